"""The most likely combination of parameters at which a limit is exceeded (design point)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from lumped.errors import OptionError, SolverError
from lumped.numerics.nearest_points import FURTHEST, Search, search_together
from lumped.support.arrays import Real
from lumped.tolerances.failure.limit import Limit

_NEAR = (1e-2, 1e-4)
"""Distances from a design point at which the normal is compared with itself."""
_TURNED = 0.1
"""Difference of two normals that is no kink yet."""
_SAME = 0.05
"""Distance of two design points, relative to that from the median, below which they are one."""


@dataclass(frozen=True, eq=False)
class DesignPoint:
    """The most likely combination of parameters at a limit, in a neighbourhood.

    Attributes
    ----------
    beta : float
        Its distance from the median in standard normal space, the reliability index of Hasofer and
        Lind; negative if the median exceeds the limit.
    u : ndarray, shape (d,)
        The point in standard normal space.
    alpha : ndarray, shape (d,)
        Direction from the median in which the limit is exceeded, of length one.
    x : ndarray, shape (d,)
        Parameters there, in SI units.
    slopes : ndarray, shape (d,)
        Derivatives of the excess over the limit by the parameters.
    steepness : float
        Growth of the excess over a unit of standard normal space, along `alpha`.
    bend : float
        ``1 + beta kappa`` with the curvature kappa of the limit along one direction: 1 for a plane.
    """

    beta: float
    u: Real
    alpha: Real
    x: Real
    slopes: Real
    steepness: float
    bend: float

    @property
    def probability(self) -> float:
        """That the limit is exceeded, if it were plane in standard normal space."""
        return float(scipy.special.ndtr(-self.beta))

    def beta_by(self, excess_by: Real) -> Real:
        """Derivatives of beta, from those of the excess over the limit at the point itself.

        Parameters
        ----------
        excess_by : ndarray
            Derivatives by anything, with the variables of standard normal space held.
        """
        return -excess_by / self.steepness


def form(limit: Limit, begin: Real | None = None, searches: int = 4) -> tuple[DesignPoint, ...]:
    """Design points, the nearest to the median first.

    Parameters
    ----------
    limit : Limit
        What must not be exceeded.
    begin : ndarray, shape (d,), optional
        Where the first search begins in standard normal space, such as at the point of a similar
        design; default is the median.
    searches : int
        Number of searches. The second begins opposite the point that the first has found, the
        others at right angles to it, in pairs.

    Raises
    ------
    SolverError
        If the limit is not reached within a distance of 8, has a kink at a design point, or
        gradients fail.
    OptionError
        If the functional depends on none of the parameters.
    """
    return points_of(limit, search_all(limit, begin, searches))


def points_of(limit: Limit, every: Sequence[Search]) -> tuple[DesignPoint, ...]:
    """Design points that searches have found, checked; errors as for `form`."""
    found = [search for search in every if search.is_found]
    if not found:
        raise nothing_found(limit, every)
    points: list[DesignPoint] = []
    saddle = ""
    for search in sorted(found, key=lambda search: float(np.linalg.norm(search.u))):
        if any(is_same(p.u, search.u) for p in points):
            continue
        point = _design_point(limit, search)
        if point.bend > 0:
            points.append(point)
        else:
            saddle = limit.combination(point.u)
    if not points:
        raise SolverError(
            f"{limit.head}: at {saddle} the limit bends around the median more than a sphere, so "
            "combinations beside this one are more likely, and none was found. Take more searches, "
            "or search='subset'."
        )
    return tuple(points)


def is_same(u: Real, other: Real) -> bool:
    """Whether two design points are one."""
    return bool(np.linalg.norm(u - other) < _SAME * (1 + np.linalg.norm(u)))


def search_all(limit: Limit, begin: Real | None = None, searches: int = 4) -> list[Search]:
    """Searches for design points, each at its end; arguments as for `form`."""
    first = np.zeros(limit.count) if begin is None else begin
    every = search_together(limit.slopes, [first])
    if searches > 1:
        every += search_together(limit.slopes, _others(every[0], searches - 1))
    return every


def join_points(points: Sequence[DesignPoint], each: Sequence[float] | None = None) -> float:
    """Probability that a limit is exceeded at one of its design points.

    That one of several half-spaces is met, by Ditlevsen's upper bound; with two it is exact.

    Parameters
    ----------
    points : sequence of DesignPoint
        All of them.
    each : sequence of float, optional
        Probability at each; default is that of a plane limit.

    Notes
    -----
    O. Ditlevsen: Narrow reliability bounds for structural systems. Journal of Structural Mechanics
    7 (1979) 453-472.
    """
    sign = 1.0 if points[0].beta > 0 else -1.0
    own = [point.probability for point in points] if each is None else each
    rare = [p if sign > 0 else 1 - p for p in own]
    beta = (-scipy.special.ndtri(rare)).tolist()
    total = 0.0
    for i, point in enumerate(points):
        both = [_both(beta[i], beta[k], point.alpha @ points[k].alpha) for k in range(i)]
        total += rare[i] - max(both, default=0.0)
    return total if sign > 0 else 1.0 - total


def _both(a: float, b: float, correlation: Any) -> float:
    """Probability that two standard normal variables exceed a and b."""
    limit = math.asin(min(max(float(correlation), -1.0), 1.0))

    def density(angle: float) -> float:  # of r = sin(angle), Plackett 1954
        square = (a * a + b * b - 2 * a * b * math.sin(angle)) / math.cos(angle) ** 2
        return math.exp(-square / 2) / (2 * math.pi)

    alone = float(scipy.special.ndtr(-a) * scipy.special.ndtr(-b))
    return max(alone + float(scipy.integrate.quad(density, 0.0, limit)[0]), 0.0)


def _others(search: Search, count: int) -> list[Real]:
    """Where further searches begin: opposite a point, and in pairs at right angles to it."""
    far = float(np.linalg.norm(search.u)) if search.is_found else 0.0
    along = search.u / far if far else np.zeros(len(search.u))
    begins = [-search.u] if far else []
    random = np.random.default_rng(0)
    while len(begins) < count:
        aside = random.standard_normal(len(along))
        aside -= along * (along @ aside) * (len(along) > 1)
        aside *= max(far, 1.0) / float(np.linalg.norm(aside))
        begins += [aside, -aside]
    return begins[:count]


def _design_point(limit: Limit, search: Search) -> DesignPoint:
    steepness = float(np.linalg.norm(search.slope))
    alpha = search.slope / steepness
    u = alpha * float(alpha @ search.u - search.g / steepness)
    beta = float(alpha @ u)
    return DesignPoint(beta, u, alpha, *limit.at(u), steepness, 1 + beta * _measure_bend(limit, u))


def nothing_found(limit: Limit, every: Sequence[Search]) -> OptionError | SolverError:
    """Why no search has found a point."""
    known = [search for search in every if np.isfinite(search.g)]
    if not known:
        return SolverError(
            f"{limit.head}: no derivatives at the median of the parameters: {limit.reason} "
            "search='subset' needs none."
        )
    if all(search.is_flat for search in known):
        return OptionError(
            f"{limit.head} does not depend on {', '.join(limit.scene.names)} near their median: "
            "all derivatives are zero. Vary something else, or take search='subset', which needs "
            "no derivatives."
        )
    if not limit.is_crossed:
        return limit.explain_unreached(f"within a distance of {FURTHEST:g}")
    for search in known:
        _measure_bend(limit, search.u)
    return SolverError(
        f"{limit.head}: no design point was found in {sum(s.count for s in every)} evaluations. "
        "Take tighter rtol, or search='subset', which needs no design point."
    )


def _measure_bend(limit: Limit, u: Real) -> float:
    """Curvature of the limit at a point, along one direction; it bends to the median if negative.

    Raises
    ------
    SolverError
        If the normal of the limit turns at once, with both normals.
    """
    aside = np.random.default_rng(1).standard_normal(len(u))
    aside /= float(np.linalg.norm(aside))
    bend = 0.0
    for far in _NEAR:
        _, slopes = limit.slopes(np.array([u - far * aside, u + far * aside]))
        if not np.isfinite(slopes).all():
            raise SolverError(
                f"{limit.head} has no derivative beside its design point at "
                f"{limit.combination(u)}: {limit.reason} search='subset' needs none."
            )
        sizes = np.linalg.norm(slopes, axis=1, keepdims=True)
        normals = slopes / np.maximum(sizes, np.finfo(float).tiny)
        middle = normals.mean(axis=0)
        tangent = aside - middle * (middle @ aside) / (middle @ middle)
        turned = normals[1] - normals[0]
        bend = -float(tangent @ turned) / (2 * far * float(tangent @ tangent) or 1.0)
        if np.linalg.norm(turned) < _TURNED:
            return bend
    first, second = (", ".join(f"{v:.3g}" for v in normal) for normal in normals)
    raise SolverError(
        f"{limit.head} has a kink at its design point, {limit.combination(u)}: on its two sides "
        f"the normals of the limit are ({first}) and ({second}), so beta says nothing about the "
        "probability. Take search='importance' or search='subset'."
    )
