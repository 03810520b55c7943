"""Bounds of functions of scalar operations over intervals, many intervals at once."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np

__all__ = ["Interval", "bounds"]

Interval = tuple[np.ndarray, np.ndarray]
"""Lower and upper ends, shape (n,) each."""

_ANYTHING = (np.array(-np.inf), np.array(np.inf))


def bounds(function: ca.Function, inputs: list[list[Interval]]) -> list[list[Interval]]:
    """Intervals in which the results lie (Moore, Interval Analysis, 1966).

    Ends are rounded to nearest, so bounds hold but for rounding.

    Parameters
    ----------
    function : Function
        Of scalar operations.
    inputs : list of list of Interval
        For each input, each entry.

    Returns
    -------
    list of list of Interval
        For each output, each nonzero.
    """
    held: list[Interval] = [_ANYTHING] * max(function.sz_w(), 1)
    zero = (np.zeros(1), np.zeros(1))
    results = [[zero] * function.nnz_out(i) for i in range(function.n_out())]
    with np.errstate(all="ignore"):
        for k in range(function.n_instructions()):
            operation = function.instruction_id(k)
            given, made = function.instruction_input(k), function.instruction_output(k)
            if operation == ca.OP_OUTPUT:
                results[made[0]][made[1]] = held[given[0]]
            elif operation == ca.OP_INPUT:
                held[made[0]] = inputs[given[0]][given[1]]
            elif operation == ca.OP_CONST:
                value = np.array([function.instruction_constant(k)])
                held[made[0]] = (value, value)
            else:
                low, high = _applied(operation, [held[i] for i in given])
                unknown = np.isnan(low) | np.isnan(high)
                held[made[0]] = (
                    np.where(unknown, -np.inf, low),
                    np.where(unknown, np.inf, high),
                )
    return results


def _applied(operation: int, args: list[Interval]) -> Interval:
    a = args[0]
    if operation in _RISING:
        function = _RISING[operation]
        return function(a[0]), function(a[1])
    if operation in _ONE:
        return _ONE[operation](a)
    if operation in _TWO:
        return _TWO[operation](a, args[1])
    return _ANYTHING


def _hull(*candidates: np.ndarray) -> Interval:
    low, high = candidates[0], candidates[0]
    for other in candidates[1:]:
        low, high = np.fmin(low, other), np.fmax(high, other)
    return low, high


def _times(a: Interval, b: Interval) -> Interval:
    # zero times infinity is zero: the infinite end is not reached
    return _hull(*(np.where((x == 0) | (y == 0), 0.0, x * y) for x in a for y in b))


def _inverse(a: Interval) -> Interval:
    inside = (a[0] < 0) & (a[1] > 0)
    low = np.where(a[1] == 0, -np.inf, 1.0 / a[1])
    high = np.where(a[0] == 0, np.inf, 1.0 / a[0])
    return np.where(inside, -np.inf, low), np.where(inside, np.inf, high)


def _magnitude(a: Interval) -> Interval:
    inside = (a[0] <= 0) & (a[1] >= 0)
    low, high = _hull(np.abs(a[0]), np.abs(a[1]))
    return np.where(inside, 0.0, low), high


def _square(a: Interval) -> Interval:
    low, high = _magnitude(a)
    return low * low, high * high


def _wave(a: Interval, top: float, function: Callable[[np.ndarray], np.ndarray]) -> Interval:
    """Of a sine or cosine that has its maxima at `top` and every turn from there."""
    low, high = _hull(function(a[0]), function(a[1]))
    turn = 2 * np.pi
    crest = np.floor((a[1] - top) / turn) >= np.ceil((a[0] - top) / turn)
    trough = np.floor((a[1] - top) / turn - 0.5) >= np.ceil((a[0] - top) / turn - 0.5)
    return np.where(trough, -1.0, low), np.where(crest, 1.0, high)


def _tan(a: Interval) -> Interval:
    pole = np.floor(a[1] / np.pi - 0.5) >= np.ceil(a[0] / np.pi - 0.5)
    return np.where(pole, -np.inf, np.tan(a[0])), np.where(pole, np.inf, np.tan(a[1]))


def _cosh(a: Interval) -> Interval:
    low, high = _magnitude(a)
    return np.cosh(low), np.cosh(high)


def _power(a: Interval, b: Interval) -> Interval:
    exponent = b[0]
    if (b[0] != b[1]).any() or (exponent != exponent[:1]).any():
        log = (np.log(np.fmax(a[0], 0.0)), np.log(np.fmax(a[1], 0.0)))
        low, high = _times(b, log)
        bad = a[0] < 0
        return np.where(bad, -np.inf, np.exp(low)), np.where(bad, np.inf, np.exp(high))
    n = float(exponent.flat[0])
    if n < 0:
        return _inverse(_power(a, (-b[0], -b[1])))
    if n == int(n) and n % 2 == 0:
        low, high = _magnitude(a)
        return low**n, high**n
    return np.power(a[0], n), np.power(a[1], n)


def _atan2(y: Interval, x: Interval) -> Interval:
    corners = _hull(*(np.arctan2(s, c) for s in y for c in x))
    around = (x[0] <= 0) & (y[0] <= 0) & (y[1] >= 0)
    return np.where(around, -np.pi, corners[0]), np.where(around, np.pi, corners[1])


def _truth(yes: np.ndarray, no: np.ndarray) -> Interval:
    """1 where something holds for sure, 0 where it does not, else both."""
    return yes.astype(float), 1.0 - no.astype(float)


def _less(a: Interval, b: Interval) -> Interval:
    return _truth(a[1] < b[0], a[0] >= b[1])


def _at_most(a: Interval, b: Interval) -> Interval:
    return _truth(a[1] <= b[0], a[0] > b[1])


def _equal(a: Interval, b: Interval) -> Interval:
    same = (a[0] == a[1]) & (b[0] == b[1]) & (a[0] == b[0])
    return _truth(same, (a[1] < b[0]) | (b[1] < a[0]))


def _not(a: Interval) -> Interval:
    return _truth((a[0] == 0) & (a[1] == 0), (a[0] > 0) | (a[1] < 0))


def _and(a: Interval, b: Interval) -> Interval:
    return _not(_or(_not(a), _not(b)))


def _or(a: Interval, b: Interval) -> Interval:
    yes = (a[0] > 0) | (a[1] < 0) | (b[0] > 0) | (b[1] < 0)
    no = (a[0] == 0) & (a[1] == 0) & (b[0] == 0) & (b[1] == 0)
    return _truth(yes, no)


def _if_else_zero(a: Interval, b: Interval) -> Interval:
    sure, never = (a[0] > 0) | (a[1] < 0), (a[0] == 0) & (a[1] == 0)
    low = np.where(sure, b[0], np.where(never, 0.0, np.fmin(b[0], 0.0)))
    return low, np.where(sure, b[1], np.where(never, 0.0, np.fmax(b[1], 0.0)))


_RISING: dict[int, Callable[[np.ndarray], np.ndarray]] = {
    ca.OP_ASSIGN: lambda x: x,
    ca.OP_TWICE: lambda x: 2 * x,
    ca.OP_SQRT: lambda x: np.sqrt(np.fmax(x, 0.0)),
    ca.OP_EXP: np.exp,
    ca.OP_LOG: lambda x: np.log(np.fmax(x, 0.0)),
    ca.OP_ASIN: lambda x: np.arcsin(np.clip(x, -1, 1)),
    ca.OP_ATAN: np.arctan,
    ca.OP_SINH: np.sinh,
    ca.OP_TANH: np.tanh,
    ca.OP_SIGN: np.sign,
    ca.OP_FLOOR: np.floor,
    ca.OP_CEIL: np.ceil,
    ca.OP_LOG1P: lambda x: np.log1p(np.fmax(x, -1.0)),
    ca.OP_EXPM1: np.expm1,
}
_ONE: dict[int, Callable[[Interval], Interval]] = {
    ca.OP_NEG: lambda a: (-a[1], -a[0]),
    ca.OP_SQ: _square,
    ca.OP_INV: _inverse,
    ca.OP_FABS: _magnitude,
    ca.OP_SIN: lambda a: _wave(a, 0.5 * np.pi, np.sin),
    ca.OP_COS: lambda a: _wave(a, 0.0, np.cos),
    ca.OP_TAN: _tan,
    ca.OP_ACOS: lambda a: (np.arccos(np.clip(a[1], -1, 1)), np.arccos(np.clip(a[0], -1, 1))),
    ca.OP_COSH: _cosh,
    ca.OP_NOT: _not,
}
_TWO: dict[int, Callable[[Interval, Interval], Interval]] = {
    ca.OP_ADD: lambda a, b: (a[0] + b[0], a[1] + b[1]),
    ca.OP_SUB: lambda a, b: (a[0] - b[1], a[1] - b[0]),
    ca.OP_MUL: _times,
    ca.OP_DIV: lambda a, b: _times(a, _inverse(b)),
    ca.OP_POW: _power,
    ca.OP_CONSTPOW: _power,
    ca.OP_FMIN: lambda a, b: (np.fmin(a[0], b[0]), np.fmin(a[1], b[1])),
    ca.OP_FMAX: lambda a, b: (np.fmax(a[0], b[0]), np.fmax(a[1], b[1])),
    ca.OP_ATAN2: _atan2,
    ca.OP_LT: _less,
    ca.OP_LE: _at_most,
    ca.OP_EQ: _equal,
    ca.OP_NE: lambda a, b: _not(_equal(a, b)),
    ca.OP_AND: _and,
    ca.OP_OR: _or,
    ca.OP_IF_ELSE_ZERO: _if_else_zero,
}
