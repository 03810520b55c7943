"""Where a quantity turns in a run, located to rounding; damage by its turning points."""

from __future__ import annotations

import itertools

import numpy as np

from lumped.errors import SolverError
from lumped.functionals.damage_law import DamageLaw
from lumped.gradients.legs import SmoothParts
from lumped.gradients.readings.extremes import range_of, turning_points_in
from lumped.gradients.readings.product_curve import (
    Points,
    ProductCurve,
    Turn,
    differentiate_at_many,
    states_at_ends,
)
from lumped.timeloop.cycle_count import count_cycles, damage_of_cycles

_COARSE = 1e-3
"""Part of the range of a quantity by which a step may miss the next point of the run at most."""
_DIVISIONS = 8
"""How often steps are divided in two, at most; beyond `_COARSE` only while that helps."""

_ROUNDING = 1e-12
"""Of the terms of a quantity: swings below are rounding."""
_KEPT = 1e-13
"""Derivatives that are smaller than this part of the largest are left out."""


def turning_points(course: SmoothParts, factors: tuple[str, ...]) -> list[Turn]:
    """All points at which a quantity turns, in order of time; the first and the last among them.

    Of a jump, both sides are among them where the quantity turns there. Swings that are
    smaller, over its range, than the accuracy are left out, the last one too. Where points of the
    run are farther apart than steps, the steps between them are divided.

    Raises
    ------
    SolverError
        If the points of the run are too far apart to follow the quantity between them.
    """
    curve, steps, rtol = ProductCurve(course, factors), course.steps, course.rtol
    rounding = _follow(curve, rtol)
    ends = curve.ends()
    least, most = float(ends.y.min()), float(ends.y.max())
    for _, span in curve.spans():
        least, most = range_of(steps, span, factors, (least, most))
    curve.check(np.array([least, most]))
    swing = max(rtol * (most - least), rounding)
    h = np.diff(ends.t)
    length = np.maximum(np.append(h, 0.0), np.append(0.0, h))
    points = [Points(ends.leg, ends.t, length, ends.y, np.ones(len(length)))]
    if most - least > swing:
        for numbers, span in curve.spans():
            rows = turning_points_in(steps, span, factors, swing)
            points.append(curve.points(numbers, span, rows))
    merged = Points(*(np.concatenate(v) for v in zip(*points, strict=True)))
    merged = merged.of(np.lexsort((merged.t, merged.leg)))
    own = _swinging(_turning(merged), merged.value.tolist(), swing)
    turns = _locate_turns(curve, merged.of(np.array(own)))
    # an interpolation may turn where shorter steps do not
    own = _swinging(list(range(len(turns))), [turn.value for turn in turns], swing)
    return [turns[k] for k in own]


def _follow(curve: ProductCurve, rtol: float) -> float:
    """Divide steps between points of the run that are too far apart; gives what is rounding."""
    known = [curve.at(np.full(len(leg.t), k), leg.t)[0] for k, leg in enumerate(curve.legs)]
    curve.check(np.concatenate(known))
    floor = max(_ROUNDING * _terms(curve), 1e-300)
    size = max(float(np.ptp(np.concatenate(known))), floor)
    origins = [np.arange(len(y) - 1) for y in known]  # to which step of the run each part belongs
    before = [np.full(len(y) - 1, np.inf) for y in known]
    for _ in range(_DIVISIONS):
        missed = _measure_misses(curve, origins)
        wanted = [
            (m > rtol * size) & ((m < 0.5 * b) | (m > _COARSE * size))
            for m, b in zip(missed, before, strict=True)
        ]
        if not any(steps.any() for steps in wanted):
            break
        for k, leg in enumerate(curve.legs):
            parts = np.where(wanted[k][origins[k]], 2, 1)
            leg.divide(parts)
            origins[k] = np.repeat(origins[k], parts)
        before = [np.where(w, m, 0.0) for w, m in zip(wanted, missed, strict=True)]
    worst = max(float(m.max(initial=0.0)) for m in missed)
    if not worst <= _COARSE * size:
        raise SolverError(
            f"{curve.run.system.name}: {', '.join(curve.factors)} is off by {worst:.3g} where it "
            "is followed from one point of the run to the next. Record the run at its steps, "
            "simulate(..., grid=None), or make it with a smaller rtol.",
            curve.run,
        )
    return floor


def _terms(curve: ProductCurve) -> float:
    """Size of the terms of which a quantity consists, at the ends of the smooth parts."""
    sizes = [0.0]
    for leg in curve.legs:
        (x, m), t = leg.sides(np.array([0, len(leg.t) - 1])), leg.t[[0, -1]]
        found = differentiate_at_many(curve.run.system, curve.factors)(x, curve.run.theta, t, m)
        slopes = found[:, 2 : 2 + x.shape[1]]
        sizes.append(float(np.nan_to_num(np.abs(slopes * x)).sum(axis=1).max()))
    return max(sizes)


