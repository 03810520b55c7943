"""How well the eigenvalues of modes are found, and how well they can be."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.numerics.eigen import nonzero
from lumped.numerics.skew_scaling import balance
from lumped.points.vibrating_states import moving
from lumped.vibration.natural.eigenpairs import Eigenpairs
from lumped.vibration.natural.left_vectors import left_vectors

Real = NDArray[np.float64]

_MOST = 500


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Accuracy of the oscillating modes, in balanced states, so that units do not count.

    Attributes
    ----------
    residuals : ndarray, shape (k,)
        ``|A x - l x| / (|A| |x|)``: by how much, relatively, the linearisation would have to be
        another for the mode to be exact (backward error).
    conditions : ndarray, shape (k,)
        ``|y| |x| / |y^H x|``: by how much a change of the linearisation is enlarged in the
        eigenvalue. 1 if undamped; infinite where an eigenvalue repeats without a shape for each.
    """

    residuals: Real
    conditions: Real

    def __repr__(self) -> str:
        # digits of rounding mean nothing, and differ from machine to machine
        largest = max(float(self.residuals.max(initial=0.0)), 3e-15)
        bound = 10.0 ** math.ceil(math.log10(largest))
        return (
            f"residual of eigenpairs below {bound:.0e}, "
            f"condition of eigenvalues at most {self.conditions.max(initial=1.0):.3g}"
        )


def accuracy(modes: Eigenpairs) -> Accuracy:
    """Residuals and conditions (Golub and Van Loan, Matrix Computations, 4th ed., 7.2.2)."""
    matrix = modes.matrix
    own = np.flatnonzero(moving(modes.system, modes.point))
    matrix = matrix[own][:, own]
    scale = balance(matrix)
    balanced = scipy.sparse.diags_array(scale) @ matrix @ scipy.sparse.diags_array(1 / scale)
    right = scale[:, None] * modes.vectors[own]
    left = left_vectors(modes)[own] / scale[:, None]
    length = np.linalg.norm(right, axis=0)
    missed = np.linalg.norm(balanced @ right - right * modes.eigenvalues, axis=0)
    norm = float(np.sqrt(abs(balanced).sum(axis=0).max() * abs(balanced).sum(axis=1).max()))
    with np.errstate(divide="ignore", invalid="ignore"):
        conditions = np.linalg.norm(left, axis=0) * length
    return Accuracy(missed / (norm * length), np.where(np.isnan(conditions), np.inf, conditions))


def count_lost_eigenvalues(modes: Eigenpairs) -> int:
    """Eigenvalues that are not zero, but below the rounding of the highest (see `Modes.lost`)."""
    own = np.flatnonzero(moving(modes.system, modes.point))
    if not modes.rigid or modes.near is not None or len(own) > _MOST:
        return 0
    matrix = modes.matrix[own][:, own]
    matrix.eliminate_zeros()
    label = scipy.sparse.csgraph.connected_components(matrix, directed=False)[1]
    blocks = (np.flatnonzero(label == k) for k in range(label.max(initial=-1) + 1))
    true = sum(nonzero(matrix[block][:, block].toarray()) for block in blocks)
    return max(true - 2 * len(modes.eigenvalues) - len(modes.decays), 0)
