"""A series of time made of harmonics with random phases."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

__all__ = ["harmonic_sum"]


def harmonic_sum(amplitudes: Sequence[float], n: int, seed: int) -> list[float]:
    """Sum of the harmonics 1, 2, ... of a period, at n points of it.

    Parameters
    ----------
    amplitudes : sequence of float
        Of the harmonics, fewer than n / 2.
    n : int
        Number of points, even.
    seed : int
        Of the random phases, uniform over a turn.

    Returns
    -------
    list of float
    """
    phases = np.random.default_rng(seed).uniform(0.0, 2 * np.pi, len(amplitudes))
    lines = np.zeros(n // 2 + 1, dtype=complex)
    lines[1 : len(amplitudes) + 1] = np.asarray(amplitudes) * np.exp(1j * phases)
    return [float(value) for value in np.fft.irfft(lines, n) * n / 2]
