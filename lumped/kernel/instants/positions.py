"""The search for positions of conditions and holds that fit at one instant.

The position of a condition is true or false, or a piece of a table; that of a hold is stuck,
forward, backward or free.
"""

from __future__ import annotations

from lumped.code.words import copy_numbers, kernel
from lumped.flattening.hold_modes import BACKWARD, COMPLIANCE, FORWARD, PARTED, STUCK
from lumped.kernel.instant_search import InstantSearch, Look
from lumped.kernel.instants.conditions import (
    begin_jumps,
    jump,
    must_ask,
    set_by_sides,
    turn,
    turn_wrong,
)
from lumped.kernel.instants.holds import (
    STANDSTILL,
    TOUCHING,
    is_at_rest,
    is_held,
    is_opposed,
    look_at,
    position_of,
    release_demands,
    set_position,
    standstills,
    stop,
)
from lumped.kernel.instants.impacts import HAS_COLLIDED, NO_ANSWER, collide, halt
from lumped.kernel.instants.linkages import close, close_first
from lumped.kernel.instants.reactions import (
    CHANGES,
    FITS,
    UNSOLVED,
    calmness,
    let_go,
    settle_reactions,
)
from lumped.kernel.instants.sharing import share
from lumped.kernel.instants.yielding import watch_redundancy, would_share
from lumped.kernel.plant import CONDITION, FREE, SLIDE, UPPER, Plant
from lumped.kernel.rounds import begin_rounds
from lumped.kernel.run import ASKS, GOES_ON, INSIDE, NO_FIT, NOT_CLOSED, SET_TWICE, Run

_DEEPEST = 1e-9
"""How deep bodies may start inside each other, m or rad: rounding of start values."""
_INFINITE = float("inf")
KEEPS = -2
"""The position of a hold fits."""


@kernel
def _first_position(plant: Plant, instant: InstantSearch, seen: Look, h: int) -> int:
    """Position of a hold that begins to act, from its speed and gap alone."""
    v, least = seen.speed[h], instant.rest_speed[h]
    is_still = abs(v) <= least
    if is_opposed(plant, instant.m, h):
        return FORWARD
    if plant.has_gap[h]:
        return STUCK if is_still and seen.gap[h] <= TOUCHING and v <= least else FORWARD
    if not is_still and v > 0.0 and plant.has_forward[h]:
        return FORWARD
    if not is_still and v < 0.0 and plant.has_backward[h]:
        return BACKWARD
    return STUCK


@kernel
def _engage(run: Run, seen: Look) -> bool:
    """Engage and release holds as their conditions say; whether any changed."""
    plant, instant = run.plant, run.instant
    any_changes = False
    for h in range(plant.holds):
        condition = plant.engaged_by[h]
        is_engaged = condition < 0 or instant.m[condition] > 0.5
        if is_engaged == (position_of(plant, instant.m, h) != FREE):
            continue
        if not any_changes:
            standstills(plant, instant)
        any_changes = True
        if is_engaged:
            set_position(plant, instant.m, h, _first_position(plant, instant, seen, h))
        else:
            set_position(plant, instant.m, h, FREE)
            instant.is_halted[h] = instant.is_settled[h] = 0
    return any_changes


@kernel
def _is_held_by_others(run: Run, seen: Look, h: int, calm: float) -> bool:
    """Whether others keep a sliding hold at rest, so that it sticks with its limit at rest."""
    if not run.may_be_redundant or run.instant.was_let_go[h]:
        return False
    touches = not run.plant.has_gap[h] or seen.gap[h] <= TOUCHING
    slowest = max(STANDSTILL, run.instant.rest_speed[h])
    is_calm = abs(seen.speed[h]) <= slowest and abs(seen.acceleration[h]) <= calm
    if not (touches and is_calm and seen.upper[h] > seen.lower[h]):
        return False
    return would_share(run, h)


@kernel
def _has_leapt(run: Run, seen: Look, h: int) -> bool:
    """Whether the limit of friction beside springs has jumped away from its reaction."""
    before = run.instant.speed_before[h]
    least = STANDSTILL * (1.0 + abs(before))
    return run.plant.may_leap[h] != 0 and seen.speed[h] - before > least


