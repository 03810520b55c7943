"""What holds at rest carry, and which of them begin to move.

The level of accelerations of the problem of an instant (`lumped.kernel.instants.problem`): among
all accelerations that constraints allow those come about that least differ from the free ones
(Gauss's principle of least constraint), with reactions within their limits. Limits at rest decide
first. What moves although it carries its limit at rest carries its law of sliding from then on, and
the problem is solved again, until nothing more begins to move. Conditions that depend on reactions,
as those of lossy gears, are part of it.
"""

from __future__ import annotations

from lumped.code.words import copy_numbers, kernel, largest_of
from lumped.flattening.hold_modes import BACKWARD, FORWARD, SHARE, STUCK
from lumped.kernel.instant_search import Look
from lumped.kernel.instants.conditions import copy_conditions, turn_wrong
from lumped.kernel.instants.holds import (
    TOUCHING,
    is_at_rest,
    is_opposed,
    is_shared,
    look_at,
    position_of,
    set_position,
)
from lumped.kernel.instants.problem import (
    AT_LOWER,
    AT_UPPER,
    OUTSIDE,
    WITHIN,
    change_places,
    position_at,
    right_place,
)
from lumped.kernel.instants.yielding import weigh, yield_from
from lumped.kernel.plant import FREE
from lumped.kernel.rounds import begin_rounds
from lumped.kernel.run import Run

FITS, CHANGES, UNSOLVED = range(3)
"""Whether positions fit, others were found, or there are none."""

_EXCESS, _LEAST = 1e-10, 1e-13
"""Excess over a limit that is still rounding, relative and at least."""
_CALM = 1e-9
"""Acceleration, relative to the largest rate, that is rounding."""
_ROUNDING = 1e-15
"""Of a reaction, relative to the largest of those at rest."""
_STILL, _SLOW, _FINE = 1e-10, 1e-3, 1e-4
"""Acceleration of redundant holds that is rounding, relative to what it is without any; the least
of those over the largest; and over what is rounding among all rates."""
_PROXIMAL = 8
"""Most proximal steps; each makes the error of accelerations some 1e8 times smaller."""
_SHORT = 1e-17
"""Way to rest after an impact that is rounding, m or rad."""
_INFINITE = float("inf")


@kernel
def calmness(run: Run, look: Look) -> float:
    """Acceleration that is rounding."""
    return _CALM * (1.0 + largest_of(run.plant.states, look.rates))


@kernel
def _ends_here(run: Run, seen: Look, h: int, is_forward: bool) -> bool:
    """Whether a hold that slides comes to rest now or at once."""
    plant, v, a = run.plant, seen.speed[h], seen.acceleration[h]
    if is_opposed(plant, run.instant.m, h):
        return False
    if plant.has_gap[h]:
        return seen.gap[h] <= TOUCHING and is_at_rest(run.instant, seen, h)
    slows = v > 0.0 and a < 0.0 if is_forward else v < 0.0 and a > 0.0
    is_brief = abs(v) <= abs(a) * run.soon
    if run.instant.has_moved:
        is_brief = is_brief or v * v <= 2.0 * abs(a) * _SHORT
    return is_at_rest(run.instant, seen, h) or (slows and is_brief)


