"""The search for positions of conditions and holds that fit at one instant."""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.conditions import PATIENCE, jump, set_by_sides, turn, turn_wrong
from lumped.kernel.holds import (
    TOUCHING,
    copy_settings,
    is_held,
    look_at,
    put,
    release_demands,
    standstills,
    stop,
)
from lumped.kernel.impacts import collide, halt
from lumped.kernel.linkages import close
from lumped.kernel.plant import (
    BACKWARD,
    COMPLIANCE,
    CONDITION,
    FORWARD,
    FREE,
    LOWER,
    SLIDE,
    STUCK,
    UPPER,
    Plant,
)
from lumped.kernel.run import GOES_ON, INSIDE, NO_FIT, NOT_CLOSED, Instant, Look, Run
from lumped.kernel.sharing import share, watch_redundancy

__all__ = ["begin", "calm_positions", "find_positions"]

_EXCESS, _LEAST = 1e-10, 1e-13
"""Excess of a limit that is still rounding, relative and at least."""
_SHARED = 1e4
"""Times this where redundant constraints share a reaction."""
_CALM = 1e-9
"""Acceleration, relative to the largest rate, that is rounding."""
_DEEPEST = 1e-9
"""How deep bodies may start inside each other, m or rad: rounding of start values."""
_MANY = 1 << 40
KEEPS = -2
"""A hold that fits."""


@kernel
def _acts(plant: Plant, m: Numbers, h: int) -> bool:
    own = m[plant.hold_setting[h] :]
    return own[STUCK] > 0.5 or own[FORWARD] > 0.5 or own[BACKWARD] > 0.5


@kernel
def _first_position(plant: Plant, instant: Instant, seen: Look, h: int) -> int:
    """Position of a hold that begins to act: it follows from speed and gap alone."""
    v, least = seen.speed[h], instant.rest_speed[h]
    is_still = abs(v) <= least
    if plant.has_gap[h]:
        return STUCK if is_still and seen.gap[h] <= TOUCHING and v <= least else FORWARD
    if not is_still and v > 0.0 and plant.has_forward[h]:
        return FORWARD
    if not is_still and v < 0.0 and plant.has_backward[h]:
        return BACKWARD
    return STUCK


@kernel
def _engage(run: Run, seen: Look) -> bool:
    """Engage and release holds; whether there were any."""
    plant, instant = run.plant, run.instant
    any_changes = False
    for h in range(plant.holds):
        condition = plant.engaged_by[h]
        is_engaged = condition < 0 or instant.m[condition] > 0.5
        if is_engaged == _acts(plant, instant.m, h):
            continue
        if not any_changes:
            standstills(plant, instant)
        any_changes = True
        if is_engaged:
            put(plant, instant.m, h, _first_position(plant, instant, seen, h))
        else:
            put(plant, instant.m, h, FREE)
            instant.is_halted[h] = 0
    return any_changes


@kernel
def _would_turn_back(run: Run, seen: Look, h: int, is_at_rest: bool, calm: float) -> bool:
    """Whether what slides would turn back at once."""
    plant, own = run.plant, run.instant.m[run.plant.hold_setting[h] :]
    v, a, has_gap = seen.speed[h], seen.acceleration[h], plant.has_gap[h] != 0
    forward, backward = own[FORWARD] > 0.5, own[BACKWARD] > 0.5
    slows = (forward and v > 0.0 and a < 0.0) or (backward and v < 0.0 and a > 0.0)
    ends = slows and not has_gap and abs(v) <= abs(a) * run.soon
    touches = not has_gap or seen.gap[h] <= TOUCHING
    if forward and touches and ((is_at_rest and a < -calm) or ends):
        return True
    return backward and ((is_at_rest and a > calm) or ends)


@kernel
def _right_position(run: Run, seen: Look, h: int, calm: float, coarse: float) -> int:
    """The position that a hold must take; KEEPS if it may keep its own."""
    plant, instant = run.plant, run.instant
    own, v, reaction = instant.m[plant.hold_setting[h] :], seen.speed[h], seen.reaction[h]
    is_stuck, forward, backward = own[STUCK] > 0.5, own[FORWARD] > 0.5, own[BACKWARD] > 0.5
    is_at_rest = abs(v) <= instant.rest_speed[h] or instant.is_halted[h] != 0
    excess = coarse * (_EXCESS * abs(reaction) + _LEAST)
    if is_stuck and reaction > seen.upper[h] + excess + _EXCESS * abs(seen.upper[h]):
        return FORWARD
    if is_stuck and reaction < seen.lower[h] - excess - _EXCESS * abs(seen.lower[h]):
        return BACKWARD
    if _would_turn_back(run, seen, h, is_at_rest, calm):
        return STUCK
    has_law = plant.has_forward[h] if v > 0.0 else plant.has_backward[h]
    is_torn = is_stuck and instant.has_moved and not is_at_rest and has_law
    is_reversed = (forward and v < 0.0) or (backward and v > 0.0)
    is_reversed = is_reversed and not is_at_rest and not plant.has_gap[h]
    if is_torn or is_reversed:
        return FORWARD if v > 0.0 else BACKWARD
    return KEEPS


