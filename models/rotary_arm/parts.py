"""Mandrel rotary arm of a tube mill's front table: its bodies and their numbers.

Five arms on one shaft, with sector counterweights, carry a mandrel over half a turn from the
pick-up to the release. In each arm a fixed gear, an idler and a moving gear of equal teeth let the
tray, and the mandrel on it, move on a circle without turning; so the mandrel's height above the
tray does not matter for gravity, and neither of them has energy of rotation. Angles count from the
horizontal on the side of the pick-up, upward. A motor drives the shaft through a reducer of 50.

Source: Li Enxue, Modification of Drive for Inlet Table Rotary Arm of 508 mm PQF Pipe Mill (in
Chinese), Steel Pipe 2016 no. 2, 45-49. All figures, the values of table 1 and two formulas are
missing in the copy used. Marks: [P] printed, [R] restored by derivation, [I] inferred where a
figure is missing, [A] assumed as the source does not give it.

The source computes with g = 10 m/s2 and a mandrel that spins, without the rotor and without the
loss of the reducer (`PRINTED`). As these are errors, the model leaves the spin out and includes
rotor, loss and g = 9.80665 m/s2; the torque without the rotor is that between rotor and reducer.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lumped as lp
from lumped.components import (
    AngleSensor,
    Coupling,
    EfficientGear,
    Fixed,
    IdealGear,
    Inertia,
    JournalFriction,
    Latch,
    Speed,
    Stop,
    Sum,
    SwingingMass,
    Torque,
    Weight,
)
from lumped.models.sources import Given

R_H = Given(1.008, "m", "P", "arm, centre of the shaft to centre of the tray")
R_X = Given(0.2535, "m", "P", "radius of the mandrel")
M_TRAYS = Given(5 * 65.0, "kg", "P", "five trays of 65 kg")
M_ARMS = Given(5 * 1463.0, "kg", "P", "five arms of 1463 kg")
M_WEIGHTS = Given(5 * 1064.0, "kg", "P", "five counterweights of 1064 kg")
R_WEIGHTS = Given(0.350, "m", "P", "counterweights from the centre of the shaft")
M_MANDREL = Given(31_700.0, "kg", "P", "mandrel")
M_SHAFT = Given(7269.0, "kg", "P", "shaft")
D_SHAFT = Given(0.270, "m", "P", "diameter of the shaft")
J_REDUCER = Given(0.2, "kg.m2", "P", "reducer at its output")
MU = Given(0.15, "1", "P", "friction coefficient of the journals")
K_JOURNAL = Given(1.27, "1", "P", "factor of a run-in journal")
RATIO = Given(50.0, "1", "P", "ratio of the reducer")
ETA = Given(0.85, "1", "I", "efficiency of the reducer; printed beside the choice of the motor")
J_ROTOR = Given(12.8, "kg.m2", "P", "rotor of the motor of 250 kW and 480 rpm")
EPS = Given(1.38, "rad/s2", "P", "angular acceleration of the arm")
SLOW = Given(0.17, "rad/s", "P", "slow speed of the arm")
FAST = Given(1.0, "rad/s", "P", "fast speed of the arm")

DIP = Given(
    np.radians(1.46912594852),
    "rad",
    "I",
    "pick-up and release below the shaft, fitted to the printed RMS torque of 4100 N.m",
)
PICK_UP, RELEASE = -DIP, np.pi + DIP

PRINTED = {"arm.g": 10.0, "arm.spin": 1.0, "reducer.eta": 1.0}
"""Parameters of the source's own calculation, which also leaves out the rotor."""


class Arm(lp.Component):
    """Everything behind the reducer: arms, counterweights, journals, mandrel, table and rollers.

    The mandrel lies on the table at the angle `pick_up`; there the trays take it, with a plastic
    impact. At `release` it stays behind on the rollers.
    """

    shaft = lp.Flange()
    phi = lp.Output("rad", "angle")
    g: lp.Param = lp.param("m/s2", "gravity", 9.80665)
    spin: lp.Param = lp.param("1", "1: the mandrel turns with the arm", 0.0)
    m_w: lp.Param = lp.param("kg", "counterweights", M_WEIGHTS, above=0)
    m_x: lp.Param = lp.param("kg", "mandrel", M_MANDREL, above=0)
    mu: lp.Param = lp.param("1", "friction coefficient of the journals", MU * K_JOURNAL, min=0)
    pick_up: lp.Param = lp.param("rad", "angle at which the mandrel lies", PICK_UP)
    release: lp.Param = lp.param("rad", "angle at which the rollers take it", RELEASE)

    trays: SwingingMass = SwingingMass(m=M_TRAYS, R=R_H, g=g)
    arms: SwingingMass = SwingingMass(m=M_ARMS, R=R_H / 2, J=M_ARMS * R_H**2 / 12, g=g)
    weights: SwingingMass = SwingingMass(m=m_w, R=-R_WEIGHTS, g=g)
    body: Inertia = Inertia(J=M_SHAFT * D_SHAFT**2 / 8 + J_REDUCER)
    journal: JournalFriction = JournalFriction(mu=mu, d=D_SHAFT)
    load: Sum = Sum(k_a=m_x * g, b=1.0, k_b=(M_TRAYS + M_ARMS + M_SHAFT + m_w) * g)

    angle: AngleSensor = AngleSensor()
    carried: Latch = Latch(on=pick_up, off=release)
    put_down: Latch = Latch(on=release)
    mandrel: Inertia = Inertia(J=m_x * (R_H**2 + spin * R_X**2 / 2))
    weight: Weight = Weight(f=m_x * g, R=R_H)
    trays_hold: Coupling = Coupling()
    table: Stop = Stop(phi_min=pick_up)
    rollers: Coupling = Coupling()
    ground: Fixed = Fixed()

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(
            self.shaft,
            self.trays.flange,
            self.arms.flange,
            self.weights.flange,
            self.body.flange_a,
            self.journal.flange_a,
            self.angle.flange,
            self.trays_hold.flange_a,
        )
        yield lp.connect(
            self.trays_hold.flange_b,
            self.mandrel.flange_a,
            self.weight.flange,
            self.table.flange_b,
            self.rollers.flange_b,
        )
        yield lp.connect(self.ground.flange, self.rollers.flange_a)
        yield lp.connect(self.angle.phi, self.phi, self.carried.u, self.put_down.u)
        yield lp.connect(self.carried.y, self.trays_hold.u, self.load.a)
        yield lp.connect(self.put_down.y, self.rollers.u)
        yield lp.connect(self.load.y, self.journal.f_n)


class Driven(lp.Component):
    """The arm behind rotor and reducer; the drive is a prescribed speed or torque."""

    drive: Speed | Torque = Speed(w=0.0)
    rotor: Inertia = Inertia(J=J_ROTOR)
    reducer: EfficientGear = EfficientGear(ratio=RATIO, eta=ETA)
    arm: Arm = Arm()

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.drive, self.rotor, self.reducer, self.arm.shaft)


class TrayGuide(lp.Component):
    """Gears of one arm: the arm carries an idler between a fixed gear and that of the tray."""

    teeth: lp.Param = lp.param("1", "teeth of the fixed gear over those of the tray's", above=0)
    arm: Speed = Speed(w=1.0)
    fixed: Fixed = Fixed()
    first: IdealGear = IdealGear(ratio=-1.0)
    second: IdealGear = IdealGear(ratio=-1 / teeth)
    tray: Inertia = Inertia(J=1.0)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.fixed, self.first, self.second, self.tray)
        yield lp.connect(self.arm.flange, self.first.support, self.second.support)
