"""Bounds of functions of scalar operations over intervals of their arguments."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import casadi as ca

__all__ = ["INFINITE", "Interval", "bounds_of", "interval_bounds"]

Interval = tuple[ca.SX, ca.SX]
"""Lower and upper end; the same expression twice if it does not depend on the interval."""

INFINITE = 1e290
"""Ends beyond this are no bounds."""
_LOWEST, _HIGHEST = ca.SX(-1e300), ca.SX(1e300)


_ZERO, _HALF, _UNIT, _TURN = (ca.SX(v) for v in (0.0, 0.5, 1.0, 2 * math.pi))


def _by(operation: int) -> Callable[[ca.SX, ca.SX], ca.SX]:
    """An operation on two scalars, many times faster than the operators of CasADi's matrices."""
    return lambda a, b: ca.SX.binary(operation, a, b)


_sum, _difference, _product, _quotient = map(_by, (ca.OP_ADD, ca.OP_SUB, ca.OP_MUL, ca.OP_DIV))
_least, _most, _both = map(_by, (ca.OP_FMIN, ca.OP_FMAX, ca.OP_AND))
_is_at_most, _if = map(_by, (ca.OP_LE, ca.OP_IF_ELSE_ZERO))


def _unary(operation: int) -> Callable[[ca.SX], ca.SX]:
    return lambda a: ca.SX.unary(operation, a)


_negative, _floor, _no = map(_unary, (ca.OP_NEG, ca.OP_FLOOR, ca.OP_NOT))


def _choice(condition: ca.SX, yes: ca.SX, no: ca.SX) -> ca.SX:
    return _sum(_if(condition, yes), _if(_no(condition), no))


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
    points = [[(known, known) for known in ca.vertsplit(each)] for each in rest]
    found = bounds_of(function, [[(low, high)], *points])
    outputs = [ca.vertcat(ca.SX(0, 1), *side) for ends in found for side in zip(*ends, strict=True)]
    return ca.Function("bounds", [low, high, *rest], outputs)


def bounds_of(function: ca.Function, inputs: Sequence[Sequence[Interval]]) -> list[list[Interval]]:
    """Intervals in which the results lie (Moore, Interval Analysis, 1966).

    Ends are rounded to nearest, so bounds are valid except for rounding.

    Parameters
    ----------
    function : Function
        Of scalar operations.
    inputs : sequence of sequence of (SX, SX)
        Ends of each nonzero of each input; the same expression twice if it does not move.
    """
    none = (ca.SX(0), ca.SX(0))
    held: list[Interval] = [none] * max(function.sz_w(), 1)
    results = [[none] * function.nnz_out(i) for i in range(function.n_out())]
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        given, made = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            results[made[0]][made[1]] = held[given[0]]
        elif operation == ca.OP_INPUT:
            held[made[0]] = inputs[given[0]][given[1]]
        elif operation == ca.OP_CONST:
            value = ca.SX(function.instruction_constant(k))
            held[made[0]] = (value, value)
        else:
            held[made[0]] = _applied(operation, [held[i] for i in given])
    return results


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
    if operation in _CALM:
        return found
    # zero times an end that is not finite would be no bound
    return _most(found[0], _LOWEST), _least(found[1], _HIGHEST)


def _hull(*candidates: ca.SX) -> Interval:
    low = high = candidates[0]
    for other in candidates[1:]:
        low, high = _least(low, other), _most(high, other)
    return low, high


def _times(a: Interval, b: Interval) -> Interval:
    for fixed, other in ((a, b), (b, a)):
        if fixed[0] is fixed[1] and fixed[0].is_constant():
            ends = _product(fixed[0], other[0]), _product(fixed[0], other[1])
            return ends if float(fixed[0]) >= 0 else (ends[1], ends[0])
    if a[0] is a[1] or b[0] is b[1]:
        return _hull(*(_product(x, y) for x, y in zip(a, b, strict=True)))
    return _hull(*(_product(x, y) for x in a for y in b))


def _over(a: Interval, b: Interval) -> Interval:
    if b[0] is b[1]:
        return _hull(_quotient(a[0], b[0]), _quotient(a[1], b[0]))
    return _times(a, _inverse(b))


def _inverse(a: Interval) -> Interval:
    """Of what may be zero only what is certain: nothing."""
    inside = _both(_is_at_most(a[0], _ZERO), _is_at_most(_ZERO, a[1]))
    low, high = (_quotient(_UNIT, end) for end in a[::-1])
    return _choice(inside, _LOWEST, low), _choice(inside, _HIGHEST, high)


def _magnitude(a: Interval) -> Interval:
    low = _most(_most(a[0], _negative(a[1])), _ZERO)
    return low, _most(_negative(a[0]), a[1])


