"""Expanding mandrel of the carrousel coiler, from the words of section 2.2.1.

A cylinder pulls the pyramid shaft; four slopes of its wedge slide under four segments and push them
apart. The sections with its forces (3.2.3 to 3.2.5) are not in the copy, so that slope and friction
are [A], and so is what loads it here: one wrap of strip at the whole tension.
"""

from __future__ import annotations

from math import atan, pi, radians, sin, tan

from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.sources import Given

SEGMENTS = Given(4, "1", "P", "segments of the mandrel")
SLOPE = Given(radians(10), "rad", "A", "slope of the wedges against the axis")
FRICTION = Given(0.1, "1", "A", "friction of the wedges")


def radial_travel(axial: float, slope: float = SLOPE) -> float:
    """Travel of the segments, m, for a travel of the pyramid, m: ``s tan(slope)``."""
    return axial * tan(slope)


def segment_force(T: float = coiler.TENSION, wraps: float = 1.0) -> float:
    """Force of wraps of strip on a segment, N: both ends of its arc pull, ``2 T sin(pi / 4)``."""
    return wraps * 2 * T * sin(pi / SEGMENTS)


def pull(force: float, slope: float = SLOPE, friction: float = FRICTION) -> float:
    """Force of the cylinder that expands the mandrel against a force on each segment, N.

    Virtual work, with the angle of friction beside that of the slope.
    """
    return SEGMENTS * force * tan(slope + atan(friction))


def hold(force: float, slope: float = SLOPE, friction: float = FRICTION) -> float:
    """Force of the cylinder below which the mandrel contracts, N; negative: it sticks by itself."""
    return SEGMENTS * force * tan(slope - atan(friction))
