"""Start values and initial equations that an equilibrium keeps if it can."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import Changes, System
from lumped.points.target_values import initial_residuals
from lumped.reduction.pruning import uses
from lumped.timeloop.results.operating_point import OperatingPoint

_SAME = 1e-9
"""Relative difference below which a value counts as kept."""


class Demands:
    """Given start values and initial equations, which an equilibrium keeps if it can.

    Parameters
    ----------
    begin : OperatingPoint
        Where they hold.
    start : mapping of name to float
        Start values that were set; those come before all others.
    rest : bool
        Speeds do not count.

    Attributes
    ----------
    asked, declared : list of int
        Nodes of start values that were set, and of those given to instances.
    """

    def __init__(self, begin: OperatingPoint, start: Changes, rest: bool) -> None:
        self.begin, system = begin, begin.system
        self.start = {system.key(name): value for name, value in start.items()}
        values = system.structure.values
        implicit, seen = {*values.implicit}, set[int]()
        groups = []
        for unknowns in (
            [system.structure.tree.unknown(n) for n in start],
            system.structure.flat.given,
        ):
            found = {system.structure.reduced.node(u): u for u in unknowns}
            mine = {n: u for n, u in found.items() if n is not None and n not in implicit | seen}
            seen |= set(mine)
            if rest:
                mine = {n: u for n, u in mine.items() if not order_of(system, n)}
            groups.append(
                {n: u for n, u in mine.items() if computable_rows(system, values.of([n]))[0]}
            )
        self.asked, self.declared = (list(group) for group in groups)
        self._unknowns = groups[0] | groups[1]
        equations, self._places = initial_residuals(system)
        kept = computable_rows(system, equations)
        self._equations = np.flatnonzero(kept).tolist()
        self.equations: ca.SX = equations[self._equations] if kept.any() else ca.SX(0, 1)

    def values(self, nodes: list[int], point: OperatingPoint) -> np.ndarray:
        """Values of nodes at a point."""
        return evaluate_expression(point, self.begin.system.structure.values.of(nodes))

    def find_kept(self, point: OperatingPoint) -> tuple[list[int], list[int]]:
        """Nodes that have their values at a point still, and initial equations that hold."""
        nodes = self.asked + self.declared
        wanted, now = (self.values(nodes, p) for p in (self.begin, point))
        same = np.abs(now - wanted) <= _SAME * (1.0 + np.abs(wanted))
        held = np.abs(evaluate_expression(point, self.equations)) <= _SAME * self._sizes(point)
        return [n for n, k in zip(nodes, same, strict=True) if k], np.flatnonzero(held).tolist()

    def _sizes(self, point: OperatingPoint) -> np.ndarray:
        """Sizes of the terms of the initial equations."""
        slopes = ca.jacobian(self.equations, point.system.inputs[0])
        found = evaluate_expression(point, slopes).reshape(slopes.shape, order="F")
        sizes: np.ndarray = 1.0 + np.abs(found) @ np.abs(point.x)
        return sizes

    def list_lost(self, point: OperatingPoint) -> tuple[str, ...]:
        """What does not hold at a point, in words."""
        system, (nodes, equations) = point.system, self.find_kept(point)
        found = []
        for node in self.asked + self.declared:
            if node not in nodes:
                unknown = self._unknowns[node]
                sign = float(system.structure.reduced.aliases.signs[unknown])
                value = sign * float(self.values([node], self.begin)[0])
                unit = system.structure.tree.quantity(unknown).unit
                found.append(f"{system.structure.tree.unknown_name(unknown)} = {value:.6g} {unit}")
        for k, place in enumerate(self._equations):
            if k not in equations:
                text = system.structure.flat.initial_text(*self._places[place])
                found.append(f"the initial equation {text}")
        return tuple(found)


def evaluate_expression(point: OperatingPoint, expression: ca.SX) -> np.ndarray:
    """Values of an expression of the structure at a point."""
    system = point.system
    function = ca.Function(
        "at", system.inputs, [ca.densify(system.structure.in_states(expression))]
    )
    return np.asarray(function(*point.inputs)).ravel(order="F")


def computable_rows(system: System, expression: ca.SX) -> np.ndarray:
    """Which rows depend on states in use only."""
    rows, columns = uses(expression, system.structure.values)
    found = np.ones(expression.numel(), dtype=bool)
    found[rows[~np.isin(columns, system.structure.in_use)]] = False
    return found


def order_of(system: System, node: int) -> int:
    """How often the quantity of a node is differentiated."""
    return system.structure.reduced.class_and_order(node)[1]
