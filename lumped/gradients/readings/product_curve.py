"""A quantity of a run and its slope, at ends of steps and anywhere; where it turns exactly."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.legs import SmoothParts
from lumped.gradients.spans import Span
from lumped.gradients.steps import FRACTIONS, Steps
from lumped.numerics.bracketed_roots import find_bracketed_roots
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.plants.many_points import ManyPoints

_AT_ONCE = 1024
"""Steps that are looked at in one call."""
Window: TypeAlias = tuple[float, float] | None
"""Part of a run, s; None is the whole run."""

_AROUND = (1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0)
"""Parts of a step on both sides of a point in which the quantity may turn."""


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
    for stretch, whole in course.stretches():
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


@made_once
def differentiate_at_many(system: System, factors: tuple[str, ...]) -> ManyPoints:
    """A product, its derivative by time along the run, and those by states and parameters."""
    y, by_x, by_p, along = _slopes(system, factors)
    every = ca.densify(ca.vertcat(y, along, by_x.T, by_p.T))
    return ManyPoints(ca.Function("at_many", system.inputs, [every]))


@made_once
def differentiate_at_one(system: System, factors: tuple[str, ...]) -> ArrayFunction:
    """A product, its derivatives by states and parameters, by time along the run: (x, p, t, m)."""
    results = [ca.densify(each) for each in _slopes(system, factors)]
    return ArrayFunction(ca.Function("differentiated", system.inputs, results))


def _slopes(system: System, factors: tuple[str, ...]) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    """A product of quantities, its derivatives by states, parameters, and time along the run."""
    x, p, t, _ = system.inputs
    y = system.product(factors)
    along = ca.jtimes(y, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
    return y, ca.jacobian(y, x), ca.jacobian(y, p), along


class Turn(NamedTuple):
    """Where a quantity is greatest, or turns.

    Attributes
    ----------
    leg : int
        Number of the smooth part of the run.
    time, value : float
        Instant, s, and the value there times its sign.
    sign : float
        -1 if it is the opposite of the quantity that is greatest there.
    edge : int
        Number of the leg with whose begin the instant moves; 0 if it does not move.
    """

    leg: int
    time: float
    value: float
    sign: float
    edge: int


class Ends(NamedTuple):
    """A quantity and its slope at the ends of steps, arrays of one length, in order of time."""

    leg: np.ndarray
    t: np.ndarray
    y: np.ndarray
    slope: np.ndarray

    @property
    def of_legs(self) -> list[tuple[int, int, int]]:
        """Number of each smooth part, and its first and last place among them."""
        numbers, firsts = np.unique(self.leg, return_index=True)
        lasts = np.append(firsts[1:], len(self.leg)) - 1
        return list(zip(numbers.tolist(), firsts.tolist(), lasts.tolist(), strict=True))


class Points(NamedTuple):
    """Points inside steps, arrays of one length.

    Attributes
    ----------
    leg, t, length : ndarray
        Smooth part of the run, instant, and length of the step, s.
    value, sign : ndarray
        Value times its sign, and this.
    """

    leg: np.ndarray
    t: np.ndarray
    length: np.ndarray
    value: np.ndarray
    sign: np.ndarray

    def of(self, which: np.ndarray) -> Points:
        """Some of them."""
        return Points(*(v[which] for v in self))


@made_once
def look_along(system: System, factors: tuple[str, ...]) -> ManyPoints:
    """A product of quantities and its slope."""
    y, _, _, along = _slopes(system, factors)
    return ManyPoints(ca.Function("look", system.inputs, [ca.densify(ca.vertcat(y, along))]))


class ProductCurve:
    """A product of quantities and its slope anywhere in a run."""

    def __init__(self, course: SmoothParts, factors: tuple[str, ...]) -> None:
        self.course, self.run, self.legs, self.factors = course, course.run, course.legs, factors
        self.look = look_along(course.run.system, factors)

    def spans(self, between: Window = None) -> Iterator[tuple[np.ndarray, Span]]:
        """Steps, some at once, and the smooth part of each of their ends."""
        for stretch, span in self.course.stretches():
            number, begin, end = np.array(stretch.legs).T
            numbers, first, last = np.repeat(number, end - begin + 1), 0, len(span.t) - 1
            if between is not None:
                first = int(np.searchsorted(span.t, between[0]))
                last = int(np.searchsorted(span.t, between[1], "right")) - 1
            if last > first:
                yield numbers[first : last + 1], span.part(first, last)

    def ends(self, between: Window = None) -> Ends:
        """All ends of steps; that of a run without steps."""
        rows = [np.zeros((4, 0))]
        for numbers, span in self.spans(between):
            is_step = span.is_step > 0
            own = np.append(is_step, False) | np.append(False, is_step)
            found = self.look(span.x[own], span.theta, span.t[own], span.m[own])
            rows.append(np.array([numbers[own], span.t[own], *found.T]))
        table = np.concatenate(rows, axis=1)
        if not table.size:
            last, t = np.array([len(self.legs) - 1]), self.legs[-1].t[-1:]
            table = np.array([last, t, *self.at(last, t)])
        self.check(table)
        return Ends(table[0].astype(int), *table[1:])

    def check(self, found: np.ndarray) -> None:
        """Refuse what is not finite."""
        if not np.isfinite(found).all():
            names, run = ", ".join(self.factors), self.run
            raise SolverError(
                f"{run.system.name}: {names} is not finite somewhere in the run.", run
            )

    def at(self, legs: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Quantity and slope at times in smooth parts, shape (2, times)."""
        return values_at(self.course, self.look, legs, t).T

    def points(self, numbers: np.ndarray, span: Span, rows: np.ndarray) -> Points:
        """Points that kernels list, without signs; not ends at which the quantity goes on."""
        place, part, value = rows[:, 0].astype(int), rows[:, 1], rows[:, 2]
        self.check(value)
        length = np.diff(span.t)[place]
        t = np.where(part < 1.0, span.t[place] + part * length, span.t[place + 1])
        return Points(numbers[place], t, length, value, np.ones(len(t)))

    def locate(self, points: Points, between: Window = None) -> tuple[Points, np.ndarray]:
        """Where a quantity, times signs, is highest near points, and whether it was found.

        It is where the slope falls through zero, by shorter steps to there. Other points stay.
        """
        if not len(points.t):
            return points, np.zeros(0, dtype=bool)
        leg, t, length, value, sign = points
        low, high = np.array([self.legs[k].t[[0, -1]] for k in leg]).T
        if between is not None:
            low, high = np.maximum(low, between[0]), np.minimum(high, between[1])
        reach = np.array(_AROUND)[:, None] * length
        sides = np.array([np.maximum(t - reach, low), np.minimum(t + reach, high)])
        slopes = self.at(np.broadcast_to(leg, sides.shape).ravel(), sides.ravel())[1]
        slopes = sign * slopes.reshape(sides.shape)
        turns = (slopes[0] > 0) & (slopes[1] <= 0)
        is_found, nearest = turns.any(axis=0), turns.argmax(axis=0)
        own = np.flatnonzero(is_found)
        begin, end = sides[:, nearest[own], own]
        at_begin, at_end = slopes[:, nearest[own], own]
        t, value = t.copy(), value.copy()
        t[own] = find_bracketed_roots(
            lambda which, times: sign[own[which]] * self.at(leg[own[which]], times)[1],
            *(begin, end, at_begin, at_end),
            1e-15 * np.maximum(1.0, end),
        )
        value[own] = sign[own] * self.at(leg[own], t[own])[0]
        return points._replace(t=t, value=value), is_found
