"""Sums of harmonics of an angle: of a curve made of straight lines, and their lowest value."""

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
    """Lowest value of a sum of harmonics of whole numbers among 720 angles, and that angle, rad.

    Parameters
    ----------
    rows : Harmonics
        What is summed.

    Returns
    -------
    (float, float)
    """
    x = np.linspace(0, 2 * np.pi, 720, endpoint=False)
    total = sum((a * np.cos(k * x + p) for k, a, p in rows), np.zeros_like(x))
    return float(total.min()), float(x[total.argmin()])
