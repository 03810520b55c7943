"""Runs and ensembles by series."""

import casadi as ca
import numpy as np
import pytest
from ensemble_runs import Alone, all_functionals, assert_same_bits, drive, ran
from rows import assemble_one, in_a_row
from scipy.linalg import expm
from test_taylor import pendulum

import lumped as lp
from lumped import functionals as fun
from lumped.code.operations import operations_of
from lumped.code.taylor import series_of
from lumped.components import Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.many_runs.native_runs import NativeRuns
from lumped.timeloop.plants.executable import executable

INERTIAS, STIFFNESSES, DELAY, TORQUE = (0.5, 1.2, 3.0), (4e4, 2.5e4), 1e-4, 100.0


def three_masses(**load):
    shafts = [SpringDamper(c=c, d=DELAY * c) for c in STIFFNESSES]
    return lp.compose(
        motor=Torque(tau=TORQUE),
        mass=[Inertia(J=J) for J in INERTIAS],
        shaft=shafts,
        **load,
        connections=lambda m: lp.chain(
            m.motor, m.mass[0], m.shaft[0], m.mass[1], m.shaft[1], m.mass[2]
        ),
    )


def speeds(times):
    """Speeds of three masses by the exponential of their matrix."""
    matrix = np.zeros((6, 6))
    matrix[0, 2:4] = matrix[1, 3:5] = 1.0, -1.0
    for k, c in enumerate(STIFFNESSES):
        pull = np.zeros(6)
        pull[k], pull[2 + k], pull[3 + k] = c, DELAY * c, -DELAY * c
        matrix[2 + k] -= pull / INERTIAS[k]
        matrix[3 + k] += pull / INERTIAS[k + 1]
    matrix[2, 5] = TORQUE / INERTIAS[0]
    return np.array([expm(t * matrix)[2:5, 5] for t in times])


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9, 1e-12])
def test_three_masses_at_output_times_inside_long_steps(rtol):
    run = lp.simulate(lp.assemble(three_masses()), until=0.5, grid=200, rtol=rtol, method="taylor")
    exact = speeds(run.t)
    error = np.abs(run.table([f"mass[{k}].w" for k in range(3)]) - exact).max() / exact.max()
    print(f"rtol {rtol:g}: {run.statistics.steps} steps, error {error / rtol:.2g} rtol")
    assert run.statistics.method == "taylor"
    assert error < max(3 * rtol, 1e-13)


def test_a_short_dip_before_another_event_in_a_long_step():
    """A body turns back just after it leaves; another condition changes a little later."""

    def equations(self):
        t = lp.time
        yield lp.der(self.x) == 1e-3 - 0.2 * t + t**2 + 0 * self.y
        yield lp.der(self.y) == 1.0
        yield lp.der(self.n) == lp.ops.where(self.x >= -5e-6, 0.0, 1.0)
        yield lp.der(self.k) == lp.ops.where(self.y >= 0.25, 1.0, 0.0)

    names = {name: lp.var("1", "counted", start=0.0) for name in "xynk"}
    run = lp.simulate(
        assemble_one(**names, equations=equations), until=1.0, rtol=1e-9, method="taylor"
    )
    x = np.poly1d([1 / 3, -0.1, 1e-3, 0.0])
    crossings = sorted(r.real for r in (x + 5e-6).roots if abs(r.imag) < 1e-9 and 0 < r.real < 1)
    expected = sorted([*crossings, 0.25])
    np.testing.assert_allclose([e.time for e in run.events], expected, atol=1e-9)


def test_a_root_at_zero_is_passed_in_another_way():
    """``v' = -x^1.5`` has no series at ``x = 0``; there ``v^2 / 2 + x^2.5 / 2.5`` stays."""

    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == -(self.x**1.5)

    x, v = lp.var("m", "position", start=0.0), lp.var("m/s", "velocity", start=1.0)
    system = assemble_one(x=x, v=v, equations=equations)
    run = lp.simulate(system, until=1.0, method="taylor", rtol=1e-9)
    np.testing.assert_allclose(run["v"] ** 2 / 2 + run["x"] ** 2.5 / 2.5, 0.5, rtol=1e-8)
    of = [fun.final("x"), fun.peak("v"), fun.rms("v")]
    given = {"until": 1.0, "rtol": 1e-9, "method": "taylor"}
    lanes, alone = (
        ran(system, [], np.zeros((9, 0)), {str(f): f for f in of}, kind=kind, **given)
        for kind in (NativeRuns, Alone)
    )
    assert_same_bits(lanes, alone)
    assert lanes.values[0, 0] == pytest.approx(run["x"][-1], rel=1e-15)


def test_a_switch_that_no_coefficient_shows_is_not_jumped_over():
    """All coefficients of ``1 + tanh(1000 (t - 1))`` at 0 are rounded to zero; it holds after 1."""

    def equations(self):
        yield lp.der(self.x) == 1 + lp.ops.tanh(1e3 * (lp.time - 1.0))

    system = assemble_one(x=lp.var("m", "position", start=0.0), equations=equations)
    run = lp.simulate(system, until=2.0, method="taylor", rtol=1e-8)
    print(run.statistics)
    assert run["x"][-1] == pytest.approx(2.0, rel=1e-8)


def stiff_shaft():
    """A spring of a millisecond, damped, between bodies that move in seconds."""
    return in_a_row(
        motor=Torque(tau=10 * lp.ops.sin(2 * lp.time)),
        rotor=Inertia(J=1.0),
        shaft=SpringDamper(c=1e6, d=2e3),
        load=Inertia(J=1.0),
        slip=Damper(d=1.0),
        ground=Fixed(),
    )


