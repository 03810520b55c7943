"""The reversing mill 400 as a machine whose structure changes, and its speed controllers.

The roll gap sticks, skids beyond M_s with the torque M_k, and is open without strip. It carries the
equalizing torque M_u from the upper to the lower rolls, in steady rolling half the difference of
the spindle torques. The source speaks of these modes but prints no numbers for them;
limits, speeds and controllers are assumed [A].

Rolls of unequal diameter roll on each other with w_n = (1 + eps) w_v. Two drives with droop s, the
loss of speed at rated torque, then load each other with M_u / Mr = eps / (2 s). Two PI speed
controllers increase this torque until the gap skids, unless a load-share trim equalises their
torques.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import lumped as lp
from lumped.components import (
    Coupling,
    ElastoBacklash,
    IdealGear,
    LoadShare,
    PController,
    PIController,
    SlipCoupling,
    SpeedSensor,
    Sum,
    Torque,
)
from lumped.models.reversing_mill.stand import (
    C_SPINDLE,
    RATED,
    SHAFTS,
    Branch,
    LowerBranch,
    OpenGap,
    UpperBranch,
)
from lumped.models.sources import Given
from lumped.ops import where

STATIC = Given(0.40 * RATED, "N.m", "A", "greatest equalizing torque without skidding, M_s")
KINETIC = Given(0.30 * RATED, "N.m", "A", "equalizing torque while skidding, M_k")
SPEED = Given(140.0, "rad/s", "A", "speed of the motors while rolling, w_0")
DIFFERENCE = Given(0.002, "1", "A", "relative difference of the roll diameters, eps")
GAIN = Given(1000.0, "N.m.s/rad", "A", "gain of a PI speed controller")
INTEGRAL_TIME = Given(0.2, "s", "A", "integral time of a PI speed controller")
PLAY = Given(0.02, "rad", "A", "play of a spindle at the motor shaft")
NEVER = 1e9  # s
SKIDS = (0.031472, 0.205081, 0.212507, 0.231298)
"""Instants at which the gap skids and sticks in `skidding`, s, by modal sums between them."""


def between(enters: lp.Expr, leaves: lp.Expr) -> lp.Expr:
    """1 while there is strip, else 0."""
    return where(lp.time >= leaves, 0.0, where(lp.time >= enters, 1.0, 0.0))


class StripGap(OpenGap):
    """Stand that is loaded, and whose rolls stick to each other, while there is strip.

    `gap` joins the rolls; its speed is the slip, positive if the upper rolls lead.
    """

    enters: lp.Param = lp.param("s", "instant at which the strip enters", 0.0)
    leaves: lp.Param = lp.param("s", "instant at which it breaks or leaves", NEVER)
    M_pr: lp.Param = lp.param("N.m", "rolling torque on each pair of rolls", RATED)
    M_s: lp.Param = lp.param("N.m", "greatest equalizing torque without skidding", STATIC, min=0)
    M_k: lp.Param = lp.param("N.m", "equalizing torque while skidding", KINETIC, min=0)
    eps: lp.Param = lp.param("1", "diameters of the rolls, upper over lower, less 1", 0.0, above=-1)

    upper_load: Torque = Torque(tau=-M_pr * between(enters, leaves))
    lower_load: Torque = Torque(tau=-M_pr * between(enters, leaves))
    ratio: IdealGear = IdealGear(ratio=1 + eps)
    gap: lp.Component = SlipCoupling(static=M_s, kinetic=M_k, u=between(enters, leaves))

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield from lp.chain(self.lower.barrel, self.ratio, self.gap, self.upper.barrel)


def skidding(
    stand: StripGap | None = None,
    until: float = 0.4,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Motors at 1.6 and 0.4 Mr for 0.12 s of steady rolling, then at Mr again [A].

    Parameters
    ----------
    stand : StripGap, optional
        Stand whose motors are torques; that of the source unless given.
    until : float
        End, s.
    start : mapping of name to value, optional
        Start values besides rated torque in all shafts.
    **options
        Passed to `lumped.simulate`, among them ``parameters={"M_s": ..., "M_k": ...}``.
    """
    rolling = dict.fromkeys(SHAFTS, RATED) | dict(start or {})
    return lp.simulate(lp.assemble(pull_apart(stand)), until=until, start=rolling, **options)


