"""Linear equations of blocks while their coefficients come together."""

from __future__ import annotations

from lumped.flattening.tape import Tape, TapeTerm
from lumped.reduction.elimination import Entry
from lumped.reduction.reduce import Block


class LinearEquations:
    """Linear equations of blocks: coefficients of the unknowns of each, and right sides."""

    def __init__(self, blocks: list[Block]) -> None:
        self.tape = Tape()
        self._column = {node: j for block in blocks for j, node in enumerate(block.nodes)}
        self.rows: list[dict[int, Entry]] = [{} for _ in self._column]
        self.right: list[tuple[TapeTerm, float]] = [(self.tape.zero, 0.0)] * len(self.rows)

    def add(self, row: int, node: int, term: TapeTerm, kind: int, value: float) -> None:
        """Add a coefficient if the node is an unknown."""
        column = self._column.get(node)
        if column is None:
            return
        old = self.rows[row].get(column)
        if old is not None:
            term, kind, value = old.term + term, max(old.kind, kind), old.value + value
        self.rows[row][column] = Entry(term, kind, value)
