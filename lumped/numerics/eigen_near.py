"""Some eigenvalues of a large linearised drive, those nearest to a frequency.

Shift-invert Lanczos and Arnoldi iteration (ARPACK; Saad, Numerical Methods for Large Eigenvalue
Problems, ch. 8). Undamped drives are solved as singular values of the sparse block ``B`` that
couples torsions with speeds. ``B' B`` is not factorised: it squares the ratio of the highest to
the lowest frequency. An augmented matrix that contains ``B`` itself takes its place.
"""

from __future__ import annotations

import numpy as np
import scipy

from lumped.errors import SolverError
from lumped.numerics.eigen import eigenpairs
from lumped.numerics.skew_scaling import balance, skew_scaling, two_colours
from lumped.support.arrays import Boolean, Complex, Real

_OFFSET = 1e-9
"""Distance of a shift from zero, relative to the highest frequency: zero is an eigenvalue."""
_ZERO = 1e-13


def eigenpairs_near(a: scipy.sparse.csr_array, near: float, count: int) -> tuple[Complex, Complex]:
    """Eigenpairs of a real matrix that does not fall into parts, nearest to ``1j * near``.

    Parameters
    ----------
    a : csr_array, shape (n, n)
        No stored zeros.
    near : float
        Angular frequency, rad/s.
    count : int
        How many oscillating modes are wanted.

    Returns
    -------
    values : ndarray of complex, shape (k,)
        At least `count` with a positive imaginary part (all, if there are fewer), and others that
        were found with them. If `near` is zero, also exactly zero for each rigid-body mode.
    vectors : ndarray of complex, shape (k, n)
        One in each row.

    Raises
    ------
    SolverError
        If the iteration does not converge.
    """
    try:
        scale = skew_scaling(a)
        colour = None if scale is None else two_colours(a)
        found = None
        if scale is not None and colour is not None:
            skew = scipy.sparse.diags_array(scale) @ a @ scipy.sparse.diags_array(1 / scale)
            found = _singular(scipy.sparse.csr_array(skew), colour, near, count, 1 / scale)
        return found or _general(a, near, count)
    except (scipy.sparse.linalg.ArpackNoConvergence, RuntimeError) as error:
        raise SolverError(
            f"modes: no eigenvalues near {near / (2 * np.pi):g} Hz were found ({error}). Ask for "
            "fewer modes, or for others."
        ) from None


def _singular(
    skew: scipy.sparse.csr_array, colour: Boolean, near: float, count: int, back: Real
) -> tuple[Complex, Complex] | None:
    """Singular values of the block; None if zero is one of them or nearly all are wanted."""
    few, many = np.flatnonzero(colour), np.flatnonzero(~colour)
    if len(few) > len(many):
        few, many = many, few
    block = scipy.sparse.csc_array(skew[many][:, few])
    size, norm = (
        len(few),
        float(np.sqrt(abs(block).sum(axis=0).max() * abs(block).sum(axis=1).max())),
    )
    square = near**2 * (1 + 1e-8) - (_OFFSET * norm) ** 2
    solve = _factorise_shifted(block, -square)
    inverse = scipy.sparse.linalg.LinearOperator((size, size), matvec=solve, dtype=float)
    start = np.random.default_rng(1).standard_normal(size)
    wanted = min(count, size) + 4
    while wanted < size // 2:
        values, z = scipy.sparse.linalg.eigsh(
            block.T @ block, wanted, sigma=square, OPinv=inverse, v0=start
        )
        drive: Real = block @ z
        omega = np.linalg.norm(drive, axis=0)
        nearest = np.argsort(np.abs(omega - near))[:count]
        far = np.abs(omega[nearest] - near).max()
        reach = np.abs(values - square).max()
        if max((near + far) ** 2 - square, square - max(near - far, 0) ** 2) <= reach:
            break
        wanted *= 2
    else:
        return None
    if (omega <= _ZERO * len(colour) * norm).any():
        return None
    vectors = np.zeros((len(colour), len(omega)), dtype=complex)
    sign = 1j if colour[few[0]] else -1j
    vectors[many], vectors[few] = drive / omega, sign * z
    found: Complex = 1j * omega
    rigid = len(many) - size
    if near == 0 and rigid:
        still = np.zeros((len(colour), rigid))
        still[many] = _null_space(scipy.sparse.csc_array(block.T), rigid, norm)
        found, vectors = np.append(found, np.zeros(rigid)), np.hstack([vectors, still])
    return found, (vectors * back[:, None]).T.astype(complex)


def _factorise_shifted(block: scipy.sparse.csc_array, shift: float):  # type: ignore[no-untyped-def]
    """``x -> (B' B + shift)^-1 x`` from the factors of an augmented matrix."""
    rows, columns = block.shape
    augmented = scipy.sparse.block_array(
        [[-scipy.sparse.eye_array(rows), block], [block.T, shift * scipy.sparse.eye_array(columns)]]
    )
    factors = scipy.sparse.linalg.splu(
        scipy.sparse.csc_array(augmented), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01
    )

    def solve(x: Real) -> Real:
        right = np.concatenate([np.zeros((rows, *x.shape[1:])), x])
        found: Real = factors.solve(right)[rows:]
        return found

    return solve


def _null_space(block: scipy.sparse.csc_array, count: int, norm: float) -> Real:
    """Orthonormal vectors that a block maps to zero, by inverse iteration."""
    solve = _factorise_shifted(block, (_OFFSET * norm) ** 2)
    found = np.random.default_rng(2).standard_normal((block.shape[1], count))
    for _ in range(4):
        found = scipy.linalg.qr(solve(found), mode="economic")[0]
    return found


def _general(a: scipy.sparse.csr_array, near: float, count: int) -> tuple[Complex, Complex]:
    """With damping: Arnoldi iteration on the balanced matrix."""
    n = a.shape[0]
    scale = balance(a)
    balanced = scipy.sparse.csc_array(
        scipy.sparse.diags_array(scale) @ a @ scipy.sparse.diags_array(1 / scale)
    ).astype(complex)
    norm = float(np.sqrt(abs(balanced).sum(axis=0).max() * abs(balanced).sum(axis=1).max()))
    shift = 1j * (near * (1 + 1e-8) + _OFFSET * norm)
    factors = scipy.sparse.linalg.splu(
        scipy.sparse.csc_array(balanced - shift * scipy.sparse.eye_array(n))
    )
    inverse = scipy.sparse.linalg.LinearOperator((n, n), matvec=factors.solve, dtype=complex)
    start = np.random.default_rng(1).standard_normal(n).astype(complex)
    wanted = 2 * count + 6
    while wanted < n // 2:
        values, vectors = scipy.sparse.linalg.eigs(
            balanced, wanted, sigma=shift, OPinv=inverse, v0=start
        )
        values = np.where(np.abs(values) <= _ZERO * n * norm, 0.0, values)
        values = np.where(np.abs(values.real) <= 1e-14 * np.abs(values), 1j * values.imag, values)
        values = np.where(np.abs(values.imag) <= _ZERO * np.abs(values), values.real, values)
        far = np.sort(np.abs(values[values.imag > 0] - 1j * near))[:count]
        if len(far) == count and far[-1] + abs(shift - 1j * near) <= np.abs(values - shift).max():
            break
        wanted *= 2
    else:
        return eigenpairs(a.toarray())
    still = values == 0
    rigid = vectors[:, still]
    real = np.linalg.svd(np.hstack([rigid.real, rigid.imag]), full_matrices=False)[0]
    vectors[:, still] = real[:, : int(still.sum())]
    return values, (vectors / scale[:, None]).T
