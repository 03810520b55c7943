"""A sweep backwards over recorded steps, with the accuracy of what it finds."""

from __future__ import annotations

from lumped.code.words import kernel, sqrt
from lumped.kernel.methods.dop853 import integral_error
from lumped.kernel.recorded_steps import dop853_back, rodas5p_back
from lumped.kernel.recorded_steps.course import Course, Sweep, go_to_step
from lumped.kernel.recorded_steps.stops_back import Stops, add_pulses, begin_stops, cross
from lumped.kernel.run import DONE, GIVEN_UP, Run

LEAST = 1e-3
"""Derivative by a state, relative to the greatest by any, below which its accuracy does not matter;
both times the nominal value of the state."""
_DOUBT = 2.0
"""Weight of the estimate of the error, as for the states."""


@kernel
def _estimate_error(run: Run, sweep: Sweep, r: int) -> float:
    """Error that one step adds to the derivatives of a result by the states, relative to these."""
    n, columns, most = run.plant.states, sweep.columns, 0.0
    for i in range(n):
        place = i * columns + r
        sweep.largest[place] = max(sweep.largest[place], abs(sweep.before[place]))
        sweep.errors[place] += _DOUBT * abs(sweep.before[place + sweep.results])
        most = max(most, sweep.largest[place] * sweep.weight[i])
    if most == 0.0:
        return 0.0
    total, count = 0.0, 0
    for i in range(n):
        if sweep.weight[i] > 0.0:
            size = max(sweep.largest[i * columns + r], LEAST * most / sweep.weight[i])
            part = sweep.before[i * columns + sweep.results + r] / size
            total += part * part
            count += 1
    return _DOUBT * sqrt(total / count)


@kernel
def _integrate(run: Run, course: Course, k: int, h: float) -> None:
    """Integrals over a step and their errors."""
    n, q = course.states, course.integrals
    for i in range(q):
        course.parts[k * q + i] = run.new[n + i]
        if run.is_implicit:
            course.part_errors[k * q + i] = abs(run.stages[8 * (n + q) + n + i])
        else:
            course.part_errors[k * q + i] = integral_error(run.stages, n + q, n + i, h)


@kernel
def _over(run: Run, sweep: Sweep, course: Course, k: int) -> bool:
    """Carry the adjoint back over one step; false if it cannot be made."""
    n, columns, results = run.plant.states, sweep.columns, sweep.results
    h = go_to_step(run, course, k)
    for i in range(n):
        for r in range(results):
            sweep.judged[i * columns + results + r] = sweep.adjoint[i * columns + r]
    if run.is_implicit:
        if not rodas5p_back.back(run, sweep, h):
            return False
    else:
        dop853_back.back(run, sweep, h)
    for r in range(results):
        course.errors[k * results + r] = _estimate_error(run, sweep, r)
    for i in range(n):
        for r in range(results):
            sweep.adjoint[i * columns + r] = sweep.before[i * columns + r]
    _integrate(run, course, k, h)
    return True


@kernel
def sweep_steps(run: Run, sweep: Sweep, course: Course, stops: Stops) -> int:
    """Carry the adjoint back over all steps, and changes between them."""
    begin_stops(stops)
    for k in range(course.steps - 1, -1, -1):
        add_pulses(run, sweep, stops, k + 1)
        if not course.is_step[k]:
            cross(sweep, stops, k)
        elif not _over(run, sweep, course, k):
            return GIVEN_UP
    add_pulses(run, sweep, stops, 0)
    return DONE
