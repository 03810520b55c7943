"""Impacts: impulses of constraints that close at a speed.

The level of speeds of the problem of an instant (`lumped.kernel.instants.problem`). The jump of all
speeds equals the accelerations that result if the constraints that take part demand their change of
speed in unit time, without any other force: the impulsive form of the same equations (Routh,
Dynamics of a System of Rigid Bodies, ch. VIII). A contact that closes leaves with its restitution
or faster, one that touches or runs freely does not close, and impulses have the sign that the
constraint can give; either the impulse or the excess of speed is zero (Pfeiffer and Glocker,
Multibody Dynamics with Unilateral Contacts, ch. 8). Limits that are finite give no impulse, but for
friction pressed by one: it carries at most what its limit gains by the impulses (Anitescu and
Potra, Nonlinear Dynamics 14 (1997) 231).
"""

from __future__ import annotations

from lumped.code.words import copy_numbers, kernel, largest_of
from lumped.flattening.hold_modes import BACKWARD, DEMAND, FORWARD, STUCK
from lumped.kernel.instant_search import Look
from lumped.kernel.instants.holds import (
    ROUNDING,
    STANDSTILL,
    TOUCHING,
    is_held,
    look_at,
    position_of,
    set_position,
    standstills,
    stop,
)
from lumped.kernel.instants.impulses import (
    PRESSED,
    find_impulses,
    gains_energy,
    gather,
    push,
    strike,
)
from lumped.kernel.instants.problem import AT_UPPER, OUTSIDE, WITHIN
from lumped.kernel.plant import FREE
from lumped.kernel.run import Run

NOTHING_CLOSES, HAS_COLLIDED, NO_ANSWER = range(3)

LOWEST = 1e-11
"""Rise of a bounce that counts as none, m or rad: far above the room of a margin."""


@kernel
def halt(run: Run, seen: Look) -> bool:
    """Bring the speeds of holds that stick to exactly zero, with the least change of energy.

    Gives whether any was more than rounding.
    """
    plant, instant, trial = run.plant, run.instant, run.instant.trial
    fastest = 0.0
    copy_numbers(plant.settings, instant.m, trial)
    for h in range(plant.holds):
        if is_held(plant, instant.m, h):
            trial[plant.hold_setting[h] + DEMAND] = -seen.speed[h]
            fastest = max(fastest, abs(seen.speed[h]))
    if fastest > 0.0:
        look_at(run, instant.x, trial, instant.pushed)
        for i in range(plant.states):
            instant.x[i] += instant.pushed.rates[i] - seen.rates[i]
    for h in range(plant.holds):
        is_halted = instant.is_halted[h] and not plant.has_gap[h]
        if is_held(plant, instant.m, h) or is_halted or instant.is_settled[h]:
            stop(plant, instant, h)
    return fastest > ROUNDING * (1.0 + instant.fastest)


@kernel
def _closes(run: Run, seen: Look, h: int) -> bool:
    """Whether a constraint without limit closes at a speed."""
    plant, instant = run.plant, run.instant
    position, v = position_of(plant, instant.m, h), seen.speed[h]
    rest = max(instant.rest_speed[h], ROUNDING * instant.fastest)
    near = not plant.has_gap[h] or seen.gap[h] <= TOUCHING or instant.is_halted[h]
    comes = v < -rest and not plant.has_backward[h] and near
    comes = comes or (v > rest and not plant.has_forward[h])
    comes = comes and (not instant.is_halted[h] or plant.has_gap[h]) and not instant.is_settled[h]
    if not instant.has_moved:
        comes = comes and (position != STUCK or not instant.was_stuck[h])
    return plant.is_impulsive[h] and position != FREE and comes


@kernel
def _returns_at_once(run: Run, h: int, v: float) -> bool:
    """Whether a contact that opens at a speed closes again at once, or rises by nothing."""
    plant, instant = run.plant, run.instant
    copy_numbers(plant.settings, instant.m, instant.trial)
    set_position(plant, instant.trial, h, FORWARD)
    look_at(run, instant.x, instant.trial, instant.at_rest)
    a = instant.at_rest.acceleration[h]
    return a < 0.0 and (2.0 * v <= -a * run.shortest or v * v <= -2.0 * a * LOWEST)


@kernel
def _end_short_bounces(run: Run) -> bool:
    """End bounces that would be over at once; whether there were any.

    All flights of a series that is left out last as long as a geometric series of them.
    """
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    look_at(run, instant.x, instant.m, instant.after)
    any_rest = False
    for h in range(plant.holds):
        bounces = instant.is_closing[h] and problem.place[h] == WITHIN
        bounces = bounces and instant.bounce[h] != 0.0
        if bounces and _returns_at_once(run, h, instant.after.speed[h]):
            flight = 2.0 * instant.after.speed[h] / -instant.at_rest.acceleration[h]
            if instant.bounce[h] < 1.0:
                instant.delay[h] = flight / (1.0 - instant.bounce[h])
            instant.bounce[h] = 0.0
            any_rest = True
    return any_rest


