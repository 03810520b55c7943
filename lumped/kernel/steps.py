"""One step after the other: error control, watched margins, output."""

from __future__ import annotations

import math

from lumped.code.words import Numbers, copy_numbers, kernel, sqrt
from lumped.kernel.choice import (
    FIRST_PATIENCE,
    choose_method,
    is_trial_due,
    note_softness,
    note_stiffness,
)
from lumped.kernel.enclosures.crossing import find_crossing
from lumped.kernel.enclosures.forcing import limit_by_forcing
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.any_method import dense_error, prepare
from lumped.kernel.methods.rates import find_rates, note_sharing
from lumped.kernel.observe import observe
from lumped.kernel.output import has_room, record
from lumped.kernel.run import (
    CROSS,
    FULL,
    GIVEN_UP,
    GOES_ON,
    LEAVE_SEGMENT,
    NEEDS_MATRIX,
    NOT_FINITE,
    STEPPING,
    TOO_MANY,
    UNFIT,
    WAITING,
    Run,
)
from lumped.kernel.step_error import SAFETY, is_dense_wanted, is_finite, try_step

_DENSE_LIMIT = 5.5
"""Step times eigenvalue from which on the interpolation of DOP853 is unstable."""
_BEGIN, _SHORTER = 1e-3, 0.1
"""Part of an implicit step in which what falls is looked at again by a shorter step, and how much
shorter: its polynomial does not begin with the rates, as that of an explicit one does."""
_EXPLICIT_SAFETY, _LEAST_GROWTH, _MOST_GROWTH = 0.8, 0.2, 8.0
"""Part of an explicit step that the tolerance allows; with 0.9 a fifth of them is rejected."""
_IMPLICIT_POWER = 0.2
LEAST = 2.5e-16
"""Step, relative to the time, that the time can tell."""
SHORTEST = 1e-14
"""Step, relative to the time, below which a run is given up."""


@kernel
def is_unfit(run: Run) -> bool:
    """Whether a dependent motion is much faster than the state that leads it (dead centre)."""
    count = run.plant.levers
    if count == 0:
        return False
    evaluate(run.plant.leverage, run, run.x, run.t, run.m, run.ratio)
    for i in range(count):
        if not abs(run.ratio[i]) <= 1.0 + run.lenience:
            return True
    return False


@kernel
def _norm(run: Run, v: Numbers, less: Numbers) -> float:
    """Root mean square of a difference, relative to the tolerance."""
    total, n = 0.0, run.plant.states
    for i in range(n):
        part = (v[i] - less[i]) / (run.atol[i] + run.rtol * abs(run.x[i]))
        total += part * part
    return sqrt(total / n)


@kernel
def begin_steps(run: Run) -> int:
    """Begin a smooth part, unless it has no length."""
    if run.t >= run.end:
        run.phase = LEAVE_SEGMENT
    elif not _begin(run):
        return NOT_FINITE
    else:
        run.phase = STEPPING
    return GOES_ON


