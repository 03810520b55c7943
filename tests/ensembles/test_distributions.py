"""Distributions against closed forms, the standard library and scipy.stats."""

import math
from statistics import NormalDist

import numpy as np
import pint
import pytest
import scipy

import lumped as lp
from lumped.ensembles.laws import Parameter
from lumped.ensembles.other_laws import distribution_of
from lumped.errors import LumpedError, OptionError, ParameterError, UnitError

STIFFNESS = Parameter("shaft.c", "N.m/rad", 100.0)
NUMBER = Parameter("gain.k", "1", 2.0)
TEMPERATURE = Parameter("oil.T", "K", 300.0)


def law(distribution, parameter=STIFFNESS):
    return distribution_of(distribution, "x =").law(parameter)


def moments(distribution, parameter=STIFFNESS):
    """Mean and variance by the trapezoidal rule over a normal variable.

    It converges faster than any power of the step for smooth quantiles; a kink or an end costs the
    square of the step, here 1e-4.
    """
    z = np.arange(-8.0, 8.0, 1e-4)
    weights = np.exp(-(z**2) / 2) / math.sqrt(2 * math.pi) * 1e-4
    x = law(distribution, parameter).quantile(scipy.special.ndtr(z))
    mean = weights @ x
    return mean, weights @ (x - mean) ** 2


def truncated_normal(mean, std, low, high):
    """Mean and variance; the ends may be infinite."""
    a, b = (low - mean) / std, (high - mean) / std
    normal = NormalDist()
    share = normal.cdf(b) - normal.cdf(a)
    shift = (normal.pdf(a) - normal.pdf(b)) / share
    ends = sum(s * x * normal.pdf(x) for s, x in ((1, a), (-1, b)) if math.isfinite(x)) / share
    return mean + std * shift, std**2 * (1 + ends - shift**2)


@pytest.mark.parametrize(
    ("distribution", "expected"),
    [
        (lp.normal(30.0, 0.5), (30.0, 0.25)),
        (lp.uniform(2.0, 5.0), (3.5, 9 / 12)),
        (lp.distributions.triangular(1.0, 2.0, 6.0), (3.0, (1 + 4 + 36 - 2 - 6 - 12) / 18)),
        (lp.distributions.triangular(1.0, 1.0, 6.0), (8 / 3, 25 / 18)),
        (lp.distributions.triangular(1.0, 6.0, 6.0), (13 / 3, 25 / 18)),
        (
            lp.distributions.lognormal(3.0, 0.2),
            (3 * math.exp(0.02), 9 * (math.exp(0.04) - 1) * math.exp(0.04)),
        ),
        (
            lp.distributions.truncated(lp.normal(1.0, 2.0), 0.0, 4.0),
            truncated_normal(1.0, 2.0, 0.0, 4.0),
        ),
        (
            lp.distributions.truncated(lp.normal(1.0, 2.0), 0.0, None),
            truncated_normal(1.0, 2.0, 0.0, math.inf),
        ),
        (
            lp.distributions.truncated(lp.normal(1.0, 2.0), None, 4.0),
            truncated_normal(1.0, 2.0, -math.inf, 4.0),
        ),
        (lp.distributions.truncated(lp.uniform(0.0, 10.0), 2.0, 5.0), (3.5, 9 / 12)),
        (lp.distributions.scaled(lp.normal(1.1, 0.05)), (110.0, 25.0)),
        (scipy.stats.gamma(4.0, scale=2.0), (8.0, 16.0)),
        (lp.distributions.truncated(scipy.stats.expon(), 0.0, None), (1.0, 1.0)),
    ],
)
def test_mean_and_variance_are_those_of_the_closed_form(distribution, expected):
    assert moments(distribution) == pytest.approx(expected, rel=1e-7)


DISTRIBUTIONS = [
    lp.normal(30.0, 0.5),
    lp.uniform(2.0, 5.0),
    lp.distributions.triangular(1.0, 2.0, 6.0),
    lp.distributions.lognormal(3.0, 0.2),
    lp.distributions.truncated(lp.normal(1.0, 2.0), 0.0, 4.0),
    lp.distributions.truncated(lp.distributions.triangular(1.0, 2.0, 6.0), 1.5, None),
    lp.distributions.scaled(lp.distributions.triangular(0.9, 1.0, 1.2)),
    scipy.stats.weibull_min(2.0),
]


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
@pytest.mark.parametrize("own", [100.0, -100.0])
def test_probabilities_are_inverse_to_quantiles(distribution, own):
    parameter = Parameter("shaft.c", "N.m/rad", own)
    one = law(distribution, parameter)
    u = np.linspace(0.01, 0.99, 99)
    falls = isinstance(distribution, type(lp.distributions.scaled(lp.normal(1.0, 1.0)))) and own < 0
    expected = 1 - u if falls else u
    x = one.quantile(u)
    assert [one.below(v) for v in x] == pytest.approx(expected, abs=1e-12)
    assert [one.above(v) for v in x] == pytest.approx(1 - expected, abs=1e-12)
    assert (one.below(-1e9), one.above(1e9)) == (0.0, 0.0)
    assert (one.below(1e9), one.above(-1e9)) == (1.0, 1.0)


