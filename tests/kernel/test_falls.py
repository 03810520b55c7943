"""Margins as polynomials: none of their roots in a long step by series is missed."""

from types import SimpleNamespace

import hybrid_drives
import numpy as np
import pytest
from ensemble_runs import Alone, assert_same_bits, ran
from numpy.polynomial import Polynomial
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import lumped as lp
from lumped import functionals as fun
from lumped.kernel import engine, falls
from lumped.kernel.run import MOST_HALVINGS

# -- polynomials -----------------------------------------------------------------------------------


def margin(coefficients, h=1.0):
    """What kernels read of a run with one margin, a polynomial of the part of a step of length h.

    Coefficients are kept as those of an integral.
    """
    n = len(coefficients) - 1
    kept = np.concatenate([[0.0], [c / h**j / (j + 1) for j, c in enumerate(coefficients)]])
    return SimpleNamespace(
        order=n,
        row=1,
        columns=0,
        coefficients=kept,
        margin=np.array([coefficients[0]]),
        tolerance=np.zeros(1),
        bernstein=np.zeros((MOST_HALVINGS + 1) * (n + 3)),
        halves=np.zeros(2),
    )


def first_fall(polynomial, h=0.3):
    """The interval that is found; None if there is none."""
    run = margin(polynomial.coef, h)
    return tuple(run.halves) if falls.first_fall(run, 0, h) else None


def with_roots(roots, scale=1.0):
    """A polynomial that is positive before its first root."""
    sign = (-1.0) ** sum(r > 0 for r in roots)
    return scale * sign * Polynomial.fromroots(roots)


def test_the_first_of_many_random_roots_is_isolated():
    rng, found = np.random.default_rng(3), 0
    for _ in range(400):
        roots = np.sort(rng.uniform(-0.3, 1.3, rng.integers(1, 9)))
        if np.diff(roots, prepend=-1).min() < 1e-3:
            continue
        inside = roots[(roots > 0) & (roots <= 1)]
        interval = first_fall(with_roots(roots.tolist()))
        assert (interval is not None) == (len(inside) > 0), roots
        if interval is not None:
            found += 1
            assert interval[0] <= inside[0] < interval[1], roots
            assert len(inside) == 1 or inside[1] >= interval[1], roots
    assert found > 200


def test_lower_bounds_hold_and_do_not_tell_of_roots_that_are_far():
    rng = np.random.default_rng(4)
    s, clear = np.linspace(0, 1, 2001), 0
    for _ in range(200):
        c = rng.normal(size=rng.integers(3, 20)) / np.arange(1, 100)[: rng.integers(3, 20)].max()
        c[0] = abs(c[0]) + 0.5
        run = margin(c)
        least, size = Polynomial(c)(s).min(), np.abs(c).sum()
        rough = falls.rest(run, 0, 1.0)
        better = falls.least(run, 0, 1.0, rough)
        assert rough <= better + 1e-13 * size
        assert better <= least + 1e-13 * size
        clear += better > 0
    assert 20 < clear < 200


@pytest.mark.parametrize(
    ("roots", "first"),
    [
        ([0.5], 0.5),  # where the step is halved
        ([0.25, 0.5, 0.75], 0.25),
        ([0.0, 0.7], 0.7),  # begins at zero
        ([1.0], None),  # ends at zero: it falls in the next step
        ([0.3, 0.3], None),  # touches
        ([0.3, 0.3, 0.8], 0.8),
        ([0.4, 0.4, 0.4], 0.4),
        ([0.6, 0.6 + 1e-6], 0.6),
        ([0.5 - 1e-6, 0.5 + 1e-6], 0.5 - 1e-6),
        ([0.1 * k for k in range(1, 10)], 0.1),
    ],
)
def test_roots_at_ends_double_and_close_ones(roots, first):
    polynomial = with_roots(roots)
    interval = first_fall(polynomial)
    if first is None:
        assert interval is None
    else:
        low, high = interval
        assert low <= first + 1e-9
        assert first < high
        assert polynomial(high) < 0


# -- runs ------------------------------------------------------------------------------------------


class Swing(lp.Component):
    """``x = sin(t)``, ``y = cos(t)``; n counts the time in which x is above a border."""

    x: lp.Var = lp.var("m", "position", start=0.0)
    y: lp.Var = lp.var("m/s", "velocity", start=1.0)
    n: lp.Var = lp.var("s", "time above", start=0.0)
    border: lp.Param = lp.param("m", "border", 0.5)

    def equations(self):
        yield lp.der(self.x) == self.y
        yield lp.der(self.y) == -self.x
        yield lp.der(self.n) == lp.ops.where(self.x > self.border, 1.0, 0.0)


def passed(border, end):
    """Instants at which the sine passes a border; near its peak asin is not accurate."""
    ahead = 2 * np.arcsin(np.sqrt((1 - border) / 2))
    peaks = np.pi / 2 + 2 * np.pi * np.arange(int(end / 2 / np.pi) + 1)
    found = np.sort(np.concatenate([peaks - ahead, peaks + ahead]))
    return found[found < end]


@pytest.mark.parametrize("above", [0.5, 1e-3, 1e-6, 1e-8, 1e-10])
def test_a_peak_that_passes_a_border_for_an_instant(above):
    border = 1 - above
    run = lp.simulate(lp.assemble(Swing(border=border)), until=18.0, rtol=1e-12, method="taylor")
    expected, times = passed(border, 18.0), [event.time for event in run.events]
    assert len(times) == len(expected)
    error = np.abs(times - expected).max()
    slope = np.sqrt(2 * above)
    print(f"{above:g}: {run.statistics.steps} steps, instants off by {error:.1e} s")
    assert run.statistics.steps < 25
    assert error * slope < 1e-11  # in x
    assert abs(run["n"][-1] - np.diff(expected)[::2].sum()) < 1e-11 / slope + 1e-12


