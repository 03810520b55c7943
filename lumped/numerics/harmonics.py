"""Sums of harmonics: of curves of straight lines, their lowest value, and with random phases."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

Harmonics = list[tuple[float, float, float]]
"""Rows of harmonic, amplitude and phase, rad: ``amplitude cos(harmonic x + phase)``."""


def harmonics_of_lines(points: Sequence[tuple[float, float]], count: int) -> Harmonics:
    """First harmonics of a curve of straight lines of period 1, exact.

    Parameters
    ----------
    points : sequence of (float, float)
        Places and values over one period, both ends included; a place that stands twice is a jump.
    count : int
        Of harmonics.

    Returns
    -------
    Harmonics
        Over the angle ``2 pi`` times the place.
    """
    found = []
    for k in range(1, count + 1):
        w, total = 2 * np.pi * k, 0j
        for (a, u), (b, v) in pairwise(points):
            if a < b:
                begin, end = cmath.exp(-1j * w * a), cmath.exp(-1j * w * b)
                total += 1j * (v * end - u * begin) / w + (v - u) / (b - a) * (end - begin) / w**2
        found.append((float(k), 2 * abs(total), cmath.phase(total)))
    return found


def lowest_of_harmonics(rows: Harmonics) -> tuple[float, float]:
    """Lowest value of a sum of harmonics, and its angle, rad.

    Of harmonics that are no whole numbers it is the bound ``-sum(abs(amplitude))``.

    Parameters
    ----------
    rows : Harmonics
        What is summed.

    Returns
    -------
    (float, float)
    """
    if any(k != round(k) for k, _, _ in rows):
        return -sum(abs(a) for _, a, _ in rows), 0.0
    n = max((int(k) for k, _, _ in rows), default=0)
    slope = np.zeros(2 * n + 1, dtype=complex)  # a polynomial of exp(i x)
    for k, a, p in rows:
        slope[n - int(k)] += 0.5j * k * a * cmath.exp(1j * p)
        slope[n + int(k)] -= 0.5j * k * a * cmath.exp(-1j * p)
    x = np.append(0.0, np.angle(np.roots(slope)))
    total = sum((a * np.cos(k * x + p) for k, a, p in rows), np.zeros_like(x))
    return float(total.min()), float(x[total.argmin()])


def make_series(amplitudes: Sequence[float], n: int, seed: int) -> list[float]:
    """Sum of the harmonics 1, 2, ... of a period with random phases, at n points of it.

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