@kernel
def _rebalance(run: Run, seen: Look) -> bool:
    """Let go what is overloaded, hold what would turn back; whether there was any.

    All change while that helps, then the first alone, as in `turn_wrong`.
    """
    plant, instant = run.plant, run.instant
    if plant.holds == 0:
        return False
    standstills(plant, instant)
    largest, coarse, count = 0.0, 1.0, 0
    for i in range(plant.states):
        largest = max(largest, abs(seen.rates[i]))
    for h in range(plant.holds):
        if instant.m[plant.hold_setting[h] + COMPLIANCE] != 0.0:
            coarse = _SHARED
    for h in range(plant.holds):
        position = _right_position(run, seen, h, _CALM * (1.0 + largest), coarse)
        if position != KEEPS:
            instant.wrong[count] = h
            instant.next_position[count] = position
            count += 1
    if count == 0:
        return False
    changing = count
    if count < instant.fewest_holds:
        instant.fewest_holds, instant.patience_holds = count, PATIENCE
    elif instant.patience_holds > 0:
        instant.patience_holds -= 1
    else:
        changing = 1
    for i in range(changing):
        h = instant.wrong[i]
        put(plant, instant.m, h, instant.next_position[i])
        if instant.next_position[i] == STUCK:
            instant.is_halted[h] = 1
    return True


@kernel
def _share_anew(run: Run) -> None:
    """Forget that limits of shared reactions are used up, if new shares leave all of them room.

    Shares are those of the limits at an instant, and limits may change later.
    """
    plant, instant = run.plant, run.instant
    is_shared, count = False, 0
    for i in range(instant.fired_count):
        kind, number = plant.margin_kind[instant.fired[i]], plant.margin_number[instant.fired[i]]
        limits = kind == UPPER or kind == LOWER
        if limits and instant.m[plant.hold_setting[number] + COMPLIANCE] > 0.0:
            is_shared = True
    if not is_shared:
        return
    if not share(run, instant.x, instant.m):
        return
    look_at(run, instant.x, instant.m, instant.seen)
    for i in range(instant.fired_count):
        kind, h = plant.margin_kind[instant.fired[i]], plant.margin_number[instant.fired[i]]
        shares = kind == UPPER or kind == LOWER
        shares = shares and instant.m[plant.hold_setting[h] + COMPLIANCE] > 0.0
        room = instant.seen.upper[h] - instant.seen.reaction[h] if kind == UPPER else 0.0
        if kind == LOWER:
            room = instant.seen.reaction[h] - instant.seen.lower[h]
        if not (shares and room > 0.0):
            instant.fired[count] = instant.fired[i]
            count += 1
    instant.fired_count = count


@kernel
def _flip(run: Run) -> None:
    """Change what is used up."""
    plant, instant = run.plant, run.instant
    _share_anew(run)
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
                put(plant, instant.m, number, STUCK)
        else:
            put(plant, instant.m, number, FORWARD if kind == UPPER else BACKWARD)


@kernel
def _prepare(run: Run) -> None:
    """States and settings that are tried out, from those of the run and from those before."""
    plant, instant = run.plant, run.instant
    for i in range(plant.states):
        instant.x[i] = run.x[i]
    copy_settings(plant, run.m, instant.m)
    for h in range(plant.holds):
        instant.was_stuck[h] = is_held(plant, instant.before, h)
        instant.is_halted[h] = instant.is_struck[h] = 0
        instant.loss[h] = 0.0
        if instant.was_stuck[h]:
            stop(plant, instant, h)  # implicit steps leave rounding there
    for k in range(plant.conditions):
        instant.is_exempt[k] = instant.has_jumped[k] = 0
    for k in range(plant.jumps):
        instant.was_true[k] = instant.before[plant.jump_setting[k]] > 0.5
    instant.has_moved = 0
    instant.fastest = 0.0
    instant.fewest_conditions = instant.fewest_holds = _MANY
    instant.patience_conditions = instant.patience_holds = PATIENCE


@kernel
def _fit(run: Run, may_collide: bool) -> int:
    """Change positions and states until everything fits."""
    plant, instant = run.plant, run.instant
    seen = instant.seen
    for _ in range(40 + 20 * (plant.holds + plant.conditions + plant.jumps)):
        share(run, instant.x, instant.m)
        look_at(run, instant.x, instant.m, seen)
        if turn_wrong(run, seen) or jump(run, seen) or _engage(run, seen):
            continue
        if (may_collide and collide(run, seen)) or _rebalance(run, seen):
            continue
        if may_collide:
            halt(run, seen)
        return GOES_ON
    return NO_FIT


@kernel
def find_positions(run: Run) -> int:
    """Find positions and states just after an instant, as `instant` tells it; whether there are.

    Takes the states and settings of the run, with functions of time as they are from now on, and
    in `instant` the settings before and what is used up. The run is not changed, but for its
    implicit quantities.
    """
    plant = run.plant
    if not close(run, run.x, run.t, run.m):
        return NOT_CLOSED
    _prepare(run)
    if plant.conditions + plant.holds + plant.jumps > 0:
        _flip(run)
        status = _fit(run, True)
        if status != GOES_ON:
            return status
    if not close(run, run.instant.x, run.t, run.instant.m):
        return NOT_CLOSED
    return GOES_ON


@kernel
def _begin_positions(run: Run) -> int:
    """Conditions at the start, as their sides say; whether the linkages close."""
    plant, instant = run.plant, run.instant
    if not close(run, run.x, run.t, run.m):
        return NOT_CLOSED
    release_demands(plant, run.m)
    for _ in range(3):
        look_at(run, run.x, run.m, instant.seen)
        # not an instant after the start already, so that a clock ticks at zero
        set_by_sides(plant, instant.seen, run.m)
    for h in range(plant.holds):
        instant.speed_at_begin[h] = instant.seen.speed[h]
    copy_settings(plant, run.m, instant.before)
    instant.fired_count = 0
    watch_redundancy(run)
    return GOES_ON


@kernel
def begin(run: Run) -> int:
    """Find positions and states at the start, and what collides there at once.

    Only the settings of functions of time, and guesses of implicit quantities, are given.
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
    """Find positions at a start before anything collides there."""
    status = _begin_positions(run)
    if status != GOES_ON:
        return status
    _prepare(run)
    return _fit(run, False)
