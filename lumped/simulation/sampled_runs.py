"""Runs of which both the values at given instants and both sides of jumps are wanted."""

from __future__ import annotations

import numpy as np

from lumped.support.progress import Progress
from lumped.timeloop.recorder import Recorder, output_times
from lumped.timeloop.result import OperatingPoint, Trajectory
from lumped.timeloop.run_by_steps import RunBySteps

__all__ = ["places_of", "sampled"]

_MOST_STEPS = 1_000_000
_SAME = 1e-12
"""Distance in time, over the end of the run, below which an instant is that of an event."""


def sampled(point: OperatingPoint, t: np.ndarray, rtol: float) -> Trajectory:
    """A run by steps to the last of some instants, with output at each of them.

    Both sides of jumps are recorded too, so that derivatives can be followed across them.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Instants, ascending, s.
    """
    begin, until = point.time, float(t[-1])
    times = output_times(np.union1d(begin, t), until, begin)
    with Progress(point.system.name, until - begin) as progress:
        output = Recorder(begin, until, times, True, progress)
        atol = max(rtol * 1e-3, 1e-12)
        run = RunBySteps(point, until, rtol, output, atol, "steps", _MOST_STEPS)
        run.go()
    return run.trajectory()


def places_of(run: Trajectory, t: np.ndarray) -> np.ndarray:
    """Points of such a run at its instants; on a jump those after it."""
    found: np.ndarray = np.searchsorted(run.t, t + _SAME * run.t[-1], "right") - 1
    return found
