"""Torsional vibration of a uniform bar: its exact stiffness and shape at a frequency."""

from __future__ import annotations

import numpy as np


def dynamic_stiffness(c: float, transit: float, w: np.ndarray) -> np.ndarray:
    """Exact stiffness of a uniform bar in harmonic motion: torques at its ends over their angles.

    ``K = c x / sin(x) [[cos(x), -1], [-1, cos(x)]]`` with ``x = w T``; the solution of
    ``G I_p phi'' + w^2 rho I_p phi = 0`` between the ends (Clough and Penzien, Dynamics of
    Structures, gives that of the bar in tension, the same in other letters). At ``w = 0`` it is the
    spring `c`. Where `x` is a multiple of pi the clamped bar is in resonance, and K is infinite.

    Parameters
    ----------
    c : float
        Static stiffness ``G I_p / L``, N.m/rad; complex for a loss factor.
    transit : float
        Time a wave takes from end to end, s; complex for a loss factor.
    w : ndarray, shape (m,)
        Circular frequencies, rad/s; they may be complex.

    Returns
    -------
    ndarray, shape (m, 2, 2)
        Torque on the bar at end a and b for a unit angle of each, N.m/rad.
    """
    x = np.atleast_1d(np.asarray(w) * transit)
    standing = x == 0
    x = np.where(standing, 1.0, x)
    with np.errstate(divide="ignore"):
        cross = np.where(standing, 1.0, x / np.sin(x))
    own = np.where(standing, 1.0, cross * np.cos(x))
    return c * np.stack([np.stack([own, -cross], -1), np.stack([-cross, own], -1)], -2)


def angles_along(x: float, at_a: complex, at_b: complex, places: np.ndarray) -> np.ndarray:
    """Angles along a uniform bar in harmonic motion, from those of its ends.

    ``(at_a sin(x (1 - s)) + at_b sin(x s)) / sin(x)``: the solution of ``phi'' + x^2 phi = 0``.

    Parameters
    ----------
    x : float
        Phase of a wave from end to end, rad: the circular frequency times `transit`; complex for a
        loss factor. At a multiple of pi the ends do not tell the angles between.
    at_a, at_b : complex
        Angles of the ends, rad.
    places : ndarray, shape (m,)
        Shares s of the length, from end a.

    Returns
    -------
    ndarray, shape (m,)
    """
    s = np.asarray(places, dtype=float)
    from_a, from_b = (1 - s, s) if x == 0 else np.sin([x * (1 - s), x * s]) / np.sin(x)
    return np.asarray(at_a * from_a + at_b * from_b)
