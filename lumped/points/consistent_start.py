"""A consistent point in all coordinates that constraints tie, and states that lead there.

Given values are held. What is not given yields in this order, as little as possible: quantities
without start value, those that are no states first, then those with a declared one. Damped
Gauss-Newton steps of least change find the point (Björck, Numerical Methods for Least Squares
Problems, 1996, section 9.2); positions first, then speeds.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from lumped.compiler.constraints import Constraints
from lumped.compiler.system import System
from lumped.errors import StartError
from lumped.reduction.state_selection import RANK
from lumped.support.made_once import made_once
from lumped.support.text_table import list_lines
from lumped.timeloop.fit_states import wish_ranks

_MET = 1e-9
"""Largest miss, relative to the terms that cancel."""
_ROUNDING = 1e-13
_STEPS = 100
_TRIES = 12
"""Directions in which to begin where the first guess does not lead to a point."""


class ConsistentStart:
    """The search for a point at which constraints hold that hang together.

    Parameters
    ----------
    system : System
        From `assemble`.
    constraints : Constraints
        Of the system.
    theta : ndarray
        Parameters.
    time : float
        Instant, s.
    modes : ndarray
        Positions of conditions.
    guess : mapping of int to float
        Values of nodes with which it begins; zero for others.
    given : set of int
        Nodes that keep these values.
    """

    def __init__(
        self,
        system: System,
        constraints: Constraints,
        theta: np.ndarray,
        time: float,
        modes: np.ndarray,
        guess: Mapping[int, float],
        given: set[int],
    ) -> None:
        self.system, self._at = system, (theta, time, modes)
        self.constraints, self.nodes = constraints, constraints.nodes
        self._begin = np.array([guess.get(node, 0.0) for node in self.nodes])
        rank = _yielding(system)
        self.rank = np.array([-1 if n in given else rank[n] for n in self.nodes])

    def release(self, nodes: Collection[int]) -> bool:
        """Let nodes yield that keep their values; whether there are any.

        What follows from them begins where it misses them least.
        """
        released = (self.rank < 0) & np.isin(self.nodes, list(nodes))
        free = np.flatnonzero(self.rank >= 0)
        if not released.any():
            return False
        rows = np.flatnonzero(self.constraints.level == self.constraints.level.min())
        touched = self.constraints.touched(rows)
        free = np.intersect1d(free, touched)
        if len(free):
            self._begin = self._descend(self._begin, rows, free)[0]
        self.rank[released] = self.rank.max() + 1
        return True

    def find(self) -> dict[int, float]:
        """Values of all tied nodes.

        Raises
        ------
        StartError
            If there are none, with the equations that are missed.
        """
        z, frozen = self._begin.copy(), np.zeros(len(self.nodes), dtype=bool)
        level = self.constraints.level
        for now in np.unique(level).tolist():
            rows = np.flatnonzero(level == now)
            touched = np.isin(np.arange(len(self.nodes)), self.constraints.touched(rows))
            z = self._meet(z, rows, touched & ~frozen)
            frozen |= touched
        return dict(zip(self.nodes, z.tolist(), strict=True))

    def _evaluate(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.constraints(z, *self._at)

    def _miss(
        self, z: np.ndarray, rows: np.ndarray, part: float
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Residuals and derivatives, scaled by what cancels in them, and which are missed."""
        value, matrix = self._evaluate(z)
        value, matrix = value[rows], matrix[rows]
        terms = np.abs(matrix) @ np.abs(z)
        size = np.maximum(np.abs(matrix).max(axis=1, initial=0.0), 1e-300)
        missed = ~(np.abs(value) <= part * np.maximum(terms, size * 1e-3))
        return value / size, matrix / size[:, None], missed

    def _meet(self, z: np.ndarray, rows: np.ndarray, may: np.ndarray) -> np.ndarray:
        """The point with these constraints met by what may move."""
        if not self._miss(z, rows, _MET)[2].any():
            return z
        for most in range(int(self.rank.max(initial=0)) + 1):
            free = np.flatnonzero(may & (self.rank >= 0) & (self.rank <= most))
            if not len(free):
                continue
            found = self._from_places(z, rows, free)
            if found is not None:
                return self._nearest(z, self._turn_back(z, found, rows, free), rows, free)
        free = np.flatnonzero(may & (self.rank >= 0))
        raise StartError(self._contradiction(z, rows, free))

    def _from_places(self, z: np.ndarray, rows: np.ndarray, free: np.ndarray) -> np.ndarray | None:
        """A point found from the guess, or from places at growing distances from it."""
        found, met = self._descend(z, rows, free)
        rng = np.random.default_rng(3)
        for k in range(_TRIES):
            if met:
                return found
            moved = z.copy()
            moved[free] += (0.1, 0.3, 1.0)[k // 4] * rng.uniform(-1.0, 1.0, len(free))
            found, met = self._descend(moved, rows, free)
        return found if met else None

    def _descend(
        self, z: np.ndarray, rows: np.ndarray, free: np.ndarray
    ) -> tuple[np.ndarray, bool]:
        """Damped steps of least change; the last point, and whether constraints are met there."""
        value, matrix, missed = self._miss(z, rows, _ROUNDING)
        for _ in range(_STEPS):
            if not missed.any():
                break
            if not np.isfinite(matrix).all():
                return z, False
            step = -np.linalg.lstsq(matrix[:, free], value, rcond=1e-9)[0]
            share = min(1.0, 0.5 * (1.0 + np.abs(z).max()) / (np.abs(step).max() or 1.0))
            before = float(np.linalg.norm(value))
            while share > 1e-6:
                trial = z.copy()
                trial[free] += share * step
                tried = self._miss(trial, rows, _ROUNDING)
                if np.linalg.norm(tried[0]) <= (1.0 - 0.1 * share) * before:
                    break
                share /= 2.0
            else:
                break
            z, (value, matrix, missed) = trial, tried
        return z, not self._miss(z, rows, _MET)[2].any()

    def _turn_back(
        self, begin: np.ndarray, z: np.ndarray, rows: np.ndarray, free: np.ndarray
    ) -> np.ndarray:
        """The same with angles within half a turn of their guesses, where these turn freely."""
        for i in free.tolist():
            turns = np.round((z[i] - begin[i]) / (2 * np.pi))
            if turns:
                trial = z.copy()
                trial[i] -= 2 * np.pi * turns
                if not self._miss(trial, rows, _MET)[2].any():
                    z = self._descend(trial, rows, free)[0]
        return z

    def _nearest(
        self, begin: np.ndarray, z: np.ndarray, rows: np.ndarray, free: np.ndarray
    ) -> np.ndarray:
        """The point moved along the constraints towards the guess, while it comes nearer."""
        for _ in range(_STEPS):
            away = begin[free] - z[free]
            slopes = self._miss(z, rows, _MET)[1][:, free]
            along = away - np.linalg.lstsq(slopes, slopes @ away, rcond=1e-9)[0]
            if np.linalg.norm(along) <= 1e-9 * (1.0 + np.linalg.norm(away)):
                break
            for share in (1.0, 0.3, 0.1):
                moved = z.copy()
                moved[free] += share * along
                trial, met = self._descend(moved, rows, free)
                closer = np.linalg.norm(begin - trial) < (1.0 - 1e-9) * np.linalg.norm(begin - z)
                if met and closer:
                    z = trial
                    break
            else:
                break
        return z

    def _contradiction(self, z: np.ndarray, rows: np.ndarray, free: np.ndarray) -> str:
        """Which equations cannot hold, with what is given in them."""
        if len(free):
            z = self._descend(z, rows, free)[0]
        missed = rows[self._miss(z, rows, _MET)[2]].tolist()
        held = [
            f"{self.system.structure.node_name(self.nodes[i])} = {self._begin[i]:.6g}"
            for i in self.constraints.touched(np.array(missed))
            if self.rank[i] < 0
        ]
        given = ", ".join(held[:6]) + f" and {len(held) - 6} more" * (len(held) > 6)
        texts = list_lines([self.constraints.text(row) for row in missed], 6)
        if not held:
            return f"No position was found in which these equations hold:\n{texts}"
        return (
            f"Start values contradict each other: with {given} these equations cannot hold:\n"
            f"{texts}\nGive fewer start values, or make them fit."
        )


@made_once
def _yielding(system: System) -> dict[int, int]:
    """Order in which nodes yield: those from 2 have declared values, and those at -1 hold."""
    structure = system.structure
    reduced, tree = structure.reduced, structure.tree
    declared: set[int | None] = set()
    for part in tree.instances:
        for i in part.layout.unknowns.values():
            if getattr(part.layout.quantities[i], "is_declared", False):
                declared.add(reduced.node(part.first_unknown + i))
    states, ranks, found = set(reduced.states), wish_ranks(system), {}
    for node in reduced.tied:
        found[node] = (node in states) + 2 * (node in declared)
        if node in states & declared and ranks.get(node, 0) >= RANK["always"]:
            found[node] = -1
    return found
