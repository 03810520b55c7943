"""Flatten a component tree to numbered unknowns and equations, keeping where each came from."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from lumped.component import Component
from lumped.errors import EquationError, ParameterError, SingularModelError
from lumped.expression import Equation, Expr, Ref, text, walk
from lumped.graph import Joints, join
from lumped.lower import lower
from lumped.quantity import Input, Param, Var, param
from lumped.template import Template, template_key
from lumped.tree import Node, Tree

__all__ = ["FlatModel", "Group", "Parameters", "flatten"]


@dataclass(eq=False)
class Group:
    """All instances of one template.

    Attributes
    ----------
    template : Template
        Their equations.
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
    nodes: list[int] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    unknowns: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), dtype=int))
    parameters: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), dtype=int))
    first_equation: int = 0
    first_mode: int = 0


@dataclass(frozen=True, eq=False)
class Parameters:
    """Parameters of a flat model.

    Attributes
    ----------
    free : list of int
        Numbers of the parameters that have a value of their own (the others are bound).
    theta : SX, shape (free, 1)
        Their symbols.
    defaults : ndarray, shape (free,)
        Their values in the model.
    values : SX, shape (all, 1)
        Every parameter as an expression of `theta`.
    """

    free: list[int]
    theta: ca.SX
    defaults: np.ndarray
    values: ca.SX
    declared: list[Param]
    names: list[str]

    def faults(self, values: np.ndarray) -> list[str]:
        """Texts of all values out of range."""
        found = []
        for name, quantity, value in zip(self.names, self.declared, values, strict=True):
            why = quantity.fault(value)
            if why:
                found.append(f"{name} = {value:g} {quantity.unit} ({quantity.text}) {why}")
        return found

    def check(self, values: np.ndarray, model: str) -> None:
        """Refuse values out of range, all in one error."""
        found = self.faults(values)
        if found:
            raise ParameterError(
                f"{model}: {len(found)} parameter fault(s):\n  " + "\n  ".join(found)
            )


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
    equation_count, mode_count : int
        Number of component equations and of modes.
    parameters : Parameters
        Their symbols and defaults.
    given : dict of int to SX
        Start values given to instances, by unknown; they hold exactly.
    starts : dict of int to SX
        Start values declared by classes, where not zero; they are defaults.
    """

    tree: Tree
    joints: Joints
    groups: list[Group]
    equation_count: int
    mode_count: int
    parameters: Parameters
    given: dict[int, ca.SX]
    starts: dict[int, ca.SX]

    @property
    def name(self) -> str:
        """Name of the model's class."""
        return type(self.tree.model).__name__

    def origin(self, equation: int) -> tuple[Node, str]:
        """Component of a component equation, and the equation with full names."""
        for group in self.groups:
            n = len(group.template.equations)
            offset = equation - group.first_equation
            if 0 <= offset < n * len(group.nodes):
                instance, number = divmod(offset, n)
                node = self.tree.nodes[group.nodes[instance]]
                return node, self._text(group.template, number, node)
        raise IndexError(equation)

    def _text(self, template: Template, number: int, node: Node) -> str:
        sample = template._component

        def name(ref: Ref) -> str:
            scope = self.tree.nodes[self.tree._number[id(sample)]]
            below = self.tree.below(ref.owner, scope) or ""
            return node.name(f"{below}.{ref.name}" if below else ref.name)

        equation = template.equations[number]
        return f"{text(equation.left, name)} = {text(equation.right, name)}"


def flatten(model: Component) -> FlatModel:
    """Number the unknowns, parameters and equations of a model.

    Raises
    ------
    ParameterError
        Missing parameters and values out of range, all with their paths.
    ConnectionError
        Ports or signals wrongly joined or left open.
    EquationError
        Equations without meaning.
    SingularModelError
        A component whose own equations do not match its own unknowns.
    """
    tree = Tree(model)
    parameters = _parameters(tree)
    joints = join(tree)
    groups, equation_count, mode_count = _groups(tree, joints)
    given, starts = _starts(tree, parameters)
    return FlatModel(tree, joints, groups, equation_count, mode_count, parameters, given, starts)


