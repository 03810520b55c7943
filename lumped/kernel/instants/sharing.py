"""Redundant constraints share a load: each yields a little, the stronger one less.

If one constraint would exceed its limit, a self-stress (a distribution of reactions that moves
nothing) shifts its load to the others, so that the smallest reserve becomes as large as possible.
If no reserve is left, the constraints that block each other let go; which do after a jump of the
load, `lumped.kernel.instants.reactions` finds.
"""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel, sqrt
from lumped.flattening.hold_modes import COMPLIANCE, DEMAND, SHARE, SLACK
from lumped.kernel.instant_search import Look
from lumped.kernel.instants.holds import is_held, is_shared, look_at
from lumped.kernel.instants.reserve import largest_reserve
from lumped.kernel.instants.yielding import COMPLIANT, soften, yield_from
from lumped.kernel.run import Run

_NO_INFLUENCE, _NO_STRESS = 1e-6, 1e-6
"""Influence, and sum of its squares over a group, that is rounding."""
_MISSING = 0.2
"""Part of the rounding of a reaction that may be missing at a limit; more tells that no reserve is
left. So a share that is found lasts while the load changes by the rest."""
_ZERO = 1e-4
"""Part of that up to which a share is zero whatever the loads are, and does not just pass zero."""
_AHEAD = 1e-5
"""Part of the span of a run after which it is seen how loads change."""
_ROUNDS = 10
"""Most rounds of sharing, as limits may depend on reactions."""
_SLACK = 5e-8
"""Rounding of a shared reaction, relative to the largest one; less if a constraint yields more."""
_GENTLE = 1e-3
"""Acceleration, in SI units, by the least load for which shares are made: one that passes through
zero shall not be shared anew again and again."""
_INFINITE = float("inf")


@kernel
def share(run: Run, x: Numbers, m: Numbers) -> None:
    """Share the load of holds that stick within their limits; note in `gives_way` which let go.

    Self-stresses relieve overloaded holds (see `reserve`). `is_exhausted` tells that no
    reserve is left. Leaves the resulting reactions in `seen`.
    """
    plant, instant = run.plant, run.instant
    for h in range(plant.holds):
        instant.gives_way[h] = instant.is_grouped[h] = 0
        m[plant.hold_setting[h] + SLACK] = 0.0
    instant.is_exhausted = 0
    instant.is_shared = soften(run, x, m)
    if instant.is_shared:
        _share_if_redundant(run, x, m)
    look_at(run, x, m, instant.seen)
    for h in range(plant.holds if instant.is_shared else 0):
        # what sharing leaves beyond a limit is rounding, too
        own, excess = m[plant.hold_setting[h] :], _excess(instant.seen, h)
        if is_shared(plant, m, h) and 2.0 * excess > own[SLACK]:
            own[SLACK] = 2.0 * excess


@kernel
def _load_of(run: Run, acceleration: float) -> float:
    """The load that gives an acceleration to the parts that yield most."""
    return acceleration * COMPLIANT / run.yielding


@kernel
def _largest(run: Run, m: Numbers, look: Look, share: bool) -> float:
    """The largest reaction, or range of limits, of all holds or those that share; or other load."""
    found = _load_of(run, _GENTLE)
    for h in range(run.plant.holds):
        load = _load_of(run, abs(look.acceleration[h]))
        found = load if load > found and load < _INFINITE else found
        if is_shared(run.plant, m, h) or not share:
            found = max(found, abs(look.reaction[h]))
            if look.upper[h] < _INFINITE and look.lower[h] > -_INFINITE:
                found = max(found, look.upper[h] - look.lower[h])
    return found


@kernel
def _share_if_redundant(run: Run, x: Numbers, m: Numbers) -> None:
    """Share by compliance, and by self-stresses too if a limit is exceeded."""
    plant, instant = run.plant, run.instant
    yielding, look = instant.pushed, instant.at_rest
    look_at(run, x, m, yielding)
    yield_from(run, m, yielding)
    look_at(run, x, m, look)
    yield_from(run, m, look)
    largest, any_overload, any_void = _largest(run, m, look, False), False, False
    felt = COMPLIANT * _largest(run, m, look, True)
    for h in range(plant.holds):
        own = m[plant.hold_setting[h] :]
        if is_held(plant, m, h):
            own[SLACK] = felt  # what is not shared feels the yielding of the others
        if is_shared(plant, m, h):
            own[SLACK] = _SLACK * largest * run.yielding / own[COMPLIANCE]
            any_overload = any_overload or _excess(look, h) > 0.0
            if look.upper[h] <= look.lower[h]:  # it can bear no share
                instant.gives_way[h] = 1 if look.reaction[h] >= 0.0 else -1
                any_void = True
    if any_overload and not any_void:
        instant.is_exhausted = not _find_shares(run, x, m)


