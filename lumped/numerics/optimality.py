"""Whether a point is a least of an objective between rows that must not be negative."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

Objective = Callable[[np.ndarray], tuple[float, np.ndarray]]
"""Value and gradient for scaled unknowns."""

Rows = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, list[str]]]
"""Numbers that must not be negative, scaled; their gradients; names with values."""

_ACTIVE = 1e-6
_MOVE = 1e-5
"""How far the unknowns move for the curvature, in their scale."""
_PRESSES = 1e-6
"""Share of the slope above which a multiplier holds its constraint."""
_FLAT = 1e-9
"""Curvature, relative to slope and largest curvature, that differences cannot tell from none."""
_FALLS = 1e-4
"""Curvature downward, relative to the same, at which a search goes on from a saddle."""
_NEAR = 1e-6
"""Distance of the optimum, in the scale of the unknowns, that counts as none."""


@dataclass(frozen=True, eq=False)
class Optimality:
    """Karush-Kuhn-Tucker conditions of first and second order at a point.

    Attributes
    ----------
    w, value : ndarray and float
        The point, and its objective.
    near : ndarray of int
        Rows that are active.
    low, high : ndarray of bool
        Unknowns at bounds.
    residual, condition : float
        Greatest slope of the Lagrangian, relative to the slope of the objective and to how it
        changes within the scale of the unknowns; condition of the active gradients.
    step : ndarray
        From here to the least of the Lagrangian's quadratic model, along what is active.
    decrease : float
        By which the objective falls there.
    basis : ndarray
        Unknowns in which the curvature of the Lagrangian is one.
    fall : ndarray or None
        A direction along which the Lagrangian curves downward.
    bend : float
        Its curvature there.
    met : bool
        Whether the step or the decrease counts as none.
    is_settled : bool
        Whether a search that begins here has nothing to find: not a tenth of a percent of such a
        decrease, nor a way downward.
    """

    w: np.ndarray
    value: float
    near: np.ndarray
    low: np.ndarray
    high: np.ndarray
    residual: float
    condition: float
    step: np.ndarray
    decrease: float
    basis: np.ndarray
    fall: np.ndarray | None
    bend: float
    met: bool
    is_settled: bool

    def begin_again(self, aside: float, stride: float) -> tuple[np.ndarray, np.ndarray, float]:
        """Start, basis and size of the objective for a search that begins here."""
        first, size = self.w, self.decrease
        if self.fall is not None:
            first, size = self.w + aside * self.fall, max(size, 0.5 * aside**2 * -self.bend)
        longest = float(np.abs(self.step).max(initial=0.0))
        return first, self.basis * np.sqrt(size * min(1.0, stride / (longest or stride))), size

    def tell_rest(self, names: list[str]) -> str:
        """What is left, in words."""
        own = self.step[: len(names)]
        most = int(np.abs(own).argmax())
        return (
            "SLSQP: no better design found, though the conditions of optimality are not met: by "
            f"the slopes left {names[most]} lies {abs(own[most]):.1e} of its scale from an optimum "
            f"whose objective is {self.decrease:.1e} less. A kink, or the accuracy of the "
            "analyses, may hold the search; begin elsewhere, or tighten rtol"
        )


def judge(
    w: np.ndarray, box: np.ndarray, objective: Objective, rows: Rows, tolerance: float
) -> Optimality:
    """Judge a point by its own slopes and curvatures, whatever the search before.

    The multipliers of what is active are those of least squares, none negative; the curvature of
    the Lagrangian along what holds the point is found by differences of gradients.

    Parameters
    ----------
    w : ndarray
        The point, in scaled unknowns.
    box : ndarray, shape (k, 3)
        Start, lower and upper bounds.
    tolerance : float
        Relative accuracy of the objective.

    Notes
    -----
    Nocedal and Wright, Numerical Optimization, 2006, theorems 12.1, 12.5 and 12.6.
    """
    value, slope = objective(w)
    values, slopes, _ = rows(w)
    low, high = (np.abs(w - box[:, i]) <= _ACTIVE for i in (1, 2))
    near, unit = np.flatnonzero(values <= _ACTIVE), np.eye(len(w))
    active = np.vstack([slopes[near], unit[low], -unit[high]])
    left, condition, Z = slope, 1.0, unit
    multipliers = np.zeros(len(values))
    if len(active):
        size = float(np.abs(slope).max()) or 1.0
        held = scipy.optimize.lsq_linear(active.T, slope / size, (0.0, np.inf)).x * size
        left = slope - active.T @ held
        condition = float(np.linalg.cond(active))
        multipliers[near] = held[: len(near)]
        Z = scipy.linalg.null_space(active[held * np.abs(active).max(axis=1) > _PRESSES * size])

    def lagrangian(at: np.ndarray) -> np.ndarray:
        found: np.ndarray = objective(at)[1] - (multipliers @ rows(at)[1] if len(near) else 0.0)
        return found

    here, curved = lagrangian(w), np.zeros((Z.shape[1], Z.shape[1]))
    for k, direction in enumerate(Z.T):
        moved = [np.clip(w + s * _MOVE * direction, box[:, 1], box[:, 2]) for s in (1.0, -1.0)]
        at = max(moved, key=lambda at: float(np.abs(at - w).max()))
        way = float((at - w) @ direction)
        curved[k] = (lagrangian(at) - here) @ Z / way if way else 0.0
    bent, own = np.linalg.eigh((curved + curved.T) / 2)
    size = max(float(np.abs(slope).max()), float(np.abs(bent).max(initial=0.0)))
    along = own.T @ (Z.T @ left)
    least = np.maximum(np.abs(bent), _FLAT * size or 1.0)
    step, decrease = -Z @ (own @ (along / least)), float((along**2 / least).sum()) / 2
    falls = len(bent) > 0 and bent[0] < -_FALLS * size
    near_by, small = float(np.abs(step).max(initial=0.0)) <= _NEAR, tolerance * abs(value)
    inner = (own / np.sqrt(least)) @ own.T
    return Optimality(
        w,
        value,
        near,
        low,
        high,
        float(np.abs(left).max()) / (size or 1.0),
        condition,
        step,
        decrease,
        Z @ inner @ Z.T + (unit - Z @ Z.T) / np.sqrt(size or 1.0),
        Z @ own[:, 0] * (-1.0 if along[0] > 0 else 1.0) if falls else None,
        float(bent[0]) if falls else 0.0,
        near_by or decrease <= small,
        (near_by or decrease <= 1e-3 * small) and not falls,
    )
