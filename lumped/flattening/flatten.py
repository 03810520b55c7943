"""Flatten a component tree to numbered unknowns and equations, keeping where each came from."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Iterator, Mapping

import numpy as np

from lumped.errors import EquationError, SingularModelError, shown, told_by
from lumped.flattening.bound_values import collect, start_values
from lumped.flattening.connection_sets import Joints, join
from lumped.flattening.flat_model import FlatModel, Group
from lumped.flattening.template import ENCLOSING, Template, template_key
from lumped.flattening.template_cache import template_of
from lumped.flattening.tree import Instance, Tree
from lumped.language.component import Component
from lumped.language.declared import quantities_of, values_of
from lumped.language.expression import Equation, Expr, Ref
from lumped.language.quantity import Input, Var, param
from lumped.language.switch import Hold, Item, Single, When
from lumped.language.validity import borders, check_ranges


def flatten(
    model: Component,
    motions: Mapping[str, Expr] | None = None,
    freed: frozenset[str] = frozenset(),
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
    tree = Tree(model, freed)
    parameters = collect(tree)
    joints = join(tree)
    groups, equation_count, mode_count = _groups(tree, joints, motions or {})
    given, starts = start_values(tree, parameters)
    return FlatModel(
        tree,
        joints,
        groups,
        equation_count,
        mode_count,
        parameters,
        given,
        starts,
        _initial_groups(tree),
        motions or {},
    )


def _groups(
    tree: Tree, joints: Joints, motions: Mapping[str, Expr]
) -> tuple[list[Group], int, int]:
    groups: dict[Template, Group] = {}
    alike: dict[Hashable, Group] = {}
    for number, node in enumerate(tree.instances):
        if type(node.component).equations is Component.equations and not node.layout.variables:
            _check_hollow(node, joints)
            continue
        group = _own_group(tree, groups, alike, node)
        _check_balance(node, group, joints)
        group.nodes.append(number)
        group.names.append(node.path)
    _bound_inputs(tree, groups)
    for name, wanted in motions.items():
        _motion(tree, groups, name, wanted)
    count = modes = 0
    for group in groups.values():
        group.first_equation, group.first_mode = count, modes
        count += group.template.count * len(group.nodes)
        modes += len(group.template.modes) * len(group.nodes)
        number_group(tree, group)
    return list(groups.values()), count, modes


def _initial_groups(tree: Tree) -> list[Group]:
    """Equations that hold at the start only."""
    groups: dict[Template, Group] = {}
    alike: dict[Hashable, Group] = {}
    for number, node in enumerate(tree.instances):
        if type(node.component).initial_equations is Component.initial_equations:
            continue
        _own_group(tree, groups, alike, node, initial=True).nodes.append(number)
    for group in groups.values():
        number_group(tree, group)
    return list(groups.values())


def _own_group(
    tree: Tree,
    groups: dict[Template, Group],
    alike: dict[Hashable, Group],
    node: Instance,
    *,
    initial: bool = False,
) -> Group:
    """Group of all instances with the own equations of one; those are asked for once."""
    key = template_key(node.component)
    if key not in alike:
        method = "initial_equations" if initial else "equations"
        with told_by(node.label, f"{method}()"):
            equations = getattr(node.component, method)()
        alike[key] = _group(tree, groups, node, equations, own=True, initial=initial)
    return alike[key]


def number_group(tree: Tree, group: Group) -> None:
    """Find the unknowns and parameters of all instances of a group."""
    group.unknowns = _numbers(tree, group, group.template.unknowns, "first_unknown")
    group.parameters = _numbers(tree, group, group.template.parameters, "first_parameter")


def _group(
    tree: Tree,
    groups: dict[Template, Group],
    scope: Instance,
    found: Iterable[Item] | None,
    *,
    own: bool = False,
    initial: bool = False,
) -> Group:
    """Group of all instances with equations like those found, made if there is none.

    They are the component's `own`, or bind its parts; `initial` ones hold at the start only.
    """
    method = "initial_equations()" if initial else "equations()"
    if not isinstance(found, Iterable):
        what = "nothing" if found is None else shown(found)
        raise EquationError(
            f"{scope.label}: {method} gave {what} back. Yield each equation: yield a == b."
        )
    with told_by(scope.label, method):
        items = [e for item in found for e in (item if isinstance(item, tuple) else (item,))]
    if own and not initial:
        with told_by(scope.label, "valid()"):
            items += borders(check_ranges(scope.component.valid()))
    try:
        for item in items:
            if not isinstance(item, Equation | Hold | When):
                raise EquationError(
                    f"{type(scope.component).__name__} yielded {item!r} as an equation; "
                    "each item must be an equation: left == right."
                )
        template = template_of(
            scope.component,
            lambda c: tree.below(c, scope),
            items,
            enclosed=own,
            plain=initial,
        )
    except EquationError as error:
        raise EquationError(f"{scope.label}: {error}") from None
    return groups.setdefault(template, Group(template, list(_list_equations(items))))


def _list_equations(items: Iterable[Single]) -> Iterator[Equation]:
    """Equations as the user wrote them, in the order of those of the template."""
    for item in items:
        if isinstance(item, Hold):
            yield from item.equations()
        elif isinstance(item, Equation):
            yield item


def _bound_inputs(tree: Tree, groups: dict[Template, Group]) -> None:
    """Equations of inputs that are given to instances instead of connected."""
    alike: dict[Hashable, Group] = {}
    for number, node in enumerate(tree.instances):
        for name, quantity in quantities_of(node.component).items():
            if not isinstance(quantity, Input) or name not in values_of(node.component):
                continue
            if node.name(name) in tree.freed:
                continue
            given, signal = values_of(node.component)[name], Ref(node.component, name, quantity)
            if isinstance(given, Expr):
                scope = max(node.parent, 0)
                group = _group(tree, groups, tree.instances[scope], [Equation(signal, given)])
                group.nodes.append(scope)
                group.names.append(node.name(name))
                continue
            key = (type(node.component), name)
            if key not in alike:
                parameter = Ref(node.component, name, param(quantity.unit, quantity.text))
                alike[key] = _group(tree, groups, node, [Equation(signal, parameter)])
            alike[key].nodes.append(number)
            alike[key].names.append(node.name(name))


def _motion(tree: Tree, groups: dict[Template, Group], name: str, wanted: Expr) -> None:
    """Add the equation of a prescribed quantity."""
    number = tree.unknown(name)
    node = tree.node_of_unknown(number)
    local = node.layout.names[number - node.first_unknown]
    equation = Equation(Ref(node.component, local, tree.quantity(number)), wanted)
    group = _group(tree, groups, tree.instances[0], [equation])
    group.nodes.append(0)
    group.names.append(name)


def _numbers(tree: Tree, group: Group, keys: Collection[tuple[str, str]], first: str) -> np.ndarray:
    table = np.empty((len(group.nodes), len(keys)), dtype=int)
    for column, (below, local) in enumerate(keys):
        for row, number in enumerate(group.nodes):
            node = _at(tree, below, tree.instances[number], local)
            if first == "first_unknown":
                table[row, column] = node.first_unknown + node.layout.unknowns[local]
            elif local in node.layout.parameters:
                table[row, column] = node.first_parameter + node.layout.parameters[local]
            elif node.name(local) in tree.input_parameters:
                table[row, column] = tree.input_parameters[node.name(local)]
            else:
                raise EquationError(
                    f"{node.label}: a part is bound to the parameter '{local}', which "
                    f"{node.label} does not have."
                )
    return table


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
    needed = layout.variables + len(_list_free(node, joints))
    if needed == found:
        return
    own = [n for n, i in layout.unknowns.items() if isinstance(layout.quantities[i], Var)]
    listed = [f"  {equation!r}" for equation in group.equations]
    verdict = "too few: something is left undetermined" if found < needed else "too many"
    raise SingularModelError(
        f"{node.label} brings {found} equations but needs {needed}, {verdict}.\n"
        f"It needs one for each variable ({', '.join(own) or 'none'}), output "
        f"({', '.join(layout.outputs) or 'none'}) and port ({', '.join(layout.ports) or 'none'}).\n"
        "Its equations:\n" + ("\n".join(listed) or "  none")
    )
