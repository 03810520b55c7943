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
    between = [[], parameters, [(ends[0], ends[1])], settings]
    bounds = bounds_of(function, between)[0]
    lows, highs = zip(*bounds, strict=True)
    both = ca.vertcat(*lows, *highs)
    ranges = ca.Function("range", [ends, p, inputs[2], m], [both])
    return {"forcing": function, "forcing_range": ranges}


def _timed(rates: ca.Function, inputs: list[ca.SX]) -> ca.SX:
    """Functions of the time alone of which anything else reads sums and multiples."""
    count = max(rates.sz_w(), 1)
    kinds, held = [_FIXED] * count, [ca.SX(0)] * count
    terms: list[dict[int, ca.SX]] = [{}] * count
    found: dict[int, ca.SX] = {}
    given = [ca.vertsplit(each) for each in inputs]
    for k in range(rates.n_instructions()):
        operation = rates.instruction_id(k)
        read, made = rates.instruction_input(k), rates.instruction_output(k)
        if operation == ca.OP_INPUT:
            kinds[made[0]] = {_STATES: _MOVING, _TIME: _EVEN}.get(read[0], _FIXED)
            held[made[0]], terms[made[0]] = given[read[0]][read[1]], {}
            continue
        if operation == ca.OP_CONST:
            kinds[made[0]], held[made[0]] = _FIXED, ca.SX(rates.instruction_constant(k))
            terms[made[0]] = {}
            continue
        own = [kinds[i] for i in read]
        kind = max(own)
        together = {key: term for i in read for key, term in terms[i].items()}
        if kind == _MOVING or operation == ca.OP_OUTPUT:
            found |= together
        if operation == ca.OP_OUTPUT:
            continue
        place = made[0]
        if kind != _MOVING:
            a, b = held[read[0]], held[read[-1]]
            is_two = operation in TWO
            held[place] = ca.SX.binary(operation, a, b) if is_two else ca.SX.unary(operation, a)
            if kind != _FIXED and not _is_linear(operation, own):
                kind, together = _TIMED, {held[place].element_hash(): held[place]}
        kinds[place], terms[place] = kind, {} if kind == _MOVING else together
    return ca.vertcat(ca.SX(0, 1), *found.values())


def _is_linear(operation: int, kinds: list[int]) -> bool:
    """Whether an operation gives sums and multiples of what it is given."""
    if operation in (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE):
        return True
    if operation == ca.OP_MUL:
        return min(kinds) == _FIXED
    if operation == ca.OP_DIV:
        return kinds[1] == _FIXED
    return operation == ca.OP_IF_ELSE_ZERO and kinds[0] == _FIXED
