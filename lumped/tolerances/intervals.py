"""Quantiles and shares of a population, as known from a sample."""

from __future__ import annotations

import math
from typing import NamedTuple

import scipy

from lumped.support.arrays import Real
from lumped.support.ranking import quantiles

CONFIDENCE = 0.95
"""Probability with which an interval has the true value inside."""
SCORE = float(scipy.special.ndtri(0.5 + 0.5 * CONFIDENCE))
"""Standard errors in half such an interval."""


class Quantile(NamedTuple):
    """A quantile, and the interval that has the true one inside with 95 %.

    An end is infinite where a sample is too small to tell it.
    """

    value: float
    low: float
    high: float


class Share(NamedTuple):
    """A share of a population, and the interval that has the true one inside with 95 %."""

    value: float
    low: float
    high: float


def quantile_of(ascending: Real, q: float) -> Quantile:
    """Quantile of a sample, linear between two values, between two order statistics.

    The number of values below the true quantile is binomial, so the interval holds for any
    continuous distribution (W. J. Conover, Practical Nonparametric Statistics, 3.2).

    Parameters
    ----------
    ascending : ndarray, shape (n,)
        Independent values, sorted.
    q : float
        Between 0 and 1.
    """
    n, rest = len(ascending), 0.5 * (1 - CONFIDENCE)
    low, high = _count(rest, n, q) - 1, _count(1 - rest, n, q)
    return Quantile(
        float(quantiles(ascending, q)),
        float(ascending[low]) if low >= 0 else -math.inf,
        float(ascending[high]) if high < n else math.inf,
    )


def _count(probability: float, n: int, q: float) -> int:
    """Least number of n values that are below the quantile with a probability."""
    found = math.ceil(float(scipy.special.bdtrik(probability, n, q)))
    below = max(found - 1, 0)
    return below if float(scipy.special.bdtr(below, n, q)) >= probability else found


def share_of(count: int, n: int) -> Share:
    """Share of `count` among n independent trials.

    C. J. Clopper, E. S. Pearson: The use of confidence or fiducial limits illustrated in the case
    of the binomial. Biometrika 26 (1934) 404-413.
    """
    if not n:
        return Share(math.nan, 0.0, 1.0)
    rest = 0.5 * (1 - CONFIDENCE)
    low = scipy.special.betaincinv(count, n - count + 1, rest) if count else 0.0
    high = scipy.special.betaincinv(count + 1, n - count, 1 - rest) if count < n else 1.0
    return Share(count / n, float(low), float(high))
