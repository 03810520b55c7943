"""Functions of a run inside its steps, and at any time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from lumped.gradients.legs import SmoothParts
from lumped.gradients.spans import Span
from lumped.gradients.steps import FRACTIONS, Steps
from lumped.gradients.stretches import stretches
from lumped.timeloop.plants.many_points import ManyPoints

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
    values : ndarray, shape (steps, samples, results)
        Results of the function.
    """

    leg: np.ndarray
    t: np.ndarray
    values: np.ndarray


def sample_steps(course: SmoothParts, function: ManyPoints) -> Iterator[Samples]:
    """A function in all steps of a run, some at once."""
    last = np.zeros(function.results)
    for stretch in stretches(course.legs):
        whole = stretch.span(course.legs)
        number, begin, end = np.array(stretch.legs).T
        numbers = np.repeat(number, end - begin + 1)
        follows = np.ones(len(whole.t), dtype=bool)  # on a step of the same part
        follows[np.array(stretch.places)[begin == 0]] = False
        for k in range(0, len(whole.t) - 1, _AT_ONCE):
            span = whole.part(k, min(k + _AT_ONCE, len(whole.t) - 1))
            count = len(span.t) - 1
            values = np.empty((count, len(FRACTIONS) + 1, function.results))
            values[:, 1:] = course.steps.evaluate_inside(span, function.counted, function.results)
            values[0, 0], values[1:, 0] = last, values[:-1, -1]
            last = values[-1, -1]
            new = np.flatnonzero(~follows[k : k + count])
            if len(new):
                values[new, 0] = function(span.x[new], span.theta, span.t[new], span.m[new])
            t = span.t[:-1, None] + np.diff(span.t)[:, None] * np.array([0.0, *FRACTIONS])
            t[:, -1] = span.t[1:]
            is_step = span.is_step > 0
            yield Samples(numbers[k : k + count][is_step], t[is_step], values[is_step])


def values_at(
    course: SmoothParts, function: ManyPoints, numbers: np.ndarray, times: np.ndarray
) -> np.ndarray:
    """A function at times in given smooth parts, shape (times, results): ends of shorter steps."""
    run, legs, t = course.run, course.legs, np.empty(len(times))
    x, m = (np.empty((len(times), len(v))) for v in legs[0].side(0))
    for number in np.unique(numbers).tolist():
        own, leg = numbers == number, legs[number]
        places = np.searchsorted(leg.t, times[own], "right") - 1
        t[own] = leg.t[places]
        x[own], m[own] = leg.sides(places)
    found = np.empty((len(times), function.results))
    inner = t != times
    if not inner.all():
        found[~inner] = function(x[~inner], run.theta, t[~inner], m[~inner])
    if inner.any():
        implicit = run.statistics.is_implicit(t[inner])
        given = run.theta, t[inner], times[inner], x[inner], m[inner], implicit
        found[inner] = function(
            states_at_ends(course.steps, *given), run.theta, times[inner], m[inner]
        )
    return found


def states_at_ends(
    steps: Steps,
    theta: np.ndarray,
    begin: np.ndarray,
    end: np.ndarray,
    x: np.ndarray,
    m: np.ndarray,
    is_implicit: np.ndarray,
) -> np.ndarray:
    """States at the ends of single steps from states and settings at their begins."""
    t = np.column_stack([begin, end]).ravel()
    twice = x.repeat(2, axis=0), m.repeat(2, axis=0)
    span = Span(theta, t, *twice, is_implicit.repeat(2)[:-1], range(1, len(t) - 1, 2))
    return steps.replay(span, np.tile([1, 0], len(begin)))[1::2]
