"""Crankshaft of a six-cylinder diesel engine, and the same with a damper and a generator.

A reconstructed example of Mendes, Meirelles, Zampieri, Analysis of torsional vibration in internal
combustion engines: modelling and experimental validation, Proc. IMechE Part K 222 (2008) 155-178.
The paper itself was not read; the numbers and the digitised pressures are those of an example of
Aalto-Arotor/openTorsion (MIT licence). Marks: [P] printed there, [A] assumed because it is not
given.

    pulley == gear train == cylinders 1 .. 6 == flywheel [ == coupling == generator ]
    [damper]

The series of the mass force is that of the source. Damper, coupling and generator are [A].
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lumped as lp
from lumped.components import (
    ElasticCoupling,
    Engine,
    Inertia,
    LossSpring,
    Torque,
    ViscousDamper,
)
from lumped.models.diesel_genset.pressure import CURVE, PEAK
from lumped.models.sources import Given

RPM = np.pi / 30
FIRING_ORDER = (1, 5, 3, 6, 2, 4)
J_PULLEY = Given(0.0170, "kg.m2", "P", "pulley")
J_GEARS = Given(0.0090, "kg.m2", "P", "gear train")
J_WEB = Given(0.0467, "kg.m2", "P", "throws of the cylinders 1, 3 and 4")
J_BARE = Given(0.0327, "kg.m2", "P", "throws of the cylinders 2 and 5")
J_LAST = Given(0.0487, "kg.m2", "P", "throw of the cylinder 6")
J_FLYWHEEL = Given(2.0750, "kg.m2", "P", "flywheel")
C_1 = Given(1.106e6, "N.m/rad", "P", "shaft 1, pulley to gear train")
C_2 = Given(1.631e6, "N.m/rad", "P", "shaft 2, gear train to cylinder 1")
C_THROWS = Given(1.253e6, "N.m/rad", "P", "shafts 3, 4, 6 and 7, between cylinders")
C_MIDDLE = Given(1.678e6, "N.m/rad", "P", "shaft 5, cylinder 3 to cylinder 4")
C_8 = Given(1.976e6, "N.m/rad", "P", "shaft 8, cylinder 6 to flywheel")
ETA = Given(0.035, "1", "P", "loss factor of every shaft")
D = Given(2.0, "N.m.s/rad", "P", "damping of every throw against the housing")
BORE = Given(0.105, "m", "P", "bore of the cylinders")
R = Given(0.0685, "m", "P", "crank radius")
L = Given(0.207, "m", "P", "length of the rods")
M = Given(2.521, "kg", "P", "mass that moves with each piston")
P_CURVE = Given(15.2e6, "Pa", "P", "largest pressure to which the curve refers")
W_LOSS = Given(1300.0, "rad/s", "A", "angular frequency of the shafts' loss in runs, near mode 1")
J_RING = Given(0.05, "kg.m2", "A", "ring of the damper at the pulley")
D_RING = Given(54.0, "N.m.s/rad", "A", "its fluid, near the optimum of Den Hartog for mode 1")
C_COUPLING = Given(4e3, "N.m/rad", "A", "elastic coupling behind the flywheel")
PSI = Given(1.1, "1", "A", "relative damping of the coupling")
W_COUPLING = Given(57.0, "rad/s", "A", "angular frequency of its loss in runs, its natural one")
J_GENERATOR = Given(2.2, "kg.m2", "A", "rotor of the generator")

_PRESSURE = tuple((float(np.radians(angle)), 1e6 * pressure) for angle, pressure in CURVE)
_SHARE = R / L
_SERIES = ((1, 1.0), (2, _SHARE), (4, -(_SHARE**3) / 4), (6, 9 / 128 * _SHARE**5))


def _shaft(c: float) -> LossSpring:
    return LossSpring(c=c, eta=ETA, w_loss=W_LOSS)


ENGINE = Engine(
    cylinders=6,
    firing_order=FIRING_ORDER,
    J=(J_WEB, J_BARE, J_WEB, J_WEB, J_BARE, J_LAST),
    shaft=tuple(_shaft(c) for c in (C_THROWS, C_THROWS, C_MIDDLE, C_THROWS, C_THROWS)),
    d=D,
    pressure=_PRESSURE,
    masses="series",
    series=_SERIES,
    bore=BORE,
    r=R,
    L=L,
    m=M,
)
SHAFTS = (
    "shaft_1.tau_c",
    "shaft_2.tau_c",
    *(f"engine.shaft[{i}].tau_c" for i in range(5)),
    "shaft_8.tau_c",
)
"""Torques of the stiffnesses of the shafts 1 to 8 of the source."""


def load(w: float) -> float:
    """Factor of the pressure at a mean speed: the largest pressure over that of the curve.

    Parameters
    ----------
    w : float
        Speed, rad/s; below the first and above the last of the table its end counts.
    """
    speeds, pressures = zip(*PEAK, strict=True)
    return float(np.interp(w / RPM, speeds, pressures) * 1e6 / P_CURVE)


class Crankshaft(lp.Component):
    """The engine of the source, from the pulley to the flywheel."""

    pulley: Inertia = Inertia(J=J_PULLEY)
    shaft_1: LossSpring = _shaft(C_1)
    gears: Inertia = Inertia(J=J_GEARS)
    shaft_2: LossSpring = _shaft(C_2)
    engine: Engine = ENGINE
    shaft_8: LossSpring = _shaft(C_8)
    flywheel: Inertia = Inertia(J=J_FLYWHEEL)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.pulley, self.shaft_1, self.gears, self.shaft_2, self.engine.front)
        yield from lp.chain(self.engine.rear, self.shaft_8, self.flywheel)


class Genset(Crankshaft):
    """The engine with a viscous damper, which drives a generator through an elastic coupling."""

    damper: ViscousDamper = ViscousDamper(J_ring=J_RING, d=D_RING)
    coupling: ElasticCoupling = ElasticCoupling(
        stiffness=((0.0, C_COUPLING),), psi=PSI, w_loss=W_COUPLING, extrapolate=True
    )
    generator: Inertia = Inertia(J=J_GENERATOR)
    electric: Torque = Torque(tau=0.0)

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.damper.flange, self.pulley.flange_a)
        yield from lp.chain(self.flywheel, self.coupling, self.generator)
        yield lp.connect(self.electric.flange, self.generator.flange_b)
