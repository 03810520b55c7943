"""Cycles of a load counted as it goes on (rainflow), and the damage of each.

Sources: ASTM E1049-85, Standard Practices for Cycle Counting in Fatigue Analysis, 5.4.4 (three
points); Amzallag and others, Standardization of the rainflow counting method for fatigue analysis,
Int. J. Fatigue 16 (1994) 287 (four points); Dowling, Mean stress effects in stress-life and
strain-life fatigue, SAE 2004-01-2227 (Goodman to Walker); FKM-Richtlinie, Rechnerischer
Festigkeitsnachweis für Maschinenbauteile (mean-stress sensitivity, four regions).

Powers are those of the C library in all engines, so all give the same bits.
"""

from __future__ import annotations

import math

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers, kernel, power, sqrt

__all__ = [
    "FKM",
    "FOUR",
    "GERBER",
    "GOODMAN",
    "NO_MEAN",
    "SMITH_WATSON_TOPPER",
    "THREE",
    "WALKER",
    "Count",
    "begin_count",
    "count_all",
    "end_count",
    "feed",
    "sum_damage",
]

(NO_MEAN, GOODMAN, GERBER, SMITH_WATSON_TOPPER, WALKER, FKM) = range(6)
"""How the mean of a cycle counts. Goodman's and Gerber's number is the ultimate strength, Walker's
the exponent, that of the FKM the mean-stress sensitivity; the others have none. A mean in
compression is no advantage by Goodman and Gerber."""

(THREE, FOUR) = (3, 4)
"""Points that a cycle is found from: three with the start point, what is left being half cycles; or
four, what is left being the residue."""


class Count(Record):
    """A count of cycles.

    Attributes
    ----------
    rule : int
        `THREE` or `FOUR`.
    scale : float
        Stress for each unit of the load.
    rows, curve, extends_down : int, Numbers, int
        Amplitude, damage of a cycle and slope from each amplitude on, ascending, and whether the
        first law holds below its amplitude.
    mean_stress, mean_number : int, float
        How means count, and the number that belongs to it.
    depth, held, held_at, size : int, Numbers, Integers, int
        Room for turning points that closed no cycle yet; their values, their numbers among all that
        was fed, how many there are.
    is_full : int
        Whether the room was too small; the damage is nan then.
    values, fed : int, int
        How many values there are in a given load; how many were fed.
    last, last_at, direction : float, int, int
        The latest value, its number, and whether values rise (1) or fall (-1).
    damage, cycles : float, float
        Sum of the damage of all cycles, and their number.
    notes : int
        Whether cycles and turning points are noted.
    noted, noted_cycle, noted_weight : int, Integers, Numbers
        Cycles: numbers of their begins and ends, and 1 or 0.5 for half of one.
    turned, turn : int, Integers
        Numbers of turning points.
    """

    rule: int
    scale: float
    rows: int
    curve: Numbers
    extends_down: int
    mean_stress: int
    mean_number: float

    depth: int
    held: Numbers
    held_at: Integers
    size: int
    is_full: int
    values: int
    fed: int
    last: float
    last_at: int
    direction: int
    damage: float
    cycles: float

    notes: int
    noted: int
    noted_cycle: Integers
    noted_weight: Numbers
    turned: int
    turn: Integers


@kernel
def _at_mean_zero(count: Count, amplitude: float, mean: float) -> float:
    """Amplitude that does the same damage at mean zero."""
    kind, number, top = count.mean_stress, count.mean_number, mean + amplitude
    if kind == GOODMAN:
        left = 1.0 - max(mean, 0.0) / number
        return amplitude / left if left > 0.0 else math.inf
    if kind == GERBER:
        share = max(mean, 0.0) / number
        left = 1.0 - share * share
        return amplitude / left if left > 0.0 else math.inf
    if kind == SMITH_WATSON_TOPPER:
        return sqrt(max(top, 0.0) * amplitude)
    if kind == WALKER:
        return power(max(top, 0.0), 1.0 - number) * power(amplitude, number)
    if kind == FKM:
        third = number / 3.0
        if mean < -amplitude:
            return amplitude * (1.0 - number)
        if mean <= amplitude:
            return amplitude + number * mean
        beyond = (1.0 + number) / (1.0 + third)
        if mean < 3.0 * amplitude:
            return beyond * (amplitude + third * mean)
        return beyond * amplitude * (1.0 + number)
    return amplitude


@kernel
def _slope_by_amplitude(count: Count, amplitude: float, mean: float) -> float:
    """Derivative of the amplitude at mean zero by the amplitude."""
    kind, number, top = count.mean_stress, count.mean_number, mean + amplitude
    if kind == GOODMAN or kind == GERBER:
        return _at_mean_zero(count, amplitude, mean) / amplitude
    if kind == SMITH_WATSON_TOPPER:
        return 0.5 * (top + amplitude) / _at_mean_zero(count, amplitude, mean) if top > 0.0 else 0.0
    if kind == WALKER:
        share = (1.0 - number) / top + number / amplitude if top > 0.0 else 0.0
        return _at_mean_zero(count, amplitude, mean) * share
    if kind == FKM:
        if mean < -amplitude:
            return 1.0 - number
        if mean <= amplitude:
            return 1.0
        beyond = (1.0 + number) / (1.0 + number / 3.0)
        return beyond if mean < 3.0 * amplitude else beyond * (1.0 + number)
    return 1.0


