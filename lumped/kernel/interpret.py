"""Functions of a plant, evaluated in machine code or one operation after the other.

Both give the same bits. Interpreting pays for functions that are seldom evaluated, because they
need no compiling; see `lumped.timeloop.plants.executable`.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import casadi as ca

from lumped.code.operations import (
    FORMULAS,
    FUNCTIONS,
    PARAMETER,
    RESULT,
    SETTING,
    STATE,
    TIME,
)
from lumped.code.words import Numbers, call, kernel, make_kernel
from lumped.kernel.plant import Function
from lumped.kernel.run import Run


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


def _operate_source() -> str:
    """One operation after the other."""
    lines = ["def operate(op: int, a: float, b: float) -> float:"]
    for op, formula in FORMULAS.items():
        lines += [f"    if op == {op}:", f"        return {formula}"]
    return "\n".join([*lines, f"    return {math.nan}"])


operate: Callable[[int, float, float], float] = make_kernel(
    "operate", _operate_source(), {**FUNCTIONS, "nan": math.nan, "__name__": __name__}
)
"""Carry out one operation."""


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
