"""Locking differentials and viscous couplings against closed forms."""

import numpy as np
import pytest
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import (
    BevelDifferential,
    Inertia,
    LimitedSlipDifferential,
    PowerLaw,
    Speed,
    Torque,
    ViscousCoupling,
)
from lumped.errors import EquationError

RATIO = 3.2


def axle(differential, push, w_left, w_right):
    """The torques that both wheels receive at given speeds."""
    system = assemble_rows(
        "push diff.flange_a",
        "diff.left one",
        "diff.right two",
        push=Torque(tau=push),
        diff=differential,
        one=Speed(w=w_left),
        two=Speed(w=w_right),
    )
    point = lp.start_point(system)
    return -point["diff.left.tau"], -point["diff.right.tau"]


@pytest.mark.parametrize(("left", "right"), [(12.0, 10.0), (-3.0, 4.0)])
@pytest.mark.parametrize("push", [90.0, -90.0])
def test_the_slower_wheel_takes_the_torque_bias_ratio(left, right, push):
    S = {"S_drive": 0.4, "S_coast": 0.25}
    torques = axle(LimitedSlipDifferential(ratio=RATIO, **S), push, left, right)
    slow, fast = torques if left < right else torques[::-1]
    assert slow + fast == pytest.approx(RATIO * push, rel=1e-12)
    bias = (1 + 0.4) / (1 - 0.4) if push > 0 else (1 - 0.25) / (1 + 0.25)
    assert slow / fast == pytest.approx(bias, rel=1e-12)


def test_preload_adds_to_the_difference_and_coast_ramps_are_those_of_drive_unless_given():
    for push in (50.0, -50.0):
        part = LimitedSlipDifferential(ratio=RATIO, S_drive=0.3, tau_0=40.0)
        left, right = axle(part, push, 5.0, 1.0)
        assert right - left == pytest.approx(40.0 + 0.3 * RATIO * 50.0, rel=1e-12)


@pytest.mark.parametrize(("drag", "sticks"), [(30.0, True), (140.0, False)])
def test_wheels_turn_together_until_their_torques_differ_by_more_than_the_friction(drag, sticks):
    push, S, tau_0 = 60.0, 0.3, 10.0
    system = assemble_rows(
        "push motor diff.flange_a",
        "diff.left one",
        "diff.right two road",
        push=Torque(tau=push),
        motor=Inertia(J=0.1),
        diff=LimitedSlipDifferential(ratio=RATIO, S_drive=S, tau_0=tau_0),
        one=Inertia(J=1.2),
        two=Inertia(J=1.2),
        road=Torque(tau=-drag),
    )
    run = lp.simulate(system, until=0.5, rtol=1e-11)
    together = (RATIO * push - drag) / (2.4 + 0.1 * RATIO**2)
    left, right = run["one.w"][-1] / 0.5, run["two.w"][-1] / 0.5
    # the mean does not feel the friction; half the difference does
    assert (left + right) / 2 == pytest.approx(together, rel=1e-9)
    if sticks:
        assert left == pytest.approx(right, rel=1e-12)
        return
    grip = tau_0 + S * RATIO * (push - 0.1 * RATIO * together)
    assert grip < drag
    assert left - right == pytest.approx((drag - grip) / 1.2, rel=1e-9)


def slip_of(characteristic, until, w=40.0):
    system = assemble_row(
        a=Inertia(J=0.3, w=w),
        visco=ViscousCoupling(characteristic=characteristic),
        b=Inertia(J=0.9),
    )
    run = lp.simulate(system, until=until, rtol=1e-11, start={"b.w": 0.0})
    assert 0.3 * run["a.w"] + 0.9 * run["b.w"] == pytest.approx(0.3 * w, rel=1e-9)
    return run.t, run["a.w"] - run["b.w"]


J = 0.3 * 0.9 / 1.2


def test_slip_decays_by_a_power_law():
    law = PowerLaw(nominal=25.0, v_nominal=20.0, n=0.6, v_low=1e-2)
    t, w = slip_of(law, 0.45)
    k = 25.0 / 20.0**0.6 / J
    exact = (40.0**0.4 - 0.4 * k * t) ** (1 / 0.4)
    assert exact[-1] > 0.1
    assert w == pytest.approx(exact, rel=1e-8)


def test_below_its_low_speed_a_power_law_is_linear():
    law = PowerLaw(nominal=25.0, v_nominal=20.0, n=0.6, v_low=8.0)
    t, w = slip_of(law, 0.5, w=8.0)
    d = 25.0 / 20.0 * (8.0 / 20.0) ** (0.6 - 1)
    assert w == pytest.approx(8.0 * np.exp(-d / J * t), rel=1e-8)


def test_slip_decays_by_rows_in_both_directions():
    rows = ((0.0, 0.0), (10.0, 30.0), (50.0, 50.0))
    t, w = slip_of(rows, 0.4)
    upper = (w > 10.0 + 1e-9) & (t > 0)
    exact = (40.0 + 50.0) * np.exp(-0.5 / J * t) - 50.0  # 25 + w / 2 above 10 rad/s
    assert w[upper] == pytest.approx(exact[upper], rel=1e-8)
    reached = J / 0.5 * np.log(90.0 / 60.0)
    assert w[~upper][1:] == pytest.approx(
        10 * np.exp(-3.0 / J * (t[~upper][1:] - reached)), rel=1e-8
    )
    assert slip_of(rows, 0.4, w=-40.0)[1] == pytest.approx(-w, rel=1e-8)


def test_between_the_outputs_of_a_differential_it_moves_torque_to_the_slower_wheel():
    system = assemble_rows(
        "push diff.flange_a",
        "diff.left visco.flange_a one",
        "diff.right visco.flange_b two",
        push=Torque(tau=50.0),
        diff=BevelDifferential(ratio=RATIO),
        visco=ViscousCoupling(characteristic=((0.0, 0.0), (10.0, 60.0))),
        one=Speed(w=15.0),
        two=Speed(w=10.0),
    )
    point = lp.start_point(system)
    received = [point["one.flange.tau"], point["two.flange.tau"]]
    assert received == pytest.approx([RATIO * 25.0 - 30.0, RATIO * 25.0 + 30.0], rel=1e-12)


def test_rows_that_begin_with_a_friction_are_refused():
    with pytest.raises(EquationError) as error:
        slip_of(((0.0, 5.0), (10.0, 30.0)), 0.1)
    for word in ("visco (ViscousCoupling)", "with 5", "Clutch"):
        assert word in str(error.value)


def test_a_power_law_out_of_range_is_refused():
    with pytest.raises(EquationError, match=r"visco.*n = -1 must be above 0"):
        slip_of(PowerLaw(nominal=25.0, v_nominal=20.0, n=-1.0, v_low=0.1), 0.1)
