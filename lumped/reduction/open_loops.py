"""Linkages before they are closed: their constraints as functions of implicit nodes and states."""

from __future__ import annotations

import casadi as ca

from lumped.reduction.evaluation import Values
from lumped.reduction.reduce import Block


class OpenLoops(Values):
    """Expressions in which the guesses of implicit nodes stand for the nodes themselves."""

    def list_constraints(self) -> tuple[list[int], list[ca.SX]]:
        """Equations of linkages, and what is left of those that are closed together."""
        times = self.reduced.differentiations
        self._rows: list[int] = []
        self._left: list[ca.SX] = []
        self.of(
            block.nodes[0]
            for b, block in enumerate(self.reduced.blocks)
            if b in self._loops and all(order < times[row] for row, order in block.equations)
        )
        return self._rows, self._left

    def _newton(self, block: Block) -> None:
        self._sx[block.nodes] = self.guesses[[self._place[node] for node in block.nodes]]
        linear = self._linearise([block])
        self._rows += [row for row, _ in block.equations]
        self._left.append(linear.tape.expressions([term for term, _ in linear.right]))
