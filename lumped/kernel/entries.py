"""Kernels that Python calls: each takes addresses and returns an integer."""

from __future__ import annotations

from typing import Any

from lumped.code.words import Numbers, kernel
from lumped.kernel.cycles import count_all, sum_damage
from lumped.kernel.instants.linkages import close, close_first, converge
from lumped.kernel.instants.positions import begin, calm_positions, find_positions
from lumped.kernel.instants.yielding import watch_redundancy
from lumped.kernel.interpret import evaluate, prepare
from lumped.kernel.loop import loop
from lumped.kernel.many_runs.variants import (
    attempt_of,
    crossing_of,
    end_of,
    look_of,
    until_steps_of,
    variants,
)
from lumped.kernel.plant import Function
from lumped.kernel.recorded_steps.course import evaluate_inside, replay_steps
from lumped.kernel.recorded_steps.listing import list_points
from lumped.kernel.recorded_steps.sweep_back import sweep_steps
from lumped.kernel.run import Run, Samples


@kernel
def value(run: Run, function: Function, out: Numbers) -> int:
    """Evaluate a function where a run is."""
    evaluate(function, run, run.x, run.t, run.m, out)
    return 0


@kernel
def values(run: Run, function: Function, course: Samples) -> int:
    """Evaluate a function at points one after the other."""
    for k in range(course.points):
        x, m = course.x[course.states * k :], course.m[course.settings * k :]
        evaluate(function, run, x, course.t[k], m, course.found[course.results * k :])
    return 0


@kernel
def close_linkages(run: Run) -> int:
    """Close the linkages where a run is; whether they close."""
    return close(run, run.x, run.t, run.m)


@kernel
def converge_linkages(run: Run) -> int:
    """Close the linkages from the given guesses only; whether they close."""
    return converge(run, run.x, run.t, run.m)


@kernel
def prepare_parameters(run: Run) -> int:
    """Compute what functions need of parameters alone."""
    prepare(run)
    return 0


@kernel
def watch_constraints(run: Run) -> int:
    """Note whether constraints may be redundant."""
    watch_redundancy(run)
    return 0


_ALL: tuple[Any, ...] = (
    *(loop, begin, calm_positions, find_positions, value, values, close_linkages, close_first),
    *(converge_linkages, watch_constraints, prepare_parameters, replay_steps, evaluate_inside),
    *(list_points, sweep_steps, variants, until_steps_of, attempt_of, crossing_of, look_of, end_of),
    *(count_all, sum_damage),
)
ENTRIES: dict[str, Any] = {entry.function.__name__: entry for entry in _ALL}
