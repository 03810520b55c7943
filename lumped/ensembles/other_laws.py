"""Distributions made of others, of samples and of those of SciPy."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from lumped.ensembles.laws import Amount, Distribution, Law, Parameter, density, probability
from lumped.errors import OptionError, shown
from lumped.support.arrays import Real

_SHARE = 1e-9
"""Least share of a distribution that may be left between two ends, known to 1e-7 of itself."""
_ALL = 1 - 2.0**-53
"""Greatest probability below one, of which a quantile is infinite."""
_FEWEST = 20
"""Samples that a measured distribution needs at least."""
_MOST_KNOTS = 64
_FAR = 40.0
"""Standard normal numbers up to here have a probability above the least float."""


@dataclass(frozen=True)
class Truncated(Distribution):
    """The part of another between two ends; None is no end."""

    distribution: Distribution
    low: Amount | None
    high: Amount | None

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        low = -math.inf if self.low is None else of.value("low", self.low)
        high = math.inf if self.high is None else of.value("high", self.high)
        of.check_order(low, high)
        whole = self.distribution.law(of)
        before, after = whole.below(low), whole.above(high)
        share = 1.0 - before - after
        if not share >= _SHARE:
            of.refuse(
                f"the truncated distribution has a share of {max(share, 0.0):.2g} between low = "
                f"{of.amount(low)} and high = {of.amount(high)}; {_SHARE:g} is needed. Move the "
                "ends to where the distribution is."
            )

        def at_score(z: Real) -> tuple[Real, Real]:
            lower, upper = (
                np.minimum(cut + share * scipy.special.ndtr(each), _ALL)
                for cut, each in ((before, z), (after, -z))
            )
            own = np.where(lower < upper, 1.0, -1.0)
            own = own * scipy.special.ndtri(np.minimum(lower, upper))
            value, slope = whole.at_score(own)
            return np.clip(value, low, high), slope * share * density(z) / density(own)

        return Law(
            lambda u: np.clip(whole.quantile(np.minimum(before + share * u, _ALL)), low, high),
            lambda x: probability((whole.below(x) - before) / share),
            lambda x: probability((whole.above(x) - after) / share),
            at_score,
        )


@dataclass(frozen=True)
class Scaled(Distribution):
    """That of a factor times the parameter's own value."""

    distribution: Distribution

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        own = of.nominal
        if own is None:
            of.refuse(
                "a factor cannot be scaled again; write lumped.distributions.scaled once, "
                "outermost."
            )
        if own == 0:
            of.refuse("its value is zero, which no factor changes. Give a distribution of values.")
        factor = self.distribution.law(Parameter(f"{of.name}: factor", "1", None))
        below, above = factor.below, factor.above
        if own < 0:
            below, above = above, below

        def at_score(z: Real) -> tuple[Real, Real]:
            value, slope = factor.at_score(z)
            return own * value, own * slope

        return Law(
            lambda u: own * factor.quantile(u),
            lambda x: below(x / own),
            lambda x: above(x / own),
            at_score,
        )


@dataclass(frozen=True)
class Frozen(Distribution):
    """One of scipy.stats."""

    given: Any

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        given = self.given
        median = given.ppf(0.5)
        if np.ndim(median) or not np.isfinite(median):
            of.refuse(
                f"the median of the distribution of scipy.stats is {np.array(median).tolist()}, "
                "which is no finite number. Correct its arguments."
            )

        def at_score(z: Real) -> tuple[Real, Real]:
            value = np.where(
                z < 0, given.ppf(scipy.special.ndtr(z)), given.isf(scipy.special.ndtr(-z))
            )
            if not hasattr(given.dist, "pdf"):
                of.refuse(
                    f"scipy.stats.{given.dist.name} has no density, so that nothing has a "
                    "derivative by it. Draw samples, or give a continuous distribution."
                )
            return value, density(z) / given.pdf(value)

        return Law(
            lambda u: np.asarray(given.ppf(u), dtype=float),
            lambda x: float(given.cdf(np.nextafter(x, -np.inf))),
            lambda x: float(given.sf(x)),
            at_score,
        )


@dataclass(frozen=True, eq=False)
class Measured(Distribution):
    """That of measured samples: a smooth curve of the values over standard normal numbers.

    The samples are sorted and put into groups of equal size. The curve goes through the mean value
    of each group at the mean score of its ranks, by monotone cubics, and goes on as a line beyond
    them. So normal samples give a normal distribution.
    """

    samples: Sequence[Amount]

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        values = np.sort([of.value("a sample", each) for each in self.samples])
        count = len(values)
        if count < _FEWEST:
            of.refuse(
                f"{count} measured samples tell too little of a distribution; {_FEWEST} are "
                "needed. Measure more, or give a distribution such as normal(mean, std)."
            )
        groups = min(max(round(math.sqrt(count)), 4), _MOST_KNOTS)
        ranks = scipy.special.ndtri((np.arange(count) + 0.5) / count)
        x, z = (
            np.array([part.mean() for part in np.array_split(each, groups)])
            for each in (values, ranks)
        )
        if not (np.diff(x) > 0).all():
            of.refuse(
                "too many of the measured samples are equal for a continuous distribution. Give "
                "them with more digits, or leave out a parameter that does not vary."
            )
        first, last = (x[1] - x[0]) / (z[1] - z[0]), (x[-1] - x[-2]) / (z[-1] - z[-2])
        far = [x[0] - first * (_FAR + z[0]), x[-1] + last * (_FAR - z[-1])]
        places, heights = np.r_[-_FAR, z, _FAR], np.r_[far[0], x, far[1]]
        curve = scipy.interpolate.PchipInterpolator(places, heights)
        slope = curve.derivative()

        def score(value: float) -> float:
            if not heights[0] < value < heights[-1]:
                return math.copysign(math.inf, value - heights[1])
            k = int(np.searchsorted(heights, value))
            ends = places[k - 1], places[k]
            return float(scipy.optimize.brentq(lambda at: curve(at) - value, *ends, xtol=1e-13))

        return Law(
            lambda u: np.asarray(curve(scipy.special.ndtri(u))),
            lambda at: float(scipy.special.ndtr(score(at))),
            lambda at: float(scipy.special.ndtr(-score(at))),
            lambda at: (np.asarray(curve(at)), np.asarray(slope(at))),
        )


def is_distribution(value: object) -> bool:
    """Whether a value is meant as a distribution."""
    return isinstance(value, Distribution) or (hasattr(value, "ppf") and hasattr(value, "support"))


def distribution_of(value: Any, what: str) -> Distribution:
    """A distribution, given as one of ours or of scipy.stats.

    Raises
    ------
    OptionError
        If it is none; the text begins with `what`.
    """
    if isinstance(value, Distribution):
        return value
    if not is_distribution(value):
        raise OptionError(
            f"{what} {shown(value)}: a distribution such as lumped.normal(mean, std), or a frozen "
            "one of scipy.stats, is needed."
        )
    if hasattr(value, "freeze"):
        raise OptionError(
            f"{what} scipy.stats.{value.name}: give the distribution its arguments, "
            f"scipy.stats.{value.name}(...)."
        )
    return Frozen(value)
