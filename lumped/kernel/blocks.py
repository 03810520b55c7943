"""The two blocks of a system that the time loop works on, filled but for what a run brings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.compiler.switching import Switching
from lumped.kernel import layout as at

__all__ = ["MOST_DENSE", "Blocks", "Sizes", "laid_out"]

MOST_DENSE = 48
"""States up to which the implicit method is used, with dense matrices."""


class Blocks:
    """Places in two blocks, handed out one after the other.

    Attributes
    ----------
    integers : ndarray of int64
        Header and tables.
    count : int
        Numbers in the other block.
    """

    def __init__(self) -> None:
        self._header = np.zeros(at.INTEGERS, dtype=np.int64)
        self._tables: list[np.ndarray] = []
        self._used = at.INTEGERS
        self.count = at.NUMBERS

    @property
    def integers(self) -> np.ndarray:
        """Header and tables in one."""
        return np.concatenate([self._header, *self._tables]).astype(np.int64)

    def put(self, place: int, value: int) -> None:
        """One integer of the header."""
        self._header[place] = value

    def numbers(self, place: int, count: int) -> None:
        """Room for numbers."""
        self._header[place] = self.count
        self.count += max(int(count), 1)

    def table(self, place: int, values: np.ndarray | list[int]) -> None:
        """Integers that stay."""
        self._header[place] = self._used
        held = np.append(np.asarray(values, dtype=np.int64), 0)
        self._tables.append(held)
        self._used += len(held)

    def flags(self, place: int, count: int) -> None:
        """Room for integers."""
        self.table(place, np.zeros(count, dtype=np.int64))


@dataclass(frozen=True)
class Sizes:
    """Sizes of a system; `nonzeros` are those of the Jacobian."""

    states: int
    settings: int
    implicit: int
    parameters: int
    margins: int
    levers: int
    nonzeros: int


def laid_out(sizes: Sizes, s: Switching, states: list[int], uses: tuple[np.ndarray, ...]) -> Blocks:
    """Blocks for a system.

    Parameters
    ----------
    s : Switching
        What decides modes.
    states : list of int
        Nodes of the states.
    uses : tuple of ndarray
        Which states the speed of each hold depends on.
    """
    b = Blocks()
    n, nm, nk = sizes.states, sizes.settings, sizes.margins
    nr, nh, nj, nv = len(s.relation_modes), len(s.names), len(s.jumps), s.values.numel()
    for place, value in (
        (at.N, n),
        (at.NM, nm),
        (at.NG, sizes.implicit),
        (at.NK, nk),
        (at.NR, nr),
        (at.NH, nh),
        (at.NJ, nj),
        (at.NV, nv),
        (at.NU, len(uses[0])),
        (at.NL, sizes.levers),
        (at.NNZ, sizes.nonzeros),
    ):
        b.put(place, value)
    seen = 2 * nr + 7 * nh + nv + n
    for place, count in (
        *((vector, n) for vector in (at.X, at.NEW, at.ARGUMENT, at.INNER, at.ATOL, at.XS)),
        *((vector, nm) for vector in (at.M, at.BEFORE, at.MS, at.TRIAL)),
        *((vector, nh) for vector in (at.DEMAND, at.WISH, at.BOUNCE, at.LOSS, at.STILL)),
        *((vector, seen if s else 0) for vector in (at.LK, at.REST, at.PUSH, at.AFTER)),
        *((at.STAGES, 16 * n), (at.DENSE, 7 * n), (at.P, sizes.parameters)),
        *((at.SAMPLES, 5 * nk), (at.ENDS, 2 * nk), (at.MARGIN, 2 * nk)),
        *((at.RING, at.STORM_SIZE), (at.LEVER, sizes.levers), (at.CLOSED, 2 * sizes.implicit)),
        *((at.MATRIX, n * n if n <= MOST_DENSE else 0), (at.RATES, sizes.nonzeros + n)),
        (at.STACK, 64),
    ):
        b.numbers(place, count)
    place_of = {node: i for i, node in enumerate(states)}
    b.table(at.RELATION_MODE, s.relation_modes)
    b.table(at.STRICT, s.strict)
    tables = [c.pieces for c in s.conditions]
    rows = [0 if p is None else p.count * p.width for p in tables]
    b.table(at.PIECE_COUNT, [0 if p is None else p.count for p in tables])
    b.table(at.PIECE_WIDTH, [1 if p is None else p.width for p in tables])
    b.table(at.PIECE_FIRST, np.cumsum([0, *rows])[:-1])
    b.numbers(at.TABLE, sum(rows))
    b.table(at.FIRST, s.first_modes)
    b.table(at.ENGAGED, s.engaged)
    b.table(at.UPPER, s.has_upper)
    b.table(at.LOWER, s.has_lower)
    b.table(at.FORWARD, s.has_forward)
    b.table(at.BACKWARD, s.has_backward)
    b.table(at.GAP, s.has_gap)
    b.table(at.PLACE, [place_of.get(node, -1) for node in s.speeds])
    b.table(at.IMPULSIVE, ~(s.has_upper & s.has_lower))
    for place in (at.EXEMPT, at.JUMPED):
        b.flags(place, nr)
    for place in (at.WAS_STUCK, at.HALTED, at.CLOSING, at.MEMBER, at.STRUCK):
        b.flags(place, nh)
    b.flags(at.WRONG, max(nr, nh))
    b.flags(at.BACK, nh)
    _jumps(b, s, place_of)
    b.table(at.USE_HOLD, uses[0])
    b.table(at.USE_STATE, uses[1])
    margins = s.rows if nk else []
    b.table(at.KIND, [("relation", "upper", "lower", "slide").index(kind) for kind, _ in margins])
    b.table(at.NUMBER, [number for _, number in margins])
    b.flags(at.FIRED_ROWS, nk)
    b.flags(at.SUSPECT, nk)
    b.flags(at.PIVOT, n)
    return b


def _jumps(b: Blocks, s: Switching, place_of: dict[int, int]) -> None:
    relations = s.relation_modes.tolist()
    starts, targets = [0], list[int]()
    for jump in s.jumps:
        targets += [place_of.get(node, -1) for node in jump.nodes]
        starts.append(len(targets))
    b.table(at.JUMP_MODE, [jump.mode for jump in s.jumps])
    b.table(at.JUMP_FIRST, [jump.first for jump in s.jumps])
    b.table(at.JUMP_START, starts)
    b.table(at.JUMP_PLACE, targets)
    b.table(
        at.JUMP_RELATION,
        [relations.index(jump.mode) if jump.mode in relations else -1 for jump in s.jumps],
    )
    b.flags(at.WAS_TRUE, len(s.jumps))
    b.numbers(at.SIGNS, len(targets))
