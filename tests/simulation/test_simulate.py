"""Simulation against closed forms."""

import numpy as np
import pytest
from checks import worst
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, Spring, Torque
from lumped.errors import SolverError
from lumped.ops import sin, table, where


@pytest.mark.parametrize("method", ["explicit", "implicit", "auto"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-7, 1e-10])
def test_a_free_vibration_stays_within_a_hundred_times_the_tolerance(two_mass, method, rtol):
    system = lp.assemble(two_mass)
    run = lp.simulate(system, until=3.0, start={"a.w": 1.5}, rtol=rtol, method=method)
    w = np.sqrt(300.0 * 1.5)
    expected = -1.5 / w * np.sin(w * run.t)
    assert worst(run["shaft.phi_rel"], expected) < 100 * rtol
    momentum = 2 * run["a.w"] + run["b.w"]
    assert worst(momentum, np.full_like(momentum, 3.0)) < 1e-10


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_the_steps_of_the_solver_and_a_grid_agree(two_mass, method):
    system = lp.assemble(two_mass)
    options = {"until": 2.0, "start": {"a.w": 1.0}, "rtol": 1e-9, "method": method}
    steps = lp.simulate(system, grid=None, **options)
    assert len(steps.t) == steps.steps + 1
    grid = lp.simulate(system, grid=steps.t, **options)
    assert worst(grid["b.w"], steps["b.w"]) < 1e-8
    between = (steps.t[1:] + steps.t[:-1]) / 2
    inside = lp.simulate(system, grid=between, **options)
    w = np.sqrt(300.0 * 1.5)
    assert worst(inside["shaft.phi_rel"], -np.sin(w * between) / w) < 1e-7


@pytest.mark.parametrize(("method", "order"), [("explicit", 7), ("implicit", 4)])
def test_the_error_falls_with_the_order_of_the_method(two_mass, method, order):
    system = lp.assemble(two_mass)
    w = np.sqrt(300.0 * 1.5)
    errors, steps = [], []
    for rtol in (1e-4, 1e-6, 1e-8):
        run = lp.simulate(
            system, until=2.0, start={"a.w": 1.0}, rtol=rtol, method=method, grid=[2.0]
        )
        errors.append(abs(run["shaft.phi_rel"][-1] + np.sin(w * 2.0) / w) * w)
        steps.append(run.steps)
    slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope > order


def test_a_torque_that_jumps_is_integrated_exactly():
    model = in_a_row(drive=Torque(tau=where(lp.time >= 0.3, 5.0, 1.0)), body=Inertia(J=2.0))
    run = lp.simulate(lp.assemble(model, keep=["body.phi"]), until=1.0, grid=20)
    assert [e.time for e in run.events] == [0.3]
    assert run.events[0].component == "drive.tau"
    expected = np.where(run.t < 0.3, 0.5 * run.t, 0.15 + 2.5 * (run.t - 0.3))
    assert worst(run["body.w"], expected) < 1e-14
    both = run["drive.tau"][run.t == 0.3]
    assert both.tolist() == [1.0, 5.0]
    assert len(run.t) == 22


def test_output_times_given_by_the_user_are_kept_exactly():
    model = in_a_row(drive=Torque(tau=table([0, 0.5, 0.5, 1], [0, 1, -1, -1])), body=Inertia(J=1.0))
    times = [0.0, 0.25, 0.5, 0.5000001, 0.75, 1.0]
    run = lp.simulate(lp.assemble(model), until=1.0, grid=times)
    assert run.t.tolist() == times
    assert run["drive.tau"] == pytest.approx([0, 0.5, -1, -1, -1, -1], abs=1e-12)
    expected = [0, 0.0625, 0.25, 0.25 - 1e-7, 0, -0.25]
    assert run["body.w"] == pytest.approx(expected, abs=1e-12)


def test_a_jump_at_the_end_is_seen(driven_mass):
    model = driven_mass.with_({"drive.tau": where(lp.time >= 1.0, 4.0, 2.0)})
    system = lp.assemble(model)
    run = lp.simulate(system, until=1.0, grid=2)
    assert run["drive.tau"].tolist() == [2.0, 2.0, 2.0, 4.0]
    assert lp.simulate(system, until=1.0, grid=[0.5, 1.0])["drive.tau"].tolist() == [2.0, 4.0]
    assert run["body.w"][-1] == pytest.approx(1.0, rel=1e-13)


def test_an_undamped_stiff_mode_that_nothing_excites_does_not_disturb_the_rest():
    model = in_a_row(
        a=Inertia(J=1.0, w=1.0),
        soft=Spring(c=100.0),
        b=Inertia(J=1e-3),
        stiff=Spring(c=1e9),
        c=Inertia(J=1.0),
    )
    run = lp.simulate(lp.assemble(model), until=2.0, rtol=1e-6, method="implicit")
    w = np.sqrt(100.0 * (1 + 1 / 1.001))
    print(run.statistics)
    assert worst(run["soft.phi_rel"], -np.sin(w * run.t) / w) < 1e-4


@pytest.mark.parametrize("grid", [500, None])
def test_a_run_into_infinity_keeps_only_finite_numbers(driven_mass, grid):
    system = lp.assemble(driven_mass.with_({"drive.tau": lp.ops.exp(lp.time)}))
    with pytest.raises(SolverError) as caught:
        lp.simulate(system, until=800.0, grid=grid)
    partial = caught.value.partial
    assert np.isfinite(partial.x).all()
    assert partial.t[-1] > 600


def test_states_that_the_absolute_tolerance_governs_are_named(driven_mass):
    model = driven_mass.with_({"drive.tau": 1e-7 * sin(10 * lp.time)})
    run = lp.simulate(lp.assemble(model), until=1.0)
    assert run.statistics.small == ("body.w",)
    assert "body.w" in repr(run).splitlines()[1]
    assert lp.simulate(lp.assemble(driven_mass), until=1.0).statistics.small == ()


def test_statistics_count_what_was_done(two_mass):
    run = lp.simulate(lp.assemble(two_mass), until=1.0, start={"a.w": 1.0}, grid=None)
    s = run.statistics
    assert s.steps == len(run.t) - 1
    assert s.evaluations == 12 * (s.steps + s.rejected) + 2  # the first step takes two
    assert f"{s.steps} steps" in repr(run)
    assert "rad/s" in repr(run)
