"""The search for positions of conditions and holds in which equations are met."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import casadi as ca
import numpy as np

from lumped.analysis.calls import Call
from lumped.system import System

__all__ = ["agreed", "borders"]

_MOST_ALIKE = 30
"""Times that a way is halved because positions come again."""

_Point = TypeVar("_Point")


def agreed(
    begin: _Point,
    solve: Callable[[_Point], _Point],
    settle: Callable[[_Point], _Point],
    between: Callable[[_Point, _Point, float], _Point],
    modes: Callable[[_Point], np.ndarray],
    most: int,
) -> _Point | None:
    """A point that meets equations in the positions that hold there; None if none is found.

    Equations are solved in the positions of a point, positions are found where that ends, and so
    on until both agree. Where positions come again, only a part of the way is gone, half as long
    each time: for equations that are continuous over their borders this is Newton's method with
    shortened steps.

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
    """
    point, share, seen = begin, 1.0, set()
    for _ in range(most):
        seen.add(modes(point).tobytes())
        found = solve(point)
        settled = settle(found)
        if settled is found:
            return found
        if modes(settled).tobytes() in seen:
            share *= 0.5
            if share < 0.5**_MOST_ALIKE:
                return None
            settled = settle(between(point, found, share))
        point = settled
    return None


def borders(system: System, expression: ca.SX) -> tuple[list[int], Call]:
    """Conditions on which an expression depends, and a function for their differences of sides.

    Returns
    -------
    list of int
        Numbers of the conditions.
    Call
        Differences, and their derivatives by all states, one row after the other, from all states,
        parameters, time and settings.
    """
    values, s = system._values, system.switching
    touched = set(ca.jacobian_sparsity(expression, values.modes).get_triplet()[1])
    numbers = [k for k, mode in enumerate(s.relation_modes.tolist()) if mode in touched]
    gap = s.greater[numbers] - s.less[numbers] if numbers else ca.SX(0, 1)
    slopes = ca.densify(ca.jacobian(gap, values.states))
    inputs = [values.states, *system._inputs[1:]]
    return numbers, Call(ca.Function("borders", inputs, [ca.densify(gap), slopes.T]))
