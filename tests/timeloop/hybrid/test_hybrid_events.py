"""Changes of states, chains of events, events at the start, storms."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia, Torque
from lumped.errors import SolverError

G = 9.81


class Jumper(lp.Component):
    """A ball whose bounce is written as a change of states."""

    e: lp.Param = lp.param("1", "restitution", 0.9)
    s: lp.Var = lp.var("m", "height", 1.0, state="always")
    v: lp.Var = lp.var("m/s", "velocity", state="always")

    def equations(self):
        yield lp.der(self.s) == self.v
        yield lp.der(self.v) == -G
        yield lp.when(self.s <= 0, {self.v: -self.e * self.v})


class Reset(lp.Component):
    """A controller's integral that is set back whenever it has grown to one."""

    y: lp.Var = lp.var("1", "integral", state="always")
    count: lp.Var = lp.var("1", "how often", state="always")

    def equations(self):
        yield lp.der(self.y) == 1 + lp.time
        yield lp.der(self.count) == 0
        yield lp.when(self.y >= 1, {self.y: self.y - 1, self.count: self.count + 1})


class Chain(lp.Component):
    """Each change makes the condition of the next one true, at the same instant."""

    a: lp.Var = lp.var("1", "first", state="always")
    b: lp.Var = lp.var("1", "second", state="always")
    c: lp.Var = lp.var("1", "third", state="always")

    def equations(self):
        for quantity, rate in ((self.a, 1), (self.b, 0), (self.c, 0)):
            yield lp.der(quantity) == rate
        yield lp.when(self.a >= 0.3, {self.b: self.b + 10 * self.a})
        yield lp.when(self.b >= 2, {self.c: self.c + 2 * self.b})


class Motor(lp.Component):
    """A motor that is switched over when it has reached a speed, and a torque that follows."""

    flange = lp.Flange()
    wanted: lp.Var = lp.var("N.m", "torque", 3.0, state="always")
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        yield self.w == lp.der(self.flange.phi)
        yield lp.der(self.wanted) == 0
        yield self.flange.tau == -self.wanted
        yield lp.when(self.w >= 2, {self.wanted: -1.0})


class Storm(lp.Component):
    """A relay without hysteresis: its state is driven back to the switching line."""

    x: lp.Var = lp.var("1", "state", 0.5, state="always")

    def equations(self):
        yield lp.der(self.x) == lp.ops.where(self.x > 0, -1, 1)


class Endless(lp.Component):
    """Two changes that make each other's condition true."""

    t: lp.Var = lp.var("s", "clock", state="always")
    x: lp.Var = lp.var("1", "state", -1.0, state="always")

    def equations(self):
        yield lp.der(self.t) == 1
        yield lp.der(self.x) == 0
        yield lp.when(self.t >= 0.5, {self.x: 1})
        yield lp.when(self.x >= 0.5, {self.x: -1})
        yield lp.when(self.x <= -0.5, {self.x: 1})


def alone(part, **options):
    return lp.assemble(lp.compose(part=part), **options)


def test_a_change_of_states_bounces_as_the_closed_form_says():
    run = lp.simulate(alone(Jumper()), until=4.0, rtol=1e-10)
    times = np.array(sorted({event.time for event in run.events}))
    fall = np.sqrt(2 / G)
    n = np.arange(10)
    expected = fall * (1 + 2 * 0.9 * (1 - 0.9**n) / (1 - 0.9))
    np.testing.assert_allclose(times, expected[expected < 4.0], rtol=1e-10)


def test_an_integral_is_set_back_each_time_it_is_full():
    run = lp.simulate(alone(Reset()), until=3.0, rtol=1e-10, grid=600)
    whole = run.t + run.t**2 / 2
    received = run["part.y"] + run["part.count"]
    np.testing.assert_allclose(received, whole, rtol=1e-9, atol=1e-12)
    times = sorted({event.time for event in run.events})
    expected = np.sqrt(1 + 2 * np.arange(1, 8)) - 1
    np.testing.assert_allclose(times, expected[expected < 3.0], rtol=1e-10)
    first = run.events[0]
    assert (first.component, first.before, first.after) == ("part", "y < 1", "y >= 1")


