"""Harmonics over the turns of what a steady rotation excites, and means over the turns."""

from __future__ import annotations

import numpy as np

from lumped.numerics.interpolated_rows import interpolate_rows
from lumped.support.arrays import Complex, Real
from lumped.vibration.rotating.rotation import Rotation, find_settings, samples_of
from lumped.vibration.rotating.small_vibrations import Parts, SmallVibrations

_ROUNDING = 1e-13
"""Mean over the largest size that is nothing but rounding."""


def harmonics(
    small: SmallVibrations, steady: Rotation, orders: Real
) -> tuple[Complex, Complex, Real, list[Real]]:
    """Harmonics of rates and outputs, means of outputs, and of the numbers of the matrices.

    Where the states at all speeds follow from the model, they are interpolated over the speed from
    some of the speeds (`interpolate_rows`).

    Returns
    -------
    rates, outputs : ndarray of complex, shapes (k, o, n) and (k, o, q)
    means : ndarray, shape (k, q)
    matrices : list of ndarray, shapes (k, numbers)
    """
    count, time = len(steady.speeds), steady.points[0].time
    n, q = steady.x.shape[1], len(small.outputs)
    if not steady.turns_matter:
        none = np.zeros((count, len(orders), n + q), dtype=complex)
        parts = _all_at_once(small, steady)
        return none[..., :n], none[..., n:], parts.outputs, list(parts[2:])
    cycles = orders * steady.turns
    numbers = np.rint(cycles).astype(int)
    whole = np.abs(cycles - numbers) <= 1e-9
    samples = samples_of(steady, orders)

    def row(k: int) -> tuple[Real, Real]:
        """Harmonics of rates and outputs, and all means; and the sizes of the parts of each."""
        angle, x, settings = steady.along(k, samples)
        parts = small(x, steady.theta[k], settings, time)
        growth = angle[:, None] * _growth(small, steady, k, parts.outputs[0])
        parts = parts._replace(outputs=parts.outputs - growth)
        moving = np.hstack(parts[:2])
        size = np.abs(moving).max(axis=0, initial=0.0)
        spectrum = np.zeros((len(orders), n + q), dtype=complex)
        own = np.fft.rfft(moving, axis=0)[numbers[whole]] * (2 / samples)
        spectrum[whole] = np.where(np.abs(own) > 1e-13 * size, own, 0)
        still = np.hstack(parts[1:])
        sizes = [np.tile(np.repeat(size, 2), len(orders)), np.abs(still).max(axis=0, initial=0.0)]
        return np.append(spectrum.view(float), still.mean(axis=0)), np.concatenate(sizes)

    if len(steady.points) == count or (steady.settings != steady.settings[0]).any():
        rows = np.array([row(k)[0] for k in range(count)])
    else:
        rows = interpolate_rows(row, steady.speeds)
    end = 2 * len(orders) * (n + q)
    spectra = np.ascontiguousarray(rows[:, :end]).view(complex).reshape(count, len(orders), n + q)
    ends = end + np.cumsum([q, *(len(r) for r, _ in small.patterns)])
    means, *matrices = np.split(rows[:, end:], ends[:-1] - end, axis=1)
    return spectra[..., :n], spectra[..., n:], means, matrices


def mean_matrix(small: SmallVibrations, steady: Rotation, orders: Real) -> tuple[Real, Real]:
    """The state matrix at the first speed by means over the turns, and the mean numbers of M.

    It is ``mean(M)^-1 mean(A)``, A in torques: shape (n, n).
    """
    _, x, settings = steady.along(0, samples_of(steady, orders))
    parts = small(x, steady.theta[0], settings, steady.points[0].time)
    numbers = parts.A
    mean = numbers.mean(axis=0)
    mean[np.abs(mean) <= _ROUNDING * np.abs(numbers).max(axis=0, initial=0.0)] = 0.0
    M = parts.M.mean(axis=0)
    pattern, mean = small.masses.divide_matrix(M, small.patterns[0], mean)
    matrix: Real = np.zeros((x.shape[1], x.shape[1]))
    matrix[pattern] = mean
    if steady.turns_matter:
        # rates are the same after the turns; a mean over some angles misses that at kinks
        way = steady.turning
        matrix -= np.outer(matrix @ way, way) / (way @ way)
    return matrix, M


def _growth(small: SmallVibrations, steady: Rotation, k: int, begin: Real) -> Real:
    """By what outputs, such as angles, grow with the angle of the shaft, shape (q,)."""
    cycle = 2 * np.pi * steady.turns
    x = steady.x[k : k + 1] + cycle * steady.turning
    m = find_settings(steady.system, x, steady.theta[k], steady.settings[k])
    found: Real = (small(x, steady.theta[k], m, steady.points[0].time).outputs[0] - begin) / cycle
    return found


def _all_at_once(small: SmallVibrations, steady: Rotation) -> Parts:
    """Everything at all speeds where nothing depends on the angle."""
    return small(steady.x, steady.theta, steady.settings, steady.points[0].time)
