"""Which few terms of many describe values and gradients, chosen again without each part of runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from lumped.support.arrays import Integer, Real
from lumped.tolerances.expansions.polynomials import Family, products, slopes_of_products

_PARTS = 10
"""Parts of the runs, each of which is left out once."""
_SPARE = 2
"""Rows for each chosen term, at least."""
_THIN = 0.1
"""Share of the square of a term that must lie outside of those chosen before."""
_PATIENCE = 20
"""Terms, and as many as were chosen, without a lower error after which the choice ends."""
_LESS = 0.98
"""Square of the error, in that of fewer terms, from which more are worth it."""
_AT_ONCE = 50
"""Terms chosen before for each further one that is chosen in the same step."""
_SOLVED = 3
"""Times that coefficients are solved for."""
_EXACT = 1e-24
"""Square of the error, in the variance, that is rounding."""
_WEIGHTS = 1e-3, 1e3
"""Range of weights of derivatives."""


@dataclass(frozen=True, eq=False)
class Choice:
    """Terms chosen from all runs, and from those without each part.

    Attributes
    ----------
    coefficients : ndarray, shape (parts + 1, P)
        Of all terms that could be chosen, without each part; the last from all runs.
    residuals : ndarray, shape (n,)
        Values less their fit from all runs.
    error : float
        Mean square of the error of values that the choice did not know.
    count : int
        Of the terms.
    parts : ndarray of int, shape (n,)
        To which part each run belongs.
    """

    coefficients: Real
    residuals: Real
    error: float
    count: int
    parts: Integer


class Rows:
    """Values and gradients of n runs as rows, for many terms.

    Parameters
    ----------
    families : sequence of Family
    z : ndarray, shape (n, d)
    values : ndarray, shape (n,)
        Of the order of one.
    slopes : ndarray, shape (n, d), or None
        nan where there are none.
    exponents : ndarray of int, shape (P, d)
        The first is the constant.
    """

    def __init__(
        self,
        families: Sequence[Family],
        z: Real,
        values: Real,
        slopes: Real | None,
        exponents: Integer,
    ) -> None:
        self.rates = np.column_stack([f.rates[exponents[:, j]] for j, f in enumerate(families)])
        left, right = [products(families, z, exponents)], [values]
        if slopes is not None:
            kernel = np.column_stack([f.weights(z[:, j]) for j, f in enumerate(families)])
            weights = np.where(np.isfinite(slopes), np.sqrt(kernel), 0.0)
            left += list(slopes_of_products(families, z, exponents) * weights.T[:, None])
            right += list((np.nan_to_num(slopes) * weights).T)
        self.left = np.stack(left, axis=1)  # (P, rows of a run, n)
        self.right = np.stack(right)  # (rows of a run, n)
        self.prior = 1.0 / (1.0 + exponents.sum(axis=1)) ** 2
        self.parts = np.random.default_rng(0).permutation(len(values)) % _PARTS

    def choose(self) -> list[Choice]:
        """Choices with derivatives as they come, and weighted by what is missed of them."""
        weights = np.ones(len(self.right))
        first, missed = self._choose(weights)
        if len(weights) == 1:
            return [first]
        with np.errstate(divide="ignore", invalid="ignore"):
            weights = np.clip(np.nan_to_num(missed[0] / missed, nan=1.0), *_WEIGHTS)
        return [first, self._choose(weights)[0]]

    def _choose(self, weights: Real) -> tuple[Choice, Real]:
        """A choice with weights of the rows of a run, and what it misses of each of these."""
        paths = self.begin(weights)
        n = len(self.parts)
        error = least = np.inf
        best, missed = 0, weights
        while min(path.extend() for path in paths):
            ends = paths[-1].ends
            squares = sum((path.missed**2).sum(axis=1) for path in paths) / n
            bound = squares[0] * max(paths[-1].growth, 1.0) ** 0.5
            if bound < _LESS * least:
                error, least, best = float(squares[0]), bound, len(ends) - 1
                missed = np.sqrt(squares) / weights
            if error < _EXACT or ends[-1] > _PATIENCE + 2 * ends[best]:
                break
        found = np.zeros((len(paths), len(self.left)))
        for row, path, part in zip(found, paths, range(_PARTS + 1), strict=True):
            chosen, kept = path.order[: path.ends[best]], self.parts != part
            rows = self.left[chosen][:, :, kept] * weights[:, None]
            sizes = self._sizes(weights)[chosen]
            rows = (rows / sizes[:, None, None]).reshape(len(chosen), -1)
            off = (self.right * weights[:, None])[:, kept].ravel()
            for _ in range(_SOLVED):  # the first solution is exact to half of the digits
                step = path.solve(rows @ off)
                off = off - step @ rows
                row[chosen] += step / sizes
        residuals = self.right[0] - found[-1] @ self.left[:, 0]
        return Choice(found, residuals, error, ends[best], self.parts), missed

    def _sizes(self, weights: Real) -> Real:
        """Expected norms of the terms over all rows."""
        rates = self.rates[:, : len(weights) - 1]
        found: Real = np.sqrt(len(self.parts) * (1.0 + rates @ weights[1:] ** 2))
        return found

    def begin(self, weights: Real) -> list[_Path]:
        """Choices that have not begun, without each part of the runs and with all."""
        left = self.left * (weights[:, None] / self._sizes(weights)[:, None, None])
        right = self.right * weights[:, None]
        flat = left.reshape(len(left), -1)
        gram, sums = flat @ flat.T, flat @ right.ravel()
        most = min(right.size // _SPARE, len(left))
        return [
            _Path(gram, sums, self.prior, left[:, :, held], right[:, held], most)
            for held in (self.parts == part for part in range(_PARTS + 1))
        ]


class _Path:
    """Terms chosen one by one from all rows but some: what lowers the squares most, by degree.

    Orthogonal least squares, by the products of the terms (Cholesky's factor with pivoting).

    Parameters
    ----------
    gram, sums : ndarray, shapes (P, P) and (P,)
        Products of the terms with each other and with the right side, over all rows.
    prior : ndarray, shape (P,)
        Weights of the terms.
    left, right : ndarray, shapes (P, rows of a run, runs) and (rows of a run, runs)
        Of the runs that are left out.
    most : int
        Of terms.

    Attributes
    ----------
    order : list of int
        Terms chosen so far.
    ends : list of int
        How many of them there were after each step.
    missed : ndarray, shape (rows of a run, runs)
        The right side of what is left out, less what the terms predict.
    """

    def __init__(
        self, gram: Real, sums: Real, prior: Real, left: Real, right: Real, most: int
    ) -> None:
        self._held = left.reshape(len(gram), -1)
        self._gram, self._prior, self.missed = gram, prior, right.copy()
        self._sums = sums - self._held @ right.ravel()
        self._left = np.diag(gram) - (self._held**2).sum(axis=1)
        self._factor = np.zeros((most, len(gram)))
        self._turned = np.zeros((most, right.size))
        self._inverse, self._squares = np.zeros((most, most)), 0.0
        self.order: list[int] = []
        self.ends: list[int] = []

    @property
    def growth(self) -> float:
        """Mean of the inverse eigenvalues of the products of the chosen terms.

        Squares of random errors grow by it in the coefficients; it is one if the terms are
        orthonormal at the runs.
        """
        return self._squares / len(self.order)

    def solve(self, right: Real) -> Real:
        """Coefficients of the first terms from products of these with a right side."""
        factor = self._factor[: len(right), self.order[: len(right)]]
        return np.asarray(scipy.linalg.cho_solve((factor, False), right))

    def extend(self) -> bool:
        """Choose one more, or with many chosen some at once; whether there are any."""
        k = len(self.order)
        is_open = self._left > _THIN
        worth = self._prior * self._sums**2 / np.where(is_open, self._left, np.inf)
        best = np.argsort(-worth, kind="stable")[: 1 + k // _AT_ONCE] if k else np.zeros(1, int)
        best = best[worth[best] > 0] if k else best
        before = self._factor[:k, best].T
        rows = self._gram[best] - self._held[best] @ self._held.T - before @ self._factor[:k]
        turned = self._held[best] - before @ self._turned[:k]
        for i, j in enumerate(best.tolist()):
            if (self._left[j] <= _THIN and k) or len(self.order) == len(self._factor):
                continue
            size, known = np.sqrt(rows[i, j]), len(self.order)
            self._inverse[known, :known] = -self._factor[:known, j] @ self._inverse[:known, :known]
            self._inverse[known, known] = 1.0
            self._inverse[known] /= size
            self._squares += float(self._inverse[known] @ self._inverse[known])
            row, own, step = rows[i] / size, turned[i] / size, self._sums[j] / size
            self._factor[len(self.order)], self._turned[len(self.order)] = row, own
            self._sums -= step * row
            self._left -= row**2
            self._left[j] = 0.0
            self.missed -= step * own.reshape(self.missed.shape)
            self.order.append(j)
            rows[i + 1 :] -= np.outer(row[best[i + 1 :]], row)
            turned[i + 1 :] -= np.outer(row[best[i + 1 :]], own)
        self.ends.append(len(self.order))
        return len(self.order) > k
