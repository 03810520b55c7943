"""Operations of CasADi functions, followed with values of any kind."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import casadi as ca

V = TypeVar("V")


def follow_operations(
    function: ca.Function,
    given: Callable[[int, int], V],
    constant: Callable[[float], V],
    applied: Callable[[int, list[V]], V],
) -> list[list[V]]:
    """Results of a function of scalar operations, the entries of each output.

    Parameters
    ----------
    function : Function
    given : callable
        Value of an entry of an input, from the numbers of both.
    constant : callable
        Value of a constant.
    applied : callable
        Value of an operation of CasADi on values.
    """
    held: dict[int, V] = {}
    results: list[dict[int, V]] = [{} for _ in range(function.n_out())]
    for k in range(function.n_instructions()):
        operation, read = function.instruction_id(k), function.instruction_input(k)
        made = function.instruction_output(k)
        if operation == ca.OP_OUTPUT:
            results[made[0]][made[1]] = held[read[0]]
        elif operation == ca.OP_INPUT:
            held[made[0]] = given(*read)
        elif operation == ca.OP_CONST:
            held[made[0]] = constant(function.instruction_constant(k))
        else:
            held[made[0]] = applied(operation, [held[i] for i in read])
    return [[entries[i] for i in range(len(entries))] for entries in results]
