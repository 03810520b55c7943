"""Flatten a component tree to numbered unknowns and equations, keeping where each came from."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping, Sequence

import numpy as np

from lumped.errors import EquationError, SingularModelError, shown, told_by
from lumped.flattening.bound_values import collect, start_values
from lumped.flattening.connection_sets import Joints, join
from lumped.flattening.flat_model import FlatModel, Group
from lumped.flattening.template import ENCLOSING, Template, template_key
from lumped.flattening.template_cache import template_of
from lumped.flattening.tree import Instance, Tree
from lumped.language.component import Component
from lumped.language.declared import values_of
from lumped.language.expression import Equation, Expr, Ref
from lumped.language.quantity import param
from lumped.language.switch import Hold, Item, Single, When
from lumped.language.validity import borders


def flatten(
    model: Component,
    motions: Mapping[str, Expr] | None = None,
    freed: frozenset[str] = frozenset(),
    massless: Mapping[str, bool] | None = None,
) -> FlatModel:
    """Number the unknowns, parameters and equations of a model.

    Parameters
    ----------
    model : Component
        The model.
    motions : mapping of str to Expr, optional
        Quantities and what they shall be: as many equations more.
    freed : frozenset of str
        Inputs given to instances that shall be unknowns: as many equations less.
    massless : mapping of str to bool, optional
        Paths of components whose friction slides beside springs only, and whether these are damped.

    Raises
    ------
    ParameterError
        Missing parameters and values out of range, all with their paths.
    ConnectError
        Ports or signals wrongly joined or left open.
    EquationError
        Equations without meaning.
    SingularModelError
        A component whose own equations do not match its own unknowns.
    """
    tree = Tree(model, freed, massless)
    parameters = collect(tree)
    joints = join(tree)
    own = _Groups(tree)
    for number, node in enumerate(tree.instances):
        if type(node.component).equations is Component.equations and not node.layout.variables:
            _check_hollow(node, joints)
        else:
            _check_balance(node, own.add_own(number), joints)
    own.add_inputs()
    for name, wanted in (motions or {}).items():
        own.add_motion(name, wanted)
    groups = own.number()
    given, starts = start_values(tree, parameters)
    initial = _Groups(tree, initial=True)
    for number, node in enumerate(tree.instances):
        if type(node.component).initial_equations is not Component.initial_equations:
            initial.add_own(number)
    return FlatModel(
        tree, joints, groups, parameters, given, starts, initial.number(), motions or {}
    )


def number_group(tree: Tree, group: Group) -> None:
    """Find the unknowns and parameters of all instances of a group."""
    group.unknowns = _numbers(tree, group, group.template.unknowns, "first_unknown")
    group.parameters = _numbers(tree, group, group.template.parameters, "first_parameter")


class _Groups:
    """Instances with equal equations, by template; `initial` ones hold at the start only."""

    def __init__(self, tree: Tree, *, initial: bool = False) -> None:
        self._tree, self._initial = tree, initial
        self._found: dict[Template, Group] = {}
        self._alike: dict[Hashable, Group] = {}

    def number(self) -> list[Group]:
        """All groups, their equations and modes numbered one after the other."""
        count = modes = 0
        for group in self._found.values():
            group.first_equation, group.first_mode = count, modes
            count += group.template.count * len(group.nodes)
            modes += len(group.template.modes) * len(group.nodes)
            number_group(self._tree, group)
        return list(self._found.values())

    def add_own(self, number: int) -> Group:
        """Add an instance with its own equations; of equal ones they are asked for once."""
        node = self._tree.instances[number]
        key = template_key(node.component), node.massless is None
        if key not in self._alike:
            method = "initial_equations" if self._initial else "equations"
            with told_by(node.label, f"{method}()"):
                found = getattr(node.component, method)()
            items = _list_items(node, found, f"{method}()")
            if not self._initial:
                items = items if node.massless is None else node.massless.items
                with told_by(node.label, "valid()"):
                    items += borders(node.ranges())
            self._alike[key] = self._group(node, items, own=True)
        group = self._alike[key]
        group.add(number, node.path)
        return group

    def add_inputs(self) -> None:
        """Add equations of inputs that are given to instances instead of connected."""
        for number, node in enumerate(self._tree.instances):
            for name, local in node.layout.inputs.items():
                if name not in values_of(node.component) or node.name(name) in self._tree.freed:
                    continue
                quantity = node.layout.quantities[local]
                given, signal = values_of(node.component)[name], Ref(node.component, name, quantity)
                if isinstance(given, Expr):
                    scope = max(node.parent, 0)
                    group = self._group(self._tree.instances[scope], [Equation(signal, given)])
                    group.add(scope, node.name(name))
                    continue
                key = (type(node.component), name)
                if key not in self._alike:
                    parameter = Ref(node.component, name, param(quantity.unit, quantity.text))
                    self._alike[key] = self._group(node, [Equation(signal, parameter)])
                self._alike[key].add(number, node.name(name))

    def add_motion(self, name: str, wanted: Expr) -> None:
        """Add the equation of a prescribed quantity."""
        tree, number = self._tree, self._tree.unknown(name)
        node = tree.node_of_unknown(number)
        local = node.layout.names[number - node.first_unknown]
        equation = Equation(Ref(node.component, local, tree.quantity(number)), wanted)
        self._group(tree.instances[0], [equation]).add(0, name)

    def _group(self, scope: Instance, items: Sequence[Single], *, own: bool = False) -> Group:
        """Group of all instances with equations like these, made if there is none.

        They are the component's `own`, or bind its parts.
        """
        try:
            template = template_of(
                scope.component,
                lambda c: self._tree.below(c, scope),
                items,
                enclosed=own,
                plain=self._initial,
            )
        except EquationError as error:
            raise EquationError(f"{scope.label}: {error}") from None
        return self._found.setdefault(template, Group(template, list(_list_equations(items))))


def _list_items(scope: Instance, found: Iterable[Item] | None, method: str) -> list[Single]:
    """What a method of a component yields, one by one.

    Raises
    ------
    EquationError
        If it yields anything but equations.
    """
    if not isinstance(found, Iterable):
        what = "nothing" if found is None else shown(found)
        raise EquationError(
            f"{scope.label}: {method} gave {what} back. Yield each equation: yield a == b."
        )
    with told_by(scope.label, method):
        items = [e for item in found for e in (item if isinstance(item, tuple) else (item,))]
    for item in items:
        if not isinstance(item, Equation | Hold | When):
            raise EquationError(
                f"{scope.label}: {type(scope.component).__name__} yielded {item!r} as an equation; "
                "each item must be an equation: left == right."
            )
    return items


def _list_equations(items: Iterable[Single]) -> Iterator[Equation]:
    """Equations as the user wrote them, in the order of those of the template."""
    for item in items:
        if isinstance(item, Hold):
            yield from item.equations()
        elif isinstance(item, Equation):
            yield item


def _numbers(tree: Tree, group: Group, keys: Collection[tuple[str, str]], first: str) -> np.ndarray:
    scopes = [tree.instances[number] for number in group.nodes]
    table = np.empty((len(scopes), len(keys)), dtype=int)
    for column, (below, local) in enumerate(keys):
        nodes = [_at(tree, below, scope, local) for scope in scopes] if below else scopes
        if first == "first_unknown":
            table[:, column] = [n.first_unknown + n.layout.unknowns[local] for n in nodes]
        else:
            table[:, column] = [_parameter(tree, node, local) for node in nodes]
    return table


def _parameter(tree: Tree, node: Instance, local: str) -> int:
    """Number of a parameter."""
    if local in node.layout.parameters:
        return node.first_parameter + node.layout.parameters[local]
    if node.name(local) in tree.input_parameters:
        return tree.input_parameters[node.name(local)]
    raise EquationError(
        f"{node.label}: a part is bound to the parameter '{local}', which {node.label} does not "
        "have."
    )


def _at(tree: Tree, below: str, node: Instance, local: str) -> Instance:
    """The node that an equation of another one means."""
    if below != ENCLOSING:
        return tree.at(below, node) if below else node
    if node.parent < 0:
        raise EquationError(
            f"{node.label}: its equations use the parameter '{local}', which is not its own but "
            "that of a component around it. Give a number, or make it a part of the component that "
            "has the parameter."
        )
    return tree.instances[node.parent]


def _list_free(node: Instance, joints: Joints) -> list[str]:
    """Ports and outputs of a component that nothing inside it determines."""
    layout = node.layout
    ports = [n for i, n in enumerate(layout.ports) if node.first_port + i not in joints.inside]
    outputs = [n for n, i in layout.outputs.items() if node.first_unknown + i not in joints.driven]
    return ports + outputs


def _check_hollow(node: Instance, joints: Joints) -> None:
    """Refuse a component without equations and variables that leaves something open."""
    if free := _list_free(node, joints):
        raise SingularModelError(
            f"{node.label} has no equations, but its {', '.join(free)} must be "
            "determined. Connect them inside to a part, or write equations()."
        )


def _check_balance(node: Instance, group: Group, joints: Joints) -> None:
    """Refuse a component that has not one equation for each variable, free output and port."""
    layout, found = node.layout, group.template.count
    needed = len(layout.variables) + len(_list_free(node, joints))
    if needed == found:
        return
    listed = [f"  {equation!r}" for equation in group.equations]
    verdict = "too few: something is left undetermined" if found < needed else "too many"
    raise SingularModelError(
        f"{node.label} brings {found} equations but needs {needed}, {verdict}.\n"
        f"It needs one for each variable ({', '.join(layout.variables) or 'none'}), output "
        f"({', '.join(layout.outputs) or 'none'}) and port ({', '.join(layout.ports) or 'none'}).\n"
        "Its equations:\n" + ("\n".join(listed) or "  none")
    )