@kernel
def _even_out(run: Run) -> None:
    """Give all closing contacts the least restitution, or none if all have the same."""
    plant, instant = run.plant, run.instant
    least, most = 1.0, 0.0
    for h in range(plant.holds):
        if instant.is_closing[h]:
            least, most = min(least, instant.bounce[h]), max(most, instant.bounce[h])
    for h in range(plant.holds):
        if instant.is_closing[h]:
            instant.bounce[h] = least if least < most else 0.0


@kernel
def _impact(run: Run, seen: Look) -> bool:
    """Find speeds after an impact that loses energy, without bounces that are over at once.

    With different restitutions Newton's law may gain energy or have no solution; then all closing
    contacts take the least restitution, and if that fails, none. Gives whether there is a solution:
    redundant constraints may contradict each other.
    """
    plant, instant = run.plant, run.instant
    copy_numbers(plant.states, instant.x, instant.x_before)
    for _ in range(plant.holds + 3):
        copy_numbers(plant.states, instant.x_before, instant.x)
        gather(run, seen)
        is_found = find_impulses(run, seen)
        bounces = largest_of(plant.holds, instant.bounce) > 0.0
        if bounces and (not is_found or gains_energy(run, seen)):
            _even_out(run)
            continue
        if not is_found:
            return False
        strike(run)
        if not (bounces and _end_short_bounces(run)):
            break
    return True


@kernel
def _note_work(run: Run, seen: Look) -> None:
    """Note the impulse of each hold and the energy that it takes."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    largest, hardest = largest_of(plant.holds, problem.carried), 0.0
    for h in range(plant.holds):
        if instant.is_closing[h]:
            hardest = max(hardest, abs(seen.speed[h]))
    is_felt = hardest > STANDSTILL * (1.0 + instant.fastest)
    for h in range(plant.holds):
        impulse = problem.carried[h]
        rubs = is_felt and problem.place[h] != OUTSIDE and abs(impulse) > PRESSED * largest
        if problem.place[h] == WITHIN or rubs:
            instant.loss[h] += 0.5 * impulse * (seen.speed[h] + instant.after.speed[h])
            instant.impulse[h] -= impulse
            instant.is_struck[h] = 1


@kernel
def _settle(run: Run, h: int, position: int) -> None:
    """Take the position that the answer gives; no later line asks its speed for it."""
    plant, instant = run.plant, run.instant
    set_position(plant, instant.m, h, position)
    instant.is_settled[h] = position == STUCK


@kernel
def _take_answer(run: Run) -> None:
    """Positions of all holds that took part; a contact that is back at once stays."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    rest = ROUNDING * (1.0 + instant.fastest)
    for h in range(plant.holds):
        place, after = problem.place[h], instant.after.speed[h]
        sticks = is_held(plant, instant.m, h) or instant.is_closing[h]
        problem.next_place[h] = OUTSIDE
        if abs(after) > rest:
            instant.is_halted[h] = instant.is_settled[h] = 0
        if place == WITHIN:
            leaving = instant.leaving[h]
            away = FORWARD if leaving > 0.0 else BACKWARD
            _settle(run, h, away if abs(leaving) > rest else STUCK)
            if abs(leaving) <= rest:
                stop(plant, instant, h)
        elif place != OUTSIDE and sticks:
            # others pull it away
            moves = after > rest if place == AT_UPPER else after < -rest
            position = FORWARD if place == AT_UPPER else BACKWARD
            _settle(run, h, position if moves else STUCK)
            if moves and plant.has_gap[h]:
                problem.next_place[h] = AT_UPPER
    for h in range(plant.holds):
        opens = problem.next_place[h] == AT_UPPER
        if opens and not _returns_at_once(run, h, instant.after.speed[h]):
            problem.next_place[h] = OUTSIDE
    for h in range(plant.holds):
        if problem.next_place[h] == AT_UPPER:
            _settle(run, h, STUCK)


@kernel
def _end_flights(run: Run) -> None:
    """Bring back what the impact has thrown but rises by nothing."""
    plant, instant, problem = run.plant, run.instant, run.instant.problem
    flies = False
    for h in range(plant.holds):
        stays = is_held(plant, instant.m, h) and instant.is_settled[h] != 0
        problem.place[h] = WITHIN if stays else OUTSIDE
        instant.leaving[h] = 0.0
        flies = flies or (stays and abs(instant.after.speed[h]) > ROUNDING * instant.fastest)
    if flies:
        push(run, instant.after)
        strike(run)


@kernel
def collide(run: Run, seen: Look) -> int:
    """Let contacts that close at a speed collide.

    Returns
    -------
    int
        `NOTHING_CLOSES`, `HAS_COLLIDED`, or `NO_ANSWER` if no impulses fit.
    """
    plant, instant = run.plant, run.instant
    standstills(plant, instant)
    closes = False
    instant.fastest = max(instant.fastest, largest_of(plant.holds, seen.speed))
    for h in range(plant.holds):
        instant.is_closing[h] = _closes(run, seen, h)
        instant.bounce[h] = seen.restitution[h] if instant.is_closing[h] else 0.0
        closes = closes or instant.is_closing[h] != 0
    if not closes:
        return NOTHING_CLOSES
    if not _impact(run, seen):
        return NO_ANSWER
    look_at(run, instant.x, instant.m, instant.after)
    _note_work(run, seen)
    _take_answer(run)
    _end_flights(run)
    return HAS_COLLIDED