def _groups(tree: Tree, joints: Joints) -> tuple[list[Group], int, int]:
    groups: dict[Hashable, Group] = {}
    for number, node in enumerate(tree.nodes):
        if type(node.component).equations is Component.equations and not node.layout.variables:
            _check_hollow(node, joints)
            continue
        key = template_key(node.component)
        group = groups.get(key)
        if group is None:
            group = groups[key] = Group(_template(tree, node, node.component.equations()))
        _check_balance(tree, node, group.template, joints)
        group.nodes.append(number)
        group.names.append(node.path)
    _bound_inputs(tree, groups)
    equations = modes = 0
    for group in groups.values():
        template = group.template
        group.first_equation, group.first_mode = equations, modes
        equations += len(template.equations) * len(group.nodes)
        modes += len(template.modes) * len(group.nodes)
        group.unknowns = _numbers(tree, group, template.unknowns, "first_unknown")
        group.parameters = _numbers(tree, group, template.parameters, "first_parameter")
    return list(groups.values()), equations, modes


def _template(
    tree: Tree, scope: Node, equations: Iterable[Equation | tuple[Equation, ...]]
) -> Template:
    return Template(scope.component, lambda c: tree.below(c, scope), equations)


def _bound_inputs(tree: Tree, groups: dict[Hashable, Group]) -> None:
    """Equations of inputs that are given to instances instead of connected."""
    for number, node in enumerate(tree.nodes):
        for name, quantity in node.component._quantities.items():
            if not isinstance(quantity, Input) or name not in node.component._values:
                continue
            given, signal = node.component._values[name], Ref(node.component, name, quantity)
            if isinstance(given, Expr):
                scope = max(node.parent, 0)
                equation = Equation(signal, given)
                key: Hashable = (node.path, name)
                template = _template(tree, tree.nodes[scope], [equation])
                groups[key] = Group(template, [scope], [node.name(name)])
                continue
            key = (type(node.component), name)
            if key not in groups:
                parameter = Ref(node.component, name, param(quantity.unit, quantity.text))
                groups[key] = Group(_template(tree, node, [Equation(signal, parameter)]))
            groups[key].nodes.append(number)
            groups[key].names.append(node.name(name))


def _numbers(tree: Tree, group: Group, keys: list[tuple[str, str]], first: str) -> np.ndarray:
    table = np.empty((len(group.nodes), len(keys)), dtype=int)
    for column, (below, local) in enumerate(keys):
        for row, number in enumerate(group.nodes):
            node = tree.at(below, tree.nodes[number]) if below else tree.nodes[number]
            if first == "first_unknown":
                table[row, column] = node.first_unknown + node.layout.unknowns[local]
            elif local in node.layout.parameters:
                table[row, column] = node.first_parameter + node.layout.parameters[local]
            else:
                table[row, column] = tree.input_parameters[node.name(local)]
    return table


def _needed(node: Node, joints: Joints) -> int:
    """Equations that a component must bring: one per variable, free output and outer port."""
    count = node.layout.variables
    for local, quantity in enumerate(node.layout.quantities):
        if quantity.kind == "output":
            count += node.first_unknown + local not in joints.driven
    for port in range(len(node.layout.ports)):
        count += (node.first_port + port) not in joints.inside
    return count


def _check_hollow(node: Node, joints: Joints) -> None:
    if _needed(node, joints):
        open_ports = [
            name
            for i, name in enumerate(node.layout.ports)
            if node.first_port + i not in joints.inside
        ]
        raise SingularModelError(
            f"{node.label} has no equations, but its {', '.join(open_ports) or 'outputs'} must be "
            "determined. Connect them inside to a part, or write equations()."
        )


def _check_balance(tree: Tree, node: Node, template: Template, joints: Joints) -> None:
    needed, found = _needed(node, joints), len(template.equations)
    if needed == found:
        return
    layout = node.layout
    own = [n for n, i in layout.unknowns.items() if isinstance(layout.quantities[i], Var)]
    outs = [n for n, i in layout.unknowns.items() if layout.quantities[i].kind == "output"]
    listed = [f"  {equation!r}" for equation in template.equations]
    verdict = "too few: something is left undetermined" if found < needed else "too many"
    raise SingularModelError(
        f"{node.label} brings {found} equations but needs {needed}, {verdict}.\n"
        f"It needs one for each variable ({', '.join(own) or 'none'}), output "
        f"({', '.join(outs) or 'none'}) and port ({', '.join(layout.ports) or 'none'}).\n"
        "Its equations:\n" + ("\n".join(listed) or "  none")
    )


