"""Solutions of ``(j w - A) x = b`` for many matrices of one pattern."""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy

from lumped.numerics.singular_factors import factors_of
from lumped.support.arrays import Complex, Integer, Real

_PIVOT = 0.05
"""Least size of a pivot, relative to the largest in its column."""


class _Number:
    """A complex number of two expressions; parts that are zero cost nothing."""

    def __init__(self, re: ca.SX, im: ca.SX) -> None:
        self.re, self.im = re, im

    def __add__(self, other: _Number) -> _Number:
        return _Number(self.re + other.re, self.im + other.im)

    def __sub__(self, other: _Number) -> _Number:
        return _Number(self.re - other.re, self.im - other.im)

    def __mul__(self, other: _Number) -> _Number:
        return _Number(
            self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re
        )

    def size(self) -> ca.SX:
        """Sum of the sizes of both parts."""
        return ca.fabs(self.re) + ca.fabs(self.im)

    def inverse(self) -> _Number:
        """One over it."""
        if self.im.is_zero():
            return _Number(1 / self.re, ca.SX(0))
        if self.re.is_zero():
            return _Number(ca.SX(0), -1 / self.im)
        scale = 1 / (self.re * self.re + self.im * self.im)
        return _Number(self.re * scale, -self.im * scale)


def pivots(rows: Integer, columns: Integer, typical: Complex) -> tuple[tuple[int, int], ...]:
    """Rows and columns of pivots in an order that suits typical matrices ``j w - A``.

    Of the pivots that are not small, the one with the least fill comes next (Markowitz, Management
    Science 3 (1957) 255).

    Parameters
    ----------
    rows, columns : ndarray, shape (k,)
        Places of the numbers in A.
    typical : ndarray of complex, shape (m, n, n)
        Some of the matrices.
    """
    n = typical.shape[1]
    pattern = [{i} for i in range(n)]
    for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
        pattern[i].add(j)
    size, left = typical.copy(), set(range(n))
    order = []
    for _ in range(n):
        i, j = _pivot(pattern, size, sorted(left))
        order.append((i, j))
        left.remove(i)
        for other in left:
            pattern_of_other = pattern[other]
            if j in pattern_of_other:
                pattern_of_other |= pattern[i]
                pattern_of_other.remove(j)
                share = size[:, other, j] / size[:, i, j]
                size[:, other] -= share[:, None] * size[:, i]
                size[:, other, j] = 0
    return tuple(order)


def _pivot(pattern: list[set[int]], size: Complex, left: list[int]) -> tuple[int, int]:
    """Row and column of the next pivot."""
    uses: dict[int, int] = {}
    for i in left:
        for j in pattern[i]:
            uses[j] = uses.get(j, 0) + 1
    own = np.abs(size[:, left])
    top = own.max(axis=1, keepdims=True)
    share = (own / np.where(top > 0, top, 1.0)).min(axis=0)
    best, place = (True, np.inf, 0.0), (-1, -1)
    for row, i in enumerate(left):
        for j in sorted(pattern[i]):
            weak = bool(share[row, j] < _PIVOT)
            fill = (len(pattern[i]) - 1) * (uses[j] - 1)
            rank = (weak, -share[row, j] if weak else fill, -share[row, j])
            if rank < best:
                best, place = rank, (i, j)
    return place


