"""Slip coupling against closed forms: overload, both directions, engaging at a speed."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, SlipCoupling, Torque

J_A, J_B, STATIC, KINETIC = 0.4, 0.6, 50.0, 30.0


def pair(torque, u=1.0, static=STATIC, kinetic=KINETIC, w=0.0):
    """Two bodies with a slip coupling between them; a torque drives the first."""
    return in_a_row(
        drive=Torque(tau=torque),
        a=Inertia(J=J_A, w=w),
        coupling=SlipCoupling(static=static, kinetic=kinetic, u=u),
        b=Inertia(J=J_B, w=0.0),
    )


@pytest.mark.parametrize("way", [1, -1])
def test_a_rising_torque_breaks_it_loose_and_a_falling_one_lets_it_stick_again(way):
    rise = 100.0  # N.m/s; the load takes J_b / (J_a + J_b) of the torque
    t_slip = STATIC * (J_A + J_B) / J_B / rise
    torque = way * rise * lp.ops.where(lp.time >= 1.0, 0.0, lp.time)
    run = lp.simulate(lp.assemble(pair(torque)), until=4.0, rtol=1e-10)
    # slip rate (M - kinetic) / J_a - kinetic / J_b up to 1 s, then -kinetic (1 / J_a + 1 / J_b)
    drag = KINETIC * (1 / J_A + 1 / J_B)
    slip = rise * (1 - t_slip**2) / 2 / J_A - drag * (1 - t_slip)
    received = [(event.time, event.after) for event in run.events if event.component == "coupling"]
    word = "backward" if way > 0 else "forward"
    assert [after for _, after in received] == [word, "stuck"]
    expected = [t_slip, 1.0 + slip / drag]
    assert [t for t, _ in received] == pytest.approx(expected, abs=1e-9)
    assert run["a.w"][-1] == pytest.approx(way * rise / 2 / (J_A + J_B), rel=1e-9)


def test_engaging_at_a_speed_brings_both_sides_together_in_the_closed_form_time():
    w, begin = 40.0, 0.5
    u = lp.ops.where(lp.time >= begin, 1.0, 0.0)
    run = lp.simulate(lp.assemble(pair(0.0, u=u, w=w)), until=2.0, rtol=1e-10)
    sticks = next(event.time for event in run.events if event.after == "stuck")
    assert sticks == pytest.approx(begin + w / (KINETIC * (1 / J_A + 1 / J_B)), abs=1e-10)
    common = J_A * w / (J_A + J_B)
    assert [run["a.w"][-1], run["b.w"][-1]] == pytest.approx([common] * 2, rel=1e-12)


def test_disengaged_it_carries_nothing():
    u = lp.ops.where(lp.time >= 0.3, 0.0, 1.0)
    run = lp.simulate(lp.assemble(pair(10.0, u=u)), until=1.0, rtol=1e-10)
    t = np.maximum(run.t - 0.3, 0)
    assert run["b.w"] == pytest.approx(10.0 * np.minimum(run.t, 0.3), rel=1e-9, abs=1e-12)
    expected = 10.0 * np.minimum(run.t, 0.3) + 10.0 / J_A * t
    assert run["a.w"] == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert run["coupling.position"][-1] == 2
