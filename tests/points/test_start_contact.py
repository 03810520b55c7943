"""Plays, stops and freewheels start in contact where what is demanded says so."""

import numpy as np
import pytest
from drives_at_points import Steady
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import Backlash, ElastoBacklash, Fixed, Inertia, OneWayClutch, Spring, Torque


def loaded_play(torque, **play):
    """A body behind a play of 0.2 rad with 100 N.m/rad, with a load."""
    return in_a_row(
        wall=Fixed(),
        play=ElastoBacklash(c=100.0, d=0.0, b=0.2, **play),
        body=Inertia(J=1.0, w=0.0),
        load=Torque(tau=torque),
    )


@pytest.mark.parametrize("torque", [5.0, -5.0])
def test_a_given_torque_of_a_play_twists_it_beyond_its_gap(torque):
    point = lp.start_point(lp.assemble(loaded_play(0.0, tau=torque)))
    expected = np.sign(torque) * (0.1 + abs(torque) / 100.0)
    assert point["play.phi_rel"] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("torque", [5.0, -5.0])
def test_a_loaded_play_starts_in_contact_where_nothing_shall_accelerate(torque):
    system = lp.assemble(loaded_play(torque))
    point = lp.start_point(system, start={"body.a": 0.0})
    expected = np.sign(torque) * (0.1 + abs(torque) / 100.0)
    assert point["play.phi_rel"] == pytest.approx(expected, rel=1e-12)
    run = lp.simulate(system, until=1.0, start={"body.a": 0.0}, grid=4)
    assert run["play.phi_rel"] == pytest.approx(np.full(5, expected), rel=1e-9)
    assert run.events == ()


def test_a_rigid_play_starts_closed_where_nothing_shall_accelerate():
    model = in_a_row(
        wall=Fixed(), play=Backlash(b=0.2), body=Inertia(J=1.0, w=0.0), load=Torque(tau=5.0)
    )
    point = lp.start_point(lp.assemble(model), start={"body.a": 0.0})
    assert point["play.phi_rel"] == pytest.approx(0.1, abs=1e-12)
    assert point["play.tau"] == pytest.approx(5.0, rel=1e-12)


@pytest.mark.parametrize("torque", [7.0, -7.0])
def test_several_plays_start_in_contact_one_behind_the_other(torque):
    count = 4
    model = in_rows(
        "wall play/body load",
        wall=Fixed(),
        play=[ElastoBacklash(c=100.0 * (i + 1), d=0.0, b=0.02 * (i + 1)) for i in range(count)],
        body=[Steady(J=1.0, w=0.0) for _ in range(count)],
        load=Torque(tau=torque),
    )
    point = lp.start_point(lp.assemble(model))
    for i in range(count):
        expected = np.sign(torque) * (0.01 * (i + 1) + abs(torque) / (100.0 * (i + 1)))
        assert point[f"play[{i}].phi_rel"] == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("part", [Backlash(b=0.2, phi_rel=-0.1), OneWayClutch(f_max=1e3, u=1.0)])
def test_a_closed_stop_and_a_locked_freewheel_carry_what_is_demanded(part):
    # a spring presses a body against the part, which takes what is left
    model = in_a_row(
        push=Torque(tau=6.0),
        a=Inertia(J=1.0, w=0.0),
        part=part,
        b=Steady(J=2.0),
        shaft=Spring(c=50.0),
        wall=Fixed(),
    )
    point = lp.start_point(lp.assemble(model))
    assert [point["a.a"], point["b.a"]] == pytest.approx([0.0, 0.0], abs=1e-9)
    assert point["shaft.tau"] == pytest.approx(-6.0, rel=1e-10)
