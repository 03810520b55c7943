"""Kernels written out as operations: run once in Python, on the names of values.

A loop over the stages of a step and the states of one system becomes straight-line code, with the
same operations in the same order, so with the same bits.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Mapping
from typing import Any

import casadi as ca

from lumped.code.operations import (
    INPUTS,
    RESULT,
    STATE,
    TIME,
    OperationRows,
    Operations,
    places_read,
)
from lumped.code.trigonometry import near_cosine, near_sine
from lumped.code.words import Kernel


class Value:
    """A value among operations in the making."""

    __slots__ = ("_rows", "number")

    def __init__(self, rows: OperationRows, number: int) -> None:
        self._rows, self.number = rows, number

    def _apply(self, operation: int, *given: Value | float) -> Value:
        numbers = [self._number(value) for value in given]
        return Value(self._rows, self._rows.apply(operation, *numbers))

    def _number(self, value: Value | float) -> int:
        return value.number if isinstance(value, Value) else self._rows.constant(float(value))

    def __add__(self, other: Value | float) -> Value:
        return self._apply(ca.OP_ADD, self, other)

    def __radd__(self, other: float) -> Value:
        return self._apply(ca.OP_ADD, other, self)

    def __sub__(self, other: Value | float) -> Value:
        return self._apply(ca.OP_SUB, self, other)

    def __rsub__(self, other: float) -> Value:
        return self._apply(ca.OP_SUB, other, self)

    def __mul__(self, other: Value | float) -> Value:
        return self._apply(ca.OP_MUL, self, other)

    def __rmul__(self, other: float) -> Value:
        return self._apply(ca.OP_MUL, other, self)

    def __truediv__(self, other: Value | float) -> Value:
        return self._apply(ca.OP_DIV, self, other)

    def __rtruediv__(self, other: float) -> Value:
        return self._apply(ca.OP_DIV, other, self)

    def __abs__(self) -> Value:
        return self._apply(ca.OP_FABS, self)

    def sqrt(self) -> Value:
        """The square root."""
        return self._apply(ca.OP_SQRT, self)

    def fmax(self, other: Value | float) -> Value:
        """The greater of two."""
        return self._apply(ca.OP_FMAX, self, other)


class Place:
    """An array of values from one place on."""

    def __init__(self, held: dict[int, Any], first: int = 0) -> None:
        self.held, self._first = held, first

    def __getitem__(self, index: int | slice) -> Any:
        if isinstance(index, slice):
            return Place(self.held, self._first + index.start)
        return self.held[self._first + index]

    def __setitem__(self, index: int, value: Any) -> None:
        self.held[self._first + index] = value


_NEAR = {ca.OP_SIN: near_sine, ca.OP_COS: near_cosine}


class Writer:
    """Writes kernels out.

    Attributes
    ----------
    farthest : Value or float
        Size of the largest angle: the sines and cosines of far ones are wrong.
    """

    def __init__(self) -> None:
        self._rows = OperationRows()
        self._made: dict[Any, Any] = {}
        self.farthest: Value | float = 0.0

    def replace(self, kernel: Any, other: Callable[..., None]) -> None:
        """Let a function stand for a kernel."""
        self._made[kernel] = other

    def input(self, operation: int, index: int) -> Value:
        """An input."""
        return Value(self._rows, self._rows.apply(operation, index, 0))

    def inputs(self, operation: int, first: int, count: int) -> dict[int, Value]:
        """So many of them from one on, by their numbers."""
        return {i: self.input(operation, first + i) for i in range(count)}

    def written(self, kernel: Any) -> Any:
        """A kernel that runs on values."""
        found = self._made.get(kernel)
        if found is None:
            code = kernel.function.__code__
            space = {name: kernel.space.get(name) for name in code.co_names}
            space = {name: held for name, held in space.items() if held is not None}
            found = self._made[kernel] = types.FunctionType(code, space)
            for name, held in space.items():
                if isinstance(held, Kernel):
                    space[name] = self.written(held)
            space |= {name: _WORDS[name] for name in _WORDS if name in code.co_names}
        return found

    def evaluate(self, function: Operations, x: Place, t: Value, out: Place) -> None:
        """Write the results of a function."""
        held = [0] * function.work
        for op, to, a, b in function.table.tolist():
            if op == RESULT:
                out[to] = Value(self._rows, held[a])
            elif op == ca.OP_CONST:
                held[to] = self._rows.constant(float(function.constants[a]))
            elif op == STATE:
                held[to] = x[a].number
            elif op == TIME:
                held[to] = t.number
            elif op in INPUTS:
                held[to] = self._rows.apply(op, a, 0)
            elif op in _NEAR:
                angle = Value(self._rows, held[a])
                self.farthest = abs(angle).fmax(self.farthest)
                held[to] = self.written(_NEAR[op])(angle).number
            else:
                held[to] = self._rows.apply(op, *(held[place] for place in places_read(op, a, b)))

    def operations(self, results: Mapping[int, Value | float]) -> Operations:
        """What writes values at places."""
        for place, value in results.items():
            number = value.number if isinstance(value, Value) else self._rows.constant(value)
            self._rows.result(place, number)
        return self._rows.operations(max(results) + 1)


_WORDS = {"sqrt": Value.sqrt, "fmax": Value.fmax}
"""Functions of the language on values."""
