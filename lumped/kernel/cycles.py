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
from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers, kernel, last_up_to, power, sqrt

(NO_MEAN, GOODMAN, GERBER, SMITH_WATSON_TOPPER, WALKER, FKM) = range(6)
"""How the mean of a cycle counts. Goodman's and Gerber's number is the ultimate strength, Walker's
the exponent, that of the FKM the mean-stress sensitivity; the others have none. A mean in
compression is no advantage by Goodman and Gerber."""

(THREE, FOUR) = (3, 4)
"""Points that a cycle is found from: three with the start point, what is left being half cycles; or
four, what is left being the residue."""


class Count(Record):
    """Counts of the cycles of several loads.

    Attributes
    ----------
    loads, depth : int
        How many loads, and for each the room for turning points that closed no cycle yet.
    rule : Integers
        `THREE` or `FOUR`.
    scale : Numbers
        Stress for each unit of the load.
    row, curve, extends_down : Integers, Numbers, Integers
        First row of each curve, then the end of the last; amplitude, damage of a cycle and slope
        from each amplitude on, ascending; whether the first law holds below its amplitude.
    mean_stress, mean_number : Integers, Numbers
        How means count, and the number that belongs to it.
    held, held_at, size : Numbers, Integers, Integers
        Turning points that closed no cycle yet, their numbers among all values, and how many there
        are; with one more than there is room for the damage is nan.
    fed, last, last_at, direction : Integers, Numbers, Integers, Integers
        How many values there were; the latest, its number, and whether they rise (1) or fall (-1).
    damage : Numbers
        Sum of the damage of all cycles.
    values, notes : int, int
        Of a load that is given as a whole: how many values it has, and whether its cycles and
        turning points are noted.
    noted, noted_cycle, noted_weight : int, Integers, Numbers
        Cycles: numbers of the values at which they begin and end, and 1, or 0.5 for half of one.
    turned, turn : int, Integers
        Numbers of the values at which the load turned.
    """

    loads: int
    depth: int
    rule: Annotated[Integers, "loads"]
    scale: Annotated[Numbers, "loads"]
    row: Annotated[Integers, "loads + 1"]
    curve: Numbers
    extends_down: Annotated[Integers, "loads"]
    mean_stress: Annotated[Integers, "loads"]
    mean_number: Annotated[Numbers, "loads"]

    held: Annotated[Numbers, "loads * depth"]
    held_at: Annotated[Integers, "loads * depth"]
    size: Annotated[Integers, "loads"]
    fed: Annotated[Integers, "loads"]
    last: Annotated[Numbers, "loads"]
    last_at: Annotated[Integers, "loads"]
    direction: Annotated[Integers, "loads"]
    damage: Annotated[Numbers, "loads"]

    values: int
    notes: int
    noted: int
    noted_cycle: Integers
    noted_weight: Numbers
    turned: int
    turn: Integers


@kernel
def _at_mean_zero(count: Count, k: int, amplitude: float, mean: float) -> float:
    """Amplitude that does the same damage at mean zero."""
    kind, number, top = count.mean_stress[k], count.mean_number[k], mean + amplitude
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
def _slope_by_amplitude(count: Count, k: int, amplitude: float, mean: float) -> float:
    """Derivative of the amplitude at mean zero by the amplitude."""
    kind, number, top = count.mean_stress[k], count.mean_number[k], mean + amplitude
    if kind == GOODMAN or kind == GERBER:
        return _at_mean_zero(count, k, amplitude, mean) / amplitude
    if kind == SMITH_WATSON_TOPPER:
        here = _at_mean_zero(count, k, amplitude, mean)
        return 0.5 * (top + amplitude) / here if top > 0.0 else 0.0
    if kind == WALKER:
        share = (1.0 - number) / top + number / amplitude if top > 0.0 else 0.0
        return _at_mean_zero(count, k, amplitude, mean) * share
    if kind == FKM:
        if mean < -amplitude:
            return 1.0 - number
        if mean <= amplitude:
            return 1.0
        beyond = (1.0 + number) / (1.0 + number / 3.0)
        return beyond if mean < 3.0 * amplitude else beyond * (1.0 + number)
    return 1.0


@kernel
def _slope_by_mean(count: Count, k: int, amplitude: float, mean: float) -> float:
    """Derivative of the amplitude at mean zero by the mean."""
    kind, number, top = count.mean_stress[k], count.mean_number[k], mean + amplitude
    here = _at_mean_zero(count, k, amplitude, mean)
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
def _row(count: Count, k: int, amplitude: float) -> int:
    """Row of the curve that holds at an amplitude; -1 below all."""
    first = count.row[k]
    found = last_up_to(count.curve, 3, first - 1, count.row[k + 1], amplitude)
    if found < first:
        return first if count.extends_down[k] else -1
    return found


