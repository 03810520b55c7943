"""Drive of a ship: two steam turbines, two gear stages each, one propeller.

A reconstructed example of Gunter and Chen, Introduction to Dynamics of Rotor-Bearing Systems
(2001), example 8.1. The book itself was not read; the numbers are those of
`marine_turbine_forced_response.py` of Aalto-Arotor/openTorsion (MIT licence), with its units: lbf
in s2, lbf in/rad, lbf in s/rad. Marks: [P] printed there, [R] restored from it, [A] assumed because
it is not given.

    propeller == shaft == bull gear -- pinion == LP intermediate == wheel -- pinion == LP turbine
                                    -- pinion == HP intermediate == wheel -- pinion == HP turbine

Shafts have no mass, pinions no inertia, meshes are rigid. All values are those on their own shafts.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lumped as lp
from lumped.components import Damper, Fixed, IdealGear, Inertia, Spring, Torque
from lumped.models.sources import Given
from lumped.ops import cos

LBF_IN = 0.11298
"""N.m for each lbf in."""
RPM = np.pi / 30
J_PROPELLER = Given(2.454e6 * LBF_IN, "kg.m2", "P", "propeller, 2.454e6 lbf in s2")
J_BULL = Given(0.826e6 * LBF_IN, "kg.m2", "P", "bull gear, 0.826e6 lbf in s2")
J_LP_WHEEL = Given(1.283e4 * LBF_IN, "kg.m2", "P", "LP wheel, 1.283e4 lbf in s2")
J_HP_WHEEL = Given(2.723e4 * LBF_IN, "kg.m2", "P", "HP wheel, 2.723e4 lbf in s2")
J_LP = Given(1.509e4 * LBF_IN, "kg.m2", "P", "LP turbine, 1.509e4 lbf in s2")
J_HP = Given(2.612e2 * LBF_IN, "kg.m2", "P", "HP turbine, 261.2 lbf in s2")
C_SHAFT = Given(826e6 * LBF_IN, "N.m/rad", "P", "propeller shaft, 826e6 lbf in/rad")
C_LP_FIRST = Given(203.94e6 * LBF_IN, "N.m/rad", "P", "LP intermediate shaft, 203.94e6 lbf in/rad")
C_HP_FIRST = Given(24.17e6 * LBF_IN, "N.m/rad", "P", "HP intermediate shaft, 24.17e6 lbf in/rad")
C_LP = Given(30.51e6 * LBF_IN, "N.m/rad", "P", "LP turbine shaft, 30.51e6 lbf in/rad")
C_HP = Given(14.26e6 * LBF_IN, "N.m/rad", "P", "HP turbine shaft, 14.26e6 lbf in/rad")
D_PROPELLER = Given(
    3.86e6 * LBF_IN, "N.m.s/rad", "P", "water at the propeller, 3.86e6 lbf in s/rad"
)
D_LP = Given(108.77 * LBF_IN, "N.m.s/rad", "P", "steam in the LP turbine, 108.77 lbf in s/rad")
D_HP = Given(42.738 * LBF_IN, "N.m.s/rad", "P", "steam in the HP turbine, 42.738 lbf in s/rad")
FIRST = Given(9.4094, "1", "P", "intermediate shafts, turns for each of the propeller")
LP_TURNS = Given(40.0424, "1", "P", "LP turbine, turns for each of the propeller")
HP_TURNS = Given(78.2365, "1", "P", "HP turbine, turns for each of the propeller")
ZETA = Given(0.00398, "1", "P", "damping ratio of every elastic mode, beside the dampers")
RATED_SPEED = Given(85 * RPM, "rad/s", "P", "rated speed of the propeller, 85 1/min")
RATED_TORQUE = Given(22.24e6 * LBF_IN, "N.m", "P", "rated torque of the propeller, 22.24e6 lbf in")
SHARE = Given(0.1, "1", "P", "alternating over mean torque of the propeller")
BLADES = Given(5.0, "1", "P", "blades of the propeller, order of its torque")
J_WHOLE = (
    (J_PROPELLER + J_BULL + (J_LP_WHEEL + J_HP_WHEEL) * FIRST**2)
    + J_LP * LP_TURNS**2
    + J_HP * HP_TURNS**2
)
D_WHOLE = D_PROPELLER + D_LP * LP_TURNS**2 + D_HP * HP_TURNS**2
"""Inertia and damping of the whole drive at the propeller, kg.m2 and N.m.s/rad."""


class Blades(lp.Component):
    """Alternating torque of the water on a propeller, which drives it with a cosine of its angle.

    ``tau = tau_max (w / w_rated)^2 cos(blades phi)``
    """

    symbol = "torque"
    flange = lp.Flange()
    blades: int = int(BLADES)
    tau_max: lp.Param = lp.param("N.m", "amplitude at rated speed", SHARE * RATED_TORQUE, min=0)
    w_rated: lp.Param = lp.param("rad/s", "rated speed", RATED_SPEED, above=0)
    tau: lp.Var = lp.var("N.m", "driving torque")
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self) -> Iterator[lp.Equation]:
        phi = self.flange.phi
        yield self.w == lp.der(phi)
        yield self.tau == self.tau_max * (self.w / self.w_rated) ** 2 * cos(self.blades * phi)
        yield self.flange.tau == -self.tau


class Turbine(lp.Component):
    """Turbine behind two gear stages, from the pinion at the bull gear to the rotor.

    A damper against the casing represents the steam.
    """

    gear = lp.Flange()
    first: lp.Param = lp.param("1", "intermediate shaft, turns for each of the bull gear", FIRST)
    turns: lp.Param = lp.param("1", "rotor, turns for each of the bull gear", LP_TURNS)
    pinion: IdealGear = IdealGear(ratio=1 / first)
    intermediate: Spring = Spring(c=C_LP_FIRST)
    wheel: Inertia = Inertia(J=J_LP_WHEEL)
    second: IdealGear = IdealGear(ratio=first / turns)
    shaft: Spring = Spring(c=C_LP)
    rotor: Inertia = Inertia(J=J_LP)
    steam: Damper = Damper(d=D_LP)
    casing: Fixed = Fixed()

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.gear, self.pinion.flange_a)
        yield from lp.chain(self.pinion, self.intermediate, self.wheel, self.second, self.shaft)
        yield from lp.chain(self.shaft, self.rotor, self.steam, self.casing)


LOW_PRESSURE = Turbine()
HIGH_PRESSURE = Turbine(
    turns=HP_TURNS,
    intermediate=Spring(c=C_HP_FIRST),
    wheel=Inertia(J=J_HP_WHEEL),
    shaft=Spring(c=C_HP),
    rotor=Inertia(J=J_HP),
    steam=Damper(d=D_HP),
)


class MarineTurbine(lp.Component):
    """Propeller, its shaft, bull gear, and the two turbines that drive it.

    `blades` is the alternating torque of the water on the propeller, `load` its damping, `steam`
    the mean torque of both turbines, referred to the propeller.
    """

    blades: lp.Component = Blades()
    propeller: Inertia = Inertia(J=J_PROPELLER)
    load: Damper = Damper(d=D_PROPELLER)
    steam: Torque = Torque(tau=0.0)
    water: Fixed = Fixed()
    shaft: Spring = Spring(c=C_SHAFT)
    bull: Inertia = Inertia(J=J_BULL)
    low: Turbine = LOW_PRESSURE
    high: Turbine = HIGH_PRESSURE

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.blades, self.propeller, self.shaft, self.bull)
        yield from lp.chain(self.propeller, self.load, self.water)
        yield lp.connect(self.steam.flange, self.bull.flange_b)
        yield lp.connect(self.bull.flange_b, self.low.gear)
        yield lp.connect(self.bull.flange_b, self.high.gear)
