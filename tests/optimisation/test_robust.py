"""Designs where parameters scatter: probabilities, means with deviations, quantiles, fronts."""

import inspect

import numpy as np
import pytest
import scipy
from differences import slope
from robust_drives import BREAKS, LOAD, SPREAD, STRENGTH, WEAKER, Bar, oscillator, pushed
from rows import in_a_row, in_rows

import lumped as lp
from lumped import distributions as dist
from lumped import functionals as fun
from lumped.components import Fixed, Inertia, Spring, SpringDamper, Torque
from lumped.numerics.sqp import sqp
from lumped.timeloop.run_options import run_plan
from lumped.tolerances.of_designs import DesignAim, DesignProbability, MovedScene


def diameter(beta):
    """Of the bar with a reliability index: ``R - a T`` is normal, ``a = 16 / (pi d^3)``."""

    def miss(a):
        return STRENGTH - a * LOAD - beta * np.hypot(WEAKER, a * SPREAD)

    a = scipy.optimize.brentq(miss, 1e3, STRENGTH / LOAD, xtol=1e-10)
    return (16 / (np.pi * a)) ** (1 / 3)


def index(p):
    return -scipy.special.ndtri(p)


def scores(k, n):
    """Standard normal numbers of scrambled Sobol points with the seed 0."""
    engine = scipy.stats.qmc.Sobol
    name = "rng" if "rng" in inspect.signature(engine).parameters else "seed"
    points = engine(k, **{name: np.random.default_rng(0)})
    return scipy.special.ndtri(points.random(n))


# -- conditions ------------------------------------------------------------------------------------


def test_the_thinnest_bar_that_breaks_once_in_ten_thousand():
    found = lp.optimise(
        lp.assemble(Bar()),
        until=1.0,
        vary={"d": (0.02, 0.3)},
        minimise="d",
        subject_to=BREAKS <= 1e-4,
    )
    (check,) = found.checks
    print(found)
    assert found.parameters["d"] == pytest.approx(diameter(index(1e-4)), rel=1e-7)
    assert found.values[BREAKS] == pytest.approx(1e-4, rel=1e-5)
    low, high = check.sampled.interval
    assert low < 1e-4 < high < 1.3 * low
    # the design point: both as far from their means as their shares in the deviation say
    a = 16 / (np.pi * found.parameters["d"] ** 3)
    share = np.array([a * SPREAD, -WEAKER]) / np.hypot(WEAKER, a * SPREAD)
    expected = [LOAD, STRENGTH] + index(1e-4) * share * [SPREAD, WEAKER]
    assert [*check.design_point.values()] == pytest.approx(expected, rel=1e-6)
    assert "by 1000 samples" in repr(found)


def test_the_derivative_of_beta_is_that_of_its_closed_form():
    """Beta = (R - a T) / sqrt(r^2 + (a t)^2) for a load whose mean is a parameter of the design."""
    over = {"T": dist.scaled(lp.normal(1.0, 0.1)), "R": lp.normal(STRENGTH, WEAKER)}
    names = ("d", "T")
    plan = run_plan(1.0, 1e-8, {})
    scene = MovedScene(lp.assemble(Bar()), fun.final("excess"), over, names, "optimise", plan)
    limit = lp.probability(fun.final("excess"), above=0.0, over=over)

    def beta(d, T):
        a = 16 / (np.pi * d**3)
        return (STRENGTH - a * T) / np.hypot(WEAKER, 0.1 * a * T)

    design = {"d": 0.055, "T": 5500.0}
    ((value, slopes),) = DesignProbability(limit, scene).betas(design)
    for name, received in zip(names, slopes, strict=True):
        expected = slope(
            lambda x, name=name: beta(**design | {name: x}), design[name], 1e-6 * design[name], 2
        )
        assert received == pytest.approx(expected, rel=1e-6)
    assert value == pytest.approx(beta(**design), rel=1e-9)


def test_a_frequency_stays_above_a_limit_with_a_probability():
    """The median of a lognormal stiffness: ``c = J (2 pi f)^2 exp(beta s)``."""
    s, f, p = 0.1, 5.0, 1e-3
    low = lp.probability(
        fun.frequency(0), below=f, over={"shaft.c": dist.scaled(dist.lognormal(1.0, s))}
    )
    found = lp.optimise(
        lp.modes(oscillator(4000.0)),
        vary={"shaft.c": (500.0, 1e4)},
        minimise="shaft.c",
        subject_to=low <= p,
    )
    expected = 2.0 * (2 * np.pi * f) ** 2 * np.exp(index(p) * s)
    assert found.parameters["shaft.c"] == pytest.approx(expected, rel=1e-7)
    assert found.active == (f"{low}",)


