"""Operations on Taylor models: what kernels interpret on numbers, carried out on models.

Only what is certain about a comparison is used: where both sides are possible, the model is the
hull of both.
"""

from __future__ import annotations

import math

import casadi as ca

from lumped.code.words import Numbers, floor, kernel
from lumped.kernel.enclosures import model_functions, models
from lumped.kernel.enclosures.models import REST, SIZE
from lumped.kernel.interpret import operate

ROOM = 12
"""Models beside those of the work vector: a result, arguments, and what functions need."""


@kernel
def _set_truth(out: Numbers, is_sure: bool, is_never: bool) -> None:
    """1, 0, or anything between."""
    if is_sure or is_never:
        models.set_fixed(out, 1.0 if is_sure else 0.0)
    else:
        models.set_between(out, 0.0, 1.0)


@kernel
def _is_true(a: Numbers) -> bool:
    return models.low(a) > 0.0 or models.high(a) < 0.0


@kernel
def _is_false(a: Numbers) -> bool:
    return models.is_fixed(a) and a[0] == 0.0


@kernel
def _compare(op: int, a: Numbers, b: Numbers, out: Numbers, room: Numbers) -> None:
    """A comparison, the lesser or greater of two, and what is chosen by a condition."""
    models.add(a, b, -1.0, room)
    least, most = models.low(room), models.high(room)
    if least <= 0.0 and most >= 0.0:
        least, most = models.lowest(room, room[SIZE:]), models.highest(room, room[SIZE:])
    if op == ca.OP_LT:
        _set_truth(out, most < 0.0, least >= 0.0)
    elif op == ca.OP_LE:
        _set_truth(out, most <= 0.0, least > 0.0)
    elif op == ca.OP_EQ:
        _set_truth(out, least == 0.0 and most == 0.0, least > 0.0 or most < 0.0)
    elif op == ca.OP_NE:
        _set_truth(out, least > 0.0 or most < 0.0, least == 0.0 and most == 0.0)
    elif least >= 0.0 or most <= 0.0:
        is_first = most <= 0.0 if op == ca.OP_FMIN else least >= 0.0
        models.copy(a if is_first else b, out)
    elif op == ca.OP_FMIN:
        least, most = min(models.low(a), models.low(b)), min(models.high(a), models.high(b))
        models.set_between(out, least, most)
    else:
        least, most = max(models.low(a), models.low(b)), max(models.high(a), models.high(b))
        models.set_between(out, least, most)


@kernel
def _choose(op: int, a: Numbers, b: Numbers, out: Numbers) -> None:
    """A value under a condition, and conditions together."""
    if op == ca.OP_AND:
        _set_truth(out, _is_true(a) and _is_true(b), _is_false(a) or _is_false(b))
    elif op == ca.OP_OR:
        _set_truth(out, _is_true(a) or _is_true(b), _is_false(a) and _is_false(b))
    elif op == ca.OP_NOT:
        _set_truth(out, _is_false(a), _is_true(a))
    elif _is_false(a):
        models.set_fixed(out, 0.0)
    elif _is_true(a):
        models.copy(b, out)
    else:
        models.set_between(out, min(models.low(b), 0.0), max(models.high(b), 0.0))


@kernel
def _rising(op: int, least: float, most: float, out: Numbers) -> None:
    """A function that never falls, between its values at both ends of a range."""
    if op == ca.OP_ACOSH:
        least, most = max(least, 1.0), max(most, 1.0)
    elif op == ca.OP_ATANH or op == ca.OP_ASIN or op == ca.OP_ACOS:
        least, most = min(max(least, -1.0), 1.0), min(max(most, -1.0), 1.0)
    elif op == ca.OP_LOG1P:
        least, most = max(least, -1.0), max(most, -1.0)
    first, last = operate(op, least, 0.0), operate(op, most, 0.0)
    models.set_between(out, min(first, last), max(first, last))


@kernel
def _smooth(op: int, a: Numbers, out: Numbers, room: Numbers) -> None:
    """A function of one argument from those that have series."""
    first, rest = room, room[SIZE:]
    if op == ca.OP_TAN:
        model_functions.cosine_of(a, out, rest)
        model_functions.inverse_of(out, first, rest)
        model_functions.sine_of(a, rest[8 * SIZE :], rest)
        models.times(first, rest[8 * SIZE :], out)
    elif op == ca.OP_ASIN or op == ca.OP_ACOS:
        models.times(a, a, first)
        models.scale(first, -1.0, out)
        models.shift(out, 1.0)
        model_functions.root_of(out, first, rest)
        model_functions.inverse_of(first, out, rest)
        models.times(a, out, first)
        model_functions.atan_of(first, out, rest)
        if op == ca.OP_ACOS:
            models.scale(out, -1.0, out)
            models.shift(out, 0.5 * math.pi)
    elif op == ca.OP_TANH:
        models.scale(a, 2.0, first)
        model_functions.exp_of(first, out, rest)
        models.shift(out, 1.0)
        model_functions.inverse_of(out, first, rest)
        models.scale(first, -2.0, out)
        models.shift(out, 1.0)
    elif op == ca.OP_SINH or op == ca.OP_COSH:
        models.scale(a, -1.0, out)
        model_functions.exp_of(out, first, rest)
        model_functions.exp_of(a, rest[8 * SIZE :], rest)
        models.add(rest[8 * SIZE :], first, -1.0 if op == ca.OP_SINH else 1.0, out)
        models.scale(out, 0.5, out)
    elif op == ca.OP_EXPM1:
        model_functions.exp_of(a, out, rest)
        models.shift(out, -1.0)
    elif op == ca.OP_LOG1P:
        models.copy(a, first)
        models.shift(first, 1.0)
        model_functions.log_of(first, out, rest)
    else:
        models.set_between(out, -math.inf, math.inf)


