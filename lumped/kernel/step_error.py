"""Whether a step is good, and whether values inside it are needed."""

from __future__ import annotations

from lumped.code.words import kernel
from lumped.kernel.instants.linkages import follow
from lumped.kernel.methods.any_method import attempt
from lumped.kernel.observe import is_inside_wanted
from lumped.kernel.run import Run

SAFETY = 0.9
"""Part of the step that the tolerance allows."""
HOPELESS = 1e3
"""Largest error that is used: such a step is shortened as far as one attempt may."""
UNCLOSED = 100.0
"""Error of a step at whose end linkages do not close."""


@kernel
def is_finite(run: Run) -> bool:
    """Whether states and derivatives at the end of the step are numbers."""
    n, new, bad = run.plant.states, run.new, 0.0
    f = run.stages[12 * n :]
    for i in range(n):
        bad += 0.0 if abs(new[i]) < 1e300 and abs(f[i]) < 1e300 else 1.0
    return bad == 0.0


@kernel
def try_step(run: Run, h: float) -> float:
    """Error of a step, relative to the tolerance."""
    error = 0.0 if run.plant.states == 0 else attempt(run, h)
    if run.plant.implicit > 0 and not follow(run, run.new, run.t_new, run.m):
        return UNCLOSED
    return error if error < HOPELESS else HOPELESS  # nan too


@kernel
def is_dense_wanted(run: Run) -> bool:
    """Whether a value inside the step is needed."""
    output = run.output
    if run.plant.states == 0:
        if run.watches:
            run.watch.is_rough = run.watch.may_rise = 1
        return False
    is_watched = run.watches and is_inside_wanted(run)
    if run.plant.margins > 0 or is_watched:
        return True
    return output.grid_next < output.grid_size and output.grid[output.grid_next] < run.t_new
