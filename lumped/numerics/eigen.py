"""Eigenvalues of a linearised drive that keep the digits of the low modes.

An undamped drive has a diagonal scaling that makes its matrix skew-symmetric; where it couples
only torsions with speeds, its natural frequencies are singular values of one block (the SVD of
``M^-1/2 B C^1/2``), whose accuracy does not suffer from extreme stiffness elsewhere.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.numerics.skew_scaling import skew_scaling, two_colours

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SWEEPS = 20


def eigenpairs(a: Real) -> tuple[Complex, Complex]:
    """Eigenvalues and eigenvectors of a real matrix that does not fall into parts.

    Parameters
    ----------
    a : ndarray, shape (n, n)

    Returns
    -------
    values : ndarray of complex, shape (k,)
        Those that are zero to rounding are exactly zero, one for each vector of the null space.
    vectors : ndarray of complex, shape (k, n)
        One in each row.
    """
    sparse = scipy.sparse.csr_array(a)
    scale = skew_scaling(sparse)
    if scale is None:
        return _general(a)
    skew = scale[:, None] * a / scale[None, :]
    colour = two_colours(sparse)
    if colour is None:
        angular, vectors = scipy.linalg.eigh(1j * skew)
        values = -1j * angular
    else:
        values, vectors = _by_singular_values(skew, colour)
    values = zero_rounding(values, len(a))
    return values, (vectors / scale[:, None]).T


def nonzero(a: Real) -> int:
    """Number of nonzero eigenvalues, however small they are beside others.

    This is the rank of the matrix with rows and columns of equal size, or of its square if a zero
    may have fewer vectors than its count; stiffness ratios do not affect it.
    """
    sparse = scipy.sparse.csr_array(a)
    if skew_scaling(sparse) is None:
        return _rank(a @ a)
    colour = two_colours(sparse)
    return _rank(a) if colour is None else 2 * _rank(a[np.ix_(colour, ~colour)])


def _rank(a: Real) -> int:
    """Rank after rows and columns are made equally long (Ruiz, RAL-TR-2001-034)."""
    for _ in range(_SWEEPS):
        for axis in (0, 1):
            size = np.sqrt(np.abs(a).max(axis=axis, keepdims=True, initial=0.0))
            a = a / np.where(size > 0, size, 1.0)
    sizes = np.linalg.svd(a, compute_uv=False)
    return int((sizes > 1e-12 * len(a) * sizes.max(initial=0.0)).sum())


def _by_singular_values(skew: Real, colour: NDArray[np.bool_]) -> tuple[Complex, Complex]:
    one, two = np.flatnonzero(colour), np.flatnonzero(~colour)
    left, angular, right = scipy.linalg.svd(skew[np.ix_(one, two)])
    n, pairs = len(skew), len(angular)
    values = np.zeros(n, dtype=complex)
    vectors = np.zeros((n, n), dtype=complex)
    for sign, first in ((1j, 0), (-1j, 1)):
        columns = slice(first, 2 * pairs, 2)
        values[columns] = sign * angular
        vectors[one, columns] = left[:, :pairs]
        vectors[two, columns] = sign * right[:pairs].T
    # what is left is still: either torsions or speeds
    vectors[one, 2 * pairs : pairs + len(one)] = left[:, pairs:]
    vectors[two, 2 * pairs : pairs + len(two)] = right[pairs:].T
    return values, vectors


def _general(a: Real) -> tuple[Complex, Complex]:
    balanced, transform = scipy.linalg.matrix_balance(a)
    values, vectors = scipy.linalg.eig(balanced)
    still = zero_rounding(values, len(a)) == 0
    if still.any():
        # a defective zero (an angle kept beside its speed) has fewer vectors than its count
        lost = max(_rank(a @ a) - int((~still).sum()), 0)
        count = len(a) - _rank(a) + lost
        rest = np.linalg.svd(balanced)[2][len(a) - count :].T
        values = np.concatenate([values[~still], np.zeros(rest.shape[1])])
        vectors = np.hstack([vectors[:, ~still], rest])
    values = np.where(np.abs(values.real) <= 1e-14 * np.abs(values), 1j * values.imag, values)
    values = zero_rounding(values, len(a))
    return values, (transform @ vectors).T


def zero_rounding(values: Complex, n: int) -> Complex:
    """Values that are zero to rounding become exactly zero; of several matrices row by row."""
    limit = 1e-13 * n * np.abs(values).max(axis=-1, initial=0.0, keepdims=True)
    return np.where(np.abs(values) <= limit, 0.0, values)
