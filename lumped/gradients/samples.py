"""Functions of a run inside its steps, and at any time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from lumped.gradients.adjoint import Leg, Steps
from lumped.gradients.step_code import FRACTIONS, Span
from lumped.gradients.stretches import stretches
from lumped.timeloop.point_function import PointFunction
from lumped.timeloop.result import Trajectory

__all__ = ["Samples", "sampled", "values_at"]

_AT_ONCE = 1024
"""Steps that are looked at in one call."""


class Samples(NamedTuple):
    """A function at the begin of steps, inside them, and at their end.

    Attributes
    ----------
    leg : ndarray of int, shape (steps,)
        Smooth part of each step.
    t : ndarray, shape (steps, samples)
        Times, s.
    values : ndarray, shape (steps, samples, width)
        Results of the function.
    """

    leg: np.ndarray
    t: np.ndarray
    values: np.ndarray


def sampled(
    run: Trajectory, legs: Sequence[Leg], steps: Steps, function: PointFunction
) -> Iterator[Samples]:
    """A function in all steps of a run, some at once."""
    for stretch in stretches(legs, _AT_ONCE):
        span = stretch.span(run, legs)
        count = len(span.t) - 1
        if not count:
            continue
        values = np.empty((count, len(FRACTIONS) + 1, function.width))
        values[:, 1:] = steps.looked(span, function.counted, function.width)
        values[1:, 0] = values[:-1, -1]
        begins = [
            place
            for (_, begin, end), place in zip(stretch.legs, stretch.places, strict=True)
            if end > begin
        ]
        values[begins, 0] = function(
            span.theta, *(np.asarray(v)[begins] for v in (span.t, span.x, span.m))
        )
        t = span.t[:-1, None] + np.diff(span.t)[:, None] * np.array([0.0, *FRACTIONS])
        t[:, -1] = span.t[1:]
        own = np.repeat([k for k, _, _ in stretch.legs], [b - a + 1 for _, a, b in stretch.legs])
        is_step = span.is_step > 0
        yield Samples(own[:-1][is_step], t[is_step], values[is_step])


def values_at(
    run: Trajectory,
    legs: Sequence[Leg],
    steps: Steps,
    function: PointFunction,
    numbers: Sequence[int],
    times: np.ndarray,
) -> np.ndarray:
    """A function at times in given smooth parts, shape (times, width): ends of shorter steps."""
    begins = [
        int(np.searchsorted(legs[number].t, time, "right")) - 1
        for number, time in zip(numbers, times.tolist(), strict=True)
    ]
    pairs = [(legs[number], begin) for number, begin in zip(numbers, begins, strict=True)]
    t = np.array([leg.t[begin] for leg, begin in pairs])
    x, m = (np.array([getattr(leg, v)[i] for leg, i in pairs]) for v in ("x", "settings"))
    found = np.empty((len(times), function.width))
    inner = t != times
    if not inner.all():
        found[~inner] = function(run.theta, t[~inner], x[~inner], m[~inner])
    if inner.any():
        ends = np.column_stack([t[inner], times[inner]]).ravel()
        twice = x[inner].repeat(2, axis=0), m[inner].repeat(2, axis=0)
        changes = range(1, len(ends) - 1, 2)
        span = Span(run.theta, ends, *twice, run.statistics.implicit_from, changes)
        found[inner] = steps.looked(span, function.counted, function.width)[::2, -1]
    return found
