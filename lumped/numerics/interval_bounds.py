"""Bounds of scalar operations over intervals of their arguments (Moore, Interval Analysis, 1966).

Ends are rounded to nearest, so bounds are valid except for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

import casadi as ca

from lumped.support.follow_operations import follow_operations

V = TypeVar("V")

INFINITE = 1e290
"""Ends beyond this are no bounds."""
_LOWEST, _HIGHEST = -1e300, 1e300


class ValueMaker(Protocol[V]):
    """What makes values: expressions, or rows of a table."""

    def constant(self, value: float) -> V:
        """A constant."""

    def read_constant(self, value: V) -> float | None:
        """The number that a value is; None if it is no constant."""

    def apply(self, operation: int, *args: V) -> V:
        """An operation of CasADi."""


class Intervals(Generic[V]):
    """Operations on intervals (lower end, upper end); both are the same object if it is a point.

    Parameters
    ----------
    by : ValueMaker
        Makes the ends.
    """

    def __init__(self, by: ValueMaker[V]) -> None:
        self._by = by
        self._apply, self._constant = by.apply, by.constant
        self._rules: dict[int, Callable[..., tuple[V, V]]] = {
            ca.OP_NEG: self._negative,
            ca.OP_SQ: lambda a: self._even(ca.OP_SQ, a),
            ca.OP_INV: self._inverse,
            ca.OP_FABS: self._magnitude,
            ca.OP_SIN: lambda a: self._wave(ca.OP_SIN, a, 0.5 * math.pi),
            ca.OP_COS: lambda a: self._wave(ca.OP_COS, a, 0.0),
            ca.OP_TAN: self._tan,
            ca.OP_ACOS: self._acos,
            ca.OP_COSH: lambda a: self._even(ca.OP_COSH, a),
            ca.OP_NOT: self._not,
            ca.OP_ADD: self._sum,
            ca.OP_SUB: self._difference,
            ca.OP_MUL: self._times,
            ca.OP_DIV: self._over,
            ca.OP_POW: self._power,
            ca.OP_CONSTPOW: self._power,
            ca.OP_FMIN: lambda a, b: self._each(ca.OP_FMIN, a, b),
            ca.OP_FMAX: lambda a, b: self._each(ca.OP_FMAX, a, b),
            ca.OP_ATAN2: self._atan2,
            ca.OP_LT: lambda a, b: self._relation(ca.OP_LT, ca.OP_LE, a, b),
            ca.OP_LE: lambda a, b: self._relation(ca.OP_LE, ca.OP_LT, a, b),
            ca.OP_EQ: self._equal,
            ca.OP_NE: lambda a, b: self._not(self._equal(a, b)),
            ca.OP_AND: lambda a, b: self._not(self._or(self._not(a), self._not(b))),
            ca.OP_OR: self._or,
            ca.OP_IF_ELSE_ZERO: self._if_else_zero,
        }

    def bound(self, operation: int, args: list[tuple[V, V]]) -> tuple[V, V]:
        """Interval in which an operation lies."""
        if all(low is high for low, high in args):
            value = self._apply(operation, *(low for low, _ in args))
            return value, value
        if operation in _RISING:
            low, high = self._clip(args[0], *_RISING[operation])
            found = self._apply(operation, low), self._apply(operation, high)
        elif operation in self._rules:
            found = self._rules[operation](*args)
        else:
            found = self._constant(-math.inf), self._constant(math.inf)
        if operation in _CALM:
            return found
        # zero times an end that is not finite would be no bound
        return self._most(found[0], self._constant(_LOWEST)), self._least(
            found[1], self._constant(_HIGHEST)
        )

    def _least(self, a: V, b: V) -> V:
        return self._apply(ca.OP_FMIN, a, b)

    def _most(self, a: V, b: V) -> V:
        return self._apply(ca.OP_FMAX, a, b)

    def _both(self, a: V, b: V) -> V:
        return self._apply(ca.OP_AND, a, b)

    def _minus(self, a: V) -> V:
        return self._apply(ca.OP_NEG, a)

    def _choice(self, condition: V, yes: V, no: V) -> V:
        other = self._apply(ca.OP_NOT, condition)
        return self._apply(
            ca.OP_ADD,
            self._apply(ca.OP_IF_ELSE_ZERO, condition, yes),
            self._apply(ca.OP_IF_ELSE_ZERO, other, no),
        )

    def _choose(self, condition: V, yes: tuple[V, V], no: tuple[V, V]) -> tuple[V, V]:
        """One of two intervals."""
        return self._choice(condition, yes[0], no[0]), self._choice(condition, yes[1], no[1])

    def _unless(self, condition: V, least: float, most: float, a: tuple[V, V]) -> tuple[V, V]:
        """An interval, or one between two numbers if a condition holds."""
        return self._choose(condition, (self._constant(least), self._constant(most)), a)

    def _has_zero(self, a: tuple[V, V]) -> V:
        zero = self._constant(0.0)
        return self._both(self._apply(ca.OP_LE, a[0], zero), self._apply(ca.OP_LE, zero, a[1]))

    def _clip(self, a: tuple[V, V], least: float, most: float) -> tuple[V, V]:
        low, high = a
        if least > -math.inf:
            edge = self._constant(least)
            low, high = self._most(low, edge), self._most(high, edge)
        if most < math.inf:
            edge = self._constant(most)
            low, high = self._least(low, edge), self._least(high, edge)
        return low, high

    def _hull(self, *candidates: V) -> tuple[V, V]:
        low = high = candidates[0]
        for other in candidates[1:]:
            low, high = self._least(low, other), self._most(high, other)
        return low, high

    def _each(self, operation: int, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        return self._apply(operation, a[0], b[0]), self._apply(operation, a[1], b[1])

    def _negative(self, a: tuple[V, V]) -> tuple[V, V]:
        return self._minus(a[1]), self._minus(a[0])

    def _sum(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        return self._each(ca.OP_ADD, a, b)

    def _difference(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        return self._each(ca.OP_SUB, a, b[::-1])

    def _times(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        if a[0] is not a[1] and b[0] is not b[1]:
            return self._hull(*(self._apply(ca.OP_MUL, x, y) for x in a for y in b))
        ends = self._each(ca.OP_MUL, a, b)
        factor = self._by.read_constant(a[0] if a[0] is a[1] else b[0])
        if factor is None:
            return self._hull(*ends)
        return ends if factor >= 0 else ends[::-1]

    def _over(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        if b[0] is b[1]:
            return self._hull(*self._each(ca.OP_DIV, a, b))
        return self._times(a, self._inverse(b))

    def _inverse(self, a: tuple[V, V]) -> tuple[V, V]:
        """Of what may be zero only what is certain: nothing."""
        unit = self._constant(1.0)
        low, high = (self._apply(ca.OP_DIV, unit, end) for end in a[::-1])
        return self._unless(self._has_zero(a), _LOWEST, _HIGHEST, (low, high))

    def _magnitude(self, a: tuple[V, V]) -> tuple[V, V]:
        low = self._most(self._most(a[0], self._minus(a[1])), self._constant(0.0))
        return low, self._most(self._minus(a[0]), a[1])

    def _even(self, operation: int, a: tuple[V, V]) -> tuple[V, V]:
        """Interval of what rises with the magnitude."""
        low, high = self._magnitude(a)
        return self._apply(operation, low), self._apply(operation, high)

    def _acos(self, a: tuple[V, V]) -> tuple[V, V]:
        low, high = self._clip(a, -1.0, 1.0)
        return self._apply(ca.OP_ACOS, high), self._apply(ca.OP_ACOS, low)

    def _holds_whole(self, low: V, high: V) -> V:
        """Whether a whole number lies between both."""
        least = self._minus(self._apply(ca.OP_FLOOR, self._minus(low)))
        return self._apply(ca.OP_LE, least, self._apply(ca.OP_FLOOR, high))

    def _periods(self, a: tuple[V, V], begin: float, period: float) -> tuple[V, V]:
        """Both ends in periods from a begin."""
        first, length = self._constant(begin), self._constant(period)
        low, high = (self._apply(ca.OP_SUB, side, first) for side in a)
        return self._apply(ca.OP_DIV, low, length), self._apply(ca.OP_DIV, high, length)

    def _wave(self, operation: int, a: tuple[V, V], top: float) -> tuple[V, V]:
        """Interval of a sine or cosine with maxima at `top` and every turn from there."""
        low, high = self._hull(self._apply(operation, a[0]), self._apply(operation, a[1]))
        crest = self._holds_whole(*self._periods(a, top, 2 * math.pi))
        trough = self._holds_whole(*self._periods(a, top + math.pi, 2 * math.pi))
        return (
            self._choice(trough, self._constant(-1.0), low),
            self._choice(crest, self._constant(1.0), high),
        )

    def _tan(self, a: tuple[V, V]) -> tuple[V, V]:
        pole = self._holds_whole(*self._periods(a, 0.5 * math.pi, math.pi))
        low, high = (self._apply(ca.OP_TAN, end) for end in a)
        return self._unless(pole, -math.inf, math.inf, (low, high))

    def _power(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        if b[0] is not b[1]:
            return self._power_that_moves(a, b)
        exponent = self._by.read_constant(b[0])
        n = self._apply(ca.OP_FABS, b[0])
        least, most = (self._apply(ca.OP_POW, end, n) for end in self._magnitude(a))
        low, high = (self._apply(ca.OP_POW, end, n) for end in a)
        half = self._apply(ca.OP_FLOOR, self._apply(ca.OP_DIV, n, self._constant(2.0)))
        even = self._apply(ca.OP_EQ, self._apply(ca.OP_TWICE, half), n)
        found = self._choose(even, (least, most), (low, high))
        if exponent is not None and exponent >= 0:
            return found
        negative = self._apply(ca.OP_LT, b[0], self._constant(0.0))
        return self._choose(negative, self._inverse(found), found)

    def _power_that_moves(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        low, high = self._clip(a, 0.0, math.inf)
        log = self._apply(ca.OP_LOG, low), self._apply(ca.OP_LOG, high)
        low, high = (self._apply(ca.OP_EXP, end) for end in self._times(b, log))
        bad = self._apply(ca.OP_LT, a[0], self._constant(0.0))
        return self._unless(bad, -math.inf, math.inf, (low, high))

    def _atan2(self, y: tuple[V, V], x: tuple[V, V]) -> tuple[V, V]:
        low, high = self._hull(*(self._apply(ca.OP_ATAN2, s, c) for s in y for c in x))
        left = self._apply(ca.OP_LE, x[0], self._constant(0.0))
        around = self._both(left, self._has_zero(y))
        return self._unless(around, -math.pi, math.pi, (low, high))

    def _truth(self, yes: V, no: V) -> tuple[V, V]:
        """1 if a relation is certainly true, 0 if certainly false, else both."""
        return yes, self._apply(ca.OP_NOT, no)

    def _relation(self, holds: int, opposite: int, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        return self._truth(self._apply(holds, a[1], b[0]), self._apply(opposite, b[1], a[0]))

    def _equal(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        same = self._both(self._apply(ca.OP_EQ, a[0], b[1]), self._apply(ca.OP_EQ, a[1], b[0]))
        apart = self._apply(
            ca.OP_OR, self._apply(ca.OP_LT, a[1], b[0]), self._apply(ca.OP_LT, b[1], a[0])
        )
        return self._truth(same, apart)

    def _is_surely_true(self, a: tuple[V, V]) -> V:
        zero = self._constant(0.0)
        return self._apply(
            ca.OP_OR, self._apply(ca.OP_LT, zero, a[0]), self._apply(ca.OP_LT, a[1], zero)
        )

    def _is_surely_false(self, a: tuple[V, V]) -> V:
        zero = self._constant(0.0)
        return self._both(self._apply(ca.OP_EQ, a[0], zero), self._apply(ca.OP_EQ, a[1], zero))

    def _not(self, a: tuple[V, V]) -> tuple[V, V]:
        return self._truth(self._is_surely_false(a), self._is_surely_true(a))

    def _or(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        return self._truth(
            self._apply(ca.OP_OR, self._is_surely_true(a), self._is_surely_true(b)),
            self._both(self._is_surely_false(a), self._is_surely_false(b)),
        )

    def _if_else_zero(self, a: tuple[V, V], b: tuple[V, V]) -> tuple[V, V]:
        if a[0] is a[1]:
            return self._each(ca.OP_IF_ELSE_ZERO, a, b)
        sure, never, zero = self._is_surely_true(a), self._is_surely_false(a), self._constant(0.0)
        low = self._choice(never, zero, self._least(b[0], zero))
        high = self._choice(never, zero, self._most(b[1], zero))
        return self._choose(sure, b, (low, high))


_ALL = (-math.inf, math.inf)
_RISING = {
    **dict.fromkeys((ca.OP_ASSIGN, ca.OP_TWICE, ca.OP_EXP, ca.OP_ATAN, ca.OP_SINH), _ALL),
    **dict.fromkeys((ca.OP_TANH, ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL, ca.OP_EXPM1), _ALL),
    ca.OP_SQRT: (0.0, math.inf),
    ca.OP_LOG: (0.0, math.inf),
    ca.OP_LOG1P: (-1.0, math.inf),
    ca.OP_ASIN: (-1.0, 1.0),
}
"""Operations that rise with their argument, and where they are defined."""
_CALM = {
    *(ca.OP_ASSIGN, ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_MUL, ca.OP_TWICE, ca.OP_SQ, ca.OP_FABS),
    *(ca.OP_FMIN, ca.OP_FMAX, ca.OP_SIN, ca.OP_COS, ca.OP_ATAN, ca.OP_ATAN2, ca.OP_TANH),
    *(ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL),
    *(ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_NOT, ca.OP_IF_ELSE_ZERO),
}
"""Operations that give finite numbers of finite ones."""


class _Expressions:
    """Values as CasADi expressions."""

    # many times faster than the operators of CasADi's matrices
    @staticmethod
    def apply(operation: int, *args: ca.SX) -> ca.SX:
        return ca.SX.unary(operation, *args) if len(args) == 1 else ca.SX.binary(operation, *args)

    @staticmethod
    def constant(value: float) -> ca.SX:
        return ca.SX(value)

    @staticmethod
    def read_constant(value: ca.SX) -> float | None:
        return float(value) if value.is_constant() else None


def interval_bounds(function: ca.Function) -> ca.Function:
    """Intervals in which the results lie while the first input moves.

    Parameters
    ----------
    function : Function
        Of scalar operations, with a number as first input.

    Returns
    -------
    Function
        (lower end, upper end, other inputs) -> (lower ends, upper ends) of each result.
    """
    low, high = ca.SX.sym("low"), ca.SX.sym("high")
    rest = [ca.SX.sym(f"i{i}", function.nnz_in(i)) for i in range(1, function.n_in())]

    def read_input(which: int, place: int) -> tuple[ca.SX, ca.SX]:
        return (rest[which - 1].nz[place],) * 2 if which else (low, high)

    applied = Intervals(_Expressions()).bound
    results = follow_operations(function, read_input, lambda value: (ca.SX(value),) * 2, applied)
    outputs = [
        ca.vertcat(ca.SX(0, 1), *side) for ends in results for side in zip(*ends, strict=True)
    ]
    return ca.Function("bounds", [low, high, *rest], outputs)
