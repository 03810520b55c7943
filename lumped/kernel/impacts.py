"""Impacts: impulses of constraints that close at a speed.

The jump of all speeds is what the accelerations would be if the closing constraints demanded the
change of their speed in unit time, without any other force: the impulsive form of the same
equations (Routh, Dynamics of a System of Rigid Bodies, ch. VIII).
"""

from __future__ import annotations

from lumped.kernel.holds import TOUCHING, copy_settings, is_held, look_at, put, standstills, stop
from lumped.kernel.plant import BACKWARD, COMPLIANCE, DEMAND, FORWARD, FREE, STUCK
from lumped.kernel.run import Look, Run
from lumped.kernel.sharing import share
from lumped.kernel.words import kernel

__all__ = ["collide", "halt"]

_ROUNDING = 1e-12
"""Impulse, relative to the largest, and speed, that are rounding."""


@kernel
def _gather(run: Run, seen: Look) -> None:
    """What takes part in an impact and how its speed changes."""
    plant, instant = run.plant, run.instant
    for h in range(plant.holds):
        closes = instant.is_closing[h] != 0
        held = is_held(plant, instant.m, h) and plant.is_impulsive[h] != 0
        instant.is_member[h] = closes or held
        instant.demand[h] = -(1.0 + instant.bounce[h]) * seen.speed[h] if closes else 0.0


@kernel
def _push(run: Run) -> None:
    """Look at the members at rest, and with the changes of speed that they demand."""
    plant, instant = run.plant, run.instant
    trial = instant.trial
    copy_settings(plant, instant.m, trial)
    for h in range(plant.holds):
        put(plant, trial, h, STUCK if instant.is_member[h] else FREE)
        trial[plant.hold_setting[h] + DEMAND] = 0.0
    share(run, instant.x, trial)
    look_at(run, instant.x, trial, instant.at_rest)
    for h in range(plant.holds):
        if instant.is_member[h]:
            trial[plant.hold_setting[h] + DEMAND] = instant.demand[h]
    look_at(run, instant.x, trial, instant.pushed)


@kernel
def _impulse(run: Run, hold: int) -> float:
    return run.instant.pushed.reaction[hold] - run.instant.at_rest.reaction[hold]


@kernel
def _speed_after(run: Run, seen: Look, hold: int) -> float:
    instant = run.instant
    return seen.speed[hold] + instant.pushed.acceleration[hold] - instant.at_rest.acceleration[hold]


@kernel
def _worst(run: Run) -> int:
    """The member whose impulse has the wrong sign by the most; -1 if none has."""
    plant, instant = run.plant, run.instant
    largest, worst, size = 0.0, -1, 0.0
    for h in range(plant.holds):
        largest = max(largest, abs(_impulse(run, h)))
    for h in range(plant.holds):
        impulse = _impulse(run, h)
        pulls = plant.has_upper[h] and not plant.has_lower[h] and impulse > 0.0
        pushes = plant.has_lower[h] and not plant.has_upper[h] and impulse < 0.0
        is_wrong = instant.is_member[h] and (pulls or pushes)
        if is_wrong and abs(impulse) > max(_ROUNDING * largest, size):
            worst, size = h, abs(impulse)
    return worst


@kernel
def _closer(run: Run, seen: Look) -> int:
    """The first contact that touches, does not take part, and would close; -1 if none would."""
    plant, instant = run.plant, run.instant
    for h in range(plant.holds):
        touches = plant.has_gap[h] and seen.gap[h] <= TOUCHING
        touches = touches and instant.m[plant.hold_setting[h] + FORWARD] > 0.5
        if touches and not instant.is_member[h] and _speed_after(run, seen, h) < -_ROUNDING:
            return h
    return -1


@kernel
def _strike(run: Run, seen: Look, may_pull: bool, counts: bool) -> None:
    """Impulses of what closes and of all constraints without limit that hold."""
    plant, instant = run.plant, run.instant
    _gather(run, seen)
    for _ in range(2 * plant.holds + 2):
        _push(run)
        worst = -1 if may_pull else _worst(run)
        closer = _closer(run, seen)
        if worst >= 0:
            instant.is_member[worst] = 0
        elif closer >= 0:
            # it did not approach, so there is nothing that would bounce
            instant.is_member[closer] = 1
            instant.demand[closer] = -seen.speed[closer]
        else:
            break
    for i in range(plant.states):
        instant.x[i] += instant.pushed.rates[i] - instant.at_rest.rates[i]
    instant.has_moved = 1
    if counts:
        for h in range(plant.holds):
            if instant.is_member[h]:
                twice_mean = seen.speed[h] + _speed_after(run, seen, h)
                instant.loss[h] += 0.5 * _impulse(run, h) * twice_mean
                instant.is_struck[h] = 1


