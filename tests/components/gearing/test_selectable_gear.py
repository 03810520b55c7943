"""Gear of two ratios against closed forms: neutral, changes at rest and while turning."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, SelectableGear, Torque
from lumped.ops import where

J_A, J_B, I_1, I_2 = 600.0, 500.0, 1.354, 2.0


def drive(u, tau=0.0):
    return in_a_row(
        motor=Torque(tau=tau),
        rotor=Inertia(J=J_A),
        gear=SelectableGear(ratio_1=I_1, ratio_2=I_2, u=u),
        mandrel=Inertia(J=J_B),
    )


@pytest.mark.parametrize(("u", "ratio"), [(1.0, I_1), (2.0, I_2)])
def test_each_gear_reflects_the_rotor_with_its_ratio(u, ratio):
    run = lp.simulate(lp.assemble(drive(u, tau=1000.0)), until=2.0, rtol=1e-11)
    rate = 1000.0 * ratio / (J_B + J_A * ratio**2)
    assert run["mandrel.w"] == pytest.approx(rate * run.t, rel=1e-10, abs=1e-12)
    assert run["rotor.w"] == pytest.approx(ratio * run["mandrel.w"], rel=1e-12, abs=1e-12)
    assert run["gear.support.tau"] == pytest.approx(
        -run["gear.flange_a.tau"] - run["gear.flange_b.tau"], rel=1e-12
    )


def test_in_neutral_the_sides_do_not_know_of_each_other():
    run = lp.simulate(lp.assemble(drive(0.0, tau=1000.0)), until=2.0)
    assert run["rotor.w"] == pytest.approx(1000.0 / J_A * run.t, rel=1e-9, abs=1e-12)
    assert np.abs(run["mandrel.w"]).max() < 1e-13


def test_a_change_at_standstill_loses_nothing():
    u = where(lp.time >= 1.0, 2.0, 1.0)
    tau = where(lp.time >= 1.0, 1000.0, 0.0)
    run = lp.simulate(lp.assemble(drive(u, tau=tau)), until=3.0, rtol=1e-11)
    assert sum(event.loss for event in run.events) == 0
    rate = 1000.0 * I_2 / (J_B + J_A * I_2**2)
    assert run["mandrel.w"][-1] == pytest.approx(2.0 * rate, rel=1e-10)


@pytest.mark.parametrize(("first", "i", "second", "k"), [(1, I_1, 2, I_2), (2, I_2, 1, I_1)])
def test_a_change_while_turning_keeps_momentum_and_tells_its_loss(first, i, second, k):
    u, w = where(lp.time >= 1.0, float(second), float(first)), 50.0
    system = lp.assemble(drive(u))
    run = lp.simulate(system, until=2.0, start={"mandrel.w": w, "rotor.w": i * w}, rtol=1e-11)
    # an impulse P at side b gives P / k to the rotor: momentum J_b w_b + k J_a w_a is kept
    after = (J_B * w + k * J_A * i * w) / (J_B + k**2 * J_A)
    lost = (J_B + i**2 * J_A) * w**2 / 2 - (J_B + k**2 * J_A) * after**2 / 2
    assert run["mandrel.w"][-1] == pytest.approx(after, rel=1e-12)
    assert run["rotor.w"][-1] == pytest.approx(k * after, rel=1e-12)
    event = [event for event in run.events if event.component == "gear"]
    assert event[0].time == 1.0
    assert sum(e.loss for e in event) == pytest.approx(lost, rel=1e-10)
    assert lost > 0.01 * (J_B + i**2 * J_A) * w**2 / 2


def test_a_change_by_way_of_neutral_keeps_momentum_too():
    u = where(lp.time >= 1.5, 2.0, where(lp.time >= 1.0, 0.0, 1.0))
    run = lp.simulate(
        lp.assemble(drive(u)),
        until=2.0,
        start={"mandrel.w": 50.0, "rotor.w": 50.0 * I_1},
        rtol=1e-11,
    )
    after = (J_B + I_2 * J_A * I_1) * 50.0 / (J_B + I_2**2 * J_A)
    assert run["mandrel.w"][-1] == pytest.approx(after, rel=1e-12)
