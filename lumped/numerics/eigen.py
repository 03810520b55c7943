"""Eigenvalues of a linearised drive that keep the digits of the low modes.

An undamped drive has a diagonal scaling that makes its matrix skew-symmetric; where it couples
only torsions with speeds, its natural frequencies are singular values of one block (the SVD of
``M^-1/2 B C^1/2``), whose accuracy does not suffer from extreme stiffness elsewhere. Damping that
is a sum of a part of the inertias and a part of the stiffnesses leaves its shapes as they are
(Rayleigh, The Theory of Sound, 97).
"""

from __future__ import annotations

import numpy as np
import scipy

from lumped.numerics.singular_factors import factors_of
from lumped.numerics.skew_scaling import skew_scaling, two_colours
from lumped.support.arrays import Boolean, Complex, Real

_SWEEPS = 20
_NONE = 1e-12
"""Singular values below, of the largest times their number, are zero."""
_SHIFT = 1e-9
"""Distance of a shift from zero, of the size of a matrix."""
_BESIDE = 1e-10
"""Relative distance of a shift from its eigenvalue."""
_TURNS = 3
_ALIKE = 1e-14
"""Relative difference of numbers that are the same but for rounding."""


def eigenpairs(a: Real) -> tuple[Complex, Complex]:
    """Eigenvalues and eigenvectors of a real matrix that does not fall into parts.

    Parameters
    ----------
    a : ndarray, shape (n, n)

    Returns
    -------
    values : ndarray of complex, shape (k,)
        One of each conjugate pair, with a positive imaginary part. Those that are zero to rounding
        are exactly zero, one for each vector of the null space.
    vectors : ndarray of complex, shape (k, n)
        One in each row.
    """
    sparse = scipy.sparse.csr_array(a)
    scale, colour = skew_scaling(sparse), two_colours(sparse)
    if scale is None:
        values, vectors = _proportional(sparse) or _general(a)
    elif colour is None:
        angular, shapes = scipy.linalg.eigh(1j * scale[:, None] * a / scale)
        values, vectors = -1j * angular, (shapes / scale[:, None]).T
    else:
        values, vectors = _by_singular_values(a, scale, colour)
    values = zero_rounding(values, len(a))
    kept = values.imag >= 0
    return values[kept], vectors[kept]


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
    return int((sizes > _NONE * len(a) * sizes.max(initial=0.0)).sum())


def _equilibrate(a: scipy.sparse.csr_array) -> tuple[scipy.sparse.csr_array, Real]:
    """A matrix with rows and columns of equal size (see `_rank`), and the scales of the columns."""
    columns = np.ones(a.shape[1])
    for _ in range(_SWEEPS):
        for axis in (1, 0):
            size = np.sqrt(abs(a).max(axis=axis).toarray().ravel())
            back = scipy.sparse.diags_array(1 / np.where(size > 0, size, 1.0))
            a = back @ a if axis else a @ back
            columns = columns if axis else columns * back.diagonal()
    return a, columns


def _null_vectors(a: Real, count: int) -> Real | None:
    """So many vectors that a matrix maps to zero, in columns; None if there are not so many.

    Then at least as many singular values are zero as `_rank` has it, without an SVD.
    """
    even, columns = _equilibrate(scipy.sparse.csr_array(a))
    size = float(np.sqrt(abs(even).sum(axis=0).max() * abs(even).sum(axis=1).max()))
    factors = factors_of(even - _SHIFT * size * scipy.sparse.eye_array(len(a)))
    if factors is None:
        return None
    found = np.random.default_rng(0).standard_normal((len(a), count))
    for _ in range(_TURNS):
        found = scipy.linalg.qr(factors.solve(found), mode="economic")[0]
    if not np.linalg.norm(even @ found, 2) <= _NONE * len(a):
        return None
    return columns[:, None] * found


