"""Leave out states that the scene does not need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from lumped.reduction.evaluation import Values
from lumped.support.sparse_graph import find_reached

_SMALL = 1e-9  # of the largest derivative
_SITUATIONS = 512  # finds what needs six given modes but for 3 in 10 000


@dataclass(frozen=True)
class LeftOut:
    """Something the system does not compute.

    Attributes
    ----------
    what, why : str
        Name or count, and reason.
    """

    what: str
    why: str

    def __repr__(self) -> str:
        return f"{self.what}: {self.why}"


def uses(expression: ca.SX, values: Values) -> tuple[np.ndarray, np.ndarray]:
    """Which state occurs in which element of an expression: numbers of elements, of states."""
    rows, columns = ca.jacobian_sparsity(expression, values.states).get_triplet()
    by_row = np.lexsort((columns, rows))
    return np.array(rows, dtype=int)[by_row], np.array(columns, dtype=int)[by_row]


def find_used_states(expression: ca.SX, values: Values) -> np.ndarray:
    """Numbers of the states that occur in an expression; costs one pass, wherever they occur."""
    if not expression.numel():
        return np.zeros(0, dtype=int)
    return np.flatnonzero(ca.which_depends(expression, values.states, 1, False))


def samples(expression: ca.SX, values: Values) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Derivatives of an expression by the states at random points.

    Returns
    -------
    rows, columns : ndarray of int, shape (nonzeros,)
        Element of the expression and state of each derivative.
    largest : ndarray, shape (nonzeros,)
        Largest magnitude over three random states, parameters, times and settings. A derivative
        that is rounding at all of them vanishes identically (Schwartz-Zippel). Behind several
        conditions, such as limiters in a row, it may vanish at all but one combination of their
        modes; so small ones are asked at many more combinations.
    """
    parameters = values.flat.parameters
    defaults = parameters.defaults
    settings = ca.vertcat(values.modes, values.guesses)
    inputs = [values.states, parameters.theta, values.time, settings]
    jacobian = ca.jacobian(expression, values.states)
    rows, columns = (np.array(i, dtype=int) for i in jacobian.sparsity().get_triplet())
    rng = np.random.default_rng(6)

    def sizes(function: ca.Function, point: list[Any]) -> np.ndarray:
        modes = rng.integers(0, 2, values.modes.numel())
        guesses = rng.uniform(-2, 2, values.guesses.numel())
        found = function(*point, np.concatenate([modes, guesses]))
        size: np.ndarray = np.abs(np.asarray(found).ravel())
        return size

    entries = ca.SX(jacobian.nz[:])
    function = ca.Function("J", inputs, [entries])
    largest = np.zeros(len(rows))
    for _ in range(3):
        point: list[Any] = [
            rng.uniform(-2, 2, values.states.numel()),
            defaults * rng.uniform(0.8, 1.2, len(defaults))
            + 0.01 * rng.uniform(size=len(defaults)),
            rng.uniform(0, 2),
        ]
        size = sizes(function, point)
        largest = np.maximum(largest, np.where(np.isfinite(size), size, np.inf))
    scale = largest.max(initial=1.0, where=np.isfinite(largest))
    small = np.flatnonzero(largest <= _SMALL * scale)
    depends = ca.which_depends(entries[small.tolist()], values.modes, 1, True)
    doubtful = small[np.array(depends, dtype=bool)]
    if len(doubtful):
        function = ca.Function("J", inputs, [entries[doubtful.tolist()]])
        for _ in range(_SITUATIONS):
            size = sizes(function, point)
            size[~np.isfinite(size)] = 0.0
            largest[doubtful] = np.maximum(largest[doubtful], size)
    return rows, columns, largest


def independent_of(expression: ca.SX, columns: Sequence[int], values: Values) -> np.ndarray:
    """Whether an expression does not change with states although they occur in it.

    Returns
    -------
    ndarray of bool, shape (len(columns),)
    """
    rows, entries, largest = samples(expression, values)
    # a row that is rounding as a whole is measured against the others
    scale = np.full(expression.numel(), 1e-3 * largest.min(initial=1.0, where=largest > 1e-9))
    finite = np.isfinite(largest)
    np.maximum.at(scale, rows[finite], largest[finite])
    alive = set(entries[~finite | (largest > 1e-13 * scale[rows])].tolist())
    return np.array([column not in alive for column in columns], dtype=bool)


def find_needed_states(
    values: Values, positions: set[int], outputs: ca.SX | None, kept: ca.SX
) -> list[int]:
    """Numbers of the states to integrate.

    Parameters
    ----------
    values : Values
        All expressions.
    positions : set of int
        Numbers of states that are positions of ports: left out where nothing depends on them.
    outputs : SX or None
        With outputs, only what they need is kept.
    kept : SX
        Quantities to be available in any case.
    """
    states = values.reduced.states
    rates = values.of([n + 1 for n in states])
    asked = set(find_used_states(kept, values).tolist())
    if outputs is not None:
        asked |= set(find_used_states(outputs, values).tolist())
        needed = find_reached(*uses(rates, values), np.array(sorted(asked), int), len(states))
        return [int(i) for i in needed]
    moving = np.zeros(len(states), dtype=bool)
    moving[find_used_states(rates, values)] = True
    doubtful = [i for i in sorted(positions - asked) if moving[i]]
    if doubtful:
        moving[doubtful] = ~independent_of(rates, doubtful, values)
    return [i for i in range(len(states)) if moving[i] or i in asked or i not in positions]
