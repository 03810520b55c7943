"""Probability that a limit is exceeded, level by level, without derivatives."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from lumped.errors import OptionError, SolverError
from lumped.tolerances.failure.limit import Array, Limit
from lumped.tolerances.failure.sampled import Level, Sampled, interval

_SHARE = 0.1
"""Of the samples of a level, that begin the chains of the next."""
_MOST = 15
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
        if not len(above) or len(levels) == _MOST:
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
        u, excess, accepted = walk.chains(u[seeds], excess[seeds], level, length)
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

    def values(self, u: Array) -> Array:
        """Excess at points, without limit below where an evaluation failed."""
        found = self.limit.values(u)
        self.count += len(u)
        self.failed += int(np.isnan(found).sum())
        return np.where(np.isnan(found), -np.inf, found)

    def chains(
        self, u: Array, excess: Array, level: float, length: int
    ) -> tuple[Array, Array, float]:
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


def _correlate(inside: NDArray[np.bool_], chains: int, are_chains: bool) -> float:
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
