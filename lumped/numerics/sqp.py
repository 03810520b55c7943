"""Sequential quadratic programming with exact gradients; checks the optimality of its result."""

from __future__ import annotations

import time as clock
from collections.abc import Callable

import numpy as np
import scipy

from lumped.errors import LumpedError, OptimisationError, OptionError
from lumped.numerics.nlp import Solution
from lumped.numerics.optimality import Objective, Rows, judge

_FAR = 1e8
"""Distance from the start, in the scale of an unknown, beyond which nothing bounds a search."""
_AWAY = 100.0
"""The same, beyond which a failing analysis is no surprise."""
_RESTARTS = 20
_ASIDE = (0.0618, 0.31, 0.73)
"""Shares of the way to a bound at which an unknown without slope at the start is tried too."""
_ESCAPE = 1e-2
"""How far a search goes along a direction in which the objective curves downward."""
_STRIDE = 0.1
"""Longest first step of a search begun again."""
_GAIN = 1e-3
"""Share of the decrease foreseen below which a search begun again makes no progress."""
_VIOLATED = 1e-6
_FINE = 1e-8
"""Share of the decrease foreseen at which a search begun again ends."""


def sqp(
    model: str,
    names: list[str],
    box: np.ndarray,
    objective: Objective,
    rows: Rows,
    evaluations: Callable[[], int],
    tolerance: float = 1e-12,
) -> tuple[Solution, tuple[str, ...]]:
    """Least objective by SLSQP (Kraft, DFVLR-FB 88-28, 1988).

    It is begun again from its end, in the scale of slope and curvature there, until the end itself
    meets the conditions of optimality (see `judge`) or nothing better is found; then the status
    tells what is left.

    Parameters
    ----------
    model : str
        Its name, for errors.
    names : list of str
        The first unknowns: parameters.
    box : ndarray, shape (k, 3)
        Start, lower and upper bound of each scaled unknown.
    evaluations : callable
        Gives how often the model was analysed so far.
    tolerance : float
        Relative accuracy of the objective.

    Returns
    -------
    solution : Solution
    active : tuple of str
        Names of active constraints.

    Raises
    ------
    OptionError
        If a parameter has no effect, or the objective does not depend on any, at the start and at
        designs beside it.
    OptimisationError
        If no optimum is found, or nothing bounds the search.
    """
    tic = clock.perf_counter()

    def bounded(w: np.ndarray) -> tuple[float, np.ndarray]:
        _refuse_unbounded(model, names, box, w, _FAR)
        try:
            return objective(w)
        except LumpedError as fault:
            _refuse_unbounded(model, names, box, w, _AWAY, fault)
            raise

    w = _find_begin(names, box, bounded, rows)
    value, slope = bounded(w)
    size = max(abs(value), float(np.abs(slope).max())) or 1.0
    found = _search(w, np.eye(len(w)), size, box, bounded, rows, tolerance)
    w, iterations = np.clip(found.x, box[:, 1], box[:, 2]), int(found.nit)
    values, _, labels = rows(w)
    if values.min(initial=0.0) < -_VIOLATED:
        raise OptimisationError(
            f"{model}: no optimum found ({found.message} after {found.nit} iterations). Worst "
            f"violated: {labels[int(values.argmin())]}. Widen bounds, or begin elsewhere.",
            found.message,
        )
    state = judge(w, box, bounded, rows, tolerance)
    for _ in range(_RESTARTS):
        if state.is_settled:
            break
        begin, basis, size = state.begin_again(_ESCAPE, _STRIDE)
        found = _search(begin, basis, size, box, bounded, rows, _FINE)
        iterations += int(found.nit)
        after = np.clip(found.x, box[:, 1], box[:, 2])
        kept = rows(after)[0].min(initial=0.0) >= -_VIOLATED
        if not (kept and state.value - bounded(after)[0] > _GAIN * size):
            break
        state = judge(after, box, bounded, rows, tolerance)
    w = state.w
    values, _, labels = rows(w)
    pressing = [labels[i].partition(" = ")[0] for i in state.near]
    for sides, text in ((state.low, "lower"), (state.high, "upper")):
        pressing += [f"{names[i]} at its {text} bound" for i in np.flatnonzero(sides[: len(names)])]
    solution = Solution(
        w,
        values,
        np.zeros(len(values)),
        np.zeros(len(w)),
        state.value,
        "SLSQP: Optimization terminated successfully" if state.met else state.tell_rest(names),
        iterations,
        evaluations(),
        state.residual,
        max(0.0, -float(values.min(initial=0.0))),
        state.condition,
        clock.perf_counter() - tic,
    )
    return solution, tuple(dict.fromkeys(pressing))


