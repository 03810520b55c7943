"""Which constraints let go if a load far exceeds their limits.

Each constraint carries at most its limit at rest; those that then move let go. The motion follows
from Gauss's principle of least constraint, so it is unique.
"""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.flattening.hold_modes import COMPLIANCE, SHARE
from lumped.kernel.holds import copy_settings, is_held, look_at
from lumped.kernel.rounds import begin_rounds, may_change
from lumped.kernel.run import Run

__all__ = ["let_moving_go"]

_SOFTER = 1e14
"""Compliance of a constraint at its limit over that of one below its limit."""
_MOVES = 1e2
"""Acceleration, over that by its own compliance at the limit, above which a constraint moves."""


@kernel
def _set(run: Run, h: int, at_limit: int) -> None:
    """Let a constraint carry its upper (1) or lower (-1) limit, or stick (0)."""
    instant = run.instant
    own = instant.trial[run.plant.hold_setting[h] :]
    own[COMPLIANCE], own[SHARE] = instant.compliance[h], 0.0
    instant.at_limit[h] = at_limit
    if at_limit != 0:
        own[COMPLIANCE] = _SOFTER * run.yielding
        own[SHARE] = instant.at_rest.upper[h] if at_limit > 0 else instant.at_rest.lower[h]


@kernel
def _right_limit(run: Run, h: int) -> int:
    """The limit that a constraint reaches, with the others as they are; 0 if it sticks."""
    instant, at_limit = run.instant, run.instant.at_limit[h]
    least, most = instant.at_rest.lower[h], instant.at_rest.upper[h]
    reaction, a = instant.pushed.reaction[h], instant.pushed.acceleration[h]
    if at_limit == 0:
        return 1 if reaction > most else -1 if reaction < least else 0
    limit = most if at_limit > 0 else least
    # it sticks if it would then carry less than its limit
    return 0 if at_limit * (a - instant.compliance[h] * limit) < 0.0 else at_limit


@kernel
def let_moving_go(run: Run, x: Numbers, m: Numbers) -> bool:
    """Note in `gives_way` which holds move under the limits in `at_rest`; whether any does."""
    plant, instant, moves = run.plant, run.instant, False
    copy_settings(plant, m, instant.trial)
    for h in range(plant.holds):
        instant.compliance[h] = m[plant.hold_setting[h] + COMPLIANCE]
        _set(run, h, 0)
    begin_rounds(instant.overload_rounds)
    for _ in range(40 + 20 * plant.holds):
        look_at(run, x, instant.trial, instant.pushed)
        wrong = 0
        for h in range(plant.holds):
            if is_held(plant, m, h) and _right_limit(run, h) != instant.at_limit[h]:
                wrong += 1
        if wrong == 0:
            break
        wrong = may_change(instant.overload_rounds, wrong)
        for h in range(plant.holds):
            at_limit = _right_limit(run, h)
            if is_held(plant, m, h) and at_limit != instant.at_limit[h] and wrong > 0:
                _set(run, h, at_limit)
                wrong -= 1
    for h in range(plant.holds):
        at_limit, a = instant.at_limit[h], instant.pushed.acceleration[h]
        limit = instant.at_rest.upper[h] if at_limit > 0 else instant.at_rest.lower[h]
        yields = max(instant.compliance[h], run.yielding) * abs(limit)
        if not is_held(plant, m, h) or abs(a) <= _MOVES * yields:
            instant.at_limit[h] = 0
        moves = moves or instant.at_limit[h] != 0
    if moves:
        for h in range(plant.holds):
            instant.gives_way[h] = instant.at_limit[h]
    return moves
