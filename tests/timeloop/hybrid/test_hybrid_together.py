"""Many changes of modes in one step or one instant."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import BearingFriction, Inertia, Torque

TAU = 0.3


def braked(inertias):
    """Bodies that turn at 1 rad/s, each slowed down by its own bearing."""
    body = [Inertia(J=float(J), w=1.0) for J in inertias]
    rub = [BearingFriction(characteristic=((0.0, TAU),)) for _ in inertias]

    def connections(_):
        for b, r in zip(body, rub, strict=True):
            yield lp.connect(b.flange_b, r.flange_a)

    return lp.assemble(lp.compose(body=body, rub=rub, connections=connections))


def stops(run):
    """Instant at which each bearing sticks."""
    found = {e.component: e.time for e in run.events if e.after == "stuck"}
    return np.array([found[f"rub[{i}]"] for i in range(len(found))])


def test_stops_within_one_step_come_each_at_its_own_instant():
    inertias = np.random.default_rng(8).permutation(np.linspace(1.0, 1.02, 25))
    run = lp.simulate(braked(inertias), until=5.0, grid=[5.0])
    np.testing.assert_allclose(stops(run), inertias / TAU, rtol=1e-13)


def test_all_that_stops_at_one_instant_stops_there():
    run = lp.simulate(braked(np.ones(200)), until=5.0, grid=[5.0])
    received = stops(run)
    assert len(received) == 200
    np.testing.assert_allclose(received, 1.0 / TAU, rtol=1e-13)
    assert len(run.pieces) == 2
    assert not run["body[137].w"][-1]


class Noted(lp.Component):
    """A body under constant torque ; it is noted when it passes a whole speed."""

    body: Inertia = Inertia(J=2.0, w=0.0)
    drive: Torque = Torque(tau=1.0)
    last = lp.var("s", "when it was passed", start=0.0)
    wanted = lp.var("rad/s", "next speed to be noted", start=1.0)

    def connections(self):
        yield lp.connect(self.drive.flange, self.body.flange_a)

    def equations(self):
        yield lp.der(self.last) == 0
        yield lp.der(self.wanted) == 0
        yield lp.when(
            self.body.w >= self.wanted, {self.wanted: self.wanted + 1.0, self.last: lp.time}
        )


@pytest.mark.parametrize("outputs", [None, ["body.w"]])
def test_a_jump_may_change_states_that_nobody_needs(outputs):
    run = lp.simulate(lp.assemble(Noted(), of=outputs), until=7.0)
    received = [e.time for e in run.events]
    np.testing.assert_allclose(received, [2.0, 4.0, 6.0], rtol=1e-12)
    np.testing.assert_allclose(run["body.w"][-1], 3.5, rtol=1e-12)
