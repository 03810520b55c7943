"""Probability that a limit is exceeded, from samples around its design points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from lumped.errors import SolverError
from lumped.numerics.nearest_points import Search
from lumped.tolerances.failure.form import nothing_found
from lumped.tolerances.failure.limit import Array, Limit
from lumped.tolerances.failure.sampled import Sampled, interval

_BESIDE = 2.0
"""How much farther than the nearest point others may be that are sampled too."""
_SAME = 0.2
"""Distance of two points below which one is enough."""
_NEARER = 0.1
"""How much nearer than a design point a sample may exceed the limit."""
_MOST = 0.2
"""Share of one sample in the estimate, of 1."""


def centres(limit: Limit, every: Sequence[Search]) -> list[Array]:
    """Points of a limit nearest to the median, whether it is smooth there or not.

    Raises
    ------
    SolverError
        If the limit is not reached.
    OptionError
        If the functional depends on none of the parameters.
    """
    found = [search.u for search in every if search.is_on_surface]
    if not found:
        raise nothing_found(limit, every)
    found.sort(key=lambda u: float(np.linalg.norm(u)))
    near = float(np.linalg.norm(found[0]))
    kept: list[Array] = []
    for u in found:
        apart = [float(np.linalg.norm(u - v)) for v in kept]
        if np.linalg.norm(u) <= near + _BESIDE and min(apart, default=np.inf) > _SAME:
            kept.append(u)
    return kept


def around(limit: Limit, points: Sequence[Array], runs: int, seed: int) -> Sampled:
    """Importance sampling with normal densities around points of the limit.

    Samples are shared among the points by the probabilities beyond them. Where the median exceeds
    the limit, the probability that it is kept is estimated.

    Parameters
    ----------
    points : sequence of ndarray, each of shape (d,)
        In standard normal space.
    runs, seed : int
        Number of samples, and the seed of their numbers.

    Raises
    ------
    SolverError
        If no sample lies beyond the limit.

    Notes
    -----
    R. E. Melchers: Importance sampling in structural systems. Structural Safety 6 (1989) 3-10.
    """
    middle, distances = np.array(points), np.linalg.norm(points, axis=1)
    shares = scipy.special.ndtr(-distances)
    shares = shares / shares.sum()
    random = np.random.default_rng(seed)
    which = random.choice(len(points), size=runs, p=shares)
    u = middle[which] + random.standard_normal((runs, middle.shape[1]))
    excess = limit.values(u)
    # density of the parameters over that of the samples
    logs = u @ middle.T - 0.5 * distances**2
    weights = np.exp(-scipy.special.logsumexp(logs, axis=1, b=shares))
    is_rare = excess > 0 if limit.is_kept_by_median else excess <= 0
    failed = np.isnan(excess)
    counted = np.where(is_rare, weights, 0.0)
    rare = float(counted.mean())
    if not rare:
        raise SolverError(
            f"{limit.head}: none of {runs} samples around {limit.combination(middle[0])} lies "
            f"beyond the limit. {limit.reason} Take search='subset'."
        )
    deviation = float(counted.std() / np.sqrt(runs) / rare)
    unknown = float(np.where(failed, weights, 0.0).mean())
    remarks = []
    beyond = u[is_rare]
    first = beyond[np.linalg.norm(beyond, axis=1).argmin()]
    if np.linalg.norm(first) < distances.min() - _NEARER:
        remarks.append(
            f"{limit.combination(first)} lies beyond the limit at a distance of "
            f"{np.linalg.norm(first):.3g}, nearer than the design point at {distances.min():.3g}; "
            "more of these may have been missed, so compare with search='subset'"
        )
    most = counted.max() / counted.sum()
    if most > _MOST:
        remarks.append(
            f"one sample makes {most:.0%} of the estimate, so its interval is too narrow; take "
            "more runs, or search='subset'"
        )
    return Sampled(
        *interval(rare, deviation, unknown, limit.is_kept_by_median),
        unknown,
        int(failed.sum()),
        tuple(remarks),
    )
