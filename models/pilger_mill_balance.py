"""Balance of the pilger mill LG90: counterweight and sectors that shake and pulsate least.

The source minimises ``F1 / F10 + F2 / F20`` with ``F1 = max |F|``, the greatest force on the
foundation, and ``F2 = max M - min M`` over a revolution; F10 and F20 are their least values. At
constant speed force and torque are affine in the mass of the counterweight and in the mass moment
of the sectors, so three computed revolutions tell all designs, and F1 and F2 are convex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog

import lumped as lp
from lumped.errors import SolverError
from lumped.models.pilger_mill_stand import (
    DESIGNS,
    IDLE,
    SPEED,
    AsPrinted,
    Mill,
    crank_torque,
    mill,
    revolution,
    shaking_force,
    turned,
)

POINTS = 1440
STEPS = (1000.0, 500.0)  # kg, kg.m


@dataclass(frozen=True)
class Balance:
    """Force and torque over a revolution of all designs ``u = (m2, ms Rs)``.

    Attributes
    ----------
    force : ndarray, shape (3, n, 2)
        Force on the foundation for no counterweight and no sectors, and its increase with each,
        N, N/kg, N/(kg m).
    torque : ndarray, shape (3, n)
        Torque at the crank shaft likewise, with the source's idle friction.
    """

    force: np.ndarray
    torque: np.ndarray

    def forces(self, u: np.ndarray) -> np.ndarray:
        """Amount of the force on the foundation, N, shape (n,)."""
        x, y = np.tensordot([1.0, *u], self.force, 1).T
        return np.asarray(np.hypot(x, y))

    def fluctuation(self, u: np.ndarray) -> float:
        """F2, N.m."""
        return float(np.ptp(np.array([1.0, *u]) @ self.torque))

    def best(self, force: float, torque: float, limit: float = np.inf) -> np.ndarray:
        """Design that minimises ``force * F1 + torque * F2`` with F2 at most `limit`, N.m.

        A linear programme for the torque; the force enters by its tangents at the designs visited,
        which are added until its estimate is met.
        """
        n = self.torque.shape[1]
        scale = np.array([1e3, 1e3, 1e5, 1e5, 1e5])
        ones, none = np.ones((n, 1)), np.zeros((n, 1))
        slope = self.torque[1:].T
        rows = [np.hstack([slope, none, -ones, none]), np.hstack([-slope, none, none, ones])]
        limits = [-self.torque[0], self.torque[0]]
        if np.isfinite(limit):
            rows.append(np.array([[0.0, 0.0, 0.0, 1.0, -1.0]]))
            limits.append(np.array([limit]))
        u = np.array(list(DESIGNS["before"].values()))
        for _ in range(50):
            amount = self.forces(u)
            pull = np.tensordot([1.0, *u], self.force, 1)
            tangent = np.einsum("knx,nx->nk", self.force[1:], pull / amount[:, None])
            rows.append(np.hstack([tangent, -ones, none, none]))
            limits.append(tangent @ u - amount)
            found = linprog(
                np.array([0.0, 0.0, force, torque, -torque]) * scale,
                A_ub=np.vstack(rows) * scale / 1e5,
                b_ub=np.concatenate(limits) / 1e5,
                bounds=[(0, None)] * 3 + [(None, None)] * 2,
            )
            if found.x is None:
                raise SolverError(f"No best design of the balance: {found.message}")
            u, estimate = np.asarray(found.x[:2] * scale[:2]), found.x[2] * scale[2]
            if self.forces(u).max() <= (1 + 1e-6) * estimate:
                return u
        raise SolverError("No best design of the balance: its force is not met in 50 steps.")

    def single(self) -> tuple[np.ndarray, np.ndarray]:
        """Designs of least force and of least fluctuation.

        The fluctuation alone may leave the sectors open; a thousandth of the force settles them.
        """
        least = self.best(1e-5, 0.0)
        return least, self.best(1e-8, 1e-5)

    def goals(self) -> tuple[float, float]:
        """F10, N, and F20, N.m."""
        force, torque = self.single()
        return float(self.forces(force).max()), self.fluctuation(torque)

    def objective(self, u: np.ndarray) -> float:
        """``F1 / F10 + F2 / F20``."""
        force, torque = self.goals()
        return float(self.forces(u).max()) / force + self.fluctuation(u) / torque

    def optimum(self) -> np.ndarray:
        """Design of least objective."""
        force, torque = self.goals()
        return self.best(1 / force, 1 / torque)

    def front(self, count: int = 21) -> np.ndarray:
        """Pareto front, shape (count, 4): designs with F1 and F2, from least F1 to least F2.

        The least F1 for each bound on F2.
        """
        force, torque = self.single()
        ends = (self.fluctuation(force), self.fluctuation(torque))
        bounds = np.linspace(*ends, count)[1:-1]
        between = [self.best(1e-5, 0.0, limit) for limit in bounds]
        designs = [force, *between, torque]
        return np.array([(*u, self.forces(u).max(), self.fluctuation(u)) for u in designs])


def balance(
    name: str, kind: type[Mill] = AsPrinted, g: float = 0.0, points: int = POINTS
) -> Balance:
    """Force and torque of all designs of a set.

    Parameters
    ----------
    name : {"P", "F"}
        Set of parameters.
    kind : type
        `AsPrinted` for the source's torque, `Mill` for the exact one. The force is always exact.
    g : float
        Acceleration of free fall, m/s2.
    points : int
        Crank angles.
    """
    w = SPEED[name]
    degrees = np.arange(points + 1) * 360 / points
    corners = ((0.0, 0.0), (STEPS[0], 0.0), (0.0, STEPS[1]))
    torque_of, force_of = (turned(mill(name, kind=k, g=g), w * lp.time) for k in (kind, Mill))
    forces, torques = [], []
    for m2, U in corners:
        changed = {"mill.m2": m2, "mill.U": U}
        run = revolution(torque_of, w, degrees, changed)
        torques.append(crank_torque(run, IDLE)[:-1])
        run = revolution(force_of, w, degrees, changed)
        forces.append(shaking_force(run)[:-1])
    return Balance(*(_affine(np.array(found)) for found in (forces, torques)))


def _affine(found: np.ndarray) -> np.ndarray:
    base, *others = found
    return np.array([base, *((y - base) / step for y, step in zip(others, STEPS, strict=True))])
