"""A probability from design points beside one by a few directions, along which limits are met."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise

import numpy as np
import scipy

from lumped.support.arrays import Integer, Real
from lumped.tolerances.failure.form import DesignPoint, find_roots, is_entered
from lumped.tolerances.failure.limit import Limit

_ANYWHERE, _TOWARDS = 8, 8
"""Directions of any kind, and towards what lies beyond the planes."""
_ALONG = 4
"""Distances along each at which the limit is looked at first; eightfold for one parameter."""
_ROUNDS = 3
"""Evaluations by which a crossing is found between two of them."""
_LEFT = 1e-4
"""Share of the probability that may lie behind the last."""
_SCORE, _FITS = 3.0, 0.1
"""Deviations, and relative difference, up to which both fit."""


def compare_directions(
    limit: Limit, points: Sequence[DesignPoint], probability: float
) -> tuple[str, ...]:
    """What a small directional sampling says against a probability; nothing if both fit.

    Half of the directions have any kind; the others are those of points beyond the planes, which
    would give the probability of a plane without scatter. All are weighted as one mixture.

    O. Ditlevsen, P. Bjerager, R. Olesen, A. M. Hasofer: Directional simulation in Gaussian
    processes. Probabilistic Engineering Mechanics 3 (1988) 207-217. A. Owen, Y. Zhou: Safe and
    effective importance sampling. Journal of the American Statistical Association 95 (2000)
    135-143 (mixture).
    """
    before, side = limit.evaluations, 1.0 if limit.is_kept_by_median else -1.0
    entered = [point for point in points if is_entered(point.beta, side > 0)]
    normals = side * np.array([point.alpha for point in entered])
    groups, weights = _draw(normals, np.abs([point.beta for point in entered]))
    changed = _look_along(limit, points, np.concatenate(groups), side)
    fails = probability if side > 0 else 1 - probability
    found, deviation = _average(changed, groups, weights)
    if found > 0.5:
        found, deviation = _average(1 - changed, groups, weights)
        fails, side = 1 - fails, -side
    if abs(found - fails) <= _SCORE * deviation + _FITS * max(found, fails):
        return ()
    told = found if side > 0 else 1 - found
    return (
        f"{len(changed)} directions, with {limit.evaluations - before} evaluations, give the "
        f"probability {told:.3g} (standard deviation {deviation:.1g}), which does not fit: the "
        "design points do not describe this limit. Take search='importance' or search='subset'",
    )


def _draw(normals: Real, beta: Real) -> tuple[list[Real], Real]:
    """Directions in groups, each shape (n, d), and the weights of all.

    Parameters
    ----------
    normals : ndarray, shape (m, d)
        Of planes beyond which the state of the median has ended.
    beta : ndarray, shape (m,)
        Their distances from it, positive.
    """
    (m, d), beyond = normals.shape, scipy.special.ndtr(-beta)
    if d == 1:
        return [np.array([[1.0], [-1.0]])], np.ones(2)
    random = np.random.default_rng(0)
    half = random.standard_normal((_ANYWHERE // 2, d))
    groups, each = [np.concatenate([half, -half])], max(_TOWARDS // m, 2)
    for normal, share in zip(normals, beyond, strict=True):
        there = random.standard_normal((each, d))
        far = -scipy.special.ndtri(share * (np.arange(each) + random.random(each)) / each)
        groups.append(there + np.outer(far - there @ normal, normal))
    groups = [group / np.linalg.norm(group, axis=1, keepdims=True) for group in groups]
    along = np.concatenate(groups)
    with np.errstate(divide="ignore"):
        far = beta / np.maximum(along @ normals.T, 0.0)
    density = each * (scipy.stats.chi2.sf(far**2, d) / beyond).sum(axis=1) + len(groups[0])
    return groups, len(along) / density


def _look_along(limit: Limit, points: Sequence[DesignPoint], along: Real, side: float) -> Real:
    """Probability along each direction that the state is not that of the median."""
    count, d = along.shape
    rare = float(scipy.special.ndtr(-min(abs(point.beta) for point in points)))
    last = float(np.sqrt(scipy.stats.chi2.isf(_LEFT * rare, d)))
    steps = last * np.linspace(0, 1, 1 + _ALONG * (8 if d == 1 else 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        planes = np.column_stack([point.beta / (along @ point.alpha) for point in points])
    planes = np.sort(np.where((planes > 0) & (planes < last), planes, last), axis=1)
    between = (planes[:, 1:] + planes[:, :-1]) / 2
    radii = np.sort(np.column_stack([np.tile(steps, (count, 1)), between]), axis=1)

    def at(rows: Integer, far: Real) -> Real:
        return side * limit.values(along[rows] * far[:, None])

    width = radii.shape[1] - 1
    excess = np.full(radii.shape, -1.0)
    excess[:, 1:] = at(np.repeat(np.arange(count), width), radii[:, 1:].ravel()).reshape(-1, width)
    for inner, here in pairwise(excess.T):  # a failed evaluation shows no change
        here[:] = np.where(np.isnan(here), inner, here)
    rows, k = np.nonzero((excess[:, 1:] > 0) != (excess[:, :-1] > 0))
    (low, high), (below, above) = (
        (table[rows, k], table[rows, k + 1]) for table in (radii, excess)
    )
    roots = find_roots(partial(at, rows), low, high, below, above, _ROUNDS)
    found = np.zeros(count)
    ends = np.where(excess[rows, k] > 0, -1.0, 1.0)
    np.add.at(found, rows, ends * scipy.stats.chi2.sf(roots**2, d))
    return found


def _average(chances: Real, groups: Sequence[Real], weights: Real) -> tuple[float, float]:
    """Mean of what directions give, and its standard deviation."""
    parts = np.split(weights * chances, np.cumsum([len(group) for group in groups])[:-1])
    spread = sum(len(part) * float(part.var(ddof=1)) for part in parts)
    # both directions of one parameter are all there are
    deviation = 0.0 if len(groups) == 1 else float(np.sqrt(spread)) / len(weights)
    return float(sum(part.sum() for part in parts)) / len(weights), deviation
