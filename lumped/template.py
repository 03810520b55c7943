"""The equations of one component class as CasADi expressions, shared by all its instances.

A class is lowered once; ten thousand instances cost one vectorised call, and so does the next
model with equal equations. The structure that the compiler needs (which unknown, at which
derivative, with which coefficient) is read off here.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field
from functools import cached_property

import casadi as ca
import numpy as np

from lumped.component import Component
from lumped.connection import label
from lumped.errors import EquationError
from lumped.expression import Call, Constant, Equation, Expr, Ref, text, walk
from lumped.lower import lower
from lumped.quantity import Param

__all__ = [
    "CONSTANT",
    "PARAMETRIC",
    "VARYING",
    "Residual",
    "Template",
    "template_key",
    "template_of",
]

_MOST_KNOWN = 1000
"""Templates that are kept for later models."""

CONSTANT, PARAMETRIC, VARYING = 0, 1, 2
"""Kinds of a coefficient: a number, a function of parameters, anything else."""


def template_key(component: Component) -> Hashable:
    """What two instances must share to have the same equations."""
    cls = type(component)
    choices = tuple((type(v), v) for v in (getattr(component, name) for name in cls._fields))
    try:
        hash(choices)
    except TypeError:
        return id(component)
    return id(component) if cls._parts else (cls, choices)


@dataclass(frozen=True, eq=False)
class Residual:
    """One equation (or a time derivative of it) as an expression that is zero.

    Attributes
    ----------
    template : Template
        Where it belongs.
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
    homogeneous : bool
        The equation is a sum of numbers times symbols and nothing else.
    """

    template: Template
    expression: ca.SX
    locals: np.ndarray
    orders: np.ndarray
    symbols: ca.SX
    partials: ca.SX
    kinds: np.ndarray
    values: np.ndarray
    affine: np.ndarray
    homogeneous: bool
    _solved: dict[int, ca.Function] = field(default_factory=dict)

    @cached_property
    def coefficients(self) -> ca.Function:
        """Partial derivatives by all symbols: (symbols, parameters, time, modes) -> (n,)."""
        return ca.Function("coefficients", self._inputs(), [self.partials])

    @cached_property
    def value(self) -> ca.Function:
        """The residual: (symbols, parameters, time, modes) -> (1,)."""
        return ca.Function("value", self._inputs(), [self.expression])

    def solved_for(self, i: int) -> ca.Function:
        """Symbol i from the others: (symbols, parameters, time, modes) -> (1,)."""
        if i not in self._solved:
            rest = ca.substitute(self.expression, self.symbols[i], 0)
            self._solved[i] = ca.Function("solved", self._inputs(), [-rest / self.partials[i]])
        return self._solved[i]

    def _inputs(self) -> list[ca.SX]:
        t = self.template
        return [
            self.symbols,
            ca.vertcat(ca.SX(0, 1), *t.parameter_symbols),
            t.time,
            ca.vertcat(ca.SX(0, 1), *t.modes),
        ]


Place = Callable[[Component], str | None]
"""Path of a component below the one that has the equations; None if it is no part of it."""

_known: dict[Hashable, Template] = {}


def template_of(component: Component, place: Place, equations: list[Equation]) -> Template:
    """The template of some equations, made once for all models with equal ones."""
    key = tuple(_content(place, side) for e in equations for side in (e.left, e.right))
    found = _known.get(key)
    if found is None:
        found = Template(component, place, equations)
        if len(_known) >= _MOST_KNOWN:
            del _known[next(iter(_known))]
        _known[key] = found
    return found


def _content(place: Place, side: Expr) -> Hashable:
    """One side of an equation, with names relative to the component."""
    numbers: dict[int, int] = {}
    found: list[Hashable] = []
    for node in walk(side):
        what: Hashable = getattr(node, "name", None)
        if isinstance(node, Constant):
            what = repr(node.value)
        elif isinstance(node, Call):
            what = node.op
        elif isinstance(node, Ref):
            what = (place(node.owner), node.name, isinstance(node.quantity, Param))
        numbers[id(node)] = len(numbers)
        found.append((type(node), what, *(numbers[id(child)] for child in node.children())))
    return tuple(found)


class Template:
    """Equations of a component class (with fixed structural choices).

    It knows no instance, as it serves several models.

    Attributes
    ----------
    count : int
        Number of equations.
    unknowns : list of (str, str)
        Path of the owner below the component ("" for itself) and name of each local unknown.
    parameters : list of (str, str)
        The same for the parameters.
    thresholds : list of (SX, int)
        Instant at which each mode changes, and +1 if it becomes 1 there, -1 if it becomes 0.
    """

    def __init__(self, component: Component, place: Place, equations: list[Equation]) -> None:
        self.count = len(equations)
        self.unknowns: list[tuple[str, str]] = []
        self.parameters: list[tuple[str, str]] = []
        self.parameter_symbols: list[ca.SX] = []
        self.modes: list[ca.SX] = []
        self.thresholds: list[tuple[ca.SX, int]] = []
        self.time = ca.SX.sym("time")
        self._unknown_index: dict[tuple[str, str], int] = {}
        self._parameter_index: dict[tuple[str, str], int] = {}
        self._symbols: dict[tuple[int, int], ca.SX] = {}
        self._key_of: dict[int, tuple[int, int]] = {}
        self._residuals: dict[tuple[int, int], Residual] = {}
        for number, equation in enumerate(equations):
            lowered = self._lowered(equation, component, place)
            self._residuals[number, 0] = self._analyse(lowered)

    def residual(self, number: int, order: int = 0) -> Residual:
        """Equation `number`, differentiated `order` times by the time."""
        found = self._residuals.get((number, order))
        if found is None:
            below = self.residual(number, order - 1)
            found = self._analyse(self._time_derivative(below.expression))
            self._residuals[number, order] = found
        return found

    def _lowered(self, equation: Equation, component: Component, place: Place) -> ca.SX:
        sides = [
            lower(
                side,
                lambda node: self._leaf(node, component, place),
                time=self.time,
                derivative=self._time_derivative,
                relation=lambda g: self._mode(g, equation, component),
            )
            for side in (equation.left, equation.right)
        ]
        return sides[0] - sides[1]

    def _leaf(self, node: Expr, component: Component, place: Place) -> ca.SX:
        if isinstance(node, Param):
            node = Ref(component, node.name, node)
        if not isinstance(node, Ref):
            raise EquationError(f"'{node!r}' is not a quantity of an instance.")
        below = place(node.owner)
        if below is None:
            raise EquationError(
                f"equations() uses {label(node)} of a component {type(node.owner).__name__} that "
                "is not one of its parts."
            )
        key = (below, node.name)
        if isinstance(node.quantity, Param):
            if key not in self._parameter_index:
                self._parameter_index[key] = len(self.parameters)
                self.parameters.append(key)
                self.parameter_symbols.append(ca.SX.sym(node.name))
            return self.parameter_symbols[self._parameter_index[key]]
        if key not in self._unknown_index:
            self._unknown_index[key] = len(self.unknowns)
            self.unknowns.append(key)
        return self._symbol(self._unknown_index[key], 0)

    def _symbol(self, unknown: int, order: int) -> ca.SX:
        key = (unknown, order)
        if key not in self._symbols:
            symbol = ca.SX.sym(self.unknowns[unknown][1] + "'" * order)
            self._symbols[key] = symbol
            self._key_of[symbol.element_hash()] = key
        return self._symbols[key]

    def _present(self, expression: ca.SX) -> list[tuple[int, int]]:
        hashes = [s.element_hash() for s in ca.symvar(expression)]
        return sorted(self._key_of[h] for h in hashes if h in self._key_of)

    def _time_derivative(self, expression: ca.SX) -> ca.SX:
        keys = self._present(expression)
        symbols = ca.vertcat(self.time, *(self._symbols[k] for k in keys))
        rates = ca.vertcat(1, *(self._symbol(u, order + 1) for u, order in keys))
        return ca.jtimes(expression, symbols, rates)

    def _mode(self, g: ca.SX, equation: Equation, component: Component) -> ca.SX:
        slope = ca.jacobian(g, self.time)
        if self._present(g) or not slope.is_constant():
            raise EquationError(
                f"{type(component).__name__}: a condition in '{text(equation.left)} == "
                f"{text(equation.right)}' must compare the time with parameters."
            )
        rate = float(slope)
        at_zero = ca.substitute(g, self.time, 0)
        threshold = ca.if_else(at_zero >= 0, -ca.inf, ca.inf) if rate == 0.0 else -at_zero / rate
        self.thresholds.append((threshold, -1 if rate < 0 else 1))
        self.modes.append(ca.SX.sym("mode"))
        return self.modes[-1]

    def _analyse(self, expression: ca.SX) -> Residual:
        keys = self._present(expression)
        symbols = ca.vertcat(*(self._symbols[k] for k in keys)) if keys else ca.SX(0, 1)
        partials = ca.densify(ca.jacobian(expression, symbols)).T
        n = len(keys)
        kinds, values = np.full(n, VARYING), np.full(n, np.nan)
        affine = np.ones((n, n), dtype=bool)
        varying = ca.vertcat(symbols, self.time, *self.modes)
        for i in range(n):
            entry = partials[i]
            if entry.is_constant():
                kinds[i], values[i] = CONSTANT, float(entry)
            elif not any(ca.which_depends(entry, varying)):
                kinds[i] = PARAMETRIC
            else:
                affine[i] = ~np.array(ca.which_depends(entry, symbols), dtype=bool)
        homogeneous = bool((kinds == CONSTANT).all())
        if homogeneous:
            rest = ca.substitute(expression, symbols, ca.SX.zeros(n)) if n else expression
            homogeneous = ca.simplify(rest).is_zero()
        return Residual(
            template=self,
            expression=expression,
            locals=np.array([k[0] for k in keys], dtype=int),
            orders=np.array([k[1] for k in keys], dtype=int),
            symbols=symbols,
            partials=partials,
            kinds=kinds,
            values=values,
            affine=affine,
            homogeneous=homogeneous,
        )
