"""Constraints that hold and slide, where bodies have round numbers."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import Inertia, OneWayClutch, Torque


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
    model = in_a_row(body=Inertia(J=J, w=2.0), rub=Rub())
    run = lp.simulate(lp.assemble(model), until=3 * J)
    (event,) = run.events
    assert event.time == pytest.approx(2 * J, rel=1e-12)
    assert run["body.w"][-1] == 0.0


def test_a_quantity_is_computed_once_however_often_the_run_changed_its_mode(monkeypatch):
    model = in_a_row(drive=Torque(tau=3 * lp.ops.sin(20 * lp.time)), body=Inertia(J=1.0), rub=Rub())
    system = lp.assemble(model)
    run = lp.simulate(system, until=2.0)
    made = []
    function = type(system).function
    monkeypatch.setattr(
        type(system), "function", lambda s, names: made.append(names) or function(s, names)
    )
    assert np.isfinite(run["rub.tau"]).all()
    assert len(run.pieces) > 10
    assert len(made) == 1


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("torque", [4.0, -4.0])
def test_redundant_constraints_are_found_without_a_warning(torque):
    """Two freewheels that bar the same motion."""
    model = lp.compose(
        drive=Torque(tau=torque),
        a=Inertia(J=1.0),
        b=Inertia(J=2.0),
        wheel=[OneWayClutch(u=0.0), OneWayClutch(u=0.0)],
        connections=lambda m: [
            lp.connect(m.drive.flange, m.a.flange_a),
            lp.connect(m.a.flange_b, *(wheel.flange_a for wheel in m.wheel)),
            lp.connect(m.b.flange_a, *(wheel.flange_b for wheel in m.wheel)),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=1.0)
    expected = (torque / 3, torque / 3) if torque > 0 else (torque, 0.0)
    received = (run["a.w"][-1], run["b.w"][-1])
    assert received == pytest.approx(expected, rel=1e-7)
