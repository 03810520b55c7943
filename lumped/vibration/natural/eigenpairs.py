"""Eigenvalues and eigenvectors of a linearised drive."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.points.linearise import sparse_state_matrix
from lumped.support.rich_html import RichHtml
from lumped.timeloop.results.operating_point import OperatingPoint

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Eigenpairs(RichHtml):
    """Eigenvalues and eigenvectors of a linearised system (see `Modes`)."""

    system: System
    eigenvalues: Complex
    vectors: Complex
    rigid_vectors: Real
    decays: Real
    decay_vectors: Complex
    point: OperatingPoint
    near: float | None = None
    mean: scipy.sparse.csr_array | None = None

    @property
    def matrix(self) -> scipy.sparse.csr_array:
        """State matrix of which they are, shape (n, n)."""
        if self.mean is not None:
            return self.mean
        return scipy.sparse.csr_array(sparse_state_matrix(self.system, self.point))

    def refuse_mean(self, analysis: str) -> None:
        """Refuse an analysis that looks at the operating point.

        Raises
        ------
        OptionError
            If these are those of a mean over turns.
        """
        if self.mean is not None:
            raise OptionError(
                f"{analysis}: modes of a mean over turns belong to no single angle of the shaft; "
                "take lumped.modes of a drive with constant inertias."
            )

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
