"""What is given to an equilibrium: what it keeps, and what it names as lost."""

import numpy as np
import pytest
from drives_at_points import geared
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import Damper, Fixed, Inertia, Torque


def test_a_given_speed_stays_although_a_given_twist_cannot():
    system = lp.assemble(geared())
    point = lp.equilibrium(system, start={"a.w": 100.0, "play.phi_rel": -0.006})
    assert [point["a.w"], point["e.w"]] == pytest.approx([100.0, 20.0], rel=1e-12)
    assert point["play.phi_rel"] == pytest.approx(-0.01, rel=1e-9)
    assert point.lost == ("play.phi_rel = -0.006 rad",)
    assert "not kept, as no equilibrium near the start does: play.phi_rel = -0.006" in repr(point)
    both = lp.equilibrium(system, start={"a.w": 100.0, "play.phi_rel": -0.01})
    assert [both["a.w"], both["play.phi_rel"]] == pytest.approx([100.0, -0.01], rel=1e-9)
    assert both.lost == ()


def test_what_is_asked_for_comes_before_what_instances_were_given():
    system = lp.assemble(geared(**{"a.w": 100.0}))
    point = lp.equilibrium(system, start={"e.w": 7.0})
    assert [point["a.w"], point["e.w"]] == pytest.approx([35.0, 7.0], rel=1e-12)
    assert point.lost == ("a.w = 100 rad/s",)


def test_an_initial_equation_that_no_equilibrium_keeps_is_named():
    model = in_a_row(
        push=Torque(tau=4.0),
        body=Inertia(J=0.5),
        brake=Damper(d=2.0),
        wall=Fixed(),
        initial_equations=lambda m: [m.body.w == 50.0],
    )
    point = lp.equilibrium(lp.assemble(model))
    assert point["body.w"] == pytest.approx(2.0, rel=1e-10)
    (lost,) = point.lost
    assert "initial equation" in lost
    assert "body.w" in lost


def test_an_equilibrium_knows_its_time():
    torque = lp.ops.where(lp.time >= 1.0, 4.0, 0.0)
    system = assemble_row(
        push=Torque(tau=torque), body=Inertia(J=0.5), brake=Damper(d=2.0), wall=Fixed()
    )
    point = lp.equilibrium(system, time=1.0)
    assert point.time == 1.0
    run = lp.simulate(system, until=3.0, start=point, grid=4)
    assert run.t[0] == 1.0
    assert run["body.w"] == pytest.approx(np.full(5, 2.0), rel=1e-9)
