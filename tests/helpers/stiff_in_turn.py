"""A body that swings freely for a second, is held by a strong damper for the next, and so on.

Free, it swings 32 times a second; held, it creeps with a rate of 25 per million of that of its
damper. Both are known in closed form.
"""

import itertools

import numpy as np

import lumped as lp
from lumped.ops import where

VALUES = {"J": 2.0, "c": 8e4, "d": 2e6, "tau": 30.0, "free": 3.0}
EDGES = (1.0, 2.0, 3.0)
UNTIL = 4.0


class InTurn(lp.Component):
    """Spring and damper to the ground, the damper pressed from 1 to 2 s and from 3 s on."""

    J: lp.Param = lp.param("kg.m2", "inertia", VALUES["J"])
    c: lp.Param = lp.param("N.m/rad", "stiffness", VALUES["c"])
    d: lp.Param = lp.param("N.m.s/rad", "damping while pressed", VALUES["d"])
    tau: lp.Param = lp.param("N.m", "torque", VALUES["tau"])
    free: lp.Param = lp.param("N.m.s/rad", "damping while free", VALUES["free"])
    cubic: float = 0.0  # a part of the spring; the closed form has none
    phi: lp.Var = lp.var("rad", "angle", 0.1)
    w: lp.Var = lp.var("rad/s", "speed", 0.0)

    def equations(self):
        """Newton's law."""
        d = self.free
        for i, edge in enumerate(EDGES):
            d = where(lp.time < edge, d, self.free if i == 1 else self.d)
        yield lp.der(self.phi) == self.w
        spring = self.c * self.phi + self.cubic * self.phi**3
        yield self.J * lp.der(self.w) == self.tau - spring - d * self.w


def moved(phi, w, t, J, c, d, tau):
    """Angle and speed a time later; takes complex steps."""
    mean, square = -0.5 * d / J, (0.5 * d / J) ** 2 - c / J
    root = np.sqrt(square + 0j)
    if np.real(square) < 0:
        even, odd = np.exp(mean * t) * np.array([np.cosh(root * t), np.sinh(root * t) / root])
    else:
        fast = mean - root
        slow = c / J / fast
        even = 0.5 * (np.exp(slow * t) + np.exp(fast * t))
        odd = 0.5 * (np.exp(slow * t) - np.exp(fast * t)) / root
    off = phi - tau / c
    phi = tau / c + even * off + odd * (w - mean * off)
    return phi, even * w + odd * (mean * w - c / J * off)


def end(J, c, d, tau, free, phi=0.1, w=0.0):
    """Angle and speed at the end; takes complex steps."""
    for begin, stop in itertools.pairwise((0.0, *EDGES, UNTIL)):
        damping = free if begin in (0.0, EDGES[1]) else d
        phi, w = moved(phi, w, stop - begin, J, c, damping, tau)
    return np.array([phi, w])
