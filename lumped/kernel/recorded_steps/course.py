"""Recorded steps of a run: made again, looked into, and differentiated backwards.

Derivatives are those of the steps as they were made, their lengths held (the discrete adjoint;
Hairer, Norsett, Wanner, vol. I, II.6). Each result has two columns: its derivatives by the states,
and by the estimate of the error of one step. The second shows how well steps that were chosen for
the states serve the derivatives.
"""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers, call, copy_numbers, kernel
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods import dop853, rodas5p
from lumped.kernel.methods.any_method import inside
from lumped.kernel.plant import Function
from lumped.kernel.run import DONE, GIVEN_UP, Run

LOOKS = 8
"""Points of each step that are looked at, the last of them its end."""


class Course(Record):
    """Recorded steps one after the other.

    Attributes
    ----------
    steps, states, settings, integrals : int
        How many; states without integrals.
    t, x, m : Numbers
        Times of all ends, s; states and settings there.
    is_given : Integers
        Whether the states are known at each.
    is_step : Integers
        Whether there is a step from each to the next; else the run changes there.
    is_implicit : Integers
        Whether the step from each to the next is one of the implicit method.
    width, found : int, Numbers
        Results of a function, and these at `LOOKS` points of each step.
    errors : Numbers
        Error of each result by each step, relative to its derivatives by the states then.
    parts, part_errors : Numbers
        Integrals over each step, and their errors.
    """

    steps: int
    states: int
    settings: int
    integrals: int
    t: Numbers
    x: Numbers
    m: Numbers
    is_given: Integers
    is_step: Integers
    is_implicit: Integers
    width: int
    found: Numbers
    errors: Numbers
    parts: Numbers
    part_errors: Numbers


class Sweep(Record):
    """Derivatives of results by the states and parameters, carried back from step to step.

    Numbers with columns come one state after the other; those by parameters have no second columns.

    Attributes
    ----------
    results, columns, parameters : int
        How many results; twice as many; parameters.
    pullback : Function
        States, then weights of the rates: their sum, differentiated by states, then by parameters.
    bent : Function
        States, increments, a part of time, then weights: the weighted derivative of the rates
        along both, differentiated by states and parameters.
    adjoint, judged : Numbers
        Derivatives by the states, zero in the second columns; the same in these.
    by_parameters : Numbers
        Derivatives by the parameters so far.
    weight : Numbers
        Nominal values of the states; zero for integrals.
    largest, errors : Numbers
        Largest size of the adjoint so far, and the sizes of the errors of all steps, together.
    """

    results: int
    columns: int
    parameters: int
    pullback: Function
    bent: Function
    adjoint: Annotated[Numbers, "states * columns"]
    judged: Annotated[Numbers, "states * columns"]
    by_parameters: Annotated[Numbers, "parameters * results"]
    weight: Annotated[Numbers, "states"]
    largest: Annotated[Numbers, "states * columns"]
    errors: Annotated[Numbers, "states * columns"]
    point: Annotated[Numbers, "2 * states + 1 + states * columns"]
    pulled: Annotated[Numbers, "12 * (states * columns + parameters * results)"]
    increments: Annotated[Numbers, "8 * states * columns"]
    carried: Annotated[Numbers, "states * columns"]
    before: Annotated[Numbers, "states * columns"]
    solved: Annotated[Numbers, "states * columns"]
    one: Annotated[Numbers, "3 * states + 1"]
    one_pulled: Annotated[Numbers, "states + parameters"]


@kernel
def go_to_step(run: Run, course: Course, k: int) -> float:
    """Go to the begin of a step; gives its length."""
    n = course.states
    for i in range(run.plant.states):
        run.x[i] = course.x[n * k + i] if i < n else 0.0
    copy_numbers(course.settings, course.m[course.settings * k :], run.m)
    run.t = course.t[k]
    run.t_new = course.t[k + 1]
    run.is_implicit = course.is_implicit[k]
    return run.t_new - run.t


@kernel
def _step(run: Run, h: float) -> bool:
    """Make a step again; false if the equations of an implicit one could not be solved."""
    evaluate(run.plant.rates, run, run.x, run.t, run.m, run.stages)
    if run.is_implicit:
        return rodas5p.step(run, h) != rodas5p.UNSOLVED
    dop853.stages(run, h)
    return True


@kernel
def replay_steps(run: Run, course: Course) -> int:
    """Find the states at the ends of steps where they are not known.

    This entry and the others give GIVEN_UP where an implicit step has no solution.
    """
    n = course.states
    for k in range(course.steps):
        if not course.is_given[k + 1]:
            if not _step(run, go_to_step(run, course, k)):
                return GIVEN_UP
            copy_numbers(n, run.new, course.x[n * (k + 1) :])
    return DONE


@kernel
def interpolate_step(run: Run, course: Course, k: int) -> bool:
    """Make a step again with its interpolation; false if an implicit one has no solution."""
    h = go_to_step(run, course, k)
    if not _step(run, h):
        return False
    if run.is_implicit:
        rodas5p.dense_output(run)
    else:
        dop853.dense_output(run, h)
    return True


@kernel
def evaluate_inside(run: Run, function: Function, course: Course) -> int:
    """Evaluate a function inside all steps; where there is none, nothing is written."""
    width = course.width
    for k in range(course.steps):
        if course.is_step[k]:
            if not interpolate_step(run, course, k):
                return GIVEN_UP
            h = run.t_new - run.t
            for j in range(1, LOOKS):
                part = float(j) / LOOKS
                inside(run, part, run.inner)
                found = course.found[(LOOKS * k + j - 1) * width :]
                evaluate(function, run, run.inner, run.t + part * h, run.m, found)
            found = course.found[(LOOKS * k + LOOKS - 1) * width :]
            evaluate(function, run, run.new, run.t_new, run.m, found)
    return DONE


@kernel
def of_columns(
    function: Function, run: Run, sweep: Sweep, point: Numbers, first: int, t: float, out: Numbers
) -> None:
    """Write the results of a function with columns; those of its arguments begin at `first`."""
    n, columns = run.plant.states, sweep.columns
    if function.wide_address != 0:
        call(function.wide_address, point, run.p, t, run.m, out)
        return
    for c in range(columns):
        copy_numbers(first, point, sweep.one)
        for i in range(n):
            sweep.one[first + i] = point[first + i * columns + c]
        evaluate(function, run, sweep.one, t, run.m, sweep.one_pulled)
        for i in range(n):
            out[i * columns + c] = sweep.one_pulled[i]
        if c < sweep.results:
            for i in range(sweep.parameters):
                out[n * columns + i * sweep.results + c] = sweep.one_pulled[n + i]