def _parameters(tree: Tree) -> Parameters:
    expressions: dict[int, tuple[Expr, Node]] = {}
    numbers: dict[int, float] = {}
    declared: list[Param] = []
    names: list[str] = []
    missing: list[str] = []
    for node in tree.nodes:
        given = node.component._values
        for local, quantity in node.layout.declared.items():
            number = len(declared)
            declared.append(quantity)
            names.append(node.name(local))
            value, scope = quantity.default, node
            if local in given:
                value = given[local]
                scope = tree.nodes[max(node.parent, 0)]
            if value is None:
                missing.append(f"{names[-1]} ({quantity.text}, {quantity.unit}) has no value")
            elif isinstance(value, Expr):
                expressions[number] = (value, scope)
            else:
                numbers[number] = float(value)
    for node in tree.nodes:
        for local, signal in node.component._quantities.items():
            number_given = node.component._values.get(local)
            if isinstance(signal, Input) and isinstance(number_given, float):
                tree.input_parameters[node.name(local)] = len(declared)
                numbers[len(declared)] = number_given
                declared.append(param(signal.unit, signal.text))
                names.append(node.name(local))
    faults = missing + [
        f"{names[i]} = {v:g} {declared[i].unit} ({declared[i].text}) {why}"
        for i, v in numbers.items()
        if (why := declared[i].fault(v))
    ]
    if faults:
        raise ParameterError(
            f"{type(tree.model).__name__}: {len(faults)} parameter fault(s):\n  "
            + "\n  ".join(faults)
        )
    free = list(numbers)
    theta = ca.SX.sym("p", len(free))
    values = ca.SX.zeros(len(declared))
    if free:
        values[free] = theta
    symbols: dict[int, ca.SX] = {}
    _bind(tree, expressions, values, symbols, names)
    result = Parameters(free, theta, np.array([numbers[i] for i in free]), values, declared, names)
    if expressions:
        at_default = np.asarray(ca.Function("p", [theta], [values])(result.defaults)).ravel()
        result.check(at_default, type(tree.model).__name__)
    return result


def _bind(
    tree: Tree,
    expressions: dict[int, tuple[Expr, Node]],
    values: ca.SX,
    done: dict[int, ca.SX],
    names: list[str],
) -> None:
    """Lower the bound parameters in an order in which each finds what it needs."""

    def source(leaf: Expr, scope: Node) -> int:
        return _source(tree, leaf, scope)

    for start in expressions:
        stack = [start]
        on_stack = {start}
        while stack:
            number = stack[-1]
            if number in done:
                stack.pop()
                continue
            expression, scope = expressions[number]
            needs = [source(leaf, scope) for leaf in _leaves(expression)]
            waiting = [n for n in needs if n in expressions and n not in done]
            if not waiting:
                lowered = lower(expression, lambda leaf, s=scope: values[source(leaf, s)])  # type: ignore[misc]
                done[number] = lowered
                values[number] = lowered
                stack.pop()
                on_stack.discard(number)
                continue
            for n in waiting:
                if n in on_stack:
                    raise ParameterError(
                        f"{names[number]} and {names[n]} are bound to each other in a circle."
                    )
                on_stack.add(n)
                stack.append(n)


def _leaves(expression: Expr) -> list[Expr]:
    return [node for node in walk(expression) if isinstance(node, Param | Ref)]


def _source(tree: Tree, leaf: Expr, scope: Node) -> int:
    """Number of the parameter that a leaf of a binding means, seen from `scope`."""
    node: Node | None = scope
    if isinstance(leaf, Ref) and isinstance(leaf.quantity, Param):
        node, name = tree.find(leaf.owner, scope), leaf.name
    elif isinstance(leaf, Param):
        name = leaf.name
    else:
        raise EquationError(
            f"{scope.label}: '{leaf!r}' is not a parameter; parameters and start values are bound "
            "to numbers and parameters only."
        )
    if node is None or name not in node.layout.parameters:
        raise EquationError(
            f"{scope.label}: a part is bound to the parameter '{name}', which "
            f"{scope.label} does not have."
        )
    return node.first_parameter + node.layout.parameters[name]


def _starts(tree: Tree, parameters: Parameters) -> tuple[dict[int, ca.SX], dict[int, ca.SX]]:
    given: dict[int, ca.SX] = {}
    starts: dict[int, ca.SX] = {}

    def value(number: object, scope: Node) -> ca.SX:
        if not isinstance(number, Expr):
            return ca.SX(float(number))  # type: ignore[arg-type]
        return lower(number, lambda leaf: parameters.values[_source(tree, leaf, scope)])

    for node in tree.nodes:
        values = node.component._values
        parent = tree.nodes[max(node.parent, 0)]
        for local, i in node.layout.unknowns.items():
            quantity = node.layout.quantities[i]
            if not isinstance(quantity, Var):
                continue
            if local in values:
                given[node.first_unknown + i] = value(values[local], parent)
            elif isinstance(quantity.start, Expr) or quantity.start != 0.0:
                starts[node.first_unknown + i] = value(quantity.start, node)
    return given, starts
