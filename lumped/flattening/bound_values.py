"""Values given to parameters and variables: collected, bound to each other, checked."""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter

import casadi as ca
import numpy as np

from lumped.errors import EquationError, ParameterError, told_by
from lumped.flattening.parameters import Parameters, refuse_faults
from lumped.flattening.tree import Instance, Tree
from lumped.language.declared import values_of
from lumped.language.expression import Expr, Ref, as_expr, walk
from lumped.language.given_numbers import find_declaring
from lumped.language.lowering import lower
from lumped.language.quantity import Input, Param, param


def collect(tree: Tree) -> Parameters:
    """Number the parameters of a model and bind those given as expressions.

    Raises
    ------
    ParameterError
        Missing values, values out of range and circles, all with their paths.
    """
    expressions: dict[int, tuple[Expr, Instance]] = {}
    numbers: dict[int, float] = {}
    declared: list[Param] = []
    names: list[str] = []
    limited: list[tuple[int, Instance]] = []
    faults: dict[int, str] = {}
    for node in tree.instances:
        own = values_of(node.component)
        for local, quantity in node.layout.declared.items():
            number = len(declared)
            declared.append(quantity)
            names.append(node.name(local))
            if quantity.exceeds is not None:
                limited.append((number, node))
            value, scope = quantity.default, node
            if local in own:
                value = own[local]
                scope = tree.instances[max(node.parent, 0)]
            elif callable(value):
                with told_by(node.label, f"the default of '{local}'"):
                    value = value(node.component)
            if value is None:
                faults[number] = f"{names[-1]} ({quantity.text}, {quantity.unit}) has no value"
            elif isinstance(value, Expr):
                expressions[number] = (value, scope)
            else:
                numbers[number] = float(value)
    for node in tree.instances:
        for local, place in node.layout.inputs.items():
            signal, given = node.layout.quantities[place], values_of(node.component).get(local)
            if node.name(local) in tree.freed:
                continue
            if isinstance(signal, Input) and isinstance(given, float):
                tree.input_parameters[node.name(local)] = len(declared)
                numbers[len(declared)] = given
                declared.append(param(signal.unit, signal.text, min=signal.min))
                names.append(node.name(local))
    free = list(numbers)
    theta = ca.SX.sym("p", len(free))
    values = ca.SX.zeros(len(declared))
    if free:
        values[free] = theta
    defaults = np.array([numbers[i] for i in free])
    result = Parameters(free, theta, defaults, values, declared, names, [])
    for i, v in numbers.items():
        fault = result.fault(i, v)
        if fault:
            faults[i] = fault
    refuse_faults(type(tree.model).__name__, [faults[i] for i in sorted(faults)])
    _bind(tree, expressions, values, names)
    for number, node in limited:
        quantity = declared[number]
        least = quantity.exceeds
        if callable(least):
            least = least(node.component)
        least = as_expr(least)
        low = lower(least, lambda leaf, s=node: values[_source(tree, leaf, s)])  # type: ignore[misc]
        result.ordered.append((number, low, *_describe(least, quantity, node)))
    if expressions or limited:
        result.check(result.defaults, type(tree.model).__name__)
    return result


def _bind(
    tree: Tree,
    expressions: dict[int, tuple[Expr, Instance]],
    values: ca.SX,
    names: list[str],
) -> None:
    """Lower the bound parameters in an order in which each finds what it needs."""

    def source(leaf: Expr, scope: Instance) -> int:
        return _source(tree, leaf, scope)

    needs = {}
    for number, (expression, scope) in expressions.items():
        leaves = (node for node in walk(expression) if isinstance(node, Param | Ref))
        needs[number] = {source(leaf, scope) for leaf in leaves} & expressions.keys()
    try:
        order = list(TopologicalSorter(needs).static_order())
    except CycleError as fault:
        needed, user, *_ = (names[number] for number in fault.args[1])
        raise ParameterError(
            f"{user} and {needed} are bound to each other in a circle. Give one of them a number."
        ) from None
    for number in order:
        expression, scope = expressions[number]
        try:
            lowered = lower(expression, lambda leaf, s=scope: values[source(leaf, s)])  # type: ignore[misc]
        except EquationError as error:
            raise EquationError(f"{names[number]}: {error}") from None
        values[number] = lowered


def _describe(least: Expr, quantity: Param, node: Instance) -> tuple[str, tuple[str, str]]:
    """What a lower limit is called, its unit, and what follows that."""
    if isinstance(least, Param):
        return node.name(least.name), (least.unit, f" ({least.text})")
    return repr(least), (quantity.unit, "")


def _source(tree: Tree, leaf: Expr, scope: Instance) -> int:
    """Number of the parameter that a leaf of a binding means, seen from `scope`."""
    if isinstance(leaf, Ref) and isinstance(leaf.quantity, Param):
        owner, name = leaf.owner, leaf.name
    elif isinstance(leaf, Param):
        owner, name = find_declaring(leaf, scope.component), leaf.name
    else:
        raise EquationError(
            f"{scope.label}: '{leaf!r}' is not a parameter; parameters and start values are bound "
            "to numbers and parameters only."
        )
    node = tree.find(owner, scope)
    if node is None or name not in node.layout.parameters:
        raise EquationError(
            f"{scope.label}: a part is bound to the parameter '{name}', which "
            f"{scope.label} does not have."
        )
    return node.first_parameter + node.layout.parameters[name]


def start_values(tree: Tree, parameters: Parameters) -> tuple[dict[int, ca.SX], dict[int, ca.SX]]:
    """Start values given to instances, and those declared by classes where not zero."""
    given: dict[int, ca.SX] = {}
    starts: dict[int, ca.SX] = {}

    def value(number: object, scope: Instance) -> ca.SX:
        if not isinstance(number, Expr):
            return ca.SX(float(number))  # type: ignore[arg-type]
        return lower(number, lambda leaf: parameters.values[_source(tree, leaf, scope)])

    for node in tree.instances:
        values = values_of(node.component)
        parent = tree.instances[max(node.parent, 0)]
        for local, i in node.layout.variables.items():
            quantity = node.layout.quantities[i]
            if local in values:
                given[node.first_unknown + i] = value(values[local], parent)
            elif isinstance(quantity.start, Expr) or quantity.start != 0.0:
                starts[node.first_unknown + i] = value(quantity.start, node)
    return given, starts
