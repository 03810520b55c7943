"""The reversing mill 400 between motors on converters: droop, PI control and load share.

The source prints type, rated torque and inertia of the motors. Assumed [A]: torque to 2.5 times the
rated one, full power from 140 rad/s on, a torque loop of 5 ms, PI speed control. Two drives without
droop on rolls of unequal diameter load each other ever more, until the gap skids; droop bounds it
at M_u / Mr = eps / (2 s), and a load-share trim on the lower drive removes it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import lumped as lp
from lumped.components import Inertia, SpeedDrive, Spring
from lumped.models.reversing_mill import scenes
from lumped.models.reversing_mill import stand as mill
from lumped.models.sources import Given

OVERLOAD = Given(2.5, "1", "A", "greatest torque of a motor over the rated one")
LOOP = Given(5e-3, "s", "A", "time constant of a motor's torque loop")
MOTOR = SpeedDrive(
    J=mill.J_MOTOR,
    tau_max=OVERLOAD * mill.RATED,
    P_max=OVERLOAD * mill.RATED * scenes.SPEED,
    T=LOOP,
    k=scenes.GAIN,
    T_i=scenes.INTEGRAL_TIME,
)


class OnMotor(mill.Branch):
    """Branch on its motor."""

    wanted: lp.Input = lp.Input("rad/s", "wanted speed")
    tau = lp.Output("N.m", "motor torque")
    s: lp.Param = lp.param("1", "droop: loss of speed at rated torque", 0.0, min=0)
    motor: SpeedDrive = MOTOR.with_({"droop": s * scenes.SPEED / mill.RATED})
    gearbox: Inertia = Inertia(J=mill.J_GEARBOX)
    spindle: Spring = Spring(c=mill.C_SPINDLE)
    rolls: Inertia = Inertia(J=mill.J_BACKUP + mill.J_WORK)

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.rolls, self.spindle, self.gearbox, *self.to_motor())
        yield lp.connect(self.barrel, self.rolls.flange_a)
        yield lp.connect(self.wanted, self.motor.wanted)
        yield lp.connect(self.motor.tau_meas, self.tau)

    def to_motor(self) -> Iterator[Any]:
        """What lies behind the gearbox."""
        yield self.motor.flange


class MotorUpper(OnMotor):
    """Upper branch on its motor, with the long shaft."""

    shaft: Spring = Spring(c=mill.C_SHAFT)

    def to_motor(self) -> Iterator[Any]:
        yield self.shaft
        yield from super().to_motor()


class MotorLower(OnMotor):
    """Lower branch on its motor."""


class MotorStand(scenes.StripGap):
    """Stand on two independently controlled motors; `s` is the droop of both."""

    s: lp.Param = lp.param("1", "droop: loss of speed at rated torque", 0.0, min=0)
    upper: MotorUpper = MotorUpper(s=s, wanted=(1 + s) * scenes.SPEED)
    lower: MotorLower = MotorLower(s=s, wanted=(1 + s) * scenes.SPEED)


class SharingStand(scenes.TrimmedStand):
    """The same without droop, with a load-share trim of the lower motor."""

    upper: MotorUpper = MotorUpper(wanted=scenes.SPEED)
    lower: MotorLower = MotorLower()


TURNING = ("upper.motor.w", "upper.gearbox.w", "upper.rolls.w", "lower.motor.w")


def sharing(s: float, eps: float = scenes.DIFFERENCE) -> float:
    """Equalizing torque over rated torque in steady rolling with a droop, on unequal rolls."""
    start = dict.fromkeys(TURNING, scenes.SPEED)
    rolling = lp.equilibrium(lp.assemble(MotorStand(s=s)), parameters={"eps": eps}, start=start)
    return float(rolling["gap.tau"] / mill.RATED)


def motors_at_entry(
    stand: MotorStand | SharingStand,
    idle: float = scenes.SPEED,
    until: float = 4.0,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Strip that enters at 0.5 s between unequal rolls turning idle, and the motors' answer.

    Parameters
    ----------
    stand : MotorStand or SharingStand
        Stand.
    idle : float
        Speed before, rad/s.
    until : float
        End, s.
    start : mapping of name to value, optional
        Start values besides.
    **options
        Passed to `lumped.simulate`.
    """
    system = lp.assemble(stand.with_({"eps": scenes.DIFFERENCE, "enters": 0.5}))
    begin = dict.fromkeys(TURNING, idle) | dict(start or {})
    return lp.simulate(system, until=until, start=begin, **options)
