"""Moments of a quadratic function of independent variables."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lumped.ensembles.laws import Law, density
from lumped.tolerances.evaluated import Array

_FAR, _PANELS, _NODES = 9.0, 120, 8


class Moments(NamedTuple):
    """Mean, variance and third central moment, and shares of variables alone in the variance."""

    mean: float
    variance: float
    third: float
    shares: Array


def central_moments(law: Law) -> tuple[float, Array]:
    """Mean of a distribution, and its central moments of orders 0 to 6.

    Integrals over the standard normal score, by Gauss's rule on short panels.
    """
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    half = _FAR / _PANELS
    middles = np.linspace(-_FAR + half, _FAR - half, _PANELS)
    z = (middles[:, None] + half * nodes).ravel()
    w = (half * np.broadcast_to(weights, (_PANELS, _NODES))).ravel() * density(z)
    w /= w.sum()
    x = law.at_score(z)[0]
    mean = float(w @ x)
    return mean, np.array([w @ (x - mean) ** k for k in range(7)])


def quadratic_moments(value: float, slope: Array, curvature: Array, central: Array) -> Moments:
    """Moments of ``value + slope v + v curvature v / 2`` for independent v with mean zero.

    Parameters
    ----------
    slope, curvature : ndarray, shapes (d,) and (d, d)
    central : ndarray, shape (d, 7)
        Moments of each variable, of orders 0 to 6.
    """
    _, _, m2, m3, m4, m5, m6 = central.T
    c, own = slope, 0.5 * np.diag(curvature)
    cross = curvature - np.diag(np.diag(curvature))
    # of each variable alone: A = c v + own (v^2 - m2)
    square = m4 - m2**2
    alone = c**2 * m2 + 2 * c * own * m3 + own**2 * square
    cubes = (
        c**3 * m3
        + 3 * c**2 * own * square
        + 3 * c * own**2 * (m5 - 2 * m2 * m3)
        + own**3 * (m6 - 3 * m2 * m4 + 2 * m2**3)
    )
    a, b = c * m2 + own * m3, c * m3 + own * square
    weighted = cross * m2
    third = (
        cubes.sum()
        + 3 * a @ cross @ a
        + 3 * b @ cross**2 @ m2
        + np.trace(weighted @ weighted @ weighted)
        + 0.5 * m3 @ cross**3 @ m3
    )
    variance = alone.sum() + 0.5 * m2 @ cross**2 @ m2
    return Moments(float(value + own @ m2), float(variance), float(third), alone / variance)
