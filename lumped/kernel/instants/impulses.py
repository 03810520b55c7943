"""Impulses of an impact: which constraints give one, and what it does to the speeds."""

from __future__ import annotations

from lumped.code.words import copy_numbers, kernel, largest_of
from lumped.flattening.hold_modes import BACKWARD, DEMAND, FORWARD, STUCK
from lumped.kernel.instant_search import Look
from lumped.kernel.instants.holds import (
    ROUNDING,
    TOUCHING,
    is_held,
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

PRESSED = 1e-9
"""Gain of a limit by impulses, relative to the largest of them, that is rounding."""
_MISS = 1e-6
"""Error of speed that redundant constraints may have, relative to their largest speed before."""
_PROXIMAL, _EXACT = 4, 1e-14
"""Most proximal steps, and error of speed, relative to the largest speed, that is rounding."""
_GAIN = -1e-9
"""Loss, relative to the energy that the impulses exchange, that is rounding."""
_INFINITE = float("inf")


@kernel
def gather(run: Run, seen: Look) -> None:
    """Find the holds that may take part in an impact, and their speeds after it."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    for h in range(plant.holds):
        position, closes = position_of(plant, instant.m, h), instant.is_closing[h] != 0
        near = not plant.has_gap[h] or seen.gap[h] <= TOUCHING
        joins = near and (plant.is_impulsive[h] or plant.is_pressed[h])
        place = OUTSIDE
        if plant.is_impulsive[h] and (closes or position == STUCK):
            place = WITHIN
        elif joins and position == FORWARD:
            place = AT_UPPER
        elif joins and position == BACKWARD:
            place = AT_LOWER
        problem.place[h], problem.beyond[h] = place, 0.0
        instant.leaving[h] = -instant.bounce[h] * seen.speed[h] if closes else 0.0


@kernel
def push(run: Run, seen: Look) -> None:
    """Impulses, and speeds beyond those that are asked for, at the present places."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    trial, rest, pushed = instant.trial, instant.at_rest, instant.pushed
    copy_numbers(plant.settings, instant.m, trial)
    if run.may_be_redundant:
        weigh(run, instant.x, trial)
    for h in range(plant.holds):
        place = problem.place[h]
        set_position(plant, trial, h, FREE if place == WITHIN else position_at(place))
    look_at(run, instant.x, trial, rest)
    for h in range(plant.holds):
        if problem.place[h] == WITHIN:
            set_position(plant, trial, h, STUCK)
            change = instant.leaving[h] - seen.speed[h]
            trial[plant.hold_setting[h] + DEMAND] = rest.acceleration[h] + change
    look_at(run, instant.x, trial, pushed)
    for _ in range(_PROXIMAL if run.may_be_redundant else 0):
        error = 0.0
        for h in range(plant.holds):
            if problem.place[h] == WITHIN:
                miss = _speed_after(run, seen, h) - instant.leaving[h]
                error = max(error, abs(miss) / (1.0 + instant.fastest))
        if error <= _EXACT:
            break
        yield_from(run, trial, pushed)
        look_at(run, instant.x, trial, pushed)
    for h in range(plant.holds):
        problem.carried[h] = pushed.reaction[h] - rest.reaction[h]
        problem.motion[h] = _speed_after(run, seen, h) - instant.leaving[h]
        problem.most[h], problem.least[h] = _INFINITE, -_INFINITE
        if plant.has_upper[h]:
            problem.most[h] = pushed.upper[h] - rest.upper[h]
        if plant.has_lower[h]:
            problem.least[h] = pushed.lower[h] - rest.lower[h]


@kernel
def _speed_after(run: Run, seen: Look, hold: int) -> float:
    instant = run.instant
    return seen.speed[hold] + instant.pushed.acceleration[hold] - instant.at_rest.acceleration[hold]


@kernel
def _right_place(run: Run, h: int, largest: float, fastest: float) -> int:
    plant, problem, place = run.plant, run.instant.problem, run.instant.problem.place[h]
    if not plant.is_impulsive[h]:
        # impulses may raise the limits of friction
        gain = max(problem.most[h], -problem.least[h])
        if not (plant.is_pressed[h] and gain < _INFINITE and gain > PRESSED * largest):
            return OUTSIDE if place == WITHIN else place
        if place == OUTSIDE and is_held(plant, run.instant.m, h):
            return WITHIN
    return right_place(problem, h, ROUNDING * largest, ROUNDING * (1.0 + fastest))


@kernel
def find_impulses(run: Run, seen: Look) -> bool:
    """Find the places of all holds in an impact; whether there is a solution."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    begin_rounds(instant.place_rounds)
    may_join = run.may_be_redundant
    for _ in range(40 + 20 * plant.holds):
        push(run, seen)
        largest = largest_of(plant.holds, problem.carried)
        fastest = largest_of(plant.holds, seen.speed)
        for h in range(plant.holds):
            problem.next_place[h] = _right_place(run, h, largest, fastest)
        if change_places(instant, plant.holds):
            continue
        if not may_join or not _join(run, ROUNDING * (1.0 + fastest)):
            return _is_obeyed(run, fastest)
        may_join = False
    return False


@kernel
def _join(run: Run, room: float) -> bool:
    """Let contacts that close, and that others have stopped, share the impulses; any there are.

    Else the first of two that are redundant would take all.
    """
    instant, problem, joins = run.instant, run.instant.problem, False
    for h in range(run.plant.holds):
        is_idle = problem.place[h] == AT_UPPER or problem.place[h] == AT_LOWER
        if is_idle and instant.is_closing[h] and abs(problem.motion[h]) <= room:
            problem.place[h] = WITHIN
            joins = True
    return joins


@kernel
def _is_obeyed(run: Run, fastest: float) -> bool:
    """Whether constraints leave at their speeds: redundant ones may contradict each other."""
    problem, obeyed = run.instant.problem, True
    most = _MISS * fastest + ROUNDING * (1.0 + run.instant.fastest)
    for h in range(run.plant.holds):
        miss = problem.motion[h] if problem.place[h] == WITHIN else 0.0
        problem.is_wrong[h] = not abs(miss) <= most
        obeyed = obeyed and not problem.is_wrong[h]
    return obeyed


@kernel
def strike(run: Run) -> None:
    """The states after the impulses."""
    instant = run.instant
    for i in range(run.plant.states):
        instant.x[i] += instant.pushed.rates[i] - instant.at_rest.rates[i]
    instant.has_moved = 1


@kernel
def gains_energy(run: Run, seen: Look) -> bool:
    """Whether the impulses would add more energy than they take."""
    problem = run.instant.problem
    loss, size = 0.0, 0.0
    for h in range(run.plant.holds):
        if problem.place[h] != OUTSIDE:
            before, after = seen.speed[h], _speed_after(run, seen, h)
            loss += 0.5 * problem.carried[h] * (before + after)
            size += 0.5 * abs(problem.carried[h]) * (abs(before) + abs(after))
    return loss < _GAIN * size