@kernel
def _position_by_speed(run: Run, seen: Look, h: int, calm: float) -> int:
    """The position that follows from speeds, whatever the reactions; KEEPS if none does."""
    plant, instant = run.plant, run.instant
    if is_opposed(plant, instant.m, h):
        return KEEPS
    own, v = instant.m[plant.hold_setting[h] :], seen.speed[h]
    is_stuck, forward, backward = own[STUCK] > 0.5, own[FORWARD] > 0.5, own[BACKWARD] > 0.5
    if (forward or backward) and _is_held_by_others(run, seen, h, calm):
        return STUCK
    if is_at_rest(instant, seen, h):
        return KEEPS
    has_law = plant.has_forward[h] if v > 0.0 else plant.has_backward[h]
    is_torn = is_stuck and (instant.has_moved or _has_leapt(run, seen, h))
    is_reversed = (forward and v < 0.0) or (backward and v > 0.0)
    if is_torn or (is_reversed and not plant.has_gap[h]):
        if has_law and not plant.is_direct[h]:
            return FORWARD if v > 0.0 else BACKWARD
        return KEEPS if is_stuck else STUCK
    return KEEPS


@kernel
def _follow_speeds(run: Run, seen: Look, calm: float) -> bool:
    """Change positions that follow from speeds; whether there were any."""
    plant, instant = run.plant, run.instant
    changes = False
    for h in range(plant.holds):
        position = _position_by_speed(run, seen, h, calm)
        if position == KEEPS:
            continue
        changes = True
        if position == STUCK:
            set_position(plant, instant.m, h, STUCK)
            instant.is_halted[h] = 1
        else:
            let_go(run, h, position)
            instant.is_settled[h] = 0
    return changes


@kernel
def _rebalance(run: Run, seen: Look) -> int:
    """Let overloaded holds go, let those stick that would reverse; gives FITS, or why not.

    Positions that follow from speeds change first: until then the reactions are wrong.
    """
    plant = run.plant
    if plant.holds == 0:
        return FITS
    standstills(plant, run.instant)
    calm = calmness(run, seen)
    if _follow_speeds(run, seen, calm):
        return CHANGES
    return settle_reactions(run, seen, calm)


@kernel
def _flip(run: Run) -> None:
    """Change the positions whose margins fired."""
    plant, instant = run.plant, run.instant
    is_seen = False
    for i in range(instant.fired_count):
        kind, number = plant.margin_kind[instant.fired[i]], plant.margin_number[instant.fired[i]]
        if kind == CONDITION:
            if not is_seen and plant.piece_count[number] > 0:
                look_at(run, instant.x, instant.m, instant.seen)
                is_seen = True
            difference = 0.0
            if is_seen:
                difference = instant.seen.greater[number] - instant.seen.less[number]
            turn(plant, instant.m, number, difference)
            instant.is_exempt[number] = 1
        elif kind == SLIDE:
            instant.is_halted[number] = 1
            if not plant.has_gap[number]:
                set_position(plant, instant.m, number, STUCK)
        elif not instant.m[plant.hold_setting[number] + COMPLIANCE] > 0.0:
            # a shared reaction at its limit only tells that the load is to be shared again
            let_go(run, number, FORWARD if kind == UPPER else BACKWARD)


@kernel
def _note_leaps(run: Run) -> None:
    """Note speeds with the settings before, and release what has jumped away from its limit."""
    plant, instant = run.plant, run.instant
    may_leap = False
    for h in range(plant.holds):
        may_leap = may_leap or plant.may_leap[h] != 0
    if not may_leap:
        return
    look_at(run, instant.x, instant.before, instant.seen)
    copy_numbers(plant.holds, instant.seen.speed, instant.speed_before)
    look_at(run, instant.x, instant.m, instant.seen)
    for h in range(plant.holds):
        if is_held(plant, instant.m, h) and _has_leapt(run, instant.seen, h):
            set_position(plant, instant.m, h, FORWARD)


@kernel
def _prepare(run: Run) -> None:
    """Copy the states and settings of the run, which the search then changes."""
    plant, instant = run.plant, run.instant
    copy_numbers(plant.states, run.x, instant.x)
    copy_numbers(plant.settings, run.m, instant.m)
    any_stuck = False
    for h in range(plant.holds):
        instant.was_stuck[h] = is_held(plant, instant.before, h)
        instant.is_halted[h] = instant.is_settled[h] = 0
        instant.is_struck[h] = instant.was_let_go[h] = 0
        instant.loss[h] = instant.impulse[h] = instant.delay[h] = 0.0
        if instant.was_stuck[h]:
            stop(plant, instant, h)  # implicit steps leave rounding there
            any_stuck = True
    _note_leaps(run)
    if run.may_be_redundant and any_stuck:
        look_at(run, instant.x, instant.m, instant.seen)
        halt(run, instant.seen)  # redundant constraints have yielded
    for k in range(plant.conditions):
        # one that changed at practically the same time may stay although its sides are equal
        if run.t - instant.prepared_at > run.soon:
            instant.is_exempt[k] = 0
        instant.has_jumped[k] = 0
    begin_jumps(run)
    instant.prepared_at = run.t
    instant.has_moved = 0
    instant.fastest = 0.0
    begin_rounds(instant.condition_rounds)


