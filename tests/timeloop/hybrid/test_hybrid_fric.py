"""Constraints that hold and slide, where bodies have round numbers."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import BearingFriction, Inertia, Torque

COULOMB = BearingFriction(characteristic=((0.0, 1.0),))


@pytest.mark.parametrize("J", [0.25, 1.0, 4.0])
def test_the_compliance_of_a_held_shaft_never_meets_its_inertia(J):
    """A constraint that yields against its reaction keeps the sign of what it holds."""
    model = in_a_row(body=Inertia(J=J, w=2.0), rub=COULOMB)
    run = lp.simulate(lp.assemble(model), until=3 * J)
    (event,) = run.events
    assert event.time == pytest.approx(2 * J, rel=1e-12)
    assert run["body.w"][-1] == 0.0


def test_a_quantity_is_computed_once_however_often_the_run_changed_its_mode(monkeypatch):
    model = in_a_row(
        drive=Torque(tau=3 * lp.ops.sin(20 * lp.time)),
        body=Inertia(J=1.0),
        rub=COULOMB,
    )
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