def test_series_give_way_where_stability_holds_their_steps():
    """The two bodies turn as one: ``2 w' + w == 10 sin(2 t)``, but for a twist of 1e-5 rad."""
    system = lp.assemble(stiff_shaft())
    run = lp.simulate(system, until=20.0, method="taylor", rtol=1e-6)
    t = run.t
    rigid = 10 / 17 * (np.sin(2 * t) - 4 * np.cos(2 * t) + 4 * np.exp(-t / 2))
    error = np.abs(run["load.w"] - rigid).max() / np.abs(rigid).max()
    print(f"{run.statistics.method}, {run.statistics.steps} steps, error {error:.1e}")
    assert run.statistics.method == "taylor then implicit"
    assert "series until" in run.statistics.why
    assert run.statistics.steps < 1000  # by series alone 11 000
    assert error < 1e-4


W, SWING, PUSH = 10.0, 3.0, 5.0


def driven_spring():
    """An undamped mass on a spring under a swinging torque."""
    return in_a_row(
        ground=Fixed(),
        spring=SpringDamper(c=W**2, d=0.0),
        body=Inertia(J=1.0, w=1.0),
        motor=Torque(tau=PUSH * lp.ops.sin(SWING * lp.time)),
    )


def test_series_stay_where_longer_steps_would_not_be_accurate():
    run = lp.simulate(lp.assemble(driven_spring()), until=400.0, method="taylor", rtol=1e-6)
    assert run.statistics.steps > 600  # after 500 a trial is due in any case
    assert run.statistics.method == "taylor"


def test_a_long_run_goes_on_by_series():
    runs = [
        lp.simulate(lp.assemble(driven_spring()), until=3000.0, grid=300, rtol=1e-10, method=method)
        for method in ("auto", "auto", "steps")
    ]
    twice, t = runs[:2], runs[0].t
    size = PUSH / (W**2 - SWING**2)
    exact = size * np.sin(SWING * t) + (1 - size * SWING) / W * np.sin(W * t)
    errors = [np.abs(run["spring.phi_rel"] - exact).max() for run in runs]
    assert [run.statistics.method for run in runs] == [*["explicit then taylor"] * 2, "explicit"]
    assert 50_000 < runs[0].statistics.steps < 0.7 * runs[2].statistics.steps
    np.testing.assert_array_equal(*(run["spring.phi_rel"] for run in twice))
    assert max(errors) < 1e-7 * np.abs(exact).max()


@pytest.mark.parametrize(
    ("kind", "seed"), [("hybrid", 704), ("hybrid", 709), ("smooth", 2101), ("smooth", 2105)]
)
def test_lanes_give_the_bits_of_single_runs(kind, seed):
    system, until, varied, points = drive(kind, seed)
    of = all_functionals(system, until)
    options = {"method": "taylor", "rtol": 1e-7}
    lanes = ran(system, varied, points, of, until, **options)
    assert_same_bits(lanes, ran(system, varied, points, of, until, Alone, **options))
    close = ran(system, varied, points, of, until, method="explicit", rtol=1e-10)
    for label, a, b in zip(of, lanes.values.T, close.values.T, strict=True):
        if label.startswith(("final", "peak", "rms")):
            assert np.nanmax(np.abs(a - b)) < 1e-5 * (1e-3 + np.nanmax(np.abs(b))), label


def test_functionals_of_long_steps_against_those_of_many_points():
    system, times = lp.assemble(three_masses()), np.linspace(0, 0.5, 20001)
    of = {
        "peak": fun.peak("shaft[0].tau"),
        "rms": fun.rms("shaft[1].tau"),
        "mean": fun.mean("mass[1].w"),
        "part": fun.mean("mass[1].w", between=(0.1003, 0.3001)),
    }
    over = {"mass[0].J": [0.5, 0.51]}
    found = lp.ensemble(system, over=over, until=0.5, of=of, method="taylor", rtol=1e-9)
    run = lp.simulate(system, until=0.5, grid=times, method="explicit", rtol=1e-12)
    shafts = run.table(["shaft[0].tau", "shaft[1].tau"])
    expected = [
        np.abs(shafts[:, 0]).max(),
        np.sqrt(np.trapezoid(shafts[:, 1] ** 2, times) / 0.5),
        np.trapezoid(run["mass[1].w"], times) / 0.5,
    ]
    np.testing.assert_allclose(found.values[0, :3], expected, rtol=2e-6)
    inside = (times >= 0.1003 - 1e-12) & (times <= 0.3001 + 1e-12)
    part = np.trapezoid(run["mass[1].w"][inside], times[inside]) / 0.1998
    assert found.values[0, 3] == pytest.approx(part, rel=2e-6)


def test_integrals_have_series_where_those_are_as_good_as_the_steps():
    """Beside a linear system only linear quantities; beside others all."""
    linear, other = lp.assemble(three_masses()), lp.assemble(pendulum())
    for system, is_kept in ((linear, False), (other, True)):
        x = system.inputs[0]
        square = operations_of(ca.Function("q", system.inputs, [x[0] ** 2]))
        plain = operations_of(ca.Function("q", system.inputs, [3 * x[0]]))
        own = executable(system).taylor
        assert (own.with_integrals(square) is not own) == is_kept
        assert own.with_integrals(plain) is not own
        assert series_of(plain).is_linear
        assert not series_of(square).is_linear
