"""Floating-shaft crank shear of 14 MN with a pair of elliptical gears: the machine.

Source: V. F. Egorov, M. I. Stupakov, M. L. Bosnyak, Loads of eccentric shears with transmissions of
variable ratio (Nagruzki ekstsentrikovykh nozhnits pri ispolzovanii peredatochnykh mekhanizmov s
peremennym peredatochnym chislom), Omsk Scientific Bulletin 2010 no. 2 (90), CC BY; equations (1) to
(23) and figure 3, whose curves are lost in the copy used. Marks: [P] printed, [R] restored by
derivation and in agreement with the print, [I] inferred, [A] assumed because the source does not
give it.

The crank shaft turns in the lower support (journal A) and carries the upper support on its pin; it
floats, because neither support is fixed to the frame. While the lower support is seated, A is at
rest and the upper support comes down as a connecting rod. At 92 deg 20' it meets the strip: from
then on the pin is at rest and the shaft lifts the lower support, which cuts. At the change of
carriage all speeds jump with momentum kept. This follows from the equations, so that a wrong rule
(``J w`` kept, or no jump) is not possible. The return at 267 deg 40' is the mirror image of this
change [I]. The ellipses turn the crank slowest during the cut. Angles count from the upper position
of the pin.

There are models for two readings of the source. `PrintedShear` is that of (1) to (7): each support
is a rod whose guide goes through the other joint of the shaft, and lies at rest while the other one
moves. In this reading the geometry jumps at the change: the lower support tilts by 3.3 deg at once.
`GuidedShear` keeps both supports in the guides of the frame, the lower one upright: only speeds
jump [R].
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lumped as lp
from lumped.components import (
    CamSwitch,
    Eccentric,
    EllipticalGear,
    GuidedRod,
    IdealGear,
    Inertia,
    PickUp,
    PulseTorque,
    SignTorque,
    Torque,
    translation,
)
from lumped.components.gearing.noncircular import slowest_at
from lumped.components.translation import Mass
from lumped.models.sources import Given

DEGREE = np.pi / 180
MINUTE = DEGREE / 60
ECCENTRICITY = Given(0.25, "m", "P", "crank radius, e")
MEETS = Given(92 * DEGREE + 20 * MINUTE, "rad", "P", "upper support meets the strip: 92 deg 20 min")
GAP = Given(
    3 * DEGREE + 25 * MINUTE, "rad", "P", "from there to the start of the cut: 3 deg 25 min"
)
CUT = Given(58 * DEGREE + 25 * MINUTE, "rad", "P", "cut: 58 deg 25 min")
OVERLAP = Given(9 * DEGREE + 35 * MINUTE, "rad", "P", "overlap after the cut: 9 deg 35 min")
CUT_BEGINS = MEETS + GAP
PULSE = Given(CUT + OVERLAP, "rad", "R", "width of the rectangle, cut and overlap: 68 deg")
CUT_ENDS = CUT_BEGINS + CUT
PULSE_ENDS = CUT_BEGINS + PULSE
M_UPPER = Given(27.3e3, "kg", "P", "upper support")
J_UPPER = Given(21e3, "kg.m2", "P", "upper support about its centre of mass")
CENTRE_UPPER = Given(1.7, "m", "P", "centre of mass of the upper support from the pin")
M_LOWER = Given(37.2e3, "kg", "P", "lower support")
J_LOWER = Given(50e3, "kg.m2", "P", "lower support about its centre of mass")
CENTRE_LOWER = Given(2.2, "m", "P", "centre of mass of the lower support from the journal")
ROD_UPPER = Given(
    3.4, "m", "A", "pin to foot of the upper support: twice the distance of its centre"
)
ROD_LOWER = Given(4.4, "m", "A", "journal to guide of the lower support: likewise")
M_SHAFT = Given(17.2e3, "kg", "P", "crank shaft")
J_JOURNAL = Given(1.1e3, "kg.m2", "P", "crank shaft about its journal A")
J_PIN = Given(0.8e3, "kg.m2", "P", "crank shaft about its pin")
CENTRE_SHAFT = Given(
    (ECCENTRICITY + (J_JOURNAL - J_PIN) / (M_SHAFT * ECCENTRICITY)) / 2,
    "m",
    "I",
    "centre of mass of the crank shaft from its journal",
)
J_SHAFT = Given(
    J_JOURNAL - M_SHAFT * CENTRE_SHAFT**2, "kg.m2", "I", "crank shaft about its centre of mass"
)
J_MOTOR = Given(
    54e3,
    "kg.m2",
    "I",
    "motor with spindle, J_mx: damaged print, 51, 56 or 5.4 t.m2 are possible",
)
SPEED = Given(1.05, "rad/s", "P", "speed of the crank, printed beside 4 cuts a minute")
FOUR_CUTS = Given(0.419, "rad/s", "R", "4 cuts a minute without pauses")
GREATEST = Given(2.5e6, "N.m", "P", "greatest torque of the cut, Mmax")
IDLE = Given(
    0.085 * GREATEST, "N.m", "I", "idle torque, fitted to the printed reductions; source: 5 to 10 %"
)
MEAN = Given(2 * CUT / (np.pi * PULSE) * GREATEST, "N.m", "R", "equivalent rectangle (17)")
CENTRE_SINE = CUT_BEGINS + CUT / 2
CENTRE_RECTANGLE = Given(
    CUT_BEGINS + PULSE / 2, "rad", "R", "middle of cut and overlap, phi_max: 129 deg 45 min"
)

HALF_SINE = PulseTorque(tau_max=-GREATEST, centre=CENTRE_SINE, width=CUT)
RECTANGLE = PulseTorque(shape="rectangle", tau_max=-MEAN, centre=CENTRE_RECTANGLE, width=PULSE)


class CrankShaft(lp.Component):
    """Shaft with mass between the journal A and the crank pin."""

    flange = lp.Flange()
    journal_x = lp.LinearFlange()
    journal_y = lp.LinearFlange()
    pin_x = lp.LinearFlange()
    pin_y = lp.LinearFlange()
    arm: Eccentric = Eccentric(radius=ECCENTRICITY, phase=np.pi / 2)
    centre: Eccentric = Eccentric(radius=CENTRE_SHAFT, phase=np.pi / 2)
    body: Inertia = Inertia(J=J_SHAFT)
    mass_x: Mass = Mass(m=M_SHAFT)
    mass_y: Mass = Mass(m=M_SHAFT)

    def connections(self) -> Iterator[lp.Connection]:
        arm, centre = self.arm, self.centre
        yield lp.connect(self.flange, arm.flange, centre.flange, self.body.flange_a)
        yield lp.connect(self.journal_x, arm.hub_x, centre.hub_x)
        yield lp.connect(self.journal_y, arm.hub_y, centre.hub_y)
        yield lp.connect(centre.pin_x, self.mass_x.flange_a)
        yield lp.connect(centre.pin_y, self.mass_y.flange_a)
        yield lp.connect(arm.pin_x, self.pin_x)
        yield lp.connect(arm.pin_y, self.pin_y)


class Hanging(lp.Component):
    """Rod that hangs on a joint of the shaft, its foot in a guide, and its centre of mass."""

    joint_x = lp.LinearFlange()
    joint_y = lp.LinearFlange()
    guide_x = lp.LinearFlange(grounded=True)
    foot_y = lp.LinearFlange(free=True)
    length: lp.Param = lp.param("m", "joint to foot, longer than the crank", above=ECCENTRICITY)
    distance: lp.Param = lp.param("m", "joint to centre of mass", above=0)
    m: lp.Param = lp.param("kg", "mass", above=0)
    J: lp.Param = lp.param("kg.m2", "moment of inertia about the centre of mass", above=0)
    rod: GuidedRod = GuidedRod(length=length)
    centre: Eccentric = Eccentric(radius=-distance, phase=np.pi / 2)

    def connections(self) -> Iterator[lp.Connection]:
        rod, centre = self.rod, self.centre
        yield lp.connect(self.joint_x, rod.pin_x, centre.hub_x)
        yield lp.connect(self.joint_y, rod.pin_y, centre.hub_y)
        yield lp.connect(self.guide_x, rod.guide_x)
        yield lp.connect(self.foot_y, rod.foot_y)
        yield lp.connect(rod.flange, centre.flange)


class Support(Hanging):
    """Support that moves with its rod."""

    mass_x: Mass = Mass(m=Hanging.m)
    mass_y: Mass = Mass(m=Hanging.m)
    body: Inertia = Inertia(J=Hanging.J)

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.rod.flange, self.body.flange_a)
        yield lp.connect(self.centre.pin_x, self.mass_x.flange_a)
        yield lp.connect(self.centre.pin_y, self.mass_y.flange_a)


class RestingSupport(Hanging):
    """Support that moves with its rod while the command `u` is on, else is at rest."""

    u: lp.Input = lp.Input("1", "moves above 0.5")
    mass_x: translation.PickUp = translation.PickUp(m=Hanging.m)
    mass_y: translation.PickUp = translation.PickUp(m=Hanging.m)
    body: PickUp = PickUp(J=Hanging.J)

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.rod.flange, self.body.flange)
        yield lp.connect(self.centre.pin_x, self.mass_x.flange)
        yield lp.connect(self.centre.pin_y, self.mass_y.flange)
        yield lp.connect(self.u, self.mass_x.u, self.mass_y.u, self.body.u)


UPPER = {"length": ROD_UPPER, "distance": CENTRE_UPPER, "m": M_UPPER, "J": J_UPPER}
LOWER = {"length": ROD_LOWER, "distance": CENTRE_LOWER, "m": M_LOWER, "J": J_LOWER}


class Shear(lp.Component):
    """Shaft, supports and the switch between the carriages; `crank` is the shaft's flange."""

    crank = lp.Flange()
    shaft: CrankShaft = CrankShaft()
    switch: CamSwitch = CamSwitch(centre=0.0, width=2 * MEETS)


