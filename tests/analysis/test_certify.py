"""The certificate of a run against its true error."""

import numpy as np
import pytest

import lumped as lp
from lumped.analysis.advance import Advance
from lumped.components import BearingFriction, Fixed, Inertia, Torque
from lumped.errors import SolverError
from lumped.ops import sin


@pytest.mark.parametrize("method", ["explicit", "implicit", "exact"])
@pytest.mark.parametrize("grid", [200, None])
def test_the_estimate_is_the_true_error(two_mass, method, grid):
    system, w = lp.assemble(two_mass), np.sqrt(450.0)
    run = lp.simulate(
        *(system,), until=3.0, start={"a.w": 1.0}, method=method, grid=grid, rtol=1e-5, certify=True
    )
    print(run)
    expected = -np.sin(w * run.t) / w
    error = np.abs(run["shaft.phi_rel"] - expected)
    found = run.certificate["shaft.phi_rel"]
    if method == "exact":
        assert error.max() < 1e-13 < found.relative < 1e-6
    else:
        assert found.relative == pytest.approx(error.max() / np.ptp(expected), rel=0.1)
        assert found.time == run.t[error.argmax()]
    assert run.certificate["shaft.tau"].relative == pytest.approx(found.relative, rel=1e-6)
    assert run.certificate.error >= found.relative
    assert "error / range" in repr(run)


def test_both_sides_of_a_jump_and_events_do_not_count():
    """A body under dry friction and an alternating torque, piece by piece by hand."""
    system = lp.assemble(
        lp.compose(
            drive=Torque(tau=3 * sin(lp.time)),
            body=Inertia(J=1.0),
            rub=BearingFriction(characteristic=((0.0, 1.0),)),
            connections=lambda m: [lp.connect(m.drive.flange, m.body.flange_a, m.rub.flange_a)],
        )
    )
    run = lp.simulate(system, until=3.0, rtol=1e-4, certify=True)
    start = np.arcsin(1 / 3)
    moves = (run.t > start) & (run["body.w"] > 0)
    expected = 3 * (np.cos(start) - np.cos(run.t)) - (run.t - start)
    true = np.abs(run["body.w"] - expected)[moves].max() / np.ptp(run["body.w"])
    print(run.certificate, true)
    assert run.certificate.states.window < 1e-3
    assert run.certificate["rub.tau"].relative < 1e-3
    assert run.certificate["body.w"].relative == pytest.approx(true, rel=0.5, abs=1e-9)


def test_a_second_run_that_fails_leaves_the_first(two_mass, monkeypatch):
    class Impatient(Advance):
        def through(self, *args):
            if self._rtol < 1e-6:
                raise SolverError("enough")
            return super().through(*args)

    monkeypatch.setattr("lumped.analysis.simulate.Advance", Impatient)
    system = lp.assemble(two_mass)
    with pytest.raises(SolverError, match=r"certify: the second run.*enough") as e:
        lp.simulate(system, until=1.0, rtol=1e-5, method="explicit", certify=True)
    assert e.value.partial.t[-1] == 1.0


def test_a_system_without_states_has_a_certificate():
    class Moved(lp.Component):
        push: Torque = Torque(tau=2.0)
        wall: Fixed = Fixed()

        def connections(self):
            yield lp.connect(self.push.flange, self.wall.flange)

    run = lp.simulate(lp.assemble(Moved()), until=1.0, certify=True)
    assert np.isnan(run.certificate.error)
    assert run.certificate["wall.flange.tau"].relative == 0.0
