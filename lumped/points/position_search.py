"""The search for positions of conditions and holds in which equations are met."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from functools import partial
from typing import TypeVar

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.support.array_function import ArrayFunction

_HALVINGS = 40
"""Times that a way is halved to find where positions change on it."""
_MOST_ALIKE = 3
"""Times that positions may come again while the way is followed from border to border."""

_BEYOND = 1e-3
"""How far a condition whose sides are equal is moved beyond its border."""

_Point = TypeVar("_Point")


def search_positions(
    begin: _Point,
    solve: Callable[[_Point], _Point],
    settle: Callable[[_Point], _Point],
    between: Callable[[_Point, _Point, float], _Point],
    modes: Callable[[_Point], np.ndarray],
    most: int,
    follows: bool = False,
) -> _Point | None:
    """A point that meets equations in the positions that hold there; None if none is found.

    Equations are solved in the positions of a point, positions are found where that ends, and so
    on until both agree. Where positions come again, the way is followed from one border to the
    next from then on (Katzenelson, Bell System Technical Journal 44 (1965) 1605), which leads to
    the solution of equations that are continuous over their borders and rise throughout.

    Parameters
    ----------
    begin : point
        Where the search begins, with positions to begin with.
    solve : callable
        A point that meets the equations in the positions of a point.
    settle : callable
        The point with the positions that hold there; itself if these are the same.
    between : callable
        A part of the way from one point to another.
    modes : callable
        Positions of a point.
    most : int
        Attempts.
    follows : bool
        The way is followed from the begin on.
    """
    point, seen = begin, Counter[bytes]()
    for _ in range(most):
        seen[modes(point).tobytes()] += 1
        found = solve(point)
        settled = settle(found)
        if settled is found:
            return found
        if not follows and modes(settled).tobytes() in seen:
            follows, seen = True, Counter()
        if follows:
            settled = _next(settled, settle, partial(between, point, found))
            if seen[modes(settled).tobytes()] >= _MOST_ALIKE:
                return None
        point = settled
    return None


def _next(
    end: _Point, settle: Callable[[_Point], _Point], between: Callable[[float], _Point]
) -> _Point:
    """Just beyond the first border on the way from one point to another."""
    low, high = 0.0, 1.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        trial = between(middle)
        settled = settle(trial)
        if settled is trial:
            low = middle
        else:
            high, end = middle, settled
    return end


def borders(system: System, expression: ca.SX) -> tuple[np.ndarray, ArrayFunction]:
    """Conditions and gaps on which an expression depends, and a function for their distances.

    Returns
    -------
    ndarray of bool, shape (rows, borders)
        Which rows of the expression depend on each of them.
    ArrayFunction
        Ways to go, in units of what decides: beyond the border of a condition, to where a gap is
        closed. Then derivatives of what decides by all states, one row after the other; from all
        states, parameters, time and settings.
    """
    values, s = system.structure.values, system.switching
    rows, columns = ca.jacobian_sparsity(expression, values.modes).get_triplet()
    touching = np.zeros((expression.numel(), values.modes.numel()), dtype=bool)
    touching[rows, columns] = True
    gaps = np.flatnonzero(s.has_gap)
    held = np.zeros((len(touching), len(gaps)), dtype=bool)
    for part in range(3):
        held |= touching[:, s.first_modes[gaps] + part]
    touching = np.hstack([touching[:, s.relation_modes], held])
    sides = s.greater - s.less
    deciding = ca.vertcat(sides, s.gap[gaps.tolist()] if len(gaps) else ca.SX(0, 1))
    beyond = ca.if_else(sides == 0, _BEYOND, -2 * sides)
    ways = ca.vertcat(beyond, -deciding[sides.numel() :])
    numbers = np.flatnonzero(touching.any(axis=0)).tolist()
    found = [ca.SX(0, 1), ca.SX(0, 1)]
    if numbers:
        found = [ways[numbers], ca.jacobian(deciding[numbers], values.states).T]
    inputs = [values.states, *system.inputs[1:]]
    call = ArrayFunction(ca.Function("borders", inputs, [ca.densify(part) for part in found]))
    return touching[:, numbers], call
