"""Instants of functions of time that move with the parameters of a variant.

A clock is a condition on the time. Here are those that are linear in it and need no other; all
others change at the same instants in each variant, or are found in Python.
"""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers, copy_numbers, kernel
from lumped.kernel.interpret import evaluate
from lumped.kernel.plant import Function
from lumped.kernel.run import Run

_NEVER = 1e300


class Clocks(Record):
    """Clocks that move, and the instants of those that do not.

    Attributes
    ----------
    count, at : int, Function
        Of the clocks, and their arguments with their slopes at a time.
    now : Numbers
        Room for these.
    is_strict, setting, column : Integers
        Whether a clock is false at zero, its setting, and its place among those of the time.
    begin, end, first : float
        Begin and end of the runs, and the time just after the begin, s.
    apart, beyond : float
        Distance of instants that are one, and the latest that counts, s.
    still, still_time, still_values : int, Numbers, Numbers
        Instants of the other clocks, and the settings before the first, between two, after the
        last.
    instant, rises : Numbers, Integers
        When each changes, and whether it is true from then on, or always.
    edges, values : Numbers
        Ends of the segments between all instants, and the settings in each.
    """

    count: int
    at: Function
    now: Annotated[Numbers, "2 * clocks"]
    is_strict: Annotated[Integers, "clocks"]
    setting: Annotated[Integers, "clocks"]
    column: Annotated[Integers, "clocks"]
    begin: float
    end: float
    first: float
    apart: float
    beyond: float
    still: int
    still_time: Numbers
    still_values: Numbers
    instant: Annotated[Numbers, "clocks"]
    rises: Annotated[Integers, "clocks"]
    edges: Annotated[Numbers, "clocks + still + 2"]
    values: Annotated[Numbers, "(clocks + still + 1) * timed"]


@kernel
def _holds(clocks: Clocks, k: int, argument: float) -> bool:
    return argument > 0.0 or (argument == 0.0 and clocks.is_strict[k] == 0)


@kernel
def set_clocks(clocks: Clocks, run: Run, m: Numbers) -> None:
    """Settings just after the begin."""
    now, n, t = clocks.now, clocks.count, clocks.first
    if n == 0:
        return
    evaluate(clocks.at, run, run.x, t, run.m, now)
    for k in range(n):
        place, slope = now[k], now[n + k]
        later = place + slope * max(1e-300, 1e-15 * abs(t))
        holds = _holds(clocks, k, later)
        if later == 0.0 and place == 0.0 and slope != 0.0:
            holds = slope > 0.0
        m[clocks.setting[k]] = 1.0 if holds else 0.0


@kernel
def _find(clocks: Clocks, run: Run) -> None:
    """When each clock changes."""
    now, n = clocks.now, clocks.count
    evaluate(clocks.at, run, run.x, 0.0, run.m, now)
    for k in range(n):
        zero, rate = now[k], now[n + k]
        instant = -zero / rate if rate != 0.0 else _NEVER
        if clocks.begin < instant and instant <= clocks.beyond:
            clocks.instant[k] = instant
            clocks.rises[k] = rate > 0.0
        else:
            middle = zero + rate * 0.5 * (clocks.begin + clocks.end)
            clocks.instant[k] = _NEVER
            clocks.rises[k] = not _holds(clocks, k, middle)


@kernel
def _add(clocks: Clocks, count: int, time: float) -> int:
    """Add an instant to the edges, in order; gives how many there are."""
    edges = clocks.edges
    if not (clocks.begin < time and time <= clocks.end):
        return count
    i = count
    while i > 0 and edges[i] > time:
        edges[i + 1] = edges[i]
        i -= 1
    edges[i + 1] = time
    return count + 1


@kernel
def _merge(clocks: Clocks, count: int) -> int:
    """Leave out instants that rounding alone keeps apart; gives how many remain."""
    edges, kept, before = clocks.edges, 0, 0.0
    for i in range(1, count + 1):
        now = clocks.end if clocks.end - edges[i] <= clocks.apart else edges[i]
        if kept == 0 or now - before > clocks.apart:
            kept += 1
            edges[kept] = now
        before = now
    return kept


@kernel
def place_instants(clocks: Clocks, run: Run) -> None:
    """Set the segments of a run between all instants."""
    if clocks.count == 0:
        return
    _find(clocks, run)
    edges, count, timed = clocks.edges, 0, run.timed
    for i in range(clocks.still):
        count = _add(clocks, count, clocks.still_time[i])
    for k in range(clocks.count):
        count = _add(clocks, count, clocks.instant[k])
    count = _merge(clocks, count)
    edges[0], edges[count + 1] = clocks.begin, clocks.end
    row = 0
    for i in range(count + 1):
        middle = 0.5 * (edges[i] + edges[i + 1])
        if i == count and count > 0 and edges[count] == clocks.end:
            middle = clocks.end + clocks.apart
        while row < clocks.still and clocks.still_time[row] <= middle:
            row += 1
        copy_numbers(timed, clocks.still_values[row * timed :], clocks.values[i * timed :])
        for k in range(clocks.count):
            after = middle >= clocks.instant[k]
            clocks.values[i * timed + clocks.column[k]] = (
                1.0 if after == (clocks.rises[k] != 0) else 0.0
            )
    run.segments, run.edges, run.timed_values = count + 1, edges, clocks.values
