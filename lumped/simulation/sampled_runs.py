"""Runs of which both the values at given instants and both sides of jumps are wanted."""

from __future__ import annotations

import numpy as np

from lumped.compiler.system import System
from lumped.points.start import run_start
from lumped.simulation.run_again import run_from
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunPlan

_SAME = 1e-12
"""Distance in time, over the end of the run, below which an instant is that of an event."""


def run_sampled(system: System, plan: RunPlan, t: np.ndarray) -> Trajectory:
    """A run by steps to the last of some instants, with output at each of them.

    Both sides of jumps are recorded too, so that derivatives can be followed across them.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Instants, ascending, s.
    """
    point = run_start(system, plan)
    times = np.union1d(plan.begin, t)
    return run_from(point, plan, Recorder(point, plan.until, times, True))


def places_of(run: Trajectory, t: np.ndarray) -> np.ndarray:
    """Points of such a run at its instants; on a jump those after it."""
    found: np.ndarray = np.searchsorted(run.t, t + _SAME * run.t[-1], "right") - 1
    return found
