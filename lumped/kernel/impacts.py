"""Impacts: impulses of constraints that close at a speed.

The jump of all speeds equals the accelerations that result if the constraints that take part demand
their change of speed in unit time, without any other force: the impulsive form of the same
equations (Routh, Dynamics of a System of Rigid Bodies, ch. VIII). Which constraints take part is a
linear complementarity problem (Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts,
ch. 8): a contact that closes leaves with its restitution or faster, one that touches or runs freely
does not close, and impulses have the sign that the constraint can give; either the impulse or the
excess of speed is zero.
"""

from __future__ import annotations

from lumped.code.words import kernel
from lumped.flattening.hold_modes import BACKWARD, DEMAND, FORWARD, STUCK
from lumped.kernel.holds import TOUCHING, copy_settings, is_held, look_at, put, standstills, stop
from lumped.kernel.plant import FREE
from lumped.kernel.rounds import begin_rounds, may_change
from lumped.kernel.run import Look, Run
from lumped.kernel.sharing import soften, yield_from

__all__ = ["HAS_COLLIDED", "NO_ANSWER", "collide", "halt"]

NOTHING_CLOSES, HAS_COLLIDED, NO_ANSWER = range(3)

_ROUNDING = 1e-12
"""Impulse and speed, relative to the largest, that are rounding."""
_MISS = 1e-6
"""Error of speed that redundant constraints may have, relative to the largest speed."""
_GAIN = -1e-9
"""Loss, relative to the energy that the impulses exchange, that is rounding."""


@kernel
def _gather(run: Run, seen: Look) -> None:
    """Find the holds that may take part in an impact, and their speeds after it."""
    plant, instant = run.plant, run.instant
    for h in range(plant.holds):
        own = instant.m[plant.hold_setting[h] :]
        closes, held = instant.is_closing[h] != 0, own[STUCK] > 0.5
        one_way = plant.has_forward[h] + plant.has_backward[h] == 1
        slides = own[FORWARD] > 0.5 or own[BACKWARD] > 0.5
        touches = slides and one_way and (not plant.has_gap[h] or seen.gap[h] <= TOUCHING)
        instant.may_join[h] = plant.is_impulsive[h] and (closes or held or touches)
        instant.is_member[h] = plant.is_impulsive[h] and (closes or held)
        instant.leaving[h] = -instant.bounce[h] * seen.speed[h] if closes else 0.0
        instant.demand[h] = instant.leaving[h] - seen.speed[h]


@kernel
def _look(run: Run, is_redundant: bool, look: Look) -> None:
    """Look at the trial; redundant constraints yield from their reactions there."""
    instant = run.instant
    look_at(run, instant.x, instant.trial, look)
    if is_redundant:
        yield_from(run, instant.trial, look)
        look_at(run, instant.x, instant.trial, look)


@kernel
def _push(run: Run) -> None:
    """Look at the members without demands, and with the changes of speed that they demand."""
    plant, instant = run.plant, run.instant
    trial = instant.trial
    copy_settings(plant, instant.m, trial)
    for h in range(plant.holds):
        put(plant, trial, h, STUCK if instant.is_member[h] else FREE)
    is_redundant = soften(run, instant.x, trial)
    _look(run, is_redundant, instant.at_rest)
    for h in range(plant.holds):
        if instant.is_member[h]:
            trial[plant.hold_setting[h] + DEMAND] = instant.demand[h]
    _look(run, is_redundant, instant.pushed)


@kernel
def _impulse(run: Run, hold: int) -> float:
    return run.instant.pushed.reaction[hold] - run.instant.at_rest.reaction[hold]


@kernel
def _speed_after(run: Run, seen: Look, hold: int) -> float:
    instant = run.instant
    return seen.speed[hold] + instant.pushed.acceleration[hold] - instant.at_rest.acceleration[hold]


