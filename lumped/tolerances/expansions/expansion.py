"""A function of random variables as a sum of orthonormal polynomials, from values and gradients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lumped.support.arrays import Integer, Real
from lumped.tolerances.expansions.greedy import Choice, Rows
from lumped.tolerances.expansions.polynomials import Family, list_exponents, products

LEAST = 10
"""Runs below which an error of leaving one out tells nothing."""
_SETS = {1.0: 0.75, 0.5: 0.25}
"""Norms of the sets of terms, total degree and hyperbolic, with shares of their number."""
_WORK, _MOST = 1e9, 1500
"""Rows times the square of the terms, and terms, at most: some tenths of a second."""
_ALIKE, _EXACT = 1.02, 1e-20
"""Squares of errors that count as equal, in each other and in the variance: fewer terms win."""
_CHUNK = 500_000
"""Numbers in the memory of one evaluation."""
_NEAR = 4
"""Runs to each side from which residuals are taken, at least; else a fiftieth of all."""
_BAND = 1000
"""Points next to a quantile over which polynomials are averaged."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """A sum of orthonormal polynomials, and what tells of its error.

    Attributes
    ----------
    families : tuple of Family
        Polynomials of each variable.
    exponents : ndarray of int, shape (P, d)
        Degrees of each term; the first is the constant.
    coefficients : ndarray, shape (P,)
    influence : ndarray, shape (P, parts)
        Change of the coefficients by each part of the runs, against the choice without it.
    parts : ndarray of int, shape (n,)
        To which part each run belongs.
    fitted, residuals : ndarray, shape (n,)
        The sum in each run, and the value less it.
    q2 : float
        Share of the variance of the values that is predicted for runs that neither the choice of
        the terms nor their coefficients know.
    with_slopes : bool
        Whether derivatives served; not where they contradict the values.
    """

    families: tuple[Family, ...]
    exponents: Integer
    coefficients: Real
    influence: Real
    parts: Integer
    fitted: Real
    residuals: Real
    q2: float
    with_slopes: bool

    @property
    def degree(self) -> int:
        """Greatest total degree of a term."""
        return int(self.exponents.sum(axis=1).max())

    @property
    def mean(self) -> float:
        """Of the function over the distribution of its variables."""
        return float(self.coefficients[0])

    @property
    def unexplained(self) -> float:
        """Variance that the sum leaves."""
        return float(np.mean(self.residuals**2))

    @property
    def variance(self) -> float:
        """Of the function: that of the sum, and what it leaves."""
        return float(self.coefficients[1:] @ self.coefficients[1:]) + self.unexplained

    @property
    def standard_errors(self) -> tuple[float, float]:
        """Of the mean and of the standard deviation, from leaving out parts of the runs.

        Notes
        -----
        B. Efron, C. Stein: The jackknife estimate of variance. Annals of Statistics 9 (1981)
        586-596.
        """
        n, c = len(self.residuals), self.coefficients[1:]
        mean, own = self.influence[0], c @ self.influence[1:]
        left = self.residuals**2 - self.unexplained
        own = own + 0.5 * np.bincount(self.parts, left) / n
        deviation = float(np.sqrt(self.variance))
        off = float(np.sqrt(own @ own)) / deviation if deviation > 0 else 0.0
        return float(np.sqrt(mean @ mean)), off

    def shares(self) -> tuple[Real, Real]:
        """Sobol's indices of the sum: of each variable alone, and with all others, shape (d,) each.

        Both are zero where nothing varies.

        Notes
        -----
        B. Sudret: Global sensitivity analysis using polynomial chaos expansions. Reliability
        Engineering and System Safety 93 (2008) 964-979.
        """
        there = self.exponents > 0
        parts = self.coefficients**2
        parts[0] = 0.0
        parts /= parts.sum() or 1.0
        alone = there & (there.sum(axis=1) == 1)[:, None]
        return parts @ alone, parts @ there

    def values(self, z: Real) -> Real:
        """Of the sum at points, shape (n, d) to (n,)."""
        size = max(1, _CHUNK // len(self.exponents))
        found = [
            np.einsum(
                "p,pn->n",  # a product of BLAS would wait for its threads at each chunk
                self.coefficients,
                products(self.families, z[i : i + size], self.exponents),
            )
            for i in range(0, len(z), size)
        ]
        return np.concatenate(found)

    def add_residuals(self, values: Real, random: np.random.Generator) -> Real:
        """Values of the sum with what it leaves: residuals of runs that have a value nearby.

        Parameters
        ----------
        values : ndarray, shape (m,)
            Of the sum.
        random : Generator
        """
        order, n = np.argsort(self.fitted), len(self.fitted)
        width = max(_NEAR, n // 50)
        at = np.searchsorted(self.fitted[order], values)
        at = np.abs(at + random.integers(-width, width + 1, len(values)))
        at = np.minimum(at, 2 * (n - 1) - at)  # turned back at both ends
        found: Real = values + self.residuals[order[at]]
        return found

    def error_near(self, z: Real, values: Real, level: float) -> float:
        """Standard error of a quantile.

        A quantile moves with a coefficient as the mean of its polynomial does where the sum has
        the value of the quantile.

        Parameters
        ----------
        z : ndarray, shape (m, d)
            A large sample.
        values : ndarray, shape (m,)
            Of the sum there.
        level : float
            The quantile.
        """
        near = np.argsort(np.abs(values - level))[:_BAND]
        slopes = products(self.families, z[near], self.exponents).mean(axis=1)
        return float(np.linalg.norm(slopes @ self.influence))


def fit_expansion(
    families: Sequence[Family], z: Real, values: Real, slopes: Real | None = None
) -> Expansion:
    """Fit a sum of polynomials to values and gradients by least squares.

    Each run has a row for its value and one for each derivative. Rows of derivatives are
    weighted by Stein's kernel of their variable, so that they leave the coefficients where the
    values alone would have them, and by the size of what the fit leaves of them. Of up to 1500
    terms those are chosen one by one that lower the squares most, weighted by their degree, as
    coefficients fall with it. How many there are, the weights, and whether derivatives serve at
    all, follow from the error at runs that are left out with all their rows, a tenth at a time:
    terms are chosen again without them. Polynomials that the runs hardly determine may be small at
    all runs and large elsewhere, above all in the tails of normal variables. So a term that nearly
    lies within those chosen before is left out, and the square of the error is multiplied by the
    root of the mean of the inverse eigenvalues of the products of the terms over the runs.

    Parameters
    ----------
    families : sequence of Family
        Of each variable.
    z : ndarray, shape (n, d)
        Independent variables in each run; 10 runs at least.
    values : ndarray, shape (n,)
    slopes : ndarray, shape (n, d), optional
        Derivatives by z; nan in runs that have none.

    Returns
    -------
    Expansion

    Notes
    -----
    G. Blatman, B. Sudret: Adaptive sparse polynomial chaos expansion based on least angle
    regression. Journal of Computational Physics 230 (2011) 2345-2367 (sparse and hyperbolic sets).
    S. Chen, S. A. Billings, W. Luo: Orthogonal least squares methods and their application to
    non-linear system identification. International Journal of Control 50 (1989) 1873-1896 (choice).
    J. Peng, J. Hampton, A. Doostan: On polynomial chaos expansion via gradient-enhanced
    l1-minimization. Journal of Computational Physics 310 (2016) 440-458 (gradients, weights).
    A. Cohen, M. A. Davenport, D. Leviatan: On the stability and accuracy of least squares
    approximations. Foundations of Computational Mathematics 13 (2013) 819-834 (eigenvalues).
    """
    families, n = tuple(families), len(values)
    middle = values.mean()
    scale = float(values.std())
    if not scale > 1e-14 * abs(middle):
        scale = float(abs(middle)) or 1.0
    right = (values - middle) / scale
    found: list[tuple[Choice, Integer, bool]] = []
    for own in [None] if slopes is None else [slopes / scale, None]:
        rows = n * (1 if own is None else 1 + len(families))
        count = min(int(np.sqrt(_WORK / rows)), _MOST)
        exponents = _list_terms([family.most for family in families], count)
        block = Rows(families, z, right, own, exponents)
        found += [(one, exponents, own is not None) for one in block.choose()]
    least = min(one.error for one, _, _ in found)
    alike = [one for one in found if one[0].error <= _ALIKE * least + _EXACT]
    best, exponents, with_slopes = min(alike, key=lambda one: one[0].count)
    used = np.flatnonzero(best.coefficients.any(axis=0) | (exponents.sum(axis=1) == 0))
    *without, coefficients = scale * best.coefficients[:, used]
    share = np.sqrt(1 - 1 / len(without))
    variance = float(right.var())
    residuals = scale * best.residuals
    influence = share * (coefficients - without).T
    coefficients[0] += middle
    return Expansion(
        families,
        exponents[used],
        coefficients,
        influence,
        best.parts,
        values - residuals,
        residuals,
        1.0 - best.error / variance if variance > 0 else 1.0,
        with_slopes,
    )


def _list_terms(most: Sequence[int], count: int) -> Integer:
    """Terms of which to choose: up to a total degree, and further ones of few variables."""
    sets = [list_exponents(most, norm, max(int(share * count), 1)) for norm, share in _SETS.items()]
    return np.array(list(dict.fromkeys(tuple(row) for one in sets for row in one.tolist())))