def _measure_misses(curve: ProductCurve, origins: list[np.ndarray]) -> list[np.ndarray]:
    """By how much each step of the run, in parts, misses its end."""
    missed = [np.zeros(origin[-1] + 1 if len(origin) else 0) for origin in origins]
    for numbers, span in curve.spans():
        own = np.flatnonzero(span.is_step)
        t, after = span.t[own], own + 1
        given = span.theta, t, span.t[after], span.x[own], span.m[own], span.is_implicit[own]
        x = states_at_ends(curve.course.steps, *given)
        found = curve.look(x, span.theta, span.t[after], span.m[own])
        off = np.abs(found - curve.look(span.x[after], span.theta, span.t[after], span.m[own]))
        off[:, 1] *= span.t[after] - t  # a slope that is off moves the turning points
        for number in np.unique(numbers[own]).tolist():
            of_leg = numbers[own] == number
            places = np.searchsorted(curve.legs[number].t, t[of_leg])
            np.maximum.at(missed[number], origins[number][places], off[of_leg].max(axis=1))
    return missed


def _turning(points: Points) -> list[int]:
    """Which of points in order are ends of smooth parts, or no less or no more than both beside."""
    rise = np.diff(points.value)
    turns = np.ones(len(points.t), dtype=bool)
    turns[1:-1] = (rise[:-1] * rise[1:] <= 0) & ((rise[:-1] != 0) | (rise[1:] != 0))
    is_new = np.diff(points.leg) > 0
    turns[1:] |= is_new
    turns[:-1] |= is_new
    return np.flatnonzero(turns).tolist()


def _swinging(places: list[int], y: list[float], least: float) -> list[int]:
    """Those between which the quantity swings by more than the least, and the first."""
    found, furthest, sign = [places[0]], places[0], 0.0
    lowest = highest = places[0]
    for place in places[1:]:
        if sign == 0:
            lowest = min(lowest, place, key=lambda k: y[k])
            highest = max(highest, place, key=lambda k: y[k])
            if y[highest] - y[lowest] > least:
                sign, furthest = (1.0, highest) if place == highest else (-1.0, lowest)
                other = lowest if place == highest else highest
                if other != places[0]:
                    found.append(other)
        elif sign * (y[place] - y[furthest]) > 0:
            furthest = place
        elif sign * (y[furthest] - y[place]) > least:
            found.append(furthest)
            furthest, sign = place, -sign
    return [*found, furthest if sign else places[-1]]


def _locate_turns(curve: ProductCurve, points: Points) -> list[Turn]:
    """Points between which the quantity swings, where it turns exactly; ends of legs stay."""
    last = len(curve.legs) - 1
    begin, end = np.array([curve.legs[k].t[[0, -1]] for k in points.leg]).T
    is_begin, is_end = points.t == begin, points.t == end
    sign = np.sign(np.diff(points.value, prepend=points.value[0]))
    inner = np.flatnonzero(~is_begin & ~is_end)
    found, _ = curve.locate(points._replace(sign=sign).of(inner))
    t, y = points.t.copy(), points.value.copy()
    t[inner], y[inner] = found.t, curve.at(found.leg, found.t)[0]
    edge = np.where(is_begin, points.leg, np.where(is_end & (points.leg < last), points.leg + 1, 0))
    rows = zip(*(v.tolist() for v in (points.leg, t, y, edge)), strict=True)
    return [Turn(leg, time, value, 1.0, moves) for leg, time, value, moves in rows]


def damage_slopes(values: np.ndarray, law: DamageLaw, slack: float) -> tuple[float, np.ndarray]:
    """Damage, and its derivatives by turning points, shape (alternatives, n).

    There are several alternatives where less than the slack decides between them: which of two
    extremes of the same height belongs to the larger cycle, or which row of the curve holds. The
    first one is that of the values as they are.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Turning points one after the other.
    slack : float
        Accuracy of the values.
    """
    damage, nominal = _slopes(values, law)
    size = np.abs(nominal).max(initial=0.0)
    range_ = np.ptp(values) if len(values) else 0.0
    if not (size > 0 and np.isfinite(size)):
        return damage, nominal[None]
    steepest = max(slope for _, _, slope in law.rows)
    same = size * min(20 * steepest * slack / range_, 0.1)
    alternatives = [nominal]
    for moved in _move_extremes(values, slack):
        slopes = _slopes(moved, law)[1]
        if all(np.abs(slopes - known).max() > same for known in alternatives):
            alternatives.append(slopes)
    found = np.array(alternatives)
    found[np.abs(found) <= _KEPT * size] = 0.0
    return damage, found


def _slopes(values: np.ndarray, law: DamageLaw) -> tuple[float, np.ndarray]:
    """Damage, and its derivatives by turning points."""
    counted = count_cycles(values, law)
    begin, end = counted.cycles.T
    swings = values[end] - values[begin]
    means = 0.5 * (values[begin] + values[end])
    _, found = damage_of_cycles(np.abs(swings), means, counted.weights, law)
    by_swing, by_mean = np.sign(swings) * found[:, 1], 0.5 * found[:, 2]
    slopes = np.bincount(end, by_mean + by_swing, len(values))
    slopes += np.bincount(begin, by_mean - by_swing, len(values))
    return counted.damage, slopes


def _move_extremes(values: np.ndarray, slack: float) -> list[np.ndarray]:
    """The values with all crests, or all troughs, further out or in, earlier or later ones more."""
    is_crest = np.append(values[:-1] > values[1:], values[-1:] > values[-2:-1])
    rising = np.linspace(0.5, 1.0, len(values))
    shares = (rising, rising[::-1], -rising, -rising[::-1])
    return [
        values + slack * np.where(is_crest, high, -low)
        for high, low in itertools.product(shares, repeat=2)
    ]