@kernel
def _damage(count: Count, k: int, amplitude: float) -> float:
    """Damage of one cycle of an amplitude at mean zero."""
    i = _row(count, k, amplitude)
    if i < 0:
        return 0.0
    row = count.curve[3 * i :]
    return row[1] * power(amplitude / row[0], row[2])


@kernel
def _add(count: Count, k: int, size: float, mean: float, weight: float) -> None:
    """Add the damage of a cycle from its range and mean."""
    amplitude = _at_mean_zero(count, k, 0.5 * count.scale[k] * size, count.scale[k] * mean)
    count.damage[k] += weight * _damage(count, k, amplitude)


@kernel
def _take(count: Count, k: int, i: int, weight: float) -> None:
    """Take the cycle between two turning points that follow each other."""
    held, at = count.held[k * count.depth + i :], count.held_at[k * count.depth + i :]
    _add(count, k, abs(held[1] - held[0]), 0.5 * (held[0] + held[1]), weight)
    if count.notes:
        noted = count.noted_cycle[2 * count.noted :]
        noted[0], noted[1] = at[0], at[1]
        count.noted_weight[count.noted] = weight
        count.noted += 1


@kernel
def _drop(count: Count, k: int, i: int, number: int) -> None:
    """Take turning points away."""
    held, at = count.held[k * count.depth :], count.held_at[k * count.depth :]
    count.size[k] -= number
    for j in range(i, count.size[k]):
        held[j], at[j] = held[j + number], at[j + number]


@kernel
def _turn(count: Count, k: int, value: float, at: int) -> None:
    """Take a turning point, and all cycles that it closes."""
    held, n = count.held[k * count.depth :], count.size[k]
    if n == count.depth:
        count.damage[k] = math.nan
        return
    held[n], count.held_at[k * count.depth + n] = value, at
    count.size[k] = n + 1
    if count.notes:
        count.turn[count.turned] = at
        count.turned += 1
    while count.size[k] >= count.rule[k]:
        n = count.size[k]
        newest, inner = abs(held[n - 1] - held[n - 2]), abs(held[n - 2] - held[n - 3])
        if newest < inner:
            break
        if count.rule[k] == FOUR and inner > abs(held[n - 3] - held[n - 4]):
            break
        if n == THREE:
            _take(count, k, 0, 0.5)
            _drop(count, k, 0, 1)
        else:
            _take(count, k, n - 3, 1.0)
            _drop(count, k, n - 3, 2)


@kernel
def begin_count(count: Count) -> None:
    """Nothing has been counted yet."""
    count.noted = count.turned = 0
    for k in range(count.loads):
        count.size[k] = count.fed[k] = count.direction[k] = 0
        count.damage[k] = 0.0


@kernel
def feed(count: Count, k: int, value: float) -> None:
    """Take the next value of a load."""
    number = count.fed[k]
    count.fed[k] = number + 1
    if number > 0 and value == count.last[k]:
        return
    if number == 0:
        _turn(count, k, value, 0)
    else:
        direction = 1 if value > count.last[k] else -1
        if count.direction[k] + direction == 0:
            _turn(count, k, count.last[k], count.last_at[k])
        count.direction[k] = direction
    count.last[k], count.last_at[k] = value, number
    if value != value:
        count.damage[k] = value


@kernel
def end_count(count: Count, k: int) -> None:
    """The last value of a load is a turning point, and of three points half cycles are left."""
    if count.direction[k] != 0:
        _turn(count, k, count.last[k], count.last_at[k])
    if count.rule[k] == THREE:
        for i in range(count.size[k] - 1):
            _take(count, k, i, 0.5)
        count.size[k] = 0


@kernel
def count_all(count: Count, load: Numbers) -> int:
    """Count the cycles of a whole load."""
    begin_count(count)
    for i in range(count.values):
        feed(count, 0, load[i])
    end_count(count, 0)
    return 0


@kernel
def sum_damage(count: Count, cycles: Numbers, found: Numbers) -> int:
    """Damage of each of given cycles, and its derivatives by range and mean; and their sum.

    A cycle is its range, its mean and 1, or 0.5 for half of one, which multiplies what is found.
    """
    begin_count(count)
    scale = count.scale[0]
    for i in range(count.values):
        cycle, out = cycles[3 * i :], found[3 * i :]
        _add(count, 0, cycle[0], cycle[1], cycle[2])
        amplitude, mean = 0.5 * scale * cycle[0], scale * cycle[1]
        at_zero = _at_mean_zero(count, 0, amplitude, mean)
        row = _row(count, 0, at_zero)
        out[0] = out[1] = out[2] = 0.0
        if row >= 0 and at_zero > 0.0:
            out[0] = cycle[2] * _damage(count, 0, at_zero)
            slope = out[0] * count.curve[3 * row + 2] / at_zero * scale
            out[1] = 0.5 * slope * _slope_by_amplitude(count, 0, amplitude, mean)
            out[2] = slope * _slope_by_mean(count, 0, amplitude, mean)
    return 0
