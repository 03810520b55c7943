"""Enclosures of quantities over a part of a step, and the events that rest on them."""

from types import SimpleNamespace

import casadi as ca
import casadi_operations
import hybrid_drives
import numpy as np
import pytest
from ensemble_runs import Alone, assert_same_bits, ran
from numpy.polynomial import Polynomial
from rows import assemble_one
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import lumped as lp
from lumped import functionals as fun
from lumped.code.operations import operations_of
from lumped.kernel import engine
from lumped.kernel.enclosed import Enclosed
from lumped.kernel.enclosures import enclosure
from lumped.kernel.enclosures.models import REST, to_bernstein
from lumped.many_runs.native_runs import NativeRuns

# -- models ----------------------------------------------------------------------------------------

ONE = casadi_operations.ONE | {
    "asin": lambda a: ca.asin(0.9 * ca.sin(a)),
    "acos": lambda a: ca.acos(0.9 * ca.cos(a)),
    "log": lambda a: ca.log(1.1 + ca.sin(a)),
    "log1p": lambda a: ca.log1p(a * a),
    "sqrt": lambda a: ca.sqrt(a * a + 0.01),
    "acosh": lambda a: ca.acosh(1.5 + a * a),
    "atanh": lambda a: ca.atanh(0.9 * ca.sin(a)),
    "ninth": lambda a: a**9,
    "tenth": lambda a: a**10,
    "minus two": lambda a: (a * a + 0.5) ** -2.0,
    "minus three": lambda a: (a + 0.1) ** -3,
    "one and a half": lambda a: ca.fabs(a) ** 1.5,
}
TWO = casadi_operations.TWO | {
    "power": lambda a, b: (a * a + 0.3) ** b,
    "less": lambda a, b: ca.if_else(a < b, a, 2 * b),
    "at most": lambda a, b: ca.if_else(a <= b, 1.0, b),
    "and": lambda a, b: ca.logic_and(a > 0, b > 0) * a,
    "or": lambda a, b: ca.logic_or(a > 0, b != 0),
    "not": lambda a, b: ca.logic_not(a > b) - (a == b),
}


class Step:
    """A step of unit length by series, and a function that is enclosed in parts of it."""

    def __init__(self, expression, symbols, coefficients):
        x, t = symbols
        p, m = ca.SX.sym("p"), ca.SX.sym("m")
        self.function = ca.Function("f", [x, p, t, m], [ca.densify(p * 0 + expression)])
        operations = operations_of(self.function)
        self.coefficients = np.asarray(coefficients)
        n, order = self.coefficients.shape[1], len(self.coefficients) - 1
        self.made = SimpleNamespace(
            count=len(operations.table),
            operations=operations.table.ravel(),
            constants=operations.constants,
        )
        self.run = SimpleNamespace(
            plant=SimpleNamespace(states=n),
            is_implicit=0,
            by_series=1,
            order=order,
            row=n,
            coefficients=self.coefficients.ravel(),
            t=0.0,
            t_new=1.0,
            p=np.array([0.7]),
            m=np.array([1.0]),
            dense=np.zeros(0),
            powers=np.zeros(64),
            bernstein=np.zeros(64),
        )
        sizes = {"enclosed_results": 1, "enclosed_work": operations.work}
        sizes["enclosed_rows"] = len(operations.table)
        self.enclosed = Enclosed(sizes, results=1)
        self.enclosed.is_open[0] = 1
        with np.errstate(all="ignore"):
            enclosure.select_open(self.run, self.enclosed, self.made, False)

    def bounds(self, begin, width):
        """Lower and upper bound by the Bernstein coefficients and the rest."""
        with np.errstate(all="ignore"):
            enclosure.enclose(self.run, self.enclosed, self.made, begin, width)
            top = to_bernstein(self.enclosed.model, self.run.bernstein)
        b, rest = self.run.bernstein[: top + 1], self.enclosed.model[REST]
        return b.min() - rest, b.max() + rest

    def values(self, begin, width):
        """Values in a part of the step."""
        u = begin + width * np.linspace(0, 1, 101)
        x = np.array([Polynomial(c)(u) for c in self.coefficients.T])
        with np.errstate(all="ignore"):
            found = self.function(x, self.run.p, u[None, :], self.run.m)
        return np.asarray(found).ravel()


def checked(step, begin, width):
    """Compare bounds with values in a part; give the width of the bounds and the spread."""
    least, most = step.bounds(begin, width)
    values = step.values(begin, width)
    values = values[np.isfinite(values)]
    if not len(values):
        return np.inf, 0.0
    slack = 1e-12 * (1 + np.abs(values).max())
    assert values.min() >= least - slack
    assert values.max() <= most + slack
    return most - least, np.ptp(values)


@pytest.mark.parametrize("name", [*ONE, *TWO])
def test_bounds_hold_what_an_operation_gives(name):
    rng = np.random.default_rng(sum(map(ord, name)))
    x, t = ca.SX.sym("x", 2), ca.SX.sym("t")
    for k in range(40):
        c = rng.normal(size=(rng.integers(2, 13), 2))
        c = c / np.arange(1, len(c) + 1)[:, None]
        a, b = (x[0], x[1]) if k % 2 else (x[0] * x[1], t - x[1])
        law = ONE[name](a) if name in ONE else TWO[name](a, b)
        step = Step(law, (x, t), c)
        for width in (1.0, 0.1, 1e-3):
            checked(step, rng.uniform(0, 1 - width), width)


