"""Modes of designs: found again for other parameters as they were found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from lumped.compiler.system import Changes
from lumped.points.equilibrium import equilibrium
from lumped.points.moved_equilibrium import find_moved_point
from lumped.points.start import start_point
from lumped.timeloop.results.operating_point import Kept, OperatingPoint
from lumped.vibration.natural.modes import Modes


def equilibrium_again(point: OperatingPoint, parameters: Changes) -> OperatingPoint:
    """The equilibrium of other parameters, found as that of a point was."""
    system, kept = point.system, point.kept or Kept()
    p = system.structure.parameters
    return equilibrium(
        system,
        parameters=parameters,
        start=kept.start,
        free=[p.names[p.free[place]] for place in kept.free],
        rest=kept.rest,
        time=point.time,
    )


class ModeDesigns:
    """Modes of one system for other parameters.

    Parameters
    ----------
    begin : Modes
        Those with which the designs are compared.

    Attributes
    ----------
    is_held : bool
        The states of the point are the same for all designs.
    """

    def __init__(self, begin: Modes) -> None:
        self.begin, self.system, point = begin, begin.system, begin.point
        self._settled = find_moved_point(point, []) is not None
        x = start_point(self.system, parameters=point.parameters).x
        self._plain = np.array_equal(x, point.x)
        self.is_held = point.kept is None and not self._plain and not self._settled

    def point(self, values: dict[str, float]) -> OperatingPoint:
        """The operating point of a design: found as that of the modes was, else held."""
        begin = self.begin.point
        if begin.kept is not None:
            return equilibrium_again(begin, values)
        if self._plain:
            return start_point(self.system, parameters=values)
        if self._settled:
            states = dict(zip(self.system.state_names, begin.x.tolist(), strict=True))
            return equilibrium(self.system, parameters=values, start=states, time=begin.time)
        return replace(begin, theta=self.system.theta(values))
