"""The least change that meets equations to first order, as an expression."""

from __future__ import annotations

import casadi as ca
import numpy as np

_SINGULAR = 1e-14
"""Part of its square by which each equation yields, so that the change is always finite."""
_TURNS = 3


def least_change(
    slopes: ca.SX, left: ca.SX, sizes: np.ndarray, angles: ca.SX
) -> tuple[ca.SX, ca.SX]:
    """The least change, relative to sizes, that takes away what is left of equations.

    Parameters
    ----------
    slopes : SX, shape (k, n)
        Derivatives of the equations.
    left : SX, shape (k, 1)
        What is left of them.
    sizes : ndarray, shape (n,)
        Nominal sizes of what changes.
    angles : SX
        Those symbols that are angles: at any values of these an equation has its usual size.

    Returns
    -------
    change : SX, shape (n, 1)
    independence : SX
        The least part of an equation at right angles to those eliminated before it, over its usual
        size, squared.
    """
    turned = ca.mtimes(ca.diag(ca.DM(sizes**2)), slopes.T)
    squares = ca.mtimes(slopes, turned)
    own = usual = ca.diag(squares)
    for turn in np.random.default_rng(5).uniform(-3.0, 3.0, (_TURNS, angles.numel())):
        usual = ca.fmax(usual, ca.substitute(own, angles, ca.DM(turn)))
    pivots, upper, order = ca.ldl(squares + ca.diag(_SINGULAR * usual))
    change = -ca.mtimes(turned, ca.ldl_solve(left, pivots, upper, order))
    return change, ca.mmin(ca.densify(pivots / usual[order]))
