"""One attempt of Rodas5P (Steinebach, BIT Numerical Mathematics 63 (2023) 27), dense algebra."""

from __future__ import annotations

import math

import numpy as np

from lumped.kernel.layout import (
    ATOL,
    DENSE,
    EVALUATIONS,
    JAC_COLUMN,
    JAC_ROW,
    JACOBIAN,
    MATRIX,
    NEW,
    NNZ,
    PIVOT,
    RATES,
    RHS,
    RTOL,
    STAGES,
    M,
    N,
    P,
    T,
    X,
)
from lumped.kernel.words import Integers, Numbers, at, evaluate, kernel
from lumped.numerics import rodas5p

__all__ = ["dense_implicit", "implicit"]

_GAMMA = rodas5p.GAMMA
_NODES = (*rodas5p.NODES, 1.0, 1.0, 1.0)
_D = (*rodas5p.D, 0.0, 0.0, 0.0)


def _square(rows: tuple[tuple[float, ...], ...]) -> tuple[float, ...]:
    """Rows of different lengths as eight of eight, one after the other."""
    filled = np.zeros((8, 8))
    for i, row in enumerate(rows):
        filled[i, : len(row)] = row
    return tuple(filled.ravel().tolist())


_A, _C = _square(rodas5p.A), _square(rodas5p.C)
_H = tuple(np.array(rodas5p.H).ravel().tolist())


@kernel
def _factorised(matrix: Numbers, pivot: Integers, n: int) -> int:
    """LU decomposition with partial pivoting, row after row; 0 if there is none."""
    for c in range(n):
        best, size = c, abs(matrix[c * n + c])
        for r in range(c + 1, n):
            if abs(matrix[r * n + c]) > size:
                best, size = r, abs(matrix[r * n + c])
        pivot[c] = best
        if size == 0.0:
            return 0
        if best != c:
            for j in range(n):
                held = matrix[c * n + j]
                matrix[c * n + j] = matrix[best * n + j]
                matrix[best * n + j] = held
        for r in range(c + 1, n):
            factor = matrix[r * n + c]
            if factor != 0.0:
                factor /= matrix[c * n + c]
                matrix[r * n + c] = factor
                for j in range(c + 1, n):
                    matrix[r * n + j] -= factor * matrix[c * n + j]
    return 1


@kernel
def _solve(matrix: Numbers, pivot: Integers, n: int, b: Numbers) -> None:
    for c in range(n):
        other = pivot[c]
        held = b[c]
        b[c] = b[other]
        b[other] = held
    for r in range(n):
        total = b[r]
        for j in range(r):
            total -= matrix[r * n + j] * b[j]
        b[r] = total
    for r in range(n - 1, -1, -1):
        total = b[r]
        for j in range(r + 1, n):
            total -= matrix[r * n + j] * b[j]
        b[r] = total / matrix[r * n + r]


@kernel
def implicit(Z: Integers, R: Numbers, h: float) -> float:
    """New states, their derivatives, and the error relative to what is tolerated; -1 if singular.

    The derivatives at both ends stand where the explicit method has them; the increments of the
    stages stand between.
    """
    n, t, nnz = Z[N], R[T], Z[NNZ]
    x, k, new = at(R, Z[X]), at(R, Z[STAGES]), at(R, Z[NEW])
    p, m, f = at(R, Z[P]), at(R, Z[M]), Z[RHS]
    values, matrix, pivot = at(R, Z[RATES]), at(R, Z[MATRIX]), at(Z, Z[PIVOT])
    rows, columns = at(Z, Z[JAC_ROW]), at(Z, Z[JAC_COLUMN])
    evaluate(Z[JACOBIAN], x, p, t, m, values)
    drift = at(values, nnz)
    for i in range(n * n):
        matrix[i] = 0.0
    for i in range(n):
        matrix[i * n + i] = 1.0
    for i in range(nnz):
        matrix[rows[i] * n + columns[i]] -= h * _GAMMA * values[i]
    if _factorised(matrix, pivot, n) == 0:
        return -1.0
    for s in range(8):
        rate = at(k, (1 + s) * n)
        for i in range(n):
            total = x[i]
            if s < 6:
                for j in range(s):
                    total += _A[8 * s + j] * k[(1 + j) * n + i]
            else:
                total = new[i] + k[s * n + i]
            new[i] = total
        if s == 0:
            for i in range(n):
                rate[i] = k[i]
        else:
            evaluate(f, new, p, t + _NODES[s] * h, m, rate)
        for i in range(n):
            total = 0.0
            for j in range(s):
                total += _C[8 * s + j] * k[(1 + j) * n + i]
            rate[i] = h * _GAMMA * (rate[i] + h * _D[s] * drift[i] + total / h)
        _solve(matrix, pivot, n, rate)
    for i in range(n):
        new[i] = new[i] + k[8 * n + i]
    evaluate(f, new, p, t + h, m, at(k, 12 * n))
    Z[EVALUATIONS] += 8
    error, rtol, atol = 0.0, R[RTOL], at(R, Z[ATOL])
    for i in range(n):
        part = k[8 * n + i] / (atol[i] + rtol * max(abs(x[i]), abs(new[i])))
        error += part * part
    return math.sqrt(error) / math.sqrt(n)


@kernel
def dense_implicit(Z: Integers, R: Numbers) -> None:
    """Interpolation coefficients of a step that was accepted."""
    n, k, out = Z[N], at(R, Z[STAGES]), at(R, Z[DENSE])
    for c in range(3):
        for i in range(n):
            total = 0.0
            for j in range(8):
                total += _H[8 * c + j] * k[(1 + j) * n + i]
            out[c * n + i] = total
