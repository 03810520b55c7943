"""Probability that a limit is exceeded, from samples: around design points, or level by level."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.errors import Interrupted, OptionError, SolverError
from lumped.numerics.nearest_points import Search
from lumped.support.arrays import Boolean, Real
from lumped.tolerances.failure.form import nothing_found
from lumped.tolerances.failure.limit import Limit
from lumped.tolerances.intervals import SCORE


@dataclass(frozen=True)
class Level:
    """One level of subset simulation.

    Attributes
    ----------
    value : float
        Of the functional, which is exceeded with the probability.
    probability : float
        That of this level, with those before it.
    accepted : float
        Share of the moves to the next sample that were taken; 1 for independent samples.
    """

    value: float
    probability: float
    accepted: float


@dataclass(frozen=True)
class Sampled:
    """A probability, and what is known of its error where it was sampled.

    Attributes
    ----------
    probability : float
        The estimate.
    deviation : float
        Its coefficient of variation; zero where nothing was sampled.
    interval : (float, float) or None
        Of 95 %, with a normal logarithm; the upper end includes `unknown`.
    unknown : float
        Probability of evaluations that failed.
    failed : int
        How many failed.
    notes : tuple of str
        What speaks against the estimate.
    levels : tuple of Level
        Of subset simulation.
    """

    probability: float
    deviation: float
    interval: tuple[float, float] | None
    unknown: float
    failed: int
    notes: tuple[str, ...] = ()
    levels: tuple[Level, ...] = ()

    @classmethod
    def from_computation(cls, probability: float, notes: tuple[str, ...] = ()) -> Sampled:
        """A probability that was computed without samples."""
        return cls(probability, 0.0, None, 0.0, 0, notes)


def interval(
    rare: float, deviation: float, unknown: float, is_rare: bool
) -> tuple[float, float, tuple[float, float]]:
    """Probability, coefficient of variation and interval of 95 % of an event.

    Parameters
    ----------
    rare, deviation : float
        Probability of the event, or of its contrary, and coefficient of variation.
    unknown : float
        Probability of evaluations that failed, in which the event may happen.
    is_rare : bool
        Whether it is the event that was estimated.
    """
    wide = math.exp(SCORE * deviation)
    low, high = rare / wide, min(rare * wide, 1.0)
    if is_rare:
        return rare, deviation, (low, min(high + unknown, 1.0))
    found = 1 - rare - unknown
    return found, rare * deviation / max(found, 1e-300), (max(1 - high - unknown, 0.0), 1 - low)


_BESIDE = 2.0
"""How much farther than the nearest point others may be that are sampled too."""
_SAME = 0.2
"""Distance of two points below which one is enough."""
_NEARER = 0.1
"""How much nearer than a design point a sample may exceed the limit."""
_MOST_OF_ONE = 0.2
"""Share of one sample in the estimate, of 1."""


def centres(limit: Limit, every: Sequence[Search]) -> list[Real]:
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
    kept: list[Real] = []
    for u in found:
        apart = [float(np.linalg.norm(u - v)) for v in kept]
        if np.linalg.norm(u) <= near + _BESIDE and min(apart, default=np.inf) > _SAME:
            kept.append(u)
    return kept


def around(limit: Limit, points: Sequence[Real], runs: int, seed: int) -> Sampled:
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
    Interrupted
        With the estimate of the samples that were done, or None.

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
    try:
        return _weigh(limit, middle, shares, u, limit.values(u))
    except Interrupted as error:
        known, found = error.partial, None
        with suppress(SolverError):
            found = _weigh(limit, middle, shares, u[: len(known)], known) if len(known) else None
        raise Interrupted(str(error), found) from None


def _weigh(limit: Limit, middle: Real, shares: Real, u: Real, excess: Real) -> Sampled:
    """Estimate of a probability from samples around points, with the weights of these."""
    runs, distances = len(u), np.linalg.norm(middle, axis=1)
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
    notes = []
    beyond = u[is_rare]
    first = beyond[np.linalg.norm(beyond, axis=1).argmin()]
    if np.linalg.norm(first) < distances.min() - _NEARER:
        notes.append(
            f"{limit.combination(first)} lies beyond the limit at a distance of "
            f"{np.linalg.norm(first):.3g}, nearer than the design point at {distances.min():.3g}; "
            "more of these may have been missed, so compare with search='subset'"
        )
    most = counted.max() / counted.sum()
    if most > _MOST_OF_ONE:
        notes.append(
            f"one sample makes {most:.0%} of the estimate, so its interval is too narrow; take "
            "more runs, or search='subset'"
        )
    return Sampled(
        *interval(rare, deviation, unknown, limit.is_kept_by_median),
        unknown,
        int(failed.sum()),
        tuple(notes),
    )


_SHARE = 0.1
"""Of the samples of a level, that begin the chains of the next."""
_MOST_LEVELS = 15
"""Levels; a probability of 1e-15 is left beyond."""
_WANTED = 0.44
"""Share of moves to be accepted."""
_RISES = 1e-9
"""Rise of a level, relative to it, that is none."""


def subset(limit: Limit, runs: int, seed: int) -> Sampled:
    """Subset simulation, with Markov chains by conditional sampling.

    Each level holds a tenth of the one before; its chains go side by side, one call for a step of
    all. An evaluation that fails is not taken as a sample; its probability is told.

    Parameters
    ----------
    runs : int
        Samples of each level, at least 100.
    seed : int
        Of the random numbers.

    Raises
    ------
    OptionError
        If there are too few runs.
    SolverError
        If all evaluations fail, or the limit is not reached in 15 levels.
    Interrupted
        With the levels that were reached.

    Notes
    -----
    S.-K. Au, J. L. Beck: Estimation of small failure probabilities in high dimensions by subset
    simulation. Probabilistic Engineering Mechanics 16 (2001) 263-277 (coefficient of variation,
    levels taken as independent). I. Papaioannou, W. Betz, K. Zwirglmaier, D. Straub: MCMC
    algorithms for subset simulation. Probabilistic Engineering Mechanics 41 (2015) 89-103.
    """
    if runs < 100:
        raise OptionError(f"{limit.head}: runs = {runs}: a level needs at least 100.")
    chains = math.ceil(_SHARE * runs)
    length = runs // chains
    walk = _Walk(limit, np.random.default_rng(seed))
    u = walk.random.standard_normal((chains * length, limit.count))
    excess = walk.values(u)
    if walk.failed == len(u):
        raise SolverError(f"{limit.head}: all {len(u)} evaluations fail. {limit.reason}")
    reached, spread, unknown, failed = 1.0, 0.0, walk.failed / len(u), walk.failed
    levels: list[Level] = []
    accepted, level = 1.0, -math.inf
    while True:
        above = excess[excess > level + _RISES * abs(level)] if levels else excess
        if not len(above) or len(levels) == _MOST_LEVELS:
            raise limit.explain_unreached(f"down to a probability of {reached:.1g}")
        following = min(max(float(np.sort(excess)[-chains]), float(above.min())), 0.0)
        inside = excess > 0 if following == 0 else excess >= following
        share = float(inside.mean())
        spread += (1 - share) / (share * len(u)) * (1 + _correlate(inside, chains, bool(levels)))
        reached *= share
        levels.append(Level(limit.bound + limit.sign * following, reached, accepted))
        if following == 0:
            break
        level = following
        known = np.flatnonzero(inside)
        seeds = walk.random.choice(known, chains, replace=len(known) < chains)
        before, tried = walk.failed, walk.count
        try:
            u, excess, accepted = walk.chains(u[seeds], excess[seeds], level, length)
        except Interrupted as error:
            raise Interrupted(str(error), tuple(levels)) from None
        lost = walk.failed - before
        failed += lost
        unknown = max(unknown, reached * lost / (walk.count - tried))
    deviation = math.sqrt(spread)
    return Sampled(*interval(reached, deviation, unknown, True), unknown, failed, (), tuple(levels))


class _Walk:
    """Samples of a limit, and chains of them."""

    def __init__(self, limit: Limit, random: np.random.Generator) -> None:
        self.limit, self.random = limit, random
        self.failed = self.count = 0
        self.step = 0.6
        """How far a move goes, of 1 for one that forgets where it began."""

    def values(self, u: Real) -> Real:
        """Excess at points, without limit below where an evaluation failed."""
        found = self.limit.values(u)
        self.count += len(u)
        self.failed += int(np.isnan(found).sum())
        return np.where(np.isnan(found), -np.inf, found)

    def chains(self, u: Real, excess: Real, level: float, length: int) -> tuple[Real, Real, float]:
        """Samples above a level, chain by chain in steps, and the share of moves accepted."""
        every, found, moved = [u], [excess], []
        for k in range(1, length):
            stay = math.sqrt(1 - self.step**2)
            there = stay * u + self.step * self.random.standard_normal(u.shape)
            value = self.values(there)
            goes = value >= level
            u, excess = np.where(goes[:, None], there, u), np.where(goes, value, excess)
            every.append(u)
            found.append(excess)
            moved.append(float(goes.mean()))
            self.step = min(self.step * math.exp((moved[-1] - _WANTED) / math.sqrt(k)), 1.0)
        return np.concatenate(every), np.concatenate(found), float(np.mean(moved))


def _correlate(inside: Boolean, chains: int, are_chains: bool) -> float:
    """What the samples of a chain repeat of each other: gamma of Au and Beck."""
    share = float(inside.mean())
    if not are_chains or share in (0.0, 1.0):
        return 0.0
    steps = inside.reshape(-1, chains).astype(float)  # one row for each step
    length, total = len(steps), 0.0
    for k in range(1, length):
        both = float((steps[k:] * steps[:-k]).mean()) - share**2
        total += 2 * (1 - k / length) * both / (share * (1 - share))
    return max(total, 0.0)
