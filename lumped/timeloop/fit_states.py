"""Which states lead at a point: those over which nothing that follows is much faster.

States whose share in the motion is too small change places with what they lead, until no ratio is
large: each exchange multiplies the volume of the dependent columns, so it ends (Goreinov,
Tyrtyshnikov, Zamarashkin, Linear Algebra Appl. 261 (1997) 1).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import scipy

from lumped.compiler.constraints import Constraints, constraints_of
from lumped.compiler.system import System
from lumped.reduction.diagnosis import list_each_once
from lumped.reduction.state_selection import RANK
from lumped.support.made_once import made_once
from lumped.timeloop.levers import FAIR_LEVERAGE, MOST_LEVERAGE

_SINGULAR = 1e-13
_SHARE = 1e-6
"""Part of a constraint in those that depend on each other, above rounding."""


class SingularPositionError(Exception):
    """No states lead, as these equations, by number, depend on each other at the point."""


def singular_text(system: System, error: SingularPositionError, where: str) -> str:
    """Words for a position in which no states lead."""
    incidence = system.structure.reduced.incidence
    found = [incidence.origin(row) for row in error.args[0]]
    owners = [incidence.flat.origin(n)[0] for kind, n in found if kind == "equation"]
    parts = list_each_once(owner.path or owner.label for owner in owners)
    return (
        f"{system.name}: at {where} linkages are in a singular position: constraints of {parts} "
        "depend on each other there, so that it is not determined how they move on. Choose a "
        "position beside it."
    )


class FitStates:
    """Constraints at a point, and states that lead there.

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
    """

    def __init__(self, system: System, theta: np.ndarray, time: float, modes: np.ndarray) -> None:
        self.system, self._at = system, (theta, time, modes)
        self._varying = [part for part in constraints_of(system) if part.varying and len(part.last)]

    def is_unfit(self, values: Mapping[int, float]) -> bool:
        """Whether a state has lost its share in the motion of what it leads.

        Parameters
        ----------
        values : mapping of int to float
            Of all tied nodes.
        """
        rng = np.random.default_rng(4)
        near = {n: v + rng.uniform(0.1, 0.3) for n, v in values.items()}
        for constraints in self._varying:
            _, here, follows, _ = self._slopes(constraints, values)
            if follows.sum() != len(here):  # positions and speeds are led by different motions
                continue
            usual = _ratios(self._slopes(constraints, near)[1], follows)
            usual = np.where(np.isfinite(usual), np.maximum(1.0, usual), 1.0)
            if not (_ratios(here, follows) <= MOST_LEVERAGE * usual).all():
                return True
        return False

    def find(self, values: Mapping[int, float]) -> list[tuple[int, int]]:
        """Motions that shall lead, each with the state whose place it takes.

        Raises
        ------
        SingularPositionError
            If no states lead, as constraints depend on each other there.
        """
        self.check(values)
        found = []
        for constraints in self._varying:
            tops, slopes, follows, bound = self._slopes(constraints, values)
            weights = np.where(follows, FAIR_LEVERAGE, np.where(bound, 1e-6, 1.0))
            now = np.isin(np.arange(len(tops)), _fair_columns(slopes, weights, bound))
            leading = np.flatnonzero(follows & ~now), np.flatnonzero(now & ~follows)
            found += [(tops[a], tops[b]) for a, b in zip(*leading, strict=True)]
        return found

    def check(self, values: Mapping[int, float]) -> float:
        """How independent constraints are: least over largest singular value of their derivatives.

        Raises
        ------
        SingularPositionError
            With the equations, if they depend on each other.
        """
        least = 1.0
        for constraints in self._varying:
            shares, sizes, _ = np.linalg.svd(self._slopes(constraints, values)[1])
            least = min(least, float(sizes[-1] / sizes[0]))
            if not sizes[-1] > _SINGULAR * sizes[0]:
                share = np.abs(shares[:, -1])
                rows = constraints.last[share > _SHARE * share.max()].tolist()
                raise SingularPositionError([constraints.rows[row][0] for row in rows])
        return least

    def _slopes(
        self, constraints: Constraints, values: Mapping[int, float]
    ) -> tuple[list[int], np.ndarray, np.ndarray, np.ndarray]:
        """Highest tied node of each motion, derivatives by them, which follow, which must lead."""
        reduced, nodes = self.system.structure.reduced, constraints.nodes
        place = {node: i for i, node in enumerate(nodes)}
        classes = sorted({reduced.class_and_order(node)[0] for node in nodes})
        tops = [int(reduced.first[c] + reduced.highest[c]) - 1 for c in classes]
        tops = [top for top in tops if top in place]
        z = np.array([values[node] for node in nodes])
        slopes = constraints(z, *self._at)[1][constraints.last]
        slopes = slopes[:, [place[top] for top in tops]]
        slopes /= np.maximum(np.abs(slopes).max(axis=1, keepdims=True), 1e-300)
        ranks = wish_ranks(self.system)
        bound = np.array([ranks.get(top, 0) >= RANK["always"] for top in tops])
        return tops, slopes, np.isin(tops, reduced.dependent), bound


def _ratios(slopes: np.ndarray, follows: np.ndarray) -> np.ndarray:
    """Ratios of what follows to what leads; infinite where nothing leads."""
    try:
        found: np.ndarray = np.abs(np.linalg.solve(slopes[:, follows], slopes[:, ~follows]))
    except np.linalg.LinAlgError:
        found = np.full((len(slopes), int((~follows).sum()) or 1), np.inf)
    return found


def _fair_columns(slopes: np.ndarray, weights: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """As many columns as rows, that lead to no large ratio of them to others."""
    count = len(slopes)
    order = scipy.linalg.qr(slopes * weights, mode="r", pivoting=True)[1]
    chosen: np.ndarray = order[:count].copy()
    others = order[count:].copy()
    for _ in range(10 * count):
        ratios = np.abs(np.linalg.solve(slopes[:, chosen], slopes[:, others]))
        ratios[:, bound[others]] = 0.0
        if not ratios.size or ratios.max() <= FAIR_LEVERAGE:
            break
        i, j = np.unravel_index(int(np.argmax(ratios)), ratios.shape)
        chosen[i], others[j] = others[j], chosen[i]
    return chosen


@made_once
def wish_ranks(system: System) -> dict[int, int]:
    """Wish of each node that has a name."""
    structure = system.structure
    return {n: RANK[structure.tree.quantity(u).wish] for n, u in structure.members.items()}