def elimination(
    rows: Integer, columns: Integer, driven: Integer, order: tuple[tuple[int, int], ...]
) -> ca.Function:
    """Solution as one formula, by elimination in a given order.

    Parameters
    ----------
    rows, columns : ndarray, shape (k,)
        Places of the numbers in A.
    driven : ndarray
        Rows of b that are not zero.
    order : tuple of (row, column)
        The pivots.

    Returns
    -------
    Function
        (x, p, t, m) -> real parts of the solution, then imaginary ones, and the backward error
        ``|b - M x| / (|M| |x| + |b|)``, sizes being ``|re| + |im|``. The first argument holds
        the numbers of A, the frequency w, rad/s, and real and imaginary parts of the driven rows of
        b; the others are empty.
    """
    n, count = len(order), len(rows)
    given = ca.SX.sym("x", count + 1 + 2 * len(driven))
    ends = [0, count, count + 1, count + 1 + len(driven), given.numel()]
    entries, w, re, im = ca.vertsplit(given, ends)
    none = _Number(ca.SX(0), ca.SX(0))
    matrix = [{i: _Number(ca.SX(0), w)} for i in range(n)]
    for k, (i, j) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
        matrix[i][j] = matrix[i].get(j, none) - _Number(entries[k], ca.SX(0))
    right = [none] * n
    for k, i in enumerate(driven.tolist()):
        right[i] = _Number(re[k], im[k])
    given_right, inverses, left = list(right), [], set(range(n))
    for i, j in order:
        left.remove(i)
        inverses.append(matrix[i].pop(j).inverse())
        for other in [r for r in left if j in matrix[r]]:
            factor = matrix[other].pop(j) * inverses[-1]
            for column, value in matrix[i].items():
                matrix[other][column] = matrix[other].get(column, none) - factor * value
            right[other] = right[other] - factor * right[i]
    found = [none] * n
    for (i, j), inverse in zip(reversed(order), reversed(inverses), strict=True):
        total = right[i]
        for column, value in matrix[i].items():
            total = total - value * found[column]
        found[j] = total * inverse
    missed = [
        _Number(b.re + w * x.im, b.im - w * x.re) for b, x in zip(given_right, found, strict=True)
    ]
    sizes = [b.size() + ca.fabs(w) * x.size() for b, x in zip(given_right, found, strict=True)]
    for k, (i, j) in enumerate(zip(rows.tolist(), columns.tolist(), strict=True)):
        part = _Number(entries[k] * found[j].re, entries[k] * found[j].im)
        missed[i], sizes[i] = missed[i] + part, sizes[i] + ca.fabs(entries[k]) * found[j].size()
    errors = [ca.if_else(s > 0, e.size() / s, 0) for e, s in zip(missed, sizes, strict=True)]
    worst = ca.mmax(ca.vertcat(*errors))
    result = ca.vertcat(*(v.re for v in found), *(v.im for v in found), worst)
    inputs = [given, ca.SX(0, 1), ca.SX.sym("t"), ca.SX(0, 1)]
    return ca.Function("shifted", inputs, [ca.cse(ca.densify(result))])


def solve_singly(
    rows: Integer, columns: Integer, entries: Real, w: Real, right: Complex
) -> tuple[Complex, Real]:
    """Solutions by a factorisation for each matrix, and their backward errors.

    Both are infinite where a matrix is singular.

    Parameters
    ----------
    rows, columns : ndarray, shape (k,)
        Places of the numbers in A.
    entries : ndarray, shape (points, k)
        Numbers of A.
    w : ndarray, shape (points,)
        Frequencies, rad/s.
    right : ndarray of complex, shape (points, n)
        b.
    """
    n = right.shape[1]
    found, missed = np.full(right.shape, np.inf + 0j), np.full(len(right), np.inf)
    unit = scipy.sparse.eye_array(n, format="csc")
    for k, (values, frequency, b) in enumerate(zip(entries, w, right, strict=True)):
        own = scipy.sparse.csc_array((values, (rows, columns)), shape=(n, n))
        matrix = scipy.sparse.csc_array(1j * frequency * unit - own)
        factors = factors_of(matrix)
        if factors is not None:
            found[k] = factors.solve(b.astype(complex))
            size = abs(matrix) @ np.abs(found[k]) + np.abs(b)
            error = np.abs(b - matrix @ found[k]) / np.where(size > 0, size, 1.0)
            missed[k] = error.max(initial=0.0)
    return found, missed
