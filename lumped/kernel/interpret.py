"""Functions of a plant, evaluated in machine code or one operation after the other.

Both give the same bits. Interpreting pays for functions that are seldom evaluated, because they
need no compiling; see `lumped.timeloop.executable`.
"""

from __future__ import annotations

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

__all__ = ["evaluate", "prepare"]


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
        elif op == ca.OP_NEG:
            w[to] = -w[a]
        elif op == ca.OP_SQ:
            w[to] = w[a] * w[a]
        elif op == ca.OP_TWICE:
            w[to] = w[a] + w[a]
        elif op == ca.OP_INV:
            w[to] = 1.0 / w[a]
        elif op == ca.OP_IF_ELSE_ZERO:
            w[to] = w[b] if w[a] != 0.0 else 0.0
        elif op == ca.OP_NOT:
            w[to] = 1.0 if w[a] == 0.0 else 0.0
        elif op == ca.OP_LT:
            w[to] = 1.0 if w[a] < w[b] else 0.0
        elif op == ca.OP_LE:
            w[to] = 1.0 if w[a] <= w[b] else 0.0
        elif op == ca.OP_EQ:
            w[to] = 1.0 if w[a] == w[b] else 0.0
        elif op == ca.OP_NE:
            w[to] = 1.0 if w[a] != w[b] else 0.0
        elif op == ca.OP_AND:
            w[to] = 1.0 if w[a] != 0.0 and w[b] != 0.0 else 0.0
        elif op == ca.OP_OR:
            w[to] = 1.0 if w[a] != 0.0 or w[b] != 0.0 else 0.0
        elif op == ca.OP_SIN:
            w[to] = sine(w[a])
        elif op == ca.OP_COS:
            w[to] = cosine(w[a])
        elif op == ca.OP_SQRT:
            w[to] = sqrt(w[a])
        elif op == ca.OP_FABS:
            w[to] = abs(w[a])
        elif op == ca.OP_SIGN:
            value = w[a]
            w[to] = -1.0 if value < 0.0 else 1.0 if value > 0.0 else value
        elif op == ca.OP_FMIN:
            w[to] = fmin(w[a], w[b])
        elif op == ca.OP_FMAX:
            w[to] = fmax(w[a], w[b])
        elif op == ca.OP_POW or op == ca.OP_CONSTPOW:
            w[to] = power(w[a], w[b])
        elif op == ca.OP_ASSIGN or op == ca.OP_LIFT:
            w[to] = w[a]
        elif op == ca.OP_TAN:
            w[to] = tan(w[a])
        elif op == ca.OP_ASIN:
            w[to] = asin(w[a])
        elif op == ca.OP_ACOS:
            w[to] = acos(w[a])
        elif op == ca.OP_ATAN:
            w[to] = atan(w[a])
        elif op == ca.OP_ATAN2:
            w[to] = atan2(w[a], w[b])
        elif op == ca.OP_TANH:
            w[to] = tanh(w[a])
        elif op == ca.OP_SINH:
            w[to] = sinh(w[a])
        elif op == ca.OP_COSH:
            w[to] = cosh(w[a])
        elif op == ca.OP_ASINH:
            w[to] = asinh(w[a])
        elif op == ca.OP_ACOSH:
            w[to] = acosh(w[a])
        elif op == ca.OP_ATANH:
            w[to] = atanh(w[a])
        elif op == ca.OP_EXP:
            w[to] = exp(w[a])
        elif op == ca.OP_EXPM1:
            w[to] = expm1(w[a])
        elif op == ca.OP_LOG:
            w[to] = log(w[a])
        elif op == ca.OP_LOG1P:
            w[to] = log1p(w[a])
        elif op == ca.OP_ERF:
            w[to] = erf(w[a])
        elif op == ca.OP_FLOOR:
            w[to] = floor(w[a])
        elif op == ca.OP_CEIL:
            w[to] = ceil(w[a])
        elif op == ca.OP_HYPOT:
            w[to] = hypot(w[a], w[b])
        elif op == ca.OP_FMOD:
            w[to] = fmod(w[a], w[b])
        elif op == ca.OP_REMAINDER:
            w[to] = remainder(w[a], w[b])
        elif op == ca.OP_COPYSIGN:
            w[to] = copysign(w[a], w[b])
