"""Bevel gears whose housing turns: differentials and the torques about two axes."""

import numpy as np
import pytest
from rows import assemble_rows

import lumped as lp
from lumped.components import BevelDifferential, BevelGear, Fixed, Inertia, Speed, Torque


def test_both_outputs_of_a_differential_take_the_same_torque_at_any_speeds():
    system = assemble_rows(
        *("drive motor", "motor.flange_b gear.flange_a"),
        *("gear.left left.flange_a at_left.flange", "gear.right right.flange_a at_right.flange"),
        gear=BevelDifferential(ratio=4.0),
        drive=Torque(tau=9.0),
        motor=Inertia(J=0.5),
        left=Inertia(J=2.0),
        at_left=Torque(tau=-8.0),
        right=Inertia(J=3.0),
        at_right=Torque(tau=1.0),
    )
    run = lp.simulate(system, until=3.0)
    left, right = run["gear.left.tau"], run["gear.right.tau"]
    assert np.abs(left - right).max() < 1e-12 * np.abs(left).max()
    assert np.abs(left + 2 * run["gear.flange_a.tau"]).max() < 1e-12 * np.abs(left).max()
    assert np.abs(run["motor.w"] - 2 * (run["left.w"] + run["right.w"])).max() < 1e-9
    # mass matrix of both outputs: the motor adds J (ratio / 2)^2 to all four places
    M = np.diag([2.0, 3.0]) + 0.5 * 4.0
    rates = np.linalg.solve(M, [-8.0 + 18.0, 1.0 + 18.0])
    received = run["left.w"][-1], run["right.w"][-1]
    assert np.abs(np.subtract(received, 3.0 * rates)).max() < 1e-9


@pytest.mark.parametrize("ratio", [3.5, -3.5])
def test_housing_of_a_bevel_gear_takes_each_torque_about_its_own_axis(ratio):
    """Moments about the axis of each shaft, of all torques on the housing and on the shafts."""
    system = assemble_rows(
        *("drive gear body load", "gear.support_a at_a.flange", "gear.support_b at_b.flange"),
        drive=Speed(w=1.0),
        gear=BevelGear(ratio=ratio),
        body=Inertia(J=1.0),
        load=Torque(tau=-7.0),
        at_a=Fixed(),
        at_b=Fixed(),
    )
    point = lp.start_point(system)
    into_a, into_b = -point["drive.flange.tau"], -7.0
    assert abs(point["body.w"] - 1 / ratio) < 1e-15
    assert abs(into_a - 7.0 / ratio) < 1e-14
    assert abs(point["at_a.flange.tau"] - into_a) < 1e-14
    assert abs(point["at_b.flange.tau"] - into_b) < 1e-14


def test_housing_of_a_bevel_gear_that_turns_about_one_axis_turns_the_other_shaft():
    """The pinion rolls on the held crown wheel while the housing turns about the crown's axis."""
    system = assemble_rows(
        *("pinion gear crown", "swing.flange gear.support_b"),
        gear=BevelGear(ratio=3.0),
        crown=Fixed(),
        swing=Speed(w=2.0),
        pinion=Inertia(J=1.0),
    )
    assert abs(lp.start_point(system)["pinion.w"] + 6.0) < 1e-14
