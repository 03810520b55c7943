"""What of the rates follows the time alone, as functions of a plant."""

from __future__ import annotations

import casadi as ca

from lumped.code.operations import TWO
from lumped.compiler.system import System
from lumped.numerics.interval_bounds import bounds_of

__all__ = ["forcing"]

_STATES, _TIME = 0, 2
"""Inputs of the rates."""
_FIXED, _EVEN, _TIMED, _MOVING = range(4)
"""What follows parameters and settings; the time linearly; the time; states."""
_EVEN_OPERATIONS = (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE)


def forcing(system: System) -> dict[str, ca.Function]:
    """`forcing` and `forcing_range` (see `lumped.kernel.plant`); empty if all follows states.

    What is linear in the time is left out: both ends of a step tell of it.
    """
    inputs = system.inputs
    if not ca.depends_on(system.rates, inputs[2]):
        return {}
    found = _timed(system.rhs, inputs)
    if not found.numel():
        return {}
    function = ca.Function("forcing", inputs, [found])
    _, p, _, m = inputs
    ends = ca.SX.sym("ends", 2)
    parameters, settings = ([(v, v) for v in ca.vertsplit(part)] for part in (p, m))
    bounds = bounds_of(function, [[], parameters, [tuple(ca.vertsplit(ends))], settings])[0]
    lows, highs = zip(*bounds, strict=True)
    both = ca.vertcat(*lows, *highs)
    ranges = ca.Function("range", [ends, p, inputs[2], m], [both])
    return {"forcing": function, "forcing_range": ranges}


def _timed(rates: ca.Function, inputs: list[ca.SX]) -> ca.SX:
    """Expressions of the time alone that anything else reads."""
    count = max(rates.sz_w(), 1)
    kinds, held = [_FIXED] * count, [ca.SX(0)] * count
    found: dict[int, ca.SX] = {}
    given = [ca.vertsplit(each) for each in inputs]
    for k in range(rates.n_instructions()):
        operation = rates.instruction_id(k)
        read, made = rates.instruction_input(k), rates.instruction_output(k)
        if operation == ca.OP_INPUT:
            kinds[made[0]] = {_STATES: _MOVING, _TIME: _EVEN}.get(read[0], _FIXED)
            held[made[0]] = given[read[0]][read[1]]
            continue
        if operation == ca.OP_CONST:
            kinds[made[0]], held[made[0]] = _FIXED, ca.SX(rates.instruction_constant(k))
            continue
        kind = _MOVING if operation == ca.OP_OUTPUT else _kind(operation, [kinds[i] for i in read])
        if kind == _MOVING:
            for i in read:
                if kinds[i] == _TIMED:
                    found[held[i].element_hash()] = held[i]
        if operation == ca.OP_OUTPUT:
            continue
        if kind != _MOVING:
            a, b = held[read[0]], held[read[-1]]
            is_two = operation in TWO
            value = ca.SX.binary(operation, a, b) if is_two else ca.SX.unary(operation, a)
            held[made[0]] = value
        kinds[made[0]] = kind
    return ca.vertcat(ca.SX(0, 1), *found.values())


def _kind(operation: int, kinds: list[int]) -> int:
    """Kind of what an operation gives."""
    most = max(kinds)
    if most != _EVEN:
        return most
    is_even = operation in _EVEN_OPERATIONS
    is_even |= operation == ca.OP_MUL and min(kinds) == _FIXED
    is_even |= operation == ca.OP_DIV and kinds[1] == _FIXED
    return _EVEN if is_even else _TIMED
