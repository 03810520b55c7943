"""Values of what must hold at a start, and their derivatives."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.points.initial_equations import initial_residuals
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once

_DENSE = 10_000
"""Entries of a matrix up to which it is kept as an array."""

Matrix = Any
"""An array, or a sparse one if it is large."""


class TargetValues:
    """Values of targets and their derivatives by states and free parameters.

    Attributes
    ----------
    places : list
        Where each initial equation is declared.
    entries : tuple of ndarray
        Rows and columns of the derivatives that are not always zero.
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
        jacobian = ca.jacobian(expression, ca.vertcat(values.states, parameters))
        results = [expression, jacobian]
        self._call = ArrayFunction(ca.Function("targets", self._inputs, results))
        rows, columns = jacobian.sparsity().get_triplet()
        self.entries = np.array(rows, dtype=int), np.array(columns, dtype=int)
        self._shape = jacobian.shape
        self.known: tuple[object, tuple[list[int], np.ndarray]] | None = None

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
