"""Reversing cold rolling mill 400: published numbers beside computed ones.

The stand and its source are described in `lumped.models.reversing_mill.stand`, the roll gap that
sticks, skids and opens in `lumped.models.reversing_mill.scenes`, its motors in
`lumped.models.reversing_mill.drives`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row, compare, unpublished
from lumped.models.about import Measure, find_shared, number_values
from lumped.models.reversing_mill import drives, scenes, stand
from lumped.models.reversing_mill.about import ABOUT

ROUNDING = "within the rounding of the printed J and C"
INFERRED = "J and C chosen that round to the printed ones [I]; rounds to the printed digits"
ALONE = "J2 without gearbox [I]; then no rounding gives all three frequencies at once"
PUBLISHED: tuple[tuple[Any, ...], ...] = (  # quantity, unit, value, place, remark, bounds, fitted
    ("upper branch, gap open, f1", "Hz", 39.8, "pages 71, 72, before (47) [P]", ROUNDING),
    ("upper branch, gap open, f2", "Hz", 21.7, "pages 71, 72, before (47) [P]", ROUNDING),
    ("lower branch, gap open", "Hz", 38.9, "equation (46) [P]", ROUNDING),
    *(
        (f"{name}, J and C inside their rounding", "Hz", value, place, INFERRED, None, True)
        for name, value, place in (
            ("upper f1", 39.8, "pages 71, 72, before (47) [P]"),
            ("upper f2", 21.7, "pages 71, 72, before (47) [P]"),
            ("lower f", 38.9, "equation (46) [P]"),
        )
    ),
    ("lower branch, motor alone", "Hz", 38.9, "equation (46) [P]", ALONE),
    (
        "influence of the mass of a spindle",
        "Hz",
        None,
        "equation (45) [P]",
        "inertia of 0.0026 kgf m s2 [I], chosen to stay just below; the dimensions are not given",
        (None, 0.1),
        True,
    ),
    (
        "eccentricity at 15 m/s",
        "Hz",
        9.55,
        "equation (47) [P]",
        "fixes the diameter, not legible [I]",
        None,
        True,
    ),
    ("eccentricity at 10 m/s", "Hz", 6.36, "equation (47) [P]", "print cut off, not rounded"),
)
NOT = "not published [R]"
LIMITS = "not published, limits [A]"
MOTORS = "not published, motors [A]"
CHANGES = ("first skid", "first stick", "second skid", "second stick")
SYMMETRIC = "by eigenvalues; two of them are those of the open branch"
ILL = "by eigenvalues; not those of the open gap"
PEAK = "strip entry, peak over mean torque"
PASSIVE = "motors unchanged, peak over mean torque"
LOWEST = "strip break, lowest over rated torque"
UNEQUAL = "equalizing over rated torque, rolls 0.2 % apart, droop"
UNPUBLISHED = (
    *unpublished(
        *("Hz", NOT),
        {
            "closed gap, mode 1": "6.34431 from the roots of equation (56)",
            "closed gap, mode 2": "22.50599 from the roots of equation (56)",
            "closed gap, mode 3": "39.17282 from the roots of equation (56)",
            "closed gap, motor alone, mode 1": "7.500 from equation (56)",
            "closed gap, motor alone, mode 2": "22.556 from equation (56)",
            "closed gap, motor alone, mode 3": "39.382 from equation (56)",
            "closed gap, equal branches, mode 1": f"6.179 {SYMMETRIC}",
            "closed gap, equal branches, mode 2": f"21.623 {SYMMETRIC}",
            "closed gap, equal branches, mode 3": f"23.411 {SYMMETRIC}",
            "closed gap, equal branches, mode 4": f"39.638 {SYMMETRIC}",
            "equation (55), hardly any creep torque, mode 1": f"21.887 {ILL}",
            "equation (55), hardly any creep torque, mode 2": f"39.160 {ILL}",
        },
    ),
    *unpublished(
        "m/s", NOT, {"speed that excites closed mode 1": "9.97 from equations (47) and (56)"}
    ),
    *unpublished(
        *("1", NOT),
        {
            "damping ratio of closed mode 1": "0.27 at K_s = 400 kgf m s, eigenvalues",
            f"{PEAK}, shaft B1": "2.491 from modal sums over 2 s",
            f"{PEAK}, spindle B2": "2.124 from modal sums over 2 s",
            f"{PEAK}, spindle B3": "2.192 from modal sums over 2 s",
            f"{PASSIVE}, shaft B1": "2.914 from modal sums over 2 s",
            f"{PASSIVE}, spindle B2": "2.082 from modal sums over 2 s",
            f"{PASSIVE}, spindle B3": "2.107 from modal sums over 2 s",
            "strip entry, equalizing over rated torque": "0.250 from modal sums",
            f"{LOWEST}, shaft B1": "-0.51 from modal sums over 2 s",
            f"{LOWEST}, spindle B2": "-0.941 from modal sums",
            f"{LOWEST}, spindle B3": "-0.943 from modal sums",
        },
    ),
    *unpublished(
        *("ms", LIMITS),
        {
            f"skidding, {what}": f"{1e3 * t:.3f} from modal sums between events"
            for what, t in zip(CHANGES, scenes.SKIDS, strict=True)
        },
    ),
    *unpublished(
        "rad/s", LIMITS, {"skidding, largest slip at 500 points": "7.764 from modal sums"}
    ),
    *unpublished(
        *("1", MOTORS),
        {
            f"{UNEQUAL} 3 %": "0.0333 from eps / (2 s)",
            f"{UNEQUAL} 1 %": "0.1000 from eps / (2 s)",
            "the same on converters, droop 3 %": "0.0333 from eps / (2 s)",
            "the same on converters, droop 1 %": "0.1000 from eps / (2 s)",
        },
    ),
)


def rows() -> list[Row]:
    """Published and computed numbers; the strip entry with motors stepping to rated torque."""
    after_break = scenes.strip_break(until=2.02, grid=40_000, rtol=1e-8)
    skids = scenes.skidding(grid=499, rtol=1e-9)
    unequal = {"eps": scenes.DIFFERENCE}
    rolling = [
        lp.equilibrium(lp.assemble(scenes.with_droop(s)), parameters=unequal) for s in (0.03, 0.01)
    ]
    opened, closed = _hertz(stand.OpenGap()), _hertz(stand.ClosedGap())
    alone = stand.LowerBranch().with_(stand.MOTOR_ONLY)
    creeping = lp.modes(lp.assemble(stand.CreepingGap()), parameters={"K_s": 400 * stand.KGF})
    entry, passive = (
        stand.strip_entry(stand.ClosedGap(), torque, until=2.0, grid=20_000, rtol=1e-8)
        for torque in (stand.RATED, 0.0)
    )
    inside = {
        f"{side}.{part}": x for side in ("upper", "lower") for part, x in stand.INSIDE.items()
    }
    rounded = _hertz(stand.OpenGap(), inside | {"upper.shaft.c": stand.C_INSIDE})
    mean = stand.J_MOTOR, stand.J_MOTOR + stand.J_GEARBOX, stand.J_MOTOR + stand.J_GEARBOX
    share = (
        stand.RATED
        * np.array(mean)
        / (stand.J_MOTOR + stand.J_GEARBOX + stand.J_BACKUP + stand.J_WORK)
    )
    computed = [
        *(opened[2], opened[0], opened[1]),
        *(rounded[2], rounded[0], rounded[1]),
        *_hertz(alone),
        opened[1] - _hertz(stand.lower_with_spindle(stand.J_SPINDLE))[0],
        *(stand.eccentricity_hertz(15), stand.eccentricity_hertz(10)),
        *closed,
        *_hertz(stand.ClosedGap(lower=alone)),
        *_hertz(stand.ClosedGap(lower=stand.UpperBranch())),
        *_hertz(stand.PrintedGap(), {"K_s": 0.01 * stand.KGF}),
        closed[0] / stand.eccentricity_hertz(1),
        creeping.damping[0],
        *(entry.table(stand.SHAFTS).max(axis=0) / stand.RATED),
        *(passive.table(stand.SHAFTS).max(axis=0) / share),
        np.abs(entry["upper.barrel.tau"] + stand.RATED).max() / stand.RATED,
        *(after_break.table(stand.SHAFTS).min(axis=0) / stand.RATED),
        *(1e3 * event.time for event in skids.events if event.component == "gap"),
        skids["gap.w_rel"].max(),
        *(point["gap.tau"] / stand.RATED for point in rolling),
        *(drives.sharing(s) for s in (0.03, 0.01)),
    ]
    return compare((*PUBLISHED, *UNPUBLISHED), computed)


def _hertz(gap: lp.Component, parameters: Mapping[str, float] | None = None) -> np.ndarray:
    return lp.modes(lp.assemble(gap), parameters=parameters).hertz


def scene(start: Mapping[str, Any] | None = None, **options: Any) -> lp.Trajectory:
    """The gap skids while all parts turn with the speed of rolling."""
    return scenes.skidding(
        start=dict.fromkeys(drives.TURNING, scenes.SPEED) | dict(start or {}), **options
    )


def give_start(system: lp.System, parameters: Mapping[str, Any] | None) -> dict[str, float]:
    """Start values of that run, which hold with changed parameters."""
    return dict.fromkeys(drives.TURNING, float(scenes.SPEED)) | dict.fromkeys(
        stand.SHAFTS, float(stand.RATED)
    )


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Natural frequencies with changed parameters."""
    found = []
    for name, gap in (("open", stand.OpenGap()), ("closed", stand.ClosedGap())):
        system = lp.assemble(gap)
        hertz = lp.modes(system, parameters=find_shared(system, parameters)).hertz
        found += number_values(f"gap {name}, natural frequency", "Hz", hertz)
    return found


MACHINE = Machine(
    "reversing_mill", ABOUT, rows, scenes.StripGap, scene, effects, short=0.4, given=give_start
)
