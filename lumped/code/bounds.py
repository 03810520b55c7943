"""Bounds of functions over intervals of their arguments, as functions of these."""

from __future__ import annotations

import math

import casadi as ca
import numpy as np

from lumped.code.operations import (
    INPUTS,
    RESULT,
    STATE,
    TIME,
    TWO,
    Operations,
    first_results,
    reuse_places,
)
from lumped.numerics.interval_bounds import Intervals

_BITS = 26
"""Of a place in a whole number that tells an operation."""
_MASK = (1 << _BITS) - 1


class _Rows:
    """Operations in the making; the same one on the same values is made once.

    An operation is one whole number, its arguments in the lower bits: what is not a container is
    not looked at by the garbage collector.
    """

    def __init__(self) -> None:
        self.rows: list[int] = []
        self.constants: list[float] = []
        self.values = 0
        self._places: dict[int, int] = {}
        self._constants: dict[tuple[float, float], int] = {}
        self._numbers: dict[int, float] = {}

    def apply(self, operation: int, *args: int) -> int:
        row = (operation << 2 * _BITS) + (args[0] << _BITS) + args[-1]
        place = self._places.get(row)
        if place is None:
            place = self._places[row] = self.values
            self.values += 1
            self.rows.append(row)
        return place

    def result(self, number: int, value: int) -> None:
        """Let a value be a result."""
        self.rows.append((RESULT << 2 * _BITS) + (value << _BITS) + number)

    def constant(self, value: float) -> int:
        key = (value, math.copysign(1.0, value))  # zeros of both signs are equal
        place = self._constants.get(key)
        if place is None:
            place = self._constants[key] = self.apply(ca.OP_CONST, len(self.constants), 0)
            self.constants.append(value)
            self._numbers[place] = value
        return place

    def read_constant(self, value: int) -> float | None:
        return self._numbers.get(value)

    def operations(self, results: int) -> Operations:
        """What was made, without what no result needs."""
        rows = np.array(self.rows, dtype=np.int64)
        op, a, b = rows >> 2 * _BITS, rows >> _BITS & _MASK, rows & _MASK
        is_result = op == RESULT
        out = np.where(is_result, b, np.cumsum(~is_result) - 1)
        table = np.column_stack([op, out, a, np.where(is_result, 0, b)])
        whole = Operations(table, np.array(self.constants), max(self.values, 1), results)
        return reuse_places(first_results(whole, results))


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
    rows = _Rows()
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
