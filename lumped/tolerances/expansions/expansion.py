"""A function of random variables as a sum of orthonormal polynomials, from values and gradients."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lumped.support.arrays import Integer, Real
from lumped.tolerances.expansions.polynomials import Family, Terms, products, slopes_of_products

LEAST = 10
"""Runs below which an error of leaving one out tells nothing."""
_NORMS = (1.0, 0.5)
"""Of the sets of terms: total degree, and hyperbolic."""
_SPARE = 2
"""Rows for each term, at least."""
_WORK = 1e9
"""Rows times the square of the terms, at most: some tenths of a second."""
_FIRST = 0.5
"""Square of the weight of derivatives before their residuals are known."""
_WEIGHTS = 1e-3, 1e3
"""Range of weights of derivatives."""
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
    influence : ndarray, shape (P, n)
        Change of the coefficients by each run, against the fit without it.
    fitted, residuals : ndarray, shape (n,)
        The sum in each run, and the value less it.
    q2 : float
        Share of the variance of the values that is predicted for a run by a fit without it.
    with_slopes : bool
        Whether derivatives served; not where they contradict the values.
    """

    families: tuple[Family, ...]
    exponents: Integer
    coefficients: Real
    influence: Real
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
        """Of the mean and of the standard deviation, from leaving out each run.

        Notes
        -----
        B. Efron, C. Stein: The jackknife estimate of variance. Annals of Statistics 9 (1981)
        586-596.
        """
        n, c = len(self.residuals), self.coefficients[1:]
        mean, own = self.influence[0], c @ self.influence[1:]
        own = own + 0.5 * (self.residuals**2 - self.unexplained) / n
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
    values alone would have them, and by the size of what the fit leaves of them. The sets of terms,
    the weights, and whether derivatives serve at all, follow from the error at runs that are left
    out with all their rows. Polynomials that the runs hardly determine may be small at all runs and
    large elsewhere, above all in the tails of normal variables. So the square of that error is
    multiplied by the mean of the inverse eigenvalues of the products of the terms over the runs,
    by which random errors grow in the coefficients; it is one if the terms are orthonormal there.

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
    J. Peng, J. Hampton, A. Doostan: On polynomial chaos expansion via gradient-enhanced
    l1-minimization. Journal of Computational Physics 310 (2016) 440-458. J. D. Jakeman,
    M. S. Eldred, K. Sargsyan: Enhancing l1-minimization estimates of polynomial chaos expansions
    using basis selection. Journal of Computational Physics 289 (2015) 18-34. Hyperbolic sets, and
    choice by leaving out runs: G. Blatman, B. Sudret, Adaptive sparse polynomial chaos expansion
    based on least angle regression. Journal of Computational Physics 230 (2011) 2345-2367.
    Eigenvalues: A. Cohen, M. A. Davenport, D. Leviatan, On the stability and accuracy of
    least squares approximations. Foundations of Computational Mathematics 13 (2013) 819-834.
    """
    families, n = tuple(families), len(values)
    middle = values.mean()
    scale = float(values.std())
    if not scale > 1e-14 * abs(middle):
        scale = float(abs(middle)) or 1.0
    kinds = [False] if slopes is None else [True, False]
    found: list[_Fit] = []
    for with_slopes in kinds:
        rows = n if slopes is None or not with_slopes else n + int(np.isfinite(slopes).sum())
        most = [family.most for family in families]
        count = int(min(rows / _SPARE, np.sqrt(_WORK / rows)))
        for norm in _NORMS:
            terms = Terms.up_to(most, norm, max(count, 1))
            own = slopes / scale if with_slopes and slopes is not None else None
            block = _Rows(families, z, (values - middle) / scale, own, terms)
            found += block.fits()
    least = min(one.bound for one in found)
    alike = [one for one in found if one.bound <= _ALIKE * least + _EXACT]
    best = min(alike, key=lambda one: one.count)
    coefficients, influence, residuals = (scale * part for part in best.solve_fit())
    coefficients[0] += middle
    variance = float(((values - middle) / scale).var())
    q2 = 1.0 - best.error / variance if variance > 0 else 1.0
    exponents = best.rows.terms.exponents[: best.count]
    with_slopes = best.rows.slopes is not None
    fitted = values - residuals
    return Expansion(
        families, exponents, coefficients, influence, fitted, residuals, q2, with_slopes
    )


class _Rows:
    """Rows of all runs, for one set of terms.

    Parameters
    ----------
    families, z, values, slopes
        As for `fit_expansion`, with values of the order of one.
    terms : Terms
    """

    def __init__(
        self,
        families: Sequence[Family],
        z: Real,
        values: Real,
        slopes: Real | None,
        terms: Terms,
    ) -> None:
        self.terms, self.slopes = terms, slopes
        self.rates = np.column_stack(
            [f.rates[terms.exponents[:, j]] for j, f in enumerate(families)]
        )
        left, right = [products(families, z, terms.exponents)], [values]
        if slopes is not None:
            kernel = np.column_stack([f.weights(z[:, j]) for j, f in enumerate(families)])
            weights = np.where(np.isfinite(slopes), np.sqrt(kernel), 0.0)
            left += list(slopes_of_products(families, z, terms.exponents) * weights.T[:, None])
            right += list((np.nan_to_num(slopes) * weights).T)
        self.left = np.stack(left, axis=1)  # (P, rows of a run, n)
        self.right = np.stack(right)  # (rows of a run, n)

    @cached_property
    def grams(self) -> Real:
        """Products of the terms over all runs, for each row of a run."""
        parts = self.left.transpose(1, 0, 2)
        return parts @ parts.transpose(0, 2, 1)

    def fits(self) -> list[_Fit]:
        """Fits with sets of terms that contain each other."""
        weights = np.full(len(self.right), np.sqrt(_FIRST))
        weights[0] = 1.0
        found = self._fit_nested(weights)
        if self.slopes is None:
            return found
        best = min(found, key=lambda one: one.bound)
        sizes = np.sqrt(np.mean(best.left_out**2, axis=1)) / weights
        with np.errstate(divide="ignore", invalid="ignore"):
            weights = np.clip(np.nan_to_num(sizes[0] / sizes, nan=1.0), *_WEIGHTS)
        return found + self._fit_nested(weights)

    def _fit_nested(self, weights: Real) -> list[_Fit]:
        """Fits with weights of the rows of a run."""
        _, m, n = self.left.shape
        gram = np.tensordot(weights**2, self.grams, 1)
        expected = n * (1.0 + self.rates[:, : m - 1] @ weights[1:] ** 2)
        shape = gram / np.sqrt(expected[:, None] * expected)
        ends = list(self.terms.ends)
        while True:
            try:
                factor = np.linalg.cholesky(shape[: ends[-1], : ends[-1]])
                break
            except np.linalg.LinAlgError:  # too many terms for these runs
                ends.pop()
        most = ends[-1]
        back = np.linalg.inv(factor)
        growth = np.cumsum((back**2).sum(axis=1)) / np.arange(1, most + 1)
        back /= np.sqrt(expected[:most])
        left = (self.left[:most] * weights[:, None]).reshape(most, m * n)
        q = back @ left
        right = self.right * weights[:, None]
        turned = q @ right.ravel()
        q = q.reshape(most, m, n)
        residuals, hat = right.copy(), np.zeros((n, m, m))
        found, begin = [], 0
        for end in ends:
            part = q[begin:end]
            residuals -= np.tensordot(turned[begin:end], part, 1)
            hat += part.transpose(2, 1, 0) @ part.transpose(2, 0, 1)
            begin = end
            try:
                left_out = np.linalg.solve(np.eye(m) - hat, residuals.T[..., None])[..., 0].T
            except np.linalg.LinAlgError:  # a run is met whatever its values are
                break
            error = float(np.mean(left_out[0] ** 2))
            bound = error * max(float(growth[end - 1]), 1.0)
            own = residuals[0].copy()
            found.append(_Fit(self, error, bound, end, back, q, turned, own, left_out))
        return found


@dataclass(frozen=True, eq=False)
class _Fit:
    """One set of terms and weights.

    Attributes
    ----------
    rows : _Rows
    error : float
        Mean square of the error at runs that are left out.
    bound : float
        The same, with what it may grow to away from the runs.
    count : int
        Of the terms.
    back : ndarray
        Inverse of Cholesky's factor of the products of the rows, of more terms perhaps.
    q : ndarray, shape (more terms, rows of a run, n)
        Orthonormal rows.
    turned : ndarray
        Coefficients of these.
    residuals : ndarray, shape (n,)
        Of values.
    left_out : ndarray, shape (rows of a run, n)
        Errors at runs that are left out, weighted.
    """

    rows: _Rows
    error: float
    bound: float
    count: int
    back: np.ndarray
    q: Real
    turned: Real
    residuals: Real
    left_out: np.ndarray

    def solve_fit(self) -> tuple[Real, Real, Real]:
        """Coefficients, influence of runs on them, residuals of values."""
        k = self.count
        effect = np.einsum("pmn,mn->pn", self.q[:k], self.left_out)
        right = np.column_stack([self.turned[:k], effect])
        found = self.back[:k, :k].T @ right
        return found[:, 0], found[:, 1:], self.residuals