@kernel
def _find_shares(run: Run, x: Numbers, m: Numbers) -> bool:
    """Share the load in each group of redundant constraints; whether all can bear it.

    Limits may depend on reactions, so this is repeated until no limit is exceeded.
    """
    plant, instant, look = run.plant, run.instant, run.instant.at_rest
    bears = True
    for _ in range(_ROUNDS):
        for h in range(plant.holds):
            instant.is_grouped[h] = 0
        _look_ahead(run, x, m)
        _ask_each(run, x, m)
        any_overload = False
        for h in range(plant.holds):
            if is_shared(plant, m, h) and not instant.is_grouped[h] and _excess(look, h) > 0.0:
                any_overload = True
                bears = _share_in_group(run, m, look, _gather_group(run, m, h)) and bears
        if not (any_overload and bears):
            break
        look_at(run, x, m, look)
    return bears


@kernel
def _excess(look: Look, h: int) -> float:
    """Reaction beyond a limit."""
    return max(look.reaction[h] - look.upper[h], look.lower[h] - look.reaction[h])


@kernel
def _ask_each(run: Run, x: Numbers, m: Numbers) -> None:
    """Changes of reactions and limits of all holds that stick if one of them yields a little.

    They are scaled by the square roots of the compliances.
    """
    plant, instant, trial = run.plant, run.instant, run.instant.trial
    n, rest, pushed = plant.holds, run.instant.at_rest, run.instant.pushed
    copy_numbers(plant.settings, m, trial)
    for i in range(n):
        if not is_held(plant, m, i):
            continue
        own = trial[plant.hold_setting[i] :]
        own[DEMAND] = sqrt(own[COMPLIANCE])
        look_at(run, x, trial, pushed)
        own[DEMAND] = 0.0
        row = instant.reserve.influence[3 * n * i :]
        for j in range(n):
            scale = 0.0
            if is_held(plant, m, j):
                scale = sqrt(m[plant.hold_setting[j] + COMPLIANCE])
            row[j] = scale * (rest.reaction[j] - pushed.reaction[j])
            row[n + j] = row[2 * n + j] = 0.0
            if rest.upper[j] < _INFINITE:
                row[n + j] = scale * (rest.upper[j] - pushed.upper[j])
            if rest.lower[j] > -_INFINITE:
                row[2 * n + j] = scale * (rest.lower[j] - pushed.lower[j])


@kernel
def _gather_group(run: Run, m: Numbers, first: int) -> int:
    """Find the group of holds that can relieve the first and each other; gives their number."""
    plant, instant = run.plant, run.instant
    instant.group[0] = first
    instant.is_grouped[first] = 1
    count, done = 1, 0
    while done < count:
        own = instant.group[done]
        for h in range(plant.holds):
            to, back = 3 * plant.holds * own + h, 3 * plant.holds * h + own
            most = max(abs(instant.reserve.influence[to]), abs(instant.reserve.influence[back]))
            if is_held(plant, m, h) and not instant.is_grouped[h] and most > _NO_INFLUENCE:
                instant.group[count] = h
                instant.is_grouped[h] = 1
                count += 1
        done += 1
    return count


@kernel
def _square_influences(run: Run, count: int) -> None:
    """Make influences in a group self-stresses but for rounding.

    In them a constraint that is not redundant has an eigenvalue of its compliance over that of the
    parts it holds, some 1e-8, and a self-stress has 1.
    """
    n, group = run.plant.holds, run.instant.group
    influence, squared = run.instant.reserve.influence, run.instant.reserve.stress
    for i in range(count):
        own, row = influence[3 * n * group[i] :], squared[3 * n * i :]
        for j in range(count):
            for part in range(3):
                row[part * n + j] = 0.0
        for k in range(count):
            other, factor = influence[3 * n * group[k] :], own[group[k]]
            for j in range(count):
                for part in range(3):
                    row[part * n + j] += factor * other[part * n + group[j]]
    for i in range(count):
        own, row = influence[3 * n * group[i] :], squared[3 * n * i :]
        for j in range(count):
            for part in range(3):
                own[part * n + group[j]] = row[part * n + j]


