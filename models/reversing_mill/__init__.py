"""Reversing cold rolling mill 400: published numbers beside computed ones.

The stand and its source are described in `lumped.models.reversing_mill.stand`, the roll gap that
sticks, skids and opens in `scenes` beside it, its motors in `drives`, the mass of its shafts in
`shaft_mass`, the torque between its branches in `equalizing`, the incoming strip in `incoming`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row, list_rows
from lumped.models.about import Measure, Motor, find_shared, number_values, read_about
from lumped.models.reversing_mill import drives, equalizing, incoming, scenes, shaft_mass, stand

PAGES, LOWER = "pages 71, 72, before (47) [P]", "page 71, by equation (46) [P]"
ECCENTRICITY = "page 72, after (47) [P]"
ROUNDING = "within the rounding of the printed J and C"
INFERRED = "J and C chosen that round to the printed ones [I]; rounds to the printed digits"
ALONE = "J2 as (46) words it; then no rounding gives all three frequencies at once"
TENTH = "page 72, by equation (45) [P]"
THIN = "inertia of 0.0026 kgf m s2 [I], chosen to stay just below; the dimensions are not given"
BARS = "the same spindle, shaft B1 of 0.023 kgf m s2 [A]; thirds by the nodes of this mode [R]"
CUT = "print cut off, if the diameter is exactly 0.5 m [I]"
DIAMETER = "fixes the diameter, not legible [I]"
NOT = "not published [R]"
BARS_NOT = "not published, inertias of the shafts [A]"
BELOW = (None, 0.1)
CURVES = "not published, slope of the curves of (55) [A]"
STRIP = "not published, incoming strip [A]"
LIMITS = "not published, limits [A]"
MOTORS = "not published, motors [A]"
CLOSED = {
    "closed gap, mode 1": "6.34431 from the roots of equation (56)",
    "closed gap, mode 2": "22.50599 from the roots of equation (56)",
    "closed gap, mode 3": "39.17282 from the roots of equation (56)",
    "closed gap, motor alone, mode 1": "7.500 from equation (56)",
    "closed gap, motor alone, mode 2": "22.556 from equation (56)",
    "closed gap, motor alone, mode 3": "39.382 from equation (56)",
}
SYMMETRIC = "by eigenvalues; two of them are those of the open branch"
EQUAL = (6.179, 21.623, 23.411, 39.638)
ILL = "by eigenvalues; not those of the open gap"
SHAFTS = ("shaft B1", "spindle B2", "spindle B3")
PEAKS = {
    "strip entry, peak over mean torque": (2.491, 2.124, 2.192),
    "motors unchanged, peak over mean torque": (2.914, 2.082, 2.107),
}
LOWEST = ("-0.51 from modal sums over 2 s", "-0.941 from modal sums", "-0.943 from modal sums")
CHANGES = ("first skid", "first stick", "second skid", "second stick")
GREATEST = drives.OVERLOAD * stand.RATED
SPLITS = {
    "node of spindle B3, from the rolls over its length": "0.9715 from (45), 5.46 / 5.6201",
    "upper f1, node of shaft B1 from the motor": "0.1403 from the roots of the chain",
    "upper f1, node of spindle B2 from the gearbox": "0.0756 from the roots of the chain",
    "upper f2, node of shaft B1 from the motor": "0.4716 from the roots of the chain",
}
EXACT = {
    "upper f1, shafts with mass": "39.543 from the exact equation of continuous shafts",
    "upper f2, shafts with mass": "21.600 from the exact equation of continuous shafts",
}
ENTERS = {
    "strip entry, equalizing by (55), 140 rad/s": "0.155 by matrix exponentials",
    "strip entry, equalizing by (55), 93.3 rad/s": "0.166 by matrix exponentials",
    "strip entry, equalizing by (54), (55) as printed": "0.150 by matrix exponentials",
}
CREEPS = {
    "rolls 0.2 % apart, equalizing by (55), droop 3 %": "0.0235 in closed form; 0.0333 no slip",
    "rolls 0.2 % apart, equalizing by (55), droop 1 %": "0.0444 in closed form; 0.1000 no slip",
}
WAVES = {
    "waves of the incoming strip at 15 m/s": "6.6845 from 0.7 times (47)",
    "waves of the incoming strip at 10 m/s": "4.4563 from 0.7 times (47)",
}
SWINGS = {
    stand.ClosedGap: ("no slip", ("0.2702", "0.4455", "1.5590")),
    stand.CreepingGap: ("K_s = 300 kgf m s", ("0.6044", "0.9967", "1.0161")),
}
DROOPS = {0.03: "0.0333 from eps / (2 s)", 0.01: "0.1000 from eps / (2 s)"}


def rows() -> list[Row]:
    """Published and computed numbers; the strip entry with motors stepping to rated torque."""
    return [
        *(*_published(), *_shafts(), *_closed(), *_entry(), *_skids(), *_droop()),
        *(*_approaches(), *_incoming()),
    ]


def _published() -> list[Row]:
    opened = _hertz(stand.OpenGap())
    inside = {
        f"{side}.{part}": x for side in ("upper", "lower") for part, x in stand.INSIDE.items()
    }
    rounded = _hertz(stand.OpenGap(), inside | {"upper.shaft.c": stand.C_INSIDE})
    inner = "J and C inside their rounding"
    spindle = opened[1] - _hertz(shaft_mass.lower_with_spindle())[0]
    alone = _hertz(stand.LowerBranch().with_(stand.MOTOR_ONLY))[0]
    fast, slow = (stand.eccentricity_hertz(speed) for speed in (15, 10))
    return [
        Row("upper branch, gap open, f1", "Hz", 39.8, opened[2], PAGES, ROUNDING),
        Row("upper branch, gap open, f2", "Hz", 21.7, opened[0], PAGES, ROUNDING),
        Row("lower branch, gap open", "Hz", 38.9, opened[1], LOWER, ROUNDING),
        Row(f"upper f1, {inner}", "Hz", 39.8, rounded[2], PAGES, INFERRED, fitted=True),
        Row(f"upper f2, {inner}", "Hz", 21.7, rounded[0], PAGES, INFERRED, fitted=True),
        Row(f"lower f, {inner}", "Hz", 38.9, rounded[1], LOWER, INFERRED, fitted=True),
        Row("lower branch, motor alone", "Hz", 38.9, alone, LOWER, ALONE),
        Row(
            *("influence of the mass of a spindle", "Hz", None, spindle),
            *(TENTH, THIN, BELOW, True),
        ),
        Row("eccentricity at 15 m/s", "Hz", 9.55, fast, ECCENTRICITY, DIAMETER, fitted=True),
        Row("eccentricity at 10 m/s", "Hz", 6.36, slow, ECCENTRICITY, CUT),
    ]


def _shafts() -> list[Row]:
    opened = _hertz(stand.UpperBranch())[::-1]
    heavy = [_hertz(shaft_mass.upper_with_shafts(mode))[mode] for mode in (1, 0)]
    ends, _ = shaft_mass.thirds(
        1.0, stand.J_MOTOR + stand.J_GEARBOX, -stand.J_BACKUP - stand.J_WORK
    )
    at = (3 * ends, *shaft_mass.nodes(1), shaft_mass.nodes(0)[0])
    return [
        *(
            Row(f"influence of both shafts, upper {name}", "Hz", None, a - b, TENTH, BARS, BELOW)
            for name, a, b in zip(("f1", "f2"), opened, heavy, strict=True)
        ),
        *list_rows("1", NOT, SPLITS, at),
        *list_rows("Hz", BARS_NOT, EXACT, heavy),
    ]


def _closed() -> list[Row]:
    closed = _hertz(stand.ClosedGap())
    alone = stand.ClosedGap(lower=stand.LowerBranch().with_(stand.MOTOR_ONLY))
    equal = {
        f"closed gap, equal branches, mode {i}": f"{hertz} {SYMMETRIC}"
        for i, hertz in enumerate(EQUAL, 1)
    }
    hardly = {
        f"equation (55), hardly any creep torque, mode {i}": f"{hertz} {ILL}"
        for i, hertz in ((1, "21.887"), (2, "39.160"))
    }
    values = (
        *(*closed, *_hertz(alone), *_hertz(stand.ClosedGap(lower=stand.UpperBranch()))),
        *_hertz(stand.PrintedGap(), {"K_s": 0.01 * stand.KGF}),
    )
    creeping = lp.modes(lp.assemble(stand.CreepingGap()), parameters={"K_s": 400 * stand.KGF})
    speed = {"speed that excites closed mode 1": "9.97 from equations (47) and (56)"}
    ratio = {"damping ratio of closed mode 1": "0.27 at K_s = 400 kgf m s, eigenvalues"}
    return [
        *list_rows("Hz", NOT, CLOSED | equal | hardly, values),
        *list_rows("m/s", NOT, speed, [closed[0] / stand.eccentricity_hertz(1)]),
        *list_rows("1", NOT, ratio, creeping.damping[:1]),
    ]


def _entry() -> Iterator[Row]:
    motor, drive = stand.J_MOTOR, stand.J_MOTOR + stand.J_GEARBOX
    share = np.array([motor, drive, drive]) / (drive + stand.J_BACKUP + stand.J_WORK)
    means = (np.ones(3), share)
    runs = [
        stand.strip_entry(stand.ClosedGap(), torque, until=2.0, grid=20_000, rtol=1e-8)
        for torque in (stand.RATED, 0.0)
    ]
    for run, mean, (text, known) in zip(runs, means, PEAKS.items(), strict=True):
        remarks = {
            f"{text}, {shaft}": f"{peak} from modal sums over 2 s"
            for shaft, peak in zip(SHAFTS, known, strict=True)
        }
        peaks = run.table(stand.SHAFTS).max(axis=0) / (stand.RATED * mean)
        yield from list_rows("1", NOT, remarks, peaks)
    barrel = np.abs(runs[0]["upper.barrel.tau"] + stand.RATED).max() / stand.RATED
    text = "strip entry, equalizing over rated torque"
    yield Row(text, "1", None, float(barrel), NOT, "0.250 from modal sums")
    after_break = scenes.strip_break(until=2.02, grid=40_000, rtol=1e-8)
    texts = (f"strip break, lowest over rated torque, {shaft}" for shaft in SHAFTS)
    least = after_break.table(stand.SHAFTS).min(axis=0) / stand.RATED
    yield from list_rows("1", NOT, dict(zip(texts, LOWEST, strict=True)), least)


def _skids() -> list[Row]:
    run = scenes.skidding(grid=499, rtol=1e-9)
    remarks = {
        f"skidding, {what}": f"{1e3 * t:.3f} from modal sums between events"
        for what, t in zip(CHANGES, scenes.SKIDS, strict=True)
    }
    times = (1e3 * event.time for event in run.events if event.component == "gap")
    slip = {"skidding, largest slip at 500 points": "7.764 from modal sums"}
    return [
        *list_rows("ms", LIMITS, remarks, times),
        *list_rows("rad/s", LIMITS, slip, [run["gap.w_rel"].max()]),
    ]


def _droop() -> Iterator[Row]:
    unequal = {"eps": scenes.DIFFERENCE}
    for s, remark in DROOPS.items():
        text = f"equalizing over rated torque, rolls 0.2 % apart, droop {100 * s:g} %"
        rolling = lp.equilibrium(lp.assemble(scenes.with_droop(s)), parameters=unequal)
        yield Row(text, "1", None, float(rolling["gap.tau"] / stand.RATED), MOTORS, remark)
    for s, remark in DROOPS.items():
        text = f"the same on converters, droop {100 * s:g} %"
        yield Row(text, "1", None, drives.sharing(s), MOTORS, remark)


def _hertz(gap: lp.Component, parameters: Mapping[str, float] | None = None) -> np.ndarray:
    return lp.modes(lp.assemble(gap), parameters=parameters).hertz


def _approaches() -> list[Row]:
    fast, slow = (equalizing.creep_coefficient(w) for w in (scenes.SPEED, scenes.SPEED / 1.5))
    gaps = (stand.CreepingGap(K_s=fast), stand.CreepingGap(K_s=slow), stand.PrintedGap(K_s=fast))
    static = (equalizing.creeping_with_droop(s, fast) for s in DROOPS)
    return [
        *list_rows("1", CURVES, ENTERS, (equalizing.peak_at_entry(gap) for gap in gaps)),
        *list_rows("1", CURVES, CREEPS, static),
    ]


def _incoming() -> Iterator[Row]:
    waves = [incoming.thickness_hertz(speed) for speed in (15, 10)]
    yield from list_rows("Hz", STRIP, WAVES, waves)
    speed = {"strip speed at which they excite closed mode 1": "14.24 from 9.97 over 0.7"}
    critical = _hertz(stand.ClosedGap())[0] / incoming.thickness_hertz(1)
    yield from list_rows("m/s", STRIP, speed, [critical])
    for gap, (how, known) in SWINGS.items():
        remarks = {
            f"waves at 15 m/s, {how}, {shaft} over rolls": f"{gain} from complex amplitudes"
            for shaft, gain in zip(SHAFTS, known, strict=True)
        }
        gains = np.abs(incoming.thickness_gains(gap(), np.array([15.0]), 1.0)[0])
        yield from list_rows("1", STRIP, remarks, gains)


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


ABOUT = read_about(
    "reversing_mill",
    until=0.4,
    varied=("M_pr",),
    watched={
        "torque of the long shaft B1": "upper.shaft.tau",
        "torque of the upper spindle": "upper.spindle.tau",
        "torque of the lower spindle": "lower.spindle.tau",
        "torque through the gap": "gap.tau",
        "slip of the rolls": "gap.w_rel",
    },
    motors=tuple(
        Motor(f"{side} motor", f"{side}.drive.tau", f"{side}.motor.w", stand.RATED, GREATEST)
        for side in ("upper", "lower")
    ),
)
MACHINE = Machine(
    "reversing_mill", ABOUT, rows, scenes.StripGap, scene, effects, short=0.4, given=give_start
)