def test_a_vibration_stays_below_a_limit_with_a_probability():
    """``|c + i w d| / |c + i w d - w^2 J|`` over the speeds: its root over the scattering c."""
    speeds, J, d, torque, limit = np.linspace(40.0, 80.0, 9), 2.0, 30.0, 100.0, 60.0
    model = in_rows(
        "wall shaft body",
        "torque body",
        wall=Fixed(),
        shaft=SpringDamper(c=5e3, d=d),
        body=Inertia(J=J),
        torque=Torque(tau=0.0),
    )
    response = lp.vibration.order_response(
        lp.assemble(model), speeds=speeds, of=["shaft.tau"], excitations={"torque.tau": {2: torque}}
    )

    def excess(c):
        w = 2 * speeds
        return np.abs(torque * (1 + w**2 * J / (c + 1j * w * d - w**2 * J))).max() - limit

    passed = lp.probability(
        fun.order_peak("shaft.tau"),
        above=limit,
        over={"shaft.c": dist.scaled(dist.lognormal(1.0, 0.1))},
        runs=100,
    )
    found = lp.optimise(
        response,
        vary={"shaft.c": (500.0, 8e3)},
        minimise={"shaft.c": -1e-3},
        subject_to=passed <= 1e-3,
    )
    c = found.parameters["shaft.c"]
    received = scipy.optimize.brentq(lambda z: excess(c * np.exp(0.1 * z)), 0.0, 8.0)
    assert received == pytest.approx(index(1e-3), abs=1e-6)


class Bent(lp.Component):
    """A load whose limit is no plane."""

    size: lp.Param = lp.param("1", "size", 3.0)
    a: lp.Param = lp.param("1", "first", 0.0)
    b: lp.Param = lp.param("1", "second", 0.0)
    y = lp.var("1", "load over size")

    def equations(self):
        yield self.y == (self.a + 0.1 * self.b**2) / self.size


def test_a_limit_that_is_no_plane_shifts_beta():
    """``P(a + k b^2 > s)`` by a quadrature over b; the design point alone says two thirds of it."""

    def probability(s):
        def density(b):
            return scipy.stats.norm.pdf(b) * scipy.special.ndtr(0.1 * b**2 - s)

        return scipy.integrate.quad(density, -12, 12, epsabs=1e-14)[0]

    normal = lp.normal(0.0, 1.0)
    passed = lp.probability(fun.final("y"), above=1.0, over={"a": normal, "b": normal}, runs=2000)
    found = lp.optimise(
        lp.assemble(Bent()),
        until=1.0,
        vary={"size": (1.0, 20.0)},
        minimise="size",
        subject_to=passed <= 1e-3,
    )
    (check,) = found.checks
    true = probability(found.parameters["size"])
    print(check, true)
    assert true == pytest.approx(1e-3, rel=0.2)
    assert probability(index(1e-3)) > 1.5e-3  # of a plane limit
    assert check.shift == pytest.approx(check.beta - index(1e-3), rel=1e-6)
    assert check.searches > 1
    assert found.values[passed] == pytest.approx(1e-3, rel=1e-4)


class Between(lp.Component):
    """A deviation within a width, about a middle."""

    middle: lp.Param = lp.param("1", "middle", 0.4)
    width: lp.Param = lp.param("1", "half width", 3.0, above=0)
    z: lp.Param = lp.param("1", "deviation", 0.0)
    y = lp.var("1", "square of the deviation over the width")

    def equations(self):
        yield self.y == ((self.z - self.middle) / self.width) ** 2


def test_both_ways_to_fail_are_followed():
    """A normal deviation is within ``+- w`` but for ``2 Phi(-w)``: the middle is its own."""
    passed = lp.probability(fun.final("y"), above=1.0, over={"z": lp.normal(0.0, 1.0)})
    found = lp.optimise(
        lp.assemble(Between()),
        until=1.0,
        vary={"middle": (-1.0, 1.0), "width": (1.0, 6.0)},
        minimise="width",
        subject_to=passed <= 1e-3,
    )
    print(found)
    assert found.parameters["middle"] == pytest.approx(0.0, abs=1e-6)
    assert found.parameters["width"] == pytest.approx(index(0.5e-3), abs=0.04)


