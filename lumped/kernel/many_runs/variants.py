"""Variants of a run, one after the other, without Python between them."""

from __future__ import annotations

from typing import Annotated

from lumped.code.records import Record
from lumped.code.words import Integers, Numbers, copy_numbers, kernel
from lumped.kernel.clocks import Clocks, place_instants, set_clocks
from lumped.kernel.enclosures.crossing import find_below
from lumped.kernel.instants.holds import position_of
from lumped.kernel.instants.positions import begin
from lumped.kernel.instants.yielding import watch_redundancy
from lumped.kernel.interpret import evaluate, prepare
from lumped.kernel.loop import until_steps
from lumped.kernel.observe import begin_watch, end_watch, observe, observe_event
from lumped.kernel.plant import Function
from lumped.kernel.run import (
    ASKS,
    BEGIN_SEGMENT,
    DONE,
    FULL,
    GOES_ON,
    NEEDS_MATRIX,
    NO_START,
    UNFIT,
    Run,
)
from lumped.kernel.steps import advance, attempt_once, end_attempt, leave_step

_LARGEST = 1e100
"""Size of start values beyond which their powers are not finite."""


class Queue(Record):
    """The variant that is next, and the end of all."""

    next: int
    end: int


class Variants(Record):
    """Variants of a run, and what is taken from each.

    Attributes
    ----------
    clocks : Clocks
        Functions of time whose instants differ between variants.
    queue : Queue
        Which variant is next; lanes that work side by side have the same.
    number, is_begun : int
        The present variant, and whether it is under way.
    why : int
        How it ends, if it does.
    columns, place, values : int, Integers, Numbers
        How many parameters vary, which, and their values in each variant.
    nominal : Numbers
        All parameters.
    start : Function
        Gives states, start values that must hold, and how far the worst is missed, from values of
        start values.
    start_values, found_start, start_count : Numbers, Numbers, int
        These values, room for what `start` gives, and how much that is.
    tolerated : float
        By how much a start value may be missed.
    first_settings : Numbers
        Settings of functions of time at the start.
    begins : int
        Whether positions at the start are found, and bodies may collide.
    starts, start_width : Numbers, int
        Starts that were found before, a row for each variant, and their width (0 without them):
        whether bodies may collide there (-1 where there is no start), states, settings, parameters.
    first_time : float
        Begin of the runs, s.
    width, found : int, Numbers
        What is taken from each run.
    status, steps, rejected : Integers
        How each ended, and its numbers of steps.
    """

    run: Run
    clocks: Clocks
    queue: Queue
    number: int
    is_begun: int
    why: int
    columns: int
    place: Integers
    values: Numbers
    parameters: int
    nominal: Numbers
    start: Function
    start_values: Numbers
    found_start: Numbers
    start_count: int
    tolerated: float
    first_settings: Numbers
    begins: int
    starts: Numbers
    start_width: int
    x_first: Annotated[Numbers, "states"]
    m_first: Annotated[Numbers, "settings"]
    first_time: float
    width: int
    found: Numbers
    status: Integers
    steps: Integers
    rejected: Integers


@kernel
def _place(variants: Variants) -> None:
    """Set the parameters of the variant, and where it begins; all else is as it was at first."""
    run = variants.run
    now, first = run.memory, run.memory_at_first
    for i in range(run.memory_size):
        now[i] = first[i]
    copy_numbers(run.plant.states, run.least_atol, run.atol)
    copy_numbers(variants.parameters, variants.nominal, run.p)
    row = variants.values[variants.number * variants.columns :]
    for i in range(variants.columns):
        run.p[variants.place[i]] = row[i]
    prepare(run)
    run.t = variants.first_time
    copy_numbers(run.plant.states, variants.x_first, run.x)
    copy_numbers(run.plant.settings, variants.m_first, run.m)


@kernel
def _find_states(variants: Variants) -> bool:
    """States from start values; false if they must be searched for."""
    run, n = variants.run, variants.run.plant.states
    found = variants.found_start
    evaluate(variants.start, run, variants.start_values, run.t, run.m, found)
    for i in range(variants.start_count):
        size = abs(found[i])
        if not size <= _LARGEST:
            return False
        if i >= n and i + 1 < variants.start_count and size > 0.0 and size * _LARGEST < 1.0:
            return False
    copy_numbers(n, found, variants.x_first)
    return found[variants.start_count - 1] <= variants.tolerated


@kernel
def note_collisions(run: Run) -> None:
    """What collides at the start is an event."""
    instant = run.instant
    for h in range(run.plant.holds):
        if instant.is_struck[h] and abs(instant.speed_at_begin[h]) > instant.rest_speed[h]:
            observe_event(run, 1, h, position_of(run.plant, instant.m, h), instant.loss[h], 0.0)


