"""Carrousel coiler with safety coupling, long shaft and play: closed forms of two bodies."""

import numpy as np
import pytest

from lumped.models.carrousel_coiler.shafts import (
    J_HALF,
    J_WHEEL,
    JAM,
    PLAY,
    SLIDING,
    SLIP,
    STIFFNESS,
    jam,
)

RATIO, TORQUE = 1.354, 80e3 * 0.4
J_MOTOR = 600.0
J_A = (J_MOTOR + J_HALF) * RATIO**2 + J_WHEEL  # all before the shaft, at the mandrel
J_B = 500.0 - J_WHEEL + np.pi * 7850 * 1.25 / 2 * (0.4**4 - 0.305**4)
SWING = np.sqrt(STIFFNESS * (1 / J_A + 1 / J_B))
SHARE = JAM * J_A / (J_A + J_B)
"""Mean torque of the shaft that stops the motor with the mandrel, N.m."""


@pytest.fixture(scope="module")
def run():
    return jam(rtol=1e-9)


def instants(run, part):
    return [event.time for event in run.events if event.component == part]


def test_without_a_slip_the_shaft_bears_twice_the_share_of_the_motor():
    run = jam(until=0.2, rtol=1e-9, parameters={"drive.coupling.static": 1e9})
    received = -run["drive.shaft.tau"].min()
    assert received == pytest.approx(TORQUE + 2 * SHARE, rel=3e-3)  # the coil grows by 5 layers
    assert not instants(run, "drive.coupling")


def test_the_coupling_slips_when_the_torque_of_the_motor_reaches_its_limit(run):
    # RATIO tau_coupling = TORQUE + (J_MOTOR RATIO^2 / J_A) SHARE (1 - cos(SWING t))
    reached = (RATIO * SLIP - TORQUE) * J_A / (J_MOTOR * RATIO**2) / SHARE
    expected = np.arccos(1 - reached) / SWING
    assert instants(run, "drive.coupling")[0] - 0.1 == pytest.approx(expected, rel=5e-3)


def test_it_bears_no_more_and_the_motor_slows_evenly(run):
    assert np.abs(run["drive.coupling.tau"]).max() <= SLIP
    slipping = run.t > instants(run, "drive.coupling")[0] + 1e-6
    assert np.abs(run["drive.coupling.tau"][slipping]) == pytest.approx(SLIDING * SLIP)
    slope = np.polyfit(run.t[slipping], run["drive.rotor.w"][slipping], 1)[0]
    assert slope == pytest.approx((TORQUE / RATIO - SLIDING * SLIP) / J_MOTOR, rel=1e-6)


def test_what_stays_before_the_shaft_swings_against_the_slipping_torque(run):
    """From the slip on: half coupling and gears on one side of the shaft, mandrel on the other."""
    small, slip = J_HALF * RATIO**2 + J_WHEEL, RATIO * SLIDING * SLIP
    t = instants(run, "drive.coupling")[0] - 0.1
    twist = TORQUE + SHARE * (1 - np.cos(SWING * t))  # as torques of the shaft
    rate = SHARE * SWING * np.sin(SWING * t)
    faster = np.sqrt(STIFFNESS * (1 / small + 1 / J_B))
    rest = STIFFNESS * (slip / small + (JAM + TORQUE) / J_B) / faster**2
    expected = rest + np.hypot(twist - rest, rate / faster)
    received = np.abs(run["drive.shaft.tau"])[run.t < 0.2].max()
    assert received == pytest.approx(expected, rel=1e-2)  # of the times of the output
    assert expected < 0.75 * (TORQUE + 2 * SHARE)


def test_a_reversed_motor_crosses_the_play_in_free_flight():
    run = jam(until=0.05, rtol=1e-10, parameters={"drive.motor.tau": -4 * TORQUE / RATIO})
    pull = -4 * TORQUE / J_A + TORQUE / J_B  # acceleration of the twist without torque of the shaft
    twist, rest = TORQUE / STIFFNESS, pull / SWING**2
    leaves = np.arccos(-rest / (twist - rest)) / SWING
    speed = SWING * np.sqrt((twist - rest) ** 2 - rest**2)
    flight = (speed - np.sqrt(speed**2 - 2 * pull * PLAY)) / pull
    received = instants(run, "drive.shaft")[:2]
    assert received == pytest.approx([leaves, leaves + flight], rel=1e-3)
