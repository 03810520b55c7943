"""Distributions of a parameter as they are written, and in numbers of its unit."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.errors import OptionError, ParameterError, shown
from lumped.support.units import amount, has_unit, plain

__all__ = [
    "Array",
    "Distribution",
    "Frozen",
    "Law",
    "Lognormal",
    "Normal",
    "Parameter",
    "Scaled",
    "Triangular",
    "Truncated",
    "Uniform",
    "distribution_of",
    "is_distribution",
]

Array = NDArray[np.float64]
Amount = float | str
"""A number in SI units, or a text with a unit."""

_SHARE = 1e-9
"""Least share of a distribution that may be left between two ends, known to 1e-7 of itself."""
_ALL = 1 - 2.0**-53
"""Greatest probability below one, of which a quantile is infinite."""


@dataclass(frozen=True)
class Parameter:
    """What a distribution is for.

    Attributes
    ----------
    name : str
        With which errors begin.
    unit : str
        Its SI unit.
    nominal : float or None
        Its value in the model; None for a factor.
    """

    name: str
    unit: str
    nominal: float | None

    def value(self, what: str, given: object) -> float:
        """One of its values, as a number in its unit.

        Raises
        ------
        UnitError
            If its unit is of another dimension.
        ParameterError
            If it is no number.
        """
        found = plain(given, self.unit, f"{self.name}: {what} =", ParameterError)
        if not math.isfinite(found):
            raise ParameterError(f"{self.name}: {what} = {given} must be a finite number.")
        return found

    def width(self, what: str, given: Any) -> float:
        """A difference of its values, greater than zero; 5 degC is 5 K here.

        Raises
        ------
        UnitError
            If its unit is of another dimension.
        ParameterError
            If it is no number.
        OptionError
            If it is not greater than zero.
        """
        found = self.value(what, given)
        if isinstance(given, str):
            found -= self.value(what, f"0 {given.strip().partition(' ')[2]}")
        elif has_unit(given):
            found -= self.value(what, type(given)(0.0, given.units))
        if not found > 0:
            self.refuse(
                f"{what} = {self.amount(found)} must be greater than zero. Leave out a parameter "
                "that does not vary."
            )
        return found

    def amount(self, value: float) -> str:
        """A value with the unit."""
        return amount(value, self.unit)

    def in_order(self, low: float, high: float) -> None:
        """Refuse ends of a range that are not in order.

        Raises
        ------
        OptionError
            With both.
        """
        if not low < high:
            self.refuse(
                f"low = {self.amount(low)} must be less than high = {self.amount(high)}. Give the "
                "smaller one first."
            )

    def refuse(self, text: str) -> NoReturn:
        """Refuse a distribution of this parameter.

        Raises
        ------
        OptionError
            Always.
        """
        raise OptionError(f"{self.name}: {text}")


@dataclass(frozen=True)
class Law:
    """A distribution in numbers of the unit of its parameter.

    Attributes
    ----------
    quantile : callable
        Value for each probability, array to array.
    below, above : callable
        Probability of less, and of more, than a number.
    """

    quantile: Callable[[Array], Array]
    below: Callable[[float], float]
    above: Callable[[float], float]


class Distribution(ABC):
    """A distribution as it was written, with units perhaps."""

    @abstractmethod
    def law(self, of: Parameter) -> Law:
        """The distribution in numbers.

        Raises
        ------
        LumpedError
            If what was given is no distribution of this parameter.
        """


@dataclass(frozen=True)
class Normal(Distribution):
    """Normal, by mean and standard deviation."""

    mean: Amount
    std: Amount

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        mean, std = of.value("mean", self.mean), of.width("std", self.std)
        ndtr, ndtri = scipy.special.ndtr, scipy.special.ndtri
        return Law(
            lambda u: np.asarray(mean + std * ndtri(u)),
            lambda x: float(ndtr((x - mean) / std)),
            lambda x: float(ndtr((mean - x) / std)),
        )


@dataclass(frozen=True)
class Uniform(Distribution):
    """Equally likely everywhere between two ends."""

    low: Amount
    high: Amount

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        low, high = of.value("low", self.low), of.value("high", self.high)
        of.in_order(low, high)
        width = high - low
        return Law(
            lambda u: low + width * u,
            lambda x: _probability((x - low) / width),
            lambda x: _probability((high - x) / width),
        )


@dataclass(frozen=True)
class Triangular(Distribution):
    """With a triangle as density."""

    low: Amount
    mode: Amount
    high: Amount

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        low, mode = of.value("low", self.low), of.value("mode", self.mode)
        high = of.value("high", self.high)
        of.in_order(low, high)
        if not low <= mode <= high:
            of.refuse(
                f"mode = {of.amount(mode)} must lie between low = {of.amount(low)} and high = "
                f"{of.amount(high)}."
            )
        width, rise, fall = high - low, mode - low, high - mode

        def quantile(u: Array) -> Array:
            rising, falling = np.sqrt(width * rise * u), np.sqrt(width * fall * (1 - u))
            return np.where(u * width < rise, low + rising, high - falling)

        def below(x: float) -> float:
            if x <= low:
                return 0.0
            return (x - low) ** 2 / (width * rise) if x < mode else 1.0 - above(x)

        def above(x: float) -> float:
            if x >= high:
                return 0.0
            return (high - x) ** 2 / (width * fall) if x >= mode else 1.0 - below(x)

        return Law(quantile, below, above)


@dataclass(frozen=True)
class Lognormal(Distribution):
    """With a normal logarithm."""

    median: Amount
    sigma: Amount

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        median = of.value("median", self.median)
        sigma = Parameter(of.name, "1", None).width("sigma", self.sigma)
        if not median > 0:
            of.refuse(f"median = {of.amount(median)} must be greater than zero.")

        def score(x: float) -> float:
            return (math.log(x) - math.log(median)) / sigma if x > 0 else -math.inf

        return Law(
            lambda u: np.asarray(median * np.exp(sigma * scipy.special.ndtri(u))),
            lambda x: float(scipy.special.ndtr(score(x))),
            lambda x: float(scipy.special.ndtr(-score(x))),
        )


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
        of.in_order(low, high)
        whole = self.distribution.law(of)
        before, after = whole.below(low), whole.above(high)
        share = 1.0 - before - after
        if not share >= _SHARE:
            of.refuse(
                f"the truncated distribution has a share of {max(share, 0.0):.2g} between low = "
                f"{of.amount(low)} and high = {of.amount(high)}; {_SHARE:g} is needed. Move the "
                "ends to where the distribution is."
            )
        return Law(
            lambda u: np.clip(whole.quantile(np.minimum(before + share * u, _ALL)), low, high),
            lambda x: _probability((whole.below(x) - before) / share),
            lambda x: _probability((whole.above(x) - after) / share),
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
        return Law(
            lambda u: own * factor.quantile(u),
            lambda x: below(x / own),
            lambda x: above(x / own),
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
        return Law(
            lambda u: np.asarray(given.ppf(u), dtype=float),
            lambda x: float(given.cdf(np.nextafter(x, -np.inf))),
            lambda x: float(given.sf(x)),
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


def _probability(value: float) -> float:
    return min(max(value, 0.0), 1.0)
