"""The pilger mill LG90 on its motor: steady running and start-up.

The source gives no motor. Assumed [A]: an induction motor on an inverter at constant flux behind a
rigid gear, with PI speed control; feed and turning gear as a constant torque while running, and as
dry friction in a start from rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import lumped as lp
from lumped.components import (
    IdealGear,
    Inertia,
    InverterInductionMotor,
    PIController,
    SignTorque,
    SpeedSensor,
    SpringDamper,
    Sum,
)
from lumped.models.pilger_mill.stand import SPEED, Mill, mill
from lumped.models.sources import Given
from lumped.ops import minimum

GEAR = Given(15.6, "1", "A", "ratio of the gear, i")
J_MOTOR = Given(30.0, "kg.m2", "A", "moment of inertia of the motor")
J_SHAFT = Given(3000.0, "kg.m2", "A", "moment of inertia of crankshaft and gear wheel")
BREAKDOWN = Given(13.5e3, "N.m", "A", "breakdown torque of the motor")
SLIP = Given(5.2, "rad/s", "A", "slip speed of the motor at breakdown")
LAG = Given(0.02, "s", "A", "time constant of the motor's torque")
GAIN = Given(0.5, "1", "A", "gain of the speed control, Kp")
INTEGRAL_GAIN = Given(2.0, "1/s", "A", "integral gain of the speed control, Ki")
RUN_UP = Given(6.0, "s", "A", "ramp of a start from rest")


class Driven(lp.Component):
    """Mill on its motor with speed control; rigid gear."""

    w: lp.Param = lp.param("rad/s", "speed of the crank that scenes want", SPEED["P"])
    wanted: lp.Input = lp.Input("rad/s", "wanted speed of the motor")
    motor: InverterInductionMotor = InverterInductionMotor(
        J=J_MOTOR, tau_k=BREAKDOWN, d_k=SLIP, T=LAG
    )
    sensor: SpeedSensor = SpeedSensor()
    control: PIController = PIController(k=GAIN, T_i=GAIN / INTEGRAL_GAIN)
    command: Sum = Sum()
    gear: IdealGear = IdealGear(ratio=GEAR)
    shaft: Inertia = Inertia(J=J_SHAFT)
    mill: Mill = mill("P")

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.motor.flange, self.gear.flange_a, self.sensor.flange)
        yield from self.line()
        yield lp.connect(self.wanted, self.control.wanted, self.command.a)
        yield lp.connect(self.sensor.w, self.control.measured)
        yield lp.connect(self.control.y, self.command.b)
        yield lp.connect(self.command.y, self.motor.w_s)

    def line(self) -> Iterator[lp.Connection]:
        """Connections between gear and mill."""
        yield from lp.chain(self.gear, self.shaft, self.mill.crank)


class ElasticallyDriven(Driven):
    """Mill on its motor with an elastic shaft between gear and crank."""

    c: lp.Param = lp.param("N.m/rad", "stiffness of the shaft", above=0)
    d: lp.Param = lp.param("N.m.s/rad", "damping of the shaft", min=0)
    twist: SpringDamper = SpringDamper(c=c, d=d)

    def line(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.gear, self.twist, self.shaft, self.mill.crank)


_WANTED = Driven.gear.ratio * Driven.w
"""Wanted speed of the motor, by the drive's own gear and crank speed."""


def running(
    part: Driven | None = None,
    until: float = 1.9,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    **options: Any,
) -> lp.Trajectory:
    """Steady running, from the crank angle zero at the wanted speed without torque.

    Parameters
    ----------
    part : Driven, optional
        Mill and motor; default is set P after the optimisation.
    until : float
        End, s.
    parameters, start : mapping of name to value, optional
        Parameters to change, and start values besides.
    **options
        Passed to `lumped.simulate`.
    """
    part = (Driven() if part is None else part).with_({"wanted": _WANTED})
    system = lp.assemble(part, keep=["mill.crank.phi"])
    found = system.parameter_values(parameters)
    begin = {"motor.w": found["gear.ratio"] * found["w"], "shaft.w": found["w"]}
    begin |= dict(start or {})
    return lp.simulate(system, until=until, parameters=parameters, start=begin, **options)


def start_up(part: Driven | None = None, until: float = 9.0, **options: Any) -> lp.Trajectory:
    """Start from rest at the crank angle zero: the wanted speed rises evenly in `RUN_UP`.

    Parameters as for `running`.
    """
    friction = SignTorque(tau_nominal=-Mill.M0)
    part = (Driven() if part is None else part).with_(
        {"wanted": minimum(lp.time / RUN_UP, 1.0) * _WANTED, "mill.feed": friction}
    )
    system = lp.assemble(part, keep=["mill.crank.phi"])
    return lp.simulate(system, until=until, **options)
