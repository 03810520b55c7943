"""A consistent point in all coordinates that constraints tie, and states that lead there.

Given values are held. What is not given yields in this order, as little as possible: quantities
without start value, those that are no states first, then those with a declared one. Damped
Gauss-Newton steps of least change find the point (Björck, Numerical Methods for Least Squares
Problems, 1996, section 9.2); positions first, then speeds. States whose share in the motion is too
small there change places with what they lead, until no ratio is large: each exchange multiplies
the volume of the dependent columns, so it ends (Goreinov, Tyrtyshnikov, Zamarashkin, Linear Algebra
Appl. 261 (1997) 1).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import StartError
from lumped.kernel.run import MOST_LEVERAGE
from lumped.points.constraints import constraints_of
from lumped.reduction.state_selection import RANK
from lumped.support.made_once import made_once
from lumped.support.text_table import list_lines

_MET = 1e-9
"""Largest miss, relative to the terms that cancel."""
_ROUNDING = 1e-13
_STEPS = 100
_TRIES = 12
"""Directions in which to begin where the first guess does not lead to a point."""
_FAIR = 5.0
"""Largest ratio of a dependent motion to a state after an exchange."""
_SINGULAR = 1e-10


class ConsistentStart:
    """The search for a point at which all constraints hold.

    Parameters
    ----------
    system : System
        From `assemble`.
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
        theta: np.ndarray,
        time: float,
        modes: np.ndarray,
        guess: Mapping[int, float],
        given: set[int],
    ) -> None:
        self.system, self._at = system, (theta, time, modes)
        self.constraints = constraints_of(system)
        self.nodes = self.constraints.nodes
        self.begin = np.array([guess.get(node, 0.0) for node in self.nodes])
        rank = _yielding(system)
        self.rank = np.array([-1 if n in given else rank[n] for n in self.nodes])

    def find(self) -> dict[int, float]:
        """Values of all tied nodes.

        Raises
        ------
        StartError
            If there are none, with the equations that are missed.
        """
        z, frozen = self.begin.copy(), np.zeros(len(self.nodes), dtype=bool)
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
            f"{self.system.structure.node_name(self.nodes[i])} = {self.begin[i]:.6g}"
            for i in self.constraints.touched(np.array(missed))
            if self.rank[i] < 0
        ]
        given = ", ".join(held[:6]) + f" and {len(held) - 6} more" * (len(held) > 6)
        texts = list_lines([self.constraints.text(row) for row in missed], 6)
        return (
            f"Start values contradict each other: with {given or 'the dimensions of the model'} "
            f"these equations cannot hold:\n{texts}\nGive fewer start values, or make them fit."
        )

    def is_unfit(self, values: Mapping[int, float]) -> bool:
        """Whether a state has lost its share in the motion of what it leads."""
        if not self.constraints.varying:
            return False
        _, here, follows, _ = self._slopes(values)
        if follows.sum() != len(here):  # positions and speeds are led by different motions
            return False
        rng = np.random.default_rng(4)
        near = {n: v + rng.uniform(0.1, 0.3) for n, v in values.items()}
        usual = _ratios(self._slopes(near)[1], follows)
        usual = np.where(np.isfinite(usual), np.maximum(1.0, usual), 1.0)
        unfit = ~(_ratios(here, follows) <= MOST_LEVERAGE * usual)
        return bool(unfit.any())

    def _slopes(
        self, values: Mapping[int, float]
    ) -> tuple[list[int], np.ndarray, np.ndarray, np.ndarray]:
        """Highest tied node of each motion, derivatives by them, which follow, which must lead."""
        reduced = self.system.structure.reduced
        own = zip(self.nodes, self.begin.tolist(), strict=True)
        z = np.array([values.get(node, begin) for node, begin in own])
        place = {node: i for i, node in enumerate(self.nodes)}
        classes = sorted({reduced.class_and_order(node)[0] for node in self.nodes})
        tops = [int(reduced.first[c] + reduced.highest[c]) - 1 for c in classes]
        tops = [top for top in tops if top in place]
        slopes = self._evaluate(z)[1][self.constraints.last][:, [place[top] for top in tops]]
        slopes /= np.maximum(np.abs(slopes).max(axis=1, keepdims=True), 1e-300)
        ranks = _wish_ranks(self.system)
        bound = np.array([ranks.get(top, 0) >= RANK["always"] for top in tops])
        return tops, slopes, np.isin(tops, reduced.dependent), bound

    def lead(self, values: Mapping[int, float]) -> list[tuple[int, int]]:
        """Motions that shall lead, each with the state whose place it takes.

        Raises
        ------
        StartError
            If no states lead, as the constraints depend on each other there.
        """
        tops, slopes, follows, bound = self._slopes(values)
        weights = np.where(follows, _FAIR, np.where(bound, 1e-6, 1.0))
        found = _fair_columns(slopes, weights, bound)
        if found is None:
            raise StartError(
                f"{self.system.name}: at the start its linkages are in a singular position, in "
                "which constraints depend on each other and motions are not determined. Start "
                "beside it."
            )
        now = np.isin(np.arange(len(tops)), found)
        leading = np.flatnonzero(follows & ~now), np.flatnonzero(now & ~follows)
        return [(tops[a], tops[b]) for a, b in zip(*leading, strict=True)]


def _ratios(slopes: np.ndarray, follows: np.ndarray) -> np.ndarray:
    """Ratios of what follows to what leads; infinite where nothing leads."""
    try:
        found: np.ndarray = np.abs(np.linalg.solve(slopes[:, follows], slopes[:, ~follows]))
    except np.linalg.LinAlgError:
        found = np.full((len(slopes), int((~follows).sum()) or 1), np.inf)
    return found


def _fair_columns(slopes: np.ndarray, weights: np.ndarray, bound: np.ndarray) -> np.ndarray | None:
    """As many columns as rows, that lead to no large ratio of them to others; None if singular."""
    count = len(slopes)
    _, upper, order = scipy.linalg.qr(slopes * weights, mode="economic", pivoting=True)
    sizes = np.abs(np.diag(upper))
    if not np.isfinite(sizes).all() or not sizes.min() > _SINGULAR * 1e-6 * sizes.max():
        return None
    chosen: np.ndarray = order[:count].copy()
    others = order[count:].copy()
    if not np.linalg.cond(slopes[:, chosen]) < 1.0 / _SINGULAR:
        return None
    for _ in range(10 * count):
        ratios = np.abs(np.linalg.solve(slopes[:, chosen], slopes[:, others]))
        ratios[:, bound[others]] = 0.0
        if not ratios.size or ratios.max() <= _FAIR:
            break
        i, j = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
        chosen[i], others[j] = others[j], chosen[i]
    return chosen


@made_once
def _wish_ranks(system: System) -> dict[int, int]:
    """Wish of each node that has a name."""
    structure = system.structure
    return {n: RANK[structure.tree.quantity(u).wish] for n, u in structure.members.items()}


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
    states, ranks, found = set(reduced.states), _wish_ranks(system), {}
    for node in reduced.tied:
        found[node] = (node in states) + 2 * (node in declared)
        if node in states & declared and ranks.get(node, 0) >= RANK["always"]:
            found[node] = -1
    return found
