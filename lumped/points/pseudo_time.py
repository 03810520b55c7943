"""States that a system settles to, followed in pseudo-time."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.timeloop.plants.executable import evaluate_at
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.settings import follow_settings

_MOST_STEPS = 500
_FIRST_MOVE = 0.1
"""What the first step may move a state, relative to its size."""
_FARTHEST = 1e12
"""A state so many times larger than it was runs away."""


class Settled(NamedTuple):
    """States and settings near those that a system approaches.

    Attributes
    ----------
    x, settings : ndarray
        States; modes and implicit quantities.
    changed : bool
        Whether positions of conditions or holds change there, on the way.
    """

    x: np.ndarray
    settings: np.ndarray
    changed: bool


def settle_states(
    point: OperatingPoint, movable: np.ndarray, change: scipy.sparse.csc_array
) -> Settled | None:
    """States near those that the system approaches, and settings there; None if it settles nowhere.

    Pseudo-transient continuation (Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998) 508): one
    linearised step of the implicit Euler method after the other. A step is taken if the equations
    are nearly met at its end; the next is then longer. Short steps follow the motion that the
    system would make, long ones are steps of Newton's method. States not movable are held; only
    what the matrix `change` makes of the derivatives counts. Where positions of conditions or holds
    change, the way ends.
    """
    system, begin, settings = point.system, point.x, point.settings
    nominal = np.array([_nominal(system, node) for node in system.structure.states])
    free = np.flatnonzero(movable)
    x = begin.copy()
    if not len(free):
        return None
    rates = change @ _rates(point, x, settings)
    size = np.abs(x) + nominal
    fastest = np.abs(rates[free] / size[free]).max()
    if not (np.isfinite(fastest) and fastest > 0):
        return None
    length = shortest = _FIRST_MOVE / fastest
    for _ in range(_MOST_STEPS):
        size = np.abs(x) + nominal
        jacobian = system.jacobian(x, point.theta, point.time, settings)[0]
        rows = scipy.sparse.csc_array(change @ scipy.sparse.csc_array(jacobian.sparse()))[free]
        matrix = rows[:, free]
        step = np.zeros(len(x))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", scipy.sparse.linalg.MatrixRankWarning)
            euler = scipy.sparse.csc_array(scipy.sparse.eye_array(len(free)) / length - matrix)
            step[free] = np.atleast_1d(scipy.sparse.linalg.spsolve(euler, rates[free]))
        closed = follow_settings(system, x + step, point.theta, point.time, settings)
        share = np.inf
        if closed is not None:
            found = change @ _rates(point, x + step, closed)
            miss = (step / length - found)[free] / size[free]
            share = float(np.linalg.norm(miss) / np.linalg.norm(rates[free] / size[free]))
        if closed is None or not share <= 0.5:  # not finite counts as too far
            length /= 4
            if length < 1e-12 * shortest:
                break
            continue
        x, rates, settings = x + step, found, closed
        if _changes(point, x, settings):
            return Settled(x, settings, changed=True)
        length *= 10 if share < 0.1 else 2
        if np.abs(step / size).max() <= 1e-8 or not rates[free].any():
            return Settled(x, settings, changed=False)
        if (np.abs(x) > _FARTHEST * (np.abs(begin) + nominal)).any():
            break
    return None


def _rates(point: OperatingPoint, x: np.ndarray, settings: np.ndarray) -> np.ndarray:
    return np.asarray(point.system.rhs(x, point.theta, point.time, settings)).ravel()


def _nominal(system: System, node: int) -> float:
    unknown = system.structure.members.get(node)
    return 1.0 if unknown is None else system.structure.tree.quantity(unknown).nominal


def _changes(point: OperatingPoint, x: np.ndarray, settings: np.ndarray) -> bool:
    """Whether conditions or holds do not have their positions any more."""
    if not point.system.switching:
        return False
    if not point.system.margins.size1_out(0):
        return False
    both = evaluate_at(point.system, "margin", x, point.theta, point.time, settings)
    left, tolerance = np.split(both, 2)
    return bool((left < -tolerance).any())