@kernel
def _gather(run: Run, seen: Look) -> None:
    """Find the holds at rest, with what they carry in their positions."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    for h in range(plant.holds):
        position = position_of(plant, instant.m, h)
        problem.place[h], problem.slides[h], problem.beyond[h] = OUTSIDE, 0, 0.0
        if position == STUCK:
            problem.place[h] = WITHIN
        elif position == FORWARD and _ends_here(run, seen, h, True):
            problem.place[h], problem.slides[h] = AT_UPPER, 1
        elif position == BACKWARD and _ends_here(run, seen, h, False):
            problem.place[h], problem.slides[h] = AT_LOWER, 1
        problem.carried[h], problem.motion[h] = seen.reaction[h], seen.acceleration[h]
        problem.most[h], problem.least[h] = seen.upper[h], seen.lower[h]
        _limit(run, seen, h)


@kernel
def _limit(run: Run, look: Look, h: int) -> None:
    """Limits of a hold: those at rest, or what it carries when it slides."""
    problem = run.instant.problem
    if not problem.slides[h] or problem.place[h] == OUTSIDE:
        problem.most[h], problem.least[h] = look.upper[h], look.lower[h]
    elif problem.place[h] == AT_UPPER:
        problem.most[h] = look.reaction[h]
    elif problem.place[h] == AT_LOWER:
        problem.least[h] = look.reaction[h]


@kernel
def _find_right_places(run: Run) -> bool:
    """The next places of all holds; whether any differs from its own."""
    plant, problem = run.plant, run.instant.problem
    differs = False
    for h in range(plant.holds):
        # at a dead centre no reaction holds, and the one that would is infinite
        size = abs(problem.carried[h]) if abs(problem.carried[h]) < _INFINITE else 0.0
        if problem.most[h] < _INFINITE:
            size = max(size, abs(problem.most[h]))
        if problem.least[h] > -_INFINITE:
            size = max(size, abs(problem.least[h]))
        place = right_place(problem, h, _EXCESS * size + _LEAST, problem.room[h])
        problem.next_place[h] = place
        differs = differs or place != problem.place[h]
    return differs


@kernel
def _place(run: Run) -> None:
    """Put all holds of the problem at their places."""
    plant, trial, problem = run.plant, run.instant.trial, run.instant.problem
    for h in range(plant.holds):
        place = problem.place[h]
        if place != OUTSIDE:
            set_position(plant, trial, h, position_at(place))
        if place == AT_UPPER or place == AT_LOWER:
            trial[plant.hold_setting[h] + SHARE] = problem.beyond[h]


@kernel
def _carry_limits(run: Run, look: Look) -> bool:
    """Let what is at its limit at rest carry just that; whether it did not."""
    plant, problem = run.plant, run.instant.problem
    changes, largest = False, 0.0
    for h in range(plant.holds):
        if problem.place[h] != OUTSIDE:
            largest = max(largest, abs(look.reaction[h]))
    for h in range(plant.holds):
        place = problem.place[h]
        if problem.slides[h] or place == OUTSIDE or place == WITHIN:
            continue
        limit = look.upper[h] if place == AT_UPPER else look.lower[h]
        missing = limit - look.reaction[h]
        if abs(missing) > 0.1 * (_EXCESS * abs(limit) + _LEAST) + _ROUNDING * largest:
            problem.beyond[h] += missing
            changes = True
    return changes


@kernel
def _pivot(run: Run) -> bool:
    """Find the places of all holds of the problem; whether there are any."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    look = instant.pushed
    begin_rounds(instant.place_rounds)
    for _ in range(40 + 20 * (plant.holds + plant.conditions)):
        _place(run)
        look_at(run, instant.x, instant.trial, look)
        if turn_wrong(run, look, instant.trial) or _carry_limits(run, look):
            continue
        calm = calmness(run, look)
        for h in range(plant.holds):
            problem.carried[h], problem.motion[h] = look.reaction[h], look.acceleration[h]
            # what sticks at a dead centre makes all rates huge
            problem.room[h] = min(problem.room[h], calm)
            _limit(run, look, h)
        _find_right_places(run)
        if not change_places(instant, plant.holds):
            return True
    return False


