"""A run as equations: Radau collocation of the states on intervals of equal length."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.polynomial import Polynomial

from lumped.compiler.system import System
from lumped.numerics.nlp import Programme

DEGREE = 3
"""Collocation points in each interval."""


@dataclass(frozen=True, eq=False)
class Phase:
    """Nodes of one smooth part of a run.

    Attributes
    ----------
    t : SX, shape (n, 1)
        Instants of the nodes, s; the first is the begin, the last the end.
    x : SX, shape (states, n)
        States there.
    theta : SX, shape (parameters, n)
        Parameters there.
    weights : SX, shape (n, 1)
        Weights of an integral over time, s.
    """

    t: ca.SX
    x: ca.SX
    theta: ca.SX
    weights: ca.SX


def lagrange(points: np.ndarray, j: int) -> Polynomial:
    """The polynomial that is one at a point and zero at the others."""
    others = np.delete(points, j)
    found: Polynomial = Polynomial.fromroots(others) / np.prod(points[j] - others)
    return found


def _rule() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points of an interval with its begin, slopes of the interpolation there, weights."""
    points = np.concatenate([[0.0], ca.collocation_points(DEGREE, "radau")])
    slopes = np.zeros((DEGREE + 1, DEGREE))
    for j in range(DEGREE + 1):
        slopes[j] = lagrange(points, j).deriv()(points[1:])
    weights = np.array([lagrange(points[1:], j).integ()(1.0) for j in range(DEGREE)])
    return points, slopes, weights


POINTS, SLOPES, WEIGHTS = _rule()


def fractions(intervals: int) -> np.ndarray:
    """Nodes of a phase from 0 to 1, shape (1 + DEGREE * intervals,)."""
    inside = (np.arange(intervals)[:, None] + POINTS[None, 1:]) / intervals
    return np.concatenate([[0.0], inside.ravel()])


def phase(
    programme: Programme,
    system: System,
    x: ca.SX,
    theta: ca.SX,
    settings: np.ndarray,
    span: tuple[ca.SX, ca.SX],
    sizes: np.ndarray,
) -> Phase:
    """Demand that states at nodes follow their equations.

    Parameters
    ----------
    x : SX, shape (states, n)
        States at the nodes of `fractions`.
    theta : SX, shape (parameters, n)
        Parameters at the nodes.
    settings : ndarray, shape (n, m)
        Modes and guesses.
    span : tuple of SX
        Begin and duration, s.
    sizes : ndarray, shape (states,)
        Sizes of the states.

    Notes
    -----
    Order 5 with three Radau points (Hairer and Wanner, Solving Ordinary Differential Equations II,
    IV.5; Biegler, Nonlinear Programming, 2010, ch. 10).
    """
    nodes = settings.shape[0]
    intervals = (nodes - 1) // DEGREE
    begin, duration = span
    at = ca.SX(ca.DM(fractions(intervals)))
    t = begin + at * duration
    rates = system.rhs.map(nodes - 1)(x[:, 1:], theta[:, 1:], t[1:].T, ca.DM(settings[1:].T))
    # one block of columns per collocation point, so that all intervals are done at once
    parts = [x[:, j : nodes - DEGREE + j : DEGREE] for j in range(DEGREE + 1)]
    h = duration / intervals
    for i in range(DEGREE):
        left = sum(float(SLOPES[j, i]) * parts[j] for j in range(DEGREE + 1))
        defect = (left - h * rates[:, i::DEGREE]) / ca.DM(sizes)
        programme.constrain("equations of motion", defect, 0.0, 0.0)
    weights = ca.vertcat(0.0, ca.repmat(ca.DM(WEIGHTS), intervals, 1) * h)
    return Phase(t, x, theta, weights)
