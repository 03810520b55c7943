"""Distributions as functions of standard normal numbers, and those of measured samples."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy

from lumped.ensembles import distributions as dist
from lumped.ensembles.laws import Parameter
from lumped.ensembles.other_laws import distribution_of
from lumped.errors import OptionError

PARAMETER = Parameter("test: shaft.c", "N.m/rad", 100.0)
TRIANGLE = SimpleNamespace(  # from 90 to 120 with its top at 95; SciPy loses the upper tail
    cdf=lambda x: np.where(x < 95, (x - 90) ** 2 / 150, 1 - (120 - x) ** 2 / 750),
    sf=lambda x: np.where(x < 95, 1 - (x - 90) ** 2 / 150, (120 - x) ** 2 / 750),
    pdf=lambda x: np.where(x < 95, (x - 90) / 75, (120 - x) / 375),
)
LAWS = {
    "normal": (dist.normal(100.0, 5.0), scipy.stats.norm(100, 5)),
    "uniform": (dist.uniform(90.0, 120.0), scipy.stats.uniform(90, 30)),
    "triangular": (dist.triangular(90.0, 95.0, 120.0), TRIANGLE),
    "lognormal": (dist.lognormal(100.0, 0.2), scipy.stats.lognorm(0.2, scale=100)),
    "truncated": (
        dist.truncated(dist.normal(100.0, 5.0), 97.0, 130.0),
        scipy.stats.truncnorm(-0.6, 6.0, 100, 5),
    ),
    "scaled": (dist.scaled(dist.uniform(0.9, 1.2)), scipy.stats.uniform(90, 30)),
    "scipy": (scipy.stats.gamma(9.0, scale=10.0), scipy.stats.gamma(9.0, scale=10.0)),
}


def law_of(given):
    return distribution_of(given, "test").law(PARAMETER)


@pytest.mark.parametrize("kind", LAWS)
def test_values_have_the_probabilities_of_their_scores(kind):
    given, expected = LAWS[kind]
    z = np.linspace(-6.0, 6.0, 61)
    x, slope = law_of(given).at_score(z)
    lower = np.where(z < 0, expected.cdf(x), 0.0)
    upper = np.where(z >= 0, expected.sf(x), 0.0)
    # both tails, each relative to itself; a number near an end of a range has lost its own digits
    true = np.where(z < 0, scipy.special.ndtr(z), scipy.special.ndtr(-z))
    lost = np.spacing(np.abs(x)) * expected.pdf(x) / true
    off = np.abs((lower + upper) / true - 1) - 20 * lost
    assert off.max() < 1e-9
    step = 1e-5
    by = (law_of(given).at_score(z + step)[0] - law_of(given).at_score(z - step)[0]) / (2 * step)
    kinks = np.abs(slope - by) > 1e-6 * np.abs(slope) + 1e-8
    assert kinks.sum() == 0


def test_samples_with_normal_scores_give_a_normal_distribution():
    z = scipy.special.ndtri((np.arange(400) + 0.5) / 400)
    law = law_of(dist.measured(50.0 + 4.0 * np.random.default_rng(1).permutation(z)))
    at = np.linspace(-5.0, 5.0, 101)
    x, slope = law.at_score(at)
    assert np.abs(x - 50 - 4 * at).max() < 1e-10
    assert np.abs(slope - 4).max() < 1e-10
    for value in (40.0, 49.0, 61.3):
        assert law.below(value) == pytest.approx(scipy.stats.norm.cdf(value, 50, 4), rel=1e-9)
        assert law.above(value) == pytest.approx(scipy.stats.norm.sf(value, 50, 4), rel=1e-9)


def test_skew_samples_keep_their_quantiles_and_a_smooth_rising_curve():
    samples = np.random.default_rng(2).gamma(4.0, 2.0, 3000)
    law = law_of(dist.measured(samples))
    for q in (0.02, 0.2, 0.5, 0.8, 0.98):
        found, expected = (
            float(law.quantile(np.array([q]))[0]),
            scipy.stats.gamma(4, scale=2).ppf(q),
        )
        # four standard errors of a quantile of a sample
        room = 4 * np.sqrt(q * (1 - q) / 3000) / scipy.stats.gamma(4, scale=2).pdf(expected)
        print(f"{q}: {found:.4f}, expected {expected:.4f}")
        assert abs(found - expected) < room
    z = np.linspace(-4.0, 4.0, 4001)
    x, slope = law.at_score(z)
    assert (slope > 0).all()
    assert np.abs(np.gradient(x, z)[1:-1] / slope[1:-1] - 1).max() < 0.01  # no jump of the slope


def test_too_few_or_equal_samples_are_refused_by_name():
    with pytest.raises(OptionError, match=r"test: shaft\.c: 19 measured samples .* 20 are needed"):
        law_of(dist.measured(np.arange(19.0)))
    with pytest.raises(OptionError, match=r"test: shaft\.c: too many of the measured .* equal"):
        law_of(dist.measured(np.repeat([1.0, 2.0], 30)))
    texts = [f"{value} kN.m/rad" for value in np.linspace(0.9, 1.1, 25)]
    middle = law_of(dist.measured(texts)).quantile(np.array([0.5]))
    assert middle == pytest.approx(1000.0, rel=1e-9)
