"""A synchroniser against the impulse of its cones; the dogs lock without an impact."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, Synchroniser, Torque

CONES = {"f_max": 900.0, "mu": 0.1, "R": 0.035, "alpha": np.radians(6.5), "n": 2.0}
GRIP = 0.1 * 2 * 0.035 * 900.0 / np.sin(np.radians(6.5))  # N.m
J_A, J_B = 0.02, 0.5


def box(w_a, w_b, u, load=0.0, **given):
    return in_a_row(
        wheel=Inertia(J=J_A, w=w_a),
        shift=Synchroniser(**CONES, u=u, **given),
        shaft=Inertia(J=J_B, w=w_b),
        load=Torque(tau=load),
    )


def shift(model, until, grid=2000):
    return lp.simulate(lp.assemble(model), until=until, grid=grid, rtol=1e-10)


@pytest.mark.parametrize("w_a", [300.0, 50.0])
def test_cones_bring_the_speeds_together_with_momentum_kept(w_a):
    w_b = 120.0
    run = shift(box(w_a, w_b, 1.0), 1.0)
    common = (J_A * w_a + J_B * w_b) / (J_A + J_B)
    instant = abs(w_b - w_a) * J_A * J_B / (J_A + J_B) / GRIP
    locks = [e for e in run.events if "position**2" in e.after]
    assert locks[0].time == pytest.approx(instant, rel=1e-9)
    assert all(event.loss == pytest.approx(0.0, abs=1e-9) for event in run.events)
    after = run.t > instant
    assert run["wheel.w"][after] == pytest.approx(common, rel=1e-9)
    assert run["shift.locked"][-1] == 1.0


def test_locked_dogs_carry_more_than_the_cones_and_open_without_force():
    pressed = lp.ops.where(lp.time >= 0.6, 0.0, 1.0)
    load = lp.ops.where(lp.time >= 0.3, -50 * GRIP, 0.0)
    run = shift(box(200.0, 100.0, pressed, load), 0.8)
    held = (run.t > 0.31) & (run.t < 0.59)
    assert np.abs(run["shift.w_rel"][held]).max() < 1e-9
    share = -50 * GRIP * J_A / (J_A + J_B)
    assert share < -1.5 * GRIP
    assert run["shift.tau"][held] == pytest.approx(share, rel=1e-9)
    free = run.t > 0.61
    assert run["shift.tau"][free] == pytest.approx(0.0, abs=1e-12)
    assert np.ptp(run["wheel.w"][free]) < 1e-9


def test_it_does_not_lock_against_a_greater_torque():
    model = box(0.0, 100.0, 1.0)
    drag = in_a_row(
        pull=Torque(tau=-1.2 * GRIP),
        wheel=Inertia(J=J_A, w=0.0),
        shift=Synchroniser(**CONES, u=1.0),
        shaft=Inertia(J=J_B, w=100.0),
    )
    assert shift(model, 0.3)["shift.locked"][-1] == 1.0
    run = shift(drag, 0.3)
    assert run["shift.locked"].max() == 0.0
    assert run["wheel.w"] == pytest.approx(-0.2 * GRIP / J_A * run.t, rel=1e-9, abs=1e-9)


def test_it_starts_locked_where_that_is_given():
    run = shift(box(100.0, 100.0, 1.0, load=-60 * GRIP, locked=1.0), 0.1)
    assert np.abs(run["shift.w_rel"]).max() < 1e-12
    assert run["wheel.w"] == pytest.approx(100 - 60 * GRIP / (J_A + J_B) * run.t, rel=1e-9)
