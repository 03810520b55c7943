"""Scatter by polynomials of the parameters that are fitted to a few runs and their gradients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lumped.ensembles.variants import Sampling
from lumped.errors import OptionError, SolverError, shown
from lumped.support.arrays import Real
from lumped.tolerances.expansions.expansion import LEAST, Expansion, fit_expansion
from lumped.tolerances.expansions.polynomials import NORMAL, Family, family_of, standard_normal
from lumped.tolerances.intervals import SCORE, Share, share_of
from lumped.tolerances.scene import Scene, find_correlated, refuse_correlated
from lumped.tolerances.spread import (
    Spread,
    Spreads,
    explain_variance,
    rank_shares,
    refuse_infinite,
    skewness_of,
)

_POINTS = 2**16
"""Points at which polynomials are evaluated for quantiles."""
_TRUSTED = 0.9
"""Share of the variance that must be predicted for polynomials to be believed."""


@dataclass(frozen=True, eq=False)
class _Ground:
    """What the polynomials of all functionals of a scene share.

    Attributes
    ----------
    scene : Scene
    families : tuple of Family
        Of each parameter.
    x, z : ndarray, shape (m, d)
        Many points: parameters, and variables of the polynomials.
    """

    scene: Scene
    families: tuple[Family, ...]
    x: Real
    z: Real


class PolynomialSpread(Spread):
    """From polynomials of the parameters.

    Mean and deviation follow from the coefficients, and what the polynomials leave is added to the
    variance. Quantiles and shares are those of a large sample of the polynomials, to which
    residuals of runs with values nearby are added. Intervals follow from choosing and fitting
    without a tenth of the runs each. They know nothing of what no run met: with a probability of
    5 %, n runs miss what concerns 3 / n of all.

    Attributes
    ----------
    expansion : Expansion
        The polynomials.
    predicted : float
        Share of the variance that is predicted for runs by polynomials chosen and fitted without
        them, often called Q2.
    mean_error, std_error : float
        Standard errors of the mean and of the deviation.
    is_trusted : bool
        Whether at least nine tenths of the variance are predicted.
    """

    def __init__(
        self, ground: _Ground, label: str, unit: str, expansion: Expansion, missing: Share
    ) -> None:
        self._plain = expansion.values(ground.z)
        found = expansion.add_residuals(self._plain, np.random.default_rng(0))
        names = ground.scene.names
        super().__init__(label, unit, names, ground.x, found)
        self.missing, self.expansion, self._ground = missing, expansion, ground
        self.predicted, self.is_trusted = expansion.q2, expansion.q2 >= _TRUSTED
        self.mean, self.std = expansion.mean, float(np.sqrt(expansion.variance))
        self.mean_error, self.std_error = expansion.standard_errors
        self.skewness = skewness_of(found)
        shares, self._total = expansion.shares()
        if find_correlated(ground.scene).any():
            shares = np.array([explain_variance(column, found) for column in ground.x.T])
        self.ranking = rank_shares(names, shares)

    @property
    def total(self) -> tuple[tuple[str, float], ...]:
        """Parameters and the share of the variance in which each has a part, the largest first.

        With `ranking`, the share of each alone, these are Sobol's indices.

        Raises
        ------
        OptionError
            If parameters are correlated, so that these shares do not exist.
        """
        refuse_correlated(self._ground.scene)
        return rank_shares(self._ground.scene.names, self._total)

    def at(self, u: Real) -> Real:
        """The polynomials at points.

        Parameters
        ----------
        u : ndarray, shape (n, d)
            Independent standard normal numbers for the parameters (see `Scene.physical`).

        Returns
        -------
        ndarray, shape (n,)
        """
        return self.expansion.values(_variables(self._ground.scene, self._ground.families, u))

    def _error_near(self, level: float) -> float:
        return SCORE * self.expansion.error_near(self._ground.z, self._plain, level)

    def trust(self) -> str:
        """How far the polynomials hold, in words."""
        kind = "values and gradients" if self.expansion.with_slopes else "values"
        verdict = (
            "to be trusted"
            if self.is_trusted
            else "not to be trusted, since it jumps or has kinks over these ranges or the runs are "
            "too few; take more, or search='samples'"
        )
        return (
            f"degree {self.expansion.degree} from {kind}, predicts "
            f"{100 * max(self.predicted, 0.0):.4g} % of the variance of runs left out: {verdict}"
        )


def by_chaos(
    scene: Scene, runs: int, seed: int, sampling: Sampling, *, gradients: bool = True
) -> Spreads:
    """Fit polynomials of the parameters to runs, for functionals that are smooth in them.

    Parameters
    ----------
    scene : Scene
    runs : int
        At least 10.
    seed, sampling
        How their parameters are drawn.
    gradients : bool
        Whether each run also gives its derivatives.

    Raises
    ------
    OptionError
        If there are fewer than 10 runs, or a functional has no derivatives.
    SolverError
        If fewer than 10 runs have a value.
    """
    if not runs >= LEAST:
        raise OptionError(f"{scene.analysis}: runs = {shown(runs)}: at least {LEAST} are needed.")
    grid = scene.physical(np.tile(standard_normal()[:, None], len(scene.names)))
    families = tuple(
        NORMAL if is_one else family_of(grid[:, j])
        for j, is_one in enumerate(find_correlated(scene))
    )
    u = scene.scores(runs, seed, sampling)
    x, z = scene.physical(u), _variables(scene, families, u)
    slopes: Real | None = None
    if gradients:
        try:
            values, slopes = scene.slopes(x)
        except OptionError as error:
            raise OptionError(f"{error} Or fit polynomials to values, gradients=False.") from None
        slopes = slopes @ _derive_parameters(scene, families, u)
    else:
        values = scene.values(x)
    failures = dict(scene.failures)
    many = scene.scores(_POINTS, seed, "sobol")
    ground = _Ground(scene, families, scene.physical(many), _variables(scene, families, many))
    spreads: dict[str, Spread] = {}
    for k, (label, unit) in enumerate(zip(scene.labels, scene.units, strict=True)):
        refuse_infinite(scene.analysis, label, values[:, k])
        there = np.isfinite(values[:, k])
        count = int(there.sum())
        if count < LEAST:
            run, reason = next(iter(failures.items()), (0, "it is no number."))
            raise SolverError(
                f"{scene.analysis}: {count} of {runs} runs have {label}; polynomials need {LEAST}. "
                f"Run {run}: {reason}",
                None,
            )
        own = None if slopes is None else slopes[there, k]
        found = fit_expansion(families, z[there], values[there, k], own)
        missing = share_of(runs - count, runs)
        spreads[label] = PolynomialSpread(ground, label, unit, found, missing)
    notes: tuple[str, ...] = ()
    if failures:
        notes = (
            f"{len(failures)} of {runs} runs have no value; there the polynomials go on from the "
            "others. search='samples' leaves out what has no value.",
        )
    return Spreads(spreads, x, values, failures, notes)


def _variables(scene: Scene, families: Sequence[Family], u: Real) -> Real:
    """Variables of the polynomials for standard normal numbers, shape (n, d)."""
    x, z = scene.physical(u), np.array(u, dtype=float)
    for j, family in enumerate(families):
        if family.bounded:
            z[:, j] = (x[:, j] - family.mean) / family.deviation
    return z


def _derive_parameters(scene: Scene, families: Sequence[Family], u: Real) -> Real:
    """Derivatives of the parameters by the variables of the polynomials, shape (n, d, d)."""
    found = np.array(scene.physical_slopes(u))
    for j, family in enumerate(families):
        if family.bounded:
            found[:, j, j] = family.deviation
    return found
