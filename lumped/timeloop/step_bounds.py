"""Bounds of quantities over a step, and what divides it, for functionals."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence

import casadi as ca

from lumped.code.bounds import bounds_of
from lumped.code.operations import Operations, operations_of
from lumped.compiler.system import System
from lumped.support.follow_operations import follow_operations


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
    found: dict[int, ca.SX] = {}

    def apply(operation: int, args: list[ca.SX]) -> ca.SX:
        if operation in _KINKS:
            own = _KINKS[operation](*args)
            if ca.depends_on(own, moving):
                found[own.element_hash()] = own
        return (ca.SX.unary if len(args) == 1 else ca.SX.binary)(operation, *args)

    follow_operations(function, lambda which, place: given[which][place], ca.SX, apply)
    if not found:
        return None
    return ca.Function("kinks", system.inputs, [ca.densify(ca.vertcat(*found.values()))])


_KINKS: dict[int, Callable[..., ca.SX]] = {
    **dict.fromkeys((ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_FMIN, ca.OP_FMAX), operator.sub),
    **dict.fromkeys((ca.OP_FABS, ca.OP_SIGN), lambda a: a),
    **dict.fromkeys((ca.OP_FLOOR, ca.OP_CEIL), lambda a: ca.sin(math.pi * a)),
    ca.OP_FMOD: lambda a, b: ca.sin(math.pi * a / b),
    ca.OP_REMAINDER: lambda a, b: ca.cos(math.pi * a / b),
}
