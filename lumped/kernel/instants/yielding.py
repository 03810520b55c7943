"""How far redundant constraints yield, so that they share a load: the stronger ones less."""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.flattening.hold_modes import COMPLIANCE, DEMAND, SHARE, STUCK
from lumped.kernel.instant_search import Look
from lumped.kernel.instants.holds import is_held, look_at, set_position
from lumped.kernel.plant import FREE
from lumped.kernel.run import Run

COMPLIANT = 1e-8
"""Compliance of redundant constraints, relative to that of the parts they hold."""
_FOLLOWS = 1e-4
"""Error of accelerations asked for, which are about 1, of holds that are not redundant."""
_ASKED = 64
"""Holds, evenly chosen, at which the compliance of the parts is found."""
_WEAKEST = 1e3
"""Most times that one constraint yields more than the strongest."""
_BESIDE = 30.0
"""The same, beside a contact: it has no limit, so it counts as strong as what it carries."""
_AGREE = 1e-6
_INFINITE = float("inf")


@kernel
def _is_redundant(run: Run, x: Numbers, trial: Numbers) -> bool:
    """Whether the holds that stick cannot all follow arbitrary accelerations."""
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
    """Note whether constraints are redundant if all stick; otherwise no fewer ones can be."""
    plant, trial = run.plant, run.instant.trial
    copy_numbers(plant.settings, run.m, trial)
    for h in range(plant.holds):
        set_position(plant, trial, h, STUCK)
        trial[plant.hold_setting[h] + COMPLIANCE] = 0.0
    run.may_be_redundant = plant.holds > 0 and _is_redundant(run, run.x, trial)
    run.yielding = -1.0


@kernel
def _softest(run: Run, x: Numbers, alone: Numbers) -> float:
    """The largest acceleration that a unit of force gives at a constraint."""
    plant, rest, pushed = run.plant, run.instant.at_rest, run.instant.pushed
    found = 0.0
    for h in range(plant.holds):
        set_position(plant, alone, h, FREE)
        alone[plant.hold_setting[h] + COMPLIANCE] = 0.0
    asked = min(plant.holds, _ASKED)
    for k in range(asked):
        h = k * (plant.holds - 1) // max(asked - 1, 1)
        demand = plant.hold_setting[h] + DEMAND
        set_position(plant, alone, h, STUCK)
        look_at(run, x, alone, rest)
        alone[demand] = 1.0
        look_at(run, x, alone, pushed)
        alone[demand] = 0.0
        set_position(plant, alone, h, FREE)
        # the force is infinite where a motion is prescribed
        force = abs(pushed.reaction[h] - rest.reaction[h])
        if force > 0.0 and force < _INFINITE:
            found = max(found, 1.0 / force)
    return found if found > 0.0 else 1.0


@kernel
def soften(run: Run, x: Numbers, m: Numbers) -> bool:
    """Let holds that stick yield a little if they are redundant; whether they are."""
    plant, instant = run.plant, run.instant
    any_stuck = False
    for h in range(plant.holds):
        own = m[plant.hold_setting[h] :]
        own[COMPLIANCE] = own[DEMAND] = own[SHARE] = 0.0
        any_stuck = any_stuck or is_held(plant, m, h)
    if not (run.may_be_redundant and any_stuck):
        return False
    copy_numbers(plant.settings, m, instant.sole)
    if not _is_redundant(run, x, instant.sole):
        return False
    weigh(run, x, m)
    _keep_rigid(run, x, m)
    return True


@kernel
def would_share(run: Run, h: int) -> bool:
    """Whether constraints are redundant if one more sticks."""
    plant, instant, trial = run.plant, run.instant, run.instant.sole
    copy_numbers(plant.settings, instant.m, trial)
    set_position(plant, trial, h, STUCK)
    for other in range(plant.holds):
        trial[plant.hold_setting[other] + COMPLIANCE] = 0.0
    return _is_redundant(run, instant.x, trial)


@kernel
def _keep_rigid(run: Run, x: Numbers, m: Numbers) -> None:
    """Let holds not yield that can follow any accelerations, unless motions are prescribed."""
    plant, instant = run.plant, run.instant
    rest, pushed, trial = instant.at_rest, instant.pushed, instant.sole
    copy_numbers(plant.settings, m, trial)
    look_at(run, x, trial, rest)
    for h in range(plant.holds):
        instant.is_grouped[h] = 0
    is_prescribed = False
    for other in range(2):
        for h in range(plant.holds):
            wanted = plant.any_demand[(h + other) % plant.holds]
            trial[plant.hold_setting[h] + DEMAND] = wanted
        look_at(run, x, trial, pushed)
        for h in range(plant.holds):
            change = pushed.acceleration[h] - rest.acceleration[h]
            error = abs(change - trial[plant.hold_setting[h] + DEMAND])
            instant.is_grouped[h] = instant.is_grouped[h] or not error < _FOLLOWS
            moves = abs(change) > _FOLLOWS
            is_prescribed = is_prescribed or (is_held(plant, m, h) and not moves)
    for h in range(plant.holds):
        if is_held(plant, m, h) and not (is_prescribed or instant.is_grouped[h]):
            m[plant.hold_setting[h] + COMPLIANCE] = 0.0


@kernel
def weigh(run: Run, x: Numbers, m: Numbers) -> None:
    """Let all holds yield while they stick, the weaker ones more."""
    plant, instant = run.plant, run.instant
    if run.yielding < 0.0:  # found once in a run
        copy_numbers(plant.settings, m, instant.sole)
        run.yielding = COMPLIANT * _softest(run, x, instant.sole)
    look, strongest, heaviest = instant.at_rest, 0.0, 0.0
    for h in range(plant.holds):
        m[plant.hold_setting[h] + COMPLIANCE] = run.yielding
    look_at(run, x, m, look)
    for h in range(plant.holds):
        reach = min(abs(look.upper[h]), abs(look.lower[h]))
        if reach > 0.0 and reach < _INFINITE:
            strongest = max(strongest, reach)
        elif is_held(plant, m, h) and abs(look.reaction[h]) < _INFINITE:
            heaviest = max(heaviest, abs(look.reaction[h]))
    for h in range(plant.holds):
        reach = min(abs(look.upper[h]), abs(look.lower[h]))
        if reach > 0.0 and reach < _INFINITE:
            weaker = max(min(strongest / reach, _WEAKEST), min(heaviest / reach, _BESIDE))
            m[plant.hold_setting[h] + COMPLIANCE] *= max(weaker, 1.0)


@kernel
def yield_from(run: Run, m: Numbers, look: Look) -> None:
    """Let holds that stick yield only to changes of their reaction from that at a point."""
    plant = run.plant
    for h in range(plant.holds):
        m[plant.hold_setting[h] + SHARE] = look.reaction[h] if is_held(plant, m, h) else 0.0
