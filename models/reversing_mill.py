"""Reversing cold rolling mill 400: published numbers beside computed ones.

The stand and its source are described in `lumped.models.reversing_mill_stand`, what happens where
the roll gap sticks, skids and opens in `lumped.models.reversing_mill_scenes`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import lumped as lp
from lumped.models import Row
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
UNPUBLISHED = (  # quantity, unit, None, place, reference and its origin
    ("closed gap, mode 1", "Hz", None, NOT, "6.34431 from the roots of equation (56)"),
    ("closed gap, mode 2", "Hz", None, NOT, "22.50599 from the roots of equation (56)"),
    ("closed gap, mode 3", "Hz", None, NOT, "39.17282 from the roots of equation (56)"),
    ("speed that excites closed mode 1", "m/s", None, NOT, "9.97 from equations (47) and (56)"),
    ("damping ratio of closed mode 1", "1", None, NOT, "0.27 at K_s = 400 kgf m s, eigenvalues"),
    ("strip entry, peak / mean, shaft B1", "1", None, NOT, "2.491 from modal sums over 2 s"),
    ("strip entry, peak / mean, spindle B2", "1", None, NOT, "2.124 from modal sums over 2 s"),
    ("strip entry, peak / mean, spindle B3", "1", None, NOT, "2.192 from modal sums over 2 s"),
)


def rows() -> list[Row]:
    """Published and computed numbers; the strip entry with motors stepping to rated torque."""
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
    ]
    return [
        Row(quantity, unit, value, float(found), place, remark)
        for (quantity, unit, value, place, remark), found in zip(
            (*PUBLISHED, *UNPUBLISHED), computed, strict=True
        )
    ]


def plots() -> dict[str, Figure]:
    """Figures by name."""
    from lumped.models.reversing_mill_figures import figures

    return figures()
