"""Impacts, stops, play and couplings against closed forms, momentum and energy."""

import numpy as np
import pytest
from drive_chains import in_turn
from rows import assemble_row, assemble_rows
from test_impact_shafts import at

import lumped as lp
from lumped.components import translation
from lumped.components.translation import Force, Mass, MassWithStops, Position

G = 9.81  # m/s2


def impacts(run, component=None):
    """Instants and losses of the impacts."""
    hits = [e for e in run.events if e.loss and component in (None, e.component)]
    return np.array([e.time for e in hits]), np.array([e.loss for e in hits])


# -- stops -------------------------------------------------------------------------------------


def test_a_body_leaves_a_shaking_table_when_its_weight_no_longer_holds_it():
    amplitude, w, mass = 0.02, 60.0, 3.0
    system = assemble_row(
        table=Position(s=amplitude * lp.ops.sin(w * lp.time)),
        contact=translation.Stop(),
        mass=Mass(m=mass, s=0.0, v=amplitude * w),
        weight=Force(f=-mass * G),
    )
    run = lp.simulate(system, until=0.04, rtol=1e-11)
    first = run.events[0]
    lift = np.arcsin(G / (amplitude * w**2)) / w
    print(f"lifts off at {first.time:.9f} s, error {first.time - lift:.1e} s")
    assert (first.before, first.after) == ("closed", "open")
    assert first.time == pytest.approx(lift, abs=1e-9)
    t = run.t[run.t > lift + 1e-9]
    s0, v0 = amplitude * np.sin(w * lift), amplitude * w * np.cos(w * lift)
    expected = s0 + v0 * (t - lift) - G * (t - lift) ** 2 / 2
    np.testing.assert_allclose(run["mass.s"][run.t > lift + 1e-9], expected, rtol=1e-9)


def test_a_body_between_two_stops_keeps_the_time_of_its_round_trips():
    e, v, half = 0.8, 3.0, 1.0
    model = MassWithStops(m=1.5, s_min=-half, s_max=half, s=0.0, v=v, restitution=e)
    system = lp.assemble(lp.compose(body=model))
    run = lp.simulate(system, until=8.0)
    times, losses = impacts(run)
    n = np.arange(len(times))
    flights = np.concatenate([[half / v], 2 * half / (v * e ** n[1:])])
    np.testing.assert_allclose(times, np.cumsum(flights), rtol=1e-12)
    np.testing.assert_allclose(losses, 1.5 / 2 * (v * e**n) ** 2 * (1 - e**2), rtol=1e-12)
    assert np.abs(run["body.s"]).max() <= half + 1e-12


