"""Probability that a limit is exceeded, from samples around its design points."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy

from lumped.errors import SolverError
from lumped.tolerances.form import searches
from lumped.tolerances.limit import Array, Limit
from lumped.tolerances.sampled import Sampled, interval

__all__ = ["around", "centres"]

_NEARER = 0.1
"""How much nearer than a design point a sample may exceed the limit."""
_MOST = 0.2
"""Share of one sample in the estimate, of 1."""


def centres(limit: Limit, starts: int) -> list[Array]:
    """Where a limit is nearest to the median, whether it is smooth there or not.

    Raises
    ------
    SolverError
        If the limit is not reached.
    """
    found = [search.u for search in searches(limit, starts=starts) if search.is_on_surface]
    if not found:
        raise limit.unreached("where gradients lead")
    near = min(float(np.linalg.norm(u)) for u in found)
    return [u for u in found if np.linalg.norm(u) <= near + 2]


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
            f"beyond the limit. {limit.reason} Take method='subset'."
        )
    deviation = float(counted.std() / np.sqrt(runs) / rare)
    unknown = float(np.where(failed, weights, 0.0).mean())
    remarks = []
    nearest = float(np.linalg.norm(u[is_rare], axis=1).min())
    if nearest < distances.min() - _NEARER:
        remarks.append(
            f"a sample beyond the limit is only {nearest:.3g} from the median, nearer than the "
            f"design point at {distances.min():.3g}: {limit.combination(u[is_rare][np.linalg.norm(u[is_rare], axis=1).argmin()])}; there may be more of "
            "these, so compare with method='subset'"
        )
    if counted.max() > _MOST * counted.sum():
        remarks.append(
            f"one sample makes {counted.max() / counted.sum():.0%} of the estimate, so its interval "
            "cannot be trusted; take more runs, or method='subset'"
        )
    return Sampled(
        *interval(rare, deviation, unknown, limit.is_kept_by_median),
        unknown,
        int(failed.sum()),
        tuple(remarks),
    )
