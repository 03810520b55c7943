"""How eigenvalues that repeat part when one parameter changes."""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.errors import SolverError
from lumped.points.linearise import sparse_state_matrix
from lumped.points.moved_equilibrium import MovedPoint, find_moved_point, still_point
from lumped.points.vibrating_states import moving
from lumped.vibration.natural.left_vectors import beside, parts
from lumped.vibration.natural.modes import Modes

Complex = NDArray[np.complex128]

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
    part = parts(modes)
    own = np.flatnonzero(
        (part == part[np.abs(modes.vectors[:, together[0]]).argmax()]) & moving(system, point)
    )
    block = scipy.sparse.csc_array(sparse_state_matrix(system, point))[own][:, own].astype(complex)
    value = modes.eigenvalues[together[0]]
    factors = beside(block, value)
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
    along = Along(modes, system.rates, moved)
    change = np.column_stack([along(v)[own, 0] for v in vectors.T])
    small = np.linalg.solve(left.conj().T @ right[0], left.conj().T @ change)
    found = np.linalg.eigvals(small).astype(complex)
    ordered: Complex = found[np.lexsort((found.real, found.imag))]
    return ordered


class Along:
    """Derivatives by parameters of ``(d outputs / dx) vector``.

    Parameters
    ----------
    outputs : SX
        Expressions of the system.
    moved : MovedPoint
        How the operating point follows the parameters.
    """

    def __init__(self, modes: Modes, outputs: ca.SX, moved: MovedPoint) -> None:
        x, theta, _, _ = modes.system.inputs
        v = ca.SX.sym("v", x.numel())
        slope = ca.jacobian(ca.jtimes(outputs, x, v), ca.vertcat(x, theta))
        self._function = ca.Function("along", [*modes.system.inputs, v], [slope])
        self._point, self._moved = modes.point, moved

    def __call__(self, vector: Complex) -> Complex:
        """For a direction of the states that is held, shape (outputs, parameters)."""
        point = self._point
        real, imaginary = (
            scipy.sparse.csc_array(
                self._function(point.x, point.theta, point.time, point.settings, part).sparse()
            )
            for part in (vector.real, vector.imag)
        )
        found: Complex = self._moved.through(real + 1j * imaginary)
        return found