def test_a_design_that_never_fails_is_left_where_it_is():
    """The limit is out of reach at the start and at the optimum, at the least inertia."""
    found = lp.optimise(
        pushed(),
        until=1.0,
        vary={"body.J": (1.0, 10.0)},
        minimise="body.J",
        subject_to=lp.probability(
            fun.final("body.w"), above=100.0, over={"motor.tau": lp.normal(10.0, 1.0)}
        )
        <= 1e-3,
    )
    assert found.parameters["body.J"] == pytest.approx(1.0)
    assert found.checks[0].sampled is None
    assert "out of reach" in repr(found)


def test_the_least_probability_of_a_speed_is_that_of_the_largest_inertia():
    over = {"motor.tau": lp.normal(10.0, 1.0)}
    fails = lp.probability(fun.final("body.w"), above=6.0, over=over)
    found = lp.optimise(pushed(), until=1.0, vary={"body.J": (1.8, 2.2)}, minimise=fails)
    expected = scipy.special.ndtr(-(6.0 * 2.2 - 10.0))
    assert found.parameters["body.J"] == pytest.approx(2.2)
    assert found.objective == pytest.approx(expected, rel=1e-6)


# -- samples ---------------------------------------------------------------------------------------


def test_the_quantile_is_that_of_harrell_and_davis():
    values = np.random.default_rng(3).gamma(2.0, size=300)
    aim = lp.tolerances.quantile(fun.final("y"), 0.9, over={})
    expected = scipy.stats.mstats.hdquantiles(values, prob=[0.9])[0]
    slopes = np.random.default_rng(4).standard_normal((300, 2))
    received, by = aim.of_sample(values, slopes)
    assert received == pytest.approx(expected, rel=1e-12)
    for k in range(2):

        def moved(x, k=k):
            return scipy.stats.mstats.hdquantiles(values + x * slopes[:, k], prob=[0.9])[0]

        assert by[k] == pytest.approx(slope(moved, 0.0, 1e-7, 2), rel=1e-6)


def test_a_search_ends_where_values_of_a_quantile_change_places():
    """Half of each of two equal normal deviations has the least quantile."""
    a, b = scores(2, 256).T
    aim = lp.tolerances.quantile(fun.final("y"), 0.9, over={})

    def objective(w):
        value, slope = aim.of_sample(w[0] * a + (1 - w[0]) * b, (a - b)[:, None])
        return value, slope

    def none(w):
        return np.zeros(0), np.zeros((0, 1)), []

    box = np.array([[0.3, 0.0, 1.0]])
    found, _ = sqp("mixture", ["share"], box, objective, none, lambda: 0)
    every = [objective([w])[0] for w in np.linspace(0.4, 0.6, 2001)]
    assert found.objective <= min(every) * (1 + 1e-9)
    assert found.w[0] == pytest.approx(0.5, abs=0.05)


def test_the_softest_spring_with_a_frequency_three_deviations_above_a_limit():
    """``f = f0 exp(s z / 2)``: mean ``f0 exp(s^2/8)``, relative deviation ``sqrt(e^(s^2/4)-1)``."""
    s, f = 0.2, 5.0
    over = {"shaft.c": dist.scaled(dist.lognormal(1.0, s))}
    aim = lp.tolerances.mean_plus(fun.frequency(0), -3.0, over=over, runs=32)
    found = lp.optimise(
        lp.modes(oscillator(4000.0)),
        vary={"shaft.c": (500.0, 1e4)},
        minimise="shaft.c",
        subject_to=aim >= f,
    )
    factor = np.exp(s**2 / 8) * (1 - 3 * np.sqrt(np.exp(s**2 / 4) - 1))
    own = np.exp(s / 2 * scores(1, 32)[:, 0])
    of_sample = own.mean() - 3 * own.std(ddof=1)
    expected = [2.0 * (2 * np.pi * f / each) ** 2 for each in (of_sample, factor)]
    (check,) = found.checks
    print(found)
    assert found.parameters["shaft.c"] == pytest.approx(expected[0], rel=1e-7)
    assert found.parameters["shaft.c"] == pytest.approx(expected[1], rel=0.08)
    assert found.values[aim] == pytest.approx(f, rel=1e-6)
    assert check.fresh == pytest.approx(f * factor / of_sample, rel=0.02)
    assert check.fresh != check.value
    assert "Hz by 32 runs" in repr(found)


