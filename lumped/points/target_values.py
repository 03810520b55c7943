"""Values of what must hold at a start, initial equations among them, and their derivatives."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.flattening.flat_model import Group
from lumped.flattening.residual import Residual
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once

_DENSE = 10_000
"""Entries of a matrix up to which it is kept as an array."""

Matrix = Any
"""An array, or a sparse one if it is large."""
Place = tuple[Group, int, int]
"""Group, instance and number of an initial equation in its template."""


class TargetValues:
    """Values of targets and their derivatives by states and free parameters.

    Attributes
    ----------
    places : list
        Where each initial equation is declared.
    expression : SX
        Values as an expression.
    has_positions : bool
        Whether they depend on positions of conditions and holds, or on implicit quantities.
    """

    def __init__(self, system: System, given: tuple[int, ...], free: tuple[int, ...]) -> None:
        values, inputs = system.structure.values, system.inputs[1:]
        residuals, self.places = initial_residuals(system)
        expression = ca.densify(ca.vertcat(values.of(list(given)), residuals))
        self._inputs, self.expression = [values.states, *inputs], expression
        self.has_positions = bool(ca.depends_on(expression, inputs[-1]))
        parameters = inputs[0][list(free)] if free else ca.SX(0, 1)
        self._unknowns = ca.vertcat(values.states, parameters)
        self._shape = expression.numel(), self._unknowns.numel()
        self._values = ArrayFunction(ca.Function("targets", self._inputs, [expression]))
        self.known: tuple[object, tuple[list[int], np.ndarray]] | None = None

    @cached_property
    def _slopes(self) -> ca.SX:
        return ca.jacobian(self.expression, self._unknowns)

    @cached_property
    def entries(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the derivatives that are not always zero."""
        rows, columns = self._slopes.sparsity().get_triplet()
        return np.array(rows, dtype=int), np.array(columns, dtype=int)

    @cached_property
    def _call(self) -> ArrayFunction:
        results = [self.expression, self._slopes]
        return ArrayFunction(ca.Function("targets", self._inputs, results))

    def values(
        self, x: np.ndarray, theta: np.ndarray, time: float, settings: np.ndarray
    ) -> np.ndarray:
        """Values at a point; no derivatives are made for that."""
        return self._values(x, theta, time, settings)[0]

    @cached_property
    def by_parameters(self) -> ca.Function:
        """Derivatives by all parameters: (all states, p, t, m)."""
        found = ca.jacobian(self.expression, self._inputs[1])
        return ca.Function("by_parameters", self._inputs, [found])

    def __call__(
        self, x: np.ndarray, theta: np.ndarray, time: float, settings: np.ndarray
    ) -> tuple[np.ndarray, Matrix]:
        """Values and derivatives at a point."""
        value, nonzeros = self._call(x, theta, time, settings)
        if self._shape[0] * self._shape[1] > _DENSE:
            return value, scipy.sparse.csc_array((nonzeros, self.entries), shape=self._shape)
        matrix = np.zeros(self._shape)
        matrix[self.entries] = nonzeros
        return value, matrix


@made_once
def target_values(system: System, given: tuple[int, ...], free: tuple[int, ...]) -> TargetValues:
    """Values of given nodes and initial equations; `free`: places of parameters."""
    return TargetValues(system, given, free)


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
