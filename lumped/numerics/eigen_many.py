"""Eigenvalues of many matrices with one pattern, side by side."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.numerics.eigen import zero_rounding
from lumped.numerics.skew_scaling import skew_scaling, two_colours

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

_BESIDE = 1e-10
"""Relative distance of a shift from its eigenvalue."""
_TURNS = 3


def eigenvalues_of_many(blocks: Real) -> Complex:
    """Eigenvalues of real matrices, none of which falls into parts, shape (n, m).

    The same numbers as `eigenpairs` gives one by one: undamped drives by singular values. Zeros
    that repeat with too few vectors are only zero to the root of rounding.

    Parameters
    ----------
    blocks : ndarray, shape (n, m, m)
    """
    n, m, _ = blocks.shape
    first = scipy.sparse.csr_array(blocks[0])
    values = np.zeros((n, m), dtype=complex)
    fits = np.zeros(n, dtype=bool)
    if skew_scaling(first) is not None:
        fits, skew = _skew(blocks, first)
        colour = two_colours(first)
        if colour is None:
            values[fits] = -1j * np.linalg.eigvalsh(1j * skew)
        else:
            one, two = np.flatnonzero(colour), np.flatnonzero(~colour)
            angular = np.linalg.svd(skew[:, one][:, :, two], compute_uv=False)
            pairs = angular.shape[1]
            values[fits, :pairs], values[fits, pairs : 2 * pairs] = 1j * angular, -1j * angular
    if not fits.all():
        found = np.linalg.eigvals(blocks[~fits]).astype(complex)
        imaginary = np.abs(found.real) <= 1e-14 * np.abs(found)
        values[~fits] = np.where(imaginary, 1j * found.imag, found)
    return zero_rounding(values, m)


def vectors_of_many(blocks: Real, values: Complex) -> tuple[Complex, Complex]:
    """Right and left eigenvectors x and y of one eigenvalue of each matrix, ``y^H x == 1``.

    By inverse iteration.

    Parameters
    ----------
    blocks : ndarray, shape (n, m, m)
    values : ndarray of complex, shape (n,)

    Returns
    -------
    ndarray of complex, shapes (n, m) and (n, m)
    """
    n, m, _ = blocks.shape
    shifted = blocks - (values * (1 + _BESIDE))[:, None, None] * np.eye(m)
    begin = np.random.default_rng(0).standard_normal(m)
    begin += 2.0  # no vector of a mode is at right angles to it
    sides: list[Complex] = []
    for matrix in (shifted, np.conj(np.swapaxes(shifted, 1, 2))):
        vector: Complex = np.tile(begin + 0j, (n, 1))
        for _ in range(_TURNS):
            vector = np.asarray(np.linalg.solve(matrix, vector[..., None])[..., 0], dtype=complex)
            vector /= np.linalg.norm(vector, axis=1, keepdims=True)
        sides.append(vector)
    right, left = sides
    with np.errstate(divide="ignore", invalid="ignore"):
        left = left / np.conj((left.conj() * right).sum(axis=1))[:, None]
    return right, left


def _skew(blocks: Real, first: scipy.sparse.csr_array) -> tuple[NDArray[np.bool_], Real]:
    """Which matrices a diagonal scaling makes skew-symmetric, and these when scaled."""
    n, m, _ = blocks.shape
    i, j = first.nonzero()
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = -blocks[:, j, i] / blocks[:, i, j]
        ratio_of = {(a, b): k for k, (a, b) in enumerate(zip(i.tolist(), j.tolist(), strict=True))}
        order, before = scipy.sparse.csgraph.breadth_first_order(first, 0)
        scale = np.ones((n, m))
        for k in order[1:].tolist():
            leader = int(before[k])
            scale[:, k] = scale[:, leader] / np.sqrt(ratio[:, ratio_of[leader, k]])
        off = np.abs((scale[:, i] / scale[:, j]) ** 2 / ratio - 1)
    alike = np.ones(n, dtype=bool)
    elsewhere = np.ones((m, m), dtype=bool)
    elsewhere[i, j] = False
    alike &= ~blocks[:, elsewhere].any(axis=1)
    fits: NDArray[np.bool_] = alike & (ratio > 0).all(axis=1) & (off < 1e-9).all(axis=1)
    own = scale[fits]
    return fits, own[:, :, None] * blocks[fits] / own[:, None, :]
