"""Conditions: how their sides set them, and the jumps of states that follow."""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel, last_up_to
from lumped.kernel.instant_search import InstantSearch, Look
from lumped.kernel.plant import Plant
from lumped.kernel.rounds import may_change
from lumped.kernel.run import SET_TWICE, Run

_EQUAL, _LEAST = 1e-12, 1e-13
"""Difference of sides that are equal, relative to them, and at least."""


@kernel
def slack(look: Look, k: int) -> float:
    """Difference of the sides of a condition that is still rounding."""
    return _EQUAL * (abs(look.greater[k]) + abs(look.less[k])) + _LEAST


@kernel
def _enter(plant: Plant, m: Numbers, k: int, piece: int) -> None:
    """Settings of a piece of a table."""
    width = plant.piece_width[k]
    row = plant.pieces[plant.first_piece[k] + piece * width :]
    copy_numbers(width, row, m[plant.condition_setting[k] :])


@kernel
def _piece_at(plant: Plant, k: int, place: float) -> int:
    """The last piece that begins at or before a place; the first has no begin."""
    begins = plant.pieces[plant.first_piece[k] + 1 :]
    return last_up_to(begins, plant.piece_width[k], 0, plant.piece_count[k], place)


@kernel
def copy_conditions(plant: Plant, begin: Numbers, to: Numbers) -> None:
    """Copy the settings of all conditions."""
    for k in range(plant.conditions):
        first = plant.condition_setting[k]
        copy_numbers(plant.piece_width[k], begin[first:], to[first:])


@kernel
def set_by_sides(plant: Plant, look: Look, m: Numbers) -> None:
    """Set all conditions by their sides; where these are equal, ``>=`` holds and ``>`` does not."""
    for k in range(plant.conditions):
        if plant.piece_count[k] > 0:
            _enter(plant, m, k, _piece_at(plant, k, look.greater[k]))
        else:
            least = slack(look, k) if plant.is_strict[k] != 0 else -slack(look, k)
            holds = look.greater[k] - look.less[k] > least
            m[plant.condition_setting[k]] = 1.0 if holds else 0.0


@kernel
def turn(plant: Plant, m: Numbers, k: int, difference: float) -> None:
    """Change a condition to its opposite, or to the next piece."""
    own, count = m[plant.condition_setting[k] :], plant.piece_count[k]
    if count == 0:
        own[0] = 1.0 - own[0]
        return
    onward = own[3] < 0.0 or own[4] * difference < -0.5
    piece = int(own[0]) + (1 if onward else -1)
    _enter(plant, m, k, min(max(piece, 0), count - 1))


@kernel
def _is_wrong(plant: Plant, m: Numbers, k: int, difference: float, tolerated: float) -> bool:
    """Whether a condition contradicts its sides."""
    own = m[plant.condition_setting[k] :]
    if plant.piece_count[k] > 0:
        return own[2] + difference * (own[3] + own[4] * difference) < -tolerated
    return difference < -tolerated if own[0] > 0.5 else difference > tolerated


@kernel
def _is_tie(plant: Plant, instant: InstantSearch, m: Numbers, k: int, difference: float) -> bool:
    """Whether the sides are exactly equal and the condition is wrong for equal sides."""
    if difference != 0.0 or instant.is_exempt[k] or plant.piece_count[k] > 0:
        return False
    holds = m[plant.condition_setting[k]] > 0.5
    return holds == (plant.is_strict[k] != 0)


@kernel
def turn_wrong(run: Run, seen: Look, m: Numbers) -> bool:
    """Change conditions that contradict their sides; whether there were any."""
    plant, instant = run.plant, run.instant
    wrong, count = instant.wrong, 0
    for k in range(plant.conditions):
        difference = seen.greater[k] - seen.less[k]
        is_tie = _is_tie(plant, instant, m, k, difference)
        if is_tie or _is_wrong(plant, m, k, difference, slack(seen, k)):
            wrong[count] = k
            count += 1
        if is_tie:
            instant.is_exempt[k] = 1
    if count == 0:
        return False
    for i in range(may_change(instant.condition_rounds, count)):
        k = wrong[i]
        turn(plant, m, k, seen.greater[k] - seen.less[k])
    return True


@kernel
def must_ask(run: Run) -> bool:
    """Whether a program must answer before states change; notes for which jump."""
    plant, instant = run.plant, run.instant
    first = 0
    for k in range(plant.jumps):
        rank = plant.jump_asks[k]
        if rank == 0 or instant.was_true[k] or instant.was_asked[k]:
            continue
        if instant.m[plant.jump_setting[k]] > 0.5 and (first == 0 or rank < first):
            first, instant.asking = rank, k
    if first == 0:
        return False
    instant.was_asked[instant.asking] = 1
    return True


@kernel
def begin_jumps(run: Run) -> None:
    """Note which conditions held before an instant, and that nothing is set yet.

    What happens at practically the same time is one instant.
    """
    plant, instant = run.plant, run.instant
    is_later = run.t - instant.prepared_at > run.soon
    for i in range(plant.states):
        instant.set_by[i] = 0 if is_later else max(instant.set_by[i], -instant.set_by[i])
    for k in range(plant.jumps):
        instant.was_true[k] = instant.before[plant.jump_setting[k]] > 0.5
        instant.was_asked[k] = 0


@kernel
def jump(run: Run, seen: Look) -> int:
    """Change states where conditions have become true.

    Returns
    -------
    int
        1 if any did, 0 if none, SET_TWICE if two set the same state. What was set in an earlier
        round of the instant may be set again: that is cause and effect.
    """
    plant, instant = run.plant, run.instant
    any_jumps = 0
    if instant.has_moved:
        for i in range(plant.states):
            instant.set_by[i] = min(instant.set_by[i], -instant.set_by[i])
    for k in range(plant.jumps):
        holds = instant.m[plant.jump_setting[k]] > 0.5
        if holds and not instant.was_true[k]:
            any_jumps = 1
            if plant.jump_condition[k] >= 0:
                instant.has_jumped[plant.jump_condition[k]] = 1
            for i in range(plant.jump_begin[k], plant.jump_begin[k + 1]):
                state = plant.jump_state[i]
                if state >= 0:
                    if instant.set_by[state] > 0 and instant.set_by[state] != k + 1:
                        instant.set_twice, instant.setting_again = state, k
                        return SET_TWICE
                    instant.set_by[state] = k + 1
                    instant.x[state] = plant.jump_sign[i] * seen.jumped[i]
                    instant.has_moved = 1
        instant.was_true[k] = holds
    return any_jumps
