"""Moments of quadratic functions, against sums over all values of discrete variables."""

import itertools

import numpy as np
import pytest
import scipy

from lumped.ensembles import distributions as dist
from lumped.ensembles.laws import Parameter, central_moments
from lumped.tolerances.expansions.by_derivatives import quadratic_moments


def test_moments_are_those_of_all_combinations():
    rng = np.random.default_rng(0)
    values = [rng.normal(size=3) for _ in range(4)]
    shares = [rng.dirichlet(np.ones(3)) for _ in range(4)]
    values = [v - p @ v for v, p in zip(values, shares, strict=True)]
    central = np.array([[p @ v**k for k in range(7)] for v, p in zip(values, shares, strict=True)])
    slope, curvature = rng.normal(size=4), rng.normal(size=(4, 4))
    curvature += curvature.T
    every, weights = [], []
    for chosen in itertools.product(range(3), repeat=4):
        v = np.array([values[i][k] for i, k in enumerate(chosen)])
        every.append(1.5 + slope @ v + 0.5 * v @ curvature @ v)
        weights.append(np.prod([shares[i][k] for i, k in enumerate(chosen)]))
    y, w = np.array(every), np.array(weights)
    mean = w @ y
    expected = mean, w @ (y - mean) ** 2, w @ (y - mean) ** 3
    found = quadratic_moments(1.5, slope, curvature, central)[:3]
    assert found == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (dist.normal(3.0, 0.5), scipy.stats.norm(3.0, 0.5)),
        (dist.uniform(1.0, 4.0), scipy.stats.uniform(1.0, 3.0)),
        (dist.triangular(1.0, 2.0, 4.0), scipy.stats.triang(1 / 3, 1.0, 3.0)),
        (dist.lognormal(2.0, 0.3), scipy.stats.lognorm(0.3, scale=2.0)),
    ],
    ids=["normal", "uniform", "triangular", "lognormal"],
)
def test_moments_of_distributions(given, expected):
    mean, central = central_moments(given.law(Parameter("p", "1", None)))
    raw = np.array([1.0, *(expected.moment(k) for k in range(1, 7))])
    true = [
        sum(scipy.special.comb(k, j) * raw[j] * (-raw[1]) ** (k - j) for j in range(k + 1))
        for k in range(7)
    ]
    scale = expected.std() ** np.arange(7)
    assert mean == pytest.approx(expected.mean(), rel=1e-6)
    assert np.abs((central - true) / scale).max() < 2e-5
