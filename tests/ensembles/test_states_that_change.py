"""Runs of an ensemble in which another state leads from a dead centre on."""

import linkages
import numpy as np
import pytest
from ensemble_runs import (
    CURVE,
    Alone,
    all_functionals,
    assert_equal_to_single_runs,
    assert_events_are_those,
    assert_same_bits,
    event_functionals,
    ran,
)
from linkages import double_rocker
from rows import assemble_rows

import lumped as lp
from lumped import functionals as fun
from lumped.components import Brake, Fixed, Inertia, SpringDamper, Torque
from lumped.kernel import engine
from lumped.ops import tan, where

SPEED = 12.0


@pytest.fixture(scope="module")
def pendulum():
    """A pendulum that turns over, in coordinates across and down."""
    return lp.assemble(linkages.pendulum(SPEED))


class Tangent(lp.Component):
    """An angle that leads less and less, b = tan a."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()

    def equations(self):
        a, b = self.flange_a, self.flange_b
        yield b.phi == tan(a.phi)
        yield a.tau == -b.tau * (1 + tan(a.phi) ** 2)


@pytest.fixture(scope="module")
def braked():
    """A body that runs away from the angle that leads it, with a brake and a jump of its load."""
    return assemble_rows(
        "a tangent b shaft wall",
        "b load",
        "b brake",
        a=Inertia(J=2.0),
        tangent=Tangent(),
        b=Inertia(J=0.1, phi=0.0, w=60.0),
        shaft=SpringDamper(c=0.4, d=0.01),
        wall=Fixed(),
        load=Torque(tau=where(lp.time >= 0.8, 5.0, -2.0)),
        brake=Brake(f_max=8.0, u=1.0, characteristic=((0.0, 1.0),)),
    )


def values(names, ranges, count, seed=3):
    """Values of what varies, one row for each run."""
    low, high = np.array(ranges).T
    return np.random.default_rng(seed).uniform(low, high, (count, len(names)))


def changes(run):
    """How often states change."""
    return sum(event.kind == "states" for event in run.events)


@pytest.mark.parametrize("method", ["steps", "implicit"])
def test_runs_with_many_dead_centres_are_those_of_simulate(pendulum, method):
    names, ranges = ["across.m", "down.m"], [(0.8, 1.2), (0.8, 1.2)]
    _, runs = assert_equal_to_single_runs(
        pendulum,
        names,
        values(names, ranges, 6),
        ["across.s", "down.s", "across.v"],
        4.0,
        (1.0, 3.0),
        method=method,
        rtol=1e-8,
    )
    assert {changes(run) for run in runs} == {1}


def test_functionals_go_on_where_another_state_leads(pendulum):
    """Extremes are the length of the rod and the speed at the bottom, integrals are ways."""
    lengths = np.linspace(1.5, 2.5, 5)
    of = {
        "highest": fun.highest("down.s"),
        "lowest": fun.lowest("down.s"),
        "fastest": fun.highest("across.v"),
        "swing": fun.swing("across.s"),
        "way": fun.integral("down.v"),
        "end": fun.final("down.s"),
        "at": fun.at_time([0.0, 4.0], "down.s"),
    }
    found = lp.ensemble(pendulum, over={"rod.length": lengths}, until=4.0, of=of, rtol=1e-9)
    expected = {
        "highest": lengths,
        "lowest": -lengths,
        "fastest": np.full(5, SPEED),
        "swing": 2 * lengths,
        "way": found["end"] - lengths,
        "at": found["end"] + lengths,
    }
    for label, value in expected.items():
        error = np.abs(found[label] - value).max()
        print(f"{label}: {error:.1e}")
        assert error < 1e-5


def test_cycles_are_counted_where_another_state_leads(pendulum):
    """The rod goes round: half cycles from top to bottom and back, and a rest at the end."""
    lengths, knee = np.linspace(1.5, 2.5, 5), 0.1
    of = {"damage": fun.damage("down.s", CURVE), "end": fun.final("down.s")}
    found = lp.ensemble(pendulum, over={"rod.length": lengths}, until=4.0, of=of, rtol=1e-9)

    def half_cycle(range_):
        return 0.5e-5 * (0.5 * range_ / knee) ** 5

    for length, damage, end in zip(lengths, found["damage"], found["end"], strict=True):
        turns = np.arange(2, 20)
        rest = np.abs(end - length * (-1.0) ** turns)
        errors = np.abs((turns * half_cycle(2 * length) + half_cycle(rest)) / damage - 1)
        print(f"{turns[errors.argmin()]} half turns: {errors.min():.0e}")
        assert errors.min() < 1e-6


def test_lanes_and_events_go_on_where_another_state_leads(braked):
    names, ranges = ["b.J", "shaft.c", "a.J"], [(0.07, 0.13), (0.3, 0.5), (1.4, 2.6)]
    points = values(names, ranges, 19)
    found, runs = assert_equal_to_single_runs(
        braked,
        names,
        points,
        ["a.phi", "b.phi", "b.w"],
        3.0,
        (0.1, 0.5, 2.0),
        event_functionals(braked),
        rtol=1e-8,
    )
    assert_events_are_those(found, runs)
    assert {changes(run) for run in runs} == {1}
    assert min(len(run.events) for run in runs) >= 3
    of = all_functionals(braked, 3.0)
    together = ran(braked, names, points, of, 3.0)
    assert_same_bits(ran(braked, names, points, of, 3.0, Alone), together)


def test_other_engines_give_the_same_bits(braked):
    names, points = ["b.J"], np.array([[0.1], [0.12]])
    of = all_functionals(braked, 1.0)
    together = ran(braked, names, points, of, 1.0)
    with engine.using("python"):
        assert_same_bits(ran(braked, names, points, of, 1.0), together)


def test_threads_share_the_systems_that_others_lead():
    system = lp.assemble(double_rocker(w=3.0))
    options = {"over": {"crank.J": np.linspace(1.5, 2.5, 64)}, "until": 3.0}
    of = [fun.final("crank.w"), fun.peak("rocker.w")]
    one, four = (lp.ensemble(system, of=of, workers=n, **options) for n in (1, 4))
    assert not one.failures
    np.testing.assert_array_equal(one.values, four.values)
