"""Jumps that make their own condition false again."""

import numpy as np

import lumped as lp


class Clock(lp.Component):
    """Counts: at 0, T, 2 T, ... ``n += 1``."""

    T: lp.Param = lp.param("s", "period", 0.3, above=0)
    n: lp.Var = lp.var("1", "count", state="always")
    t_next: lp.Var = lp.var("s", "next instant", state="always")

    def equations(self):
        yield lp.der(self.n) == 0
        yield lp.der(self.t_next) == 0
        changes = {self.n: self.n + 1, self.t_next: self.t_next + self.T}
        yield lp.when(lp.time > self.t_next, changes)


def test_each_jump_is_noted_at_its_instant():
    run = lp.simulate(lp.assemble(lp.compose(clock=Clock())), until=2.0, grid=100)
    received = np.array([event.time for event in run.events])
    expected = 0.3 * np.arange(7)
    assert {event.component for event in run.events} == {"clock"}
    assert len(received) == len(expected)
    assert np.abs(received - expected).max() <= 1e-12
    assert run["clock.n"][-1] == 7
