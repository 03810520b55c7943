"""Taylor coefficients of rates: operations at order zero, and recurrences for those after it.

Each operation of a function gives the coefficient of order k of its result from those of lower
orders of its arguments (Jorba and Zou, Experimental Mathematics 14 (2005) 99, prop. 2.1). A linear
operation needs those of order k alone; a product needs a sum over all orders, and so does a
quotient, a root, and an integral ``y' = g a'``, of which all other functions are made: a sine has
the cosine as g, a tangent ``1 + y^2``, an arctangent ``1 / (1 + a^2)``. What depends on parameters
and settings alone has no coefficients beyond order zero, whatever the operations are.
"""

from __future__ import annotations

from collections.abc import Iterator
from enum import IntEnum
from functools import cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.code.operations import (
    INPUTS,
    PARAMETER,
    RESULT,
    STATE,
    TIME,
    TWO,
    Operations,
    UnsupportedError,
    operations_of,
)


class Kind(IntEnum):
    """Kinds of recurrences.

    CHOSEN is the first argument where the second, a constant, is not zero.
    """

    (OF_STATE, OF_TIME, WRITTEN, COPIED, NEGATIVE, TWICE, SUM, DIFFERENCE, SCALED) = range(9)
    (CHOSEN, PRODUCT, QUOTIENT, ROOT, INTEGRAL) = range(9, 14)


Row = tuple[int, int, int, int]
_MOST_MULTIPLIED = 16
"""Whole exponents up to which a power is made of products, which also hold where its base is 0."""
_NAMES = {getattr(ca, n): n[3:].lower() for n in dir(ca) if n.startswith("OP_")}
_NAMES |= dict.fromkeys((ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE), "a comparison")
_NAMES |= dict.fromkeys((ca.OP_NOT, ca.OP_AND, ca.OP_OR), "a logical operation")
_NAMES[ca.OP_IF_ELSE_ZERO] = "a choice by the value"
_LINEAR = {ca.OP_ADD: Kind.SUM, ca.OP_SUB: Kind.DIFFERENCE}
_ONE_LINEAR = {
    ca.OP_NEG: Kind.NEGATIVE,
    ca.OP_TWICE: Kind.TWICE,
    ca.OP_ASSIGN: Kind.COPIED,
    ca.OP_LIFT: Kind.COPIED,
}


_A, _Y, _NONE = ca.SX.sym("a"), ca.SX.sym("y"), ca.SX.sym("none", 0)
_DERIVATIVES = {
    ca.OP_EXP: _Y,
    ca.OP_EXPM1: 1 + _Y,
    ca.OP_TAN: 1 + _Y**2,
    ca.OP_TANH: 1 - _Y**2,
    ca.OP_LOG: 1 / _A,
    ca.OP_LOG1P: 1 / (1 + _A),
    ca.OP_ERF: 2 / np.sqrt(np.pi) * ca.exp(-(_A**2)),
    ca.OP_ATAN: 1 / (1 + _A**2),
    ca.OP_ATANH: 1 / (1 - _A**2),
    ca.OP_ASIN: 1 / ca.sqrt(1 - _A**2),
    ca.OP_ACOS: 1 / ca.sqrt(1 - _A**2),
    ca.OP_ASINH: 1 / ca.sqrt(1 + _A**2),
    ca.OP_ACOSH: 1 / ca.sqrt(_A**2 - 1),
}
"""Derivatives of functions y of a; of the inverse cosine with the other sign."""


@cache
def _derivative(op: int) -> Operations:
    given = [_A, _Y, _NONE, _NONE]
    return operations_of(ca.Function("derivative", given, [_DERIVATIVES[op]]))


class Recurrence(NamedTuple):
    """How the coefficient of order k of a value follows.

    Attributes
    ----------
    kind : Kind
    value : int
        The value; of a written one, the number of the result.
    a, b : int
        Values that it is made of, or -1; of an integral the value a and its g.
    factor : int
        Constant by which a quotient or root is multiplied: the inverse of what it divides by.
    sign : int
        Of an integral.
    """

    kind: Kind
    value: int
    a: int = -1
    b: int = -1
    factor: int = -1
    sign: int = 1


