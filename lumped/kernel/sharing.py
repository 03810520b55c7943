"""Redundant constraints share what they carry: they yield a little, the stronger one less.

What would carry more than it can yields more, until the others carry the rest, as a ductile
structure does; so a set lets go when no distribution is left that it could bear (the elastic
compensation of Mackenzie and Boyle, International Journal of Pressure Vessels and Piping 53 (1993)
77).
"""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.holds import copy_settings, is_held, look_at, put
from lumped.kernel.plant import COMPLIANCE, DEMAND, FREE, STUCK
from lumped.kernel.run import Look, Run

__all__ = ["share", "watch_redundancy"]

_COMPLIANCE = 1e-9
"""Of redundant constraints, relative to the compliance of what they hold."""
_ASKED = 64
"""Holds, evenly chosen, that are asked for the compliance of what they hold."""
_WEAKEST = 1e3
"""Most times that one constraint yields more than the strongest."""
_GOAL = (0.9, 0.99, 0.999, 1 - 1e-4, 1 - 1e-5, 1 - 1e-6, 1 - 1e-7, 1 - 1e-8)
_GOALS = len(_GOAL)
"""Parts of the limits within which a distribution is sought, so that it lasts for a while."""
_ROUNDS = 50
"""Most rounds in which what is overloaded yields more."""
_MOST = 1e3
"""Times that what is overloaded may yield more than at first."""
_AGREE = 1e-6
_INFINITE = float("inf")


@kernel
def _is_redundant(run: Run, x: Numbers, trial: Numbers) -> bool:
    """Whether what sticks cannot be given any accelerations that one likes."""
    plant, rest, pushed = run.plant, run.instant.at_rest, run.instant.pushed
    wanted = plant.any_demand
    look_at(run, x, trial, rest)
    for h in range(plant.holds):
        trial[plant.hold_setting[h] + DEMAND] = wanted[h]
    look_at(run, x, trial, pushed)
    found = False
    for h in range(plant.holds):
        trial[plant.hold_setting[h] + DEMAND] = 0.0
        error = abs(pushed.acceleration[h] - rest.acceleration[h] - wanted[h])
        force = abs(pushed.reaction[h] - rest.reaction[h])
        if is_held(plant, trial, h) and (not error < _AGREE or not force < _INFINITE):
            found = True
    return found


@kernel
def watch_redundancy(run: Run) -> None:
    """Note whether constraints are redundant if all stick; with fewer they are less so."""
    plant, trial = run.plant, run.instant.trial
    copy_settings(plant, run.m, trial)
    for h in range(plant.holds):
        put(plant, trial, h, STUCK)
        trial[plant.hold_setting[h] + COMPLIANCE] = 0.0
    run.may_be_redundant = plant.holds > 0 and _is_redundant(run, run.x, trial)
    run.yielding = -1.0


@kernel
def _softest(run: Run, x: Numbers, alone: Numbers) -> float:
    """How much acceleration a unit of force gives at most where a constraint acts."""
    plant, rest, pushed = run.plant, run.instant.at_rest, run.instant.pushed
    found = 0.0
    for h in range(plant.holds):
        put(plant, alone, h, FREE)
        alone[plant.hold_setting[h] + COMPLIANCE] = 0.0
    asked = min(plant.holds, _ASKED)
    for k in range(asked):
        h = k * (plant.holds - 1) // max(asked - 1, 1)
        demand = plant.hold_setting[h] + DEMAND
        put(plant, alone, h, STUCK)
        look_at(run, x, alone, rest)
        alone[demand] = 1.0
        look_at(run, x, alone, pushed)
        alone[demand] = 0.0
        put(plant, alone, h, FREE)
        # it is infinite where a motion is prescribed
        force = abs(pushed.reaction[h] - rest.reaction[h])
        if force > 0.0 and force < _INFINITE:
            found = max(found, 1.0 / force)
    return found if found > 0.0 else 1.0


@kernel
def share(run: Run, x: Numbers, m: Numbers) -> bool:
    """Let what sticks yield a little if it is redundant; the stronger one carries more.

    Gives whether all limits bear that.
    """
    plant, instant = run.plant, run.instant
    any_stuck = False
    for h in range(plant.holds):
        m[plant.hold_setting[h] + COMPLIANCE] = 0.0
        any_stuck = any_stuck or is_held(plant, m, h)
    if not (run.may_be_redundant and any_stuck):
        return True
    copy_settings(plant, m, instant.sole)
    if not _is_redundant(run, x, instant.sole):
        return True
    if run.yielding < 0.0:
        run.yielding = _COMPLIANCE * _softest(run, x, instant.sole)
    for h in range(plant.holds):
        m[plant.hold_setting[h] + COMPLIANCE] = run.yielding
    look = instant.at_rest
    look_at(run, x, m, look)
    strongest = 0.0
    for h in range(plant.holds):
        reach = min(abs(look.upper[h]), abs(look.lower[h]))
        if reach < _INFINITE:
            strongest = max(strongest, reach)
    for h in range(plant.holds):
        reach = min(abs(look.upper[h]), abs(look.lower[h]))
        if reach > 0.0 and reach < _INFINITE and strongest > 0.0:
            m[plant.hold_setting[h] + COMPLIANCE] *= min(strongest / reach, _WEAKEST)
    for h in range(plant.holds):
        instant.weight[h] = m[plant.hold_setting[h] + COMPLIANCE]
    look_at(run, x, m, look)
    if not _is_overloaded(run, m, look, 1.0):
        return True
    for k in range(_GOALS):
        if _is_borne(run, x, m, _GOAL[k]):
            return True
        for h in range(plant.holds):
            m[plant.hold_setting[h] + COMPLIANCE] = instant.weight[h]
    return False


@kernel
def _is_borne(run: Run, x: Numbers, m: Numbers, part: float) -> bool:
    """Let what would carry more than a part of its limit yield more, until nothing does."""
    look = run.instant.at_rest
    for _ in range(_ROUNDS):
        look_at(run, x, m, look)
        if not _is_overloaded(run, m, look, part):
            return True
        _yield_more(run, m, look, part)
        if not _still_holds(run, m):
            return False
    return False


@kernel
def _is_overloaded(run: Run, m: Numbers, look: Look, part: float) -> bool:
    for h in range(run.plant.holds):
        if is_held(run.plant, m, h) and _use(look, h) > part:
            return True
    return False


@kernel
def _use(look: Look, h: int) -> float:
    """What a hold carries over what it can; zero where it can carry nothing."""
    reaction = look.reaction[h]
    limit = look.upper[h] if reaction > 0.0 else look.lower[h]
    return abs(reaction) / abs(limit) if limit != 0.0 else 0.0


@kernel
def _still_holds(run: Run, m: Numbers) -> bool:
    """Whether nothing yields so much that it would move."""
    plant, weight = run.plant, run.instant.weight
    for h in range(plant.holds):
        if m[plant.hold_setting[h] + COMPLIANCE] > _MOST * weight[h]:
            return False
    return True


@kernel
def _yield_more(run: Run, m: Numbers, look: Look, part: float) -> None:
    """Let what is overloaded yield more."""
    plant = run.plant
    for h in range(plant.holds):
        over = _use(look, h) / part
        if is_held(plant, m, h) and over > 1.0:
            beyond = 1.0 + 0.5 * (1.0 - part)  # so that it ends below its limit, not at it
            m[plant.hold_setting[h] + COMPLIANCE] *= beyond * over * over
