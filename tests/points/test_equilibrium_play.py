"""Equilibria of drives with play."""

import numpy as np
import pytest
from drives_at_points import geared
from rows import assemble_row, in_a_row, in_rows

import lumped as lp
from lumped.components import Backlash, Brake, ElastoBacklash, Fixed, Inertia, SpringDamper, Torque


@pytest.mark.parametrize("torque", [5.0, -5.0])
@pytest.mark.parametrize("start", [{}, {"a.w": 100.0}, {"e.w": -20.0}])
def test_a_loaded_drive_with_play_turns_steadily_from_the_default_start(torque, start):
    point = lp.equilibrium(lp.assemble(geared(torque)), start=start)
    speed = next((w if n == "a.w" else 5.0 * w for n, w in start.items()), 0.0)
    assert [point["a.w"], 5.0 * point["e.w"]] == pytest.approx([speed] * 2, rel=1e-9, abs=1e-9)
    # the flank carries the motor's torque; its twist counts from the edge of the play
    expected = -np.sign(torque) * (0.005 + 5.0 / 1e3)
    assert point["play.phi_rel"] == pytest.approx(expected, rel=1e-9)
    assert point["shaft.phi_rel"] == pytest.approx(-5.0 * torque / 1e3, rel=1e-9)
    assert point.lost == ()


@pytest.mark.parametrize("torque", [5.0, -5.0])
@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_a_body_comes_to_rest_on_the_flank_of_a_play(torque, damping):
    system = assemble_row(
        wall=Fixed(),
        play=ElastoBacklash(c=100.0, d=damping, b=0.2),
        body=Inertia(J=1.0),
        load=Torque(tau=torque),
    )
    expected = np.sign(torque) * (0.1 + 5.0 / 100.0)
    for rest in (False, True):
        point = lp.equilibrium(system, rest=rest)
        assert point["play.phi_rel"] == pytest.approx(expected, rel=1e-9)
        assert point["body.w"] == pytest.approx(0.0, abs=1e-12)
    already = lp.equilibrium(system, start={"play.phi_rel": 1.2 * expected})
    assert already["play.phi_rel"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("torque", [8.0, -8.0])
def test_a_train_of_many_plays_is_driven_through(torque):
    count = 6
    model = in_rows(
        "motor first play/wheel load",
        motor=Torque(tau=torque),
        first=Inertia(J=1.0, w=50.0),
        play=[ElastoBacklash(c=1e3 * (i + 1), d=0.5, b=0.01 * (i + 1)) for i in range(count)],
        wheel=[Inertia(J=0.5 + i) for i in range(count)],
        load=Torque(tau=-torque),
    )
    point = lp.equilibrium(lp.assemble(model))
    for i in range(count):
        expected = -np.sign(torque) * (0.005 * (i + 1) + 8.0 / (1e3 * (i + 1)))
        assert point[f"play[{i}].phi_rel"] == pytest.approx(expected, rel=1e-8)
        assert point[f"wheel[{i}].w"] == pytest.approx(50.0, rel=1e-9)


def test_a_rigid_play_closes_on_the_way_to_an_equilibrium():
    model = in_a_row(
        wall=Fixed(),
        shaft=SpringDamper(c=100.0, d=1.0),
        a=Inertia(J=1.0),
        play=Backlash(b=0.2),
        b=Inertia(J=2.0),
        load=Torque(tau=5.0),
    )
    point = lp.equilibrium(lp.assemble(model))
    received = [point[n] for n in ("shaft.phi_rel", "play.phi_rel", "a.w", "b.w")]
    assert received == pytest.approx([0.05, 0.1, 0.0, 0.0], rel=1e-9, abs=1e-9)


def test_a_play_that_opens_is_no_steady_rotation():
    # nothing drives: both bodies turn at the given speed, and not one of them alone
    model = in_a_row(
        a=Inertia(J=1.0, w=100.0), play=ElastoBacklash(c=1e3, d=1.0, b=0.01), b=Inertia(J=10.0)
    )
    point = lp.equilibrium(lp.assemble(model))
    assert [point["a.w"], point["b.w"]] == pytest.approx([100.0, 100.0], rel=1e-12)
    assert abs(point["play.phi_rel"]) <= 0.005


def test_a_load_slides_until_a_spring_behind_a_gap_takes_what_friction_does_not_hold():
    model = in_a_row(
        wall=Fixed(),
        play=ElastoBacklash(c=100.0, d=1.0, b=0.2),
        body=Inertia(J=1.0),
        brake=Brake(f_max=2.0, u=1.0, characteristic=((0.0, 1.0),)),
        load=Torque(tau=5.0),
    )
    point = lp.equilibrium(lp.assemble(model))
    assert point["body.w"] == pytest.approx(0.0, abs=1e-12)
    # it rests where the spring takes from 5 - 2 to 5 + 2 N.m
    assert 0.1 + 3.0 / 100.0 - 1e-6 <= point["play.phi_rel"] <= 0.1 + 7.0 / 100.0 + 1e-6
