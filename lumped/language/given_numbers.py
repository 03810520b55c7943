"""Numbers of parameters before a model is assembled, for structural choices made of them."""

from __future__ import annotations

import casadi as ca

from lumped.errors import EquationError
from lumped.language.component import Component
from lumped.language.declared import place_of, quantities_of, values_of
from lumped.language.expression import Expr, Ref
from lumped.language.lowering import lower
from lumped.language.quantity import Param


def read_given_number(component: Component, name: str) -> float:
    """The number that a parameter has as the model is written; nan if it is not given.

    Parameters
    ----------
    component : Component
        As it is in the model.
    name : str
        Of a parameter.

    Raises
    ------
    EquationError
        If its value is bound to something that is no parameter.
    """
    quantity = quantities_of(component)[name]
    if not isinstance(quantity, Param):
        raise EquationError(f"'{name}' of {type(component).__name__} is not a parameter.")
    value, scope = quantity.default, component
    given, place = values_of(component), place_of(component)
    if name in given:
        value, scope = given[name], component if place is None else place[0]
    elif callable(value):
        value = value(component)
    if not isinstance(value, Expr):
        return float("nan") if value is None else float(value)

    def leaf(node: Expr) -> ca.SX:
        if isinstance(node, Ref):
            return ca.SX(read_given_number(node.owner, node.name))
        if isinstance(node, Param):
            return ca.SX(read_given_number(find_declaring(node, scope), node.name))
        raise EquationError(f"'{node!r}' is not a parameter.")

    return float(lower(value, leaf))


def find_declaring(parameter: Param, scope: Component) -> Component:
    """The component around a part that declares a parameter, `scope` if none has this very one."""
    node = scope
    while quantities_of(node).get(parameter.name) is not parameter:
        place = place_of(node)
        if place is None:
            return scope
        node = place[0]
    return node
