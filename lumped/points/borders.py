"""Borders at which a law changes its piece, and derivatives that do not exist there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lumped.errors import SolverError
from lumped.flattening.hold_modes import FORWARD
from lumped.points.moved_equilibrium import MovedPoint
from lumped.support.arrays import Real
from lumped.timeloop.holds import hold_words, turn_condition
from lumped.timeloop.results.operating_point import OperatingPoint

Numbers = NDArray[np.inexact[Any]]

_NEAR = 10.0
"""Tolerances of a margin within which a point is at the border."""
_SAME = 1e-9


def at_borders(point: OperatingPoint) -> list[int]:
    """Rows of the margins (see `Switching.rows`) at whose border the point is."""
    if not point.system.switching:
        return []
    margins, tolerances = (np.asarray(v).ravel() for v in point.system.margins(*point.inputs))
    return np.flatnonzero(np.abs(margins) <= _NEAR * tolerances).tolist()


def sides(point: OperatingPoint, rows: list[int], signs: Real) -> tuple[Real, Real]:
    """Modes on both sides of borders.

    Parameters
    ----------
    rows : list of int
        Rows of margins of conditions.
    signs : ndarray, shape (len(rows),)
        Positive where the first side is that on which the margin is positive; zero for none.
    """
    system, first, second = point.system, point.settings.copy(), point.settings.copy()
    for row, sign in zip(rows, signs, strict=True):
        number = system.switching.rows[row][1]
        if sign:
            side = first if sign < 0 else second
            side[:] = turn_condition(system, point.x, point.theta, point.time, side, number)
    return first, second


def is_bent(point: OperatingPoint, first: Real, second: Real) -> bool:
    """Whether the rates or their derivatives by states are others in these modes."""
    system = point.system
    both = [(point.x, point.theta, point.time, modes) for modes in (first, second)]
    rates = [np.asarray(system.rhs(*inputs)).ravel() for inputs in both]
    matrices = [system.state_matrix(inputs).toarray() for inputs in both]
    terms = np.abs(matrices).max(axis=0) @ (np.abs(point.x) + 1e-3)
    return bool((np.abs(rates[0] - rates[1]) > _SAME * terms).any()) or differ(*matrices)


def is_law(point: OperatingPoint, row: int) -> bool:
    """Whether a margin is that of a condition in a law, not of what sticks, slides or engages."""
    kind, number = point.system.switching.rows[row]
    switching = point.system.switching
    return kind == "relation" and switching.relation_modes[number] not in switching.engaged


def differ(a: Numbers, b: Numbers) -> bool:
    """Whether rows differ by more than rounding of their largest numbers."""
    size = np.abs(a) + np.abs(b)
    return bool(
        (np.abs(a - b) > _SAME * size + 1e-13 * size.max(axis=1, initial=0.0)[:, None]).any()
    )


def border_text(point: OperatingPoint, row: int) -> str:
    """Where a point is at a border, in words."""
    switching = point.system.switching
    kind, number = switching.rows[row]
    if kind == "relation":
        mode = point.settings[switching.relation_modes[number]]
        name, text = switching.relation_text(number, mode)
        return f"{name} ({text} just begins or ends)"
    name, words = switching.names[number], hold_words(switching, number)
    if kind == "slide":
        ends = "closes" if switching.has_gap[number] else "comes to rest"
        return f"{name} ({words[FORWARD]}, just {ends})"
    return f"{name} ({words[0]}, with its reaction exactly at its limit)"


def refuse_kinks(
    point: OperatingPoint,
    moved: MovedPoint,
    names: list[str],
    value: Callable[[Real], Numbers],
) -> None:
    """Refuse parameters that move a point across a border at which it is.

    Parameters
    ----------
    moved : MovedPoint
        How the point follows the parameters.
    names : list of str
        The parameters.
    value : callable
        What derivatives are made of, for given modes. What is the same on both sides of a border
        has a derivative there.

    Raises
    ------
    SolverError
        If the derivative by a parameter does not exist.
    """
    rows = at_borders(point)
    if not rows:
        return
    system, switching = point.system, point.system.switching
    x, theta, _, _ = system.inputs
    expression = system.structure.in_states(switching.margins[0][rows])
    slopes = ca.Function("slopes", system.inputs, [ca.jacobian(expression, ca.vertcat(x, theta))])
    matrix = slopes(*point.inputs).full()
    change, size = moved.through(matrix), moved.sizes().through(np.abs(matrix))
    change[np.abs(change) <= _SAME * size] = 0.0
    conditions = [k for k, row in enumerate(rows) if is_law(point, row)]
    for k in np.setdiff1d(np.arange(len(rows)), conditions).tolist():
        if change[k].any():
            raise SolverError(_refusal(point, [rows[k]], names[int(np.abs(change[k]).argmax())]))
    ways = np.sign(change[conditions])
    for signs in np.unique(ways, axis=1).T:
        first, second = sides(point, [rows[k] for k in conditions], signs)
        if differ(value(first), value(second)) or is_bent(point, first, second):
            column = int((ways == signs[:, None]).all(axis=0).argmax())
            crossed = [rows[k] for k, sign in zip(conditions, signs, strict=True) if sign]
            raise SolverError(_refusal(point, crossed, names[column]))


def _refusal(point: OperatingPoint, rows: list[int], name: str) -> str:
    where = "; ".join(dict.fromkeys(border_text(point, row) for row in rows[:4]))
    return (
        f"{point.system.name}: at t = {point.time:g} s the operating point is exactly at a border "
        f"of {where}, and {name} moves it across. So there is no derivative by {name}, only a "
        f"different one on each side. Change {name} a little, or leave it out of `by`."
    )
