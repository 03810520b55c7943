"""Two inertias, a progressive coupling, a propeller law; its natural frequency by numpy alone."""

from __future__ import annotations

import numpy as np
import scipy
from rows import assemble_row

import lumped as lp
from lumped.components import Inertia, QuadraticTorque, Spring, Torque

J_A, J_B, RATED, W_RATED = 2.0, 5.0, 900.0, 100.0
SOFT, CUBIC = 2e4, 3e6


class Progressive(Spring):
    """Coupling with the torque ``soft twist + cubic twist^3``."""

    soft: lp.Param = lp.param("N.m/rad", "stiffness without torque", SOFT, above=0)
    cubic: lp.Param = lp.param("N.m/rad3", "progression", CUBIC, min=0)
    c: lp.Param = lp.param("N.m/rad", "unused", 1.0)

    def equations(self):
        every = list(super().equations())
        yield from every[:1]
        yield self.tau == self.soft * self.phi_rel + self.cubic * self.phi_rel**3
        yield from every[2:]

    def stored(self):
        return 0.5 * self.soft * self.phi_rel**2 + 0.25 * self.cubic * self.phi_rel**4


def drive(coupling):
    """Motor, coupling and propeller; the motor balances the torque of the water."""
    return assemble_row(
        motor=Torque(tau=0.0),
        a=Inertia(J=J_A),
        coupling=coupling,
        b=Inertia(J=J_B),
        water=QuadraticTorque(tau_nominal=-RATED, w_nominal=W_RATED),
    )


def respond(system, speeds, **more):
    return lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["coupling.tau"],
        shaft="a.phi",
        free="motor.tau",
        excitations={"motor.tau": {1: 1.0}},
        **more,
    )


def cubic_stiffness(torque, soft=SOFT, cubic=CUBIC):
    """Slope of the progressive law at a mean torque."""
    most = torque / soft + (torque / cubic) ** (1 / 3) if cubic else torque / soft
    twist = scipy.optimize.brentq(
        lambda x: soft * x + cubic * x**3 - torque, 0.0, most, xtol=1e-16, rtol=1e-15
    )
    return soft + 3 * cubic * twist**2


def hertz(speed, stiffness, j_b=J_B, rated=RATED):
    """Natural frequency at the mean torque of a speed; the water damps with its slope."""
    c = stiffness(rated * (speed / W_RATED) ** 2)
    water = 2 * rated * speed / W_RATED**2
    matrix = np.array([[0, -1, 1], [c / J_A, 0, 0], [-c / j_b, 0, -water / j_b]])
    values = np.linalg.eigvals(matrix)
    return float(np.abs(values[np.argmax(values.imag)]) / (2 * np.pi))


def critical(order, stiffness, begin, end, **more):
    """All speeds at which an order meets the frequency, between many speeds."""

    def away(speed):
        return hertz(speed, stiffness, **more) - order * speed / (2 * np.pi)

    grid = np.linspace(begin, end, 101)
    side = np.sign([away(speed) for speed in grid])
    return [
        scipy.optimize.brentq(away, *grid[k : k + 2], xtol=1e-14, rtol=1e-14)
        for k in np.flatnonzero(side[1:] != side[:-1])
    ]
