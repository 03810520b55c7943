"""Square-root position control of the rotary arm, and the first motor, which could not lift.

The wanted speed is the smaller of a speed profile over the angle (slow about pick-up and release,
fast between) and the square-root law of the distance to the aim [R from the wording]. A ramp
limiter follows; it is bypassed near the aim, where the law is linear. The source has a square root
and a proportional range, but no formula in the copy. A bare sqrt(2 a e) has an infinite gain at the
aim and chatters there, as a gain K of 1000 1/s shows; one that meets K e without a shift asks for
twice the deceleration from there on; sqrt(2 a (e - e_0 / 2)) brakes with `a` throughout. A PI speed
controller with anti-windup sets the torque of the motor. Gains, decelerations and the lag of the
torque are [A].

The arm starts at rest with the torque that holds it. Friction in journals and reducer keeps it
there until the controller has built up the torque for lifting, after 5 ms. A calculation in which
friction acts forward all the time lets the arm sag meanwhile, and reaches the pick-up 1.5
microseconds later.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.components import (
    EfficientGear,
    Gain,
    Latch,
    Minimum,
    RateLimiter,
    SpeedDrive,
    SpeedProfile,
    SquareRootController,
    StepSequencer,
    Switch,
)
from lumped.models.rotary_arm import parts
from lumped.models.rotary_arm.cycle import ADOPTED
from lumped.models.rotary_arm.loads import FREE_WEIGHTS, MAXIMUM, load_inertia
from lumped.models.sources import Given

BRAKING = Given(1.0, "rad/s2", "A", "deceleration of the profile and of the square-root law, a_p")
GAIN = Given(6.0, "1/s", "A", "gain near the aim, K")
BANDWIDTH = Given(30.0, "rad/s", "A", "bandwidth of the speed control with the mandrel on the arm")
LAG = Given(0.005, "s", "A", "time constant of the motor's torque")
SECTOR = Given(0.02, "rad/s", "A", "error of speed below which the ramp limiter is a lag")
BEGIN = ADOPTED.points["S"]
AIM = BEGIN + 2 * np.pi
J_M = parts.J_ROTOR + load_inertia(loaded=True) / parts.RATIO**2  # kg.m2
PROFILE = (
    (BEGIN, parts.SLOW),
    (ADOPTED.points["A"], parts.FAST),
    (ADOPTED.points["E"] + (parts.FAST**2 - parts.SLOW**2) / (2 * parts.EPS), parts.SLOW),
    (ADOPTED.points["F"], parts.FAST),
)


class Controlled(lp.Component):
    """Arm on a speed-controlled motor that a square-root controller leads to its aim."""

    bandwidth: lp.Param = lp.param("1/s", "bandwidth of the speed control", BANDWIDTH, above=0)
    target: lp.Param = lp.param("1", "angle of the arm to reach", AIM)

    aim: SquareRootController = SquareRootController(wanted=target, K=GAIN, a=BRAKING)
    profile: SpeedProfile | StepSequencer = SpeedProfile(sections=PROFILE, a=BRAKING)
    slower: Minimum = Minimum()
    ramp: RateLimiter = RateLimiter(rate=parts.EPS, T=SECTOR / parts.EPS)
    near: Latch = Latch(on=target - aim.a / aim.K**2)  # where the square-root law becomes linear
    wanted: Switch = Switch()
    reducer: EfficientGear = EfficientGear(ratio=parts.RATIO, eta=parts.ETA)
    at_motor: Gain = Gain(k=reducer.ratio)
    motor: SpeedDrive = SpeedDrive(
        J=parts.J_ROTOR, k=bandwidth * J_M, T_i=5 / bandwidth, T=LAG, tau_max=MAXIMUM, P_max=1e9
    )
    arm: parts.Arm = parts.Arm()

    def connections(self) -> Iterator[lp.Connection]:
        yield from lp.chain(self.motor, self.reducer, self.arm.shaft)
        yield lp.connect(self.arm.phi, self.aim.measured, self.profile.u, self.near.u)
        yield lp.connect(self.aim.y, self.slower.a)
        yield lp.connect(self.profile.y, self.slower.b)
        yield lp.connect(self.slower.y, self.ramp.u, self.wanted.a)
        yield lp.connect(self.ramp.y, self.wanted.b)
        yield lp.connect(self.near.y, self.wanted.u)
        yield lp.connect(self.wanted.y, self.at_motor.u)
        yield lp.connect(self.at_motor.y, self.motor.wanted)


def run_controlled(
    until: float = 10.98,
    parameters: Mapping[str, Any] | None = None,
    start: Mapping[str, Any] | None = None,
    model: Controlled | None = None,
    **options: Any,
) -> lp.Trajectory:
    """The cycle under position control, from rest at S.

    Parameters
    ----------
    until : float
        End, s.
    parameters : mapping of name to value, optional
        Changed parameters, such as ``reducer.eta``, ``motor.tau_max``, ``bandwidth``.
    start : mapping of name to value, optional
        Start values instead of rest at S, with the torque that holds the arm there.
    model : Controlled, optional
        Arm, motor and control; those of the source unless given.
    **options
        Passed to `lumped.simulate`.
    """
    system = lp.assemble(Controlled() if model is None else model, keep=["arm.angle.phi"])
    begin = at_rest(system, parameters) | dict(start or {})
    return lp.simulate(system, until=until, parameters=parameters, start=begin, **options)


def at_rest(system: lp.System, parameters: Mapping[str, Any] | None = None) -> dict[str, float]:
    """Start values of rest at S, with the torque that holds the arm there."""
    found = system.parameter_values(parameters)
    still = {"arm.phi": BEGIN, "arm.mandrel.phi": found["arm.pick_up"], "arm.table.gap": 0.0}
    point = lp.start_point(system, parameters=parameters, start=still)
    weight = sum(point[name] for name in FREE_WEIGHTS)
    held = weight / (found["reducer.ratio"] * found["reducer.eta"])
    return still | {"motor.tau": held, "motor.x": held / found["motor.k"]}


def instants(run: lp.Trajectory) -> tuple[float, float, float]:
    """Instants at which the mandrel is taken and put down, and the law becomes linear, s."""
    found = {(e.component, e.after): e.time for e in reversed(run.events)}
    return (
        found["arm.carried", "u >= on"],
        found["arm.carried", "u >= off"],
        found["near", "u >= on"],
    )
