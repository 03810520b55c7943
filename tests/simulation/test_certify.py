"""The certificate of a run against its true error."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from rows import assemble_row, assemble_rows, in_a_row
from scipy.integrate import simpson
from scipy.linalg import expm

import lumped as lp
from lumped.components import (
    BearingFriction,
    Clutch,
    Damper,
    DCMotor,
    Fixed,
    Ground,
    Inertia,
    Spring,
    SpringDamper,
    Torque,
    VoltageSource,
    translation,
)
from lumped.errors import EquationError, Interrupted, SolverError
from lumped.ops import sin, where
from lumped.simulation.certify import compare_runs
from lumped.timeloop.run_by_steps import RunBySteps


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
    system = assemble_rows(
        "drive body.flange_a rub",
        drive=Torque(tau=3 * sin(lp.time)),
        body=Inertia(J=1.0),
        rub=BearingFriction(characteristic=((0.0, 1.0),)),
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
    class Impatient(RunBySteps):
        def go(self):
            if self.rtol < 1e-6:
                raise SolverError("enough")
            super().go()

    monkeypatch.setattr(import_module("lumped.simulation.simulate"), "RunBySteps", Impatient)
    system = lp.assemble(two_mass)
    with pytest.raises(SolverError, match=r"certify: the second run.*enough") as e:
        lp.simulate(system, until=1.0, rtol=1e-5, method="explicit", certify=True)
    assert e.value.partial.t[-1] == 1.0


def test_a_system_without_states_has_a_certificate():

    run = lp.simulate(assemble_row(push=Torque(tau=2.0), wall=Fixed()), until=1.0, certify=True)
    assert np.isnan(run.certificate.error)
    assert run.certificate["wall.flange.tau"].relative == 0.0


def braked():
    """A motor torque, two bodies on a damped shaft, a brake: three parts that store, two others."""
    return assemble_row(
        drive=Torque(tau=where(lp.time >= 0.7, -2.0, 5.0)),
        a=Inertia(J=2.0, w=3.0),
        shaft=SpringDamper(c=300.0, d=0.5, phi_rel0=0.01),
        b=Inertia(J=1.0),
        brake=Damper(d=1.5),
        wall=Fixed(),
    )


def balanced(system, **options):
    """A run, and its energy balance."""
    run = lp.simulate(system, certify=True, **options)
    print(run.certificate.energy)
    return run, run.certificate.energy


@pytest.mark.parametrize("method", ["explicit", "implicit", "auto"])
def test_the_energy_balance_is_that_of_the_matrix_exponential(method):
    a = np.zeros((4, 4))
    a[0, 1:3] = -1, 1  # twist, w_a, w_b, 1
    a[1] = 150, -0.25, 0.25, -1.5
    a[2] = -300, 0.5, -0.5 - 1.5, 3.0
    t = np.linspace(0, 2.0, 20001)
    z = [np.array([0, 3.0, 0, 1])]
    for tau, steps in ((5.0, 7000), (-2.0, 13_000)):
        driven = a.copy()
        driven[1, 3] += tau / 2
        step = expm(driven * 1e-4)
        for _ in range(steps):
            z.append(step @ z[-1])
    twist, w_a, w_b, _ = np.array(z).T
    loss = simpson(0.5 * (w_b - w_a) ** 2 + 1.5 * w_b**2, x=t)
    work = 5 * simpson(w_a[:7001], x=t[:7001]) - 2 * simpson(w_a[7000:], x=t[7000:])
    energy = 150 * (twist - 0.01) ** 2 + w_a**2 + w_b**2 / 2
    _, audit = balanced(braked(), until=2.0, rtol=1e-8, method=method)
    assert audit.components == ("a", "shaft", "b")
    assert audit.supplied == pytest.approx(work, rel=1e-6)
    assert audit.dissipated == pytest.approx(loss, rel=1e-6)
    assert audit.change == pytest.approx(energy[-1] - energy[0], rel=1e-6)
    assert audit.impacts == pytest.approx(0, abs=1e-12)
    assert audit.error < 1e-6


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-7])
def test_the_error_of_the_balance_is_the_drift_of_an_undamped_drive(two_mass, rtol):
    options = {"start": {"a.w": 1.0}, "rtol": rtol, "method": "explicit", "grid": None}
    run, audit = balanced(lp.assemble(two_mass), until=5.0, **options)
    energy = run["a.w"] ** 2 + run["b.w"] ** 2 / 2 + 150 * run["shaft.phi_rel"] ** 2
    assert audit.supplied == pytest.approx(0, abs=1e-14)
    assert audit.error == pytest.approx(np.abs(energy - 1).max() / energy.max(), rel=1e-6)


def test_what_a_clutch_dissipates_while_it_slips_is_told():
    """150 rad/s against a body at rest: J w^2 / 2 with J = J_a J_b / (J_a + J_b)."""
    model = in_a_row(
        a=Inertia(J=0.4, w=150.0), clutch=Clutch(f_max=168.0, u=1.0), b=Inertia(J=1.2, w=0.0)
    )
    _, audit = balanced(lp.assemble(model), until=1.0)
    assert audit.dissipated == pytest.approx(0.3 * 150.0**2 / 2, rel=1e-9)
    assert audit.change == pytest.approx(-0.3 * 150.0**2 / 2, rel=1e-9)
    assert audit.supplied == pytest.approx(0.0, abs=1e-6)
    assert audit.works == ()


def test_a_motor_gives_what_its_supply_gives_and_heats():
    v, R, k, J = 12.0, 0.5, 0.1, 0.02
    system = assemble_rows(
        "supply.p motor.p",
        "supply.n motor.n ground.pin",
        "motor.flange load",
        supply=VoltageSource(v=v),
        ground=Ground(),
        motor=DCMotor(J=1e-9, k=k, R=R, L=1e-9),
        load=Inertia(J=J),
    )
    t = 2.0
    run, audit = balanced(system, until=t, rtol=1e-9, method="implicit")
    T, w = R * J / k**2, v / k * (1 - np.exp(-t * k**2 / (R * J)))
    given = v * v / R * T * (1 - np.exp(-t / T))  # i = v / R exp(-t / T)
    assert run["load.w"][-1] == pytest.approx(w, rel=1e-6)
    assert dict(audit.works)["supply"] == pytest.approx(given, rel=1e-5)
    assert audit.dissipated == pytest.approx(v**2 / R * T / 2 * (1 - np.exp(-2 * t / T)), rel=1e-5)


def test_an_impact_loses_what_newton_says():
    model = in_a_row(
        body=translation.Mass(m=2.0, s=0.0, v=1.0),
        stop=translation.Stop(restitution=0.5),
        wall=translation.Fixed(s0=0.5),
    )
    _, audit = balanced(lp.assemble(model), until=1.0)
    assert audit.impacts == pytest.approx(0.75, rel=1e-12)
    assert audit.change == pytest.approx(-0.75, rel=1e-12)
    assert audit.error < 1e-12


def test_springs_in_series_without_a_body_between_them_balance():
    springs = {"one": Spring(c=300.0), "two": SpringDamper(c=200.0, d=0.7)}
    model = in_a_row(a=Inertia(J=2.0, w=1.0), **springs, b=Inertia(J=1.0))
    run, audit = balanced(lp.assemble(model), until=2.0, rtol=1e-8)
    kinetic = run["a.w"] ** 2 + run["b.w"] ** 2 / 2
    elastic = 150 * run["one.phi_rel"] ** 2 + 100 * run["two.phi_rel"] ** 2
    assert audit.supplied == pytest.approx(0, abs=1e-9)
    assert audit.dissipated == pytest.approx(1 - (kinetic + elastic)[-1], rel=1e-6)
    assert audit.dissipated > 0.1
    assert audit.error < 1e-6


class Leaking(Inertia):
    """Says that it stores what is not its own."""

    def stored(self):
        return self.w**2 * Inertia(J=1.0).w


def test_an_energy_of_foreign_quantities_is_refused(two_mass):
    with pytest.raises(EquationError, match=r"a \(Leaking\): .* only the component's own"):
        lp.simulate(lp.assemble(two_mass.with_({"a": Leaking(J=1.0)})), until=1.0, certify=True)


class Sampled(lp.Component):
    """A body under the torque -w, of which every 0.1 s a sample is taken."""

    w: lp.Var = lp.var("rad/s", "speed", 1.0)
    held: lp.Var = lp.var("1", "sample")
    due: lp.Var = lp.var("s", "instant of the next sample", 0.1)

    def equations(self):
        yield lp.der(self.w) == -30.0 * self.w
        yield lp.der(self.held) == 0
        yield lp.der(self.due) == 0
        yield lp.when(lp.time >= self.due, {self.held: self.w, self.due: self.due + 0.1})


@pytest.mark.parametrize("grid", [10, 7])
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_where_output_times_are_events_inner_instants_are_compared(grid, method):
    """All but the first and last of 11 output times are samples, so none may be compared."""
    run = lp.simulate(
        lp.assemble(Sampled()), until=1.0, grid=grid, rtol=1e-4, method=method, certify=True
    )
    found = run.certificate
    print(found)
    seen = found.states.t
    samples = np.arange(1, 11) * 0.1
    counts = np.bincount(np.searchsorted(samples, seen), minlength=10)[:10]
    assert (counts >= 1).all()
    if grid == 10:
        assert found.inner == 40
        assert (counts[1:9] == 4).all()
        assert np.abs(seen[:, None] - samples[:9]).min() > 1e-9
    assert f"compared at {len(seen)} instants from {seen[0]:.6g} to {seen[-1]:.6g} s" in repr(found)
    assert len(run.t) < len(found.run.t)
    # the estimate is the true error, at the very instants that were compared
    w, t = found.run["w"], found.run.t
    place = np.searchsorted(t, seen)
    error = np.abs(w[place] - np.exp(-30.0 * t[place]))
    assert found["w"].relative * np.ptp(w) == pytest.approx(error.max(), rel=0.1)
    assert error.max() > 1e-9


def test_a_closed_form_between_events_is_compared_inside_too():
    """A torque that jumps every 0.1 s, seen at these instants only."""
    torque = sum(where(lp.time >= 0.1 * k, (-1.0) ** k, 0.0) for k in range(1, 10))
    model = in_a_row(drive=Torque(tau=torque), body=Inertia(J=1.0, w=1.0))
    grid = np.arange(11) * 0.1
    run = lp.simulate(lp.assemble(model), until=1.0, grid=grid, certify=True, method="exact")
    assert run.statistics.method == run.certificate.run.statistics.method == "exact"
    assert run.certificate.inner == 40
    assert run.certificate.error < 1e-6
    assert run.certificate.energy.error < 1e-9


def test_a_comparison_of_nothing_is_no_agreement(two_mass):
    run = lp.simulate(lp.assemble(two_mass), until=1.0, grid=[0.5])
    spoiled = replace(run, events=(lp.simulation.Event(0.5, "shaft", "condition", "a", "b"),))
    found = compare_runs(spoiled, spoiled, 1e-9, ["a.w"])
    assert np.isnan(found.worst.relative)
    assert len(found.t) == 0


def test_what_only_seems_to_vary_is_measured_by_its_size():
    # steady at -1.5 rad but for a swing of 1e-7 of it, which the tolerance does not see
    parts = {"motor": Inertia(J=1.0), "shaft": Spring(c=10.0), "body": Inertia(J=1.0)}
    system = assemble_row(drive=Torque(tau=20.0), **parts, load=Torque(tau=-10.0))
    start = {"shaft.phi_rel": -1.5 * (1 + 1e-7), "motor.w": 15.0, "body.w": 15.0}
    run = lp.simulate(system, until=2.0, method="explicit", certify=True, start=start)
    found = run.certificate["shaft.phi_rel"]
    assert found.range == pytest.approx(1.5, rel=1e-6)
    assert found.relative < 1e-6


def test_an_interrupt_while_certifying_leaves_the_run(two_mass, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(import_module("lumped.simulation.simulate"), "audit_energy", interrupted)
    with pytest.raises(Interrupted, match="interrupted while it was certified") as caught:
        lp.simulate(lp.assemble(two_mass), until=1.0, certify=True)
    assert caught.value.partial.t[-1] == 1.0


@pytest.mark.parametrize("rtol", [1e-3, 1e-6])
def test_a_coarse_run_asks_for_a_tighter_one_before_it_blames_the_model(rtol):
    class Grows(lp.Component):
        x: lp.Var = lp.var("1", "growing", 1.0)

        def equations(self):
            yield lp.der(self.x) == self.x**2

    with pytest.raises(SolverError, match=r"runs to infinity|finite|numbers") as caught:
        lp.simulate(lp.assemble(Grows()), until=2.0, rtol=rtol)
    asks = str(caught.value).startswith("At rtol = 0.001 this may be the error of the run itself")
    assert asks == (rtol > 1e-6)
    assert caught.value.partial.t[-1] == pytest.approx(1.0, abs=0.1)
