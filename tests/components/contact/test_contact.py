"""Elastic play and gaps against closed forms, and their energy."""

import numpy as np
import pytest
from rows import assemble_row
from scipy.optimize import brentq

import lumped as lp
from lumped.components import ElastoBacklash, Fixed, Inertia, Torque, translation

J, C, D, PLAY, SPEED = 2.0, 5000.0, 30.0, 0.1, 3.0
FADE = D / (2 * J)
W = np.sqrt(C / J - FADE**2)
FREE = PLAY / 2 / SPEED
"""Time to the first flank, s."""


def disc(direction=1.0, **options):
    """A disc in the middle of its play, moving towards a flank."""
    return assemble_row(
        wall=Fixed(),
        play=ElastoBacklash(c=C, b=PLAY, **options),
        disc=Inertia(J=J, phi=0.0, w=direction * SPEED),
    )


def damped(x, v, t):
    """Free damped motion from a twist and a speed: twist, speed, acceleration."""
    a, b = x, (v + FADE * x) / W
    sine, cosine, fade = np.sin(W * t), np.cos(W * t), np.exp(-FADE * t)
    x = fade * (a * cosine + b * sine)
    v = -FADE * x + fade * W * (b * cosine - a * sine)
    return x, v, -(C * x + 2 * FADE * J * v) / J


def release(limited):
    """Time from contact to release, and the speed then."""
    if not limited:
        # the flank lets go where c e + d v = -J a = 0
        t = (np.pi - np.arctan2(2 * FADE * W, W**2 - FADE**2)) / W
        return t, damped(0.0, SPEED, t)[1]
    # the damping part is first limited to the elastic one, which doubles the stiffness
    w = np.sqrt(2 * C / J)
    first = np.arctan(D * w / C) / w
    x, v = SPEED / w * np.sin(w * first), SPEED * np.cos(w * first)
    second = brentq(lambda t: damped(x, v, t)[2], 1e-6, np.pi / W, xtol=1e-15)
    return first + second, damped(x, v, second)[1]


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("limited", [True, False])
def test_a_disc_leaves_an_elastic_flank_with_the_speed_of_the_closed_form(limited, direction):
    run = lp.simulate(disc(direction, d=D, limited=limited), until=0.1, rtol=1e-11)
    lasts, speed = release(limited)
    times = sorted({event.time for event in run.events})
    assert times[0] == pytest.approx(FREE, rel=1e-11)
    if not limited:
        assert times[1] == pytest.approx(FREE + lasts, rel=1e-9)
    assert run["disc.w"][-1] == pytest.approx(direction * speed, rel=1e-9)
    # the flank is free again where the disc has travelled what is left of the twist
    left = -D / C * speed
    assert times[-1] == pytest.approx(FREE + lasts + left / -speed, rel=1e-9)


def test_without_damping_both_flanks_give_the_speed_back():
    run = lp.simulate(disc(), until=1.0, rtol=1e-11, grid=None)
    half = np.pi * np.sqrt(J / C)
    times = sorted({event.time for event in run.events})
    expected = [FREE]
    while len(expected) < len(times):
        expected.append(expected[-1] + (half if len(expected) % 2 else PLAY / SPEED))
    np.testing.assert_allclose(times, expected, rtol=1e-9)
    assert len(times) > 20


@pytest.mark.parametrize("limited", [True, False])
def test_the_torque_jumps_where_the_flanks_meet_only_if_the_damping_is_not_limited(limited):
    run = lp.simulate(disc(d=D, limited=limited), until=0.05, rtol=1e-9)
    before, after = run["play.tau"][np.abs(run.t - FREE) < 1e-12]
    expected = (0.0, 0.0 if limited else D * SPEED)
    assert (before, after) == pytest.approx(expected, abs=1e-9)


def test_a_loaded_play_rests_at_the_twist_of_its_spring():
    torque, middle = 12.0, 0.3
    system = assemble_row(
        wall=Fixed(),
        play=ElastoBacklash(c=C, d=400.0, b=PLAY, phi_rel0=middle),
        disc=Inertia(J=J, phi=middle, w=0.0),
        drive=Torque(tau=torque),
    )
    run = lp.simulate(system, until=20.0, rtol=1e-9)
    received = run["play.phi_rel"][-1]
    expected = middle + PLAY / 2 + torque / C
    assert received == pytest.approx(expected, rel=1e-9)


def test_without_play_it_is_a_spring_and_damper():
    system = assemble_row(
        wall=Fixed(), play=ElastoBacklash(c=C, d=D, b=0.0), disc=Inertia(J=J, phi=0.0, w=SPEED)
    )
    run = lp.simulate(system, until=1.0, rtol=1e-10)
    np.testing.assert_allclose(run["disc.phi"], damped(0.0, SPEED, run.t)[0], atol=1e-9 * SPEED / W)


@pytest.mark.parametrize("limited", [True, False])
def test_a_mass_leaves_an_elastic_gap_with_the_speed_of_the_closed_form(limited):
    start = 0.4
    system = assemble_row(
        wall=translation.Fixed(),
        gap=translation.ElastoGap(c=C, d=D, s_rel0=start, limited=limited),
        mass=translation.Mass(m=J, s=start + PLAY / 2, v=-SPEED),
    )
    run = lp.simulate(system, until=0.3, rtol=1e-11)
    lasts, speed = release(limited)
    # if limited, the damper is weaker than the spring from an event between on
    begin, *_, released, end = np.unique([event.time for event in run.events])
    assert begin == pytest.approx(FREE, rel=1e-11)
    assert released == pytest.approx(FREE + lasts, rel=1e-9)
    assert end == pytest.approx(FREE + lasts + D / C, rel=1e-9)
    assert run["mass.v"][-1] == pytest.approx(-speed, rel=1e-9)
    assert (run["gap.f"] <= 1e-12 * np.abs(run["gap.f"]).max()).all()