def pull_apart(stand: StripGap | None = None) -> StripGap:
    """Stand whose motors give 1.6 and 0.4 Mr for 0.12 s, then Mr each [A].

    Parameters
    ----------
    stand : StripGap, optional
        Stand whose motors are torques; that of the source unless given.
    """
    early = lp.time < 0.12
    return (StripGap() if stand is None else stand).with_(
        {
            "upper.drive.tau": where(early, 1.6 * RATED, RATED),
            "lower.drive.tau": where(early, 0.4 * RATED, RATED),
        }
    )


def strip_break(
    share: float = 0.0,
    play: float = 0.0,
    until: float = 0.22,
    stand: StripGap | None = None,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Strip that breaks at 20 ms of steady rolling; the motors keep their torques.

    Parameters
    ----------
    share : float
        Part of Mr that the upper motor has more and the lower one less: load share.
    play : float
        Whole play in each spindle, at the motor shaft, rad.
    until : float
        End, s.
    stand : StripGap, optional
        Stand whose motors are torques; that of the source unless given.
    parameters : mapping of name to value, optional
        Parameters to change.
    start : mapping of name to value, optional
        Values near which, or with which, the steady rolling is sought.
    **options
        Passed to `lumped.simulate`.
    """
    stand = (StripGap() if stand is None else stand).with_(
        {
            "leaves": 0.02,
            "upper.drive.tau": (1 + share) * RATED,
            "lower.drive.tau": (1 - share) * RATED,
        }
    )
    if play:
        loose = ElastoBacklash(c=C_SPINDLE, b=play)
        stand = stand.with_({"upper.spindle": loose, "lower.spindle": loose})
    system = lp.assemble(stand)
    found = system.parameter_values(parameters)
    near: dict[str, Any] = {}
    for side, torque in (("upper", (1 + share) * RATED), ("lower", (1 - share) * RATED)):
        spindle = f"{side}.spindle"
        if f"{spindle}.c" in found:  # on the driving side of its play
            gap = found.get(f"{spindle}.b", 0.0)
            near[f"{spindle}.phi_rel"] = torque / found[f"{spindle}.c"] + gap / 2
    rolling = lp.equilibrium(system, parameters=parameters, start=near | dict(start or {}))
    return lp.simulate(system, until=until, start=rolling, **options)


class JoinedGap(StripGap):
    """Strip joins the rolls at once, whatever their speeds, and holds any torque."""

    gap: Coupling = Coupling(u=between(StripGap.enters, StripGap.leaves))


def entry_at_speed(
    stand: StripGap,
    lead: float,
    until: float = 0.2,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Strip that enters at 20 ms; the motors have rated torque from then on.

    Parameters
    ----------
    stand : StripGap
        Stand, for example `JoinedGap`.
    lead : float
        Speed of the upper branch before, relative to the lower one, rad/s.
    until : float
        End, s.
    start : mapping of name to value, optional
        Start values besides.
    **options
        Passed to `lumped.simulate`.
    """
    step = where(lp.time >= 0.02, RATED, 0.0)
    drives = {"upper.drive.tau": step, "lower.drive.tau": step}
    system = lp.assemble(stand.with_({"enters": 0.02} | drives))
    turning = ("upper.motor.w", "upper.gearbox.w", "upper.rolls.w", "gap.w_rel")
    begin = dict.fromkeys(turning, lead) | dict(start or {})
    return lp.simulate(system, until=until, start=begin, **options)


class SpeedControlled(lp.Component):
    """Motor torque set by a speed controller."""

    flange = lp.Flange()
    wanted: lp.Input = lp.Input("rad/s", "wanted speed")
    tau = lp.Output("N.m", "motor torque")
    torque: Torque = Torque()
    sensor: SpeedSensor = SpeedSensor()
    control: PController | PIController = PIController(k=GAIN, T_i=INTEGRAL_TIME)

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.flange, self.torque.flange, self.sensor.flange)
        yield lp.connect(self.wanted, self.control.wanted)
        yield lp.connect(self.sensor.w, self.control.measured)
        yield lp.connect(self.control.y, self.torque.tau, self.tau)


