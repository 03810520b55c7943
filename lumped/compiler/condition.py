"""Relations of instances, and which of them depend on the time alone.

The one place that decides what becomes of a kink. A condition that depends on the time and on
parameters only changes at instants that are known before the run; any other has a margin that a run
watches.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import or_

import casadi as ca
import numpy as np

from lumped.flattening.lowered_switches import Relation
from lumped.language.lowering import is_even
from lumped.language.pieces import Pieces
from lumped.reduction.evaluation import Values
from lumped.support.follow_operations import follow_operations


@dataclass(frozen=True, eq=False)
class Condition:
    """A relation of an instance.

    Attributes
    ----------
    name : str
        Its component.
    mode : int
        Its mode, or the first of the settings of its piece.
    greater, less : SX
        Its sides, as expressions of states, parameters, time and modes.
    relation : Relation
        What it is an instance of.
    active : SX, optional
        1 while it matters, as it occurs in a branch that another condition chooses.
    """

    name: str
    mode: int
    greater: ca.SX
    less: ca.SX
    relation: Relation
    active: ca.SX | None

    @property
    def pieces(self) -> Pieces | None:
        """Those of a piecewise polynomial."""
        return self.relation.pieces

    @property
    def argument(self) -> ca.SX:
        """What passes zero, or the borders of the pieces."""
        return self.greater if self.pieces is not None else self.greater - self.less

    @property
    def modes(self) -> range:
        """All its modes."""
        return range(self.mode, self.mode + (1 if self.pieces is None else self.pieces.width))

    def texts(self, numbers: np.ndarray) -> list[str]:
        """What modes, 1 or 0, or numbers of pieces say in words."""
        left, right = self.relation.sides
        if self.pieces is None:
            yes, no = (">", "<=") if self.relation.strict else (">=", "<")
            words = self.relation.words or (f"{left} {yes} {right}", f"{left} {no} {right}")
            return [words[0 if holds else 1] for holds in (numbers > 0.5).tolist()]
        last = np.inf if self.pieces.period is not None else self.pieces.count - 1
        begins, ends = self.pieces.begin(numbers), self.pieces.begin(numbers + 1)
        found = []
        for number, begin, end in zip(numbers, begins, ends, strict=True):
            parts = [f"{left} >= {begin:.6g}"] if number > 0 or np.isinf(last) else []
            parts += [f"{left} < {end:.6g}"] if number < last else []
            found.append(" and ".join(parts))
        return found


def sort_conditions(
    found: list[Condition], values: Values, *, foresee: bool
) -> tuple[list[Condition], list[list[int]], list[Condition]]:
    """Those that depend on the time alone, the numbers of those that each needs, and the others.

    Each comes after those that it needs.
    """
    if not found:
        return [], [], []
    owner = {mode: k for k, condition in enumerate(found) for mode in condition.modes}
    inputs = [
        *(values.states, values.guesses, values.modes),
        *(values.flat.parameters.theta, values.time),
    ]
    needs = _needs(ca.Function("sides", inputs, [c.argument for c in found]), owner)
    if not foresee:
        for k, condition in enumerate(found):
            if needs[k] is not None and not is_even(condition.argument, values.time):
                needs[k] = None
    timed: dict[int, int] = {}
    count = -1
    while count < len(timed):
        count = len(timed)
        for k, need in enumerate(needs):
            if k not in timed and need is not None and need <= timed.keys():
                timed[k] = len(timed)
    order = [sorted(timed[i] for i in needs[k] or ()) for k in timed]
    return [found[k] for k in timed], order, [c for k, c in enumerate(found) if k not in timed]


def _needs(sides: ca.Function, owner: dict[int, int]) -> list[set[int] | None]:
    """Conditions that each condition depends on; None if it depends on states or holds too.

    A function of steps has no derivative, so dependence is followed through the operations.
    """
    states = 1

    def find_bits(which: int, entry: int) -> int:
        if which == 2:
            return 2 << owner[entry] if entry in owner else states
        return states if which < 2 else 0

    found = follow_operations(sides, find_bits, lambda _: 0, lambda _, read: reduce(or_, read))
    return [
        None if bits & states else {k - 1 for k in range(1, bits.bit_length()) if bits >> k & 1}
        for bits in (reduce(or_, entries, 0) for entries in found)
    ]
