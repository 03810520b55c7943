"""Eigenvalues and eigenvectors of a linearised drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import System
from lumped.timeloop.result import OperatingPoint

__all__ = ["Eigenpairs"]

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Eigenpairs:
    """Eigenvalues and eigenvectors of a linearised system (see `Modes`)."""

    system: System
    eigenvalues: Complex
    vectors: Complex
    rigid_vectors: Real
    decays: Real
    decay_vectors: Complex
    point: OperatingPoint
    near: float | None = None

    @property
    def hertz(self) -> Real:
        """Natural frequencies ``abs(eigenvalue) / (2 pi)``, Hz."""
        return np.abs(self.eigenvalues) / (2 * np.pi)

    @property
    def damped_hertz(self) -> Real:
        """Frequencies of the damped oscillation ``imag(eigenvalue) / (2 pi)``, Hz."""
        return self.eigenvalues.imag / (2 * np.pi)

    @property
    def damping(self) -> Real:
        """Damping ratios ``-real(eigenvalue) / abs(eigenvalue)``."""
        return 0.0 - self.eigenvalues.real / np.abs(self.eigenvalues)

    @property
    def rigid(self) -> int:
        """Number of rigid-body modes."""
        return int(self.rigid_vectors.shape[1])
