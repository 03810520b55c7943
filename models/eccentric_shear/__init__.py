"""Floating-shaft crank shear with elliptical gears: published numbers beside computed ones.

The machine and its source are described in `lumped.models.eccentric_shear.stand`, its motions in
`lumped.models.eccentric_shear.scenes`.

The study claims that ellipses of eccentricity 0.4 to 0.5 reduce the greatest motor torque 2.5 to 3
times and the equivalent load 1.6 to 1.7 times (figure 3, whose curves are lost in the copy
used). The half-sine of (17) gives 2.32 to 2.85 and 1.69 to 1.63. The rectangle of (18), which the
study says it used, cannot: at constant torque over 68 deg the reduction is at most 1 / sin(34 deg)
= 1.79 whatever the eccentricity. Nor can the phase of (22), (23): it puts the greatest ratio at
-26.3 deg for e = 0.4 and 9.9 deg for 0.5, not at the cut, and raises the peak.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

import lumped as lp
from lumped.models import Machine, Row
from lumped.models.about import Measure, Motor, find_shared, number_values, read_about
from lumped.models.eccentric_shear import duty, scenes, series, stand

ANGLES = "angles of the cycle [P]"
FIGURE = "figure 3 and its text [P]"
MEAN_TORQUE = "equation (17) [R]"
RIGHT = "not published [R]"
MOTOR = "not published, motor [A]"
CLAIM = "2.5 to 3 for e = 0.4 to 0.5; idle torque fitted [I]"
SHAPE = "(1 + e) / (1 - e) at the middle of the cut; idle torque fitted [I]"
CUTS = "4 cuts/min, printed beside 1.05 rad/s, but without pauses 0.419 rad/s"
LOAD = "1.6 to 1.7 for e = 0.4 to 0.5, ends in any order; idle torque fitted [I]"
SERIES = "20 harmonics do not explain the gap to the claim; idle torque fitted [I]"
CONCLUSION = "conclusions [P]"
STARTS = "not published, motor and ramp of 0.5 s [A]"
MOTORS = "J_mx is illegible; the claims fit 5.4 as well as 54 t.m2 [I]"
EVEN = "1.6 to 1.7 for e = 0.4 to 0.5; the other reading, at constant motor speed [I]"
TOO_WIDE = "impossible: at most 1.79 without inertia; a rectangle of 68 deg is too wide"
INERTIAS = (5.4e3, 51e3, 56e3)  # kg.m2  other readings of J_mx [I]
BEST = 0.564  # 1  eccentricity of the least peak
ELLIPSES, PEAKS, LOADS = (0.4, 0.5), (2.5, 3.0), (1.6, 1.7)
SLOW: dict[str, Any] = {"speed": scenes.SLOW * stand.SPEED}
WIDE: dict[str, Any] = {"pulse": "rectangle"}
EVEN_MOTOR: dict[str, Any] = {"size": "rms", "motion": scenes.MotorTurned}
NO_IDLE: dict[str, Any] = {"parameters": {"loaded.idle.tau": 0.0}}


def printed_phase(eps: float) -> float:
    """Crank angle of the greatest ratio by (22) and (23), rad; the source means `phi_max`."""
    driver = (1 + eps) / (1 - eps) * stand.CENTRE_RECTANGLE
    return float(2 * np.arctan((1 - eps) / (1 + eps) * np.tan(driver / 2)))


def rows() -> list[Row]:
    """Published and computed numbers; reductions are those against e = 0."""
    return [*_geometry(), *_reductions(), *_free(), *_idle_and_work(), *_starts()]


def _geometry() -> list[Row]:
    turns = [0, stand.MEETS, stand.CUT_BEGINS, stand.CUT_ENDS, stand.PULSE_ENDS]
    down, lift, travel, over = -1e3 * stand.ECCENTRICITY * np.diff(np.cos(turns))
    sine, (before, after, guided) = scenes.turn(scenes.CrankTurned), _at_the_change()
    mean, slab = stand.MEAN / 1e6, "slab of 200 mm; angles rounded to 5'"
    printed, half_sine = "from the printed angles", "1.3673 from a half-sine"
    geometry = "3.1388 from plane geometry"
    return [
        Row("travel while cutting", "mm", 200.0, travel, ANGLES, slab),
        Row("approach of the upper support", "mm", None, down, ANGLES, f"260.18 {printed}"),
        Row("lift before the cut", "mm", None, lift, ANGLES, f"14.87 {printed}"),
        Row("overlap of the knives", "mm", 15.0, over, ANGLES, f"{printed}, rounded to 5'"),
        Row("equivalent rectangular torque", "MN.m", None, mean, MEAN_TORQUE, half_sine),
        Row("reduced inertia, before the change", "t.m2", None, before, RIGHT, "2.8094 from (1)"),
        Row("reduced inertia, after it, as printed", "t.m2", None, after, RIGHT, "3.1170 from (4)"),
        Row("reduced inertia, after it, guided", "t.m2", None, guided, RIGHT, geometry),
        Row("greatest torque, e = 0", "kN.m", None, sine.peak / 1e3, RIGHT, "2711.7 from (20)"),
        Row("RMS torque, e = 0", "kN.m", None, sine.rms / 1e3, RIGHT, "813.4 from (20)"),
    ]


def _reductions() -> Iterator[Row]:
    motors = (
        (f"the same, motor of {J / 1e3:g} t.m2", PEAKS, MOTORS, {"parameters": {"motor.J": J}})
        for J in INERTIAS
    )
    for name, published, remark, options in (
        ("greatest torque, reduction", PEAKS, CLAIM, {}),
        ("the same, constant inertia", PEAKS, SHAPE, SLOW),
        ("the same at 0.419 rad/s", PEAKS, CUTS, {"speed": stand.FOUR_CUTS}),
        *motors,
        ("RMS torque, reduction", LOADS, LOAD, {"size": "rms"}),
        ("RMS torque, even motor, reduction", LOADS, EVEN, EVEN_MOTOR),
        ("the same without idle torque", LOADS, EVEN, EVEN_MOTOR | NO_IDLE),
        ("greatest torque, rectangle, reduction", PEAKS, TOO_WIDE, WIDE),
    ):
        for e, printed, value in zip(ELLIPSES, published, reductions(**options), strict=True):
            row = Row(f"{name}, e = {e:g}", "1", printed, value, FIGURE, remark)
            yield row._replace(fitted="fitted" in remark)
    for e, printed, value in zip(ELLIPSES, PEAKS, series.reduce_peaks(ELLIPSES), strict=True):
        name = f"greatest torque, inertia by (7), reduction, e = {e:g}"
        yield Row(name, "1", printed, value, FIGURE, SERIES, fitted=True)
    even_peak = scenes.turn(scenes.CrankTurned, **WIDE).peak
    mistaken = (
        scenes.turn(scenes.CrankTurned, e, slowest=printed_phase(e), **WIDE).peak / even_peak
        for e in ELLIPSES
    )
    name, remark = "rectangle without inertia, reduction, e = 0.5", "1.78 from (20)"
    (slow,) = reductions(ellipses=(0.5,), **WIDE, **SLOW)
    yield Row(name, "1", None, slow, RIGHT, remark)
    for e, increase in zip(ELLIPSES, mistaken, strict=True):
        name = f"rectangle, phase by (22), increase, e = {e:g}"
        yield Row(name, "1", None, increase, RIGHT, "2.33 and 2.86 from (20)")
    for name, options, remark in (
        ("greatest torque, reduction", {}, "3.00 from (20), the best"),
        ("the same, constant inertia", SLOW, "3.56 from (20), the best"),
    ):
        (best,) = reductions(ellipses=(BEST,), **options)
        yield Row(f"{name}, e = {BEST}", "1", None, best, RIGHT, remark)


def _free() -> list[Row]:
    run = scenes.free_run(rtol=1e-9, until=12.0, grid=20_000)
    twice = np.interp(4 * np.pi, run["loaded.shear.crank.phi"], run.t)
    t, tau = run.t[run.t <= twice], run["motor.tau"][run.t <= twice] / 1e3
    rms = np.sqrt(np.trapezoid(tau**2, t) / twice)
    first = next(event.time for event in run.events if event.loss)
    lost = sum(event.loss for event in run.events if event.time == first) / 1e3
    kept, momentum = scenes.compare_speeds(run)[0], "0.95265 from momentum"
    printed, guided = (
        scenes.landing(scenes.free_run(0.5, shear=shear, rtol=1e-9, grid=40_000))
        for shear in (stand.PrintedShear, stand.GuidedShear)
    )
    over_cut, above = "free run, e = 0.5, landing over cutting torque", "above 1 by the impacts"
    other, reading = "the same, supports in the guides of the frame", "the other reading"
    by_hand = "{} by DOP853 on (19)".format
    return [
        Row("free run, time of two turns", "s", None, twice, MOTOR, by_hand("11.982149")),
        Row("free run, greatest motor torque", "kN.m", None, tau.max(), MOTOR, by_hand("2739.2")),
        Row("free run, RMS motor torque", "kN.m", None, rms, MOTOR, by_hand("880.1")),
        Row("free run, speed kept where the pin lands", "1", None, kept, MOTOR, momentum),
        Row("free run, energy lost there", "kJ", None, lost, MOTOR, "2.7386 from momentum"),
        Row(over_cut, "1", None, printed, MOTOR, above),
        Row(other, "1", None, guided, MOTOR, reading),
    ]


def _idle_and_work() -> Iterator[Row]:
    """Shares of a turn at constant motor speed, and what the motor feels while idle."""
    shares = {e: duty.working_share(e) for e in (0.0, *ELLIPSES)}
    closed = "{:.2f} by 2/pi arctan((1 + e)/(1 - e) tan(a/4)), cut a = 58 deg 25 min".format
    for (e, share), by_hand in zip(shares.items(), (16.23, 34.78, 42.24), strict=True):
        name = f"even motor, share of the cut in a turn, e = {e:g}"
        yield Row(name, "%", None, 100 * share, RIGHT, closed(by_hand))
    for e in ELLIPSES:
        longer, shorter = shares[e] / shares[0.0], (1 - shares[e]) / (1 - shares[0.0])
        ratio = f"2 to 3 times the ratio, {(1 + e) / (1 - e):.2f} at its greatest"
        name = f"even motor, working time over that of circles, e = {e:g}"
        mean = f"{ratio}; in proportion to its mean over the cut"
        yield Row(name, "1", None, longer, CONCLUSION, mean, bounds=(2.0, 3.0))
        name = f"even motor, idle time over that of circles, e = {e:g}"
        yield Row(name, "1", None, shorter, RIGHT, "falls, but not 2 to 3 times")
    for e in (0.0, *ELLIPSES):
        name = f"greatest motor torque while idle, e = {e:g}"
        remark = "idle torque over the ratio; its changes are called not large"
        yield Row(name, "kN.m", None, duty.idle_peak(e) / 1e3, RIGHT, remark)


def _starts() -> Iterator[Row]:
    """Start and stop in idle periods, which the ellipses hardly influence by the conclusions."""
    load, bare = "the idle torque, over a ratio below 1", "by the inertia alone"
    sizes = (
        ("time", "s", "as wanted", "time", 1.0),
        ("greatest motor torque", "kN.m", load, "peak", 1e3),
        ("work of the motor", "kJ", load, "work", 1e3),
    )
    without = (("greatest torque without idle torque", "kN.m", bare, "peak", 1e3),)
    for torque, wanted in ((stand.IDLE, sizes), (0.0, without)):
        runs = {e: duty.split_turn(duty.start_stop(e, torque)) for e in (0.0, ELLIPSES[1])}
        for i, phase in enumerate(("start", "stop")):
            for quantity, unit, remark, field, scale in wanted:
                for e, found in runs.items():
                    name = f"{phase}, {quantity}, e = {e:g}"
                    value = getattr(found[i], field) / scale
                    yield Row(name, unit, None, value, STARTS, remark)


def reductions(
    size: str = "peak",
    ellipses: Sequence[float] = ELLIPSES,
    motion: type[scenes.CrankTurned] = scenes.CrankTurned,
    **options: Any,
) -> list[float]:
    """Motor torque of circles over that of ellipses.

    Parameters
    ----------
    size : {"peak", "rms"}
        Peak or root mean square of the torque.
    ellipses : sequence of float
        Eccentricities.
    motion : CrankTurned or MotorTurned
        Whether crank or motor turns at constant speed.
    **options
        Passed to `lumped.models.eccentric_shear.scenes.turn`.
    """
    sizes = [float(getattr(scenes.turn(motion, e, **options), size)) for e in (0.0, *ellipses)]
    return [sizes[0] / x for x in sizes[1:]]


def _at_the_change() -> Iterator[float]:
    """Reduced inertia before the pin lands, and after it by both readings, t.m2."""
    for shear, sides in ((stand.PrintedShear, (0, -1)), (stand.GuidedShear, (-1,))):
        run = scenes.inertia(shear)
        first = next(event.time for event in run.events if event.component.endswith("switch"))
        at = np.flatnonzero(run.t == first)
        for side in sides:
            yield float((scenes.motions(run, shear)[at[side]] ** 2).sum() / 1e3)


def effects(run: lp.Trajectory, parameters: Mapping[str, Any] | None) -> list[Measure]:
    """Torque at constant crank speed, and what impacts leave, with changed parameters."""
    demand = scenes.turn(
        scenes.CrankTurned, parameters=find_shared(lp.assemble(scenes.CrankTurned()), parameters)
    )
    return [
        Measure("constant crank speed, greatest motor torque", "N.m", demand.peak),
        Measure("constant crank speed, RMS motor torque", "N.m", demand.rms),
        *number_values("speed of the crank kept at impact", "1", scenes.compare_speeds(run)),
    ]


ABOUT = read_about(
    "eccentric_shear",
    until=12.0,
    watched={
        "motor torque": "motor.tau",
        "speed of the motor": "motor.w",
        "speed of the crank": "loaded.shear.shaft.body.w",
        "current of the motor": "motor.i",
    },
    motors=(Motor("motor", "motor.tau", "motor.w"),),
)
MACHINE = Machine(
    *("eccentric_shear", ABOUT, rows, scenes.FreeShear, scenes.free_run, effects),
    short=6.0,
    given=lambda system, parameters: scenes.upright(stand.PrintedShear),
    grid=8000,
)
