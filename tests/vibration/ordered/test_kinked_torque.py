"""Orders of a torque with kinks over the angle, and their slopes, against its integrals."""

from __future__ import annotations

import numpy as np

import lumped as lp
from lumped.components import Cylinder, Inertia, Torque

_AREA, _R, _L = np.pi / 4 * 0.12**2, 0.05, 0.25
_TABLE = np.array([(0, 0.0), (1.9, 2e5), (3.1, 0.0), (3.1001, 7e5), (6.28, 7e5), (2 * np.pi, 0.0)])
_ORDERS = np.array([1, 2, 12, 24, 300])


def _amplitudes(r: float = _R) -> np.ndarray:
    """Of the torque of the gas: integrals by Gauss's rule on small parts of each line."""
    parts = np.concatenate(
        [np.linspace(a, b, 200)[:-1] for a, b in zip(_TABLE[:-1, 0], _TABLE[1:, 0], strict=True)]
    )
    half = 0.5 * np.diff(np.append(parts, 2 * np.pi))
    places, weights = np.polynomial.legendre.leggauss(16)
    a = parts[:, None] + half[:, None] * (1 + places)
    lever = r * np.sin(a) * (1 + r * np.cos(a) / np.sqrt(_L**2 - (r * np.sin(a)) ** 2))
    torque = half[:, None] * weights * np.interp(a, *_TABLE.T) * _AREA * lever / np.pi
    return np.array([(torque * np.exp(-1j * order * a)).sum() for order in _ORDERS])


def test_orders_of_torque_with_kinks_and_their_slopes_are_exact() -> None:
    model = lp.compose(
        motor=Torque(tau=0.0),
        fly=Inertia(J=1.5),
        cylinder=Cylinder(
            strokes=2, pressure=_TABLE.tolist(), bore=0.12, r=_R, L=_L, masses="excitation"
        ),
        connections=lambda m: [
            *lp.chain(m.motor, m.fly),
            lp.connect(m.fly.flange_b, m.cylinder.flange),
        ],
    )
    responses = [
        lp.vibration.order_response(
            lp.assemble(model),
            speeds=[50.0, 100.0],
            of=["cylinder.tau_gas"],
            shaft="fly.phi",
            free="motor.tau",
            orders=orders,
        )
        for orders in (_ORDERS, _ORDERS[2:3])
    ]
    amplitudes = _amplitudes()
    np.testing.assert_allclose(
        responses[0]["cylinder.tau_gas"], [amplitudes, amplitudes], rtol=1e-10, atol=1e-11
    )
    slope = lp.vibration.order_sensitivity(
        responses[1], "cylinder.tau_gas", speed=50.0, by=["cylinder.r"]
    )["cylinder.r"]
    step = 1e-6
    sizes = [np.abs(_amplitudes(_R + sign * step))[2] for sign in (1, -1)]
    np.testing.assert_allclose(slope, (sizes[0] - sizes[1]) / (2 * step), rtol=1e-7)
