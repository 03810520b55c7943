"""Initial equations as expressions of states, parameters and settings."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening.flat_model import Group
from lumped.flattening.residual import Residual

Place = tuple[Group, int, int]
"""Group, instance and number of an initial equation in its template."""


def initial_residuals(system: System) -> tuple[ca.SX, list[Place]]:
    """Left minus right side of each initial equation, and where it is declared.

    Expressions of all states, left out or not; one vectorised call for each template equation.
    """
    parts, places = [ca.SX(0, 1)], []
    for group in system.structure.flat.initial:
        for number in range(group.template.count):
            parts.append(_residuals(system, group, group.template.residual(number)))
            places += [(group, instance, number) for instance in range(len(group.nodes))]
    return ca.vertcat(*parts), places


def _residuals(system: System, group: Group, residual: Residual) -> ca.SX:
    aliases = system.structure.reduced.aliases
    unknowns = group.unknowns[:, residual.locals]
    m, n = unknowns.shape
    orders = residual.orders + aliases.shifts[unknowns]
    alive = np.flatnonzero(aliases.classes[unknowns].ravel() >= 0)
    symbols = ca.SX.zeros(m * n)
    if len(alive):
        found = _derivatives(
            system, aliases.classes[unknowns].ravel()[alive], orders.ravel()[alive]
        )
        symbols[alive.tolist()] = found * ca.DM(aliases.signs[unknowns].ravel()[alive])
    numbers = group.parameters.ravel().tolist()
    parameters = system.structure.parameters.values[numbers] if numbers else ca.SX(0, 1)
    arguments = (
        ca.reshape(symbols, n, m),
        ca.reshape(parameters, len(numbers) // m, m),
        ca.repmat(system.structure.values.time, 1, m),
        ca.SX(0, m),
    )
    return ca.vec(residual.value.map(m)(*arguments))


def _derivatives(system: System, classes: np.ndarray, orders: np.ndarray) -> ca.SX:
    """Time derivatives of classes; those beyond the highest in use by the chain rule."""
    reduced, values = system.structure.reduced, system.structure.values
    beyond = np.maximum(orders - reduced.highest[classes], 0)
    found = values.of((reduced.first[classes] + orders - beyond).tolist())
    along = ca.vertcat(values.states, values.time)
    for level in range(1, int(beyond.max()) + 1):
        rates = ca.vertcat(values.of([n + 1 for n in reduced.states]), 1)
        picked = np.flatnonzero(beyond >= level).tolist()
        found[picked] = ca.jtimes(found[picked], along, rates)
    return found