def _search(
    first: np.ndarray,
    basis: np.ndarray,
    size: float,
    box: np.ndarray,
    objective: Objective,
    rows: Rows,
    tolerance: float,
) -> scipy.optimize.OptimizeResult:
    """The end of one search, whose unknowns are those of a basis from its start on."""
    low, high = (np.isfinite(box[:, i]) for i in (1, 2))
    sides = np.vstack([basis[low], -basis[high]])

    def at(z: np.ndarray) -> np.ndarray:
        w: np.ndarray = np.clip(first + basis @ z, box[:, 1], box[:, 2])
        return w

    def goal(z: np.ndarray) -> tuple[float, np.ndarray]:
        value, slope = objective(at(z))
        return value / size, slope @ basis / size

    def room(z: np.ndarray) -> np.ndarray:
        w = first + basis @ z
        return np.concatenate([rows(at(z))[0], (w - box[:, 1])[low], (box[:, 2] - w)[high]])

    found = scipy.optimize.minimize(
        goal,
        np.zeros(len(first)),
        jac=True,
        method="SLSQP",
        constraints={
            "type": "ineq",
            "fun": room,
            "jac": lambda z: np.vstack([rows(at(z))[1] @ basis, sides]),
        },
        options={"ftol": tolerance, "maxiter": 200},
    )
    found.x = at(found.x)
    return found


def _refuse_unbounded(
    model: str,
    names: list[str],
    box: np.ndarray,
    w: np.ndarray,
    size: float,
    fault: LumpedError | None = None,
) -> None:
    """Refuse a search that runs away where there is no bound."""
    far = ~(np.abs(w - box[:, 0]) < size * np.maximum(1.0, np.abs(box[:, 0])))
    far &= np.where(w < box[:, 0], ~np.isfinite(box[:, 1]), ~np.isfinite(box[:, 2]))
    lost = [name for name, i in zip(names, far.tolist(), strict=False) if i]
    if lost:
        why = f", where the model fails ({fault})" if fault else ""
        raise OptimisationError(
            f"{model}: no optimum found: the objective still fell with {', '.join(lost)} more than "
            f"{size:g} times its size away from the start{why}. Without a bound it may have no "
            "least value; give bounds in `vary`.",
            "no bound",
        ) from fault


def _find_begin(names: list[str], box: np.ndarray, objective: Objective, rows: Rows) -> np.ndarray:
    """Where a search begins: at the start, or beside it in what has no slope there.

    Raises
    ------
    OptionError
        If there is no slope beside it, either.
    """
    n, first = len(names), box[:, 0]

    def slopes(w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slope = objective(w)[1]
        return slope, np.abs(np.vstack([slope, rows(w)[1]]))[:, :n].max(axis=0) == 0

    slope, idle = slopes(first)
    if slope.any() and not idle.any():
        return first
    moves = idle if idle.any() else np.ones(n, dtype=bool)
    for share in _ASIDE:
        w = first.copy()
        for i in np.flatnonzero(moves):
            ways = np.clip(box[i, 1:] - first[i], -1.0, 1.0)
            w[i] += share * ways[int(np.argmax(np.abs(ways)))]
        slope, still = slopes(w)
        if slope.any() and not still.any():
            return w
    if not slope.any():
        raise OptionError(
            f"optimise: the objective does not depend on {', '.join(names)}: all its derivatives "
            "are exactly zero at the start and beside it, at "
            f"{len(_ASIDE)} designs. Vary something else, minimise something else, or begin "
            "elsewhere."
        )
    lost = [name for name, i in zip(names, still.tolist(), strict=True) if i]
    raise OptionError(
        f"optimise: {', '.join(lost)} has no effect on objective and constraints, at the start and "
        f"beside it, at {len(_ASIDE)} designs. Leave it out of `vary`, or begin elsewhere."
    )


def list_bound_rows(
    key: str, value: float, slope: np.ndarray, low: float, high: float
) -> list[tuple[float, np.ndarray, str]]:
    """Rows of a bounded number: distance from each bound, its gradient and name."""
    found = []
    for bound, sign in ((low, 1.0), (high, -1.0)):
        if np.isfinite(bound):
            size = abs(bound) or 1.0
            text = f"{key} = {value:.6g}, at {'least' if sign > 0 else 'most'} {bound:g}"
            found.append((sign * (value - bound) / size, sign * slope / size, text))
    return found
