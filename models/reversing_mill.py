"""Reversing cold rolling mill 400: published numbers beside computed ones.

The stand and its source are described in `lumped.models.reversing_mill_stand`, what happens where
the roll gap sticks, skids and opens in `lumped.models.reversing_mill_scenes`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import lumped as lp
from lumped.models import Row
from lumped.models.reversing_mill_scenes import (
    DIFFERENCE,
    SKIDS,
    StripGap,
    skidding,
    strip_break,
    with_droop,
)
from lumped.models.reversing_mill_stand import (
    KGF,
    RATED,
    SHAFTS,
    ClosedGap,
    CreepingGap,
    OpenGap,
    eccentricity_hertz,
    strip_entry,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROUNDING = "within the rounding of the printed J and C"
PUBLISHED = (  # quantity, unit, value, place, remark
    ("upper branch, gap open, f1", "Hz", 39.8, "equations (48) to (51)", ROUNDING),
    ("upper branch, gap open, f2", "Hz", 21.7, "equations (48) to (51)", ROUNDING),
    ("lower branch, gap open", "Hz", 38.9, "equation (46)", ROUNDING),
    ("eccentricity at 15 m/s", "Hz", 9.55, "equation (47)", "used to find the lost roll diameter"),
    ("eccentricity at 10 m/s", "Hz", 6.36, "equation (47)", "print cut off, not rounded"),
)
NOT = "not published"
CHANGES = ("first skid", "first stick", "second skid", "second stick")
UNPUBLISHED = (  # quantity, unit, None, place, reference and its origin
    ("closed gap, mode 1", "Hz", None, NOT, "6.34431 from the roots of equation (56)"),
    ("closed gap, mode 2", "Hz", None, NOT, "22.50599 from the roots of equation (56)"),
    ("closed gap, mode 3", "Hz", None, NOT, "39.17282 from the roots of equation (56)"),
    ("speed that excites closed mode 1", "m/s", None, NOT, "9.97 from equations (47) and (56)"),
    ("damping ratio of closed mode 1", "1", None, NOT, "0.27 at K_s = 400 kgf m s, eigenvalues"),
    ("strip entry, peak / mean, shaft B1", "1", None, NOT, "2.491 from modal sums over 2 s"),
    ("strip entry, peak / mean, spindle B2", "1", None, NOT, "2.124 from modal sums over 2 s"),
    ("strip entry, peak / mean, spindle B3", "1", None, NOT, "2.192 from modal sums over 2 s"),
    ("strip break, lowest torque / Mr, shaft B1", "1", None, NOT, "-0.51 from modal sums over 2 s"),
    ("strip break, lowest torque / Mr, spindle B2", "1", None, NOT, "-0.941 from modal sums"),
    ("strip break, lowest torque / Mr, spindle B3", "1", None, NOT, "-0.943 from modal sums"),
    *(
        (f"skidding, {what}", "ms", None, NOT, f"{1e3 * t:.3f} from modal sums between events")
        for what, t in zip(CHANGES, SKIDS, strict=True)
    ),
    ("skidding, largest slip at 500 points", "rad/s", None, NOT, "7.764 from modal sums"),
    ("M_u / Mr, eps = 0.2 %, droop 3 %", "1", None, NOT, "0.0333 from eps / (2 s)"),
    ("M_u / Mr, eps = 0.2 %, droop 1 %", "1", None, NOT, "0.1000 from eps / (2 s)"),
)


def rows() -> list[Row]:
    """Published and computed numbers; the strip entry with motors stepping to rated torque."""
    after_break = strip_break(until=2.02, grid=40_000, rtol=1e-8)
    skids = skidding(grid=499, rtol=1e-9)
    unequal = {"eps": DIFFERENCE}
    rolling = [lp.equilibrium(lp.assemble(with_droop(s)), parameters=unequal) for s in (0.03, 0.01)]
    opened, closed = (lp.modes(lp.assemble(gap)).hertz for gap in (OpenGap(), ClosedGap()))
    creeping = lp.modes(lp.assemble(CreepingGap()), parameters={"K_s": 400 * KGF})
    entry = strip_entry(ClosedGap(), RATED, until=2.0, grid=20_000, rtol=1e-8)
    computed = [
        *(opened[2], opened[0], opened[1]),
        *(eccentricity_hertz(15), eccentricity_hertz(10)),
        *closed,
        closed[0] / eccentricity_hertz(1),
        creeping.damping[0],
        *(entry.table(SHAFTS).max(axis=0) / RATED),
        *(after_break.table(SHAFTS).min(axis=0) / RATED),
        *(1e3 * event.time for event in skids.events if event.component == "gap"),
        skids["gap.w_rel"].max(),
        *(point["gap.tau"] / RATED for point in rolling),
    ]
    return [
        Row(quantity, unit, value, float(found), place, remark)
        for (quantity, unit, value, place, remark), found in zip(
            (*PUBLISHED, *UNPUBLISHED), computed, strict=True
        )
    ]


def model() -> StripGap:
    """The machine to draw and to report on."""
    return StripGap()


def plots() -> dict[str, Figure]:
    """Figures by name."""
    from lumped.models.reversing_mill_figures import figures

    return figures()