class Worn(lp.Component):
    """Cost of a size: what wears off falls with it, what it weighs rises."""

    size: lp.Param = lp.param("1", "size", 1.0, above=0)
    T: lp.Param = lp.param("1", "load", 1.0, above=0)
    y = lp.var("1", "cost")

    def equations(self):
        yield self.y == self.T / self.size + 2.0 * self.size


def test_the_size_of_the_least_quantile_of_cost():
    """``q = T_q / s + 2 s`` is least at ``s = sqrt(T_q / 2)``."""
    over = {"T": dist.lognormal(1.0, 0.5)}
    aim = lp.tolerances.quantile(fun.final("y"), 0.9, over=over, runs=128)
    found = lp.optimise(lp.assemble(Worn()), until=1.0, vary={"size": (0.1, 10.0)}, minimise=aim)
    expected = np.exp(0.5 * scipy.special.ndtri(0.9))
    assert found.parameters["size"] == pytest.approx(np.sqrt(expected / 2), rel=0.02)
    assert found.objective == pytest.approx(np.sqrt(8 * expected), rel=0.02)
    assert found.checks[0].fresh == pytest.approx(np.sqrt(8 * expected), rel=0.01)


def test_the_derivative_of_mean_and_deviations_is_that_of_the_formula():
    """``w = tau / J`` with both scaled: by numpy over the numbers of the sample itself."""
    over = {
        "motor.tau": dist.scaled(lp.normal(1.0, 0.1)),
        "body.J": dist.scaled(dist.lognormal(1.0, 0.05)),
    }
    aim = lp.tolerances.mean_plus(fun.final("body.w"), 2.0, over=over, runs=32)
    names = ("body.J", "motor.tau")
    plan = run_plan(1.0, 1e-8, {})
    scene = MovedScene(pushed(), fun.final("body.w"), over, names, "optimise", plan)
    design = {"body.J": 3.0, "motor.tau": 8.0}
    value, slopes = DesignAim(aim, scene).at(design)
    z = scores(2, 32)
    w = (1 + 0.1 * z[:, 0]) / np.exp(0.05 * z[:, 1])
    factor = w.mean() + 2 * w.std(ddof=1)
    assert value == pytest.approx(factor * 8 / 3, rel=1e-9)
    assert slopes == pytest.approx([-factor * 8 / 9, factor / 3], rel=1e-9)


# -- fronts ----------------------------------------------------------------------------------------


def test_the_front_of_diameter_and_probability_is_the_closed_form():
    front = lp.optimisation.pareto(
        lp.assemble(Bar(d=0.05)),
        until=1.0,
        vary={"d": (0.046, 0.056)},
        minimise=("d", BREAKS),
        count=5,
    )
    d, p = front.values.T
    print(front)
    assert d[[0, -1]] == pytest.approx([0.046, 0.056], rel=1e-6)
    assert d == pytest.approx([diameter(index(each)) for each in p], rel=1e-5)
    assert np.ptp(np.diff(index(p))) < 1e-4  # equal steps of the index
    assert all(design.checks for design in front.designs)
    for backend in ("matplotlib", "plotly"):
        figure = front.plot(units={"d": "mm"}, backend=backend)
        if backend == "plotly":
            (line,), label = figure.data, figure.layout.xaxis.title.text
            x, y, is_log = line.x, line.y, figure.layout.yaxis.type == "log"
        else:
            (axis,) = figure.axes
            (line,), label = axis.lines, axis.get_xlabel()
            x, y, is_log = *line.get_data(), axis.get_yscale() == "log"
        assert (label, is_log) == ("d, mm", True)
        assert np.array(x) == pytest.approx(1e3 * d)
        assert np.array(y) == pytest.approx(p)


def test_the_front_of_two_springs_and_their_frequency():
    """Springs in series: the least sum of stiffnesses for a frequency has both equal."""
    model = in_a_row(
        wall=Fixed(), one=Spring(c=3000.0), other=Spring(c=9000.0), body=Inertia(J=2.0)
    )
    front = lp.optimisation.pareto(
        lp.modes(lp.assemble(model)),
        vary={"one.c": (1e3, 2e4), "other.c": (1e3, 2e4)},
        minimise=({"one.c": 1.0, "other.c": 1.0}, {fun.frequency(0): -1.0}),
        count=4,
    )
    cost, hertz = front.values.T
    c = 2.0 * (2 * np.pi * hertz) ** 2  # of both in series
    assert cost == pytest.approx(4 * c, rel=1e-6)
    assert cost[[0, -1]] == pytest.approx([2e3, 4e4], rel=1e-5)
