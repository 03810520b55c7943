"""Balance of the pilger mill LG90: counterweight and sectors of least force and torque swing.

The source minimises ``F1 / F10 + F2 / F20`` with ``F1 = max |F|``, the greatest force on the
foundation, and ``F2 = max M - min M`` over a revolution; F10 and F20 are their least values. At
constant speed force and torque are affine in the mass of the counterweight and in the mass moment
of the sectors, so three computed revolutions give all designs, and F1 and F2 are convex.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.optimize import linprog, minimize_scalar

import lumped as lp
from lumped.errors import SolverError
from lumped.models.pilger_mill import stand

POINTS = 1440
STEPS = (1000.0, 500.0)  # kg, kg.m


@dataclass(frozen=True, eq=False)
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

        Linear programmes with Kelley's cutting planes: tangents of the force and values of the
        torque, both at the angles near an extreme of a visited design.
        """
        scale = np.array([1e3, 1e3, 1e5, 1e5, 1e5])  # m2, U, F1, greatest and least torque
        rows, limits = [np.zeros((0, 5))], [np.zeros(0)]
        if np.isfinite(limit):
            rows.append(np.array([[0.0, 0.0, 0.0, 1.0, -1.0]]))
            limits.append(np.array([limit]))
        counts = torque > 0 or np.isfinite(limit)
        none = np.zeros(2)
        allowed = 1e-7 * self.forces(none).max(), 1e-8 * self.fluctuation(none)
        u = np.array(list(stand.DESIGNS["before"].values()))
        for _ in range(100):
            for row, bound in self._cuts(u, counts):
                rows.append(row)
                limits.append(bound)
            found = linprog(
                np.array([0.0, 0.0, force, torque, -torque]) * scale,
                A_ub=np.vstack(rows) * scale / 1e5,
                b_ub=np.concatenate(limits) / 1e5,
                bounds=[(0, 100)] * 2 + [(0, None)] + [(None, None)] * 2,
            )
            if found.x is None:
                raise SolverError(f"No best design of the balance: {found.message}")
            *_, least_force, high, low = found.x * scale
            u = np.asarray(found.x[:2] * scale[:2])
            met = self.forces(u).max() - least_force <= allowed[0]
            if met and (not counts or self.fluctuation(u) - (high - low) <= allowed[1]):
                return u
        raise SolverError("No best design of the balance: its force is not met in 100 steps.")

    def _cuts(self, u: np.ndarray, torque: bool) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Rows of inequalities at a design, and their right-hand sides."""
        pull = np.tensordot([1.0, *u], self.force, 1)
        amount = np.hypot(*pull.T)
        near = amount > 0.95 * amount.max()
        tangent = np.einsum("knx,nx->nk", self.force[1:, near], (pull / amount[:, None])[near])
        below = np.tile([-1.0, 0.0, 0.0], (len(tangent), 1))
        yield np.hstack([tangent, below]), tangent @ u - amount[near]
        if torque:
            values = np.array([1.0, *u]) @ self.torque
            for sign, column in ((1.0, 1), (-1.0, 2)):
                top = sign * values > (sign * values).max() - 0.05 * np.ptp(values)
                slope = sign * self.torque[1:, top].T
                below = np.zeros((len(slope), 3))
                below[:, column] = -sign
                yield np.hstack([slope, below]), -sign * self.torque[0, top]

    @cached_property
    def single(self) -> tuple[np.ndarray, np.ndarray]:
        """Designs of least force and of least fluctuation.

        The fluctuation alone may not determine the sectors; a thousandth of the force is added.
        """
        return self.best(1e-5, 0.0), self.best(1e-8, 1e-5)

    def goals(self) -> tuple[float, float]:
        """F10, N, and F20, N.m."""
        force, torque = self.single
        return float(self.forces(force).max()), self.fluctuation(torque)

    def best_sectors(self, m2: float) -> float:
        """Mass moment of the sectors of least F1 for a given counterweight, kg.m."""
        found = minimize_scalar(
            lambda U: float(self.forces(np.array([m2, U])).max()),
            bounds=(0.0, 1e4),
            method="bounded",
            options={"xatol": 1e-6},
        )
        return float(found.x)

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
        force, torque = self.single
        ends = (self.fluctuation(force), self.fluctuation(torque))
        bounds = np.linspace(*ends, count)[1:-1]
        between = [self.best(1e-5, 0.0, limit) for limit in bounds]
        designs = [force, *between, torque]
        return np.array([(*u, self.forces(u).max(), self.fluctuation(u)) for u in designs])


def balance(
    name: str, kind: type[stand.Mill] = stand.AsPrinted, g: float = 0.0, points: int = POINTS
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
    w = stand.SPEED[name]
    degrees = np.arange(points + 1) * 360 / points
    corners = ((0.0, 0.0), (STEPS[0], 0.0), (0.0, STEPS[1]))
    torque_of, force_of = (
        stand.turn_mill(stand.mill(name, kind=k, g=g), w * lp.time) for k in (kind, stand.Mill)
    )
    forces, torques = [], []
    for m2, U in corners:
        changed = {"mill.m2": m2, "mill.U": U}
        run = stand.revolution(torque_of, w, degrees, changed)
        torques.append(stand.crank_torque(run, stand.IDLE)[:-1])
        run = stand.revolution(force_of, w, degrees, changed)
        forces.append(stand.shaking_force(run)[:-1])
    return Balance(*(_affine(np.array(found)) for found in (forces, torques)))


def _affine(found: np.ndarray) -> np.ndarray:
    base, *others = found
    return np.array([base, *((y - base) / step for y, step in zip(others, STEPS, strict=True))])
