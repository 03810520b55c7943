"""Bevel gears whose housing turns: differentials and the torques about two axes."""

import numpy as np
import pytest
from rows import in_rows

import lumped as lp
from lumped.components import BevelDifferential, BevelGear, Fixed, Inertia, Speed, Torque


class TestBevelDifferential:
    def model(self, **given):
        return lp.compose(
            gear=BevelDifferential(ratio=4.0),
            motor=Inertia(J=0.5),
            left=Inertia(J=2.0),
            right=Inertia(J=3.0),
            torques={name: Torque(tau=0.0) for name in ("a", "left", "right")},
            connections=lambda m: (
                lp.connect(m.torques["a"].flange, m.motor.flange_a),
                lp.connect(m.motor.flange_b, m.gear.flange_a),
                lp.connect(m.gear.left, m.left.flange_a, m.torques["left"].flange),
                lp.connect(m.gear.right, m.right.flange_a, m.torques["right"].flange),
            ),
            **given,
        )

    def test_both_outputs_take_the_same_torque_at_any_speeds(self):
        changed = {
            f'torques["{n}"].tau': v for n, v in (("a", 9.0), ("left", -8.0), ("right", 1.0))
        }
        run = lp.simulate(lp.assemble(self.model()), until=3.0, parameters=changed)
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
    model = in_rows(
        "drive gear body load",
        "gear.support_a at_a",
        "gear.support_b at_b",
        drive=Speed(w=1.0),
        gear=BevelGear(ratio=ratio),
        body=Inertia(J=1.0),
        load=Torque(tau=-7.0),
        at_a=Fixed(),
        at_b=Fixed(),
    )
    point = lp.start_point(lp.assemble(model))
    into_a, into_b = -point["drive.flange.tau"], -7.0
    assert abs(point["body.w"] - 1 / ratio) < 1e-15
    assert abs(into_a - 7.0 / ratio) < 1e-14
    assert abs(point["at_a.flange.tau"] - into_a) < 1e-14
    assert abs(point["at_b.flange.tau"] - into_b) < 1e-14


def test_housing_of_a_bevel_gear_that_turns_about_one_axis_turns_the_other_shaft():
    """The pinion rolls on the held crown wheel while the housing turns about the crown's axis."""
    model = in_rows(
        "crown gear.flange_b",
        "swing gear.support_b",
        "pinion.flange_a gear",
        gear=BevelGear(ratio=3.0),
        crown=Fixed(),
        swing=Speed(w=2.0),
        pinion=Inertia(J=1.0),
    )
    assert abs(lp.start_point(lp.assemble(model))["pinion.w"] + 6.0) < 1e-14
