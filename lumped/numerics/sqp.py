"""Sequential quadratic programming with exact gradients; checks the optimality of its result."""

from __future__ import annotations

import time as clock
from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from lumped.errors import OptimisationError, OptionError
from lumped.numerics.nlp import Solution

Objective = Callable[[np.ndarray], tuple[float, np.ndarray]]
"""Value and gradient for scaled unknowns."""

Rows = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, list[str]]]
"""Numbers that must not be negative, scaled; their gradients; names with values."""

_SMALLER = 0.1
_STILL = 1e-9
_ACTIVE = 1e-6


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

    The objective is measured by its size at the start. Where it has become ten times
    smaller, the search goes on from there with the new size, until nothing moves. Parameters of
    which all derivatives are zero at the start begin a twentieth of their range beside it.

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
        Relative change of the objective at which the search ends.

    Returns
    -------
    solution : Solution
    active : tuple of str
        Names of active constraints.

    Raises
    ------
    OptionError
        If a parameter has no effect, or the objective does not depend on any.
    OptimisationError
        If no optimum is found.
    """
    tic, n = clock.perf_counter(), len(names)
    first = _leave_flat_start(names, box, objective, rows)
    value, slope = objective(first)
    size = begun = max(abs(value), float(np.abs(slope).max())) or 1.0
    while True:
        found = _search(first, box, objective, rows, size, tolerance)
        w = np.clip(found.x, box[:, 1], box[:, 2])
        value, slope = objective(w)
        smaller = max(abs(value), float(np.abs(slope).max()))
        if found.status != 0 or not 0 < smaller < _SMALLER * size:
            break
        if np.abs(w - first).max() <= _STILL:
            break
        first, size = w, smaller
    values, slopes, labels = rows(w)
    violation = max(0.0, -float(values.min(initial=0.0)))
    if found.status != 0 or violation > 1e-6:
        worst = f"Worst violated: {labels[int(values.argmin())]}." if violation > 1e-6 else ""
        raise OptimisationError(
            f"{model}: no optimum found ({found.message} after {found.nit} "
            f"iterations). {worst} Widen bounds, or begin elsewhere.",
            found.message,
        )
    size = begun
    low, high = (np.abs(w - box[:, i]) <= _ACTIVE for i in (1, 2))
    near = np.flatnonzero(values <= _ACTIVE)
    unit = np.eye(len(w))
    active = np.vstack([slopes[near], unit[low], -unit[high]])
    residual, condition = float(np.abs(slope).max()) / size, 1.0
    if len(active):
        # least-squares multipliers, none negative
        held = scipy.optimize.lsq_linear(active.T, slope / size, (0.0, np.inf))
        residual = float(np.abs(active.T @ held.x - slope / size).max())
        condition = float(np.linalg.cond(active))
    pressing = [labels[i].partition(" = ")[0] for i in near]
    for sides, text in ((low, "lower"), (high, "upper")):
        pressing += [f"{names[i]} at its {text} bound" for i in np.flatnonzero(sides[:n])]
    solution = Solution(
        w,
        values,
        np.zeros(len(values)),
        np.zeros(len(w)),
        value,
        "SLSQP: " + found.message,
        int(found.nit),
        evaluations(),
        residual,
        violation,
        condition,
        clock.perf_counter() - tic,
    )
    return solution, tuple(dict.fromkeys(pressing))


def _search(
    first: np.ndarray,
    box: np.ndarray,
    objective: Objective,
    rows: Rows,
    size: float,
    tolerance: float,
) -> Any:
    """What SLSQP finds with the objective over a size."""
    return scipy.optimize.minimize(
        lambda w: tuple(v / size for v in objective(w)),
        first,
        jac=True,
        method="SLSQP",
        bounds=box[:, 1:],
        constraints={
            "type": "ineq",
            "fun": lambda w: rows(w)[0],
            "jac": lambda w: rows(w)[1],
        },
        options={"ftol": tolerance, "maxiter": 200},
    )


def _leave_flat_start(
    names: list[str], box: np.ndarray, objective: Objective, rows: Rows
) -> np.ndarray:
    """A start at which each parameter has a derivative that is not zero."""
    n, first = len(names), box[:, 0].copy()
    for moves in (True, False):
        slope = objective(first)[1]
        flat = np.abs(np.vstack([slope, rows(first)[1]]))[:, :n].max(axis=0) == 0
        if slope.any() and not flat.any():
            return first
        lost = ", ".join(name for name, i in zip(names, flat, strict=True) if i)
        if not moves and not slope.any():
            raise OptionError(
                f"optimise: the objective does not depend on {', '.join(names)}: all its "
                "derivatives are exactly zero at the start and beside it. Vary something else, "
                "or minimise something else."
            )
        if not moves:
            raise OptionError(
                f"optimise: {lost} has no effect on objective and constraints, at the start and "
                "beside it. Leave it out of `vary`, or begin elsewhere."
            )
        flat = flat if flat.any() else np.ones(n, dtype=bool)
        low, high = box[:n, 1], box[:n, 2]
        step = 0.05 * np.where(np.isfinite(high - low), high - low, 1.0)
        step = np.where(first[:n] + step <= high, step, -step)
        first[:n] += np.where(flat, step, 0.0)
    return first


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
