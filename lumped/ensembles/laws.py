"""Distributions of parameters: as they are written, and in numbers of their units."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NoReturn

import numpy as np
import scipy

from lumped.errors import OptionError, ParameterError
from lumped.support.arrays import Real
from lumped.support.units import amount, has_unit, plain

_FAR, _PANELS, _NODES = 9.0, 120, 8
"""Scores up to which moments are integrated, parts of this range, and nodes of Gauss in each."""
Amount = float | str
"""A number in SI units, or a text with a unit."""


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

    def check_order(self, low: float, high: float) -> None:
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
    at_score : callable
        Value for each number of a standard normal variable, which has the same probability, and
        its derivative by that number. Both tails keep their digits.
    origin : (Distribution, Parameter) or None
        From which copies make it anew.
    """

    quantile: Callable[[Real], Real]
    below: Callable[[float], float]
    above: Callable[[float], float]
    at_score: Callable[[Real], tuple[Real, Real]]
    origin: tuple[Distribution, Parameter] | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return law_of, self.origin


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


def law_of(distribution: Distribution, of: Parameter) -> Law:
    """A distribution in numbers, which can be copied to other processes."""
    return replace(distribution.law(of), origin=(distribution, of))


def density(z: Real) -> Real:
    """Of a standard normal variable."""
    return np.exp(-0.5 * z * z) / math.sqrt(2 * math.pi)


def probability(value: float) -> float:
    """A number between zero and one, rounding apart."""
    return min(max(value, 0.0), 1.0)


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
            lambda z: (mean + std * z, np.full_like(z, std)),
        )


@dataclass(frozen=True)
class Uniform(Distribution):
    """Equally likely everywhere between two ends."""

    low: Amount
    high: Amount

    def law(self, of: Parameter) -> Law:
        """In numbers."""
        low, high = of.value("low", self.low), of.value("high", self.high)
        of.check_order(low, high)
        width = high - low
        return Law(
            lambda u: low + width * u,
            lambda x: probability((x - low) / width),
            lambda x: probability((high - x) / width),
            lambda z: (low + width * scipy.special.ndtr(z), width * density(z)),
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
        of.check_order(low, high)
        if not low <= mode <= high:
            of.refuse(
                f"mode = {of.amount(mode)} must lie between low = {of.amount(low)} and high = "
                f"{of.amount(high)}."
            )
        width, rise, fall = high - low, mode - low, high - mode

        def quantile(u: Real) -> Real:
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

        def at_score(z: Real) -> tuple[Real, Real]:
            before, after = scipy.special.ndtr(z), scipy.special.ndtr(-z)
            rises = before * width < rise
            rising, falling = np.sqrt(width * rise * before), np.sqrt(width * fall * after)
            root = np.where(rises, rising, falling)
            side = 0.5 * width * np.where(rises, rise, fall)
            return np.where(rises, low + rising, high - falling), side * density(z) / root

        return Law(quantile, below, above, at_score)


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
            lambda z: (median * np.exp(sigma * z), sigma * median * np.exp(sigma * z)),
        )


def central_moments(law: Law) -> tuple[float, Real]:
    """Mean of a distribution, and its central moments of orders 0 to 6.

    Integrals over the standard normal score, by Gauss's rule on short panels.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    half = _FAR / _PANELS
    middles = np.linspace(-_FAR + half, _FAR - half, _PANELS)
    z = (middles[:, None] + half * nodes).ravel()
    w = (half * np.broadcast_to(weights, (_PANELS, _NODES))).ravel() * density(z)
    w /= w.sum()
    x = law.at_score(z)[0]
    mean = float(w @ x)
    return mean, np.array([w @ (x - mean) ** k for k in range(7)])