class Series(NamedTuple):
    """What gives the coefficients of a function.

    Attributes
    ----------
    first : list of rows
        Operations for order zero as in `Operations`; each result is a value of its own.
    constants : list of float
        Their constants.
    later : list of Recurrence
        The orders after.
    values : int
        Number of values.
    """

    first: list[Row]
    constants: list[float]
    later: list[Recurrence]
    values: int

    @property
    def is_linear(self) -> bool:
        """Whether no recurrence has a sum over orders."""
        return all(r.kind < Kind.PRODUCT for r in self.later)


def series_of(function: Operations) -> Series:
    """Taylor coefficients of a function.

    Raises
    ------
    UnsupportedError
        If something that varies goes through an operation without Taylor coefficients.
    """
    made = _SeriesMaker(function)
    return Series(made.first, made.constants, [r for r in made.later if r], made.count)


class _SeriesMaker:
    """The series of a function while it is made."""

    def __init__(self, function: Operations) -> None:
        self.first: list[Row] = []
        self.constants: list[float] = []
        self.later: list[Recurrence | None] = []
        self.count = 0
        self._varies: list[bool] = []
        self._number: dict[int, float] = {}
        self._known: dict[tuple[int, int], tuple[int, int]] = {}
        for out, value in self._carry_out(function, {}):
            self.first.append((RESULT, out, value, 0))
            self.later.append(Recurrence(Kind.WRITTEN, out, value if self._varies[value] else -1))

    def _carry_out(self, function: Operations, given: dict[int, int]) -> Iterator[tuple[int, int]]:
        """Results of a function, some of whose inputs are values already, with their numbers."""
        held: dict[int, int] = {}
        for op, out, a, b in function.table.tolist():
            if op == RESULT:
                yield out, held[a]
            elif op in given:
                held[out] = given[op]
            elif op == ca.OP_CONST:
                held[out] = self._constant(function.constants[a])
            elif op in INPUTS:
                held[out] = self._input(op, a)
            else:
                held[out] = self._apply(op, held[a], held[b] if op in TWO else held[a])

    def _value(self, varies: bool, row: tuple[int, int, int] | None) -> int:
        """A new value, and the operation that gives it at order zero."""
        value = self.count
        self.count += 1
        self._varies.append(varies)
        if row is not None:
            self.first.append((row[0], value, row[1], row[2]))
        return value

    def _input(self, op: int, a: int) -> int:
        value = self._value(op in (STATE, TIME), (op, a, 0))
        if op == STATE:
            self.later.append(Recurrence(Kind.OF_STATE, value, a))
        elif op == TIME:
            self.later.append(Recurrence(Kind.OF_TIME, value))
        return value

    def _constant(self, number: float) -> int:
        self.constants.append(number)
        value = self._value(False, (ca.OP_CONST, len(self.constants) - 1, 0))
        self._number[value] = number
        return value

    def _freeze(self, op: int, a: int) -> int:
        """Something that is computed at order zero only."""
        return self._value(False, (op, a, a))

    def _then(self, kind: Kind, row: tuple[int, int, int], a: int, b: int = -1, **more: int) -> int:
        """A value that varies."""
        value = self._value(True, row)
        self.later.append(Recurrence(kind, value, a, b, **more))
        return value

    def _apply(self, op: int, a: int, b: int) -> int:
        """The result of an operation."""
        row = (op, a, b)
        first, last = self._varies[a], self._varies[b]
        if not (first or last):
            return self._value(False, row)
        if op in _ONE_LINEAR:
            return self._then(_ONE_LINEAR[op], row, a)
        if op in _LINEAR:
            if first and last:
                return self._then(_LINEAR[op], row, a, b)
            if first:
                return self._then(Kind.COPIED, row, a)
            return self._then(Kind.COPIED if op == ca.OP_ADD else Kind.NEGATIVE, row, b)
        if op == ca.OP_MUL:
            if first and last:
                return self._then(Kind.PRODUCT, row, a, b)
            return self._then(Kind.SCALED, row, a if first else b, b if first else a)
        if op == ca.OP_SQ:
            return self._then(Kind.PRODUCT, row, a, a)
        if op == ca.OP_DIV and not last:
            return self._then(Kind.SCALED, row, a, self._freeze(ca.OP_INV, b))
        if op in (ca.OP_DIV, ca.OP_INV):
            over = a if op == ca.OP_DIV and first else -1
            return self._then(Kind.QUOTIENT, row, over, b, factor=self._freeze(ca.OP_INV, b))
        if op == ca.OP_SQRT:
            return self._root(row, a)
        if op == ca.OP_HYPOT:
            return self._root(row, self._apply(ca.OP_ADD, self._square(a), self._square(b)))
        if op == ca.OP_IF_ELSE_ZERO and not first:
            return self._then(Kind.CHOSEN, row, b, a)
        if op in (ca.OP_POW, ca.OP_CONSTPOW):
            return self._power(row, a, b)
        if op in (ca.OP_SIN, ca.OP_COS):
            return self._pair(a, ca.OP_SIN, ca.OP_COS, -1)[op == ca.OP_COS]
        if op in (ca.OP_SINH, ca.OP_COSH):
            return self._pair(a, ca.OP_SINH, ca.OP_COSH, 1)[op == ca.OP_COSH]
        if op == ca.OP_ATAN2:
            return self._angle(row, a, b)
        return self._by_derivative(op, a)

    def _square(self, a: int) -> int:
        return self._apply(ca.OP_SQ, a, a)

    def _root(self, row: tuple[int, int, int], a: int) -> int:
        """A square root of a value."""
        value = self._value(True, row)
        factor = self._freeze(ca.OP_INV, self._freeze(ca.OP_TWICE, value))
        self.later.append(Recurrence(Kind.ROOT, value, a, factor=factor))
        return value

    def _pair(self, a: int, sine: int, cosine: int, sign: int) -> tuple[int, int]:
        """A sine and cosine, circular or hyperbolic; each needs the other."""
        if (sine, a) not in self._known:
            s, c = self._value(True, (sine, a, a)), self._value(True, (cosine, a, a))
            self.later.append(Recurrence(Kind.INTEGRAL, s, a, c))
            self.later.append(Recurrence(Kind.INTEGRAL, c, a, s, sign=sign))
            self._known[sine, a] = s, c
        return self._known[sine, a]

    def _power(self, row: tuple[int, int, int], a: int, b: int) -> int:
        exponent = self._number.get(b, 0.5)
        if exponent == int(exponent) and 0 < abs(exponent) <= _MOST_MULTIPLIED:
            found, left, square = -1, int(abs(exponent)), a
            while left:
                if left % 2:
                    found = square if found < 0 else self._apply(ca.OP_MUL, found, square)
                left //= 2
                square = self._square(square) if left else square
            return found if exponent > 0 else self._apply(ca.OP_INV, found, found)
        y = self._value(True, row)
        if self._varies[b]:  # y' = y (b log a)'
            through = self._apply(ca.OP_MUL, b, self._apply(ca.OP_LOG, a, a))
            self.later.append(Recurrence(Kind.INTEGRAL, y, through, y))
            return y
        place = len(self.later)
        self.later.append(None)
        g = self._apply(ca.OP_MUL, b, self._apply(ca.OP_DIV, y, a))
        self.later[place] = Recurrence(Kind.INTEGRAL, y, a, g)  # y' = b y / a a'
        return y

    def _angle(self, row: tuple[int, int, int], y: int, x: int) -> int:
        """``atan2(y, x)``, whose derivative is ``(x y' - y x') / (x^2 + y^2)``."""
        whole = self._apply(ca.OP_ADD, self._square(x), self._square(y))
        parts = []
        for through, other, sign in ((y, x, 1), (x, y, -1)):
            if self._varies[through]:
                part = self._value(True, None)
                g = self._apply(ca.OP_DIV, other, whole)
                self.later.append(Recurrence(Kind.INTEGRAL, part, through, g, sign=sign))
                parts.append(part)
        if len(parts) == 1:
            return self._then(Kind.COPIED, row, parts[0])
        return self._then(Kind.SUM, row, parts[0], parts[1])

    def _by_derivative(self, op: int, a: int) -> int:
        """A function of one value."""
        if op not in _DERIVATIVES:
            raise UnsupportedError(_NAMES.get(op, f"operation {op}"))
        y, place = self._value(True, (op, a, a)), len(self.later)
        self.later.append(None)
        ((_, g),) = self._carry_out(_derivative(op), {STATE: a, PARAMETER: y})
        sign = -1 if op == ca.OP_ACOS else 1
        self.later[place] = Recurrence(Kind.INTEGRAL, y, a, g, sign=sign)
        return y
