"""Differential equations from one instant to another, without changes of position."""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from lumped.kernel import engine
from lumped.kernel.run import DONE, FULL, RESTART
from lumped.timeloop.plants.executable import Executable, span
from lumped.timeloop.plants.kept_run import KeptRun

Method = Literal["explicit", "implicit"]

_LEAST_ROWS = 64
"""Room for so many times at least, so that the next run can have it."""


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
    grid = np.ascontiguousarray(t[1:], dtype=float)
    rows = max(_LEAST_ROWS, 1 << (len(grid) + 8).bit_length())
    options = rtol, method, rows
    kept = code.reuse_run(options) or _with_options(code, options)
    run, room = kept.run, kept.room
    span(run, max(abs(float(t[0])), abs(float(t[-1]))))
    run.atol[:] = atol
    run.t, run.end = float(t[0]), float(t[-1])
    run.edges = np.array([t[0], t[-1]], dtype=float)
    room.begin(grid, 0, on_grid=True, both_sides=False)
    code.place(run, theta, x, settings)
    why = FULL
    while why == FULL:
        run.pause = run.steps + run.rejected + code.attempts
        why = engine.call("loop", run)
        code.account(run)
    count, last = room.output.rows, run.x[None, :].repeat(len(grid) - room.output.rows, axis=0)
    fault_at = None if why == DONE else float(run.t)
    found = np.concatenate([x[None, :], room.x[:count], last])
    code.take_back(kept)
    return SmoothSolution(found, run.evaluations, fault_at)


def _with_options(code: Executable, options: tuple[float, Method, int]) -> KeptRun:
    """Records of a run at no point yet."""
    rtol, method, rows = options
    run, plant = code.blank_run(), code.plant
    run.rtol, run.max_steps = rtol, 1 << 60
    run.phase, run.segments = RESTART, 1
    if method == "implicit":
        code.add_matrix(run)
        run.is_implicit = 1
    modes = plant.settings - plant.implicit
    room = code.room((rows, 1, 1, plant.states, plant.implicit, modes))
    run.output = room.output
    return KeptRun(options, run, room)
