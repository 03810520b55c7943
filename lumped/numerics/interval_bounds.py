"""Bounds of functions of scalar operations over intervals of their first argument."""

from __future__ import annotations

import math
from collections.abc import Callable

import casadi as ca

__all__ = ["INFINITE", "interval_bounds"]

Interval = tuple[ca.SX, ca.SX]
"""Lower and upper end; the same expression twice if it does not depend on the interval."""

INFINITE = 1e300
"""Ends beyond this are no bounds."""


def interval_bounds(function: ca.Function) -> ca.Function:
    """Intervals in which the results lie (Moore, Interval Analysis, 1966).

    Ends are rounded to nearest, so bounds are valid except for rounding.

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
    none = (ca.SX(0), ca.SX(0))
    held: list[Interval] = [none] * max(function.sz_w(), 1)
    results = [[none] * function.nnz_out(i) for i in range(function.n_out())]
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        given, made = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            results[made[0]][made[1]] = held[given[0]]
        elif operation == ca.OP_INPUT:
            known = None if given[0] == 0 else rest[given[0] - 1][given[1]]
            held[made[0]] = (low, high) if known is None else (known, known)
        elif operation == ca.OP_CONST:
            value = ca.SX(function.instruction_constant(k))
            held[made[0]] = (value, value)
        else:
            held[made[0]] = _applied(operation, [held[i] for i in given])
    outputs = []
    for result in results:
        for side in (0, 1):
            outputs.append(ca.vertcat(ca.SX(0, 1), *(interval[side] for interval in result)))
    return ca.Function("bounds", [low, high, *rest], outputs)


def _applied(operation: int, args: list[Interval]) -> Interval:
    if all(low is high for low, high in args):
        points = [low for low, _ in args]
        made = ca.SX.unary if len(points) == 1 else ca.SX.binary
        value = made(operation, *points)
        return value, value
    if operation in _RISING:
        found = _RISING[operation](args[0][0]), _RISING[operation](args[0][1])
    elif operation in _ONE:
        found = _ONE[operation](args[0])
    elif operation in _TWO:
        found = _TWO[operation](args[0], args[1])
    else:
        found = (ca.SX(-math.inf), ca.SX(math.inf))
    # nan, such as the difference of infinite ends, is no bound
    return ca.fmax(found[0], -1e308), ca.fmin(found[1], 1e308)


def _hull(*candidates: ca.SX) -> Interval:
    low = high = candidates[0]
    for other in candidates[1:]:
        low, high = ca.fmin(low, other), ca.fmax(high, other)
    return low, high


def _times(a: Interval, b: Interval) -> Interval:
    if a[0] is a[1] or b[0] is b[1]:
        return _hull(*(x * y for x, y in zip(a, b, strict=True)))
    return _hull(*(x * y for x in a for y in b))


def _over(a: Interval, b: Interval) -> Interval:
    if b[0] is b[1]:
        return _hull(a[0] / b[0], a[1] / b[0])
    return _times(a, _inverse(b))


def _inverse(a: Interval) -> Interval:
    inside = ca.logic_and(a[0] < 0, a[1] > 0)
    low = ca.if_else(a[1] == 0, -math.inf, 1 / a[1])
    high = ca.if_else(a[0] == 0, math.inf, 1 / a[0])
    return ca.if_else(inside, -math.inf, low), ca.if_else(inside, math.inf, high)


def _magnitude(a: Interval) -> Interval:
    inside = ca.logic_and(a[0] <= 0, a[1] >= 0)
    low, high = _hull(ca.fabs(a[0]), ca.fabs(a[1]))
    return ca.if_else(inside, 0, low), high


def _square(a: Interval) -> Interval:
    low, high = _magnitude(a)
    return low * low, high * high


def _wave(a: Interval, top: float, function: Callable[[ca.SX], ca.SX]) -> Interval:
    """Interval of a sine or cosine with maxima at `top` and every turn from there."""
    low, high = _hull(function(a[0]), function(a[1]))
    turn = 2 * math.pi
    begin, end = (a[0] - top) / turn, (a[1] - top) / turn
    crest = ca.floor(end) >= ca.ceil(begin)
    trough = ca.floor(end - 0.5) >= ca.ceil(begin - 0.5)
    return ca.if_else(trough, -1, low), ca.if_else(crest, 1, high)


def _tan(a: Interval) -> Interval:
    pole = ca.floor(a[1] / math.pi - 0.5) >= ca.ceil(a[0] / math.pi - 0.5)
    return ca.if_else(pole, -math.inf, ca.tan(a[0])), ca.if_else(pole, math.inf, ca.tan(a[1]))


def _cosh(a: Interval) -> Interval:
    low, high = _magnitude(a)
    return ca.cosh(low), ca.cosh(high)


def _power(a: Interval, b: Interval) -> Interval:
    if b[0] is not b[1]:
        log = (ca.log(ca.fmax(a[0], 0)), ca.log(ca.fmax(a[1], 0)))
        low, high = _times(b, log)
        bad = a[0] < 0
        return ca.if_else(bad, -math.inf, ca.exp(low)), ca.if_else(bad, math.inf, ca.exp(high))
    n = ca.fabs(b[0])
    even = ca.floor(n / 2) * 2 == n
    least, most = _magnitude(a)
    rising = (a[0] ** n, a[1] ** n)
    found = (ca.if_else(even, least**n, rising[0]), ca.if_else(even, most**n, rising[1]))
    over = _inverse(found)
    negative = b[0] < 0
    return ca.if_else(negative, over[0], found[0]), ca.if_else(negative, over[1], found[1])


def _atan2(y: Interval, x: Interval) -> Interval:
    low, high = _hull(*(ca.atan2(s, c) for s in y for c in x))
    around = ca.logic_and(x[0] <= 0, ca.logic_and(y[0] <= 0, y[1] >= 0))
    return ca.if_else(around, -math.pi, low), ca.if_else(around, math.pi, high)


def _truth(yes: ca.SX, no: ca.SX) -> Interval:
    """1 if a relation is certainly true, 0 if certainly false, else both."""
    return yes, 1 - no


def _less(a: Interval, b: Interval) -> Interval:
    return _truth(a[1] < b[0], a[0] >= b[1])


def _at_most(a: Interval, b: Interval) -> Interval:
    return _truth(a[1] <= b[0], a[0] > b[1])


def _equal(a: Interval, b: Interval) -> Interval:
    same = ca.logic_and(a[0] == b[1], a[1] == b[0])
    return _truth(same, ca.logic_or(a[1] < b[0], b[1] < a[0]))


def _not(a: Interval) -> Interval:
    return _truth(
        ca.logic_and(a[0] == 0, a[1] == 0),
        ca.logic_or(a[0] > 0, a[1] < 0),
    )


def _or(a: Interval, b: Interval) -> Interval:
    sure = [ca.logic_or(x[0] > 0, x[1] < 0) for x in (a, b)]
    never = [ca.logic_and(x[0] == 0, x[1] == 0) for x in (a, b)]
    return _truth(ca.logic_or(*sure), ca.logic_and(*never))


def _and(a: Interval, b: Interval) -> Interval:
    return _not(_or(_not(a), _not(b)))


def _if_else_zero(a: Interval, b: Interval) -> Interval:
    sure, never = ca.logic_or(a[0] > 0, a[1] < 0), ca.logic_and(a[0] == 0, a[1] == 0)
    low = ca.if_else(sure, b[0], ca.if_else(never, 0, ca.fmin(b[0], 0)))
    return low, ca.if_else(sure, b[1], ca.if_else(never, 0, ca.fmax(b[1], 0)))


def _clipped(x: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(x, -1), 1)


_RISING: dict[int, Callable[[ca.SX], ca.SX]] = {
    ca.OP_ASSIGN: lambda x: x,
    ca.OP_TWICE: lambda x: 2 * x,
    ca.OP_SQRT: lambda x: ca.sqrt(ca.fmax(x, 0)),
    ca.OP_EXP: ca.exp,
    ca.OP_LOG: lambda x: ca.log(ca.fmax(x, 0)),
    ca.OP_ASIN: lambda x: ca.asin(_clipped(x)),
    ca.OP_ATAN: ca.atan,
    ca.OP_SINH: ca.sinh,
    ca.OP_TANH: ca.tanh,
    ca.OP_SIGN: ca.sign,
    ca.OP_FLOOR: ca.floor,
    ca.OP_CEIL: ca.ceil,
    ca.OP_LOG1P: lambda x: ca.log1p(ca.fmax(x, -1)),
    ca.OP_EXPM1: ca.expm1,
}
_ONE: dict[int, Callable[[Interval], Interval]] = {
    ca.OP_NEG: lambda a: (-a[1], -a[0]),
    ca.OP_SQ: _square,
    ca.OP_INV: _inverse,
    ca.OP_FABS: _magnitude,
    ca.OP_SIN: lambda a: _wave(a, 0.5 * math.pi, ca.sin),
    ca.OP_COS: lambda a: _wave(a, 0.0, ca.cos),
    ca.OP_TAN: _tan,
    ca.OP_ACOS: lambda a: (ca.acos(_clipped(a[1])), ca.acos(_clipped(a[0]))),
    ca.OP_COSH: _cosh,
    ca.OP_NOT: _not,
}
_TWO: dict[int, Callable[[Interval, Interval], Interval]] = {
    ca.OP_ADD: lambda a, b: (a[0] + b[0], a[1] + b[1]),
    ca.OP_SUB: lambda a, b: (a[0] - b[1], a[1] - b[0]),
    ca.OP_MUL: _times,
    ca.OP_DIV: _over,
    ca.OP_POW: _power,
    ca.OP_CONSTPOW: _power,
    ca.OP_FMIN: lambda a, b: (ca.fmin(a[0], b[0]), ca.fmin(a[1], b[1])),
    ca.OP_FMAX: lambda a, b: (ca.fmax(a[0], b[0]), ca.fmax(a[1], b[1])),
    ca.OP_ATAN2: _atan2,
    ca.OP_LT: _less,
    ca.OP_LE: _at_most,
    ca.OP_EQ: _equal,
    ca.OP_NE: lambda a, b: _not(_equal(a, b)),
    ca.OP_AND: _and,
    ca.OP_OR: _or,
    ca.OP_IF_ELSE_ZERO: _if_else_zero,
}