def test_a_peak_that_does_not_reach_a_border():
    for border in (1.0 + 1e-10, 1.0):
        system = lp.assemble(Swing(border=border))
        run = lp.simulate(system, until=18.0, rtol=1e-12, method="taylor")
        assert not run.events, border


class Chebyshev(lp.Component):
    """``x = cos(t)`` passes zeros of ``T_7(x) - 0.3 == cos(7 t) - 0.3``, many in one step."""

    x: lp.Var = lp.var("m", "position", start=1.0)
    y: lp.Var = lp.var("m/s", "velocity", start=0.0)
    n: lp.Var = lp.var("s", "time above", start=0.0)

    def equations(self):
        x = self.x
        high = x * (x**2 * (x**2 * (64 * x**2 - 112) + 56) - 7)
        yield lp.der(x) == self.y
        yield lp.der(self.y) == -x
        yield lp.der(self.n) == lp.ops.where(high > 0.3, 1.0, 0.0)


def test_many_roots_in_a_step():
    run = lp.simulate(lp.assemble(Chebyshev()), until=6.0, rtol=1e-11, method="taylor")
    a, turns = np.arccos(0.3), 2 * np.pi * np.arange(8)
    expected = np.sort(np.concatenate([turns + a, turns + 2 * np.pi - a])) / 7
    expected = expected[expected < 6.0]
    error = np.abs(np.array([event.time for event in run.events]) - expected).max()
    print(f"{len(expected)} events, off by {error:.1e} s")
    assert len(expected) == 13
    assert error < 1e-10


def test_margins_without_series_are_sampled():
    """A border that is a spline over the position of something else."""
    knots, heights = np.linspace(0, 2 * np.pi, 7), [0.2, 0.6, -0.3, 0.4, 0.7, -0.5, 0.2]

    def equations(self):
        border = lp.ops.periodic_spline(self.phi, knots, heights)
        yield lp.der(self.phi) == 1.0
        yield lp.der(self.n) == lp.ops.where(lp.ops.sin(3 * self.phi) > border, 1.0, 0.0)

    phi, n = lp.var("rad", "angle", start=0.1), lp.var("1", "counted", start=0.0)
    kind = type("Part", (lp.Component,), {"__doc__": ".", "phi": phi, "n": n})
    kind.equations = equations
    run = lp.simulate(lp.assemble(kind()), until=6.0, rtol=1e-10, method="taylor")
    curve = CubicSpline(knots, heights, bc_type="periodic")

    def law(t):
        return np.sin(3 * (t + 0.1)) - curve((t + 0.1) % (2 * np.pi))

    t = np.linspace(0, 6.0, 6001)
    ends = np.flatnonzero(np.diff(np.sign(law(t))))
    expected = [brentq(law, t[i], t[i + 1], xtol=1e-14) for i in ends]
    assert len(expected) >= 4
    np.testing.assert_allclose([e.time for e in run.events], expected, rtol=0, atol=1e-9)


def test_a_margin_with_a_root_at_zero_is_sampled():
    """``sqrt(t)`` has no series at 0; it passes 0.5 at 0.25 s."""

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield lp.der(self.n) == lp.ops.where(lp.ops.sqrt(self.x) > 0.5, 1.0, 0.0)

    x, n = lp.var("1", "time", start=0.0), lp.var("1", "counted", start=0.0)
    kind = type("Part", (lp.Component,), {"__doc__": ".", "x": x, "n": n, "equations": equations})
    run = lp.simulate(lp.assemble(kind()), until=1.0, rtol=1e-10, method="taylor")
    assert [e.time for e in run.events] == [pytest.approx(0.25, rel=1e-12)]
    assert run["n"][-1] == pytest.approx(0.75, rel=1e-12)


@pytest.mark.parametrize("seed", [*range(700, 712), 723, 731])
def test_random_hybrid_drives_have_the_events_of_dop853(seed):
    system = lp.assemble(hybrid_drives.RandomDrive(seed).model())
    options = {"until": hybrid_drives.END, "rtol": 1e-9, "grid": [hybrid_drives.END]}
    runs = [lp.simulate(system, method=m, **options) for m in ("taylor", "steps")]
    told = [sorted((e.component, e.after, e.time) for e in run.events) for run in runs]
    series, steps = ([event[:2] for event in events] for events in told)
    assert series == steps
    apart = [abs(a[2] - b[2]) for a, b in zip(*told, strict=True)]
    print(f"{len(apart)} events, {max(apart, default=0):.1e} s apart")
    assert max(apart, default=0) < 1e-6


def test_engines_and_lanes_find_the_same_instants():
    border = 1 - 1e-10
    system = lp.assemble(Swing(border=border))
    options = {"until": 20.0, "rtol": 1e-11, "method": "taylor"}
    expected = [event.time for event in lp.simulate(system, **options).events]
    assert len(expected) == 6
    for name in ("c", "python"):
        with engine.using(name):
            assert [event.time for event in lp.simulate(system, **options).events] == expected
    name = lp.simulate(system, **options).events[0].component
    of = {"count": fun.count(name), "first": fun.instant(name), "n": fun.final("n")}
    points = np.append(1 - np.logspace(-10, -1, 10), border)[:, None]
    lanes, alone = (
        ran(system, ["border"], points, of, kind=kind, **options)
        for kind in (lp.ensembles.native_runs.NativeRuns, Alone)
    )
    assert_same_bits(lanes, alone)
    assert lanes.values[-1, :2].tolist() == [6, expected[0]]
