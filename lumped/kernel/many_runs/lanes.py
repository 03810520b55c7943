"""Explicit steps of several runs side by side in the registers of the processor.

Each lane has its own time and step, and takes the next variant when its own is done. All formulas
are those of a single run, with the same rounding, so each variant gives the bits of its single run.
What is rare is done by a run alone: starts, changes of position, the search for an instant or an
extreme, trials of implicit steps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeAlias

from lumped.code.words import (
    Wide,
    Wides,
    any_lane,
    call_wide,
    enter,
    flat,
    kernel,
    record_at,
)
from lumped.kernel.choice import NEAR_LIMIT, STIFF_AFTER, UNTRIED
from lumped.kernel.enclosures.extremes import rises
from lumped.kernel.enclosures.forcing import is_clear
from lumped.kernel.instants.linkages import follow
from lumped.kernel.interpret import evaluate
from lumped.kernel.many_runs.lane_records import IDLE, STEPPING, WAITING, LaneWatch
from lumped.kernel.many_runs.lane_transfer import hand_over, load, load_sums, unload_step
from lumped.kernel.many_runs.variants import Variants
from lumped.kernel.methods.any_method import (
    LONGER,
    NODES,
    attempt_explicit,
    explicit_dense_error,
    inside,
    inside_explicit,
    integrals,
    prepare_step,
    set_ranges,
    set_rough_ranges,
)
from lumped.kernel.methods.rates import end_step, find_rates
from lumped.kernel.observe import has_border
from lumped.kernel.plant import Function
from lumped.kernel.run import (
    DONE,
    FULL,
    GIVEN_UP,
    GOES_ON,
    LEAVE_SEGMENT,
    TOO_MANY,
    UNFIT,
    Run,
)
from lumped.kernel.step_error import HOPELESS, SAFETY, UNCLOSED, is_finite
from lumped.kernel.steps import LEAST, SHORTEST, explicit_growth
from lumped.kernel.watch import Watch

if TYPE_CHECKING:
    Lanes: TypeAlias = Any  # formulas of a `Run` take it too
else:
    from lumped.kernel.many_runs.lane_records import Lanes


@kernel
def evaluate_wide(
    function: Function, lanes: Lanes, x: Wides, t: Wide, m: Wides, out: Wides
) -> None:
    """Write the results of a function at a point of each lane."""
    call_wide(function.wide_address, x, lanes.p, t, m, out)


@kernel
def find_rates_wide(lanes: Lanes, x: Wides, t: Wide, out: Wides) -> None:
    """Write the rates of the states at a point of each lane, none of which shares a load."""
    evaluate_wide(lanes.plant.rates, lanes, x, t, lanes.m, out)


@kernel
def end_step_wide(lanes: Lanes) -> None:
    """Write the rates at the end of the step of each lane; lanes have no invariants."""
    find_rates_wide(lanes, lanes.new, lanes.t_new, lanes.stages[12 * lanes.plant.states :])


@kernel
def _fill(lanes: Lanes) -> int:
    """Let runs go on alone that wait for it.

    Gives GOES_ON if lanes make steps, DONE if no variant is left, or why Python must act.
    """
    found = DONE
    for k in range(lanes.count):
        if lanes.state[k] == WAITING:
            by = lanes.entry[k]
            lanes.entry[k] = lanes.until_steps_of
            status = enter(by, record_at(Variants, lanes.slot[k]))
            if status == GOES_ON:
                load(lanes, k)
            elif status == DONE:
                lanes.state[k] = IDLE
            else:
                lanes.waiting = k
                return status
        if lanes.state[k] == STEPPING:
            found = GOES_ON
    return found


# -- one attempt of all lanes ------------------------------------------------------------------


@kernel
def _hand_over_marked(lanes: Lanes) -> bool:
    """Let runs of marked lanes make an attempt alone; whether there are any."""
    if not any_lane(lanes.mark > 0.5):
        return False
    for k in range(lanes.count):
        if flat(lanes.mark)[k] > 0.5:
            hand_over(lanes, k, lanes.attempt_of)
    return True


@kernel
def _try_implicit(lanes: Lanes, h: Wide) -> bool:
    """Let runs go on alone for which a trial of an implicit step is due; whether there are any."""
    is_over = lanes.patience == 0.0 or h > lanes.long_enough
    is_due = lanes.untried_steps >= UNTRIED or (lanes.stiff_steps >= STIFF_AFTER and is_over)
    is_due = is_due and lanes.is_on > 0.5 and lanes.end - lanes.t > LONGER * h
    lanes.mark = 1.0 if is_due else 0.0
    return _hand_over_marked(lanes)


@kernel
def _leave_unseen(lanes: Lanes, h: Wide) -> bool:
    """Let runs go on alone whose steps may miss what acts by the time; whether there are any."""
    clear = is_clear(lanes, h, NODES[0], NODES[1])
    lanes.mark = 1.0 if clear < 0.5 and lanes.is_on > 0.5 else 0.0
    return _hand_over_marked(lanes)


@kernel
def _without_suspects(lanes: Lanes, accepted: Wide) -> Wide:
    """Accepted lanes but for those in which a margin fires or may fire, whose runs go on alone."""
    mark, floor = accepted * 0.0, lanes.floor
    set_ranges(lanes)
    evaluate_wide(lanes.plant.margin_floor, lanes, lanes.ranges, lanes.t, lanes.m, floor)
    for i in range(lanes.plant.margins):
        mark = mark if floor[i] >= 0.0 else 1.0
    mark = mark if accepted > 0.5 else 0.0
    lanes.mark = mark
    for k in range(lanes.count if any_lane(mark > 0.5) else 0):
        if flat(lanes.mark)[k] > 0.5:
            variants = unload_step(lanes, k)
            for i in range(lanes.plant.margins):
                variants.run.floor[i] = flat(lanes.floor)[i * lanes.count + k]
            lanes.entry[k] = lanes.crossing_of
    return accepted if mark < 0.5 else 0.0


@kernel
def _look_alone(lanes: Lanes) -> None:
    """Let runs take themselves what functionals need from the step."""
    for k in range(lanes.count):
        if flat(lanes.look_mark)[k] > 0.5:
            variants = unload_step(lanes, k)
            enter(lanes.look_of, variants)
            load_sums(lanes, variants.run, k)
            flat(lanes.is_on)[k] = 1.0
            lanes.state[k] = STEPPING


@kernel
def _observe(lanes: Lanes, is_on: Wide) -> None:
    """Take what functionals need from the step."""
    watch = lanes.watch
    lanes.look_mark = 1.0 if is_on > 0.5 and lanes.next_look < lanes.t_new else 0.0
    if watch.loads > 0:
        lanes.look_mark = 1.0 if is_on > 0.5 else 0.0
    if watch.extremes > 0:
        is_open = is_on * lanes.may_rise
        if any_lane(is_open > 0.5):
            if lanes.plant.margins == 0 and not lanes.by_series:
                set_ranges(lanes)
            is_open = is_open * rises(lanes)
            lanes.look_mark = 1.0 if is_open > 0.5 else lanes.look_mark
    if watch.integrands > 0:
        lanes.look_mark = 1.0 if is_on > 0.5 and lanes.is_rough > 0.5 else lanes.look_mark
    alone = lanes.look_mark
    for k in range(watch.integrands):
        is_whole = lanes.t >= watch.begin[k] and lanes.t_new <= watch.end[k]
        is_own = is_on > 0.5 and alone < 0.5
        watch.sums[k] = watch.sums[k] + watch.parts[k] if is_own and is_whole else watch.sums[k]
    if any_lane(alone > 0.5):
        _look_alone(lanes)


@kernel
def _exchange_implicit(lanes: Lanes, accepted: Wide) -> None:
    """Exchange implicit quantities at the begin of accepted steps with those at their end."""
    first = lanes.plant.settings - lanes.plant.implicit
    for i in range(lanes.plant.implicit):
        before, after = lanes.m[first + i], lanes.found[i]
        lanes.m[first + i] = after if accepted > 0.5 else before
        lanes.found[i] = before


@kernel
def _move_on(lanes: Lanes, accepted: Wide) -> None:
    """The end of accepted steps becomes the begin of the next."""
    n, x, k = lanes.plant.states, lanes.x, lanes.stages
    is_accepted = accepted > 0.5
    for i in range(n):
        x[i] = lanes.new[i] if is_accepted else x[i]
        k[i] = k[12 * n + i] if is_accepted else k[i]
    lanes.t = lanes.t_new if is_accepted else lanes.t


@kernel
def _end_unfit(lanes: Lanes, accepted: Wide) -> None:
    """End runs in which a dependent motion is much faster than the state that leads it."""
    ratio, mark = lanes.ratio, accepted * 0.0
    evaluate_wide(lanes.plant.leverage, lanes, lanes.x, lanes.t, lanes.m, ratio)
    for i in range(lanes.plant.levers):
        mark = mark if abs(ratio[i]) <= 1.0 else 1.0
    lanes.mark = mark * accepted
    if any_lane(lanes.mark > 0.5):
        for k in range(lanes.count):
            if flat(lanes.mark)[k] > 0.5:
                variants = hand_over(lanes, k, lanes.end_of)
                variants.why = UNFIT


@kernel
def _leave(lanes: Lanes) -> None:
    """Let runs go on alone that are at the end of a segment, or given up."""
    is_short = lanes.h < SHORTEST * max(abs(lanes.t), 1e-6) and lanes.was_rejected > 0.5
    are_many = lanes.steps + lanes.rejected > lanes.max_steps
    mark = 1.0 if lanes.t >= lanes.end else 0.0
    mark = 2.0 if are_many else mark
    lanes.mark = 3.0 if is_short else mark
    if not any_lane(lanes.mark * lanes.is_on > 0.5):
        return
    for k in range(lanes.count):
        if lanes.state[k] == STEPPING:
            found = flat(lanes.mark)[k]
            if found > 1.5:
                variants = hand_over(lanes, k, lanes.end_of)
                variants.why = GIVEN_UP if found > 2.5 else TOO_MANY
            elif found > 0.5:
                variants = hand_over(lanes, k, lanes.until_steps_of)
                variants.run.phase = LEAVE_SEGMENT


@kernel
def _note_rises(lanes: Lanes, is_good: Wide) -> None:
    """Note in which of some lanes an extreme may rise in the step."""
    lanes.may_rise = is_good
    if lanes.plant.margins == 0:
        set_rough_ranges(lanes)
        lanes.may_rise = rises(lanes) * is_good


@kernel
def _note_rough(lanes: Lanes, is_good: Wide) -> None:
    """Note in which of some lanes integrals over the step need values inside it."""
    watch, t, t_new = lanes.watch, lanes.t, lanes.t_new
    rough = 1.0 if integrals(lanes, t_new - t) > 1.0 else 0.0
    for k in range(watch.integrands):
        rough = 1.0 if has_border(watch.begin[k], watch.end[k], t, t_new) else rough
    lanes.is_rough = rough * is_good


@kernel
def _error(lanes: Lanes, h: Wide) -> Wide:
    """Error of a step, relative to the tolerance; notes where values inside it are known."""
    error = attempt_explicit(lanes, h)
    error = error if error < HOPELESS else HOPELESS
    if lanes.plant.implicit > 0:
        error = error if follow(lanes, lanes.new, lanes.t_new, lanes.m) else UNCLOSED
    is_dense = error <= 1.0 and is_finite(lanes) and lanes.is_on > 0.5
    is_good = 1.0 if is_dense else lanes.t * 0.0
    if lanes.watch.extremes > 0:
        _note_rises(lanes, is_good)
    if lanes.watch.integrands > 0:
        _note_rough(lanes, is_good)
    if not lanes.looks_inside:
        is_wanted = lanes.may_rise > 0.5 or lanes.is_rough > 0.5
        is_dense = is_dense and (is_wanted or lanes.next_look < lanes.t_new)
    lanes.mark = 1.0 if is_dense else 0.0
    if any_lane(is_dense):
        dense = explicit_dense_error(lanes, h)
        error = max(error, dense) if is_dense else error
    return error


@kernel
def _note_attempt(lanes: Lanes, h: Wide, error: Wide) -> Wide:
    """Next steps, and what was accepted: 1 or 0."""
    growth = explicit_growth(lanes, error, lanes.mark > 0.5)
    is_accepted = error <= 1.0 and is_finite(lanes)
    accepted = 1.0 if is_accepted and lanes.is_on > 0.5 else lanes.t * 0.0
    lanes.h = h * growth if is_accepted else h * min(growth, SAFETY)
    lanes.was_rejected = 0.0 if is_accepted else 1.0
    lanes.steps = lanes.steps + accepted
    lanes.rejected = lanes.rejected + (1.0 - accepted)
    stiff = lanes.stiff_steps + 1.0 if lanes.stiffness > NEAR_LIMIT else 0.0
    lanes.stiff_steps = stiff if is_accepted else lanes.stiff_steps
    lanes.patience = max(0.0, lanes.patience - 1.0) if is_accepted else lanes.patience
    lanes.untried_steps = lanes.untried_steps + accepted
    return accepted


@kernel
def _expand(lanes: Lanes) -> bool:
    """Coefficients of the states about the begins of the steps; sets their lengths.

    Lets runs go on alone for which there are none; whether there are any.
    """
    found = prepare_step(lanes)
    lanes.h = found if lanes.was_rejected < 0.5 and found > 0.0 else lanes.h
    lanes.mark = 0.0 if found > 0.0 or lanes.is_on < 0.5 else 1.0
    return _hand_over_marked(lanes)


@kernel
def _attempt(lanes: Lanes) -> None:
    """One attempt of all lanes."""
    t, end = lanes.t, lanes.end
    if lanes.by_series and _expand(lanes):
        return
    h = min(max(min(lanes.h, lanes.longest), LEAST * abs(t)), end - t)
    if lanes.plant.forcings > 0 and _leave_unseen(lanes, h):
        return
    if lanes.chooses_method and _try_implicit(lanes, h):
        return
    lanes.t_new = end if h >= end - t else t + h
    h = lanes.t_new - t
    accepted = _note_attempt(lanes, h, _error(lanes, h))
    if any_lane(accepted > 0.5):
        _exchange_implicit(lanes, accepted)
        if lanes.plant.margins > 0:
            accepted = _without_suspects(lanes, accepted)
        _observe(lanes, accepted)
        _move_on(lanes, accepted)
        if lanes.plant.levers > 0:
            _end_unfit(lanes, accepted)
    _leave(lanes)


@kernel
def lanes(lanes: Lanes) -> int:
    """Run variants in lanes until all are done or Python must act (see `lumped.kernel.run`)."""
    while not lanes.is_stopped:
        status = _fill(lanes)
        if status != GOES_ON:
            return status
        _attempt(lanes)
    return FULL


ENTRIES: dict[str, Any] = {"lanes": lanes}
"""Kernels that Python calls."""

COUNTERPARTS: dict[Any, Any] = {
    Run: Lanes,
    Watch: LaneWatch,
    evaluate: evaluate_wide,
    find_rates: find_rates_wide,
    end_step: end_step_wide,
    inside: inside_explicit.widened,  # type: ignore[attr-defined]
}
"""What stands for records and kernels of a single run."""
