"""Refusal of derivatives at a point that is exactly where a law changes its piece."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lumped.errors import SolverError
from lumped.points.borders import at_borders, border_text, differ, is_bent, is_law, sides
from lumped.points.moved_equilibrium import MovedPoint
from lumped.timeloop.results.operating_point import OperatingPoint

Real = NDArray[np.float64]
Numbers = NDArray[np.inexact[Any]]

_ROUNDING = 1e-9


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
    inputs = (point.x, point.theta, point.time, point.settings)
    matrix = slopes(*inputs).full()
    change, size = moved.through(matrix), moved.sizes().through(np.abs(matrix))
    change[np.abs(change) <= _ROUNDING * size] = 0.0
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
