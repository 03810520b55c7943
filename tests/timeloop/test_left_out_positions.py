"""Positions that no state needs can be asked for after a run."""

import pickle

import numpy as np
import pytest

import lumped as lp
from lumped.components import Clutch, Inertia, Spring, Torque
from lumped.timeloop.left_out_positions import on_both_sides


class Swing(lp.Component):
    """Two free inertias and a spring; the second begins to move."""

    a: Inertia = Inertia(J=2.0, phi=0.3)
    shaft: Spring = Spring(c=300.0)
    b: Inertia = Inertia(J=1.0, w=6.0)

    def connections(self):
        yield from lp.chain(self.a, self.shaft, self.b)


def expected_angle(t):
    """Angle of the first inertia: mean motion less its share of the twist."""
    rate = np.sqrt(300.0 * (1 / 2.0 + 1 / 1.0))
    return 0.3 + 2.0 * t - 6.0 / rate * np.sin(rate * t) / 3


@pytest.mark.parametrize("method", ["exact", "explicit", "implicit", "taylor"])
def test_the_angle_of_an_accelerated_inertia_is_a_parabola(driven_mass, method):
    system = lp.assemble(driven_mass)
    assert system.state_names == ["body.w"]
    run = lp.simulate(system, until=4.0, grid=8, method=method)
    np.testing.assert_allclose(run["body.phi"], 0.5 * 1.5 * run.t**2, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("method", ["exact", "explicit", "implicit", "taylor"])
@pytest.mark.parametrize("grid", [20, None, [0.1, 0.7, 0.9]])
def test_an_oscillating_angle_is_integrated_to_the_tolerance(method, grid):
    run = lp.simulate(lp.assemble(Swing()), until=1.0, grid=grid, rtol=1e-8, method=method)
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
    system = lp.assemble(Swing())
    first = lp.simulate(system, until=0.4, rtol=1e-9)
    point = first.point(0.3)
    assert point["a.phi"] == pytest.approx(expected_angle(0.3), abs=1e-8)
    second = lp.simulate(system, until=1.0, start=point, rtol=1e-9)
    copy = pickle.loads(pickle.dumps(second))
    for run in (second, copy):
        assert np.abs(run["a.phi"] - expected_angle(run.t)).max() < 3e-8


def test_points_know_the_angles_with_which_they_begin():
    system = lp.assemble(Swing())
    assert lp.start_point(system, start={"a.phi": 0.7})["b.phi"] == pytest.approx(0.7)
    assert lp.equilibrium(system, start={"b.phi": 0.4})["a.phi"] == pytest.approx(0.4)
    held = lp.equilibrium(system, start={"a.phi": 0.7})
    run = lp.simulate(system, until=2.0, start=held)
    expected = 0.7 + held["a.w"] * run.t
    np.testing.assert_allclose(run["a.phi"], expected, rtol=1e-7)


def test_all_quantities_of_a_run_have_names(two_mass):
    run = lp.simulate(lp.assemble(two_mass), until=1.0)
    assert list(run) == run.system.names()
    assert all(np.isfinite(run[name]).all() for name in run)


def test_what_outputs_exclude_stays_unknown():
    run = lp.simulate(lp.assemble(Swing(), outputs=["a.w"]), until=0.1)
    assert "a.phi" not in run
    with pytest.raises(lp.errors.UnknownNameError, match=r"keep=.*a\.phi"):
        run["a.phi"]


def test_a_long_row_of_runs_forgets_the_angle_and_says_so():
    system = lp.assemble(Swing())
    point, found = lp.start_point(system), []
    for _ in range(22):
        run = lp.simulate(system, until=point.time + 0.01, start=point, grid=1)
        point = run.point(run.t[-1])
        found.append("a.phi" in run)
    assert found[:20] == [True] * 20
    with pytest.raises(lp.errors.UnknownNameError, match="keep="):
        run["a.phi"]


def test_a_jump_stands_at_the_instant_of_the_run_that_asks():
    times = np.array([0.0, 1.0, 1.0, 2.0, 2.0, 3.0])
    own = np.array([0.0, 1.0, 1.0, 1.0 + 1e-7, 1.0 + 1e-7, 2.0 - 1e-7, 2.0 - 1e-7, 2.0, 2.0, 3.0])
    y = np.where(np.arange(10) >= 4, 5.0, 0.0) + np.where(np.arange(10) >= 6, 7.0, 0.0)
    np.testing.assert_array_equal(on_both_sides(own, y, times), [0.0, 0.0, 5.0, 5.0, 12.0, 12.0])