class Controlled(Branch):
    """Branch with speed control."""

    wanted: lp.Input = lp.Input("rad/s", "wanted speed")
    tau = lp.Output("N.m", "motor torque")
    drive: Any = SpeedControlled()

    def connections(self) -> Iterator[lp.Connection]:
        yield from super().connections()
        yield lp.connect(self.wanted, self.drive.wanted)
        yield lp.connect(self.drive.tau, self.tau)


class ControlledUpper(Controlled, UpperBranch):
    """Upper branch with speed control."""


class ControlledLower(Controlled, LowerBranch):
    """Lower branch with speed control."""


class ControlledStand(StripGap):
    """Two independent PI speed controllers."""

    upper: ControlledUpper = ControlledUpper(wanted=SPEED)
    lower: ControlledLower = ControlledLower(wanted=SPEED)


class TrimmedStand(StripGap):
    """Two PI speed controllers; a load-share trim corrects the wanted speed of the lower one."""

    trim: LoadShare = LoadShare(k=8e-4, T_i=2.0, y_max=2.0)
    wanted: Sum = Sum(a=SPEED)
    upper: Branch = ControlledUpper(wanted=SPEED)
    lower: Branch = ControlledLower()

    def connections(self) -> Iterator[lp.Connection]:
        upper: Any = self.upper
        lower: Any = self.lower
        yield from super().connections()
        yield lp.connect(lower.tau, self.trim.own)
        yield lp.connect(upper.tau, self.trim.other)
        yield lp.connect(self.trim.y, self.wanted.b)
        yield lp.connect(self.wanted.y, lower.wanted)


def with_droop(s: float) -> ControlledStand:
    """Drives that turn with w_0 at rated torque and (1 + s) w_0 without load."""
    drive = SpeedControlled(control=PController(k=RATED / (s * SPEED)))
    return ControlledStand(
        upper=ControlledUpper(drive=drive, wanted=(1 + s) * SPEED),
        lower=ControlledLower(drive=drive, wanted=(1 + s) * SPEED),
    )


def unequal_rolls(
    stand: ControlledStand | TrimmedStand,
    until: float,
    eps: float = DIFFERENCE,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Rolls of unequal diameter between PI controllers: begins with rated torque in all shafts.

    Parameters
    ----------
    stand : ControlledStand or TrimmedStand
        Stand.
    until : float
        End, s.
    eps : float
        Diameter of the upper over that of the lower rolls, less 1.
    parameters, start : mapping of name to value, optional
        Parameters to change, and start values besides.
    **options
        Passed to `lumped.simulate`.
    """
    system = lp.assemble(stand.with_({"eps": eps}))
    found = system.parameter_values(parameters)
    upper = ("upper.motor.w", "upper.gearbox.w", "upper.rolls.w")
    begin: dict[str, Any] = dict.fromkeys(SHAFTS, RATED) | dict.fromkeys(upper, SPEED)
    for side in ("upper", "lower"):
        begin[f"{side}.drive.control.x"] = RATED / found[f"{side}.drive.control.k"]
    begin["lower.motor.w"] = (1 + found["eps"]) * SPEED
    begin |= dict(start or {})
    return lp.simulate(system, until=until, parameters=parameters, start=begin, **options)
