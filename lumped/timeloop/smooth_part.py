"""Differential equations from one instant to another, without changes of position."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np

from lumped.kernel import engine
from lumped.kernel.run import DONE, FULL, RESTART, RunOutput
from lumped.timeloop.executable import Executable, span

__all__ = ["Method", "SmoothSolution", "smooth_part"]

Method = Literal["explicit", "implicit"]


class SmoothSolution(NamedTuple):
    """States at the times that were asked for.

    Attributes
    ----------
    x : ndarray, shape (k, n)
        States.
    evaluations : int
        Evaluations of the rates.
    fault_at : float or None
        Where the steps became too small or the rates are not finite; None if all went well.
    """

    x: np.ndarray
    evaluations: int
    fault_at: float | None


def smooth_part(
    code: Executable,
    theta: np.ndarray,
    t: np.ndarray,
    x: np.ndarray,
    settings: np.ndarray,
    method: Method,
    rtol: float,
    atol: np.ndarray,
) -> SmoothSolution:
    """States at times, from those at the first.

    Parameters
    ----------
    t : ndarray, shape (k,)
        Times, ascending, s.
    x, atol : ndarray, shape (n,)
        States at the first; absolute tolerance of each.
    settings : ndarray
        Modes and implicit quantities.
    """
    run = code.new_run(theta, float(t[0]), x, settings)
    span(run, max(abs(float(t[0])), abs(float(t[-1]))))
    run.rtol, run.max_steps = rtol, 1 << 60
    run.atol[:] = atol
    run.phase, run.end = RESTART, float(t[-1])
    run.segments, run.edges = 1, np.array([t[0], t[-1]], dtype=float)
    run.sampled_to = math.inf
    if method == "implicit":
        code.add_matrix(run)
        run.is_implicit = 1
    grid = np.ascontiguousarray(t[1:], dtype=float)
    rows = len(grid) + 8
    found, implicit = np.empty((rows, len(x))), np.empty(rows * len(settings))
    run.output = RunOutput(
        t=np.empty(rows),
        x=found.ravel(),
        implicit=implicit,
        most_rows=rows,
        most_pieces=1,
        most_changes=1,
        grid=grid,
        grid_size=len(grid),
        is_on_grid=1,
    )
    why = FULL
    while why == FULL:
        run.pause = run.steps + run.rejected + code.attempts
        why = engine.call("loop", run)
        code.account(run)
    rest = len(grid) - run.output.rows
    inner = found[: run.output.rows]
    last = np.repeat(run.x[None, :], rest, axis=0)
    fault_at = None if why == DONE else float(run.t)
    return SmoothSolution(np.vstack([x[None, :], inner, last]), run.evaluations, fault_at)