def _square(a: Interval) -> Interval:
    low, high = _magnitude(a)
    return ca.SX.unary(ca.OP_SQ, low), ca.SX.unary(ca.OP_SQ, high)


def _wave(a: Interval, top: float, function: Callable[[ca.SX], ca.SX]) -> Interval:
    """Interval of a sine or cosine with maxima at `top` and every turn from there."""
    low, high = _hull(function(a[0]), function(a[1]))
    begin, end = (_quotient(_difference(side, ca.SX(top)), _TURN) for side in a)
    # a whole number lies between both
    crest = _is_at_most(_negative(_floor(_negative(begin))), _floor(end))
    begin, end = _difference(begin, _HALF), _difference(end, _HALF)
    trough = _is_at_most(_negative(_floor(_negative(begin))), _floor(end))
    return _choice(trough, ca.SX(-1.0), low), _choice(crest, _UNIT, high)


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
    if a[0] is a[1]:
        return _if(a[0], b[0]), _if(a[0], b[1])
    sure, never = ca.logic_or(a[0] > 0, a[1] < 0), ca.logic_and(a[0] == 0, a[1] == 0)
    low = ca.if_else(sure, b[0], ca.if_else(never, 0, ca.fmin(b[0], 0)))
    return low, ca.if_else(sure, b[1], ca.if_else(never, 0, ca.fmax(b[1], 0)))


def _clipped(x: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(x, -1), 1)


_RISING: dict[int, Callable[[ca.SX], ca.SX]] = {
    ca.OP_ASSIGN: lambda x: x,
    ca.OP_TWICE: _unary(ca.OP_TWICE),
    ca.OP_SQRT: lambda x: ca.SX.unary(ca.OP_SQRT, _most(x, _ZERO)),
    ca.OP_EXP: _unary(ca.OP_EXP),
    ca.OP_LOG: lambda x: ca.log(ca.fmax(x, 0)),
    ca.OP_ASIN: lambda x: ca.asin(_clipped(x)),
    ca.OP_ATAN: _unary(ca.OP_ATAN),
    ca.OP_SINH: ca.sinh,
    ca.OP_TANH: _unary(ca.OP_TANH),
    ca.OP_SIGN: ca.sign,
    ca.OP_FLOOR: ca.floor,
    ca.OP_CEIL: ca.ceil,
    ca.OP_LOG1P: lambda x: ca.log1p(ca.fmax(x, -1)),
    ca.OP_EXPM1: ca.expm1,
}
_ONE: dict[int, Callable[[Interval], Interval]] = {
    ca.OP_NEG: lambda a: (_negative(a[1]), _negative(a[0])),
    ca.OP_SQ: _square,
    ca.OP_INV: _inverse,
    ca.OP_FABS: _magnitude,
    ca.OP_SIN: lambda a: _wave(a, 0.5 * math.pi, _unary(ca.OP_SIN)),
    ca.OP_COS: lambda a: _wave(a, 0.0, _unary(ca.OP_COS)),
    ca.OP_TAN: _tan,
    ca.OP_ACOS: lambda a: (ca.acos(_clipped(a[1])), ca.acos(_clipped(a[0]))),
    ca.OP_COSH: _cosh,
    ca.OP_NOT: _not,
}
_TWO: dict[int, Callable[[Interval, Interval], Interval]] = {
    ca.OP_ADD: lambda a, b: (_sum(a[0], b[0]), _sum(a[1], b[1])),
    ca.OP_SUB: lambda a, b: (_difference(a[0], b[1]), _difference(a[1], b[0])),
    ca.OP_MUL: _times,
    ca.OP_DIV: _over,
    ca.OP_POW: _power,
    ca.OP_CONSTPOW: _power,
    ca.OP_FMIN: lambda a, b: (_least(a[0], b[0]), _least(a[1], b[1])),
    ca.OP_FMAX: lambda a, b: (_most(a[0], b[0]), _most(a[1], b[1])),
    ca.OP_ATAN2: _atan2,
    ca.OP_LT: _less,
    ca.OP_LE: _at_most,
    ca.OP_EQ: _equal,
    ca.OP_NE: lambda a, b: _not(_equal(a, b)),
    ca.OP_AND: _and,
    ca.OP_OR: _or,
    ca.OP_IF_ELSE_ZERO: _if_else_zero,
}
_CALM = {
    *(ca.OP_ASSIGN, ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_MUL, ca.OP_TWICE, ca.OP_SQ, ca.OP_FABS),
    *(
        ca.OP_FMIN,
        ca.OP_FMAX,
        ca.OP_SIN,
        ca.OP_COS,
        ca.OP_ATAN,
        ca.OP_ATAN2,
        ca.OP_TANH,
        ca.OP_SIGN,
    ),
    *(ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_NOT, ca.OP_IF_ELSE_ZERO),
}
"""Operations that give finite numbers of finite ones."""
