"""Pilger mill LG90 with the force on its foundation and its torque as quantities of one model.

Its design problem is that of `lumped.models.pilger_mill.balance`, here for `lumped.optimise`.
"""

from __future__ import annotations

from collections.abc import Iterator

import lumped as lp
from lumped.components import Position
from lumped.models.pilger_mill import stand
from lumped.ops import pi, sqrt

RANGES = {"m2": (0.0, 2e4), "U": (0.0, 1e4)}
"""Counterweight, kg, and mass moment of a sector, kg.m: u >= 0 with bounds far above."""


class Turned(lp.Component):
    """Two mills of one design: force from the exact one, torque by the source's formula."""

    m2: lp.Param = lp.param("kg", "counterweight", min=0)
    U: lp.Param = lp.param("kg.m", "mass moment of a sector", min=0)
    w: lp.Param = lp.param("rad/s", "speed of the crank", above=0)
    ratio: lp.Param = lp.param("1", "speed of the shaft of the torque over the crank's", above=0)
    force = lp.Output("N", "amount of the force on the foundation, F")
    torque = lp.Output("N.m", "torque M with idle friction")
    exact: stand.Mill = stand.Mill(m2=m2, U=U)
    printed: stand.AsPrinted = stand.AsPrinted(m2=m2, U=U)
    turn: Position = Position(phi=w * lp.time)
    turn_printed: Position = Position(phi=w * lp.time)

    def equations(self) -> Iterator[lp.Equation]:
        x, y = self.exact.base_x.flange.f, self.exact.base_y.flange.f
        yield self.force == sqrt(x**2 + y**2)
        yield self.torque * self.ratio == -self.turn_printed.flange.tau / (1 - stand.IDLE)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.turn.flange, self.exact.crank)
        yield lp.connect(self.turn_printed.flange, self.printed.crank)


def run_revolution(name: str = "P", points: int = 1440) -> lp.Trajectory:
    """One revolution before the optimisation of the source, at even crank angles.

    Parameters
    ----------
    name : {"P", "F"}
        Set of parameters.
    points : int
        Number of intervals.

    Returns
    -------
    Trajectory
    """
    masses = {
        f"{part}.{key}": mass
        for part in ("exact", "printed")
        for key, mass in stand.SETS[name].items()
    }
    speeds = {"w": stand.SPEED[name], "ratio": stand.RATIO[name]}
    system = lp.assemble(Turned().with_(masses | speeds | stand.DESIGNS["before"]))
    return lp.simulate(system, until=2 * pi / stand.SPEED[name], grid=points)


def find_weighted_optimum(name: str) -> lp.optimisation.Optimum:
    """Design of least ``F1 / F10 + F2 / F20`` of a set, by IPOPT.

    Parameters
    ----------
    name : {"P", "F"}
        Set of parameters.
    """
    run = run_revolution(name)
    force, torque = lp.functionals.peak("force"), lp.functionals.swing("torque")
    front = lp.optimisation.pareto(run, vary=RANGES, minimise=(force, torque), count=2)
    (F10, _), (_, F20) = front.values
    return lp.optimise(run, vary=RANGES, minimise={force: 1 / F10, torque: 1 / F20})