@kernel
def _solve(run: Run) -> bool:
    """Solve the problem with the limits as they are, redundant holds by proximal steps."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    for _ in range(_PROXIMAL):
        if not _pivot(run):
            return False
        if not run.may_be_redundant:
            return True
        is_exact = True
        for h in range(plant.holds):
            off = problem.place[h] == WITHIN and abs(problem.motion[h]) > 0.1 * problem.room[h]
            problem.is_wrong[h] = off
            is_exact = is_exact and not off
        if is_exact:
            return True
        yield_from(run, instant.trial, instant.pushed)
    return False


@kernel
def _begins_to_move(run: Run, h: int) -> bool:
    """Whether a hold moves although it carries its limit at rest."""
    problem, place = run.instant.problem, run.instant.problem.place[h]
    if problem.slides[h] or place == OUTSIDE or place == WITHIN:
        return False
    return abs(problem.motion[h]) > problem.room[h] or not run.may_be_redundant


@kernel
def _let_move(run: Run) -> bool:
    """Let what begins to move carry its law; whether the problem is another one by that.

    What did not stick before this instant goes first: it had no limit at rest yet.
    """
    problem, any_new, changes = run.instant.problem, False, False
    for h in range(run.plant.holds):
        any_new = any_new or (_begins_to_move(run, h) and not run.instant.was_stuck[h])
    for h in range(run.plant.holds):
        if _begins_to_move(run, h):
            waits = any_new and run.instant.was_stuck[h] != 0
            changes = changes or waits or problem.beyond[h] != 0.0
            if not waits:
                problem.slides[h], problem.beyond[h] = 1, 0.0
    return changes


@kernel
def _position(run: Run, h: int) -> int:
    """The position of a hold of the problem by its place; others may keep it at rest.

    What slides since this instant does so no longer if they keep it from reversing.
    """
    problem, place = run.instant.problem, run.instant.problem.place[h]
    position = position_at(place)
    slides_on = run.instant.m[run.plant.hold_setting[h] + position] > 0.5
    rests = run.may_be_redundant and not (run.instant.was_let_go[h] and slides_on)
    rests = rests and abs(problem.motion[h]) <= problem.room[h]
    if place == WITHIN or not problem.slides[h] or rests:
        return STUCK
    return position


@kernel
def let_go(run: Run, h: int, position: int) -> None:
    """Let a hold slide from rest; it sticks again at this instant only if it would reverse."""
    set_position(run.plant, run.instant.m, h, position)
    run.instant.was_let_go[h] = run.instant.is_settled[h] = 1


@kernel
def _know_room(run: Run) -> None:
    """Accelerations that are rounding: a small part of those without any hold of the problem."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    free, largest = instant.pushed, 0.0
    copy_numbers(plant.settings, instant.trial, instant.sole)
    for h in range(plant.holds):
        if problem.place[h] != OUTSIDE:
            set_position(plant, instant.sole, h, FREE)
    look_at(run, instant.x, instant.sole, free)
    for h in range(plant.holds):
        if problem.place[h] != OUTSIDE:
            largest = max(largest, abs(free.acceleration[h]))
    for h in range(plant.holds):
        room = _STILL * max(abs(free.acceleration[h]), _SLOW * largest)
        problem.room[h] = max(room, _FINE * calmness(run, free))


@kernel
def _take_answer(run: Run) -> bool:
    """Take the positions that solve the problem; whether any is new."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    changes = False
    for h in range(plant.holds):
        own = instant.m[plant.hold_setting[h] :]
        if problem.place[h] == OUTSIDE or own[_position(run, h)] > 0.5:
            continue
        if not changes:
            copy_conditions(plant, instant.trial, instant.m)
        changes = True
        if _position(run, h) != STUCK:
            let_go(run, h, _position(run, h))
            continue
        set_position(plant, instant.m, h, STUCK)
        instant.is_settled[h] = 1
        for other in range(plant.holds):
            instant.was_let_go[other] = 0  # the new one may keep them at rest, too
    return changes


@kernel
def _let_blocking_go(run: Run) -> bool:
    """Let those go that keep redundant holds from sharing more, or bear nothing; whether any."""
    any_goes = False
    for h in range(run.plant.holds):
        way = run.instant.gives_way[h]
        if way != 0:
            let_go(run, h, FORWARD if way > 0 else BACKWARD)
            any_goes = True
    return any_goes


@kernel
def settle_reactions(run: Run, seen: Look, calm: float) -> int:
    """Let overloaded holds go, let those stick that would reverse.

    Parameters
    ----------
    seen : Look
        The quantities in the present positions.
    calm : float
        Acceleration that is rounding.

    Returns
    -------
    int
        `FITS`, `CHANGES`, or `UNSOLVED`.
    """
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    _gather(run, seen)
    for h in range(plant.holds):
        problem.room[h] = calm
    if instant.is_shared:  # what redundant holds carry was shared within their limits
        for h in range(plant.holds):
            if problem.place[h] == WITHIN and is_shared(plant, instant.m, h):
                problem.most[h], problem.least[h] = _INFINITE, -_INFINITE
                # if a motion is prescribed, no share keeps it at rest
                instant.is_exhausted = instant.is_exhausted or abs(problem.motion[h]) > calm
    if not (_find_right_places(run) or instant.is_exhausted):
        return CHANGES if _let_blocking_go(run) else FITS
    copy_numbers(plant.settings, instant.m, instant.trial)
    if run.may_be_redundant:
        weigh(run, instant.x, instant.trial)
        _know_room(run)
    for _ in range(plant.holds + 1):
        if not _solve(run):
            return UNSOLVED
        if not _let_move(run):
            break
    return CHANGES if _take_answer(run) or _let_blocking_go(run) else FITS
