"""Distributions that are given by a few numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.ensembles.laws import Amount, Array, Distribution, Law, Parameter


def density(z: Array) -> Array:
    """Of a standard normal variable."""
    found: Array = np.exp(-0.5 * z * z) / math.sqrt(2 * math.pi)
    return found


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

        def at_score(z: Array) -> tuple[Array, Array]:
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
