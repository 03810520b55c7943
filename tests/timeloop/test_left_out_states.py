"""States that no output needs can be asked for after a run."""

import pickle
import sys

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped.components import Clutch, Damper, Fixed, Inertia, Spring, Torque
from lumped.timeloop.results.operating_point import on_both_sides


def swing():
    """Two free inertias and a spring; the second begins to move."""
    return assemble_row(a=Inertia(J=2.0, phi=0.3), shaft=Spring(c=300.0), b=Inertia(J=1.0, w=6.0))


def expected_angle(t):
    """Angle of the first inertia: mean motion less its share of the twist."""
    rate = np.sqrt(300.0 * (1 / 2.0 + 1 / 1.0))
    return 0.3 + 2.0 * t - 6.0 / rate * np.sin(rate * t) / 3


@pytest.mark.parametrize("method", ["exact", "explicit", "implicit", "taylor"])
@pytest.mark.parametrize("grid", [20, None, [0.1, 0.7, 0.9]])
def test_an_oscillating_angle_is_integrated_to_the_tolerance(method, grid):
    run = lp.simulate(swing(), until=1.0, grid=grid, rtol=1e-8, method=method)
    assert "a.phi" not in run.system.state_names
    assert np.abs(run["a.phi"] - expected_angle(run.t)).max() < 3e-8
    np.testing.assert_allclose(run["b.phi"] - run["a.phi"], run["shaft.phi_rel"], atol=1e-12)


class Closing(lp.Component):
    """A driven inertia, and one at rest, which a clutch joins after a while."""

    drive: Torque = Torque(tau=3.0)
    a: Inertia = Inertia(J=2.0, w=10.0)
    clutch: Clutch = Clutch(f_max=16.0, u=lp.ops.where(lp.time >= 0.5, 1.0, 0.0))
    b: Inertia = Inertia(J=1.0, phi=-1.0, w=0.0)

    def connections(self):
        yield from lp.chain(self.drive, self.a, self.clutch, self.b)


def test_an_angle_that_was_left_out_is_that_of_a_run_that_keeps_it():
    left_out = lp.simulate(lp.assemble(Closing()), until=3.0, grid=30)
    kept = lp.simulate(lp.assemble(Closing(), keep=["a.phi", "b.phi"]), until=3.0, grid=30)
    assert len(kept.events) > 1
    for name in ("a.phi", "b.phi"):
        assert name not in left_out.system.state_names
        received = np.interp(kept.t, left_out.t, left_out[name])
        assert np.abs(received - kept[name]).max() < 1e-5
    slips = left_out.t < 0.5
    np.testing.assert_allclose(
        left_out["a.phi"][slips], 10 * left_out.t[slips] + 0.75 * left_out.t[slips] ** 2, atol=1e-8
    )
    np.testing.assert_array_equal(left_out["b.phi"][slips], -1.0)


def test_angles_go_on_where_a_run_goes_on_from_another():
    system = swing()
    first = lp.simulate(system, until=0.4, rtol=1e-9)
    point = first.point(0.3)
    assert point["a.phi"] == pytest.approx(expected_angle(0.3), abs=1e-8)
    second = lp.simulate(system, until=1.0, start=point, rtol=1e-9)
    copy = pickle.loads(pickle.dumps(second))
    for run in (second, copy):
        assert np.abs(run["a.phi"] - expected_angle(run.t)).max() < 3e-8


def test_points_know_the_angles_with_which_they_begin():
    system = swing()
    assert lp.start_point(system, start={"a.phi": 0.7})["b.phi"] == pytest.approx(0.7)
    assert lp.equilibrium(system, start={"b.phi": 0.4})["a.phi"] == pytest.approx(0.4)
    held = lp.equilibrium(system, start={"a.phi": 0.7})
    run = lp.simulate(system, until=2.0, start=held)
    expected = 0.7 + held["a.w"] * run.t
    np.testing.assert_allclose(run["a.phi"], expected, rtol=1e-7)


