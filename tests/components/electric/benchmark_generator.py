"""Turbine generator of the first IEEE benchmark (1977) on an infinite bus, and its phasors.

Inertia constants, stiffnesses and shares of the torque are those of the benchmark; without its
series capacitor. The standard parameters are the usual ones, the stator resistance is chosen.
"""

import numpy as np

import lumped as lp
from lumped.components import (
    Inertia,
    InfiniteBus,
    PerUnit,
    ShortCircuit,
    Spring,
    ThreePhaseLine,
    Torque,
    WoundFieldMachine,
    standard_parameters,
    wires,
)

BASE = PerUnit(S=892.4e6, V=26e3, f=60.0)
STANDARD = {
    "X_d": (1.79, 0.169, 0.135),
    "T_do": (4.3, 0.032),
    "X_q": (1.71, 0.228, 0.2),
    "T_qo": (0.85, 0.05),
    "X_l": 0.13,
    "R_a": 0.0025,
}
H = (0.092897, 0.155589, 0.858670, 0.884215, 0.868495, 0.0342165)  # s: HP, IP, LPA, LPB, GEN, EXC
K = (19.303, 34.929, 52.038, 70.858, 2.822)  # pu/rad
P, Q = 0.9, np.sqrt(1 - 0.9**2)
LINE = 0.02 + 0.70j


class Generator(lp.Component):
    """Generator on a line to an infinite bus; the start is steady."""

    bus: lp.Component = InfiniteBus(V=BASE.v, f=BASE.f)
    line: lp.Component = ThreePhaseLine(R=LINE.real * BASE.Z, L=LINE.imag * BASE.L)
    gen: lp.Component = WoundFieldMachine(
        **standard_parameters(BASE, **STANDARD),
        J=BASE.J(H[4]),
        v_f=1e-3 * BASE.v,
        steady=True,
        P_0=-P * BASE.S,
        Q_0=-Q * BASE.S,
        V_0=BASE.v,
    )
    fault: lp.Component = ShortCircuit(begin=0.0)

    def connections(self):
        yield from wires(self.bus, self.line, self.fault, self.gen)


class TurbineGenerator(Generator):
    """Four stages of a turbine, generator and exciter, without damping."""

    steam: lp.Param = lp.param("N.m", "torque of the turbine", P * BASE.tau)
    stages: tuple = tuple(Inertia(J=BASE.J(h)) for h in H[:4])
    exciter: lp.Component = Inertia(J=BASE.J(H[5]))
    torques: tuple = (
        Torque(tau=0.30 * steam),
        Torque(tau=0.26 * steam),
        Torque(tau=0.22 * steam),
        Torque(tau=0.22 * steam),
    )
    shafts: tuple = tuple(Spring(c=k * BASE.tau) for k in K)

    def connections(self):
        yield from super().connections()
        for torque, stage in zip(self.torques, self.stages, strict=True):
            yield lp.connect(torque.flange, stage.flange_a)
        hp, ip, lpa, lpb = self.stages
        one, two, three, four, five = self.shafts
        yield from lp.chain(hp, one, ip, two, lpa, three, lpb, four, self.gen.flange)
        yield from lp.chain(self.gen.flange, five, self.exciter)

    def initial_equations(self):
        for body in (*self.stages, self.gen, self.exciter):
            yield body.w == BASE.speed
            yield lp.der(body.w) == 0


FREE = ["bus.V", "bus.phase", "gen.v_f", "steam"]


def rotor_angle(R_a=STANDARD["R_a"], X_q=STANDARD["X_q"][0]):
    """Angle of the q axis ahead of the terminal voltage, rad."""
    return np.angle(1 + (R_a + 1j * X_q) * (P - 1j * Q))


def faulted(phases, until, grid, th0, model=TurbineGenerator, **options):
    """Run of a fault at the time zero, with the d axis then at the angle `th0` from phase a."""
    system = lp.assemble(model(fault=ShortCircuit(begin=0.0, phases=phases)))
    begin = -0.01
    start = {"gen.phi": th0 + BASE.w * begin}
    grid = np.concatenate([[begin], grid])
    options = {"rtol": 1e-9, "free": FREE, "start": start} | options
    run = lp.simulate(system, until=until, begin=begin, grid=grid, **options)
    return lambda name: run[name][np.isin(run.t, grid[1:])]