def test_a_change_that_makes_another_condition_true_happens_at_the_same_instant():
    run = lp.simulate(alone(Chain()), until=1.0, rtol=1e-10)
    np.testing.assert_allclose([event.time for event in run.events], 0.3, rtol=1e-10)
    received = [run[f"part.{name}"][-1] for name in "abc"]
    np.testing.assert_allclose(received, [1.0, 3.0, 6.0], rtol=1e-9)


def test_a_drive_is_switched_over_by_its_own_speed():
    model = lp.compose(
        motor=Motor(),
        disc=Inertia(J=1.5, w=0.0),
        connections=lambda m: lp.chain(m.motor, m.disc),
    )
    run = lp.simulate(lp.assemble(model), until=3.0, rtol=1e-10)
    switch = 2 * 1.5 / 3.0
    expected = np.where(run.t < switch, run.t * 2, 2 - (run.t - switch) / 1.5)
    np.testing.assert_allclose(run["disc.w"], expected, atol=1e-9)


def test_a_condition_that_is_true_at_the_start_does_nothing():
    run = lp.simulate(alone(Jumper()), until=0.2, start={"part.s": -1.0, "part.v": 3.0})
    assert not run.events
    np.testing.assert_allclose(run["part.v"][-1], 3.0 - 0.2 * G, rtol=1e-9)


def test_a_torque_that_begins_at_the_start_acts_from_the_start():
    drive = Torque(tau=lp.ops.where(lp.time >= 0, 4.0, 100.0))
    model = lp.compose(
        drive=drive, disc=Inertia(J=2.0, w=0.0), connections=lambda m: lp.chain(m.drive, m.disc)
    )
    run = lp.simulate(lp.assemble(model), until=1.0)
    np.testing.assert_allclose(run["disc.w"], 2.0 * run.t, atol=1e-9)


def test_a_storm_of_events_ends_with_an_error_and_the_run_so_far():
    with pytest.raises(SolverError, match=r"changes of mode within .* in part") as caught:
        lp.simulate(alone(Storm()), until=2.0)
    partial = caught.value.partial
    assert partial.t[-1] == pytest.approx(0.5, abs=1e-6)
    np.testing.assert_allclose(partial["part.x"], 0.5 - partial.t, atol=1e-6)


def test_changes_without_end_at_one_instant_end_with_an_error_and_the_run_so_far():
    with pytest.raises(SolverError, match="without end") as caught:
        lp.simulate(alone(Endless()), until=1.0)
    assert caught.value.partial.t[-1] == pytest.approx(0.5, abs=1e-9)


class Threshold(lp.Component):
    """A quantity that is cut off where a function of the time is small."""

    x: lp.Var = lp.var("1", "function of the time")
    y: lp.Var = lp.var("1", "what is left of it")

    def equations(self):
        yield self.x == lp.ops.sin(6 * lp.time)
        yield self.y == lp.ops.where(self.x > 0.5, self.x, 0)


def test_conditions_count_in_a_model_without_states():
    run = lp.simulate(alone(Threshold()), until=2.0, grid=501)
    assert not run.system.state_names
    x = np.sin(6 * run.t)
    first = np.arcsin(0.5)
    up, down = first + 2 * np.pi * np.arange(3), np.pi - first + 2 * np.pi * np.arange(3)
    expected = np.sort(np.concatenate([up, down])) / 6
    received = np.array([event.time for event in run.events])
    np.testing.assert_allclose(received, expected[expected < 2.0], rtol=1e-12)
    away = np.abs(x - 0.5) > 1e-9
    np.testing.assert_allclose(run["part.y"][away], np.where(x > 0.5, x, 0)[away], rtol=1e-12)