@pytest.mark.parametrize("mass", [0.5, 1.0, 3.0])
def test_a_pressed_body_rests_on_the_stop_that_it_is_pressed_to(mass):
    body = MassWithStops(m=mass, length=0.4, s_min=-1.0, s_max=1.0, s=0.0, v=0.0)
    system = assemble_row(body=body, drive=Force(f=6.0 - 12.0 * at(2.0)))
    run = lp.simulate(system, until=4.0, grid=[1.5, 3.9], rtol=1e-9)
    np.testing.assert_allclose(run["body.s"], [1.0, -1.0], rtol=1e-12)
    np.testing.assert_allclose(run["body.f_upper"], [-6.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(run["body.f_lower"], [0.0, -6.0], atol=1e-12)


# -- trains of bodies --------------------------------------------------------------------------


def train(masses, speeds, positions, restitution):
    """Bodies in a row with a one-sided contact between neighbours."""
    bodies = [Mass(m=m, v=v, s=s) for m, v, s in zip(masses, speeds, positions, strict=True)]
    return lp.assemble(
        in_turn(
            bodies=bodies, stops=[translation.Stop(restitution=restitution) for _ in bodies[1:]]
        )
    )


def last_speeds(run, count):
    return [run[f"bodies[{i}].v"][-1] for i in range(count)]


def test_the_last_ball_of_a_cradle_flies_on_if_the_balls_do_not_touch():
    run = lp.simulate(train([1, 1, 1], [1, 0, 0], [-1, 0, 1e-3], 1.0), until=3.0)
    np.testing.assert_allclose(last_speeds(run, 3), [0, 0, 1], atol=1e-12)


def test_balls_that_touch_take_part_in_one_impact_as_one_body():
    # Newton's law for simultaneous impacts: the two balls at rest stay together, as their
    # relative speed is zero before and after; momentum and energy are kept all the same
    run = lp.simulate(train([1, 1, 1], [1, 0, 0], [-1, 0, 0], 1.0), until=3.0)
    np.testing.assert_allclose(last_speeds(run, 3), [-1 / 3, 2 / 3, 2 / 3], rtol=1e-12)


@pytest.mark.parametrize("touching", [False, True])
def test_a_train_that_couples_up_keeps_its_momentum(touching):
    masses = np.array([4.0, 1.0, 2.5, 0.7, 3.0])
    speeds = np.array([5.0, 0.0, 0.0, 0.0, 0.0])
    gap = 0.0 if touching else 0.1
    positions = np.concatenate([[-1.0], gap * np.arange(4)])
    run = lp.simulate(train(masses, speeds, positions, 0.0), until=2.0)
    together = masses @ speeds / masses.sum()
    np.testing.assert_allclose(last_speeds(run, 5), together, rtol=1e-12)
    _, losses = impacts(run)
    expected = masses @ speeds**2 / 2 - masses.sum() * together**2 / 2
    assert losses.sum() == pytest.approx(expected, rel=1e-12)


def test_three_bodies_that_meet_at_one_instant_share_one_speed():
    masses, speeds = np.array([2.0, 5.0, 1.0]), np.array([3.0, 0.5, -4.0])
    meet = 0.25
    run = lp.simulate(train(masses, speeds, -meet * speeds, 0.0), until=1.0)
    np.testing.assert_allclose(last_speeds(run, 3), masses @ speeds / masses.sum(), rtol=1e-10)
    times, losses = impacts(run)
    np.testing.assert_allclose(times, meet, atol=1e-11)
    lost = masses @ speeds**2 / 2 - (masses @ speeds) ** 2 / masses.sum() / 2
    assert losses.sum() == pytest.approx(lost, rel=1e-9)


def test_a_pushed_train_leaves_in_order_when_it_is_pulled_back():
    # every contact transmits what accelerates the bodies behind it, and opens when that is zero
    masses = [2.0, 1.0, 3.0]
    first, *others = [Mass(m=m, s=0.0, v=0.0) for m in masses]
    system = assemble_rows(
        "drive first contacts/others",
        drive=Force(f=12.0 - 24.0 * lp.time),
        first=first,
        contacts=[translation.Stop() for _ in others],
        others=others,
    )
    run = lp.simulate(system, until=1.0, rtol=1e-10, grid=[0.0, 0.25, 1.0])
    for i in (0, 1):
        behind = sum(masses[i + 1 :]) / sum(masses)
        received = run[f"contacts[{i}].f"]
        expected = [-12.0 * behind, -6.0 * behind, 0.0]
        np.testing.assert_allclose(received, expected, atol=1e-9)
    opening = [e.time for e in run.events if e.after == "open"]
    np.testing.assert_allclose(opening, 0.5, atol=1e-9)
    speed = 12.0 * 0.5 - 12.0 * 0.25
    np.testing.assert_allclose(run["others[1].v"][-1], speed / sum(masses), rtol=1e-9)


def collided(masses, x, v, walls, restitution, until):
    """Positions and number of collisions of free bodies between walls, collision by collision."""
    x, v, now, count = np.array(x), np.array(v), 0.0, 0
    m = np.concatenate([[np.inf], masses, [np.inf]])
    while True:
        places, speeds = np.array([walls[0], *x, walls[1]]), np.array([0.0, *v, 0.0])
        gaps, rates = np.diff(places), np.diff(speeds)
        with np.errstate(divide="ignore"):
            waits = np.where(rates < 0, gaps / -rates, np.inf)
        i = int(np.argmin(waits))
        step = min(waits[i], until - now)
        x, now = x + v * step, now + step
        if now >= until:
            return x, count
        inverse = 1 / m[i] + 1 / m[i + 1]
        impulse = (1 + restitution) * -rates[i] / inverse
        speeds[i] -= impulse / m[i]
        speeds[i + 1] += impulse / m[i + 1]
        v, count = speeds[1:-1], count + 1


@pytest.mark.parametrize("restitution", [1.0, 0.9])
def test_bodies_between_walls_collide_as_they_do_one_collision_at_a_time(restitution):
    rng, count = np.random.default_rng(8), 5
    masses, v = rng.uniform(0.5, 2.0, count), rng.uniform(-2.0, 2.0, count)
    x = np.sort(rng.uniform(0.1, 2.9, count))
    first, *contacts = [translation.Stop(restitution=restitution) for _ in range(count + 1)]
    system = assemble_rows(
        "left first bodies/contacts right",
        left=translation.Fixed(s0=0.0),
        first=first,
        contacts=contacts,
        bodies=[Mass(m=m, s=s, v=w) for m, s, w in zip(masses, x, v, strict=True)],
        right=translation.Fixed(s0=3.0),
    )
    run = lp.simulate(system, until=8.0, rtol=1e-10)
    expected, hits = collided(masses, x, v, (0.0, 3.0), restitution, 8.0)
    received = [run[f"bodies[{i}].s"][-1] for i in range(count)]
    error = np.abs(received - expected).max()
    print(f"e = {restitution}: {hits} collisions, largest error of a position {error:.1e} m")
    assert len({event.time for event in run.events}) == hits
    assert error <= 1e-9


def test_a_dropped_stack_comes_to_rest_on_itself():
    # collisions between all neighbours become ever faster until everything lies still
    masses, heights, e = [1.0, 2.0, 3.0, 1.0, 0.2], [1.0, 1.2, 1.5, 1.6, 1.7], 0.6
    system = assemble_rows(
        "contacts/bodies/weights",
        contacts=[translation.Stop(restitution=e) for _ in masses],
        bodies=[Mass(m=m, s=h, v=0.0) for m, h in zip(masses, heights, strict=True)],
        weights=[Force(f=-m * G) for m in masses],
    )
    run = lp.simulate(system, until=3.0, rtol=1e-9)
    carried = [run[f"contacts[{i}].f"][-1] for i in range(len(masses))]
    np.testing.assert_allclose(carried, -G * np.cumsum(masses[::-1])[::-1], rtol=1e-10)
    assert [run[f"bodies[{i}].v"][-1] for i in range(len(masses))] == [0.0] * len(masses)
    energy = G * np.dot(masses, heights)
    assert sum(event.loss for event in run.events) == pytest.approx(energy, rel=1e-9)
