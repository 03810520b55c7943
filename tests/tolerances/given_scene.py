"""A scene of formulas, for studies that are tried without a drive."""

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import scipy

from lumped.ensembles.variants import probabilities


class GivenScene:
    """What `Scene` has, for a formula.

    Parameters
    ----------
    laws : sequence of callable
        Values and derivatives of each parameter for standard normal numbers.
    formula, slopes : callable
        Functionals, shape (n, k), and derivatives, shape (n, k, d), for parameters of shape (n, d).
    mixing : ndarray, optional
        Dependent standard normal variables from independent ones.
    second : callable, optional
        Second derivatives, shape (k, d, d), at one point.
    """

    analysis, error = "study", 1e-9

    def __init__(self, laws, formula: Callable, slopes: Callable, mixing=None, second=None) -> None:
        self.laws, self.formula, self.derivatives, self.second = laws, formula, slopes, second
        self.names = tuple(f"p{j}" for j in range(len(laws)))
        self.mixing = np.eye(len(laws)) if mixing is None else mixing
        each = [SimpleNamespace(at_score=law) for law in laws]
        self.marginals = SimpleNamespace(mixing=self.mixing, laws=each)
        k = formula(self.physical(np.zeros((1, len(laws))))).shape[1]
        self.labels, self.units = tuple(f"y{i}" for i in range(k)), ("1",) * k
        self.parameter_units = ("1",) * len(laws)
        self.failures, self.asked = {}, []

    def physical(self, u):
        u = u @ self.mixing.T
        return np.column_stack([law(u[:, j])[0] for j, law in enumerate(self.laws)])

    def physical_slopes(self, u):
        v = u @ self.mixing.T
        own = np.column_stack([law(v[:, j])[1] for j, law in enumerate(self.laws)])
        return own[:, :, None] * self.mixing

    def scores(self, n, seed=0, sampling="random"):
        return scipy.special.ndtri(probabilities(n, len(self.names), seed, sampling, "study"))

    def values(self, x):
        self.asked.append(x)
        found = self.formula(x)
        lost = np.flatnonzero(~np.isfinite(found).all(axis=1))
        self.failures = dict.fromkeys(lost.tolist(), "the formula has no value here")
        return found

    def slopes(self, x):
        return self.values(x), self.derivatives(x)

    def exact_curvatures(self, x):
        return None if self.second is None else self.second(x)


def numbers(value, slope, mean, std, curvature=None):
    """Over independent normal parameters, by the value and the gradient at one point; in N.m."""
    scene = GivenScene(
        [normal(*each) for each in zip(mean, std, strict=True)],
        lambda x: np.array([[value(row)] for row in x], float),
        lambda x: np.array([[slope(row)] for row in x], float),
        second=None if curvature is None else lambda x: np.array([curvature(x)], float),
    )
    scene.units = ("N.m",)
    return scene


def normal(mean, deviation):
    return lambda u: (mean + deviation * u, np.full(len(u), deviation))


def lognormal(median, sigma):
    return lambda u: (median * np.exp(sigma * u), median * sigma * np.exp(sigma * u))


def uniform(low, high):
    density = np.sqrt(1 / (2 * np.pi))
    return lambda u: (
        low + (high - low) * scipy.special.ndtr(u),
        (high - low) * density * np.exp(-0.5 * u**2),
    )


# -- the function of Ishigami and Homma, with its shares in closed form ----------------------------

A, B = 7.0, 0.1
ISHIGAMI_VARIANCE = A**2 / 8 + B * np.pi**4 / 5 + B**2 * np.pi**8 / 18 + 0.5
_FIRST = np.array([0.5 * (1 + B * np.pi**4 / 5) ** 2, A**2 / 8, 0.0])
_TOGETHER = B**2 * np.pi**8 * (1 / 18 - 1 / 50)
ISHIGAMI_MEAN = A / 2
ISHIGAMI_FIRST = _FIRST / ISHIGAMI_VARIANCE
ISHIGAMI_TOTAL = (_FIRST + np.array([_TOGETHER, 0.0, _TOGETHER])) / ISHIGAMI_VARIANCE


def ishigami():
    """Over three uniform parameters from -pi to pi."""

    def formula(x):
        a, b, c = x.T
        return (np.sin(a) + A * np.sin(b) ** 2 + B * c**4 * np.sin(a))[:, None]

    def slopes(x):
        a, b, c = x.T
        by = [np.cos(a) * (1 + B * c**4), A * np.sin(2 * b), 4 * B * c**3 * np.sin(a)]
        return np.column_stack(by)[:, None]

    return GivenScene([uniform(-np.pi, np.pi)] * 3, formula, slopes)
