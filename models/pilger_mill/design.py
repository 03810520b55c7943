"""Pilger mill LG90 with the force on its foundation and its torque as quantities of one model.

Its design problem is that of `lumped.models.pilger_mill.balance`, here for `lumped.optimise`.
"""

from __future__ import annotations

from collections.abc import Iterator

import lumped as lp
from lumped.components import Position
from lumped.models.pilger_mill import stand
from lumped.ops import pi, sqrt


class Turned(lp.Component):
    """Two mills of one design: force from the exact one, torque by the source's formula."""

    m2: lp.Param = lp.param("kg", "counterweight", min=0)
    U: lp.Param = lp.param("kg.m", "mass moment of a sector", min=0)
    force = lp.Output("N", "amount of the force on the foundation")
    torque = lp.Output("N.m", "torque at the crank shaft, with idle friction")
    exact: stand.Mill = stand.Mill(m2=m2, U=U).with_(stand.SETS["P"])
    printed: stand.AsPrinted = stand.AsPrinted(m2=m2, U=U).with_(stand.SETS["P"])
    turn: Position = Position(phi=stand.SPEED["P"] * lp.time)
    turn_printed: Position = Position(phi=stand.SPEED["P"] * lp.time)

    def equations(self) -> Iterator[lp.Equation]:
        x, y = self.exact.base_x.flange.f, self.exact.base_y.flange.f
        yield self.force == sqrt(x**2 + y**2)
        yield self.torque == -self.turn_printed.flange.tau / (1 - stand.IDLE)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.turn.flange, self.exact.crank)
        yield lp.connect(self.turn_printed.flange, self.printed.crank)


def run_revolution(points: int = 1440) -> lp.Trajectory:
    """One revolution of set P before the optimisation of the source, at even crank angles.

    Parameters
    ----------
    points : int
        Number of intervals.

    Returns
    -------
    Trajectory
    """
    system = lp.assemble(Turned().with_(stand.DESIGNS["before"]))
    return lp.simulate(system, until=2 * pi / stand.SPEED["P"], grid=points)