@kernel
def _slope_by_mean(count: Count, amplitude: float, mean: float) -> float:
    """Derivative of the amplitude at mean zero by the mean."""
    kind, number, top = count.mean_stress, count.mean_number, mean + amplitude
    here = _at_mean_zero(count, amplitude, mean)
    if kind == GOODMAN and mean > 0.0:
        return here / (number - mean)
    if kind == GERBER and mean > 0.0:
        return 2.0 * here * mean / (number * number - mean * mean)
    if kind == SMITH_WATSON_TOPPER and top > 0.0:
        return 0.5 * amplitude / here
    if kind == WALKER and top > 0.0:
        return here * (1.0 - number) / top
    if kind == FKM and mean >= -amplitude and mean < 3.0 * amplitude:
        third = number / 3.0
        return number if mean <= amplitude else third * (1.0 + number) / (1.0 + third)
    return 0.0


@kernel
def _row(count: Count, amplitude: float) -> int:
    """Row of the curve that holds at an amplitude; -1 below all."""
    low, high = 0, count.rows
    while low < high:
        middle = (low + high) // 2
        if count.curve[3 * middle] <= amplitude:
            low = middle + 1
        else:
            high = middle
    return 0 if low == 0 and count.extends_down else low - 1


@kernel
def _damage(count: Count, amplitude: float) -> float:
    """Damage of one cycle of an amplitude at mean zero."""
    k = _row(count, amplitude)
    if k < 0:
        return 0.0
    row = count.curve[3 * k :]
    return row[1] * power(amplitude / row[0], row[2])


@kernel
def _add(count: Count, size: float, mean: float, weight: float) -> None:
    """Add the damage of a cycle from its range and mean."""
    amplitude = _at_mean_zero(count, 0.5 * count.scale * size, count.scale * mean)
    count.damage += weight * _damage(count, amplitude)
    count.cycles += weight


@kernel
def _take(count: Count, i: int, weight: float) -> None:
    """Take the cycle between two turning points that follow each other."""
    begin, end = count.held[i], count.held[i + 1]
    _add(count, abs(end - begin), 0.5 * (begin + end), weight)
    if count.notes:
        k = count.noted
        noted = count.noted_cycle[2 * k :]
        noted[0], noted[1] = count.held_at[i], count.held_at[i + 1]
        count.noted_weight[k] = weight
        count.noted = k + 1


@kernel
def _drop(count: Count, i: int, number: int) -> None:
    """Take turning points away."""
    count.size -= number
    for k in range(i, count.size):
        count.held[k], count.held_at[k] = count.held[k + number], count.held_at[k + number]


@kernel
def _turn(count: Count, value: float, at: int) -> None:
    """Take a turning point, and all cycles that it closes."""
    if count.size == count.depth:
        count.is_full = 1
        count.damage = math.nan
        return
    held, n = count.held, count.size
    held[n], count.held_at[n] = value, at
    count.size = n + 1
    if count.notes:
        count.turn[count.turned] = at
        count.turned += 1
    while count.size >= count.rule:
        n = count.size
        newest, inner = abs(held[n - 1] - held[n - 2]), abs(held[n - 2] - held[n - 3])
        if newest < inner:
            break
        if count.rule == FOUR and inner > abs(held[n - 3] - held[n - 4]):
            break
        if n == THREE:
            _take(count, 0, 0.5)
            _drop(count, 0, 1)
        else:
            _take(count, n - 3, 1.0)
            _drop(count, n - 3, 2)


@kernel
def begin_count(count: Count) -> None:
    """Nothing has been counted yet."""
    count.size = count.is_full = count.fed = count.direction = count.noted = count.turned = 0
    count.last = count.damage = count.cycles = 0.0


@kernel
def feed(count: Count, value: float) -> None:
    """Take the next value of the load."""
    number = count.fed
    count.fed = number + 1
    if number > 0 and value == count.last:
        return
    if number == 0:
        _turn(count, value, 0)
    else:
        direction = 1 if value > count.last else -1
        if count.direction + direction == 0:
            _turn(count, count.last, count.last_at)
        count.direction = direction
    count.last, count.last_at = value, number
    if value != value:
        count.damage = value


@kernel
def end_count(count: Count) -> None:
    """The load ends: its last value is a turning point, and of three points half cycles are left."""
    if count.direction != 0:
        _turn(count, count.last, count.last_at)
    if count.rule == THREE:
        for i in range(count.size - 1):
            _take(count, i, 0.5)
        count.size = 0


@kernel
def count_all(count: Count, load: Numbers) -> int:
    """Count the cycles of a whole load."""
    begin_count(count)
    for k in range(count.values):
        feed(count, load[k])
    end_count(count)
    return 0


@kernel
def sum_damage(count: Count, cycles: Numbers, found: Numbers) -> int:
    """Damage of each of given cycles, and its derivatives by range and mean; and their sum.

    A cycle is its range, its mean and 1, or 0.5 for half of one, which multiplies what is found.
    """
    begin_count(count)
    for k in range(count.values):
        cycle, out = cycles[3 * k :], found[3 * k :]
        size, mean, weight = cycle[0], cycle[1], cycle[2]
        _add(count, size, mean, weight)
        amplitude, mean = 0.5 * count.scale * size, count.scale * mean
        at_zero = _at_mean_zero(count, amplitude, mean)
        row = _row(count, at_zero)
        out[0] = out[1] = out[2] = 0.0
        if row >= 0 and at_zero > 0.0:
            out[0] = weight * _damage(count, at_zero)
            slope = out[0] * count.curve[3 * row + 2] / at_zero * count.scale
            out[1] = 0.5 * slope * _slope_by_amplitude(count, amplitude, mean)
            out[2] = slope * _slope_by_mean(count, amplitude, mean)
    return 0