class PrintedShear(Shear):
    """The journal or the pin stands still, and with it the support that is not lifted."""

    upper: RestingSupport = RestingSupport().with_(UPPER)
    lower: RestingSupport = RestingSupport().with_(LOWER)
    journal_x: translation.Coupling = translation.Coupling()
    journal_y: translation.Coupling = translation.Coupling()
    pin_x: translation.Coupling = translation.Coupling()
    pin_y: translation.Coupling = translation.Coupling()
    frame: translation.Fixed = translation.Fixed()

    def connections(self) -> Iterator[lp.Connection]:
        shaft, upper, lower = self.shaft, self.upper, self.lower
        yield lp.connect(self.crank, shaft.flange, self.switch.flange)
        yield lp.connect(shaft.pin_x, upper.joint_x, lower.guide_x, self.pin_x.flange_b)
        yield lp.connect(shaft.pin_y, upper.joint_y, self.pin_y.flange_b)
        yield lp.connect(shaft.journal_x, upper.guide_x, lower.joint_x, self.journal_x.flange_b)
        yield lp.connect(shaft.journal_y, lower.joint_y, self.journal_y.flange_b)
        holds = (self.journal_x, self.journal_y, self.pin_x, self.pin_y)
        yield lp.connect(self.frame.flange, *(hold.flange_a for hold in holds))
        yield lp.connect(self.switch.y, self.journal_x.u, self.journal_y.u, upper.u)
        yield lp.connect(self.switch.rest, self.pin_x.u, self.pin_y.u, lower.u)


