"""Floating-shaft crank shear with elliptical gears: published numbers beside computed ones.

The machine and its source are described in `lumped.models.eccentric_shear_stand`, its motions in
`lumped.models.eccentric_shear_scenes`.

The study claims that ellipses of eccentricity 0.4 to 0.5 reduce the greatest motor torque 2.5 to 3
times and the equivalent load 1.6 to 1.7 times (figure 3, whose values are lost). The half-sine of
(17) reproduces both. The rectangle of (18), with which the study says it computed, cannot: at
constant torque over 68 deg the reduction is at most 1 / sin(34 deg) = 1.79 whatever the
eccentricity. Nor can the phase of (22), (23): it puts the greatest ratio at 9.9 deg, not at the
cut, and raises the peak.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lumped.models import Row
from lumped.models.eccentric_shear_scenes import (
    SLOW,
    CrankTurned,
    FreeShear,
    free_run,
    kept,
    landing,
    turn,
)
from lumped.models.eccentric_shear_stand import (
    CENTRE_RECTANGLE,
    CUT_BEGINS,
    CUT_ENDS,
    ECCENTRICITY,
    FOUR_CUTS,
    MEAN,
    MEETS,
    PULSE_ENDS,
    SPEED,
    GuidedShear,
    PrintedShear,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ANGLES = "angles of the cycle"
FIGURE = "figure 3 and its text"
CLAIM = "2.5 to 3 for e = 0.4 to 0.5; idle torque fitted"
CUTS = "4 cuts/min, printed beside 1.05 rad/s, but without pauses 0.419 rad/s"
LOAD = "1.6 to 1.7 for e = 0.4 to 0.5, ends in any order; idle torque fitted"
NOT = "not published"
READINGS = (PrintedShear, GuidedShear)
TOO_WIDE = "impossible: at most 1.79 without inertia; a rectangle of 68 deg is too wide"
TITLES = (  # quantity, unit, published, place, remark
    ("travel while cutting", "mm", 200.0, ANGLES, "slab of 200 mm; angles rounded to 5'"),
    ("approach of the upper support", "mm", None, ANGLES, "260.18 from the printed angles"),
    ("overlap of the knives", "mm", None, ANGLES, "15.00 from the printed angles"),
    ("equivalent rectangular torque", "MN.m", None, "equation (17)", "1.3673 from a half-sine"),
    ("greatest torque, reduction, e = 0.4", "1", 2.5, FIGURE, CLAIM),
    ("greatest torque, reduction, e = 0.5", "1", 3.0, FIGURE, CLAIM),
    ("the same at 0.419 rad/s, e = 0.4", "1", 2.5, FIGURE, CUTS),
    ("the same at 0.419 rad/s, e = 0.5", "1", 3.0, FIGURE, CUTS),
    ("RMS torque, reduction, e = 0.4", "1", 1.6, FIGURE, LOAD),
    ("RMS torque, reduction, e = 0.5", "1", 1.7, FIGURE, LOAD),
    ("greatest torque, rectangle, reduction, e = 0.4", "1", 2.5, FIGURE, TOO_WIDE),
    ("greatest torque, rectangle, reduction, e = 0.5", "1", 3.0, FIGURE, TOO_WIDE),
    ("the same, e = 0.5, without inertia", "1", None, NOT, "1.78 from (20)"),
    ("the same, phase by (22), increase", "1", None, NOT, "2.86 from (20)"),
    ("free run, time of two turns", "s", None, NOT, "11.982149 by DOP853 on (19)"),
    ("free run, greatest motor torque", "kN.m", None, NOT, "2739.2 by DOP853 on (19)"),
    ("free run, speed kept where the pin lands", "1", None, NOT, "0.95265 from momentum"),
    ("free run, e = 0.5, landing over cutting torque", "1", None, NOT, "above 1 by the impacts"),
    ("the same, supports in the guides of the frame", "1", None, NOT, "the other reading"),
)


def printed_phase(eps: float) -> float:
    """Crank angle of the greatest ratio by (22) and (23), rad; the source means `phi_max`."""
    driver = (1 + eps) / (1 - eps) * CENTRE_RECTANGLE
    return float(2 * np.arctan((1 - eps) / (1 + eps) * np.tan(driver / 2)))


def rows() -> list[Row]:
    """Published and computed numbers; reductions are those against e = 0."""
    lift = -1e3 * ECCENTRICITY * np.diff(np.cos([0, MEETS, CUT_BEGINS, CUT_ENDS, PULSE_ENDS]))
    sine, *sines = (turn(CrankTurned, e) for e in (0.0, 0.4, 0.5))
    rectangle, *rectangles = (turn(CrankTurned, e, "rectangle") for e in (0.0, 0.4, 0.5))
    even_sine, *slower = (turn(CrankTurned, e, speed=FOUR_CUTS) for e in (0.0, 0.4, 0.5))
    slow = [turn(CrankTurned, e, "rectangle", speed=SLOW * SPEED) for e in (0.0, 0.5)]
    mistaken = turn(CrankTurned, 0.5, "rectangle", slowest=printed_phase(0.5))
    even = free_run(rtol=1e-9, until=12.0, grid=20_000)
    elliptical = [free_run(0.5, shear=shear, rtol=1e-9, grid=4000) for shear in READINGS]
    computed = [
        *(lift[2], lift[0], lift[3]),
        MEAN / 1e6,
        *(sine.peak / demand.peak for demand in sines),
        *(even_sine.peak / demand.peak for demand in slower),
        *(sine.rms / demand.rms for demand in sines),
        *(rectangle.peak / demand.peak for demand in rectangles),
        slow[0].peak / slow[1].peak,
        mistaken.peak / rectangle.peak,
        np.interp(4 * np.pi, even["loaded.shear.crank.phi"], even.t),
        even["motor.tau"].max() / 1e3,
        kept(even)[0],
        *map(landing, elliptical),
    ]
    return [
        Row(*title[:3], float(x), *title[3:]) for title, x in zip(TITLES, computed, strict=True)
    ]


def model() -> FreeShear:
    """The machine to draw and to report on."""
    return FreeShear()


def plots() -> dict[str, Figure]:
    """Figures by name."""
    from lumped.models.eccentric_shear_figures import figures

    return figures()
