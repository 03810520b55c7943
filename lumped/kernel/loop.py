"""The time loop of a run: from one change of positions to the next."""

from __future__ import annotations

from lumped.code.words import copy_numbers, kernel
from lumped.kernel.instants.holds import position_of
from lumped.kernel.instants.positions import find_positions
from lumped.kernel.interpret import evaluate
from lumped.kernel.observe import observe_clocks
from lumped.kernel.output import begin_piece, has_room, note_change, record_edge
from lumped.kernel.run import (
    BEGIN_SEGMENT,
    CROSS,
    DONE,
    FULL,
    GOES_ON,
    JUMPS,
    LEAVE_SEGMENT,
    MOST_JUMP,
    OPEN_CROSSING,
    OPEN_SEGMENT,
    RESTART,
    SETTLING,
    STEPPING,
    STORM,
    STORM_SIZE,
    STORM_WITHIN,
    UNFIT,
    WAITING,
    Run,
)
from lumped.kernel.steps import advance, begin_steps, is_unfit, take_states


@kernel
def _note_changes(run: Run) -> None:
    """Note the positions that have changed at an instant."""
    plant, instant = run.plant, run.instant
    if run.watches and run.phase == OPEN_SEGMENT and run.segment > 0:
        observe_clocks(run)
    for k in range(plant.conditions):
        setting = plant.condition_setting[k]
        was, now = int(instant.before[setting]), int(instant.m[setting])
        if instant.has_jumped[k]:
            was, now = 0, 1
        if was != now:
            note_change(run, 0, k, was, now, 0.0, 0.0)
    for h in range(plant.holds):
        was, now = position_of(plant, instant.before, h), position_of(plant, instant.m, h)
        if was != now or instant.is_struck[h]:
            note_change(run, 1, h, was, now, instant.loss[h], instant.delay[h])


@kernel
def _settle(run: Run) -> int:
    """Go on with the positions and states just after an instant."""
    run.phase = SETTLING
    status = find_positions(run)
    if status != GOES_ON:
        return status
    run.phase = run.next_phase
    _note_changes(run)
    copy_numbers(run.plant.settings, run.instant.m, run.m)
    take_states(run, run.instant.x)
    return GOES_ON


@kernel
def must_jump(run: Run) -> bool:
    """Whether bodies would have to follow a jump of a prescribed motion."""
    plant, old, new = run.plant, run.followed_before, run.followed_after
    if plant.followers == 0:
        return False
    evaluate(plant.following, run, run.x, run.t, run.instant.before, old)
    evaluate(plant.following, run, run.x, run.t, run.m, new)
    for i in range(plant.followers):
        if abs(new[i] - old[i]) > MOST_JUMP * max(1.0, abs(old[i])):
            return True
    return False


@kernel
def _begin_segment(run: Run) -> int:
    """Set the functions of time for the next segment, at an instant known before."""
    plant, k = run.plant, run.segment
    copy_numbers(plant.settings, run.m, run.instant.before)
    run.t, run.end = run.edges[k], run.edges[k + 1]
    for i in range(run.timed):
        run.m[run.timed_setting[i]] = run.timed_values[k * run.timed + i]
    run.instant.fired_count = 0
    run.next_phase = OPEN_SEGMENT
    if k > 0 and must_jump(run):
        return JUMPS
    return _settle(run)


@kernel
def _cross(run: Run) -> int:
    """Go to the instant at which margins fire."""
    take_states(run, run.inner)
    run.t = run.t_cross
    record_edge(run)
    copy_numbers(run.plant.settings, run.m, run.instant.before)
    run.next_phase = OPEN_CROSSING
    return _settle(run)


@kernel
def _open_crossing(run: Run) -> int:
    """Begin a new piece, unless changes follow each other without end."""
    begin_piece(run)
    k = run.changed_count
    run.changed[k % STORM_SIZE] = run.t
    run.changed_count = k + 1
    run.phase = RESTART
    if k >= STORM_SIZE and run.t - run.changed[(k + 1) % STORM_SIZE] <= STORM_WITHIN * run.span:
        return STORM
    return GOES_ON


@kernel
def _leave_segment(run: Run) -> int:
    k = run.segment
    if run.output.is_on_grid and run.edges[k + 1] > run.edges[k]:
        record_edge(run)
    run.segment = k + 1
    run.phase = BEGIN_SEGMENT
    return DONE if k + 1 == run.segments else GOES_ON


@kernel
def until_steps(run: Run) -> int:
    """Continue a run until steps are due; gives GOES_ON, or why the loop returns."""
    output = run.output
    while run.phase != STEPPING and run.phase != WAITING:
        status = GOES_ON
        if output.pieces >= output.most_pieces or not has_room(output):
            return FULL
        if output.most_changes - output.changes < run.plant.conditions + run.plant.holds:
            return FULL
        if run.phase == BEGIN_SEGMENT:
            status = _begin_segment(run)
        elif run.phase == OPEN_SEGMENT:
            begin_piece(run)
            run.phase = RESTART
            status = UNFIT if is_unfit(run) else GOES_ON
        elif run.phase == CROSS:
            status = _cross(run)
        elif run.phase == SETTLING:
            status = _settle(run)
        elif run.phase == OPEN_CROSSING:
            status = _open_crossing(run)
        elif run.phase == LEAVE_SEGMENT:
            status = _leave_segment(run)
        else:
            status = begin_steps(run)
        if status != GOES_ON:
            return status
    return GOES_ON


@kernel
def loop(run: Run) -> int:
    """Continue a run until it is done or Python must act.

    Returns
    -------
    int
        Why it returns (see `lumped.kernel.run`).
    """
    status = GOES_ON
    while status == GOES_ON:
        status = until_steps(run)
        if status == GOES_ON:
            status = advance(run, False)
    return status
