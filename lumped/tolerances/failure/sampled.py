"""Probabilities and what is known of their errors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from lumped.tolerances.intervals import SCORE


@dataclass(frozen=True)
class Level:
    """One level of subset simulation.

    Attributes
    ----------
    value : float
        Of the functional, which is exceeded with the probability.
    probability : float
        That of this level, with those before it.
    accepted : float
        Share of the moves to the next sample that were taken; 1 for independent samples.
    """

    value: float
    probability: float
    accepted: float


@dataclass(frozen=True)
class Sampled:
    """A probability, and what is known of its error where it was sampled.

    Attributes
    ----------
    probability : float
        The estimate.
    deviation : float
        Its coefficient of variation; zero where nothing was sampled.
    interval : (float, float) or None
        Of 95 %, with a normal logarithm; the upper end includes `unknown`.
    unknown : float
        Probability of evaluations that failed.
    failed : int
        How many failed.
    remarks : tuple of str
        What speaks against the estimate.
    levels : tuple of Level
        Of subset simulation.
    """

    probability: float
    deviation: float
    interval: tuple[float, float] | None
    unknown: float
    failed: int
    remarks: tuple[str, ...] = ()
    levels: tuple[Level, ...] = ()

    @classmethod
    def from_computation(cls, probability: float, remarks: tuple[str, ...] = ()) -> Sampled:
        """A probability that was computed without samples."""
        return cls(probability, 0.0, None, 0.0, 0, remarks)


def interval(
    rare: float, deviation: float, unknown: float, is_rare: bool
) -> tuple[float, float, tuple[float, float]]:
    """Probability, coefficient of variation and interval of 95 % of an event.

    Parameters
    ----------
    rare, deviation : float
        Probability of the event, or of its contrary, and coefficient of variation.
    unknown : float
        Probability of evaluations that failed, in which the event may happen.
    is_rare : bool
        Whether it is the event that was estimated.
    """
    wide = math.exp(SCORE * deviation)
    low, high = rare / wide, min(rare * wide, 1.0)
    if is_rare:
        return rare, deviation, (low, min(high + unknown, 1.0))
    found = 1 - rare - unknown
    return found, rare * deviation / max(found, 1e-300), (max(1 - high - unknown, 0.0), 1 - low)
