"""Scatter by polynomials of the parameters, fitted to few runs and their gradients."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import Changes
from lumped.ensembles.laws import Array
from lumped.ensembles.variants import Over, Sampling
from lumped.errors import OptionError, SolverError, nearest, shown
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, listed, number, table
from lumped.tolerances.expansion import LEAST, Expansion, fit
from lumped.tolerances.polynomials import NORMAL, Family, family_of, standard_normal
from lumped.tolerances.scene import Scattered, Scene, scene_of
from lumped.tolerances.shares import correlated, refuse_correlated, shares_table

__all__ = ["Chaos", "chaos", "chaos_of"]

_SAMPLE = 2**16
"""Points at which the polynomials are evaluated for quantiles."""
_SEED = 0
_GOOD = 0.9
"""Share of the variance that must be predicted for results to be trusted."""
_TOLD = (0.01, 0.99)
"""Quantiles in a printed result."""


@dataclass(frozen=True, eq=False)
class Chaos(RichHtml):
    """Polynomials that stand for functionals of scattering parameters, and what follows.

    Attributes
    ----------
    names : tuple of str
        Parameters that scatter, d of them.
    labels, units : tuple of str
        Functionals and their units, k of each.
    expansions : tuple of Expansion
        Polynomials of each functional.
    points, values_of_runs : ndarray, shapes (n, d) and (n, k)
        Parameters and functionals of the runs that were made.
    failures : dict of int to str
        Why runs failed, by their number; they did not serve.
    scene : Scene
        What scatters.
    """

    names: tuple[str, ...]
    labels: tuple[str, ...]
    units: tuple[str, ...]
    expansions: tuple[Expansion, ...]
    points: Array
    values_of_runs: Array
    failures: dict[int, str]
    scene: Scene

    @property
    def runs(self) -> int:
        """Runs that were made."""
        return len(self.points)

    @property
    def mean(self) -> Array:
        """Means of the functionals, shape (k,)."""
        return np.array([one.mean for one in self.expansions])

    @property
    def std(self) -> Array:
        """Standard deviations, with what the polynomials leave, shape (k,)."""
        return np.sqrt([one.variance for one in self.expansions])

    @property
    def standard_errors(self) -> Array:
        """Of means and of standard deviations, from leaving out each run, shape (k, 2)."""
        return np.array([one.standard_errors for one in self.expansions])

    @property
    def q2(self) -> Array:
        """Share of the variance that is predicted for a run by a fit without it, shape (k,)."""
        return np.array([one.q2 for one in self.expansions])

    @property
    def first(self) -> Array:
        """Share of the variance that each parameter has alone, shape (k, d).

        Raises
        ------
        OptionError
            If parameters are correlated, so that their shares are not defined.
        """
        return self._shares()[0]

    @property
    def total(self) -> Array:
        """Share of the variance that each parameter has a part in, shape (k, d).

        Raises
        ------
        OptionError
            If parameters are correlated, so that their shares are not defined.
        """
        return self._shares()[1]

    def _shares(self) -> tuple[Array, Array]:
        refuse_correlated(self.scene)
        pairs = [one.shares() for one in self.expansions]
        return np.array([first for first, _ in pairs]), np.array([total for _, total in pairs])

    def values(self, u: Array) -> Array:
        """The polynomials at independent standard normal numbers (see `Scene.physical`).

        Parameters
        ----------
        u : ndarray, shape (n, d)

        Returns
        -------
        ndarray, shape (n, k)
        """
        return self._at(_variables(self.scene, self._families, u))

    @property
    def _families(self) -> tuple[Family, ...]:
        return self.expansions[0].families

    def _at(self, z: Array) -> Array:
        return np.column_stack([one.values(z) for one in self.expansions])

    @cached_property
    def _many(self) -> tuple[Array, Array]:
        """Variables of many points, and the polynomials there."""
        z = _variables(self.scene, self._families, self.many_scores)
        return z, self._at(z)

    @property
    def many_scores(self) -> Array:
        """Standard normal numbers of the sample, shape (65536, d)."""
        return self.scene.scores(_SAMPLE, _SEED, "sobol")

    @cached_property
    def sample(self) -> Array:
        """Functionals at many points, shape (65536, k).

        What the polynomials leave is added: residuals of runs, drawn at random.
        """
        at = np.random.default_rng(_SEED).random(_SAMPLE)
        left = [one.residuals[(at * len(one.residuals)).astype(int)] for one in self.expansions]
        found: Array = self._many[1] + np.column_stack(left)
        return found

    def quantile(self, label: str, q: float | Sequence[float] | Array) -> tuple[Array, Array]:
        """Quantiles of a functional and their standard errors, from leaving out each run.

        Parameters
        ----------
        label : str
            Of the functional.
        q : float or sequence of float
            Between 0 and 1.

        Returns
        -------
        ndarray
            Quantiles, one for each of `q`.
        ndarray
            Their standard errors.

        Raises
        ------
        OptionError
            If there is no such functional.
        """
        if label not in self.labels:
            raise OptionError(f"chaos: there is no '{label}'. {nearest(label, self.labels)}")
        k = self.labels.index(label)
        z, values = self._many
        found = np.quantile(self.sample[:, k], np.atleast_1d(q))
        plain = np.quantile(values[:, k], np.atleast_1d(q))
        return found, np.array([self.expansions[k].error_near(z, values[:, k], v) for v in plain])

    @property
    def doubts(self) -> tuple[str, ...]:
        """Why results may not be trusted, and what to do; empty where nothing speaks against it."""
        found = [
            f"{label}: a fit without a run predicts {max(one.q2, 0.0):.0%} of the variance of such "
            "runs. The functional jumps or has kinks within these ranges, or the runs are too "
            'few. Take more runs, or lumped.scatter with method="samples".'
            for label, one in zip(self.labels, self.expansions, strict=True)
            if not one.q2 >= _GOOD
        ]
        if self.failures:
            run, reason = next(iter(self.failures.items()))
            found.append(
                f"{len(self.failures)} of {self.runs} runs have no result; where they failed, the "
                'polynomials go on from the others. lumped.scatter with method="samples" counts '
                f"them. Run {run}: {reason}"
            )
        return tuple(found)

    def __repr__(self) -> str:
        rows = []
        for label, unit, one in zip(self.labels, self.units, self.expansions, strict=True):
            (low, high), _ = self.quantile(label, _TOLD)
            *texts, shown_unit = amounts(label, unit, one.mean, low, high)
            off, _ = amounts(label, unit, float(np.sqrt(one.variance)), is_change=True)
            fitted = "gradients" if one.with_slopes else "values"
            kind = (str(one.degree), str(len(one.coefficients)), fitted, number(one.q2, 4))
            rows.append((label, texts[0], off, *texts[1:], shown_unit, *kind))
        quantiles = [f"{100 * q:g} %" for q in _TOLD]
        head = ("functional", "mean", "deviation", *quantiles, "unit")
        parts = [
            f"polynomials of {listed(self.names)}; {self.runs} runs, {len(self.failures)} failed",
            table((*head, "degree", "terms", "fitted to", "predicted"), rows),
        ]
        if not correlated(self.scene).any():
            shares = zip(self.labels, self.first, self.total, strict=True)
            parts.append(shares_table(self.names, list(shares)))
        return "\n".join([*parts, *self.doubts])


@checked
def chaos(
    what: Scattered,
    *,
    over: Over,
    of: Mapping[str, Any] | Iterable[Any],
    until: float | str | None = None,
    parameters: Changes | None = None,
    start: Changes | None = None,
    runs: int = 200,
    seed: int = 0,
    sampling: Sampling = "sobol",
    derivatives: bool = True,
    rtol: float = 1e-6,
    workers: int | None = None,
) -> Chaos:
    """How results scatter, by polynomials that are fitted to few runs.

    For functionals that are smooth over the ranges of the parameters. Means, standard deviations
    and shares of the parameters in the variance follow from the coefficients, quantiles from a
    large sample of the polynomials.

    Parameters
    ----------
    what, over, of, until, parameters, start, rtol, workers
        As for `lumped.tolerances.scene_of`.
    runs : int
        At least 10.
    seed, sampling
        How they are drawn, as for `ensemble`.
    derivatives : bool
        Also fit the gradient of each run. It counts as many values as there are parameters. For a
        small drive a run with its gradient takes longer than as many runs side by side; then
        more runs without gradients are better.

    Returns
    -------
    Chaos

    Raises
    ------
    OptionError
        If an option makes no sense, or a functional has no derivative.
    SolverError
        If fewer than 10 runs have a result.
    """
    scene = scene_of(
        what,
        over=over,
        of=of,
        until=until,
        parameters=parameters,
        start=start,
        rtol=rtol,
        workers=workers,
        analysis="chaos",
    )
    return chaos_of(scene, runs, seed, sampling, derivatives)


def chaos_of(scene: Scene, runs: int, seed: int, sampling: Sampling, derivatives: bool) -> Chaos:
    """The same for a scene (see `chaos`)."""
    if not runs >= LEAST:
        raise OptionError(f"{scene.analysis}: runs = {shown(runs)}: at least {LEAST} are needed.")
    together = correlated(scene)
    grid = scene.physical(np.tile(standard_normal()[:, None], len(scene.names)))
    families = tuple(
        NORMAL if together[j] else family_of(grid[:, j]) for j in range(len(scene.names))
    )
    u = scene.scores(runs, seed, sampling)
    x, z = scene.physical(u), _variables(scene, families, u)
    slopes: NDArray[np.float64] | None = None
    if derivatives:
        try:
            values, slopes = scene.slopes(x)
        except OptionError as error:
            raise OptionError(f"{error} Or fit values alone, by derivatives=False.") from None
        slopes = slopes @ _moved(scene, families, u)
    else:
        values = scene.values(x)
    expansions = []
    for k, label in enumerate(scene.labels):
        there = np.isfinite(values[:, k])
        if there.sum() < LEAST:
            reason = next(iter(scene.failures.items()), (0, "it has no value"))
            raise SolverError(
                f"{scene.analysis}: {there.sum()} of {runs} runs have a {label}; {LEAST} are "
                f"needed. Run {reason[0]}: {reason[1]}"
            )
        own = None if slopes is None else slopes[there, k]
        expansions.append(fit(families, z[there], values[there, k], own))
    return Chaos(
        scene.names,
        scene.labels,
        scene.units,
        tuple(expansions),
        x,
        values,
        dict(scene.failures),
        scene,
    )


def _variables(scene: Scene, families: Sequence[Family], u: Array) -> Array:
    """Variables of the polynomials for standard normal numbers, shape (n, d)."""
    x, z = scene.physical(u), np.array(u, dtype=float)
    for j, family in enumerate(families):
        if family.bounded:
            z[:, j] = (x[:, j] - family.mean) / family.deviation
    return z


def _moved(scene: Scene, families: Sequence[Family], u: Array) -> Array:
    """Derivatives of the parameters by the variables of the polynomials, shape (n, d, d)."""
    found = np.array(scene.physical_slopes(u))
    for j, family in enumerate(families):
        if family.bounded:
            found[:, j, j] = family.deviation
    return found
