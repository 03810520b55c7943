"""Expressions of a template of one instance, such as a user's formula, in those of a system."""

from __future__ import annotations

import casadi as ca

from lumped.flattening.flat_model import Group
from lumped.reduction.evaluation import Values


def rate_of(values: Values, found: ca.SX) -> ca.SX:
    """Time derivative of an expression of all states, by these."""
    moving = ca.vertcat(values.states, values.time)
    rates = ca.vertcat(values.of([state + 1 for state in values.reduced.states]), 1)
    return ca.jtimes(found, moving, rates)


def derivative(values: Values, unknown: int, order: int) -> ca.SX:
    """A time derivative of an unknown as an expression of all states, left out or not."""
    reduced = values.reduced
    node = reduced.node(unknown)
    if node is None:
        return ca.SX(0)
    number, own = reduced.class_and_order(node)
    known = min(order, int(reduced.highest[number]) - own)
    found = values.of([node + known])
    for _ in range(order - known):  # such as of a torque
        found = rate_of(values, found)
    return float(reduced.aliases.signs[unknown]) * found


def of_formula(values: Values, group: Group, expression: ca.SX) -> ca.SX:
    """An expression of the template of a formula as one of all states, left out or not."""
    template, unknowns = group.template, group.unknowns[0]
    keys = template.present(expression)
    function = ca.Function("formula", template.inputs(keys), [expression])
    symbols = [derivative(values, int(unknowns[local]), order) for local, order in keys]
    parameters = [values.flat.parameters.values[int(i)] for i in group.parameters[0]]
    modes = [values.modes[group.first_mode + i] for i in range(len(template.modes))]
    own = [ca.vertcat(ca.SX(0, 1), *column) for column in (symbols, parameters, modes)]
    return function(*own[:2], values.time, own[2])
