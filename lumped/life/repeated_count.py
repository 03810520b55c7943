"""Cycles of loads that follow each other, each so often, and then all again.

What a count by four points leaves open is joined to what follows and counted again, which gives the
cycles of the whole sequence (Amzallag and others, Int. J. Fatigue 16 (1994) 287). It changes no
more once a load was joined to itself, so the number of repetitions costs nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lumped.life.rainflow import Cycles
from lumped.timeloop.cycle_count import count_cycles

Real = NDArray[np.float64]
BETWEEN = -1
"""In place of the number of a load: a cycle that none of them makes alone."""


class _Open(NamedTuple):
    """Turning points that close no cycle yet, and to which load each belongs."""

    values: Real
    load: NDArray[np.int64]


class _Closed(NamedTuple):
    """Cycles: begins, ends, how many of each, and the loads of both ends."""

    begin: Real
    end: Real
    counts: Real
    begin_load: NDArray[np.int64]
    end_load: NDArray[np.int64]

    def times(self, number: int) -> _Closed:
        """The same so many times."""
        return self._replace(counts=number * self.counts)


def count_in_turn(
    loads: Sequence[Real], repetitions: Sequence[int]
) -> tuple[Cycles, NDArray[np.int64]]:
    """Cycles of a sequence of loads that is repeated for ever, in one turn of it.

    Parameters
    ----------
    loads : sequence of ndarray, shape (n,)
        In the order in which they happen.
    repetitions : sequence of int
        How often each happens, one right after the other.

    Returns
    -------
    cycles : Cycles
    load : ndarray of int, shape (k,)
        To which load each belongs: one in which it begins or ends, and that reaches both ends;
        else `BETWEEN`.
    """
    inside: list[_Closed] = []
    rests: list[_Open] = []
    for k, (load, number) in enumerate(zip(loads, repetitions, strict=True)):
        rest, closed = _count(_Open(load, np.full(len(load), k)))
        inside.append(closed.times(number))
        rests.append(rest)
    held = _Open(np.zeros(0), np.zeros(0, dtype=np.int64))
    while True:
        before, joined = held, list[_Closed]()
        for rest, number in zip(rests, repetitions, strict=True):
            held = _repeat(held, rest, number, joined)
        if np.array_equal(before.values, held.values):
            break
    every = _Closed(*(np.concatenate(parts) for parts in zip(*inside, *joined, strict=True)))
    cycles = Cycles(
        np.abs(every.end - every.begin),
        0.5 * (every.begin + every.end),
        every.counts,
        np.concatenate([rest.values for rest in rests]),
        np.zeros(0),
    )
    return cycles, _owners(every, loads)


def _count(given: _Open) -> tuple[_Open, _Closed]:
    """What is left open of turning points, and the cycles that they close."""
    found = count_cycles(given.values, rule="four")
    values, load = given.values[found.cycles.T], given.load[found.cycles.T]
    rest = _Open(given.values[found.residue], given.load[found.residue])
    return rest, _Closed(values[0], values[1], found.weights, load[0], load[1])


def _repeat(held: _Open, rest: _Open, number: int, joined: list[_Closed]) -> _Open:
    """What is left open after one load that happens so often; its cycles are added."""
    for left in range(number, 0, -1):
        before = held
        both = (np.concatenate(parts) for parts in zip(before, rest, strict=True))
        held, closed = _count(_Open(*both))
        if np.array_equal(before.values, held.values):
            joined.append(closed.times(left))
            return held
        joined.append(closed)
    return held


def _owners(every: _Closed, loads: Sequence[Real]) -> NDArray[np.int64]:
    """To which load each cycle belongs."""
    low, high = (np.array([f(load) for load in loads]) for f in (np.min, np.max))
    least, most = np.minimum(every.begin, every.end), np.maximum(every.begin, every.end)
    found = np.full(len(least), BETWEEN)
    for load in (every.begin_load, every.end_load):
        reaches = (low[load] <= least) & (most <= high[load])
        found[reaches] = load[reaches]
    return found
