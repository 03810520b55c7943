"""Turbine generator on a line to an infinite bus, with faults at its terminals.

A reconstructed example of IEEE Subsynchronous Resonance Task Force, First benchmark model for
computer simulation of subsynchronous resonance, IEEE Trans. Power Apparatus and Systems 96 (1977)
1565-1572. The paper itself was not read; inertia constants, stiffnesses, shares of the torque,
network and synchronous reactances are copies in public programs. Marks: [P] printed there, [A]
assumed or usual values, of which no second copy was found.

    HP == IP == LPA == LPB == generator == exciter
                                  |
                                 fault -- line -- bus

Per unit: 892.4 MVA, and amplitudes of a phase. The series capacitor of the benchmark stands in
`Compensated` only.
"""

from __future__ import annotations

from collections.abc import Iterator

import lumped as lp
from lumped.components import (
    CircuitBreaker,
    Inertia,
    InfiniteBus,
    PerUnit,
    SeriesCapacitor,
    ShortCircuit,
    Spring,
    ThreePhaseLine,
    Torque,
    WoundFieldMachine,
    standard_parameters,
    wires,
)
from lumped.models.sources import Given
from lumped.ops import pi, where

S_RATED = Given(892.4e6, "V.A", "P", "rated apparent power")
V_RATED = Given(26e3, "V", "A", "rated voltage between lines; nothing in per unit depends on it")
F_RATED = Given(60.0, "Hz", "P", "rated frequency")
BASE = PerUnit(S=S_RATED, V=V_RATED, f=F_RATED)
STANDARD = {
    "X_d": (
        Given(1.79, "1", "P", "Xd, synchronous reactance of the d axis, pu"),
        Given(0.169, "1", "A", "X'd, transient reactance of the d axis, pu"),
        Given(0.135, "1", "A", "X''d, subtransient reactance of the d axis, pu"),
    ),
    "T_do": (
        Given(4.3, "s", "A", "T'do, transient time constant of the d axis, open circuit"),
        Given(0.032, "s", "A", "T''do, subtransient time constant of the d axis, open circuit"),
    ),
    "X_q": (
        Given(1.71, "1", "P", "Xq, synchronous reactance of the q axis, pu"),
        Given(0.228, "1", "A", "X'q, transient reactance of the q axis, pu"),
        Given(0.2, "1", "A", "X''q, subtransient reactance of the q axis, pu"),
    ),
    "T_qo": (
        Given(0.85, "s", "A", "T'qo, transient time constant of the q axis, open circuit"),
        Given(0.05, "s", "A", "T''qo, subtransient time constant of the q axis, open circuit"),
    ),
    "X_l": Given(0.13, "1", "P", "leakage reactance of the stator, pu"),
    "R_a": Given(0.0025, "1", "A", "resistance of the stator, pu; the benchmark has none"),
}
H_HP = Given(0.092897, "s", "P", "inertia constant of the high-pressure turbine")
H_IP = Given(0.155589, "s", "P", "inertia constant of the intermediate-pressure turbine")
H_LPA = Given(0.858670, "s", "P", "inertia constant of the low-pressure turbine A")
H_LPB = Given(0.884215, "s", "P", "inertia constant of the low-pressure turbine B")
H_GEN = Given(0.868495, "s", "P", "inertia constant of the generator")
H_EXC = Given(0.0342165, "s", "P", "inertia constant of the exciter")
K_HP_IP = Given(19.303, "1", "P", "stiffness of the shaft HP to IP, pu/rad")
K_IP_LPA = Given(34.929, "1", "P", "stiffness of the shaft IP to LPA, pu/rad")
K_LPA_LPB = Given(52.038, "1", "P", "stiffness of the shaft LPA to LPB, pu/rad")
K_LPB_GEN = Given(70.858, "1", "P", "stiffness of the shaft LPB to generator, pu/rad")
K_GEN_EXC = Given(2.822, "1", "P", "stiffness of the shaft generator to exciter, pu/rad")
SHARE_HP = Given(0.30, "1", "P", "share of HP in the torque of the turbine")
SHARE_IP = Given(0.26, "1", "P", "share of IP in the torque of the turbine")
SHARE_LP = Given(0.22, "1", "P", "share of each of LPA and LPB in the torque of the turbine")
R_LINE = Given(0.02, "1", "P", "resistance of transformer, line and bus, pu")
X_LINE = Given(0.14 + 0.5 + 0.06, "1", "P", "reactance of transformer, line and bus, pu")
X_C = Given(0.371, "1", "A", "reactance of the series capacitor, pu")
POWER = Given(0.9, "1", "P", "power before the fault, pu")
FACTOR = Given(0.9, "1", "A", "power factor before the fault, lagging")
REACTIVE = POWER * (FACTOR**-2 - 1) ** 0.5
BEGIN = Given(0.02, "s", "A", "instant of the fault")
CLEARED = Given(0.07, "s", "A", "instant of its clearing before load rejection and reclosing")
OPENS = Given(0.15, "s", "A", "instant of the load rejection")
CLOSES = Given(0.25, "s", "A", "instant of the reclosing")


