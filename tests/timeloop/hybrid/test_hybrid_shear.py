"""Impacts beside states of quite another size."""

from collections.abc import Iterator

import pytest

import lumped as lp
from lumped.components import Inertia, PickUp
from lumped.ops import where

W = 1e-3  # rad/s


class Carrier(lp.Component):
    """A slow wheel that picks up two bodies at 1 s; its momentum is J W."""

    wheel: Inertia = Inertia(J=1.0, w=W)
    first: PickUp = PickUp(J=2.0, u=where(lp.time >= 1.0, 1.0, 0.0))
    second: PickUp = PickUp(J=3.0, u=where(lp.time >= 1.0, 1.0, 0.0))
    large: lp.Var = lp.var("1", "a state that no speed depends on", state="prefer")

    def equations(self) -> Iterator[lp.Equation]:
        yield lp.der(self.large) == self.wheel.w

    def connections(self) -> Iterator[lp.Connection]:
        yield lp.connect(self.wheel.flange_a, self.first.flange, self.second.flange)


@pytest.mark.parametrize("large", [0.0, 1e6, 1e9])
def test_impact_does_not_depend_on_the_size_of_other_states(large):
    start = {"large": large, "first.w": 0.0, "second.w": 0.0}
    run = lp.simulate(lp.assemble(Carrier()), until=2.0, start=start, rtol=1e-10)
    received = [run[f"{name}.w"][-1] for name in ("wheel", "first", "second")]
    expected = W / 6
    assert max(abs(w / expected - 1) for w in received) < 1e-12
    assert len({event.time for event in run.events}) == 1
    lost = sum(event.loss for event in run.events)
    assert abs(lost / (W**2 / 2 * (1 - 1 / 6)) - 1) < 1e-12
