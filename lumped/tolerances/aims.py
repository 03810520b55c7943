"""Probabilities, means and quantiles of what scatters, as aims and conditions of a design."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, NoReturn

import numpy as np
import scipy

from lumped.ensembles.variants import Over
from lumped.errors import OptimisationError, OptionError, shown
from lumped.functionals import Condition, Functional
from lumped.functionals.functional import Bounded
from lumped.support.arguments import checked


@dataclass(frozen=True, eq=False)
class Probability:
    """The probability that a functional passes a limit where parameters scatter.

    ``probability(...) <= 1e-4`` is a condition for `subject_to` of `optimise`.

    Attributes
    ----------
    of : functional
        What is limited.
    above, below : float or str or None
        The limit that it passes.
    over : mapping of name to distribution, or Correlated
        What scatters.
    runs : int
        Samples by which the result is checked.
    seed : int
        Of these.
    """

    of: Functional
    above: float | str | None
    below: float | str | None
    over: Over = field(repr=False)
    runs: int
    seed: int

    def __str__(self) -> str:
        side, limit = ("above", self.above) if self.below is None else ("below", self.below)
        told = limit if isinstance(limit, str) else f"{limit:g}"
        return f"probability({self.of} {side} {told})"

    def __le__(self, most: float | str) -> Condition:
        if isinstance(most, str | bool) or not 0 < most < 1:
            raise OptionError(
                f"{self} <= {shown(most)}: a number greater than 0 and less than 1 is needed."
            )
        return Condition(self, None, most)

    def _refuse(self, other: object) -> NoReturn:
        raise OptionError(
            f"{self} is a condition only with `<=` and a number, such as probability(...) <= 1e-4."
        )

    # what a condition cannot be made of
    __lt__ = __gt__ = __ge__ = __eq__ = __ne__ = _refuse
    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        self._refuse(None)


@checked
def probability(
    of: Functional,
    *,
    over: Any,
    above: float | str | None = None,
    below: float | str | None = None,
    runs: int = 1000,
    seed: int = 0,
) -> Probability:
    """The probability that a functional passes a limit, to be bounded or made small by `optimise`.

    Parameters
    ----------
    of : functional
        From `lumped.functionals`.
    over : mapping of name to distribution, or correlated distributions
        What scatters, as for `ensemble`. Distributions that are `scaled` move with the design.
    above, below : float or str
        One of these: the limit, in the SI unit of the functional or with a unit, such as
        ``"5 kN.m"``; the functional fails above or below it.
    runs : int
        Samples by which the probability of the best design is checked.
    seed : int
        Of these samples.

    Returns
    -------
    Probability
        ``probability(...) <= 1e-4`` is a condition.

    Raises
    ------
    OptionError
        If there is not one limit, or something else than ``<=`` is made of it.
    """
    if (above is None) == (below is None):
        raise OptionError(
            f"probability: above = {shown(above)} and below = {shown(below)}: give one limit, "
            "above or below which the functional fails."
        )
    if runs < 100:
        raise OptionError(f"probability: runs = {runs}: at least 100 are needed for the check.")
    return Probability(of, above, below, over, runs, seed)


_RUNS = 256
"""Runs of a sample where none are asked for: a power of two, which suits Sobol points."""
_BEYOND = 10
"""Values that a sample needs beyond a quantile."""


@dataclass(frozen=True, eq=False)
class MeanPlusAim(Bounded):
    """Mean of a functional and a multiple of its standard deviation.

    Attributes
    ----------
    of : functional
        What scatters.
    k : float
        The multiple; a negative one is meant for what shall be large.
    over, runs, seed
        See `mean_plus`.
    """

    of: Functional
    k: float
    over: Over = field(repr=False)
    runs: int
    seed: int

    def __str__(self) -> str:
        return f"mean {'-' if self.k < 0 else '+'} {abs(self.k):g} std of {self.of}"

    def of_sample(self, values: np.ndarray, slopes: np.ndarray) -> tuple[float, np.ndarray]:
        """Value and derivatives.

        Parameters
        ----------
        values : ndarray, shape (n,)
            Of the functional.
        slopes : ndarray, shape (n, m)
            Their derivatives.

        Returns
        -------
        value : float
        slope : ndarray, shape (m,)

        Raises
        ------
        OptimisationError
            If the functional does not scatter: its standard deviation has a kink there.
        """
        n, mean = len(values), float(values.mean())
        off = values - mean
        std = math.sqrt(off @ off / (n - 1))
        if not std > 0:
            raise OptimisationError(
                f"{self}: all {n} runs have the same value, {mean:.6g}, so the standard deviation "
                "has no derivative. Let parameters scatter on which it depends.",
                "no scatter",
            )
        slope: np.ndarray = slopes.mean(axis=0) + self.k * (off @ slopes) / ((n - 1) * std)
        return mean + self.k * std, slope


@dataclass(frozen=True, eq=False)
class QuantileAim(Bounded):
    """A quantile of a functional, estimated by all values of a sample.

    Attributes
    ----------
    of : functional
        What scatters.
    share : float
        Share of the values that are less.
    over, runs, seed
        See `quantile`.
    """

    of: Functional
    share: float
    over: Over = field(repr=False)
    runs: int
    seed: int

    def __str__(self) -> str:
        return f"{100 * self.share:g} % quantile of {self.of}"

    def of_sample(self, values: np.ndarray, slopes: np.ndarray) -> tuple[float, np.ndarray]:
        """Value and derivatives; arguments and results as for `MeanPlusAim.of_sample`."""
        order = np.argsort(values, kind="stable")
        weights = _harrell_davis(len(values), self.share)
        slope: np.ndarray = weights @ slopes[order]
        return float(weights @ values[order]), slope


RobustAim = MeanPlusAim | QuantileAim
"""What sums up the scatter of a functional."""


def _harrell_davis(n: int, share: float) -> np.ndarray:
    """Weights of the ordered values of a sample, shape (n,)."""
    a, b = (n + 1) * share, (n + 1) * (1 - share)
    return np.diff(scipy.special.betainc(a, b, np.arange(n + 1) / n))


@checked
def mean_plus(
    of: Functional,
    k: float,
    *,
    over: Any,
    runs: int = _RUNS,
    seed: int = 0,
) -> MeanPlusAim:
    """Mean of a functional and a multiple of its standard deviation, for `optimise`.

    Both are those of a sample: the same points of standard normal variables for all designs, so
    that derivatives are exact.

    Parameters
    ----------
    of : functional
        From `lumped.functionals`.
    k : float
        Standard deviations that are added to the mean; a negative number takes them away, for what
        shall be large.
    over : mapping of name to distribution, or correlated distributions
        What scatters, as for `ensemble`. Distributions that are `scaled` move with the design.
    runs : int
        Size of the sample, scrambled Sobol points.
    seed : int
        Of the sample.

    Returns
    -------
    MeanPlusAim
        To be minimised or bounded.

    Raises
    ------
    OptionError
        If there are fewer than 16 runs.
    """
    if runs < 16:
        raise OptionError(f"mean_plus: runs = {runs}: at least 16 are needed.")
    return MeanPlusAim(of, k, over, runs, seed)


@checked
def quantile(
    of: Functional,
    share: float,
    *,
    over: Any,
    runs: int | None = None,
    seed: int = 0,
) -> QuantileAim:
    """A quantile of a functional, for `optimise`.

    A sum of all ordered values of a sample, weighted by a beta distribution: it is continuous in
    the design, and has exact derivatives where no two values are equal.

    Parameters
    ----------
    of : functional
        From `lumped.functionals`.
    share : float
        Share of the values that are less, such as 0.95.
    over : mapping of name to distribution, or correlated distributions
        What scatters, as for `ensemble`. Distributions that are `scaled` move with the design.
    runs : int, optional
        Size of the sample, scrambled Sobol points; default is 256, or as many as leave ten values
        beyond the quantile.
    seed : int
        Of the sample.

    Returns
    -------
    QuantileAim
        To be minimised or bounded.

    Raises
    ------
    OptionError
        If the share is not between 0 and 1, or fewer than ten values are beyond the quantile.

    Notes
    -----
    F. E. Harrell, C. E. Davis: A new distribution-free quantile estimator. Biometrika 69 (1982)
    635-640.
    """
    if not 0 < share < 1:
        raise OptionError(
            f"quantile: share = {share:g}: a number greater than 0 and less than 1 is needed."
        )
    least = math.ceil(_BEYOND / min(share, 1 - share) - 1e-9)
    if runs is not None and runs < least:
        raise OptionError(
            f"quantile: runs = {runs}: of {least} runs {_BEYOND} are beyond the quantile of "
            f"{100 * share:g} %; give at least so many."
        )
    return QuantileAim(of, share, over, runs or max(_RUNS, least), seed)
