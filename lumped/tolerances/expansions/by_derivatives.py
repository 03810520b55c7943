"""Scatter by derivatives: first and second order about the mean, checked by a few runs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lumped.ensembles.laws import central_moments
from lumped.errors import OptionError, SolverError
from lumped.support.arrays import Real
from lumped.tolerances.intervals import share_of
from lumped.tolerances.scene import Scene, find_correlated
from lumped.tolerances.spread import (
    Spread,
    Spreads,
    explain_variance,
    rank_shares,
    refuse_infinite,
)

_TRUSTED = 0.1
"""Root mean square of what an expansion misses, over the deviation, up to which it is believed."""
_POINTS = 2**17
"""Points at which an expansion is evaluated for its quantiles."""


class Moments(NamedTuple):
    """Mean, variance and third central moment, and shares of variables alone in the variance."""

    mean: float
    variance: float
    third: float
    shares: Real


class ExpandedSpread(Spread):
    """From an expansion about the mean.

    Quantiles and shares are those of the expansion at Sobol points; to their intervals the largest
    of what it misses in the check is added, which of 64 runs covers 95 % of the population with a
    probability of 96 %.

    Attributes
    ----------
    order : int
        1 or 2: of the expansion.
    error : float
        Root mean square of what it misses in the runs of the check, over their deviation.
    worst : float
        The largest of what it misses, in the unit of the functional.
    is_trusted : bool
        Whether `error` is at most a tenth.
    """

    def __init__(
        self,
        label: str,
        unit: str,
        names: tuple[str, ...],
        population: tuple[Real, Real],
        moments: Moments,
        order: int,
        check: tuple[Real, Real],
    ) -> None:
        super().__init__(label, unit, names, *population)
        self.order, self.ranking = order, rank_shares(names, moments.shares)
        self.mean, self.std = moments.mean, math.sqrt(moments.variance)
        self.skewness = moments.third / self.std**3 if self.std else math.nan
        true, found = check
        there = np.isfinite(true)
        missed = (true - found)[there]
        self.missing = share_of(int((~there).sum()), len(true))
        size = float(true[there].std()) if there.any() else math.nan
        self.worst = float(np.abs(missed).max()) if there.any() else math.inf
        self.error = float(np.sqrt(np.mean(missed**2))) / size if size else math.nan
        self.is_trusted = self.error <= _TRUSTED

    def _error_near(self, level: float) -> float:
        return self.worst

    def trust(self) -> str:
        """How far the expansion holds, in words."""
        order = "second order" if self.order == 2 else "first order"
        verdict = "to be trusted" if self.is_trusted else "not to be trusted, take search='samples'"
        return f"{order}, misses {100 * self.error:.2g} % of the deviation: {verdict}"


def by_derivatives(scene: Scene, runs: int, seed: int) -> Spreads:
    """Expand functionals in the parameters about their means, and check that by some runs.

    Moments are exact for the expansion where the parameters are independent, by those of their
    distributions up to the sixth. Quantiles are those of the expansion at Sobol points.

    Raises
    ------
    SolverError
        If there are no derivatives at the mean.
    OptionError
        If nothing that scatters changes a functional.
    """
    laws = scene.marginals.laws
    independent = not find_correlated(scene).any()
    means, central = (np.array(part) for part in zip(*map(central_moments, laws), strict=True))
    values, slopes = scene.slopes(means[None])
    if scene.failures:
        raise SolverError(
            f"{scene.analysis}: there are no derivatives at the mean: {scene.failures[0]} Take "
            "search='samples'.",
            None,
        )
    points = scene.draw(runs, seed)
    true, failures = scene.values(points), dict(scene.failures)
    many = scene.physical(scene.scores(_POINTS, seed, "sobol"))
    spreads: dict[str, Spread] = {}
    notes, order = tuple[str, ...](), 2
    try:
        curvatures = scene.curvatures(means)
    except SolverError as error:
        order, curvatures = 1, np.zeros((*slopes[0].shape, len(laws)))
        notes = (f"first order: {error}",)
    for i, (label, unit) in enumerate(zip(scene.labels, scene.units, strict=True)):
        value, slope, curvature = float(values[0, i]), slopes[0, i], curvatures[i]
        if not (slope.any() or curvature.any()):
            raise OptionError(
                f"{scene.analysis}: nothing that scatters changes {label} near the mean. Leave it "
                "out, or take search='samples'."
            )
        found = _expand(many - means, value, slope, curvature)
        if independent:
            moments = quadratic_moments(value, slope, curvature, central)
        else:
            off = found - found.mean()
            shares = np.array([explain_variance(column, found) for column in many.T])
            variance = float(off @ off) / len(off)
            moments = Moments(float(found.mean()), variance, np.mean(off**3), shares)
        refuse_infinite(scene.analysis, label, true[:, i])
        check = true[:, i], _expand(points - means, value, slope, curvature)
        spreads[label] = ExpandedSpread(
            label, unit, scene.names, (many, found), moments, order, check
        )
    return Spreads(spreads, points, true, failures, notes)


def _expand(off: Real, value: float, slope: Real, curvature: Real) -> Real:
    """Values of an expansion at distances from the mean, shape (n, d)."""
    found: Real = value + off @ slope + 0.5 * ((off @ curvature) * off).sum(axis=1)
    return found


def quadratic_moments(value: float, slope: Real, curvature: Real, central: Real) -> Moments:
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
