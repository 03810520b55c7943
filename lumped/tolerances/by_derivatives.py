"""Scatter by derivatives: first and second order about the mean, checked by a few runs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.errors import OptionError, SolverError
from lumped.support.text_table import listed
from lumped.tolerances.evaluated import Array, Failures
from lumped.tolerances.intervals import Quantile, Share, share_of
from lumped.tolerances.moments import central_moments, quadratic_moments
from lumped.tolerances.scene import Scene
from lumped.tolerances.spread import Spread

__all__ = ["ExpandedSpread", "Expansions", "expanded"]

_TRUSTED = 0.1
"""Root mean square of what an expansion misses, over the deviation, up to which it is believed."""
_SHOWN = 20_000
"""Values of an expansion in a histogram."""


class ExpandedSpread(Spread):
    """From the moments of an expansion, by Cornish and Fisher.

    Attributes
    ----------
    order : int
        1 or 2: of the expansion.
    error : float
        Root mean square of what it misses in the runs of the check, over their deviation.
    worst : float
        The largest of what it misses, in the unit of the functional; quantiles may be so far off.
    is_trusted : bool
        Whether `error` is at most a tenth.
    """

    def __init__(
        self,
        label: str,
        unit: str,
        moments: tuple[float, float, float],
        ranking: tuple[tuple[str, float], ...],
        order: int,
        checked: tuple[Array, Array],
        sample: Array,
    ) -> None:
        self.label, self.unit, self.order, self.ranking = label, unit, order, ranking
        self.mean, variance, third = moments
        self.std = math.sqrt(variance)
        self.skewness = third / self.std**3 if self.std else math.nan
        true, found = checked
        there = np.isfinite(true)
        missed = (true - found)[there]
        self.missing = share_of(int((~there).sum()), len(true))
        self.worst = float(np.abs(missed).max(initial=0.0)) if there.any() else math.inf
        size = float(true[there].std()) if there.any() else math.nan
        self.error = float(np.sqrt(np.mean(missed**2))) / size if size else math.nan
        self.is_trusted = self.error <= _TRUSTED
        self._sample = np.sort(sample)

    def _quantile(self, q: float) -> Quantile:
        value = self.mean + self.std * self._stretched(float(scipy.special.ndtri(q)))
        return Quantile(value, value - self.worst, value + self.worst)

    def _share(self, limit: float, above: bool) -> Share:
        side = 1.0 if above else -1.0
        found = [
            self._beyond((limit + off * side * self.worst - self.mean) / self.std, side)
            for off in (0, 1, -1)
        ]
        return Share(*found)

    def sample(self) -> Array:
        """Values of the expansion."""
        return self._sample

    def _stretched(self, z: float) -> float:
        """Score of a distribution with this skewness for that of a normal one.

        Raises
        ------
        OptionError
            Where scores would fall while probabilities rise.
        """
        skew = self.skewness
        if self._rise(z) <= 0:
            raise OptionError(
                f"scatter: {self.label} is too skew ({skew:.3g}) for Cornish and Fisher's series "
                "at this probability. Take method='samples'."
            )
        return z + (z * z - 1) * skew / 6 - (2 * z**3 - 5 * z) * skew**2 / 36

    def _rise(self, z: float) -> float:
        return 1 + z * self.skewness / 3 - (6 * z * z - 5) * self.skewness**2 / 36

    def _beyond(self, score: float, side: float) -> float:
        """Probability of more, or of less, than a score."""
        reach = 8.0
        while reach > 0.1 and min(self._rise(reach), self._rise(-reach)) <= 0:
            reach -= 0.1
        ends = self._stretched(-reach), self._stretched(reach)
        if not ends[0] < score < ends[1]:
            return float((score > 0) != (side > 0))
        z = scipy.optimize.brentq(lambda at: self._stretched(at) - score, -reach, reach)
        return float(scipy.special.ndtr(-side * z))


@dataclass(frozen=True, eq=False)
class Expansions:
    """What an expansion gave.

    Attributes
    ----------
    spreads : dict of str to ExpandedSpread
    points, values : ndarray, shapes (n, d) and (n, k)
        Runs of the check.
    failures : dict of int to str
        Why runs of the check failed.
    notes : tuple of str
        Of what is of first order, and why.
    """

    spreads: dict[str, ExpandedSpread]
    points: Array
    values: Array
    failures: Failures
    notes: tuple[str, ...]


def expanded(scene: Scene, runs: int, seed: int) -> Expansions:
    """Expand functionals about the mean, and check that by some runs.

    Independent parameters are expanded in themselves, with the moments of their distributions up to
    the sixth; dependent ones in the independent normal variables behind them.

    Raises
    ------
    SolverError
        If there are no derivatives at the mean.
    OptionError
        If nothing that scatters changes a functional.
    """
    laws, mixing = scene.marginals.laws, scene.marginals.mixing
    d = len(laws)
    independent = np.array_equal(mixing, np.eye(d))
    means, central = (np.array(part) for part in zip(*map(central_moments, laws), strict=True))
    if independent:
        begin = means
    else:
        begin = scene.physical(np.zeros((1, d)))[0]
        central = np.tile([1.0, 0.0, 1.0, 0.0, 3.0, 0.0, 15.0], (d, 1))
    values, slopes = scene.slopes(begin[None])
    if scene.failures:
        raise SolverError(
            f"{scene.analysis}: there are no derivatives at the mean: {scene.failures[0]} Take "
            "method='samples'.",
            None,
        )
    random = np.random.default_rng(seed)
    u = random.standard_normal((runs, d))
    many = random.standard_normal((_SHOWN, d))
    x = scene.physical(u)
    true, failures = scene.values(x), dict(scene.failures)
    spreads, notes = {}, dict[str, list[str]]()
    for i, (label, unit) in enumerate(zip(scene.labels, scene.units, strict=True)):
        slope, curvature = slopes[0, i], np.zeros((d, d))
        order = 2
        try:
            curvature = scene.curvature(begin, i)
        except (OptionError, SolverError) as error:
            order = 1
            notes.setdefault(str(error), []).append(label)
        if not independent:
            slope, curvature = scene.in_scores(np.zeros(d), slope, curvature)
        if not (slope.any() or curvature.any()):
            raise OptionError(
                f"{scene.analysis}: nothing that scatters changes {label} to second order. Leave "
                "it out, or take method='samples'."
            )

        def at(u: Array, slope: Array = slope, curvature: Array = curvature, i: int = i) -> Array:
            v = scene.physical(u) - begin if independent else u
            quadratic = 0.5 * np.einsum("ni,ij,nj->n", v, curvature, v)
            found: Array = values[0, i] + v @ slope + quadratic
            return found

        moments = quadratic_moments(float(values[0, i]), slope, curvature, central)
        shares = _shares(slope, curvature, central, mixing, moments.variance, independent)
        ranking = tuple((scene.names[j], float(shares[j])) for j in np.argsort(-shares))
        checked = true[:, i], at(u)
        spreads[label] = ExpandedSpread(label, unit, moments, ranking, order, checked, at(many))
    told = [f"first order for {listed(labels)}: {text}" for text, labels in notes.items()]
    return Expansions(spreads, x, true, failures, tuple(told))


def _shares(
    slope: Array,
    curvature: Array,
    central: Array,
    mixing: Array,
    variance: float,
    independent: bool,
) -> Array:
    """Share of the variance that each parameter explains alone."""
    if not independent:  # square of the correlation with it, to first order
        found: Array = (mixing @ slope) ** 2 / (slope @ slope)
        return found
    _, _, m2, m3, m4, *_ = central.T
    own = 0.5 * np.diag(curvature)
    alone: Array = slope**2 * m2 + 2 * slope * own * m3 + own**2 * (m4 - m2**2)
    return alone / variance
