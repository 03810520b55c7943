"""Holds: reading and writing positions, and the quantities that decide them at a point."""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.flattening.hold_modes import (
    BACKWARD,
    COMPLIANCE,
    DEMAND,
    FORWARD,
    PARTED,
    SHARE,
    SLACK,
    STUCK,
)
from lumped.kernel.instant_search import InstantSearch, Look
from lumped.kernel.interpret import evaluate
from lumped.kernel.plant import FREE, Plant
from lumped.kernel.run import Run

TOUCHING = 1e-13
"""Gap of bodies that touch, m or rad."""
_INFINITE = float("inf")
ROUNDING = 1e-12
"""Impulse, and speed after an impact, relative to the largest, that are rounding."""
STANDSTILL = 1e-9
"""Speed that is rounding, relative to the speeds from which it is computed."""


@kernel
def set_position(plant: Plant, m: Numbers, hold: int, position: int) -> None:
    """Let a hold stick, slide, or be free."""
    own = m[plant.hold_setting[hold] :]
    own[0] = own[1] = own[2] = 0.0
    if position != STUCK:
        own[SHARE] = 0.0
    if position != FREE:
        own[position] = 1.0


@kernel
def position_of(plant: Plant, m: Numbers, h: int) -> int:
    """Position of a hold."""
    own = m[plant.hold_setting[h] :]
    if own[STUCK] > 0.5:
        return STUCK
    if own[FORWARD] > 0.5:
        return FORWARD
    return BACKWARD if own[BACKWARD] > 0.5 else FREE


@kernel
def is_held(plant: Plant, m: Numbers, hold: int) -> bool:
    """Whether a hold sticks."""
    return m[plant.hold_setting[hold] + STUCK] > 0.5


@kernel
def is_opposed(plant: Plant, m: Numbers, hold: int) -> bool:
    """Whether friction is at its opposite limit; both are met where its limits come to zero."""
    return plant.opposite[hold] >= 0 and is_held(plant, m, plant.opposite[hold])


@kernel
def is_shared(plant: Plant, m: Numbers, hold: int) -> bool:
    """Whether a hold sticks and shares its load with others."""
    return is_held(plant, m, hold) and m[plant.hold_setting[hold] + COMPLIANCE] > 0.0


@kernel
def is_at_rest(instant: InstantSearch, seen: Look, hold: int) -> bool:
    """Whether a speed is zero: by decision, or but for rounding."""
    if instant.is_halted[hold] != 0 or instant.is_settled[hold] != 0:
        return True
    return abs(seen.speed[hold]) <= instant.rest_speed[hold]


@kernel
def release_demands(plant: Plant, m: Numbers) -> None:
    """Clear demands, compliances, shares and gaps of parting."""
    for h in range(plant.holds):
        own = m[plant.hold_setting[h] :]
        own[COMPLIANCE] = own[DEMAND] = own[SHARE] = own[SLACK] = own[PARTED] = 0.0


@kernel
def look_at(run: Run, x: Numbers, m: Numbers, look: Look) -> None:
    """Evaluate all quantities that decide positions; missing limits are infinite.

    Gaps count from where bodies parted.
    """
    plant = run.plant
    evaluate(plant.look, run, x, run.t, m, look.greater)
    for h in range(plant.holds):
        look.gap[h] -= m[plant.hold_setting[h] + PARTED]
        if not plant.has_upper[h]:
            look.upper[h] = _INFINITE
        if not plant.has_lower[h]:
            look.lower[h] = -_INFINITE


@kernel
def standstills(plant: Plant, instant: InstantSearch) -> None:
    """Largest speeds that count as zero; a speed that is a state must be exactly zero."""
    rest = instant.rest_speed
    for h in range(plant.holds):
        rest[h] = 0.0
    for i in range(plant.speed_uses):
        h = plant.use_hold[i]
        rest[h] = max(rest[h], abs(instant.x[plant.use_state[i]]))
    for h in range(plant.holds):
        rest[h] = 0.0 if plant.speed_state[h] >= 0 else STANDSTILL * (1.0 + rest[h])
        if instant.has_moved:
            rest[h] = max(rest[h], ROUNDING * (1.0 + instant.fastest))


@kernel
def stop(plant: Plant, instant: InstantSearch, hold: int) -> None:
    """Make a speed exactly zero if it is a state."""
    if plant.speed_state[hold] >= 0:
        instant.x[plant.speed_state[hold]] = 0.0
