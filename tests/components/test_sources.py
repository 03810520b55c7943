"""Sources that follow a signal, accelerate, or move between two flanges; bodies with length."""

import numpy as np
import pytest
from rows import assemble_row, in_a_row

import lumped as lp
from lumped.components import (
    Acceleration,
    FilteredPosition,
    FilteredSpeed,
    Inertia,
    RelativeSpeed,
    translation,
)

F_CRIT = 5.0
STEP = lp.ops.where(lp.time >= 0.1, 2.0, 0.0)


def moved(source):
    return assemble_row(source=source, body=Inertia(J=3.0), keep=["body.phi", "source.flange.tau"])


def test_a_filtered_position_follows_a_step_as_two_equal_lags_do():
    system = moved(FilteredPosition(f_crit=F_CRIT, phi_ref=STEP))
    run = lp.simulate(system, until=0.5, rtol=1e-10, atol=1e-12)
    corner = 2 * np.pi * F_CRIT / np.sqrt(np.sqrt(2) - 1)
    z = corner * np.maximum(run.t - 0.1, 0)
    expected = 2.0 * (1 - (1 + z) * np.exp(-z))
    error = np.abs(run["body.phi"] - expected).max()
    assert error < 1e-8
    # the torque is that of the acceleration, twice the corner squared just after the step
    after = run.t > 0.1
    push = 3.0 * 2.0 * corner**2 * (1 - z) * np.exp(-z)
    received = -run["source.flange.tau"]
    assert np.abs(received - push)[after].max() < 1e-7 * np.abs(push).max()


def test_a_filtered_speed_follows_a_step_as_a_lag_does():
    system = moved(FilteredSpeed(f_crit=F_CRIT, w_ref=STEP))
    run = lp.simulate(system, until=0.5, rtol=1e-10, atol=1e-12)
    z = 2 * np.pi * F_CRIT * np.maximum(run.t - 0.1, 0)
    assert np.abs(run["body.w"] - 2.0 * (1 - np.exp(-z))).max() < 1e-8


@pytest.mark.parametrize(("kind", "name"), [(FilteredPosition, "phi"), (FilteredSpeed, "w")])
def test_at_the_critical_frequency_half_of_the_power_is_left(kind, name):
    system = moved(kind(f_crit=F_CRIT, **{f"{name}_ref": 0.0}))
    found = lp.frequency_response(
        system, inputs=[f"source.{name}_ref"], outputs=[f"source.{name}"], hertz=[0.01, F_CRIT]
    )
    received = np.abs(found[f"source.{name}", f"source.{name}_ref"])
    assert received == pytest.approx([1.0, np.sqrt(0.5)], rel=1e-5)


def test_an_acceleration_gives_speed_and_way_and_takes_the_force_for_it():
    source = Acceleration(a=0.6 * lp.time, w=-0.2, phi=0.5)
    run = lp.simulate(moved(source), until=2.0, rtol=1e-10, atol=1e-12)
    assert run["body.w"] == pytest.approx(-0.2 + 0.3 * run.t**2, abs=1e-9)
    assert run["body.phi"] == pytest.approx(0.5 - 0.2 * run.t + 0.1 * run.t**3, abs=1e-9)
    assert -run["source.flange.tau"] == pytest.approx(1.8 * run.t, abs=1e-9)


def test_a_speed_between_two_bodies_keeps_their_momentum():
    rel = 0.5 * lp.ops.sin(3 * lp.time)
    model = in_a_row(
        a=Inertia(J=3.0),
        between=RelativeSpeed(w=rel),
        b=Inertia(J=1.0),
    )
    run = lp.simulate(lp.assemble(model), until=4.0, rtol=1e-10, start={"a.w": 1.0})
    expected = 0.5 * np.sin(3 * run.t)
    assert run["b.w"] - run["a.w"] == pytest.approx(expected, abs=1e-12)
    momentum = 3.0 * run["a.w"] + run["b.w"]
    assert np.ptp(momentum) < 1e-8
    # what the source gives is the reduced mass times the relative acceleration
    force = 3.0 * 1.0 / 4.0 * 1.5 * np.cos(3 * run.t)
    assert -run["between.tau"] == pytest.approx(force, abs=1e-8)


def test_rods_and_bodies_with_length_stand_one_behind_the_other():
    model = in_a_row(
        wall=translation.Fixed(s0=0.1),
        rod=translation.Rod(length=0.4),
        body=translation.MassWithLength(m=2.0, length=0.6),
        spring=translation.Spring(c=100.0, s_rel0=0.5),
        end=translation.Rod(length=-0.2),
        pull=translation.Force(f=20.0),
    )
    names = ["body.s", "spring.flange_b.s", "end.flange_b.s", "wall.flange.f"]
    point = lp.start_point(lp.assemble(model, keep=names))
    received = [point[name] for name in names]
    stretched = 1.1 + 0.5 + 20.0 / 100.0
    assert received == pytest.approx([0.5 + 0.3, stretched, stretched - 0.2, 20.0], abs=1e-12)