def test_normal_quantiles_are_those_of_the_standard_library():
    u = np.array([1e-10, 0.001, 0.3, 0.5, 0.9, 0.999999])
    expected = [NormalDist(30.0, 0.5).inv_cdf(v) for v in u]
    assert law(lp.normal(30.0, 0.5)).quantile(u) == pytest.approx(expected, rel=1e-14)


def test_a_truncated_normal_is_that_of_scipy():
    u = np.linspace(0.001, 0.999, 999)
    for low, high in ((-1.0, 3.0), (4.0, 5.0), (-5.0, -4.0)):
        expected = scipy.stats.truncnorm(low, high, loc=10.0, scale=2.0).ppf(u)
        ends = (10 + 2 * low, 10 + 2 * high)
        received = law(lp.distributions.truncated(lp.normal(10.0, 2.0), *ends)).quantile(u)
        assert received == pytest.approx(expected, rel=1e-10)
        assert (received >= ends[0]).all()
        assert (received <= ends[1]).all()


def test_a_discrete_distribution_keeps_its_ends():
    die = scipy.stats.randint(1, 7)
    u = (np.arange(600) + 0.5) / 600
    assert np.bincount(law(die).quantile(u).astype(int)).tolist() == [0] + 6 * [100]
    one = law(lp.distributions.truncated(die, 2.0, 4.0))
    assert np.bincount(one.quantile(u).astype(int)).tolist() == [0, 0, 200, 200, 200]
    assert (one.below(2.0), one.above(4.0)) == (0.0, 0.0)
    assert one.below(3.0) == pytest.approx(1 / 3)
    assert law(die).above(5.0) == pytest.approx(1 / 6)


# -- units ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("distribution", "expected"),
    [
        (lp.normal("30 kN.m/rad", "0.5 kN.m/rad"), lp.normal(30e3, 500.0)),
        (lp.normal("30 kN.m/deg", 500.0), lp.normal(30e3 * 180 / math.pi, 500.0)),
        (lp.uniform("1 kN.m/rad", 2000.0), lp.uniform(1000.0, 2000.0)),
        (
            lp.distributions.triangular("1 kN.m/rad", "2 kN.m/rad", "3 kN.m/rad"),
            lp.distributions.triangular(1e3, 2e3, 3e3),
        ),
        (lp.distributions.lognormal("3 kN.m/rad", "10 %"), lp.distributions.lognormal(3e3, 0.1)),
        (
            lp.distributions.truncated(lp.normal(1e3, 200.0), "0.9 kN.m/rad", "1.2 kN.m/rad"),
            lp.distributions.truncated(lp.normal(1e3, 200.0), 900.0, 1200.0),
        ),
        (lp.distributions.scaled(lp.uniform("90 %", "110 %")), lp.uniform(90.0, 110.0)),
    ],
)
def test_values_with_units_are_converted_to_that_of_the_parameter(distribution, expected):
    u = np.linspace(0.1, 0.9, 9)
    assert law(distribution).quantile(u) == pytest.approx(law(expected).quantile(u), rel=1e-12)


def test_a_standard_deviation_is_a_difference_of_temperatures():
    quantity = pint.UnitRegistry().Quantity
    for std in ("9 degC", "9 K", quantity(9.0, "degC"), quantity(9.0, "K"), 9.0, "16.2 degF"):
        u = np.array([0.5, NormalDist().cdf(1.0)])
        received = law(lp.normal("20 degC", std), TEMPERATURE).quantile(u)
        assert received == pytest.approx([293.15, 302.15], rel=1e-12)


# -- what is refused -------------------------------------------------------------------------------