@kernel
def _function(op: int, a: Numbers, b: Numbers, out: Numbers, room: Numbers) -> None:
    """Any other function."""
    least, most = models.low(a), models.high(a)
    if op == ca.OP_ASSIGN or op == ca.OP_LIFT:
        models.copy(a, out)
    elif op == ca.OP_ATAN2:
        model_functions.atan2_of(a, b, out, room)
    elif op == ca.OP_HYPOT:
        models.times(a, a, out)
        models.times(b, b, room)
        models.add(out, room, 1.0, room[SIZE:])
        model_functions.root_of(room[SIZE:], out, room[2 * SIZE :])
    elif op == ca.OP_EXP:
        model_functions.exp_of(a, out, room)
    elif op == ca.OP_LOG:
        model_functions.log_of(a, out, room)
    elif op == ca.OP_ATAN:
        model_functions.atan_of(a, out, room)
    elif op == ca.OP_SIGN or op == ca.OP_FLOOR or op == ca.OP_CEIL:
        _rising(op, models.lowest(a, room), models.highest(a, room), out)
    elif op == ca.OP_COPYSIGN:
        size = max(abs(least), abs(most))
        models.set_between(out, -size, size)
    elif op == ca.OP_FMOD or op == ca.OP_REMAINDER:
        size = min(max(abs(least), abs(most)), max(abs(models.low(b)), abs(models.high(b))))
        models.set_between(out, -size, size)
    else:
        _smooth(op, a, out, room)
        if not out[REST] < math.inf and not (op == ca.OP_TAN or op == ca.OP_COSH):
            _rising(op, least, most, out)


@kernel
def carry_out(op: int, a: Numbers, b: Numbers, out: Numbers, room: Numbers) -> None:
    """One operation."""
    if op == ca.OP_ADD or op == ca.OP_SUB:
        models.add(a, b, 1.0 if op == ca.OP_ADD else -1.0, out)
    elif op == ca.OP_MUL:
        if models.is_fixed(a):
            models.scale(b, a[0], out)
        elif models.is_fixed(b):
            models.scale(a, b[0], out)
        else:
            models.times(a, b, out)
    elif op == ca.OP_DIV:
        if models.is_fixed(b) and b[0] != 0.0:
            models.scale(a, 1.0 / b[0], out)
        else:
            model_functions.inverse_of(b, room, room[SIZE:])
            models.times(a, room, out)
    elif op == ca.OP_NEG or op == ca.OP_TWICE:
        models.scale(a, -1.0 if op == ca.OP_NEG else 2.0, out)
    elif op == ca.OP_SQ:
        models.times(a, a, out)
    elif op == ca.OP_INV:
        model_functions.inverse_of(a, out, room)
    elif op == ca.OP_SIN:
        model_functions.sine_of(a, out, room)
    elif op == ca.OP_COS:
        model_functions.cosine_of(a, out, room)
    elif op == ca.OP_SQRT:
        model_functions.root_of(a, out, room)
    elif op == ca.OP_FABS:
        least, most = models.lowest(a, room), models.highest(a, room)
        if least >= 0.0:
            models.copy(a, out)
        elif most <= 0.0:
            models.scale(a, -1.0, out)
        else:
            models.set_between(out, 0.0, max(-least, most))
    elif op == ca.OP_POW or op == ca.OP_CONSTPOW:
        if not models.is_fixed(b):
            model_functions.log_of(a, out, room)
            models.times(b, out, room)
            model_functions.exp_of(room, out, room[SIZE:])
        elif b[0] < 0.0 and floor(b[0]) == b[0]:
            model_functions.power_of(a, -b[0], room, room[SIZE:])
            model_functions.inverse_of(room, out, room[SIZE:])
        else:
            model_functions.power_of(a, b[0], out, room)
    elif op == ca.OP_AND or op == ca.OP_OR or op == ca.OP_NOT or op == ca.OP_IF_ELSE_ZERO:
        _choose(op, a, b, out)
    elif (
        op == ca.OP_LT
        or op == ca.OP_LE
        or op == ca.OP_EQ
        or op == ca.OP_NE
        or op == ca.OP_FMIN
        or op == ca.OP_FMAX
    ):
        _compare(op, a, b, out, room)
    else:
        _function(op, a, b, out, room)
