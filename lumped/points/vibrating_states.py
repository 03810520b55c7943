"""Which states can vibrate."""

from __future__ import annotations

import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.support.arrays import Boolean
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.validity import refuse_point_outside


def moving(system: System, point: OperatingPoint) -> Boolean:
    """States that can vibrate: neither cyclic nor held at the operating point, shape (n,)."""
    return ~np.isin(
        system.structure.states,
        [*system.structure.cyclic, *system.switching.find_held(point.settings)],
    )


def find_stuck_holds(point: OperatingPoint) -> Boolean:
    """Which holds hold at the operating point, shape (h,)."""
    found: Boolean = point.settings[point.system.switching.first_modes] > 0.5
    return found


def finite(point: OperatingPoint) -> OperatingPoint:
    """The point itself.

    Raises
    ------
    SolverError
        If a state or parameter is no number there, or equations of a component do not hold.
    """
    p = point.system.structure.parameters
    names = [*point.system.state_names, *(p.names[i] for i in p.free)]
    values = np.append(point.x, point.theta)
    bad = np.flatnonzero(~np.isfinite(values))
    if len(bad):
        raise SolverError(
            f"{point.system.name}: the operating point is not finite: {names[bad[0]]} = "
            f"{values[bad[0]]}. Take one from start_point, equilibrium or a run."
        )
    refuse_point_outside(point, "at the operating point")
    return point
