"""Changes of states, chains of events, events at the start, storms."""

import numpy as np
import pytest

import lumped as lp
from lumped.errors import SolverError


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


@pytest.mark.parametrize("grid", [7, 501, None])
def test_conditions_count_in_a_model_without_states(grid):
    run = lp.simulate(alone(Threshold()), until=2.0, grid=grid)
    assert not run.system.state_names
    x = np.sin(6 * run.t)
    first = np.arcsin(0.5)
    up, down = first + 2 * np.pi * np.arange(3), np.pi - first + 2 * np.pi * np.arange(3)
    expected = np.sort(np.concatenate([up, down])) / 6
    received = np.array([event.time for event in run.events])
    np.testing.assert_allclose(received, expected[expected < 2.0], rtol=1e-12)
    away = np.abs(x - 0.5) > 1e-9
    np.testing.assert_allclose(run["part.y"][away], np.where(x > 0.5, x, 0)[away], rtol=1e-12)
