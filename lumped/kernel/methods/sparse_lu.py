"""LU factors of a sparse matrix with given pattern and pivots (see `pivots`)."""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.run import Matrix, Pattern, Run

_ACCURATE = 1e-8
"""Largest residual with good pivots, relative to the terms of a row."""
_TOLERATED = 1e-3
"""The same, relative to the absolute tolerance."""


@kernel
def factorise(pattern: Pattern, matrix: Matrix, n: int) -> bool:
    """Factors in place of the matrix, row after row; false where a pivot vanishes."""
    begin, diagonal, at = pattern.begin, pattern.diagonal, pattern.at
    values, row = matrix.factors, matrix.row
    for i in range(n):
        for e in range(begin[i], begin[i + 1]):
            row[at[e]] = values[e]
        for e in range(begin[i], diagonal[i]):
            k = at[e]
            factor = row[k] / values[diagonal[k]]
            row[k] = factor
            for g in range(diagonal[k] + 1, begin[k + 1]):
                row[at[g]] -= factor * values[g]
        for e in range(begin[i], begin[i + 1]):
            values[e] = row[at[e]]
        if values[diagonal[i]] == 0.0:
            return False
    return True


@kernel
def solve(pattern: Pattern, matrix: Matrix, n: int, b: Numbers) -> None:
    """Solve with the factors, in place."""
    begin, diagonal, at, order = pattern.begin, pattern.diagonal, pattern.at, pattern.order
    values, y = matrix.factors, matrix.row
    for i in range(n):
        total = b[order[i]]
        for e in range(begin[i], diagonal[i]):
            total -= values[e] * y[at[e]]
        y[i] = total
    for i in range(n - 1, -1, -1):
        total = y[i]
        for e in range(diagonal[i] + 1, begin[i + 1]):
            total -= values[e] * y[at[e]]
        y[i] = total / values[diagonal[i]]
    for i in range(n):
        b[order[i]] = y[i]


@kernel
def solve_transposed(pattern: Pattern, matrix: Matrix, n: int, b: Numbers, stride: int) -> None:
    """Solve with the factors of the transposed matrix, in place; every `stride`-th number of b."""
    begin, diagonal, at, order = pattern.begin, pattern.diagonal, pattern.at, pattern.order
    values, y = matrix.factors, matrix.row
    for i in range(n):
        y[i] = b[order[i] * stride]
    for i in range(n):
        y[i] /= values[diagonal[i]]
        for e in range(diagonal[i] + 1, begin[i + 1]):
            y[at[e]] -= values[e] * y[i]
    for i in range(n - 1, -1, -1):
        for e in range(begin[i], diagonal[i]):
            y[at[e]] -= values[e] * y[i]
    for i in range(n):
        b[order[i] * stride] = y[i]


@kernel
def is_solved(run: Run, step: float, right: Numbers, x: Numbers) -> bool:
    """Whether ``(I - step J) x`` is the right-hand side, up to rounding of its terms."""
    matrix, n = run.matrix, run.plant.states
    pattern, rest, size = matrix.pattern, matrix.row, matrix.size
    for i in range(n):
        rest[i] = right[i] - x[i]
        size[i] = abs(right[i]) + abs(x[i])
    for e in range(pattern.nonzeros):
        i, term = pattern.row[e], step * matrix.slopes[e] * x[pattern.column[e]]
        rest[i] += term
        size[i] += abs(term)
    for i in range(n):
        if not abs(rest[i]) <= _ACCURATE * size[i] + _TOLERATED * run.atol[i]:
            return False
    return True
