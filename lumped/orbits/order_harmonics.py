"""Harmonics of a periodic motion over the angle of a shaft."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lumped.orbits.orbit import PeriodicOrbit
from lumped.vibration.ordered.order_response import OrderResponse

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


def order_harmonics(
    orbit: PeriodicOrbit,
    outputs: tuple[str, ...],
    orders: Real,
    turns: int,
    shaft: tuple[str, float] | None = None,
) -> tuple[Complex, Real]:
    """Amplitudes of orders, shape (o, outputs), and means, shape (outputs,).

    Parameters
    ----------
    turns : int
        Turns in a period.
    shaft : (name, float), optional
        Angle of the shaft, and its value where orders have no phase. They count over what it is on
        average, which grows steadily; without it over the time from the start of the period.
    """
    numbers = np.rint(orders * turns).astype(int)
    offset = 0.0
    if shaft is not None:
        name, zero = shaft
        offset = orbit.mean(name) - np.pi * turns - zero
    turned = np.exp(-1j * orders * offset)
    every = np.array([orbit.harmonics(output, int(numbers.max())) for output in outputs])
    return (every[:, numbers] * turned).T, every[:, 0].real


def angle_of(response: OrderResponse, k: int) -> tuple[str, float]:
    """Angle of the shaft of a response, and its value where orders have no phase at a speed."""
    own, system = response.rotation.at(k), response.system
    assert own.shaft is not None
    function = ca.Function("angle", system.inputs, [system.expressions([own.shaft])])
    value = function(own.x[0], own.theta[0], own.points[0].time, own.settings[0])
    return own.shaft, float(value)
