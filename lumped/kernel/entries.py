"""Kernels that Python calls: each takes addresses and returns an integer."""

from __future__ import annotations

from typing import Any

from lumped.code.words import Numbers, kernel
from lumped.kernel.cycles import count_all, sum_damage
from lumped.kernel.instants.linkages import close, converge
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


ENTRIES: dict[str, Any] = {
    "loop": loop,
    "begin": begin,
    "calm_positions": calm_positions,
    "find_positions": find_positions,
    "value": value,
    "values": values,
    "close_linkages": close_linkages,
    "converge_linkages": converge_linkages,
    "watch_constraints": watch_constraints,
    "prepare_parameters": prepare_parameters,
    "replay_steps": replay_steps,
    "evaluate_inside": evaluate_inside,
    "list_points": list_points,
    "sweep_steps": sweep_steps,
    "variants": variants,
    "until_steps_of": until_steps_of,
    "attempt_of": attempt_of,
    "crossing_of": crossing_of,
    "look_of": look_of,
    "end_of": end_of,
    "count_all": count_all,
    "sum_damage": sum_damage,
}
