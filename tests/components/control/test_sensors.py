"""Sensors against the quantities that they measure."""

import numpy as np
from checks import assert_close
from rows import assemble_rows

import lumped as lp
from lumped.components import (
    AccelerationSensor,
    AngleSensor,
    Inertia,
    PowerSensor,
    RelativeAngleSensor,
    RelativeSpeedSensor,
    SpeedSensor,
    Spring,
    Torque,
    TorqueSensor,
)

GRID = np.linspace(0.0, 2.0, 41)


def shown(*rows, **parts):
    """A run that keeps what angle sensors show."""
    keep = [name for name in ("position.phi", "distance.phi_rel") if name.split(".")[0] in parts]
    system = assemble_rows(*rows, keep=keep, **parts)
    return lp.simulate(system, until=2.0, rtol=1e-11, grid=GRID)


def test_position_speed_and_acceleration_are_those_of_the_body():
    """``J der(w) = 6 cos(3 t)``."""
    found = shown(
        "drive body position speed acceleration",
        drive=Torque(tau=6 * lp.ops.cos(3 * lp.time)),
        body=Inertia(J=4.0, phi=0.5, w=2.0),
        position=AngleSensor(),
        speed=SpeedSensor(),
        acceleration=AccelerationSensor(),
    )
    angle = 3 * GRID
    expected = 0.5 + 2.0 * GRID + (1 - np.cos(angle)) / 6
    assert_close(found["position.phi"], expected, 1e-9, "angle")
    assert_close(found["speed.w"], 2.0 + np.sin(angle) / 2, 1e-9, "speed")
    assert_close(found["acceleration.a"], 1.5 * np.cos(angle), 1e-9, "acceleration")


def test_relative_position_and_speed_are_those_of_b_seen_from_a():
    found = shown(
        *("a spring b", "a distance b", "a speed b"),
        a=Inertia(J=3.0, w=0.0),
        spring=Spring(c=96.0, phi_rel=0.25),
        b=Inertia(J=6.0, w=0.0),
        distance=RelativeAngleSensor(),
        speed=RelativeSpeedSensor(),
    )
    w = np.sqrt(96.0 * (1 / 3.0 + 1 / 6.0))
    assert_close(found["distance.phi_rel"], 0.25 * np.cos(w * GRID), 1e-9, "angle")
    assert_close(found["speed.w_rel"], -0.25 * w * np.sin(w * GRID), 1e-9, "speed")


def test_effort_and_power_count_positive_from_a_to_b():
    """``tau_ab = tau J_b / (J_a + J_b)``."""
    found = shown(
        "drive a effort power b",
        drive=Torque(tau=10.0),
        a=Inertia(J=2.0, w=-3.0),
        effort=TorqueSensor(),
        power=PowerSensor(),
        b=Inertia(J=3.0),
    )
    assert_close(found["effort.tau"], np.full(len(GRID), 6.0), 1e-14, "effort")
    assert_close(found["power.power"], 6.0 * (2.0 * GRID - 3.0), 1e-10, "power")
