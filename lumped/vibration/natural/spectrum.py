"""Natural frequencies and damping ratios of eigenvalues, and their derivatives."""

from __future__ import annotations

import numpy as np

from lumped.support.arrays import Complex, Real

REPEATED = 1e-6
"""Relative distance below which eigenvalues repeat, and have no derivatives of their own."""


class Spectrum:
    """Eigenvalues of oscillating modes.

    Attributes
    ----------
    eigenvalues : ndarray of complex
        One of each conjugate pair, 1/s.
    """

    eigenvalues: Complex

    @property
    def hertz(self) -> Real:
        """Natural frequencies ``abs(eigenvalue) / (2 pi)``, Hz."""
        return np.abs(self.eigenvalues) / (2 * np.pi)

    @property
    def damping(self) -> Real:
        """Damping ratios ``-real(eigenvalue) / abs(eigenvalue)``; nan where it is zero."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return 0.0 - self.eigenvalues.real / np.abs(self.eigenvalues)


def hertz_slopes(eigenvalues: Complex, slopes: Complex) -> Real:
    """Derivatives of natural frequencies, Hz.

    Parameters
    ----------
    eigenvalues : ndarray of complex, shape (..., k)
    slopes : ndarray of complex, shape (..., k, d)
        Their derivatives.
    """
    return size_slopes(eigenvalues[..., None], slopes) / (2 * np.pi)


def damping_slopes(eigenvalues: Complex, slopes: Complex) -> Real:
    """Derivatives of damping ratios, of the same arguments."""
    values = eigenvalues[..., None]
    size = np.abs(values)
    found: Real = -slopes.real / size + values.real * size_slopes(values, slopes) / size**2
    return found


def size_slopes(values: Complex | complex, slopes: Complex) -> Real:
    """Derivatives of magnitudes."""
    return (np.conj(values) * slopes).real / np.abs(values)


def second_derivatives(
    value: complex, first: Complex, second: Complex, *, of_damping: bool
) -> Real:
    """Second derivatives of a natural frequency, Hz, or of a damping ratio, shape (d, d).

    Parameters
    ----------
    value : complex
        The eigenvalue.
    first, second : ndarray of complex, shapes (d,) and (d, d)
        Its derivatives.
    of_damping : bool
        Which of both.
    """
    size, real, slope = abs(value), value.real, first.real
    by = size_slopes(value, first)
    squares = np.outer(first.conj(), first).real + (np.conj(value) * second).real
    twice: Real = (squares - np.outer(by, by)) / size
    if not of_damping:
        return twice / (2 * np.pi)
    mixed = np.outer(slope, by)
    off: Real = (mixed + mixed.T + real * twice) / size**2 - 2 * real * np.outer(by, by) / size**3
    return off - second.real / size