@kernel
def _fit(run: Run, may_collide: bool) -> int:
    """Change positions and states until all fit."""
    plant, instant = run.plant, run.instant
    seen, is_last = instant.seen, not may_collide
    for _ in range(40 + 20 * (plant.holds + plant.conditions + plant.jumps)):
        share(run, instant.x, instant.m)
        if turn_wrong(run, seen, instant.m):
            continue
        if must_ask(run):
            return ASKS
        jumped = jump(run, seen)
        if jumped == SET_TWICE:
            return SET_TWICE
        if jumped != 0:
            for h in range(plant.holds):
                instant.is_settled[h] = 0
            continue
        if _engage(run, seen):
            continue
        if may_collide:
            collided = collide(run, seen)
            if collided == NO_ANSWER:
                return NO_FIT
            if collided == HAS_COLLIDED:
                continue
        balance = _rebalance(run, seen)
        if balance == UNSOLVED:
            return NO_FIT
        if balance == CHANGES:
            continue
        if may_collide and halt(run, seen) and not is_last:
            is_last = True
            continue
        _part(run, seen)
        return GOES_ON
    return NO_FIT


@kernel
def _part(run: Run, seen: Look) -> None:
    """Set gaps of parting bodies to zero where rounding left a small gap."""
    plant, m = run.plant, run.instant.m
    for h in range(plant.holds):
        own = m[plant.hold_setting[h] :]
        parts = run.instant.was_stuck[h] or seen.gap[h] < 0.0
        if plant.has_gap[h] and own[FORWARD] > 0.5 and parts:
            own[PARTED] += seen.gap[h]


@kernel
def find_positions(run: Run) -> int:
    """Find positions and states just after an instant; gives why if there are none.

    Takes the states and settings of the run, with functions of time as they are from now on, and
    from `instant` the settings before and the margins that fired. The results are in `instant`; of
    the run only implicit quantities change. After ASKS it goes on with the answers that are in
    the states of `instant`.
    """
    plant, instant = run.plant, run.instant
    if not instant.is_waiting:
        if not close(run, run.x, run.t, run.m):
            return NOT_CLOSED
        _prepare(run)
    if plant.conditions + plant.holds + plant.jumps > 0:
        if not instant.is_waiting:
            _flip(run)
        status = _fit(run, True)
        instant.is_waiting = status == ASKS
        if status != GOES_ON:
            return status
    if not close(run, instant.x, run.t, instant.m):
        return NOT_CLOSED
    return GOES_ON


@kernel
def _begin_positions(run: Run) -> int:
    """Set conditions at the start by their sides; gives NOT_CLOSED if a linkage does not close."""
    plant, instant = run.plant, run.instant
    if not close_first(run):
        return NOT_CLOSED
    release_demands(plant, run.m)
    for _ in range(3):
        look_at(run, run.x, run.m, instant.seen)
        # at the start, not just after it, so that a clock ticks at zero
        set_by_sides(plant, instant.seen, run.m)
    copy_numbers(plant.holds, instant.seen.speed, instant.speed_at_begin)
    copy_numbers(plant.settings, run.m, instant.before)
    instant.fired_count = 0
    instant.prepared_at = -_INFINITE
    watch_redundancy(run)
    return GOES_ON


@kernel
def begin(run: Run) -> int:
    """Find positions and states at the start, with the impacts there.

    Only the settings of functions of time and the guesses of implicit quantities are given.
    """
    status = _begin_positions(run)
    if status != GOES_ON:
        return status
    for h in range(run.plant.holds):
        if run.plant.has_gap[h] and run.instant.seen.gap[h] < -_DEEPEST:
            return INSIDE
    return find_positions(run)


@kernel
def calm_positions(run: Run) -> int:
    """Find positions at a start before any impact there."""
    status = _begin_positions(run)
    if status != GOES_ON:
        return status
    _prepare(run)
    return _fit(run, False)
