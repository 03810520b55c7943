"""Couplings that close and bodies picked up: momentum and energy across drive trains."""

import numpy as np
import pytest
from drive_chains import in_turn
from rows import assemble_row
from test_impact_shafts import at

import lumped as lp
from lumped.components import (
    Coupling,
    IdealGear,
    Inertia,
    PickUp,
    Torque,
)


def losses(run):
    return sum(event.loss for event in run.events)


# -- couplings ---------------------------------------------------------------------------------


@pytest.mark.parametrize("ratio", [1.0, 3.0, -2.0])
def test_a_coupling_closes_with_momentum_kept_through_a_gear(ratio):
    a, b, w, v = 0.7, 5.0, 40.0, 3.0
    system = assemble_row(
        motor=Inertia(J=a, w=w),
        coupling=Coupling(u=at(0.5) - at(0.8)),
        gear=IdealGear(ratio=ratio),
        load=Inertia(J=b, w=v),
    )
    run = lp.simulate(system, until=1.0, grid=[0.4, 0.6, 1.0])
    common = (a * w + b / ratio**2 * ratio * v) / (a + b / ratio**2)
    np.testing.assert_allclose(run["motor.w"], [w, common, common], rtol=1e-13)
    np.testing.assert_allclose(run["load.w"] * ratio, [v * ratio, common, common], rtol=1e-13)
    expected = a * w**2 / 2 + b * v**2 / 2 - (a + b / ratio**2) * common**2 / 2
    assert losses(run) == pytest.approx(expected, rel=1e-13)
    np.testing.assert_allclose(run["coupling.position"], [2.0, 0.0, 2.0])


def test_a_closed_coupling_carries_torque_and_lets_go_at_the_command():
    system = assemble_row(
        drive=Torque(tau=9.0),
        motor=Inertia(J=1.0, w=0.0),
        coupling=Coupling(u=1.0 - at(0.5)),
        load=Inertia(J=2.0),
    )
    run = lp.simulate(system, until=1.0, grid=[0.25, 1.0], rtol=1e-10)
    np.testing.assert_allclose(run["coupling.tau"], [-6.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(run["motor.w"][-1], 3.0 * 0.5 + 9.0 * 0.5, rtol=1e-12)
    np.testing.assert_allclose(run["load.w"][-1], 3.0 * 0.5, rtol=1e-12)


def test_couplings_in_a_chain_close_one_after_another_and_together():
    J, w = np.array([1.0, 2.0, 0.5, 4.0, 3.0]), np.array([10.0, -3.0, 25.0, 1.0, 0.0])
    closing = [0.1, 0.3, 0.1, 0.2]
    discs = [Inertia(J=j, w=v) for j, v in zip(J, w, strict=True)]
    system = lp.assemble(in_turn(bodies=discs, couplings=[Coupling(u=at(t)) for t in closing]))
    run = lp.simulate(system, until=0.4, grid=[0.05, 0.15, 0.25, 0.35])
    received = np.array([run[f"bodies[{i}].w"] for i in range(5)]).T

    def joined(*groups):
        found = np.empty(5)
        for group in groups:
            own = list(group)
            found[own] = J[own] @ w[own] / J[own].sum()
        return found

    expected = [w, joined((0, 1), (2, 3), (4,)), joined((0, 1), (2, 3, 4)), joined((0, 1, 2, 3, 4))]
    np.testing.assert_allclose(received, expected, rtol=1e-12, atol=1e-14 * 25)
    assert losses(run) == pytest.approx(J @ w**2 / 2 - (J @ w) ** 2 / J.sum() / 2, rel=1e-12)


# -- bodies picked up --------------------------------------------------------------------------


def test_a_turning_arm_picks_a_body_up_and_puts_it_down():
    arm, body, w = 3.0, 1.5, 2.0
    system = assemble_row(arm=Inertia(J=arm, w=w), load=PickUp(J=body, u=at(0.5) - at(1.0)))
    run = lp.simulate(system, until=1.5, grid=[0.4, 0.6, 1.5])
    slow = w * arm / (arm + body)
    np.testing.assert_allclose(run["arm.w"], [w, slow, slow], rtol=1e-13)
    np.testing.assert_allclose(run["load.w"], [0.0, slow, 0.0], rtol=1e-13)
    np.testing.assert_allclose(run["load.position"], [2.0, 0.0, 2.0])
    expected = [arm * w**2 / 2 * body / (arm + body), body * slow**2 / 2]
    received = [event.loss for event in run.events if event.loss]
    np.testing.assert_allclose(received, expected, rtol=1e-13)


def test_a_coupling_that_is_closed_from_the_start_makes_speeds_equal_at_once():
    system = assemble_row(
        a=Inertia(J=1.0, w=9.0), coupling=Coupling(u=1.0), b=Inertia(J=2.0, w=0.0)
    )
    run = lp.simulate(system, until=1.0)
    (event,) = run.events
    assert (event.time, event.component) == (0.0, "coupling")
    assert event.loss == pytest.approx(1.0 * 2.0 / 3.0 / 2 * 9.0**2, rel=1e-13)
    np.testing.assert_allclose(run["a.w"], 3.0, rtol=1e-13)
    np.testing.assert_allclose(run["b.w"], 3.0, rtol=1e-13)
