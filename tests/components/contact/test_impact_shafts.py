"""Rigid play in drive trains: instants, momentum, energy."""

import numpy as np
import pytest
from drive_chains import in_turn
from rows import assemble_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Backlash, Damper, Fixed, IdealGear, Inertia, Torque


def at(instant):
    """A command that becomes 1."""
    return lp.ops.where(lp.time >= instant, 1, 0)


def test_two_discs_with_play_meet_at_the_instants_of_the_closed_form():
    a, b, w, play, e = 1.0, 2.0, 10.0, 0.2, 0.5
    system = assemble_row(
        a=Inertia(J=a, w=w), play=Backlash(b=play, restitution=e), b=Inertia(J=b, w=0.0)
    )
    run = lp.simulate(system, until=1.0, start={"play.phi_rel": 0.0})
    hits = [event for event in run.events if event.loss]
    n = np.arange(len(hits))
    flights = np.concatenate([[play / 2 / w], play / (w * e ** n[1:])])
    np.testing.assert_allclose([h.time for h in hits], np.cumsum(flights), rtol=1e-11)
    reduced = a * b / (a + b)
    expected = reduced / 2 * (w * e**n) ** 2 * (1 - e**2)
    np.testing.assert_allclose([h.loss for h in hits], expected, rtol=1e-11)
    assert run["a.w"][-1] * a + run["b.w"][-1] * b == pytest.approx(a * w, rel=1e-12)


def test_an_impact_in_a_gear_train_shakes_everything_that_is_rigid_with_it():
    # the play stands between two gears; the impulse passes both by their ratios
    J, ratios, w, e = (0.5, 3.0, 40.0), (4.0, 2.5), 30.0, 0.3
    system = assemble_row(
        motor=Inertia(J=J[0], w=w),
        first=IdealGear(ratio=ratios[0]),
        middle=Inertia(J=J[1]),
        play=Backlash(b=0.01, restitution=e, phi_rel=0.0),
        last=IdealGear(ratio=ratios[1]),
        load=Inertia(J=J[2], w=0.0),
    )
    run = lp.simulate(system, until=1e-3, grid=[0.0, 1e-3])
    (hit,) = [event for event in run.events if event.loss]
    here, there = J[1] + J[0] * ratios[0] ** 2, J[2] / ratios[1] ** 2
    before = w / ratios[0]
    common = here * before / (here + there)
    # speeds at the play: common speed, and its deviation reversed and reduced
    driving = common - e * (before - common)
    driven = common + e * common
    assert run["motor.w"][-1] == pytest.approx(driving * ratios[0], rel=1e-12)
    assert run["load.w"][-1] == pytest.approx(driven / ratios[1], rel=1e-12)
    reduced = here * there / (here + there)
    assert hit.loss == pytest.approx(reduced / 2 * before**2 * (1 - e**2), rel=1e-12)


@pytest.mark.parametrize(("seed", "restitution"), [(0, 0.2), (3, 0.5), (5, 0.0)])
def test_ten_rattling_gears_enter_no_flank_and_keep_their_books(seed, restitution):
    rng, d = np.random.default_rng(seed), 0.2
    J, play, ratio = (rng.uniform(*of) for of in ((0.05, 0.5, 10), (0.005, 0.02, 9), (0.5, 2.0, 9)))
    model = in_turn(
        {"bearing": Damper(d=d), "ground": Fixed()},
        {"drive": (Torque(tau=8.0 * lp.ops.sin(40.0 * lp.time)), "discs", 0)},
        discs=[Inertia(J=j) for j in J.tolist()],
        plays=[Backlash(b=b, restitution=restitution) for b in play.tolist()],
        gears=[IdealGear(ratio=r) for r in ratio.tolist()],
    )
    run = lp.simulate(lp.assemble(model), until=0.5, rtol=1e-9)
    for i, b in enumerate(play):
        assert np.abs(run[f"plays[{i}].phi_rel"]).max() <= b / 2 + 1e-9
    supplied = -run.value(fun.integral("drive.flange.tau", "discs[0].w"))
    heat = d * run.value(fun.integral("discs[9].w", "discs[9].w"))
    stored = sum(j / 2 * run[f"discs[{i}].w"][-1] ** 2 for i, j in enumerate(J))
    times, each = np.unique([e.time for e in run.events], return_inverse=True)
    lost = np.bincount(each, weights=[e.loss for e in run.events])
    turned = lost.sum() + heat
    assert len(times) > 20
    assert lost.min() >= -1e-12 * turned
    assert supplied == pytest.approx(stored + turned, abs=1e-7 * turned)


def test_flanks_carry_the_torque_that_the_load_needs():
    system = assemble_row(
        drive=Torque(tau=6.0),
        motor=Inertia(J=1.0, w=0.0),
        play=Backlash(b=0.02, phi_rel=0.01),
        load=Inertia(J=2.0, w=0.0),
    )
    # flange b leads: first the motor has to cross the play, then it pushes at the back flank
    run = lp.simulate(system, until=1.0, rtol=1e-10)
    (hit,) = [event for event in run.events if event.loss]
    assert hit.time == pytest.approx(np.sqrt(2 * 0.02 / 6.0), rel=1e-11)
    assert run["play.tau"][-1] == pytest.approx(-4.0, rel=1e-12)
    assert run["play.phi_rel"][-1] == pytest.approx(-0.01, abs=1e-12)
