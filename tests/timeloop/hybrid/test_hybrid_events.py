"""Changes of states, chains of events, events at the start, storms."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, Torque
from lumped.errors import SolverError


class Reset(lp.Component):
    """A controller's integral that is set back whenever it has grown to one."""

    y: lp.Var = lp.var("1", "integral", state="always")
    count: lp.Var = lp.var("1", "how often", state="always")

    def equations(self):
        yield lp.der(self.y) == 1 + lp.time
        yield lp.der(self.count) == 0
        yield lp.when(self.y >= 1, {self.y: self.y - 1, self.count: self.count + 1})


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


def test_a_torque_that_begins_at_the_start_acts_from_the_start():
    drive = Torque(tau=lp.ops.where(lp.time >= 0, 4.0, 100.0))
    model = in_a_row(drive=drive, disc=Inertia(J=2.0, w=0.0))
    run = lp.simulate(lp.assemble(model), until=1.0)
    np.testing.assert_allclose(run["disc.w"], 2.0 * run.t, atol=1e-9)


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
