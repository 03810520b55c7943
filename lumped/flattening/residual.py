"""One equation of a component class as an expression, and its partial derivatives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np

CONSTANT, PARAMETRIC, VARYING = 0, 1, 2
"""Kinds of a coefficient: a number, a function of parameters, anything else."""


@dataclass(frozen=True, eq=False)
class Residual:
    """One equation (or a time derivative of it) as an expression that is zero.

    Attributes
    ----------
    inputs : callable
        Gives its symbols, the parameters, the time and the modes of its component class.
    expression : SX
        Left minus right side.
    locals, orders : ndarray of int, shape (n,)
        Local unknown and order of derivative of each symbol in it.
    kinds : ndarray of int, shape (n,)
        Kind of the partial derivative by each symbol: number, parametric or varying.
    values : ndarray, shape (n,)
        The partial derivative where it is a number, else nan.
    affine : ndarray of bool, shape (n, n)
        ``affine[i, j]``: the partial derivative by symbol i does not depend on symbol j.
    """

    inputs: Callable[[], list[ca.SX]]
    expression: ca.SX
    locals: np.ndarray
    orders: np.ndarray
    symbols: ca.SX
    partials: ca.SX
    kinds: np.ndarray
    values: np.ndarray
    affine: np.ndarray
    _solved: dict[int, ca.Function] = field(default_factory=dict)

    @cached_property
    def coefficients(self) -> ca.Function:
        """Partial derivatives by all symbols: (symbols, parameters, time, modes) -> (n,)."""
        return ca.Function("coefficients", self.inputs(), [self.partials])

    @cached_property
    def value(self) -> ca.Function:
        """The residual: (symbols, parameters, time, modes) -> (1,)."""
        return ca.Function("value", self.inputs(), [self.expression])

    @cached_property
    def homogeneous(self) -> bool:
        """The equation is a sum of numbers times symbols and nothing else."""
        return bool((self.kinds == CONSTANT).all()) and self.proportional

    @cached_property
    def proportional(self) -> bool:
        """The equation is a sum of numbers or parameters times symbols and nothing else."""
        if (self.kinds == VARYING).any():
            return False
        n = len(self.kinds)
        rest = (
            ca.substitute(self.expression, self.symbols, ca.SX.zeros(n)) if n else self.expression
        )
        return bool(ca.simplify(rest).is_zero())

    def solve_for(self, i: int) -> ca.Function:
        """Symbol i from the others: (symbols, parameters, time, modes) -> (1,)."""
        if i not in self._solved:
            rest = ca.substitute(self.expression, self.symbols[i], 0)
            self._solved[i] = ca.Function("solved", self.inputs(), [-rest / self.partials[i]])
        return self._solved[i]