REFUSED = {
    OptionError: [
        (
            lp.normal(30.0, -0.5),
            r"shaft\.c: std = -0\.5 N\.m/rad must be greater than zero\. Leave out",
        ),
        (lp.normal(30.0, "0 N.m/rad"), r"std = 0 N\.m/rad must be greater than zero"),
        (
            lp.uniform(3.0, 1.0),
            r"low = 3 N\.m/rad must be less than high = 1 N\.m/rad\. Give the smaller one first",
        ),
        (lp.uniform(3.0, 3.0), "must be less than high"),
        (lp.distributions.triangular(3.0, 2.0, 1.0), "low = 3 N.m/rad must be less than high = 1"),
        (lp.distributions.triangular(1.0, 5.0, 3.0), "mode = 5 N.m/rad must lie between low = 1"),
        (lp.distributions.lognormal(-1.0, 0.1), "median = -1 N.m/rad must be greater than zero"),
        (lp.distributions.lognormal(1.0, 0.0), "sigma = 0 must be greater than zero"),
        (lp.distributions.truncated(lp.normal(1.0, 1.0), 3.0, 2.0), "low = 3 N.m/rad must be less"),
        (
            lp.distributions.truncated(lp.normal(1.0, 1.0), 20.0, 30.0),
            r"share of 0 between low = 20 N\.m/rad and high = 30 N\.m/rad; 1e-09 is needed",
        ),
        (lp.distributions.scaled(lp.uniform(2.0, 1.0)), r"shaft\.c: factor: low = 2 must be less"),
        (
            lp.distributions.scaled(lp.distributions.scaled(lp.normal(1.0, 0.1))),
            "cannot be scaled again",
        ),
        (scipy.stats.norm(0.0, -1.0), "median .* is nan, which is no finite number"),
        (scipy.stats.norm([1.0, 2.0], 1.0), r"median .* is \[1\.0, 2\.0\]"),
    ],
    UnitError: [
        (lp.normal("30 kg", 1.0), r"shaft\.c: mean = '30 kg': the unit must be of the"),
        (lp.normal(30.0, "1 kg"), r"shaft\.c: std = '1 kg': the unit must be of the"),
        (lp.distributions.scaled(lp.normal("1 kg", 0.1)), r"shaft\.c: factor: mean = '1 kg'"),
    ],
    ParameterError: [
        (lp.normal("nan N.m/rad", 1.0), "mean = nan N.m/rad must be a finite"),
    ],
}


@pytest.mark.parametrize(
    ("kind", "distribution", "text"),
    [(kind, *row) for kind, rows in REFUSED.items() for row in rows],
)
def test_what_is_no_distribution_of_the_parameter_is_refused(distribution, kind, text):
    with pytest.raises(kind, match=text):
        law(distribution)


def test_a_value_of_zero_cannot_be_scaled():
    with pytest.raises(OptionError, match=r"part\.x: its value is zero, which no factor changes"):
        law(lp.distributions.scaled(lp.normal(1.0, 0.1)), Parameter("part.x", "m", 0.0))


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: lp.normal(math.nan, 1.0), "normal: mean = nan: a finite number or a text"),
        (lambda: lp.uniform(0.0, math.inf), "uniform: high = inf: a finite number or a text"),
        (lambda: lp.normal(1.0), "normal: missing a required argument: 'std'"),
        (
            lambda: lp.distributions.scaled(3.0),
            r"scaled: distribution = 3\.0: a distribution such as lumped\.",
        ),
        (
            lambda: lp.distributions.truncated(None, 1.0, 2.0),
            "truncated: distribution = None: a distribution",
        ),
        (
            lambda: lp.distributions.scaled(scipy.stats.norm),
            r"scaled: distribution = scipy\.stats\.norm: give the distribution its arguments",
        ),
        (
            lambda: lp.distributions.paired([1.0]),
            r"paired: values = \[1\.0\]: a dictionary with names as keys",
        ),
    ],
)
def test_what_is_no_distribution_at_all_is_refused_at_once(make, text):
    with pytest.raises(LumpedError, match=text):
        make()


TWO = {"shaft.c": lp.normal(100.0, 1.0), "body.J": lp.normal(1.0, 0.1)}


@pytest.mark.parametrize(
    ("distributions", "correlation", "text"),
    [
        ({}, [], "correlated: there is no distribution"),
        ({"shaft.c": 3.0}, [[1.0]], r"correlated: shaft\.c = 3\.0: a distribution such as"),
        (TWO, [1.0, 0.5], r"shape \(2,\); 2 rows of 2 numbers are needed, in the order shaft\.c"),
        (TWO, [[1.0, 0.5, 0.1], [0.5, 1.0, 0.1]], r"shape \(2, 3\); 2 rows"),
        (TWO, [[1.0, 0.5], [0.4, 1.0]], r"shaft\.c and body\.J is 0\.5 above .* 0\.4 below"),
        (TWO, [[1.0, 0.5], [0.5, 4.0]], r"body\.J with itself is 4, which must be 1\. Divide"),
        (TWO, [[1.0, 1.5], [1.5, 1.0]], r"least eigenvalue of the matrix is -0\.5"),
        (TWO, [[1.0, math.nan], [math.nan, 1.0]], "correlation = .* a list of finite numbers"),
        (TWO, [[1.0, 0.5], [0.5]], "correlation = .* a list of finite numbers"),
    ],
)
def test_what_is_no_correlation_matrix_is_refused(distributions, correlation, text):
    with pytest.raises(OptionError, match=text):
        lp.distributions.correlated(distributions, correlation)


def test_correlations_that_contradict_each_other_are_refused():
    """Three variables cannot all be opposite to each other: 1 - 2 r is an eigenvalue."""
    names = {f"shaft[{i}].c": lp.normal(100.0, 1.0) for i in range(3)}
    matrix = np.full((3, 3), -0.6) + 1.6 * np.eye(3)
    with pytest.raises(OptionError, match=r"least eigenvalue of the matrix is -0\.2"):
        lp.distributions.correlated(names, matrix)
    lp.distributions.correlated(names, np.full((3, 3), -0.5) + 1.5 * np.eye(3))
