"""Error against run time, where the error is known."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import BearingFriction, Damper, Fixed, Inertia, Spring, SpringDamper, Torque
from lumped.errors import OptionError
from lumped.ops import sin, where
from lumped.simulation.certify import compare_runs

W = np.sqrt(450.0)


def test_errors_are_those_against_the_closed_form(two_mass):
    system = lp.assemble(two_mass)
    until, ladder = 3.0, (1e-4, 1e-7)
    found = lp.simulation.work_precision(
        system, until=until, of=["shaft.phi_rel"], tolerances=ladder, start={"a.w": 1.0}
    )
    print(found)
    t = np.linspace(0, until, 998)
    expected = -np.sin(W * t) / W
    assert [r.method for r in found.rows[::2]] == ["explicit", "implicit", "exact", "auto"]
    for row in found.rows:
        run = lp.simulate(
            *(system,), until=until, grid=t, start={"a.w": 1.0}, rtol=row.rtol, method=row.method
        )
        error = np.abs(run["shaft.phi_rel"] - expected).max() / np.ptp(expected)
        assert row.error == pytest.approx(error, rel=1e-3, abs=1e-12)
        assert (row.steps, row.outcome) == (run.steps, "ok")
        assert 0 < row.seconds < 1
    assert found.reference_error < 0.1 * min(ladder)


def test_the_fastest_is_the_fastest_that_is_accurate_enough(two_mass):
    system = lp.assemble(two_mass)
    found = lp.simulation.work_precision(
        system, until=1.0, start={"a.w": 1.0}, methods=["explicit", "implicit"]
    )
    best = found.fastest(1e-6)
    assert best.error <= 1e-6
    others = [r.seconds for r in found.rows if r.error <= 1e-6]
    assert best.seconds == min(others)
    assert len(others) < len(found.rows)
    with pytest.raises(OptionError, match="no run has an error of 1e-11"):
        found.fastest(1e-11)
    with pytest.raises(OptionError, match="the error of the reference itself"):
        found.fastest(1e-16)


def braked():
    """A body that friction stops, under a torque that comes and goes."""
    return lp.compose(
        drive=Torque(tau=where(lp.time >= 1.0, 0.0, 3 * sin(4 * lp.time))),
        body=Inertia(J=1.0),
        rub=BearingFriction(characteristic=((0.0, 1.0),)),
        connections=lambda m: [lp.connect(m.drive.flange, m.body.flange_a, m.rub.flange_a)],
    )


def test_events_at_different_instants_are_no_error():
    system = lp.assemble(braked())
    names = ["body.w", "rub.tau"]
    found = lp.simulation.work_precision(system, until=2.0, of=names, tolerances=[1e-3, 1e-6])
    print(found)
    assert all(row.outcome == "ok" for row in found.rows)
    assert 0 < found.window < 1e-2
    assert max(row.error for row in found.rows) < 3e-3
    assert max(row.error for row in found.rows if row.rtol == 1e-6) < 3e-6


def test_a_missed_event_counts():
    system = lp.assemble(braked())
    grid = np.linspace(0, 2.0, 1001)
    right = lp.simulate(system, until=2.0, grid=grid)
    free = lp.simulate(
        lp.assemble(braked().with_({"rub": BearingFriction(characteristic=((0.0, 1e-6),))})),
        until=2.0,
        grid=grid,
    )
    comparison = compare_runs(free, right, 1e-9, ["body.w"])
    print(comparison)
    assert "in the reference" in comparison.missed
    assert comparison.worst.relative > 0.1


def test_a_run_that_fails_is_a_row_with_its_reason():
    model = in_a_row(
        drive=Torque(tau=sin(lp.time)),
        motor=Inertia(J=1e-6),
        coupling=SpringDamper(c=1e9, d=1e6),
        rotor=Inertia(J=1.0),
        load=Damper(d=2.0),
        ground=Fixed(),
    )
    found = lp.simulation.work_precision(
        lp.assemble(model),
        until=1.0,
        of=["rotor.w"],
        tolerances=[1e-4],
        methods=["explicit", "implicit", "exact", "auto"],
    )
    print(found)
    explicit, implicit, exact, auto = found.rows
    assert "max_steps" in explicit.outcome
    assert explicit.steps > 100_000
    assert "polynomial" in exact.outcome
    assert np.isnan([explicit.error, exact.error, exact.seconds]).all()
    assert implicit.error < 1e-4 > auto.error
    assert "max_steps" in repr(found)
    assert found.plot().axes[0].get_legend() is not None


def test_what_makes_no_sense_is_refused(two_mass):
    system = lp.assemble(two_mass)
    with pytest.raises(OptionError, match="at least one tolerance"):
        lp.simulation.work_precision(system, until=1.0, tolerances=[])
    empty = in_a_row(a=Fixed(), b=Spring(c=1.0), c=Fixed())
    with pytest.raises(OptionError, match="no states to compare"):
        lp.simulation.work_precision(lp.assemble(empty), until=1.0)
