"""Sensors against the quantities that they measure."""

import numpy as np
from checks import assert_close

import lumped as lp
from lumped import components as rotation
from lumped.components import (
    Inertia,
    RelativeAngleSensor,
    RelativeSpeedSensor,
    Spring,
    Torque,
    TorqueSensor,
)

GRID = np.linspace(0.0, 2.0, 41)
TIGHT = {"until": 2.0, "rtol": 1e-11, "grid": GRID}


class Turning(lp.Component):
    """A body under a torque with sensors on it: J der(w) = 6 cos(3 t)."""

    drive: Torque = Torque(tau=6 * lp.ops.cos(3 * lp.time))
    body: Inertia = Inertia(J=4.0, phi=0.5, w=2.0)
    position: rotation.AngleSensor = rotation.AngleSensor()
    speed: rotation.SpeedSensor = rotation.SpeedSensor()
    acceleration: rotation.AccelerationSensor = rotation.AccelerationSensor()
    names = ("position.phi", "speed.w", "acceleration.a")

    def connections(self):
        yield from lp.chain(self.drive, self.body)
        sensors = (self.position, self.speed, self.acceleration)
        yield lp.connect(self.body.flange_b, *(sensor.flange for sensor in sensors))


def test_position_speed_and_acceleration_are_those_of_the_body():
    found = lp.simulate(lp.assemble(Turning(), keep=[Turning.names[0]]), **TIGHT)
    angle = 3 * GRID
    expected = (
        0.5 + 2.0 * GRID + (1 - np.cos(angle)) / 6,
        2.0 + np.sin(angle) / 2,
        1.5 * np.cos(angle),
    )
    for name, values in zip(Turning.names, expected, strict=True):
        assert_close(found[name], values, 1e-9, name)


class Twisting(lp.Component):
    """Two bodies on a spring with sensors across it: tau = c (phi_b - phi_a)."""

    a: Inertia = Inertia(J=3.0, w=0.0)
    spring: Spring = Spring(c=96.0, phi_rel=0.25)
    b: Inertia = Inertia(J=6.0, w=0.0)
    distance: RelativeAngleSensor = RelativeAngleSensor()
    speed: RelativeSpeedSensor = RelativeSpeedSensor()
    names = ("distance.phi_rel", "speed.w_rel")

    def connections(self):
        yield from lp.chain(self.a, self.spring, self.b)
        yield from lp.chain(self.a, self.distance, self.b)
        yield from lp.chain(self.a, self.speed, self.b)


def test_relative_position_and_speed_are_those_of_b_seen_from_a():
    found = lp.simulate(lp.assemble(Twisting(), keep=Twisting.names), **TIGHT)
    w = np.sqrt(96.0 * (1 / 3.0 + 1 / 6.0))
    expected = (0.25 * np.cos(w * GRID), -0.25 * w * np.sin(w * GRID))
    for name, values in zip(Twisting.names, expected, strict=True):
        assert_close(found[name], values, 1e-9, name)


class Shaft(lp.Component):
    """A torque accelerates two bodies through two sensors: tau_ab = tau J_b / (J_a + J_b)."""

    drive: Torque = Torque(tau=10.0)
    a: Inertia = Inertia(J=2.0, w=-3.0)
    effort: TorqueSensor = TorqueSensor()
    power: rotation.PowerSensor = rotation.PowerSensor()
    b: Inertia = Inertia(J=3.0)

    def connections(self):
        yield from lp.chain(self.drive, self.a, self.effort, self.power, self.b)


def test_effort_and_power_count_positive_from_a_to_b():
    found = lp.simulate(lp.assemble(Shaft()), **TIGHT)
    effort = np.full(len(GRID), 6.0)
    power = 6.0 * (2.0 * GRID - 3.0)
    assert_close(found["effort.tau"], effort, 1e-14, "effort")
    assert_close(found["power.power"], power, 1e-10, "power")
