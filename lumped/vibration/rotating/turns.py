"""Points over the turns of a steady rotation that give means and harmonics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from lumped.support.arrays import Complex, Real
from lumped.vibration.rotating.rotation import Rotation
from lumped.vibration.rotating.small_vibrations import Parts, SmallVibrations

_SAMPLES = 1440
"""Points of a turn at which torques that follow from the angle are taken."""
_GAUSS = 8
"""Points of each part of the turns between kinks."""
_HALVINGS = 32
"""Halvings of the smallest step after which it is rounding of the angle."""
_SAME = 1e-12
"""Distance of kinks, rad, that is rounding."""


class Turns(NamedTuple):
    """Points over all turns, and their weights in means, whose sum is one.

    Attributes
    ----------
    angles, weights : ndarray, shape (samples,)
        Angles of the shaft, rad.
    x, settings : ndarray, shapes (samples, n) and (samples, m)
        States and settings.
    """

    angles: Real
    weights: Real
    x: Real
    settings: Real

    def waves(self, orders: Real) -> Complex:
        """What times a curve has the amplitudes of the curve as sums, shape (o, samples)."""
        found: Complex = 2 * self.weights * np.exp(-1j * orders[:, None] * self.angles)
        return found


def begin_of(steady: Rotation, k: int = 0) -> Turns:
    """The point at one speed where the angle is that of the operating point."""
    return Turns(np.zeros(1), np.ones(1), *steady.along(k, np.zeros(1)))


def turns_of(
    small: SmallVibrations, steady: Rotation, k: int = 0, orders: ArrayLike = 1.0
) -> Turns:
    """Points at one speed by which what follows from the angle has its means and harmonics.

    Means over equal steps of a smooth curve converge faster than any power of the step (Euler and
    Maclaurin). A curve with kinks is integrated between these by Gauss's rule.
    """
    if not steady.turns_matter:
        return begin_of(steady, k)
    samples = _SAMPLES * steady.turns
    while samples < 8 * steady.turns * np.max(orders):
        samples *= 2
    edges = 2 * np.pi * steady.turns * np.arange(samples + 1) / samples
    kinks = _find_kinks(small, steady, k, edges)
    if not len(kinks):
        angles, weights = edges[:-1], np.full(samples, 1 / samples)
    else:
        edges = np.union1d(edges[::_GAUSS], kinks)
        places, weights = np.polynomial.legendre.leggauss(_GAUSS)
        half = 0.5 * np.diff(edges)[:, None]
        angles = (edges[:-1, None] + half * (1 + places)).ravel()
        weights = (half * weights).ravel() / edges[-1]
    return Turns(angles, weights, *steady.along(k, angles))


def everything_along(small: SmallVibrations, steady: Rotation, turns: Turns, k: int = 0) -> Parts:
    """Rates, outputs and matrices over all turns of a rotation at one of its speeds."""
    return small(turns.x, steady.theta[k], turns.settings, steady.time)


def _find_kinks(small: SmallVibrations, steady: Rotation, k: int, edges: Real) -> Real:
    """Angles, to their rounding, at which pieces of the equations change between given angles.

    Those found before are looked at first, as few move with the speed.
    """

    def pieces(angles: Real) -> Real:
        x, settings = steady.along(k, angles)
        return np.hstack([settings, small.pieces(x, steady.theta[k], settings, steady.time)])

    least, known = edges[1] * 2.0**-_HALVINGS, small.kinks[small.kinks <= edges[-1]]
    edges = np.unique(np.concatenate([edges, known, known - least]))
    ends, every = np.stack([edges[:-1], edges[1:]]), pieces(edges)
    sides = np.stack([every[:-1], every[1:]])
    found = list[Real]()
    while ends.size:
        own = (sides[0] != sides[1]).any(axis=1)
        narrow = ends[1] - ends[0] <= 1.5 * least
        found.append(ends[1, own & narrow])
        ends, sides = ends[:, own & ~narrow], sides[:, own & ~narrow]
        middle = ends.mean(axis=0)
        inside = pieces(middle) if len(middle) else every[:0]
        ends = np.stack([np.append(ends[0], middle), np.append(middle, ends[1])])
        sides = np.stack([np.vstack([sides[0], inside]), np.vstack([inside, sides[1]])])
    kinks: Real = np.unique(np.concatenate(found))
    small.kinks = kinks
    return kinks[np.diff(kinks, prepend=-1.0) > _SAME]
