"""Bounds of quantities over a step, and what divides it, for functionals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import casadi as ca

from lumped.code.bounds import bounds_of
from lumped.code.operations import TWO, Operations, operations_of
from lumped.compiler.system import System

__all__ = ["heights", "kinks"]


def heights(
    system: System, quantities: Sequence[ca.SX], signs: Sequence[int], states: int
) -> Operations:
    """What quantities times their signs do not exceed; their sizes where that is 0.

    `states` tells how many ranges of states are given.
    """
    pairs = zip(quantities, signs, strict=True)
    signed = [ca.fabs(each) if sign == 0 else sign * each for each, sign in pairs]
    function = ca.Function("heights", system.inputs, [ca.densify(ca.vertcat(*signed))])
    return bounds_of(operations_of(function), states, lower=False)


def kinks(system: System, quantities: Sequence[ca.SX]) -> ca.Function | None:
    """What changes its sign where quantities have kinks, or jump: (x, p, t, m); None if nothing."""
    function = ca.Function("quantities", system.inputs, [ca.densify(ca.vertcat(*quantities))])
    moving = ca.vertcat(system.inputs[0], system.inputs[2])
    given = [ca.vertsplit(each) for each in system.inputs]
    held = [ca.SX(0)] * max(function.sz_w(), 1)
    found: dict[int, ca.SX] = {}
    for k in range(function.n_instructions()):
        operation = function.instruction_id(k)
        read, made = function.instruction_input(k), function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            continue
        if operation == ca.OP_INPUT:
            held[made[0]] = given[read[0]][read[1]]
        elif operation == ca.OP_CONST:
            held[made[0]] = ca.SX(function.instruction_constant(k))
        else:
            args = [held[i] for i in read]
            if operation in _KINKS:
                own = _KINKS[operation](*args)
                if ca.depends_on(own, moving):
                    found[own.element_hash()] = own
            is_two = operation in TWO
            made_of = ca.SX.binary if is_two else ca.SX.unary
            held[made[0]] = made_of(operation, *args[: 1 + is_two])
    if not found:
        return None
    return ca.Function("kinks", system.inputs, [ca.densify(ca.vertcat(*found.values()))])


def _apart(a: ca.SX, b: ca.SX) -> ca.SX:
    return a - b


_KINKS: dict[int, Callable[..., ca.SX]] = {
    **dict.fromkeys((ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_FMIN, ca.OP_FMAX), _apart),
    **dict.fromkeys((ca.OP_FABS, ca.OP_SIGN), lambda a: a),
    **dict.fromkeys((ca.OP_FLOOR, ca.OP_CEIL), lambda a: ca.sin(math.pi * a)),
    ca.OP_FMOD: lambda a, b: ca.sin(math.pi * a / b),
    ca.OP_REMAINDER: lambda a, b: ca.cos(math.pi * a / b),
}