@kernel
def halt(run: Run, seen: Look) -> None:
    """Bring the speed of what sticks to exactly zero."""
    plant, instant = run.plant, run.instant
    moves = False
    for h in range(plant.holds):
        held = is_held(plant, instant.m, h)
        instant.is_closing[h] = held
        instant.bounce[h] = 0.0
        moves = moves or (held and seen.speed[h] != 0.0)
    if moves:
        _strike(run, seen, True, False)
    for h in range(plant.holds):
        is_halted = instant.is_halted[h] and not plant.has_gap[h]
        if is_held(plant, instant.m, h) or is_halted:
            stop(plant, instant, h)


@kernel
def _closes(run: Run, seen: Look, h: int) -> bool:
    """Whether a constraint without limit closes at a speed."""
    plant, instant = run.plant, run.instant
    m, v, rest = instant.m[plant.hold_setting[h] :], seen.speed[h], instant.rest_speed[h]
    acts = m[STUCK] > 0.5 or m[FORWARD] > 0.5 or m[BACKWARD] > 0.5
    near = not plant.has_gap[h] or seen.gap[h] <= TOUCHING or instant.is_halted[h]
    comes = v < -rest and not plant.has_backward[h] and near
    comes = comes or (v > rest and not plant.has_forward[h])
    comes = comes and (not instant.is_halted[h] or plant.has_gap[h])
    if not instant.has_moved:
        comes = comes and (m[STUCK] < 0.5 or not instant.was_stuck[h])
    return plant.is_impulsive[h] and acts and comes


@kernel
def _rests(run: Run, h: int, seen: Look) -> bool:
    """Whether a bounce would be over at once."""
    plant, instant = run.plant, run.instant
    copy_settings(plant, instant.m, instant.trial)
    put(plant, instant.trial, h, FORWARD)
    look_at(run, instant.x, instant.trial, instant.at_rest)
    v, a = seen.speed[h], instant.at_rest.acceleration[h]
    return a < 0.0 and (2.0 * v <= -a * run.shortest or v * v <= -2.0 * a * run.lowest)


@kernel
def _end_short_bounces(run: Run) -> None:
    """Let those stay closed whose bounce would be over at once."""
    plant, instant = run.plant, run.instant
    look_at(run, instant.x, instant.m, instant.after)
    for h in range(plant.holds):
        instant.next_position[h] = instant.is_closing[h] and instant.is_member[h]
    for h in range(plant.holds):
        bounces = instant.next_position[h] and instant.bounce[h] != 0.0
        if bounces and _rests(run, h, instant.after):
            for j in range(plant.holds):
                instant.is_closing[j] = j == h
            instant.bounce[h] = 0.0
            _strike(run, instant.after, True, True)


@kernel
def collide(run: Run, seen: Look) -> bool:
    """Let constraints without limit that close at a speed do so; whether there were any."""
    plant, instant = run.plant, run.instant
    standstills(plant, instant)
    closes, bounces = False, False
    for h in range(plant.holds):
        instant.is_closing[h] = _closes(run, seen, h)
        instant.bounce[h] = seen.restitution[h] if instant.is_closing[h] else 0.0
        closes = closes or instant.is_closing[h] != 0
        bounces = bounces or instant.bounce[h] != 0.0
    if not closes:
        return False
    _strike(run, seen, False, True)
    for h in range(plant.holds):
        instant.has_closed[h] = instant.is_closing[h] + (2 if instant.is_member[h] else 0)
    if bounces:
        _end_short_bounces(run)
    for h in range(plant.holds):
        if instant.has_closed[h] % 2 == 0:
            continue
        instant.is_halted[h] = 0
        if instant.has_closed[h] == 1:  # others pull it away
            put(plant, instant.m, h, FORWARD if plant.has_upper[h] else BACKWARD)
        elif instant.bounce[h] != 0.0:
            put(plant, instant.m, h, FORWARD)
        else:
            put(plant, instant.m, h, STUCK)
            stop(plant, instant, h)
    return True
