"""Derivatives of natural frequencies and damping ratios from those of eigenvalues."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def hertz_slopes(eigenvalues: Complex, slopes: Complex) -> Real:
    """Derivatives of natural frequencies, Hz.

    Parameters
    ----------
    eigenvalues : ndarray of complex, shape (..., k)
    slopes : ndarray of complex, shape (..., k, d)
        Their derivatives.
    """
    values = eigenvalues[..., None]
    found: Real = (values.conj() * slopes).real / np.abs(values) / (2 * np.pi)
    return found


def damping_slopes(eigenvalues: Complex, slopes: Complex) -> Real:
    """Derivatives of damping ratios, of the same arguments."""
    values = eigenvalues[..., None]
    size = np.abs(values)
    along: Real = (values.conj() * slopes).real / size
    found: Real = -slopes.real / size + values.real * along / size**2
    return found


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
    by = (np.conj(value) * first).real / size
    squares = np.outer(first.conj(), first).real + (np.conj(value) * second).real
    twice: Real = (squares - np.outer(by, by)) / size
    if not of_damping:
        return twice / (2 * np.pi)
    mixed = np.outer(slope, by)
    off: Real = (mixed + mixed.T + real * twice) / size**2 - 2 * real * np.outer(by, by) / size**3
    return off - second.real / size