@kernel
def _is_wrong(run: Run, seen: Look, h: int, largest: float, fastest: float) -> bool:
    """Whether a member would pull that can only push, or another hold would close."""
    plant, instant = run.plant, run.instant
    if instant.is_member[h]:
        impulse = _impulse(run, h)
        if plant.has_upper[h] and not plant.has_lower[h]:
            return impulse > _ROUNDING * largest
        if plant.has_lower[h] and not plant.has_upper[h]:
            return impulse < -_ROUNDING * largest
        return False
    if not instant.may_join[h]:
        return False
    ahead = _speed_after(run, seen, h) - instant.leaving[h]
    if not plant.has_backward[h]:
        return ahead < -_ROUNDING * (1.0 + fastest)
    return ahead > _ROUNDING * (1.0 + fastest)


@kernel
def _find_members(run: Run, seen: Look) -> bool:
    """Find the holds that take part; whether there is a solution."""
    plant, instant = run.plant, run.instant
    begin_rounds(instant.member_rounds)
    for _ in range(40 + 20 * plant.holds):
        _push(run)
        largest, fastest, count = 0.0, 0.0, 0
        for h in range(plant.holds):
            largest = max(largest, abs(_impulse(run, h)))
            fastest = max(fastest, abs(seen.speed[h]))
        for h in range(plant.holds):
            instant.joins[h] = _is_wrong(run, seen, h, largest, fastest)
            count += instant.joins[h]
        if count == 0:
            return _is_obeyed(run, seen, fastest)
        changing = may_change(instant.member_rounds, count)
        for h in range(plant.holds):
            if instant.joins[h] and changing > 0:
                instant.is_member[h] = 1 - instant.is_member[h]
                changing -= 1
    return False


@kernel
def _is_obeyed(run: Run, seen: Look, fastest: float) -> bool:
    """Whether members leave at their speeds: redundant constraints may contradict each other."""
    for h in range(run.plant.holds):
        miss = _speed_after(run, seen, h) - run.instant.leaving[h]
        if run.instant.is_member[h] and not abs(miss) <= _MISS * (1.0 + fastest):
            return False
    return True


@kernel
def _strike(run: Run) -> None:
    """The states after the impulses."""
    instant = run.instant
    for i in range(run.plant.states):
        instant.x[i] += instant.pushed.rates[i] - instant.at_rest.rates[i]
    instant.has_moved = 1


@kernel
def _gains_energy(run: Run, seen: Look) -> bool:
    """Whether the impulses would add more energy than they take."""
    loss, size = 0.0, 0.0
    for h in range(run.plant.holds):
        if run.instant.is_member[h]:
            before, after = seen.speed[h], _speed_after(run, seen, h)
            loss += 0.5 * _impulse(run, h) * (before + after)
            size += 0.5 * abs(_impulse(run, h)) * (abs(before) + abs(after))
    return loss < _GAIN * size


@kernel
def halt(run: Run, seen: Look) -> None:
    """Bring the speeds of holds that stick to exactly zero."""
    plant, instant = run.plant, run.instant
    moves = False
    for h in range(plant.holds):
        held = is_held(plant, instant.m, h)
        instant.is_member[h] = held
        instant.demand[h] = -seen.speed[h]
        moves = moves or (held and seen.speed[h] != 0.0)
    if moves:
        _push(run)
        _strike(run)
    for h in range(plant.holds):
        is_halted = instant.is_halted[h] and not plant.has_gap[h]
        if is_held(plant, instant.m, h) or is_halted:
            stop(plant, instant, h)


@kernel
def _closes(run: Run, seen: Look, h: int) -> bool:
    """Whether a constraint without limit closes at a speed."""
    plant, instant = run.plant, run.instant
    m, v = instant.m[plant.hold_setting[h] :], seen.speed[h]
    rest = max(instant.rest_speed[h], _ROUNDING * instant.fastest)
    acts = m[STUCK] > 0.5 or m[FORWARD] > 0.5 or m[BACKWARD] > 0.5
    near = not plant.has_gap[h] or seen.gap[h] <= TOUCHING or instant.is_halted[h]
    comes = v < -rest and not plant.has_backward[h] and near
    comes = comes or (v > rest and not plant.has_forward[h])
    comes = comes and (not instant.is_halted[h] or plant.has_gap[h])
    if not instant.has_moved:
        comes = comes and (m[STUCK] < 0.5 or not instant.was_stuck[h])
    return plant.is_impulsive[h] and acts and comes