class GuidedShear(Shear):
    """Both supports in the guides of the frame; the lower one seated, or the upper one's foot."""

    upper: Support = Support().with_(UPPER)
    lower: Mass = Mass(m=M_LOWER)
    seat: translation.Coupling = translation.Coupling()
    strip: translation.Coupling = translation.Coupling()
    frame: translation.Fixed = translation.Fixed()

    def connections(self) -> Iterator[lp.Connection]:
        shaft, upper = self.shaft, self.upper
        yield lp.connect(self.crank, shaft.flange, self.switch.flange)
        yield lp.connect(shaft.pin_x, upper.joint_x)
        yield lp.connect(shaft.pin_y, upper.joint_y)
        yield lp.connect(shaft.journal_y, self.lower.flange_a, self.seat.flange_b)
        yield lp.connect(upper.foot_y, self.strip.flange_b)
        yield lp.connect(
            self.frame.flange, shaft.journal_x, self.seat.flange_a, self.strip.flange_a
        )
        yield lp.connect(self.switch.y, self.seat.u)
        yield lp.connect(self.switch.rest, self.strip.u)


class Loaded(lp.Component):
    """Shear under its loads behind the ellipses, whose motor side is `flange`."""

    flange = lp.Flange()
    eps: lp.Param = lp.param("1", "eccentricity of the ellipses", 0.0, min=0, below=1)
    slowest: lp.Param = lp.param("rad", "crank angle at which the crank is slowest", CENTRE_SINE)
    shear: Shear = PrintedShear()
    idle: Torque | SignTorque = Torque(tau=-IDLE)
    cut: PulseTorque = HALF_SINE
    mesh: IdealGear = IdealGear(ratio=-1.0)
    gear: EllipticalGear = EllipticalGear(e=eps, phase=slowest_at(slowest, eps))

    def connections(self) -> Iterator[lp.Connection]:
        crank = self.mesh.flange_b
        yield lp.connect(self.flange, self.gear.flange_a)
        yield lp.connect(self.gear.flange_b, self.mesh.flange_a)
        yield lp.connect(crank, self.shear.crank, self.idle.flange, self.cut.flange)
