"""States of a run that were left out, from a second run that has them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from lumped.compiler.system import System

_NEAR = 1e-5
"""How far apart instants of the same jump may be in two runs, relative to their length."""


def with_left_out(
    system: System, x: np.ndarray, left_out: Callable[[str], np.ndarray]
) -> tuple[System, np.ndarray]:
    """The system with all its states, and their values.

    Parameters
    ----------
    x : ndarray, shape (points, n)
        States of the system.
    left_out : callable
        Gives a state that was left out by its name, shape (points,).
    """
    whole, column = system.whole, {i: k for k, i in enumerate(system.structure.in_use)}
    columns = [
        x[:, column[place]] if place in column else left_out(name)
        for place, name in zip(whole.structure.in_use, whole.state_names, strict=True)
    ]
    return whole, np.column_stack(columns)


def on_both_sides(t: np.ndarray, y: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Values of one run at the times of another, which jumps where it does.

    Parameters
    ----------
    t, y : ndarray, shape (k,)
        Times, among them all `times`, and values; a time that occurs twice is a jump.
    times : ndarray, shape (points,)
        Times of the other run, s, in the same way. What jumps a little later or earlier in `y`
        is moved to these instants.
    """
    found: np.ndarray = y[np.searchsorted(t, times, "right") - 1].copy()
    near, twice = _NEAR * (times[-1] - times[0]), np.flatnonzero(np.diff(times) == 0)
    jumps = np.flatnonzero((np.diff(t) == 0) & (np.diff(y) != 0))
    instants, heights = t[jumps], np.diff(y)[jumps]
    for before in twice if len(jumps) else ():
        instant = times[before]
        close = np.abs(instants - instant) <= near
        found[before] -= heights[close & (instants <= instant)].sum()
        found[before + 1] += heights[close & (instants > instant)].sum()
    return found


@dataclass(frozen=True, eq=False)
class PointOfRun:
    """Makes a point of a run again, with the states that were left out.

    Attributes
    ----------
    run : callable
        Makes the run again at some times.
    time : float
        Instant, s.
    """

    run: Any
    time: float

    def __call__(self, _: System) -> Any:
        """The point."""
        return self.run(np.array([self.time])).point(self.time)
