"""A model as numbered unknowns and equations, in groups of equal ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np

from lumped.flattening.connection_sets import Joints
from lumped.flattening.parameters import Parameters
from lumped.flattening.template import Template
from lumped.flattening.tree import Instance, Tree
from lumped.language.expression import Equation, Expr, Ref, text
from lumped.language.formula import Formula
from lumped.language.quantity import Param


@dataclass(eq=False)
class Group:
    """All instances of one template.

    Attributes
    ----------
    template : Template
        Their equations, lowered.
    equations : list of Equation
        Those of the first instance, as written.
    nodes : list of int
        Node number of each instance.
    names : list of str
        Dotted name of what each instance's equations belong to.
    unknowns : ndarray of int, shape (instances, local unknowns)
        Number of each local unknown.
    parameters : ndarray of int, shape (instances, local parameters)
        Number of each local parameter.
    first_equation : int
        Number of the first equation; equation e of instance i is ``first + i * n + e``.
    first_mode : int
        The same for the modes.
    """

    template: Template
    equations: list[Equation]
    nodes: list[int] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    unknowns: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), dtype=int))
    parameters: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), dtype=int))
    first_equation: int = 0
    first_mode: int = 0

    def add(self, node: int, name: str) -> None:
        """Add an instance."""
        self.nodes.append(node)
        self.names.append(name)


@dataclass(eq=False)
class FlatModel:
    """A model as numbered unknowns and equations.

    Attributes
    ----------
    tree : Tree
        Components and names.
    joints : Joints
        What the connections imply.
    groups : list of Group
        Component equations, by template.
    parameters : Parameters
        Their symbols and defaults.
    given : dict of int to SX
        Start values given to instances, by unknown; they hold exactly.
    starts : dict of int to SX
        Start values declared by classes, where not zero; they are defaults.
    initial : list of Group
        Equations that hold at the start only, by template.
    motions : dict of str to Expr
        Quantities that are prescribed beside the model, and what they are.
    watched : dict of Formula to Group
        Formulas of a user at whose kinks runs stop, and their groups.
    """

    tree: Tree
    joints: Joints
    groups: list[Group]
    parameters: Parameters
    given: dict[int, ca.SX]
    starts: dict[int, ca.SX]
    initial: list[Group]
    motions: Mapping[str, Expr]
    watched: Mapping[Formula, Group] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """Name of the model's class."""
        return type(self.tree.model).__name__

    @cached_property
    def equation_count(self) -> int:
        """Number of component equations."""
        return sum(group.template.count * len(group.nodes) for group in self.groups)

    @cached_property
    def mode_count(self) -> int:
        """Number of modes."""
        return sum(len(group.template.modes) * len(group.nodes) for group in self.groups)

    @cached_property
    def start_numbers(self) -> dict[int, float]:
        """Start values at default parameters, by unknown, where they are not zero by default."""
        values = {**self.starts, **self.given}
        if not values:
            return {}
        theta = self.parameters.theta
        evaluate = ca.Function("s", [theta], [ca.vertcat(*values.values())])
        found = np.asarray(evaluate(self.parameters.defaults)).ravel()
        return dict(zip(values, found.tolist(), strict=True))

    def origin(self, equation: int) -> tuple[Instance, str]:
        """Component of a component equation, and the equation with full names."""
        group, instance, number = self.place(equation)
        node = self.tree.instances[group.nodes[instance]]
        return node, self._text(group, number, node)

    def place(self, equation: int) -> tuple[Group, int, int]:
        """Group of a component equation, the instance, and the number in the template."""
        for group in self.groups:
            n = group.template.count
            offset = equation - group.first_equation
            if 0 <= offset < n * len(group.nodes):
                return group, *divmod(offset, n)
        raise IndexError(equation)

    def initial_text(self, group: Group, instance: int, number: int) -> str:
        """An initial equation with full names, and where it is declared."""
        node = self.tree.instances[group.nodes[instance]]
        return f"{self._text(group, number, node)} in {node.label}"

    def _text(self, group: Group, number: int, node: Instance) -> str:
        scope = self.tree.instances[group.nodes[0]]

        def name(ref: Ref) -> str:
            below = self.tree.below(ref.owner, scope) or ""
            full = node.name(f"{below}.{ref.name}" if below else ref.name)
            number = self.tree.input_parameters.get(full)
            if number is not None and isinstance(ref.quantity, Param):
                return f"{self.parameters.defaults[self.parameters.free.index(number)]:g}"
            return full

        equation = group.equations[number]
        return f"{text(equation.left, name)} = {text(equation.right, name)}"