@kernel
def _find_stresses(run: Run, m: Numbers, count: int) -> None:
    """Self-stresses of a group, with the changes of limits that they cause.

    They span the influences, which are made orthogonal by Gram and Schmidt's method with pivots.
    """
    plant, programme, group = run.plant, run.instant.reserve, run.instant.group
    n, stress = plant.holds, programme.stress
    _square_influences(run, count)
    r = 0
    while r < count:
        pivot, largest = 0, _NO_STRESS
        for j in range(count):
            own, size = run.instant.reserve.influence[3 * n * group[j] :], 0.0
            for i in range(count):
                size += own[group[i]] * own[group[i]]
            if size > largest:
                pivot, largest = j, size
        if largest <= _NO_STRESS:
            break
        new, best = stress[3 * n * r :], run.instant.reserve.influence[3 * n * group[pivot] :]
        for i in range(count):
            for part in range(3):
                new[part * n + i] = best[part * n + group[i]] / sqrt(largest)
        for j in range(count):
            own, along = run.instant.reserve.influence[3 * n * group[j] :], 0.0
            for i in range(count):
                along += own[group[i]] * new[i]
            for i in range(count):
                for part in range(3):
                    own[part * n + group[i]] -= along * new[part * n + i]
        r += 1
    programme.stresses = r
    for i in range(count):
        # influences are scaled by compliances; undo this for the reactions
        scale = sqrt(run.yielding / m[plant.hold_setting[group[i]] + COMPLIANCE])
        for k in range(3 * r):
            stress[n * k + i] = scale * stress[n * k + i]


@kernel
def _look_ahead(run: Run, x: Numbers, m: Numbers) -> None:
    """Look where the motion goes; the result is in `seen`."""
    rest, ahead, t = run.instant.at_rest, run.argument, run.t
    step = _AHEAD * run.span
    for i in range(run.plant.states):
        ahead[i] = x[i] + step * rest.rates[i]
    run.t = t + step
    look_at(run, ahead, m, run.instant.seen)
    run.t = t


@kernel
def _note_nearing(run: Run, count: int) -> None:
    """Note how much nearer the limits of a group come as the load changes."""
    instant, programme = run.instant, run.instant.reserve
    now, later, fastest, size = instant.at_rest, instant.seen, 0.0, 0.0
    for i in range(count):
        h = instant.group[i]
        upper, lower = 0.0, 0.0
        if now.upper[h] < _INFINITE:
            upper = now.upper[h] - now.reaction[h] - later.upper[h] + later.reaction[h]
        if now.lower[h] > -_INFINITE:
            lower = now.reaction[h] - now.lower[h] - later.reaction[h] + later.lower[h]
        programme.nears_upper[i] = upper if upper > 0.0 and upper < _INFINITE else 0.0
        programme.nears_lower[i] = lower if lower > 0.0 and lower < _INFINITE else 0.0
        fastest = max(fastest, max(programme.nears_upper[i], programme.nears_lower[i]))
        size = max(size, max(abs(now.reaction[h]), abs(later.reaction[h])))
    programme.changes = fastest > _SLACK * size
    for i in range(count if programme.changes else 0):
        programme.nears_upper[i] = programme.nears_upper[i] / fastest
        programme.nears_lower[i] = programme.nears_lower[i] / fastest


@kernel
def _share_in_group(run: Run, m: Numbers, look: Look, count: int) -> bool:
    """Give a group the shares with the largest reserve, or note which let go if none is left."""
    plant, instant, programme = run.plant, run.instant, run.instant.reserve
    for i in range(count):
        h = instant.group[i]
        programme.upper[i], programme.lower[i] = look.upper[h], look.lower[h]
        programme.carried[i] = look.reaction[h]
        programme.rounding[i] = _MISSING * m[plant.hold_setting[h] + SLACK]
    _note_nearing(run, count)
    programme.size = plant.holds
    programme.least_size = _load_of(run, _GENTLE)
    _find_stresses(run, m, count)
    largest_reserve(programme, count)
    lets_go = programme.is_exhausted or _bear_nothing(run, look, count)
    for i in range(count):
        h = instant.group[i]
        if lets_go:
            instant.gives_way[h] = programme.blocks[i]
        else:
            m[plant.hold_setting[h] + SHARE] = programme.carried[i]
    return not programme.is_exhausted


@kernel
def _bear_nothing(run: Run, look: Look, count: int) -> bool:
    """Whether those that block each other can only bear zero, as freewheels that face each other.

    Their shares would end with the next change of any load.
    """
    programme, any_blocks = run.instant.reserve, False
    for i in range(count):
        way, h = programme.blocks[i], run.instant.group[i]
        limit = look.upper[h] if way > 0 else look.lower[h]
        bears = limit != 0.0 or abs(programme.carried[i]) > _ZERO * programme.rounding[i]
        if way != 0 and bears:
            return False
        any_blocks = any_blocks or way != 0
    return any_blocks
