"""What an ensemble draws its parameters from, and values that belong together."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from lumped.compiler.structure import Name
from lumped.ensembles.laws import Distribution, Lognormal, Normal, Triangular, Uniform
from lumped.ensembles.other_laws import Measured, Scaled, Truncated, distribution_of
from lumped.errors import OptionError
from lumped.flattening.tree import key_of
from lumped.support.arguments import checked
from lumped.support.arrays import Real

_ROUNDING = 1e-12
"""Error of a correlation matrix that is nothing but rounding."""


@dataclass(frozen=True, eq=False)
class Correlated:
    """Distributions of parameters that depend on each other.

    Attributes
    ----------
    distributions : dict of name to Distribution
        Of each parameter.
    correlation : ndarray, shape (k, k)
        Of the normal variables behind them.
    """

    distributions: dict[Name, Distribution]
    correlation: Real

    def couple(self, u: Real) -> Real:
        """Dependent probabilities from independent ones, shape (n, k); those of the first are kept.

        Normal variables are mixed by `mixing`.
        """
        mixed: Real = scipy.special.ndtr(scipy.special.ndtri(u) @ self.mixing.T)
        return np.clip(mixed, float(np.finfo(float).tiny), 1 - 2.0**-53)

    @property
    def mixing(self) -> Real:
        """Cholesky's factor of the correlation, shape (k, k).

        Its column is zero for a variable that follows from those before it.
        """
        factor = np.zeros_like(self.correlation)
        for j in range(len(factor)):
            left = self.correlation[j:, j] - factor[j:, :j] @ factor[j, :j]
            if left[0] > _ROUNDING:
                factor[j:, j] = left / math.sqrt(left[0])
        return factor


@dataclass(frozen=True, eq=False)
class Paired:
    """Values of parameters that belong together, run by run.

    Attributes
    ----------
    values : dict of name to array_like
        Of each parameter.
    """

    values: dict[Name, Any]


@checked
def normal(mean: float | str, std: float | str) -> Distribution:
    """A normal distribution of a parameter.

    Parameters
    ----------
    mean, std : float or str
        Mean and standard deviation, in the SI unit of the parameter or with a unit, such as
        ``"30 kN.m/rad"``.

    Returns
    -------
    Distribution
        For `over` of an ensemble, which refuses what does not fit the parameter.
    """
    return Normal(mean, std)


@checked
def uniform(low: float | str, high: float | str) -> Distribution:
    """A distribution of a parameter whose values between two ends are all equally likely.

    Parameters
    ----------
    low, high : float or str
        Ends, in the SI unit of the parameter or with a unit.

    Returns
    -------
    Distribution
        For `over` of an ensemble, which refuses what does not fit the parameter.
    """
    return Uniform(low, high)


@checked
def triangular(low: float | str, mode: float | str, high: float | str) -> Distribution:
    """A distribution of a parameter whose density is a triangle.

    Parameters
    ----------
    low, mode, high : float or str
        Lower end, most likely value and upper end, in the SI unit of the parameter or with a unit.

    Returns
    -------
    Distribution
        For `over` of an ensemble, which refuses what does not fit the parameter.
    """
    return Triangular(low, mode, high)


@checked
def lognormal(median: float | str, sigma: float | str) -> Distribution:
    """A distribution of a parameter whose logarithm is normal.

    Parameters
    ----------
    median : float or str
        Half of the values are smaller; in the SI unit of the parameter or with a unit.
    sigma : float or str
        Standard deviation of the natural logarithm; 0.1 scatters by some 10 %.

    Returns
    -------
    Distribution
        For `over` of an ensemble, which refuses what does not fit the parameter.
    """
    return Lognormal(median, sigma)


@checked
def measured(samples: Any) -> Distribution:
    """The distribution of samples that were measured.

    A smooth and rising curve goes through the means of groups of the sorted samples, over the
    scores of a standard normal variable. Normal samples so give a normal distribution, and beyond
    the outermost groups the tails are those of a normal one: of what is rarer than one in the
    number of samples they know nothing.

    Parameters
    ----------
    samples : array_like, shape (n,)
        At least 20 values, in the SI unit of the parameter or texts with a unit.

    Returns
    -------
    Distribution
        For `over` of an ensemble, which refuses what does not fit the parameter.
    """
    return Measured(np.ravel(np.asarray(samples)).tolist())


@checked
def truncated(distribution: Any, low: float | str | None, high: float | str | None) -> Distribution:
    """The part of a distribution between two ends, such as a normal one without negative values.

    Parameters
    ----------
    distribution : Distribution or frozen distribution of scipy.stats
        Of a parameter.
    low, high : float or str or None
        Ends, in the SI unit of the parameter or with a unit; None is no end.

    Returns
    -------
    Distribution
        For `over` of an ensemble, which refuses what does not fit the parameter.

    Raises
    ------
    OptionError
        If it is no distribution.
    """
    return Truncated(distribution_of(distribution, "truncated: distribution ="), low, high)


@checked
def scaled(distribution: Any) -> Distribution:
    """A distribution of a factor by which a parameter's own value is multiplied.

    That value is the one of the model, or of the parameters that are changed for all runs.

    Parameters
    ----------
    distribution : Distribution or frozen distribution of scipy.stats
        Of the factor, such as ``uniform(0.9, 1.1)``.

    Returns
    -------
    Distribution
        For `over` of an ensemble, which refuses what does not fit the parameter.

    Raises
    ------
    OptionError
        If it is no distribution.
    """
    return Scaled(distribution_of(distribution, "scaled: distribution ="))


@checked
def correlated(distributions: Mapping[Name, Any], correlation: ArrayLike) -> Correlated:
    """Distributions of parameters that depend on each other, by a Gaussian copula.

    Parameters
    ----------
    distributions : mapping of name to distribution
        For each parameter, all that are drawn.
    correlation : array_like, shape (k, k)
        Correlation of normal variables: the parameters take their probabilities from these, so
        normal distributions have this correlation themselves. For others, Spearman's rank
        correlation ``r`` is met by ``2 sin(pi r / 6)``.

    Returns
    -------
    Correlated
        For `over` of an ensemble.

    Raises
    ------
    OptionError
        If something is no distribution, or the matrix no correlation matrix.

    Notes
    -----
    P.-L. Liu, A. Der Kiureghian: Multivariate distribution models with prescribed marginals and
    covariances. Probabilistic Engineering Mechanics 1 (1986) 105-112. Ranks: W. H. Kruskal, Ordinal
    measures of association. Journal of the American Statistical Association 53 (1958) 814-861.
    """
    names = [key_of(name) for name in distributions]
    given = {
        name: distribution_of(value, f"correlated: {key_of(name)} =")
        for name, value in distributions.items()
    }
    matrix, k = np.array(correlation, dtype=float), len(names)
    if not names:
        raise OptionError("correlated: there is no distribution; give that of each parameter.")
    if matrix.shape != (k, k):
        raise OptionError(
            f"correlated: the correlation has the shape {matrix.shape}; {k} rows of {k} numbers "
            f"are needed, in the order {', '.join(names)}."
        )
    i = int(np.argmax(np.abs(np.diag(matrix) - 1)))
    if abs(matrix[i, i] - 1) > _ROUNDING:
        raise OptionError(
            f"correlated: the correlation of {names[i]} with itself is {matrix[i, i]:g}, which "
            "must be 1. Divide a covariance by both standard deviations."
        )
    i, j = divmod(int(np.argmax(np.abs(matrix - matrix.T))), k)
    if abs(matrix[i, j] - matrix[j, i]) > _ROUNDING:
        raise OptionError(
            f"correlated: the correlation of {names[i]} and {names[j]} is {matrix[i, j]:g} above "
            f"the diagonal, but {matrix[j, i]:g} below it. Write the same number twice."
        )
    least = np.linalg.eigvalsh(matrix).min()
    if least < -_ROUNDING * k:
        raise OptionError(
            f"correlated: the correlations contradict each other: the least eigenvalue of the "
            f"matrix is {least:.3g}, and must not be negative. Make some of them smaller."
        )
    return Correlated(given, matrix)


@checked
def paired(values: Mapping[Name, Any]) -> Paired:
    """Values of parameters that belong together: value i of each makes run i.

    Parameters
    ----------
    values : mapping of name to array_like
        For each parameter, all of one length; numbers in SI units, or texts with units.

    Returns
    -------
    Paired
        For `over` of an ensemble.
    """
    return Paired(dict(values))