class Apart(lp.Component):
    """A brake, and apart from it an inertia under a torque that jumps from -2 to 8 N.m."""

    brake: Inertia = Inertia(J=2.0, w=3.0)
    oil: Damper = Damper(d=0.3)
    ground: Fixed = Fixed()
    push: Torque = Torque(tau=lp.ops.where(lp.time >= 0.5, 8.0, -2.0))
    load: Inertia = Inertia(J=4.0, phi=0.2, w=1.0)

    def connections(self):
        yield from lp.chain(self.brake, self.oil, self.ground)
        yield from lp.chain(self.push, self.load)


@pytest.mark.parametrize("method", ["exact", "explicit", "implicit"])
@pytest.mark.parametrize("grid", [20, None, [0.1, 0.5, 0.9]])
def test_what_no_output_needs_is_integrated_when_it_is_asked_for(method, grid):
    system = lp.assemble(Apart(), of=["brake.w"])
    assert system.state_names == ["brake.w"]
    run = lp.simulate(system, until=1.0, grid=grid, rtol=1e-9, method=method)
    t, late = run.t, np.maximum(run.t - 0.5, 0.0)
    expected = {
        "load.w": 1.0 - 0.5 * t + 2.5 * late,
        "load.phi": 0.2 + t - 0.25 * t**2 + 1.25 * late**2,
        "brake.phi": 3.0 * (1 - np.exp(-0.15 * t)) / 0.15,
        "oil.tau": -0.9 * np.exp(-0.15 * t),
    }
    worst = max(np.abs(run[name] - y).max() for name, y in expected.items())
    assert worst < 1e-8
    at_jump = np.flatnonzero(np.diff(t) == 0)
    assert len(at_jump) == (0 if isinstance(grid, list) else 1)
    np.testing.assert_allclose(run["load.a"][at_jump], -0.5)
    np.testing.assert_allclose(run["load.a"][at_jump + 1], 2.0)
    assert run.point(t[-1])["load.w"] == pytest.approx(expected["load.w"][-1], abs=1e-8)


def test_every_run_of_a_long_row_knows_its_angle():
    system = swing()
    point, runs = lp.start_point(system), []
    for k in range(150):
        run = lp.simulate(system, until=0.01 * (k + 1), start=point, grid=2, rtol=1e-9)
        point = run.point(run.t[-1])
        runs.append(run)
    copy = pickle.loads(pickle.dumps(runs[-1]))
    branch = lp.simulate(system, until=1.7, start=runs[119].point(1.195), rtol=1e-9)
    for run in (runs[-1], *runs[::30], copy, branch):
        assert run["a.phi"] == pytest.approx(expected_angle(run.t), abs=1e-7)


def test_a_row_may_be_longer_than_python_can_call_itself():
    system = lp.assemble(lp.compose(body=Inertia(J=1.0, w=2.0)))
    point = lp.start_point(system)
    for k in range(400):
        run = lp.simulate(system, until=0.5 * (k + 1), start=point, grid=1, method="exact")
        point = run.point(run.t[-1])
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(300)
    try:
        assert pickle.loads(pickle.dumps(run))["body.phi"][-1] == pytest.approx(2.0 * run.t[-1])
    finally:
        sys.setrecursionlimit(limit)


def test_a_jump_stands_at_the_instant_of_the_run_that_asks():
    times = np.array([0.0, 1.0, 1.0, 2.0, 2.0, 3.0])
    own = np.array([0.0, 1.0, 1.0, 1.0 + 1e-7, 1.0 + 1e-7, 2.0 - 1e-7, 2.0 - 1e-7, 2.0, 2.0, 3.0])
    y = np.where(np.arange(10) >= 4, 5.0, 0.0) + np.where(np.arange(10) >= 6, 7.0, 0.0)
    np.testing.assert_array_equal(on_both_sides(own, y, times), [0.0, 0.0, 5.0, 5.0, 12.0, 12.0])
