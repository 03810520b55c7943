"""Left eigenvectors of modes, and the parts of a drive that do not touch."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.errors import SolverError
from lumped.numerics.singular_factors import factors_of
from lumped.vibration.natural.eigenpairs import Eigenpairs

_DISTANCES = (1e-10, 1e-8, 1e-6, 1e-4)
"""Of a shift from an eigenvalue, relative."""


def left_vectors(modes: Eigenpairs, decays: bool = False) -> NDArray[np.complex128]:
    """Left eigenvectors y with ``y^H x == 1``, as columns, by inverse iteration.

    Parameters
    ----------
    modes : Eigenpairs
        From `lumped.modes`; an eigenvalue that repeats in one connected part has no such vector,
        and what is given for it is without meaning.
    decays : bool
        Those of the decays, in place of those of the oscillating modes.
    """
    values = modes.decays if decays else modes.eigenvalues
    right = modes.decay_vectors if decays else modes.vectors
    matrix = scipy.sparse.csc_array(modes.matrix).astype(complex)
    n, part = matrix.shape[0], parts(modes)
    found = np.zeros((n, len(values)), dtype=complex)
    for k, value in enumerate(values):
        x = right[:, k]
        own = np.flatnonzero(part == part[np.abs(x).argmax()])
        block = matrix[own][:, own]
        factors = beside(block, value)
        y = np.ones(len(own)) / np.sqrt(len(own))
        y = y + 0.1 * np.random.default_rng(k).standard_normal(len(own))
        for _ in range(3):
            y = factors.solve(y.astype(complex), trans="H")
            y /= np.linalg.norm(y)
        with np.errstate(divide="ignore", invalid="ignore"):
            found[own, k] = y / np.conj(np.vdot(y, x[own]))
    return found


def beside(block: scipy.sparse.csc_array, value: complex) -> Any:
    """LU factors of ``block - shift``, the shift as close to an eigenvalue as they exist.

    Where an eigenvalue repeats without a shape for each, all close shifts are singular to rounding.
    """
    unit = scipy.sparse.eye_array(block.shape[0])
    for distance in _DISTANCES:
        factors = factors_of(block - value * (1 + distance) * unit)
        if factors is not None:
            return factors
    raise SolverError(
        f"the eigenvalue {value:.6g} 1/s cannot be separated from others that it repeats; change a "
        "parameter a little."
    )


def parts(modes: Eigenpairs) -> NDArray[np.int32]:
    """Number of the connected part of the drive to which each state belongs, shape (n,)."""
    matrix = modes.matrix.copy()
    matrix.eliminate_zeros()
    found: NDArray[np.int32] = scipy.sparse.csgraph.connected_components(matrix, directed=False)[1]
    return found