@kernel
def _begin(run: Run) -> bool:
    """Derivatives and first step of a smooth part; false if they are not finite.

    The step is that of Hairer, Norsett and Wanner, vol. I, II.4.
    """
    n, t, length = run.plant.states, run.t, run.end - run.t
    x, f, a, later = run.x, run.stages, run.argument, run.new
    run.enclosed_margins.is_surveyed = run.enclosed_rates.is_surveyed = 0
    if run.watches:
        run.watch.enclosed_extremes.is_surveyed = run.watch.enclosed_loads.is_surveyed = 0
        run.watch.loads_at = -math.inf
    run.was_rejected = run.stiff_steps = 0
    if run.next_patience == 0:
        run.next_patience = FIRST_PATIENCE
    note_sharing(run)
    find_rates(run, x, t, f)
    run.evaluations += 1
    if n == 0:
        run.h = length
        return True
    for i in range(n):
        if not abs(f[i]) < math.inf:
            return False
        later[i] = 0.0
    d0, d1 = _norm(run, x, later), _norm(run, f, later)
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    h0 = min(h0, length)
    for i in range(n):
        a[i] = x[i] + h0 * f[i]
    find_rates(run, a, t + h0, later)
    run.evaluations += 1
    steepest = max(d1, _norm(run, later, f) / h0)
    h1 = max(1e-6, h0 * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** 0.125
    first = min(min(100.0 * h0, h1), length)
    run.h = first if first > 0.0 and first < math.inf else 1e-6 * length
    return True


@kernel
def take_states(run: Run, x: Numbers) -> None:
    """Go on with other states; the largest sizes that they had count."""
    for i in range(run.plant.states):
        run.x[i] = x[i]
        run.largest[i] = max(run.largest[i], abs(x[i]))


@kernel
def _bound_growth(run: Run, growth: float) -> float:
    most = 1.0 if run.was_rejected else _MOST_GROWTH
    return min(max(growth, _LEAST_GROWTH), most)


@kernel
def explicit_growth(run: Run, error: float, is_dense: bool) -> float:
    """The same for a step of order eight."""
    growth = _bound_growth(run, _EXPLICIT_SAFETY / sqrt(sqrt(sqrt(max(error, 1e-12)))))
    # beyond the limit of stability the interpolation fails first, and the step is repeated
    stable = min(growth, max(1.0, _DENSE_LIMIT / max(run.stiffness, 1e-300)))
    return stable if is_dense else growth


@kernel
def _growth(run: Run, error: float, is_dense: bool) -> float:
    """Length of the next step over that of this one."""
    if run.is_implicit:
        return _bound_growth(run, SAFETY * max(error, 1e-12) ** -_IMPLICIT_POWER)
    return explicit_growth(run, error, is_dense)


@kernel
def _exchange_implicit(run: Run) -> None:
    """Exchange implicit quantities at the begin of the step with those at its end."""
    for i in range(run.plant.implicit):
        place = run.plant.settings - run.plant.implicit + i
        before = run.m[place]
        run.m[place] = run.found[i]
        run.found[i] = before


@kernel
def _attempt(run: Run) -> int:
    """One attempt of a step; gives GOES_ON, or why the loop must return."""
    plant, t, end = run.plant, run.t, run.end
    prepare(run)
    h = min(max(min(run.h, run.longest), LEAST * abs(t)), end - t)
    if plant.forcings > 0:
        h = limit_by_forcing(run, h)
    if is_trial_due(run, h):
        if not run.has_matrix:
            return NEEDS_MATRIX
        h = choose_method(run, h)
    run.t_new = end if h >= end - t else t + h
    h = run.t_new - t  # as it can be made again
    error = try_step(run, h)
    is_dense = error <= 1.0 and is_finite(run) and is_dense_wanted(run)
    if is_dense:
        error = max(error, dense_error(run, h))
    growth = _growth(run, error, is_dense)
    if not (error <= 1.0 and is_finite(run)):
        run.rejected += 1
        run.was_rejected = 1
        run.h = h * min(growth, SAFETY)
        return GIVEN_UP if run.h < SHORTEST * max(abs(t), 1e-6) else GOES_ON
    _exchange_implicit(run)
    run.is_crossed = plant.margins > 0 and find_crossing(run)
    if run.is_implicit and run.is_crossed and t < run.t_cross and run.t_cross - t < _BEGIN * h:
        run.rejected += 1
        run.was_rejected = 1
        run.h = _SHORTER * h
        _exchange_implicit(run)
        return GOES_ON
    run.h = h * growth
    run.was_rejected = 0
    run.steps += 1
    if run.chooses_method:
        if run.is_implicit:
            note_softness(run)
        else:
            note_stiffness(run)
    return leave_step(run)


@kernel
def leave_step(run: Run) -> int:
    """Record the wanted points of an accepted step and move on; why the loop returns."""
    output = run.output
    if run.watches and run.phase != WAITING:
        observe(run, run.t_cross if run.is_crossed else run.t_new)
    record(run, run.t_cross if run.is_crossed else run.t_new, run.is_crossed != 0)
    run.phase = STEPPING
    if run.waits and output.grid_next >= output.grid_size:
        run.phase = WAITING
        return FULL
    if run.is_crossed:
        run.phase = CROSS
        return GOES_ON
    # the end of the step becomes the begin of the next
    n = run.plant.states
    take_states(run, run.new)
    copy_numbers(n, run.stages[12 * n :], run.stages)
    run.t = run.t_new
    return UNFIT if is_unfit(run) else GOES_ON


@kernel
def end_attempt(run: Run, status: int) -> int:
    """Where a run goes on after an attempt that gave a status; why the loop returns."""
    if status != GOES_ON:
        return status
    if run.steps + run.rejected > run.max_steps:
        return TOO_MANY
    if run.phase == STEPPING and run.t >= run.end:
        run.phase = LEAVE_SEGMENT
    return GOES_ON


@kernel
def attempt_once(run: Run) -> int:
    """One attempt, and where the run goes on after it; why the loop returns."""
    if not has_room(run.output) or run.steps + run.rejected >= run.pause:
        return FULL
    return end_attempt(run, leave_step(run) if run.phase == WAITING else _attempt(run))


@kernel
def advance(run: Run, only_alone: bool) -> int:
    """Steps up to the end of the segment or a change of positions; why the loop returns.

    Lanes do not make implicit steps, nor those of shared loads: these may be wanted only.
    """
    while run.phase == STEPPING or run.phase == WAITING:
        if only_alone and not (run.is_implicit or run.shares):
            return GOES_ON
        status = attempt_once(run)
        if status != GOES_ON:
            return status
    return GOES_ON