def _proportional(a: scipy.sparse.csr_array) -> tuple[Complex, Complex] | None:
    """Eigenpairs of a drive whose damping is proportional to inertias and stiffnesses; else None.

    With ``G = U s V'`` and ``H = alpha + beta G G'``, ``u' = G v - H u`` and ``v' = -G' u`` fall
    into ``l^2 + (alpha + beta s^2) l + s^2 == 0``.
    """
    elastic = scipy.sparse.csr_array(a * (a * a.T < 0))
    elastic.eliminate_zeros()
    if scipy.sparse.csgraph.connected_components(elastic, directed=False)[0] > 1:
        return None
    scale, colour = skew_scaling(elastic), two_colours(elastic)
    if scale is None or colour is None:
        return None
    damping = elastic - a
    damping.eliminate_zeros()
    if colour[damping.nonzero()[0][0]]:
        colour = ~colour
    one, two = np.flatnonzero(~colour), np.flatnonzero(colour)
    if damping[two].nnz or damping[:, two].nnz:
        return None
    both = scipy.sparse.diags_array(scale), scipy.sparse.diags_array(1 / scale)
    block = (both[0] @ elastic @ both[1])[one][:, two]
    shares = _find_shares((both[0] @ damping @ both[1])[one][:, one], block @ block.T)
    if shares is None:
        return None
    left, size, right = scipy.linalg.svd(block.toarray())
    pairs, n = len(size), a.shape[0]
    if size.min(initial=np.inf) <= _NONE * n * size.max(initial=0.0):
        return None
    half = 0.5 * (shares[0] + shares[1] * size**2)
    root = np.sqrt((half - size) * (half + size) + 0j)
    first = -half - root
    values = np.zeros(n, dtype=complex)
    values[: 2 * pairs] = np.concatenate([first, size**2 / first])
    vectors = np.zeros((n, n), dtype=complex)
    vectors[one, : 2 * pairs] = np.tile(left[:, :pairs], 2) * values[: 2 * pairs]
    vectors[two, : 2 * pairs] = np.tile(-right[:pairs].T * size, 2)
    # what is left does not bend: either torsions or speeds
    vectors[one, 2 * pairs : pairs + len(one)] = left[:, pairs:]
    vectors[two, 2 * pairs : pairs + len(two)] = right[pairs:].T
    values[2 * pairs : pairs + len(one)] = -shares[0]
    lengths = np.linalg.norm(vectors, axis=0)
    return zero_rounding(values, n), (vectors / lengths / scale[:, None]).T


def _find_shares(
    damping: scipy.sparse.csr_array, stiffness: scipy.sparse.csr_array
) -> tuple[float, float] | None:
    """The numbers of ``damping == alpha + beta stiffness``, exact to rounding; None without any."""
    i, j = (abs(damping) + abs(stiffness)).nonzero()
    d, c, own = damping[i, j], stiffness[i, j], i == j
    ratios = d[~own] / c[~own] if c[~own].all() else np.full(1, np.nan)
    beta = float(np.median(ratios)) if len(ratios) else 0.0
    alpha = float(np.median((d - beta * c)[own]))
    if abs(alpha) <= _ALIKE * abs(beta) * c[own].max():
        alpha = 0.0
    off = np.abs(d - alpha * own - beta * c)
    fits = (off <= _ALIKE * (abs(alpha) * own + np.abs(beta * c))).all()
    return (alpha, beta) if fits else None


def _by_singular_values(a: Real, scale: Real, colour: Boolean) -> tuple[Complex, Complex]:
    one, two = np.flatnonzero(colour), np.flatnonzero(~colour)
    left, angular, right = scipy.linalg.svd(scale[one, None] * a[np.ix_(one, two)] / scale[two])
    left, right = (left / scale[one, None]).T, right / scale[two]
    pairs = int((zero_rounding(angular, len(a)) > 0).sum())
    values = np.zeros(len(a) - pairs, dtype=complex)
    values.imag[:pairs] = angular[:pairs]
    vectors = np.zeros((len(a) - pairs, len(a)), dtype=complex)
    vectors.real[: len(one), one] = left
    vectors.imag[:pairs, two] = right[:pairs]
    # what is left is still: either torsions or speeds
    vectors.real[len(one) :, two] = right[pairs:]
    return values, vectors


def _general(a: Real) -> tuple[Complex, Complex]:
    balanced, transform = scipy.linalg.matrix_balance(a)
    values, vectors = scipy.linalg.eig(balanced)
    still = zero_rounding(values, len(a)) == 0
    if still.any():
        inverse = transform.T / (transform.sum(axis=0) ** 2)[:, None]
        null = _null_vectors(a, int(still.sum()))
        if null is not None:
            rest = scipy.linalg.qr(inverse @ null, mode="economic")[0]
        else:
            # a defective zero (an angle kept beside its speed) has fewer vectors than its count
            lost = max(_rank(a @ a) - int((~still).sum()), 0)
            count = len(a) - _rank(a) + lost
            rest = np.linalg.svd(balanced)[2][len(a) - count :].T
        values = np.concatenate([values[~still], np.zeros(rest.shape[1])])
        vectors = np.hstack([vectors[:, ~still], rest])
    values = np.where(np.abs(values.real) <= 1e-14 * np.abs(values), 1j * values.imag, values)
    values = zero_rounding(values, len(a))
    return values, (scipy.sparse.csr_array(transform) @ vectors).T


def zero_rounding(values: Complex, n: int) -> Complex:
    """Values that are zero to rounding become exactly zero; of several matrices row by row."""
    limit = 1e-13 * n * np.abs(values).max(axis=-1, initial=0.0, keepdims=True)
    return np.where(np.abs(values) <= limit, 0.0, values)


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


def _skew(blocks: Real, first: scipy.sparse.csr_array) -> tuple[Boolean, Real]:
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
    fits: Boolean = alike & (ratio > 0).all(axis=1) & (off < 1e-9).all(axis=1)
    own = scale[fits]
    return fits, own[:, :, None] * blocks[fits] / own[:, None, :]
