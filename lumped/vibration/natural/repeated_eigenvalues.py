"""How eigenvalues that repeat part when one parameter changes."""

from __future__ import annotations

import numpy as np
import scipy

from lumped.errors import SolverError
from lumped.points.linearise import sparse_state_matrix
from lumped.points.moved_equilibrium import find_moved_point, still_point
from lumped.points.vibrating_states import moving
from lumped.support.arrays import Complex
from lumped.vibration.natural.eigenpairs import factors_beside
from lumped.vibration.natural.matrix_slopes import Along
from lumped.vibration.natural.modes import Modes

_DEFECTIVE = 1e-6
"""Angle between left and right vectors below which an eigenvalue has too few shapes."""


def derive_split(modes: Modes, together: list[int], place: int) -> Complex:
    """Derivatives of the eigenvalues into which one that repeats parts, 1/s, shape (m,).

    With bases X and Y of the right and left eigenvectors they are the eigenvalues of
    ``(Y^H X)^-1 Y^H (dA/dp) X`` (Lancaster, Numerische Mathematik 6, 1964).

    Parameters
    ----------
    together : list of int
        The modes whose eigenvalue is the same.
    place : int
        Place of the parameter.

    Raises
    ------
    SolverError
        If there are fewer shapes than eigenvalues, where the derivatives are infinite.
    """
    system, point = modes.system, modes.point
    own = modes.own_part(modes.vectors[:, together[0]])
    own = own[moving(system, point)[own]]
    block = scipy.sparse.csc_array(sparse_state_matrix(system, point))[own][:, own].astype(complex)
    value = modes.eigenvalues[together[0]]
    factors = factors_beside(block, value)
    left = np.random.default_rng(3).standard_normal((len(own), len(together))).astype(complex)
    for _ in range(4):
        left = scipy.linalg.qr(factors.solve(left, trans="H"), mode="economic")[0]
    right = scipy.linalg.qr(modes.vectors[own][:, together], mode="economic")
    angles = np.linalg.svd(left.conj().T @ right[0], compute_uv=False)
    sizes = np.abs(np.diag(right[1]))
    if min(angles.min(), sizes.min() / sizes.max()) < _DEFECTIVE:
        raise SolverError(
            f"{system.name}: the eigenvalue of mode {together[0]} ({value:.6g} 1/s) repeats with "
            "fewer shapes than eigenvalues: its derivatives are infinite. Change a parameter a "
            "little."
        )
    vectors = np.zeros((len(point.x), len(together)), dtype=complex)
    vectors[own] = right[0]
    moved = find_moved_point(point, [place]) or still_point(point, [place])
    along = Along(point, system.rates, moved)
    change = np.column_stack([along(v)[own, 0] for v in vectors.T])
    small = np.linalg.solve(left.conj().T @ right[0], left.conj().T @ change)
    found = np.linalg.eigvals(small).astype(complex)
    ordered: Complex = found[np.lexsort((found.real, found.imag))]
    return ordered
