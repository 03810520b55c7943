"""Eigenvalues and eigenvectors of a linearised drive, and how well they are found."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.numerics.eigen import nonzero
from lumped.numerics.singular_factors import factors_of
from lumped.numerics.skew_scaling import balance, symmetric_weights
from lumped.points.linearise import moving
from lumped.support.arrays import Complex, Real
from lumped.support.display_units import frequency_unit
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.vibration.natural.spectrum import Spectrum

_DISTANCES = (1e-10, 1e-8, 1e-6, 1e-4)
"""Of a shift from an eigenvalue, relative."""
_MOST = 500


@dataclass(frozen=True, eq=False)
class Eigenpairs(Spectrum, RichHtml):
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
    turning: Real | None = None

    @property
    def matrix(self) -> scipy.sparse.csr_array:
        """State matrix of which they are, shape (n, n)."""
        if self.mean is not None:
            return self.mean
        return scipy.sparse.csr_array(self.system.state_matrix(self.point.inputs))

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

    def check_mode(self, mode: int, analysis: str) -> None:
        """Refuse the number of a mode that is none.

        Raises
        ------
        OptionError
            If there is no such mode.
        """
        count = len(self.eigenvalues)
        if not 0 <= mode < count:
            raise OptionError(f"{analysis}: mode {mode} of {count}; modes count from 0.")

    @property
    def damped_hertz(self) -> Real:
        """Frequencies of the damped oscillation ``imag(eigenvalue) / (2 pi)``, Hz."""
        return self.eigenvalues.imag / (2 * np.pi)

    @property
    def rigid(self) -> int:
        """Number of rigid-body modes."""
        return int(self.rigid_vectors.shape[1])

    @cached_property
    def parts(self) -> NDArray[np.int32]:
        """Number of the connected part of the drive to which each state belongs, shape (n,)."""
        return label_parts(self.matrix)

    def own_part(self, vector: Complex) -> NDArray[np.intp]:
        """States of the part of the drive that moves in a mode."""
        return np.flatnonzero(self.parts == self.parts[np.abs(vector).argmax()])

    @cached_property
    def left_vectors(self) -> Complex:
        """Left eigenvectors y with ``y^H x == 1`` of the oscillating modes, shape (n, k).

        An eigenvalue that repeats in one connected part has no such vector, and what is given for
        it is without meaning.
        """
        return self._find_left(self.eigenvalues, self.vectors)

    @cached_property
    def left_decay_vectors(self) -> Complex:
        """Those of the decays, shape (n, r)."""
        return self._find_left(self.decays, self.decay_vectors)

    def _find_left(self, values: Real | Complex, right: Complex) -> Complex:
        found = np.zeros(right.shape, dtype=complex)
        part = self.parts[np.abs(right).argmax(axis=0)] if right.size else np.zeros(0, dtype=int)
        for label in np.unique(part):
            own, mine = np.flatnonzero(self.parts == label), np.flatnonzero(part == label)
            block = self.matrix[own][:, own]
            block.eliminate_zeros()
            weights, shapes = symmetric_weights(block), right[np.ix_(own, mine)]
            if weights is not None:
                left = (weights[:, None] * shapes).conj()
            else:
                left = find_left_vectors(block, values[mine])
            with np.errstate(divide="ignore", invalid="ignore"):
                found[np.ix_(own, mine)] = left / (left * shapes.conj()).sum(axis=0)
        return found

    def list_modes(
        self, head: Sequence[str], rows: Iterable[Sequence[str]], more: Sequence[Any] = ()
    ) -> str:
        """A table of modes with their natural frequencies.

        Parameters
        ----------
        head : sequence of str
            Heads of further columns.
        rows : iterable of sequence of str
            What stands in these, for as many modes as are shown.
        more : sequence
            Further rows.
        """
        frequency = frequency_unit()
        lines = [
            (str(i + 1), number(frequency.value(hertz), 9), *row)
            for i, (hertz, row) in enumerate(zip(self.hertz, rows, strict=False))
        ]
        return table(("mode", f"natural frequency, {frequency.unit}", *head), [*lines, *more])


def label_parts(matrix: scipy.sparse.csr_array) -> NDArray[np.int32]:
    """Number of the connected part to which each row of a matrix belongs, shape (n,)."""
    own = matrix.copy()
    own.eliminate_zeros()
    found: NDArray[np.int32] = scipy.sparse.csgraph.connected_components(own, directed=False)[1]
    return found


def find_left_vectors(block: scipy.sparse.csr_array, values: Real | Complex) -> Complex:
    """Left eigenvectors of a connected part of a drive by inverse iteration, in columns."""
    matrix, n = scipy.sparse.csc_array(block).astype(complex), block.shape[0]
    found = np.empty((n, len(values)), dtype=complex)
    for k, value in enumerate(values):
        factors = factors_beside(matrix, value)
        y = np.ones(n) / np.sqrt(n) + 0.1 * np.random.default_rng(k).standard_normal(n)
        for _ in range(3):
            y = factors.solve(y.astype(complex), trans="H")
            y /= np.linalg.norm(y)
        found[:, k] = y
    return found


def factors_beside(block: scipy.sparse.csc_array, value: complex) -> Any:
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


def find_accuracy(modes: Eigenpairs) -> Accuracy:
    """Residuals and conditions (Golub and Van Loan, Matrix Computations, 4th ed., 7.2.2)."""
    own = np.flatnonzero(moving(modes.system, modes.point))
    matrix = modes.matrix[own][:, own]
    scale = balance(matrix)
    balanced = scipy.sparse.diags_array(scale) @ matrix @ scipy.sparse.diags_array(1 / scale)
    right = scale[:, None] * modes.vectors[own]
    left = modes.left_vectors[own] / scale[:, None]
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
    label = label_parts(matrix)
    blocks = (np.flatnonzero(label == k) for k in range(label.max(initial=-1) + 1))
    true = sum(nonzero(matrix[block][:, block].toarray()) for block in blocks)
    return max(true - 2 * len(modes.eigenvalues) - len(modes.decays), 0)