class Generator(lp.Component):
    """Generator on a line to an infinite bus, in steady state at the start of a run."""

    bus: InfiniteBus = InfiniteBus(V=BASE.v, f=BASE.f)
    line: ThreePhaseLine = ThreePhaseLine(R=R_LINE * BASE.Z, L=X_LINE * BASE.L)
    fault: ShortCircuit = ShortCircuit(begin=BEGIN)
    gen: WoundFieldMachine = WoundFieldMachine(
        **standard_parameters(BASE, **STANDARD),  # type: ignore[arg-type]
        J=BASE.J(H_GEN),
        v_f=1e-3 * BASE.v,
        steady=True,
        P_0=-POWER * BASE.S,
        Q_0=-REACTIVE * BASE.S,
        V_0=BASE.v,
    )

    def connections(self) -> Iterator[lp.Connection]:
        yield from wires(self.bus, self.line, self.fault, self.gen)


class Turbine(lp.Component):
    """Four stages of a turbine and the exciter, with all shafts to the generator between them."""

    rotor = lp.Flange()
    steam: lp.Param = lp.param("N.m", "torque of all stages", POWER * BASE.tau)
    hp: Inertia = Inertia(J=BASE.J(H_HP))
    ip: Inertia = Inertia(J=BASE.J(H_IP))
    lpa: Inertia = Inertia(J=BASE.J(H_LPA))
    lpb: Inertia = Inertia(J=BASE.J(H_LPB))
    exciter: Inertia = Inertia(J=BASE.J(H_EXC))
    hp_ip: Spring = Spring(c=K_HP_IP * BASE.tau)
    ip_lpa: Spring = Spring(c=K_IP_LPA * BASE.tau)
    lpa_lpb: Spring = Spring(c=K_LPA_LPB * BASE.tau)
    lpb_gen: Spring = Spring(c=K_LPB_GEN * BASE.tau)
    gen_exc: Spring = Spring(c=K_GEN_EXC * BASE.tau)
    hp_steam: Torque = Torque(tau=SHARE_HP * steam)
    ip_steam: Torque = Torque(tau=SHARE_IP * steam)
    lpa_steam: Torque = Torque(tau=SHARE_LP * steam)
    lpb_steam: Torque = Torque(tau=SHARE_LP * steam)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.hp, self.hp_ip, self.ip, self.ip_lpa, self.lpa, self.lpa_lpb)
        yield from lp.chain(self.lpa_lpb, self.lpb, self.lpb_gen, self.rotor)
        yield from lp.chain(self.rotor, self.gen_exc, self.exciter)
        yield lp.connect(self.hp_steam.flange, self.hp.flange_a)
        yield lp.connect(self.ip_steam.flange, self.ip.flange_a)
        yield lp.connect(self.lpa_steam.flange, self.lpa.flange_a)
        yield lp.connect(self.lpb_steam.flange, self.lpb.flange_a)


class Train(lp.Component):
    """The shaft train without a network: the generator is its rotor alone."""

    turbine: Turbine = Turbine(steam=0.0)
    gen: Inertia = Inertia(J=BASE.J(H_GEN))

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.turbine.rotor, self.gen.flange_a)


class TurbineGenerator(Generator):
    """Turbine, generator and exciter without damping, all at synchronous speed at the start."""

    turbine: Turbine = Turbine()

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.turbine.rotor, self.gen.flange)

    def initial_equations(self) -> Iterator[lp.Equation]:
        turbine = self.turbine
        bodies = (turbine.hp, turbine.ip, turbine.lpa, turbine.lpb, self.gen, turbine.exciter)
        for body in bodies:
            yield self.gen.pairs * body.w == 2 * pi * self.bus.f
            yield lp.der(body.w) == 0


class Compensated(TurbineGenerator):
    """The generator on a line with a series capacitor, before any fault."""

    X_c: lp.Param = lp.param("1", "reactance of the series capacitor, pu", X_C, above=0)
    fault: ShortCircuit = ShortCircuit(begin=1e3, i_a=0.0, i_c=0.0)
    capacitor: SeriesCapacitor = SeriesCapacitor(C=1 / (X_c * BASE.Z * BASE.w), f=BASE.f)

    def connections(self) -> Iterator[lp.Connection]:
        yield from wires(self.bus, self.line, self.capacitor, self.fault, self.gen)
        yield lp.connect(self.turbine.rotor, self.gen.flange)

    def initial_equations(self) -> Iterator[lp.Equation]:
        yield from super().initial_equations()
        yield lp.der(self.capacitor.v_d) == 0
        yield lp.der(self.capacitor.v_q) == 0


class Reclosed(TurbineGenerator):
    """The generator behind a breaker, which opens after a cleared fault and closes again."""

    opens: lp.Param = lp.param("s", "instant at which the breaker opens", OPENS)
    closes: lp.Param = lp.param("s", "instant at which it closes again", CLOSES, above=opens)
    fault: ShortCircuit = ShortCircuit(begin=BEGIN, end=CLEARED)
    breaker: CircuitBreaker = CircuitBreaker(
        closed=where(lp.time < opens, 1.0, where(lp.time < closes, 0.0, 1.0))
    )

    def connections(self) -> Iterator[lp.Connection]:
        yield from wires(self.bus, self.line, self.fault, self.breaker, self.gen)
        yield lp.connect(self.turbine.rotor, self.gen.flange)


SHAFTS = {
    "HP-IP": "turbine.hp_ip.tau",
    "IP-LPA": "turbine.ip_lpa.tau",
    "LPA-LPB": "turbine.lpa_lpb.tau",
    "LPB-GEN": "turbine.lpb_gen.tau",
    "GEN-EXC": "turbine.gen_exc.tau",
}
"""Torques in the model, by the names of the source."""