@pytest.mark.parametrize("name", sorted(ONE.keys() - {"sign", "floor", "ceil", "fabs", "not"}))
def test_bounds_of_smooth_functions_close_in_fast(name):
    """What a model lacks falls with the eighth power of the width.

    Inverses of hyperbolic functions, the error function and powers of sizes are intervals.
    """
    x, t = ca.SX.sym("x", 2), ca.SX.sym("t")
    step = Step(ONE[name](x[0]), (x, t), [[0.4, 0.0], [0.5, 0.0], [-0.2, 0.0]])
    width, spread = checked(step, 0.3, 0.01)
    slow = name in ("asinh", "acosh", "atanh", "erf")
    assert width <= spread * (1.01 if slow else 1 + 1e-3) + 1e-12


def test_what_is_linear_in_states_and_time_is_exact():
    """Differences cancel, so a margin that rests at zero is no reason to look closer."""
    rng = np.random.default_rng(1)
    x, t = ca.SX.sym("x", 3), ca.SX.sym("t")
    c = rng.normal(size=(8, 3))
    c[:, 2] = 0.3 * c[:, 0] - 0.7 * c[:, 1]
    step = Step(2 * x[2] - (0.6 * x[0] - 1.4 * x[1]) + 1e-9 * t, (x, t), c)
    least, most = step.bounds(0.0, 1.0)
    assert abs(least) < 1e-14
    assert most == pytest.approx(1e-9, abs=1e-14)


@pytest.mark.parametrize("seed", range(30))
def test_bounds_hold_for_nested_functions(seed):
    rng = np.random.default_rng(seed)
    x, t = ca.SX.sym("x", 3), ca.SX.sym("t")
    pool = [x[0], x[1], x[2], t, ca.SX(float(rng.normal())), 1.5 * x[0] - x[1]]
    one, two = list(ONE.values()), list(TWO.values())
    for _ in range(8):
        a, b = (pool[i] for i in rng.integers(len(pool), size=2))
        made = rng.random() < 0.4
        pool.append(one[rng.integers(len(one))](a) if made else two[rng.integers(len(two))](a, b))
    step = Step(pool[-1], (x, t), rng.normal(size=(6, 3)) / 2.0 ** np.arange(6)[:, None])
    for width in (1.0, 0.3, 0.03, 1e-3, 1e-5):
        checked(step, rng.uniform(0, 1 - width), width)


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


def test_margins_without_series_are_enclosed():
    """A border that is a spline over the position of something else."""
    knots, heights = np.linspace(0, 2 * np.pi, 7), [0.2, 0.6, -0.3, 0.4, 0.7, -0.5, 0.2]

    def equations(self):
        border = lp.ops.periodic_spline(self.phi, knots, heights)
        yield lp.der(self.phi) == 1.0
        yield lp.der(self.n) == lp.ops.where(lp.ops.sin(3 * self.phi) > border, 1.0, 0.0)

    phi, n = lp.var("rad", "angle", start=0.1), lp.var("1", "counted", start=0.0)
    system = assemble_one(phi=phi, n=n, equations=equations)
    run = lp.simulate(system, until=6.0, rtol=1e-10, method="taylor")
    curve = CubicSpline(knots, heights, bc_type="periodic")

    def law(t):
        return np.sin(3 * (t + 0.1)) - curve((t + 0.1) % (2 * np.pi))

    t = np.linspace(0, 6.0, 6001)
    ends = np.flatnonzero(np.diff(np.sign(law(t))))
    expected = [brentq(law, t[i], t[i + 1], xtol=1e-14) for i in ends]
    assert len(expected) >= 4
    np.testing.assert_allclose([e.time for e in run.events], expected, rtol=0, atol=1e-9)


def test_a_margin_with_a_root_at_zero_is_enclosed():
    """``sqrt(t)`` has no series at 0; it passes 0.5 at 0.25 s."""

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield lp.der(self.n) == lp.ops.where(lp.ops.sqrt(self.x) > 0.5, 1.0, 0.0)

    x, n = lp.var("1", "time", start=0.0), lp.var("1", "counted", start=0.0)
    system = assemble_one(x=x, n=n, equations=equations)
    run = lp.simulate(system, until=1.0, rtol=1e-10, method="taylor")
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
    assert max(apart, default=0) < 1e-6


def test_engines_and_lanes_find_the_same_instants():
    border = 1 - 1e-10
    system = lp.assemble(Swing(border=border))
    options = {"until": 8.0, "rtol": 1e-11, "method": "taylor"}
    expected = [event.time for event in lp.simulate(system, **options).events]
    assert len(expected) == 4
    for name in ("c", "python"):
        with engine.using(name):
            assert [event.time for event in lp.simulate(system, **options).events] == expected
    name = lp.simulate(system, **options).events[0].component
    of = {"count": fun.count(name), "first": fun.instant(name), "n": fun.final("n")}
    points = np.append(1 - np.logspace(-10, -1, 10), border)[:, None]
    lanes, alone = (
        ran(system, ["border"], points, of, kind=kind, **options) for kind in (NativeRuns, Alone)
    )
    assert_same_bits(lanes, alone)
    assert lanes.values[-1, :2].tolist() == [4, expected[0]]
