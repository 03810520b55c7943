"""Constraints that hold and slide, where bodies have round numbers."""

import pytest

import lumped as lp
from lumped.components import Inertia


class Rub(lp.Component):
    """Coulomb friction of a shaft on the ground: ``|tau| <= 1``."""

    flange_a = lp.Flange()
    phi: lp.Var = lp.var("rad", "angle")
    w: lp.Var = lp.var("rad/s", "sliding speed", state="prefer")
    tau: lp.Var = lp.var("N.m", "friction torque")

    def equations(self):
        yield self.phi == self.flange_a.phi
        yield self.w == lp.der(self.phi)
        yield self.flange_a.tau == self.tau
        yield lp.hold(self.tau, self.w, forward=1, backward=-1, upper=1, lower=-1)


@pytest.mark.parametrize("J", [0.25, 1.0, 4.0])
def test_the_compliance_of_a_held_shaft_never_meets_its_inertia(J):
    """A constraint that yields against its reaction keeps the sign of what it holds."""
    model = lp.compose(
        body=Inertia(J=J, w=2.0),
        rub=Rub(),
        connections=lambda m: [lp.connect(m.body.flange_b, m.rub.flange_a)],
    )
    run = lp.simulate(lp.assemble(model), until=3 * J)
    (event,) = run.events
    assert event.time == pytest.approx(2 * J, rel=1e-12)
    assert run["body.w"][-1] == 0.0
