"""Reduced inertia of the shear as the Fourier series (7), and the torque (20) with it.

The source keeps 20 harmonics. The inertia jumps where the carriage changes, so the series does not
converge there; the torque by its slope depends on the number of harmonics.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lumped.models.eccentric_shear import scenes, stand
from lumped.models.eccentric_shear.stand import PrintedShear
from lumped.models.sources import Given

ORDER = Given(20, "1", "P", "harmonics of the reduced inertia, N")


def fit_series(order: int = int(ORDER)) -> np.ndarray:
    """Complex amplitudes ``Jc - i Js`` of (7) by the rectangle rule at ``4 order`` angles, kg.m2.

    Returns
    -------
    ndarray, shape (order + 1,)
        The first one is the mean.
    """
    angles = np.arange(4 * order + 1) * np.pi / (2 * order)
    run = scenes.inertia(PrintedShear, angles / stand.SPEED)
    places = np.searchsorted(run.t, angles[:-1] / stand.SPEED * (1 - 1e-12))
    reduced = (scenes.motions(run, PrintedShear)[places] ** 2).sum(axis=1)
    found = np.fft.rfft(reduced)[: order + 1] / (2 * order)
    found[0] /= 2
    return found


def sum_series(amplitudes: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Inertia, kg.m2, and its slope, kg.m2/rad, by the series at some crank angles."""
    k = np.arange(len(amplitudes))[:, None]
    terms = amplitudes[:, None] * np.exp(1j * k * phi)
    return terms.real.sum(axis=0), (1j * k * terms).real.sum(axis=0)


def reduce_peaks(ellipses: Sequence[float], order: int = int(ORDER)) -> list[float]:
    """Greatest motor torque (20) of circles over that of ellipses, with the series' inertia."""
    amplitudes = fit_series(order)
    peaks = []
    for eps in (0.0, *ellipses):
        demand = scenes.turn(scenes.CrankTurned, eps)
        run, u = demand.run, demand.ratio
        inertia = stand.SPEED**2 * sum_series(amplitudes, demand.phi)[1] / 2
        loads = run["loaded.idle.tau"] + run["loaded.cut.tau"]
        torque = (inertia - loads) / u + stand.J_MOTOR * run["motor.a"]
        peaks.append(float(torque.max()))
    return [peaks[0] / peak for peak in peaks[1:]]
