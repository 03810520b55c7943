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
from lumped.models import Machine, Row
from lumped.models.about import Measure, numbered, shared
from lumped.models.reversing_mill.about import ABOUT
from lumped.models.reversing_mill.drives import (
    TURNING,
    sharing,
)
from lumped.models.reversing_mill.scenes import (
    DIFFERENCE,
    SKIDS,
    SPEED,
    StripGap,
    skidding,
    strip_break,
    with_droop,
)
from lumped.models.reversing_mill.stand import (
    C_INSIDE,
    INSIDE,
    J_BACKUP,
    J_GEARBOX,
    J_MOTOR,
    J_SPINDLE,
    J_WORK,
    KGF,
    MOTOR_ONLY,
    RATED,
    SHAFTS,
    ClosedGap,
    CreepingGap,
    LowerBranch,
    OpenGap,
    PrintedGap,
    UpperBranch,
    eccentricity_hertz,
    lower_with_spindle,
    strip_entry,
)

ROUNDING = "within the rounding of the printed J and C"
INFERRED = "J and C chosen that round to the printed ones [I]; rounds to the printed digits"
ALONE = "J2 without gearbox [I]; then no rounding gives all three frequencies at once"
PUBLISHED: tuple[tuple[Any, ...], ...] = (  # quantity, unit, value, place, remark, bounds, fitted
    ("upper branch, gap open, f1", "Hz", 39.8, "equations (48) to (51) [P]", ROUNDING),
    ("upper branch, gap open, f2", "Hz", 21.7, "equations (48) to (51) [P]", ROUNDING),
    ("lower branch, gap open", "Hz", 38.9, "equation (46) [P]", ROUNDING),
    *(
        (f"{name}, J and C inside their rounding", "Hz", value, place, INFERRED, None, True)
        for name, value, place in (
            ("upper f1", 39.8, "equations (48) to (51) [P]"),
            ("upper f2", 21.7, "equations (48) to (51) [P]"),
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
        "fixes the lost diameter [I]",
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
UNPUBLISHED = (  # quantity, unit, None, place, reference and its origin
    *(
        (f"closed gap, mode {i}", "Hz", None, NOT, f"{f} from the roots of equation (56)")
        for i, f in enumerate(("6.34431", "22.50599", "39.17282"), 1)
    ),
    *(
        (f"closed gap, motor alone, mode {i}", "Hz", None, NOT, f"{f} from equation (56)")
        for i, f in enumerate(("7.500", "22.556", "39.382"), 1)
    ),
    *(
        (
            f"closed gap, equal branches, mode {i}",
            "Hz",
            None,
            NOT,
            f"{f} {SYMMETRIC}",
        )
        for i, f in enumerate(("6.179", "21.623", "23.411", "39.638"), 1)
    ),
    *(
        (
            f"equation (55), hardly any creep torque, mode {i}",
            "Hz",
            None,
            NOT,
            f"{f} {ILL}",
        )
        for i, f in enumerate(("21.887", "39.160"), 1)
    ),
    ("speed that excites closed mode 1", "m/s", None, NOT, "9.97 from equations (47) and (56)"),
    ("damping ratio of closed mode 1", "1", None, NOT, "0.27 at K_s = 400 kgf m s, eigenvalues"),
    (
        "strip entry, peak over mean torque, shaft B1",
        "1",
        None,
        NOT,
        "2.491 from modal sums over 2 s",
    ),
    (
        "strip entry, peak over mean torque, spindle B2",
        "1",
        None,
        NOT,
        "2.124 from modal sums over 2 s",
    ),
    (
        "strip entry, peak over mean torque, spindle B3",
        "1",
        None,
        NOT,
        "2.192 from modal sums over 2 s",
    ),
    (
        "motors unchanged, peak over mean torque, shaft B1",
        "1",
        None,
        NOT,
        "2.914 from modal sums over 2 s",
    ),
    (
        "motors unchanged, peak over mean torque, spindle B2",
        "1",
        None,
        NOT,
        "2.082 from modal sums over 2 s",
    ),
    (
        "motors unchanged, peak over mean torque, spindle B3",
        "1",
        None,
        NOT,
        "2.107 from modal sums over 2 s",
    ),
    ("strip entry, equalizing over rated torque", "1", None, NOT, "0.250 from modal sums"),
    (
        "strip break, lowest over rated torque, shaft B1",
        "1",
        None,
        NOT,
        "-0.51 from modal sums over 2 s",
    ),
    ("strip break, lowest over rated torque, spindle B2", "1", None, NOT, "-0.941 from modal sums"),
    ("strip break, lowest over rated torque, spindle B3", "1", None, NOT, "-0.943 from modal sums"),
    *(
        (f"skidding, {what}", "ms", None, LIMITS, f"{1e3 * t:.3f} from modal sums between events")
        for what, t in zip(CHANGES, SKIDS, strict=True)
    ),
    ("skidding, largest slip at 500 points", "rad/s", None, LIMITS, "7.764 from modal sums"),
    (
        "equalizing over rated torque, rolls 0.2 % apart, droop 3 %",
        "1",
        None,
        MOTORS,
        "0.0333 from eps / (2 s)",
    ),
    (
        "equalizing over rated torque, rolls 0.2 % apart, droop 1 %",
        "1",
        None,
        MOTORS,
        "0.1000 from eps / (2 s)",
    ),
    ("the same on converters, droop 3 %", "1", None, MOTORS, "0.0333 from eps / (2 s)"),
    ("the same on converters, droop 1 %", "1", None, MOTORS, "0.1000 from eps / (2 s)"),
)


def rows() -> list[Row]:
    """Published and computed numbers; the strip entry with motors stepping to rated torque."""
    after_break = strip_break(until=2.02, grid=40_000, rtol=1e-8)
    skids = skidding(grid=499, rtol=1e-9)
    unequal = {"eps": DIFFERENCE}
    rolling = [lp.equilibrium(lp.assemble(with_droop(s)), parameters=unequal) for s in (0.03, 0.01)]
    opened, closed = _hertz(OpenGap()), _hertz(ClosedGap())
    alone = LowerBranch().with_(MOTOR_ONLY)
    creeping = lp.modes(lp.assemble(CreepingGap()), parameters={"K_s": 400 * KGF})
    entry, passive = (
        strip_entry(ClosedGap(), torque, until=2.0, grid=20_000, rtol=1e-8)
        for torque in (RATED, 0.0)
    )
    inside = {f"{side}.{part}": x for side in ("upper", "lower") for part, x in INSIDE.items()}
    rounded = _hertz(OpenGap(), inside | {"upper.shaft.c": C_INSIDE})
    mean = J_MOTOR, J_MOTOR + J_GEARBOX, J_MOTOR + J_GEARBOX
    share = RATED * np.array(mean) / (J_MOTOR + J_GEARBOX + J_BACKUP + J_WORK)
    computed = [
        *(opened[2], opened[0], opened[1]),
        *(rounded[2], rounded[0], rounded[1]),
        *_hertz(alone),
        opened[1] - _hertz(lower_with_spindle(J_SPINDLE))[0],
        *(eccentricity_hertz(15), eccentricity_hertz(10)),
        *closed,
        *_hertz(ClosedGap(lower=alone)),
        *_hertz(ClosedGap(lower=UpperBranch())),
        *_hertz(PrintedGap(), {"K_s": 0.01 * KGF}),
        closed[0] / eccentricity_hertz(1),
        creeping.damping[0],
        *(entry.table(SHAFTS).max(axis=0) / RATED),
        *(passive.table(SHAFTS).max(axis=0) / share),
        np.abs(entry["upper.barrel.tau"] + RATED).max() / RATED,
        *(after_break.table(SHAFTS).min(axis=0) / RATED),
        *(1e3 * event.time for event in skids.events if event.component == "gap"),
        skids["gap.w_rel"].max(),
        *(point["gap.tau"] / RATED for point in rolling),
        *(sharing(s) for s in (0.03, 0.01)),
    ]
    return [
        Row(quantity, unit, value, float(found), *rest)
        for (quantity, unit, value, *rest), found in zip(
            (*PUBLISHED, *UNPUBLISHED), computed, strict=True
        )
    ]


def _hertz(gap: lp.Component, parameters: Mapping[str, float] | None = None) -> np.ndarray:
    return lp.modes(lp.assemble(gap), parameters=parameters).hertz


def scene(start: Mapping[str, Any] | None = None, **options: Any) -> lp.Trajectory:
    """The gap skids while all parts turn with the speed of rolling."""
    return skidding(start=dict.fromkeys(TURNING, SPEED) | dict(start or {}), **options)


def given(system: lp.System, parameters: Mapping[str, Any] | None) -> dict[str, float]:
    """Start values of that run, which hold with changed parameters."""
    return dict.fromkeys(TURNING, float(SPEED)) | dict.fromkeys(SHAFTS, float(RATED))


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Natural frequencies with changed parameters."""
    found = []
    for name, gap in (("open", OpenGap()), ("closed", ClosedGap())):
        system = lp.assemble(gap)
        hertz = lp.modes(system, parameters=shared(system, parameters)).hertz
        found += numbered(f"gap {name}, natural frequency", "Hz", hertz)
    return found


MACHINE = Machine("reversing_mill", ABOUT, rows, StripGap, scene, effects, short=0.4, given=given)