@kernel
def _rests(run: Run, h: int) -> bool:
    """Whether a bounce would be over at once, or lower than a gap that counts as none."""
    plant, instant = run.plant, run.instant
    v = instant.after.speed[h]
    copy_settings(plant, instant.m, instant.trial)
    put(plant, instant.trial, h, FORWARD)
    look_at(run, instant.x, instant.trial, instant.at_rest)
    a = instant.at_rest.acceleration[h]
    return a < 0.0 and (2.0 * v <= -a * run.shortest or v * v <= -2.0 * a * TOUCHING)


@kernel
def _end_short_bounces(run: Run) -> bool:
    """End bounces that would be over at once; whether there were any."""
    plant, instant = run.plant, run.instant
    look_at(run, instant.x, instant.m, instant.after)
    any_rest = False
    for h in range(plant.holds):
        bounces = instant.is_closing[h] and instant.is_member[h] and instant.bounce[h] != 0.0
        if bounces and _rests(run, h):
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
def _bounces(run: Run) -> bool:
    for h in range(run.plant.holds):
        if run.instant.bounce[h] != 0.0:
            return True
    return False


@kernel
def _impact(run: Run, seen: Look) -> bool:
    """Find speeds after an impact that loses energy, without bounces that are over at once.

    With different restitutions Newton's law may gain energy or have no solution; then all closing
    contacts take the least restitution, and if that fails, none. Gives whether there is a solution:
    redundant constraints may contradict each other.
    """
    plant, instant = run.plant, run.instant
    for i in range(plant.states):
        instant.x_before[i] = instant.x[i]
    for _ in range(plant.holds + 3):
        for i in range(plant.states):
            instant.x[i] = instant.x_before[i]
        _gather(run, seen)
        is_found = _find_members(run, seen)
        if _bounces(run) and (not is_found or _gains_energy(run, seen)):
            _even_out(run)
            continue
        if not is_found:
            return False
        for h in range(plant.holds):
            instant.work[h] = instant.push[h] = 0.0
            if instant.is_member[h]:
                instant.push[h] = _impulse(run, h)
                twice_mean = seen.speed[h] + _speed_after(run, seen, h)
                instant.work[h] = 0.5 * instant.push[h] * twice_mean
        _strike(run)
        if not (_bounces(run) and _end_short_bounces(run)):
            break
    return True


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
    for h in range(plant.holds):
        instant.fastest = max(instant.fastest, abs(seen.speed[h]))
    for h in range(plant.holds):
        instant.is_closing[h] = _closes(run, seen, h)
        instant.bounce[h] = seen.restitution[h] if instant.is_closing[h] else 0.0
        closes = closes or instant.is_closing[h] != 0
    if not closes:
        return NOTHING_CLOSES
    if not _impact(run, seen):
        return NO_ANSWER
    for h in range(plant.holds):
        if instant.is_member[h]:
            instant.loss[h] += instant.work[h]
            instant.impulse[h] -= instant.push[h]
            instant.is_struck[h] = 1
        if not instant.is_closing[h]:
            continue
        instant.is_halted[h] = 0
        if not instant.is_member[h]:  # others pull it away
            put(plant, instant.m, h, FORWARD if plant.has_upper[h] else BACKWARD)
        elif instant.bounce[h] != 0.0:
            put(plant, instant.m, h, FORWARD)
        else:
            put(plant, instant.m, h, STUCK)
            stop(plant, instant, h)
    return HAS_COLLIDED
