"""An operating point in a system that stops at the kinks of formulas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lumped.compiler.system import System
from lumped.timeloop.clocks import modes_at
from lumped.timeloop.holds import Holds
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.settings import just_after


def watch_formulas(point: OperatingPoint, system: System) -> OperatingPoint:
    """The point in the same system with formulas at whose kinks runs stop, as its last modes."""
    first = point.system.structure.mode_count
    settings = modes_at(system, point.theta, just_after(point.time))
    settings = np.concatenate([point.settings[:first], settings[first:], point.settings[first:]])
    count, s, holds = system.structure.mode_count, system.switching, Holds(system, point.theta)
    for _ in range(count - first):  # one condition may need another
        look = holds.look(point.time, point.x, settings[:count], settings[count:])
        modes = settings[:count].copy()
        s.begin(modes, look.greater, look.less)
        if (modes[first:] == settings[first:count]).all():
            break
        settings[first:count] = modes[first:]
    before = point.before and watch_formulas(point.before, system)
    return replace(point, system=system, settings=settings, before=before)
