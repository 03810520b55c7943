"""Turning points of runs, against closed forms."""

import numpy as np
import pytest
from linkages import pendulum
from rows import assemble_row, in_rows

import lumped as lp
from lumped.components import Fixed, Inertia, Spring, SpringDamper, Torque
from lumped.errors import OptionError, SolverError
from lumped.life import rainflow, turning_points
from lumped.ops import where


@pytest.fixture(scope="module")
def swinging():
    return assemble_row(
        ground=Fixed(), spring=SpringDamper(c=100.0, d=0.4, phi_rel=0.5), body=Inertia(J=1.0)
    )


DECAY = np.exp(-np.pi * 0.02 / np.sqrt(1 - 0.02**2))  # of half a period


@pytest.mark.parametrize("method", ["explicit", "implicit", "taylor"])
def test_a_free_vibration_turns_where_its_formula_does(swinging, method):
    run = lp.simulate(swinging, until=10.0, grid=None, rtol=1e-9, method=method)
    found = turning_points(run, "spring.phi_rel", rtol=1e-8)
    wanted = 0.5 * (-DECAY) ** np.arange(32)
    assert found[:-1] == pytest.approx(wanted, abs=1e-8)
    assert found[-1] == pytest.approx(run["spring.phi_rel"][-1], abs=1e-8)


@pytest.mark.parametrize("grid", [500, 77, 12])
def test_a_grid_need_not_meet_them(swinging, grid):
    run = lp.simulate(swinging, until=10.0, grid=grid, rtol=1e-9)
    found = turning_points(run, "spring.phi_rel")
    error = np.abs(found[:-1] - 0.5 * (-DECAY) ** np.arange(32)).max()
    assert error < 1e-6
    recorded = rainflow(run["spring.phi_rel"])
    assert recorded.ranges.max() < rainflow(found).ranges.max()


def test_points_that_no_motion_joins_are_refused(swinging):
    run = lp.simulate(swinging, until=100.0, grid=20, rtol=0.3, atol=0.3, method="explicit")
    with pytest.raises(SolverError, match=r"spring.phi_rel is off by .*grid=None"):
        turning_points(run, "spring.phi_rel")


def test_both_sides_of_a_jump_count():
    """A torque that steps: it is its own turning points; the twist follows a known formula."""
    step = assemble_row(
        load=Torque(tau=where(lp.time >= 0.5, 7.0, where(lp.time >= 0.2, 2.0, 0.0))),
        body=Inertia(J=1.0),
        spring=Spring(c=(2 * np.pi) ** 2),
        ground=Fixed(),
    )
    run = lp.simulate(step, until=1.0, grid=None)
    assert turning_points(run, "load.tau") == pytest.approx([0.0, 7.0])
    torque = run.system.key("body.a")
    found = turning_points(run, torque)
    # the acceleration jumps by 2 at 0.2 s and by 5 at 0.5 s, and is a cosine between
    before = 2 * np.cos(2 * np.pi * 0.3)
    after = before + 5
    assert found[:2] == pytest.approx([0.0, 2.0], abs=1e-6)
    assert np.abs(found - before).min() < 1e-5
    assert np.abs(found - after).min() < 1e-5


def test_another_state_may_lead():
    """A pendulum that turns over, in coordinates across and down: top and bottom in turn."""
    run = lp.simulate(lp.assemble(pendulum(v=12.0)), until=4.0, grid=None, rtol=1e-9)
    assert len({id(piece.system) for piece in run.pieces}) > 1
    found = turning_points(run, "down.s")
    wanted = 2.0 * (-1.0) ** np.arange(len(found) - 1)
    assert len(found) > 6
    assert found[:-1] == pytest.approx(wanted, abs=1e-6)


def test_a_formula_turns_where_its_quantities_do(swinging):
    spring = swinging.model.spring
    run = lp.simulate(swinging, until=3.0, grid=None, rtol=1e-9)
    found = turning_points(run, 3 * spring.phi_rel + 1)
    assert found == pytest.approx(3 * turning_points(run, "spring.phi_rel") + 1, abs=1e-9)


def test_what_does_not_turn_has_two(swinging):
    run = lp.simulate(swinging, until=0.2, grid=None)
    assert len(turning_points(run, "spring.phi_rel")) == 2
    assert turning_points(run, "ground.flange.phi").tolist() == [0.0, 0.0]


def test_slips_are_named(swinging):
    run = lp.simulate(swinging, until=0.1, grid=None)
    with pytest.raises(OptionError, match="rtol = 2"):
        turning_points(run, "spring.tau", rtol=2.0)
    with pytest.raises(lp.errors.UnknownNameError, match=r"spring\.ta"):
        turning_points(run, "spring.ta")


@pytest.mark.parametrize("options", [{"grid": None}, {"grid": 50, "method": "exact"}])
def test_rounding_does_not_turn(options):
    """Two springs that swing alike, by other numbers: their difference is rounding."""
    model = in_rows(
        "ground soft light",
        "ground stiff heavy",
        ground=Fixed(),
        soft=Spring(c=100.0, phi_rel=0.5),
        light=Inertia(J=1.0),
        stiff=Spring(c=300.0, phi_rel=0.5),
        heavy=Inertia(J=3.0),
    )
    run = lp.simulate(lp.assemble(model), until=10.0, **options)
    found = turning_points(run, model.soft.phi_rel - model.stiff.phi_rel)
    assert len(found) == 2
    assert np.abs(found).max() < 1e-9
