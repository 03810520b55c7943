"""Bounds of functions over intervals of their arguments, as functions of these."""

from __future__ import annotations

import casadi as ca

from lumped.code.operations import INPUTS, RESULT, STATE, TIME, TWO, OperationRows, Operations
from lumped.numerics.interval_bounds import Intervals


def bounds_of(
    function: Operations, states: int, *, lower: bool = True, upper: bool = True
) -> Operations:
    """Lower bounds of all results, then the upper ones, while states and time move.

    What it makes takes ends in place of the states: the least values of all states, then the
    greatest, then the times between which they take them.

    Parameters
    ----------
    function : Operations
    states : int
        How many states there are.
    lower, upper : bool
        Which bounds are wanted.
    """
    rows = OperationRows()
    applied, wanted = Intervals(rows).bound, [0] * lower + [1] * upper
    held = [(0, 0)] * function.work
    for op, out, a, b in zip(*function.table.T.tolist(), strict=True):
        if op == RESULT:
            ends = [held[a][k] for k in wanted]
            for number, end in enumerate(ends):
                rows.result(number * function.results + out, end)
        elif op == ca.OP_CONST:
            value = rows.constant(float(function.constants[a]))
            held[out] = (value, value)
        elif op == STATE:
            held[out] = rows.apply(STATE, a, 0), rows.apply(STATE, states + a, 0)
        elif op == TIME:
            held[out] = rows.apply(STATE, 2 * states, 0), rows.apply(STATE, 2 * states + 1, 0)
        elif op in INPUTS:
            value = rows.apply(op, a, 0)
            held[out] = (value, value)
        else:
            held[out] = applied(op, [held[a], held[b]] if op in TWO else [held[a]])
    return rows.operations(function.results * len(wanted))
