"""Probability of what lies beyond several planes in standard normal space."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import scipy

from lumped.support.arrays import Real
from lumped.tolerances.failure.form import DesignPoint, is_entered

_PARALLEL = 1e-12
"""Difference of a correlation from 1 that is rounding."""
_BEYOND = 1e-6
"""Distance from which a point lies beyond a plane."""
_TIGHT = 1e-3
"""Difference of both bounds of a probability, relative to it, that is not looked into."""


def join_points(
    points: Sequence[DesignPoint], is_kept: bool, each: Sequence[float] | None = None
) -> float:
    """Probability that a limit is exceeded, by planes at its design points.

    Going out from the median, its state ends at some planes and comes back at others, such as the
    far side of a resonance. With ``A`` beyond any of them and ``B`` beyond any of the latter, the
    state is another one with the probability ``P(A) - P(B)``. Where it ends again behind that, as
    in the next band, the same is added for the planes there.

    Parameters
    ----------
    points : sequence of DesignPoint
        All of them.
    is_kept : bool
        Whether the median keeps the limit.
    each : sequence of float, optional
        Probability at each; default is that of a plane limit.
    """
    own = np.array([point.probability for point in points] if each is None else each)
    enters = np.array([is_entered(point.beta, is_kept) for point in points])
    side = np.where(enters == is_kept, 1.0, -1.0)
    beyond = np.where(side > 0, own, 1 - own)
    normals = side[:, None] * np.array([point.alpha for point in points])
    # how many planes where the state comes back lie between the median and each point
    points_at = np.array([point.u for point in points])
    back, far = ~enters, points_at @ normals.T - side * [point.beta for point in points]
    passed = ((far > _BEYOND) & back).sum(axis=1)
    changed = 0.0
    for turn in range(int(passed.max()) + 1):
        now = passed == turn
        ends = now & back
        changed += _unite(beyond[now], normals[now]) - _unite(beyond[ends], normals[ends])
    changed = min(max(changed, 0.0), 1.0)
    return changed if is_kept else 1.0 - changed


def _unite(beyond: Real, normals: Real) -> float:
    """Probability of the union of half-spaces, from the probability and the normal of each.

    With two it is exact, by inclusion and exclusion. With more it lies between the bounds of
    Ditlevsen, which are nearly one for rare events; else what is left inside is integrated.

    O. Ditlevsen: Narrow reliability bounds for structural systems. Journal of Structural Mechanics
    7 (1979) 453-472.
    """
    order = np.argsort(-beyond)[: np.count_nonzero(beyond)]
    beyond, normals = beyond[order], normals[order]
    beta, alike = -scipy.special.ndtri(beyond), normals @ normals.T
    low = high = 0.0
    for i, single in enumerate(beyond.tolist()):
        both = [_both(beta[i], beta[k], float(alike[i, k])) for k in range(i)]
        low += max(single - sum(both), 0.0)
        high += single - max(both, default=0.0)
    if len(beyond) < 3 or high - low <= _TIGHT * high:
        return high
    inside = scipy.stats.multivariate_normal.cdf(
        beta, cov=alike, allow_singular=True, rng=np.random.default_rng(0)
    )
    return min(max(1.0 - float(inside), low), high)


def _both(a: float, b: float, correlation: float) -> float:
    """Probability that two standard normal variables exceed a and b."""
    if correlation > 1 - _PARALLEL:
        return float(scipy.special.ndtr(-max(a, b)))
    if correlation < _PARALLEL - 1:
        return max(float(scipy.special.ndtr(-a) - scipy.special.ndtr(b)), 0.0)

    def density(angle: float) -> float:  # of r = sin(angle), Plackett 1954
        square = (a * a + b * b - 2 * a * b * math.sin(angle)) / math.cos(angle) ** 2
        return math.exp(-square / 2) / (2 * math.pi)

    alone = float(scipy.special.ndtr(-a) * scipy.special.ndtr(-b))
    limit = math.asin(correlation)
    return max(alone + float(scipy.integrate.quad(density, 0.0, limit)[0]), 0.0)
