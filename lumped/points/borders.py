"""Borders at which a law changes its piece."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumped.flattening.hold_modes import FORWARD
from lumped.timeloop.holds import hold_words, turn_condition
from lumped.timeloop.results.operating_point import OperatingPoint

Real = NDArray[np.float64]
Numbers = NDArray[np.inexact[Any]]

_NEAR = 10.0
"""Tolerances of a margin within which a point is at the border."""
_SAME = 1e-9


def at_borders(point: OperatingPoint) -> list[int]:
    """Rows of the margins (see `Switching.rows`) at whose border the point is."""
    if not point.system.switching:
        return []
    inputs = (point.x, point.theta, point.time, point.settings)
    margins, tolerances = (np.asarray(v).ravel() for v in point.system.margins(*inputs))
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