@kernel
def _begin_variant(variants: Variants) -> int:
    """States and positions at the start of the variant that is due."""
    run, plant = variants.run, variants.run.plant
    if variants.start_width > 0:
        found = variants.starts[variants.number * variants.start_width :]
        if found[0] < 0.0:
            run.steps = run.rejected = 0
            return NO_START
        variants.begins = int(found[0])
        copy_numbers(plant.states, found[1:], variants.x_first)
        copy_numbers(plant.settings, found[1 + plant.states :], variants.m_first)
        copy_numbers(
            variants.parameters, found[1 + plant.states + plant.settings :], variants.nominal
        )
        _place(variants)
    else:
        copy_numbers(plant.settings, variants.first_settings, variants.m_first)
        _place(variants)
        set_clocks(variants.clocks, run, variants.m_first)
        copy_numbers(plant.settings, variants.m_first, run.m)
        if not _find_states(variants):
            return NO_START
    if variants.begins:
        _place(variants)
        if begin(run) != GOES_ON:
            return NO_START
        copy_numbers(plant.states, run.instant.x, variants.x_first)
        copy_numbers(plant.settings, run.instant.m, variants.m_first)
        begin_watch(run)
        note_collisions(run)
        _place(variants)
    else:
        copy_numbers(plant.states, variants.x_first, run.x)
        begin_watch(run)
    place_instants(variants.clocks, run)
    run.phase, run.segment, run.end = BEGIN_SEGMENT, 0, run.edges[1]
    watch_redundancy(run)
    return GOES_ON


@kernel
def take(run: Run, out: Numbers) -> None:
    """Take what functionals are at the end of a run."""
    watch = run.watch
    end_watch(run)
    copy_numbers(watch.integrands, watch.sums, out)
    n = watch.integrands
    copy_numbers(watch.extremes, watch.best, out[n:])
    n += watch.extremes
    copy_numbers(watch.loads, watch.count.damage, out[n:])
    n += watch.loads
    copy_numbers(watch.points, watch.totals, out[n:])
    n += watch.points
    copy_numbers(watch.finals, watch.last, out[n:])
    n += watch.finals
    for i in range(watch.wanted_events):
        number, count = watch.event_number[i], watch.happened[i]
        if number < 0 and count + number >= 0:
            watch.taken[i] = watch.ring[watch.latest[i] + (count + number) % (0 - number)]
        out[n], out[n + 1] = watch.taken[i], float(count)
        n += 2


@kernel
def _end_variant(variants: Variants, status: int) -> None:
    """Note how the variant ended, and what its functionals are."""
    run, k = variants.run, variants.number
    variants.is_begun = 0
    variants.status[k] = status
    variants.steps[k], variants.rejected[k] = run.steps, run.rejected
    if status == DONE:
        take(run, variants.found[k * variants.width :])


@kernel
def until_steps_of(variants: Variants) -> int:
    """Go on until explicit steps of a variant are due; gives GOES_ON then.

    Gives DONE if no variant is left, or why Python must act (see `lumped.kernel.run`).
    """
    run, queue = variants.run, variants.queue
    while True:
        status = GOES_ON
        if not variants.is_begun:
            if queue.next >= queue.end:
                return DONE
            variants.number = queue.next
            queue.next += 1
            status = _begin_variant(variants)
            variants.is_begun = 1
        if status == GOES_ON:
            status = until_steps(run)
            if status == GOES_ON:
                if not (run.is_implicit or run.shares):
                    return GOES_ON
                status = advance(run, True)
                if status == GOES_ON:
                    continue
        if status == FULL or status == NEEDS_MATRIX or status == UNFIT or status == ASKS:
            return status
        _end_variant(variants, status)


@kernel
def after_attempt(variants: Variants, status: int) -> int:
    """Go on after an attempt that gave a status; as `until_steps_of`."""
    if status == FULL or status == NEEDS_MATRIX or status == UNFIT or status == ASKS:
        return status
    if status != GOES_ON:
        _end_variant(variants, status)
    return until_steps_of(variants)


@kernel
def variants(variants: Variants) -> int:
    """Run variants until all are done or Python must act (see `lumped.kernel.run`)."""
    status = until_steps_of(variants)
    while status == GOES_ON:
        status = after_attempt(variants, advance(variants.run, False))
    return status


@kernel
def attempt_of(variants: Variants) -> int:
    """Make one attempt of a variant, and go on until its next step; as `until_steps_of`."""
    return after_attempt(variants, attempt_once(variants.run))


@kernel
def crossing_of(variants: Variants) -> int:
    """End a step in which margins may fire, and go on; as `until_steps_of`."""
    run = variants.run
    run.is_crossed = find_below(run)
    return after_attempt(variants, end_attempt(run, leave_step(run)))


@kernel
def look_of(variants: Variants) -> int:
    """Take what functionals need from the present step."""
    observe(variants.run, variants.run.t_new)
    return GOES_ON


@kernel
def end_of(variants: Variants) -> int:
    """End a variant in the way that is noted, and go on; as `until_steps_of`."""
    return after_attempt(variants, variants.why)
