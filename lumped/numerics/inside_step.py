"""States and margins inside a step."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any, Literal

import casadi as ca

__all__ = ["INSIDE", "Method", "below", "doubtful", "interpolated"]

Method = Literal["explicit", "implicit"]

INSIDE = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Fractions of each step at which it is asked whether a mode must change."""


def interpolated(method: Method, fraction: Any, before: Any, after: Any, columns: list[Any]) -> Any:
    """The dense output of a step, in numbers or symbols."""
    rest = 1 - fraction
    if method == "implicit":
        inner = columns[0] + fraction * (columns[1] + fraction * columns[2])
        return rest * before + fraction * (after + rest * inner)
    y = 0.0 * before
    for i in range(7):
        y = (y + columns[6 - i]) * (fraction if i % 2 == 0 else rest)
    return before + y


def below(samples: Sequence[Any]) -> Any:
    """Whether margins are below zero at a sample after the first (the state just settled)."""
    least = samples[1]
    for sample in samples[2:]:
        least = ca.fmin(least, sample)
    return least < 0


def doubtful(samples: Sequence[Any], slopes: Sequence[Any]) -> Any:
    """Whether margins may have been below zero between samples at equal distances; 0 or 1.

    Between samples a margin dips by an eighth of its second difference at most, if it is smooth.
    It is not resolved, and may dip by more, if its fourth difference is not small, or if the
    samples contradict its slopes.

    Parameters
    ----------
    samples : sequence of five vectors
        Margins at `INSIDE`, each shape (k, 1).
    slopes : sequence of two vectors
        Derivatives at the first and last sample, times the distance between these.
    """
    least, most = samples[0], samples[0]
    for sample in samples[1:]:
        least, most = ca.fmin(least, sample), ca.fmax(most, sample)
    rises = [b - a for a, b in itertools.pairwise(samples)]
    bends = [b - a for a, b in itertools.pairwise(rises)]
    bend = ca.fmax(ca.fmax(ca.fabs(bends[0]), ca.fabs(bends[1])), ca.fabs(bends[2]))
    # one-sided difference of fourth order (Fornberg, Mathematics of Computation 51 (1988) 699)
    weights = (-25 / 12, 4.0, -3.0, 4 / 3, -1 / 4)
    rough = ca.fabs(bends[0] - 2 * bends[1] + bends[2])
    for slope, sign, along in ((slopes[0], 1, samples), (slopes[1], -1, samples[::-1])):
        sampled = sum(sign * w * sample for w, sample in zip(weights, along, strict=True))
        rough = ca.fmax(rough, ca.fabs(0.25 * slope - sampled))
    falls, climbs = rises[0], rises[0]
    for rise in (*rises[1:], *slopes):
        falls, climbs = ca.fmin(falls, rise), ca.fmax(climbs, rise)
    dips = ca.logic_and(falls * climbs < 0, least < bend / 8)
    unresolved = ca.logic_and(rough > 0.2 * (most - least), least < rough)
    return ca.logic_or(dips, unresolved)
