"""Functions of a plant, evaluated in machine code or one operation after the other.

Both give the same bits. Interpreting pays for functions that are seldom evaluated, because they
need no compiling; see `lumped.timeloop.executable`.
"""

from __future__ import annotations

import math

import casadi as ca

from lumped.code.operations import PARAMETER, RESULT, SETTING, STATE, TIME
from lumped.code.trigonometry import cosine, sine
from lumped.code.words import (
    Numbers,
    acos,
    acosh,
    asin,
    asinh,
    atan,
    atan2,
    atanh,
    call,
    ceil,
    copysign,
    cosh,
    erf,
    exp,
    expm1,
    floor,
    fmax,
    fmin,
    fmod,
    hypot,
    kernel,
    log,
    log1p,
    power,
    remainder,
    sinh,
    sqrt,
    tan,
    tanh,
)
from lumped.kernel.plant import Function
from lumped.kernel.run import Run

__all__ = ["evaluate", "operate", "prepare"]


@kernel
def evaluate(function: Function, run: Run, x: Numbers, t: float, m: Numbers, out: Numbers) -> None:
    """Write the results of a function at a point."""
    if function.address != 0:
        call(function.address, x, run.p, t, m, out)
    else:
        _interpret(function, run.work, x, run.p, t, m, out)
        run.interpreted += function.count


@kernel
def prepare(run: Run) -> None:
    """Compute what functions need of parameters alone."""
    plant = run.plant
    if plant.prepared > 0:
        evaluate(plant.prepare, run, run.x, run.t, run.m, run.p[plant.parameters :])


@kernel
def operate(op: int, a: float, b: float) -> float:
    """Carry out one operation."""
    if op == ca.OP_MUL:
        return a * b
    if op == ca.OP_ADD:
        return a + b
    if op == ca.OP_SUB:
        return a - b
    if op == ca.OP_DIV:
        return a / b
    if op == ca.OP_NEG:
        return -a
    if op == ca.OP_SQ:
        return a * a
    if op == ca.OP_TWICE:
        return a + a
    if op == ca.OP_INV:
        return 1.0 / a
    if op == ca.OP_IF_ELSE_ZERO:
        return b if a != 0.0 else 0.0
    if op == ca.OP_NOT:
        return 1.0 if a == 0.0 else 0.0
    if op == ca.OP_LT:
        return 1.0 if a < b else 0.0
    if op == ca.OP_LE:
        return 1.0 if a <= b else 0.0
    if op == ca.OP_EQ:
        return 1.0 if a == b else 0.0
    if op == ca.OP_NE:
        return 1.0 if a != b else 0.0
    if op == ca.OP_AND:
        return 1.0 if a != 0.0 and b != 0.0 else 0.0
    if op == ca.OP_OR:
        return 1.0 if a != 0.0 or b != 0.0 else 0.0
    if op == ca.OP_SIN:
        return sine(a)
    if op == ca.OP_COS:
        return cosine(a)
    if op == ca.OP_SQRT:
        return sqrt(a)
    if op == ca.OP_FABS:
        return abs(a)
    if op == ca.OP_FMIN:
        return fmin(a, b)
    if op == ca.OP_FMAX:
        return fmax(a, b)
    if op == ca.OP_POW or op == ca.OP_CONSTPOW:
        return power(a, b)
    if op == ca.OP_ASSIGN or op == ca.OP_LIFT:
        return a
    if op == ca.OP_SIGN:
        return -1.0 if a < 0.0 else 1.0 if a > 0.0 else a
    if op == ca.OP_TAN:
        return tan(a)
    if op == ca.OP_ASIN:
        return asin(a)
    if op == ca.OP_ACOS:
        return acos(a)
    if op == ca.OP_ATAN:
        return atan(a)
    if op == ca.OP_ATAN2:
        return atan2(a, b)
    if op == ca.OP_TANH:
        return tanh(a)
    if op == ca.OP_SINH:
        return sinh(a)
    if op == ca.OP_COSH:
        return cosh(a)
    if op == ca.OP_ASINH:
        return asinh(a)
    if op == ca.OP_ACOSH:
        return acosh(a)
    if op == ca.OP_ATANH:
        return atanh(a)
    if op == ca.OP_EXP:
        return exp(a)
    if op == ca.OP_EXPM1:
        return expm1(a)
    if op == ca.OP_LOG:
        return log(a)
    if op == ca.OP_LOG1P:
        return log1p(a)
    if op == ca.OP_ERF:
        return erf(a)
    if op == ca.OP_FLOOR:
        return floor(a)
    if op == ca.OP_CEIL:
        return ceil(a)
    if op == ca.OP_HYPOT:
        return hypot(a, b)
    if op == ca.OP_FMOD:
        return fmod(a, b)
    if op == ca.OP_REMAINDER:
        return remainder(a, b)
    if op == ca.OP_COPYSIGN:
        return copysign(a, b)
    return math.nan


@kernel
def _interpret(
    function: Function, w: Numbers, x: Numbers, p: Numbers, t: float, m: Numbers, out: Numbers
) -> None:
    constants = function.constants
    for k in range(function.count):
        operation = function.operations[4 * k :]
        op, to, a, b = operation[0], operation[1], operation[2], operation[3]
        if op == ca.OP_MUL:
            w[to] = w[a] * w[b]
        elif op == ca.OP_ADD:
            w[to] = w[a] + w[b]
        elif op == ca.OP_SUB:
            w[to] = w[a] - w[b]
        elif op == ca.OP_DIV:
            w[to] = w[a] / w[b]
        elif op == STATE:
            w[to] = x[a]
        elif op == PARAMETER:
            w[to] = p[a]
        elif op == SETTING:
            w[to] = m[a]
        elif op == RESULT:
            out[to] = w[a]
        elif op == ca.OP_CONST:
            w[to] = constants[a]
        elif op == TIME:
            w[to] = t
        else:
            w[to] = operate(op, w[a], w[b])
