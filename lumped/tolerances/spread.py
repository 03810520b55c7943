"""How one functional scatters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from lumped.errors import OptionError, ParameterError, SolverError
from lumped.support.arrays import Boolean, Real
from lumped.support.ranking import ranks
from lumped.support.units import plain
from lumped.tolerances.evaluated import Failures
from lumped.tolerances.intervals import Quantile, Share, quantile_of, share_of

_DEGREE = 4
"""Of the polynomials in the score of one parameter that explain a functional."""


class Spread:
    """How a functional scatters.

    Attributes
    ----------
    label, unit : str
        The functional, and its unit.
    mean, std, skewness : float
        Of its distribution.
    ranking : tuple of (str, float)
        Parameters and the share of the variance that each explains alone, the largest first.
    missing : Share or None
        Share of runs that have no value: they failed, or an event did not happen. None where
        nothing was sampled.
    """

    label: str
    unit: str
    mean: float
    std: float
    skewness: float
    ranking: tuple[tuple[str, float], ...]
    missing: Share | None = None

    def __init__(
        self, label: str, unit: str, names: tuple[str, ...], x: Real, values: Real
    ) -> None:
        """Keep a population: parameters of shape (n, d) and values of shape (n,)."""
        self.label, self.unit = label, unit
        self._names, self._x, self._values = names, x, values
        self._ascending = np.sort(values)

    def quantile(self, q: float) -> Quantile:
        """The value that is not exceeded with a probability, and its interval.

        Parameters
        ----------
        q : float
            Between 0 and 1.

        Raises
        ------
        OptionError
            If it is not, or no run has the functional.
        """
        if not 0 < q < 1:
            raise OptionError(f"scatter: quantile({q:g}): a number between 0 and 1 is needed.")
        if not len(self._ascending):
            raise OptionError(f"scatter: no run has {self.label}.")
        found = quantile_of(self._ascending, float(q))
        off = self._error_near(found.value)
        return Quantile(found.value, found.low - off, found.high + off)

    def share(self, *, above: float | str | None = None, below: float | str | None = None) -> Share:
        """Share of the population beyond a limit, and its interval.

        Parameters
        ----------
        above, below : float or str
            One of both; in the SI unit of the functional or with a unit, such as ``"3 MN.m"``.

        Raises
        ------
        OptionError
            If it is not one of both.
        UnitError
            If a unit does not fit.
        """
        limit, is_above = self._limit(above, below)
        off = self._error_near(limit) * (1 if is_above else -1)
        value, least, most = (
            share_of(int(self._is_beyond(end, is_above).sum()), len(self._values))
            for end in (limit, limit + off, limit - off)
        )
        return Share(value.value, least.low, most.high)

    def causes(
        self, *, above: float | str | None = None, below: float | str | None = None
    ) -> tuple[tuple[str, float], ...]:
        """Parameters that decide whether the functional is beyond a limit, the strongest first.

        Each with the share of the variance of this verdict (1 beyond, 0 not) that it explains
        alone; what is left, parameters decide together.

        Parameters
        ----------
        above, below : float or str
            As for `share`.

        Raises
        ------
        OptionError
            If it is not one of both, or none or all of the population is beyond the limit.
        UnitError
            If a unit does not fit.
        """
        limit, is_above = self._limit(above, below)
        verdict = self._is_beyond(limit, is_above).astype(float)
        if verdict.min(initial=1.0) == verdict.max(initial=0.0):
            raise OptionError(
                f"scatter: causes of {self.label}: {'all' if verdict.any() else 'none'} of "
                f"{len(verdict)} values are beyond the limit. Take a limit between them, or more "
                "runs."
            )
        shares = np.array([explain_variance(column, verdict) for column in self._x.T])
        return rank_shares(self._names, shares)

    def sample(self) -> Real:
        """Values that are distributed like the functional, ascending, for histograms."""
        return self._ascending

    def _limit(self, above: float | str | None, below: float | str | None) -> tuple[float, bool]:
        given = [limit for limit in (above, below) if limit is not None]
        if len(given) != 1:
            raise OptionError(f"scatter: {self.label}: give a limit, above= or below=.")
        what = f"scatter: {self.label}: the limit ="
        return plain(given[0], self.unit, what, ParameterError), above is not None

    def _is_beyond(self, limit: float, above: bool) -> Boolean:
        return self._values > limit if above else self._values < limit

    def _error_near(self, level: float) -> float:
        """Error of the values of the population near a level, beside that of a sample."""
        return 0.0

    def trust(self) -> str:
        """How far the numbers hold, in words; empty where their intervals tell it."""
        return ""


class SampledSpread(Spread):
    """From values of a sample.

    Parameters
    ----------
    label, unit : str
    names : tuple of str
        Of the parameters.
    x : ndarray, shape (n, d)
        Parameters.
    values : ndarray, shape (n,)
        nan where there is none; infinity is a value, such as the damage of a part that breaks at
        once.
    """

    def __init__(
        self, label: str, unit: str, names: tuple[str, ...], x: Real, values: Real
    ) -> None:
        there = ~np.isnan(values)
        self.missing = share_of(int((~there).sum()), len(values))
        known = values[there]
        super().__init__(label, unit, names, x[there], known)
        self.mean = float(known.mean()) if len(known) else np.nan
        is_finite = bool(np.isfinite(known).all())
        self.std = float(known.std(ddof=1)) if len(known) > 1 and is_finite else np.nan
        self.skewness = skewness_of(known) if is_finite else np.nan
        shares = np.array([explain_variance(column, known) for column in x[there].T])
        self.ranking = rank_shares(names, shares)


class Spreads(NamedTuple):
    """How functionals scatter, and the runs from which that is known.

    Attributes
    ----------
    spreads : dict of str to Spread
        By the labels of the functionals.
    points, values : ndarray, shapes (n, d) and (n, k)
        Parameters and functionals of the runs: the sample, the check of an expansion, or what
        polynomials were fitted to.
    failures : dict of int to str
        Why runs failed.
    notes : tuple of str
        What else must be known.
    """

    spreads: dict[str, Spread]
    points: Real
    values: Real
    failures: Failures
    notes: tuple[str, ...] = ()


def explain_variance(x: Real, y: Real) -> float:
    """Share of the variance of y that a smooth function of x explains, alone.

    Polynomials in the standard normal score of the rank of x; with the degrees of freedom taken
    off (adjusted coefficient of determination). For independent parameters it is the first-order
    Sobol index of such a function.
    """
    n = len(y)
    if n <= _DEGREE + 2 or not np.isfinite(y).all() or not y.std() > 0:
        return np.nan
    score = scipy.special.ndtri((ranks(x) + 0.5) / n)
    basis = np.linalg.qr(np.vander(score, _DEGREE + 1))[0]
    off = y - y.mean()
    left = off - basis @ (basis.T @ off)
    rest = float(left @ left) / float(off @ off) * (n - 1) / (n - 1 - _DEGREE)
    return max(1.0 - rest, 0.0)


def skewness_of(values: Real) -> float:
    """Third central moment over the cube of the deviation; nan where nothing scatters."""
    off = values - values.mean() if len(values) else values
    deviation = float(np.sqrt(np.mean(off**2))) if len(values) else 0.0
    return float(np.mean(off**3)) / deviation**3 if deviation else np.nan


def rank_shares(names: tuple[str, ...], shares: Real) -> tuple[tuple[str, float], ...]:
    """Parameters and their shares, the largest first."""
    return tuple((names[j], float(shares[j])) for j in np.argsort(-shares, kind="stable"))


def refuse_infinite(analysis: str, label: str, values: Real) -> None:
    """Refuse values through which no smooth function goes.

    Raises
    ------
    SolverError
        If some are infinite.
    """
    count = int(np.isinf(values).sum())
    if count:
        raise SolverError(
            f"{analysis}: {label} is infinite in {count} of {len(values)} runs, as the damage of a "
            "part that breaks at once, so it is not smooth. Take search='samples'.",
            None,
        )
