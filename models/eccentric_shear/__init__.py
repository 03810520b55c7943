"""Floating-shaft crank shear with elliptical gears: published numbers beside computed ones.

The machine and its source are described in `lumped.models.eccentric_shear.stand`, its motions in
`lumped.models.eccentric_shear.scenes`.

The study claims that ellipses of eccentricity 0.4 to 0.5 reduce the greatest motor torque 2.5 to 3
times and the equivalent load 1.6 to 1.7 times (figure 3, whose values are damaged in the copy
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
from lumped.models import Machine, Row, compare
from lumped.models.about import Measure, find_shared, number_values
from lumped.models.eccentric_shear import scenes, stand
from lumped.models.eccentric_shear.about import ABOUT

ANGLES = "angles of the cycle [P]"
FIGURE = "figure 3 and its text [P]"
MEAN_TORQUE = "equation (17) [R]"
RIGHT = "not published [R]"
MOTOR = "not published, motor [A]"
CLAIM = "2.5 to 3 for e = 0.4 to 0.5; idle torque fitted [I]"
SHAPE = "(1 + e) / (1 - e) at the middle of the cut; idle torque fitted [I]"
CUTS = "4 cuts/min, printed beside 1.05 rad/s, but without pauses 0.419 rad/s"
LOAD = "1.6 to 1.7 for e = 0.4 to 0.5, ends in any order; idle torque fitted [I]"
MOTORS = "J_mx is illegible; the claims fit 5.4 as well as 54 t.m2 [I]"
EVEN = "1.6 to 1.7 for e = 0.4 to 0.5; the other reading, at constant motor speed [I]"
READINGS = (stand.PrintedShear, stand.GuidedShear)
TOO_WIDE = "impossible: at most 1.79 without inertia; a rectangle of 68 deg is too wide"
INERTIAS = (5.4e3, 51e3, 56e3)  # kg.m2  other readings of J_mx [I]
BEST = 0.564  # 1  eccentricity of the least peak
ELLIPSES = (0.4, 0.5)


def _pair(quantity: str, published: tuple[float, ...] | None, *place: Any) -> list[tuple[Any, ...]]:
    """Titles of a reduction for the eccentricities 0.4 and 0.5."""
    values = published or (None, None)
    return [
        (f"{quantity}, e = {e:g}", "1", value, *place)
        for e, value in zip(ELLIPSES, values, strict=True)
    ]


PEAKS, LOADS = (2.5, 3.0), (1.6, 1.7)
TITLES = (  # quantity, unit, published, place, remark, bounds, fitted
    ("travel while cutting", "mm", 200.0, ANGLES, "slab of 200 mm; angles rounded to 5'"),
    ("approach of the upper support", "mm", None, ANGLES, "260.18 from the printed angles"),
    ("lift before the cut", "mm", None, ANGLES, "14.87 from the printed angles"),
    ("overlap of the knives", "mm", 15.0, ANGLES, "from the printed angles, rounded to 5'"),
    ("equivalent rectangular torque", "MN.m", None, MEAN_TORQUE, "1.3673 from a half-sine"),
    ("reduced inertia, before the change", "t.m2", None, RIGHT, "2.8094 from (1)"),
    ("reduced inertia, after it, as printed", "t.m2", None, RIGHT, "3.1170 from (4)"),
    ("reduced inertia, after it, guided", "t.m2", None, RIGHT, "3.1388 from plane geometry"),
    ("greatest torque, e = 0", "kN.m", None, RIGHT, "2711.7 from (20)"),
    ("RMS torque, e = 0", "kN.m", None, RIGHT, "813.4 from (20)"),
    *_pair("greatest torque, reduction", PEAKS, FIGURE, CLAIM, None, True),
    *_pair("the same, constant inertia", PEAKS, FIGURE, SHAPE, None, True),
    *_pair("the same at 0.419 rad/s", PEAKS, FIGURE, CUTS),
    *(
        title
        for J in INERTIAS
        for title in _pair(f"the same, motor of {J / 1e3:g} t.m2", PEAKS, FIGURE, MOTORS)
    ),
    *_pair("RMS torque, reduction", LOADS, FIGURE, LOAD, None, True),
    *_pair("RMS torque, even motor, reduction", LOADS, FIGURE, EVEN),
    *_pair("the same without idle torque", LOADS, FIGURE, EVEN),
    *_pair("greatest torque, rectangle, reduction", PEAKS, FIGURE, TOO_WIDE),
    ("rectangle without inertia, reduction, e = 0.5", "1", None, RIGHT, "1.78 from (20)"),
    *_pair("rectangle, phase by (22), increase", None, RIGHT, "2.33 and 2.86 from (20)"),
    (f"greatest torque, reduction, e = {BEST}", "1", None, RIGHT, "3.00 from (20), the best"),
    (f"the same, constant inertia, e = {BEST}", "1", None, RIGHT, "3.56 from (20), the best"),
    ("free run, time of two turns", "s", None, MOTOR, "11.982149 by DOP853 on (19)"),
    ("free run, greatest motor torque", "kN.m", None, MOTOR, "2739.2 by DOP853 on (19)"),
    ("free run, RMS motor torque", "kN.m", None, MOTOR, "880.1 by DOP853 on (19)"),
    ("free run, speed kept where the pin lands", "1", None, MOTOR, "0.95265 from momentum"),
    ("free run, energy lost there", "kJ", None, MOTOR, "2.7386 from momentum"),
    ("free run, e = 0.5, landing over cutting torque", "1", None, MOTOR, "above 1 by the impacts"),
    ("the same, supports in the guides of the frame", "1", None, MOTOR, "the other reading"),
)


def printed_phase(eps: float) -> float:
    """Crank angle of the greatest ratio by (22) and (23), rad; the source means `phi_max`."""
    driver = (1 + eps) / (1 - eps) * stand.CENTRE_RECTANGLE
    return float(2 * np.arctan((1 - eps) / (1 + eps) * np.tan(driver / 2)))


def rows() -> list[Row]:
    """Published and computed numbers; reductions are those against e = 0."""
    lift = (
        -1e3
        * stand.ECCENTRICITY
        * np.diff(np.cos([0, stand.MEETS, stand.CUT_BEGINS, stand.CUT_ENDS, stand.PULSE_ENDS]))
    )
    sine = scenes.turn(scenes.CrankTurned)
    even = scenes.free_run(rtol=1e-9, until=12.0, grid=20_000)
    twice = np.interp(4 * np.pi, even["loaded.shear.crank.phi"], even.t)
    tau = even["motor.tau"][even.t <= twice]
    first = next(event.time for event in even.events if event.loss)
    elliptical = [scenes.free_run(0.5, shear=shear, rtol=1e-9, grid=40_000) for shear in READINGS]
    slow: dict[str, Any] = {"speed": scenes.SLOW * stand.SPEED}
    wide: dict[str, Any] = {"pulse": "rectangle"}
    mistaken = [
        scenes.turn(scenes.CrankTurned, e, slowest=printed_phase(e), **wide).peak
        / scenes.turn(scenes.CrankTurned, **wide).peak
        for e in ELLIPSES
    ]
    computed = [
        *lift[[2, 0, 1, 3]],
        stand.MEAN / 1e6,
        *_at_the_change(),
        *(sine.peak / 1e3, sine.rms / 1e3),
        *reductions(),
        *reductions(**slow),
        *reductions(speed=stand.FOUR_CUTS),
        *(x for J in INERTIAS for x in reductions(parameters={"motor.J": J})),
        *reductions("rms"),
        *reductions("rms", motion=scenes.MotorTurned),
        *reductions("rms", motion=scenes.MotorTurned, parameters={"loaded.idle.tau": 0.0}),
        *reductions(**wide),
        *reductions(ellipses=(0.5,), **wide, **slow),
        *mistaken,
        *reductions(ellipses=(BEST,)),
        *reductions(ellipses=(BEST,), **slow),
        *(twice, tau.max() / 1e3),
        np.sqrt(np.trapezoid(tau**2, even.t[even.t <= twice]) / twice) / 1e3,
        *(
            scenes.compare_speeds(even)[0],
            sum(e.loss for e in even.events if e.time == first) / 1e3,
        ),
        *map(scenes.landing, elliptical),
    ]
    return compare(TITLES, computed)


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


MACHINE = Machine(
    *("eccentric_shear", ABOUT, rows, scenes.FreeShear, scenes.free_run, effects),
    short=6.0,
    given=lambda system, parameters: scenes.upright(stand.PrintedShear),
    grid=8000,
)
