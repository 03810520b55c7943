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
from lumped.kernel.recorded_steps.course import looked, replayed
from lumped.kernel.recorded_steps.listing import listed
from lumped.kernel.recorded_steps.sweep_back import swept
from lumped.kernel.run import Run, Samples

__all__ = ["ENTRIES"]


@kernel
def value(run: Run, function: Function, out: Numbers) -> int:
    """Evaluate a function where a run stands."""
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
def closed(run: Run) -> int:
    """Close the linkages where a run stands; whether they close."""
    return close(run, run.x, run.t, run.m)


@kernel
def converged(run: Run) -> int:
    """Close the linkages from the given guesses only; whether they close."""
    return converge(run, run.x, run.t, run.m)


@kernel
def prepared(run: Run) -> int:
    """Compute what functions need of parameters alone."""
    prepare(run)
    return 0


@kernel
def watched(run: Run) -> int:
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
    "closed": closed,
    "converged": converged,
    "watched": watched,
    "prepared": prepared,
    "replayed": replayed,
    "looked": looked,
    "listed": listed,
    "swept": swept,
    "variants": variants,
    "until_steps_of": until_steps_of,
    "attempt_of": attempt_of,
    "crossing_of": crossing_of,
    "look_of": look_of,
    "end_of": end_of,
    "count_all": count_all,
    "sum_damage": sum_damage,
}
