"""Torsional vibration of a uniform bar: how finely it is cut, and its exact stiffness."""

from __future__ import annotations

import math

import numpy as np

from lumped.errors import OptionError
from lumped.support.arguments import checked

__all__ = ["dynamic_stiffness", "elements_needed"]


@checked
def elements_needed(transit: float, f_max: float, accuracy: float) -> int:
    """Number of equal elements, half their inertia at each end, that a uniform bar is cut into.

    In a row of n such elements a wave of the frequency ``f`` of the bar has the frequency
    ``f sin(x) / x`` with ``x = pi f T / n``, `T` the time a wave takes from end to end. At free and
    at clamped ends this is exact, so all natural frequencies are too low by ``1 - sin(x) / x``, and
    that is less than ``x^2 / 6``. Up to `f_max` the error stays below `accuracy` if
    ``n >= pi f_max T / sqrt(6 accuracy)``.

    Parameters
    ----------
    transit : float
        Time a wave takes from end to end, s: length times ``sqrt(rho / G)``.
    f_max : float
        Highest frequency of interest, Hz.
    accuracy : float
        Relative error allowed of natural frequencies up to there.

    Returns
    -------
    int
        At least one.

    Raises
    ------
    OptionError
        If a time or frequency is negative, or the accuracy not between 0 and 1.
    """
    if transit < 0 or f_max < 0:
        name, value, unit = ("f_max", f_max, "Hz") if f_max < 0 else ("transit", transit, "s")
        raise OptionError(f"elements_needed: {name} = {value:g} {unit} must not be negative.")
    if not 0 < accuracy < 1:
        raise OptionError(
            f"elements_needed: accuracy = {accuracy:g}: a relative error between 0 and 1, such as "
            "0.01."
        )
    return max(1, math.ceil(math.pi * f_max * transit / math.sqrt(6 * accuracy)))


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
