"""Tables of the scalar operations of CasADi functions, to be interpreted or compiled."""

from __future__ import annotations

import hashlib
import math
import re
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from lumped.code import words
from lumped.code.trigonometry import cosine, sine

STATE, PARAMETER, TIME, SETTING, RESULT = range(-5, 0)
"""Operations that read an input or write a result; all others are CasADi's."""


class UnsupportedError(Exception):
    """An operation that kernels do not know."""


INPUTS = (STATE, PARAMETER, TIME, SETTING)
_NO_PLACES = frozenset((*INPUTS, ca.OP_CONST))
"""Operations that read no places of the work vector."""

FORMULAS: dict[int, str] = {
    **{getattr(ca, f"OP_{name.upper()}"): f"{name}(a)" for name in words.ONE},
    **{getattr(ca, f"OP_{name.upper()}"): f"{name}(a, b)" for name in words.TWO},
    ca.OP_MUL: "a * b",
    ca.OP_ADD: "a + b",
    ca.OP_SUB: "a - b",
    ca.OP_DIV: "a / b",
    ca.OP_NEG: "-a",
    ca.OP_SQ: "a * a",
    ca.OP_TWICE: "a + a",
    ca.OP_INV: "1.0 / a",
    ca.OP_IF_ELSE_ZERO: "b if a != 0.0 else 0.0",
    ca.OP_NOT: "1.0 if a == 0.0 else 0.0",
    ca.OP_LT: "1.0 if a < b else 0.0",
    ca.OP_LE: "1.0 if a <= b else 0.0",
    ca.OP_EQ: "1.0 if a == b else 0.0",
    ca.OP_NE: "1.0 if a != b else 0.0",
    ca.OP_AND: "1.0 if a != 0.0 and b != 0.0 else 0.0",
    ca.OP_OR: "1.0 if a != 0.0 or b != 0.0 else 0.0",
    ca.OP_SIN: "lumped_sin(a)",
    ca.OP_COS: "lumped_cos(a)",
    ca.OP_FABS: "abs(a)",
    ca.OP_ASSIGN: "a",
    ca.OP_LIFT: "a",
    ca.OP_SIGN: "-1.0 if a < 0.0 else 1.0 if a > 0.0 else a",
    ca.OP_CONSTPOW: "pow(a, b)",
}
"""What each operation of CasADi gives of its arguments, in the language of kernels.

The interpreter, C and LLVM are written from these, so all give the same bits."""

OWN: dict[str, Any] = {"lumped_sin": sine, "lumped_cos": cosine}
"""Functions in them that are kernels, by their symbols in compiled code."""
FUNCTIONS: dict[str, Any] = OWN | {name: words.Library(name) for name in words.ONE + words.TWO}
"""All functions in them that Python does not have."""

TWO = {op for op, formula in FORMULAS.items() if re.search(r"\bb\b", formula)}
"""Operations with two arguments."""


def places_read(op: int, a: int, b: int) -> tuple[int, ...]:
    """Places of the work vector that an operation reads."""
    if op in _NO_PLACES:
        return ()
    return (a, b) if op in TWO else (a,)


def split_in_parts(rows: list[list[int]], size: int) -> list[tuple[list[list[int]], set[int]]]:
    """Operations in parts of at most so many, each with the places that are still read after it.

    Inputs and constants are read anew in each part, where they are first used.
    """
    parts: list[list[list[int]]] = [[]]
    inputs: dict[int, list[int]] = {}
    known = set[int]()
    for row in rows:
        op, written, a, b = row
        if op in _NO_PLACES:
            inputs[written] = row
            known.discard(written)
            continue
        if len(parts[-1]) + 3 > size:  # an operation and its arguments
            parts.append([])
            known.clear()
        read = places_read(op, a, b)
        parts[-1] += [inputs[v] for v in dict.fromkeys(read) if v in inputs and v not in known]
        parts[-1].append(row)
        known.update(read)
        if op != RESULT:
            known.add(written)
            inputs.pop(written, None)
    held, after = set[int](), []
    for part in reversed(parts):
        after.append(set(held))
        for op, written, a, b in reversed(part):
            if op != RESULT:
                held.discard(written)
            held.update(places_read(op, a, b))
    return list(zip(parts, reversed(after), strict=True))


_BITS = 26
"""Of a place in a whole number that tells an operation."""
_MASK = (1 << _BITS) - 1


@dataclass(frozen=True, eq=False)
class Operations:
    """A function (x, p, t, m) -> results, one after the other.

    Attributes
    ----------
    table : ndarray of int64, shape (k, 4)
        Operation, place of its result, and two arguments: places in the work vector, or which
        input, constant or result.
    constants : ndarray
        Constants.
    work : int
        Length of the work vector.
    results : int
        Number of results.
    """

    table: np.ndarray
    constants: np.ndarray
    work: int
    results: int

    @cached_property
    def key(self) -> bytes:
        """Bytes that differ for different functions."""
        return hashlib.sha256(self.table.tobytes() + b"|" + self.constants.tobytes()).digest()

    def with_results_at(self, places: list[int]) -> Operations:
        """The same with each result at another place."""
        table = self.table.copy()
        own = table[:, 0] == RESULT
        table[own, 1] = np.array(places, dtype=np.int64)[table[own, 1]]
        return replace(self, table=table)


def operations_of(function: ca.Function, *, full: bool = True) -> Operations:
    """The operations of a function.

    Parameters
    ----------
    function : Function
        Of states, parameters, time and settings, made of scalar operations.
    full : bool
        Whether results of one column are written with their zeros; else only nonzeros are.

    Raises
    ------
    UnsupportedError
        If it contains other operations.
    """
    if not function.is_a("SXFunction"):
        raise UnsupportedError(f"{function.name()}: not a function of scalar operations")
    rows: list[int] = []  # one after the other: lists of tuples keep the garbage collector busy
    constants: list[float] = []
    first, targets = 0, []
    for i in range(function.n_out()):
        sparsity = function.sparsity_out(i)
        whole = full and sparsity.size2() == 1
        places = np.array(sparsity.row() if whole else range(sparsity.nnz()), dtype=int)
        count = sparsity.size1() if whole else sparsity.nnz()
        targets.append(first + places)
        for missing in np.setdiff1d(np.arange(count), places).tolist() if whole else ():
            rows += (ca.OP_CONST, 0, len(constants), 0)
            rows += (RESULT, first + missing, 0, 0)
            constants.append(0.0)
        first += count
    for k in range(function.n_instructions()):
        op, out = function.instruction_id(k), function.instruction_output(k)
        if op == ca.OP_CONST:
            rows += (op, out[0], len(constants), 0)
            constants.append(function.instruction_constant(k))
            continue
        given = function.instruction_input(k)
        if op == ca.OP_INPUT:
            rows += (INPUTS[given[0]], out[0], given[1], 0)
        elif op == ca.OP_OUTPUT:
            rows += (RESULT, int(targets[out[0]][out[1]]), given[0], 0)
        else:
            rows += (op, out[0], given[0], given[-1])
    table = np.array(rows, dtype=np.int64).reshape(-1, 4)
    return Operations(table, np.array(constants), max(function.sz_w(), 1), first)


def join_functions(first: Operations, second: Operations) -> Operations:
    """The results of one function, then those of another one with the same arguments."""
    table = second.table.copy()
    op = table[:, 0]
    reads = ~np.isin(op, INPUTS) & (op != ca.OP_CONST)
    table[op != RESULT, 1] += first.work
    table[op == RESULT, 1] += first.results
    table[op == ca.OP_CONST, 2] += len(first.constants)
    table[reads, 2] += first.work
    table[reads & (op != RESULT), 3] += first.work
    return Operations(
        np.vstack([first.table, table]),
        np.concatenate([first.constants, second.constants]),
        first.work + second.work,
        first.results + second.results,
    )


def first_results(function: Operations, count: int) -> Operations:
    """The same without operations that the first results do not need."""
    live = bytearray(function.work)
    kept = bytearray(len(function.table))
    k = len(kept)
    for op, out, a, b in zip(*function.table[::-1].T.tolist(), strict=True):
        k -= 1
        if op == RESULT:
            if out >= count:
                continue
            live[a] = 1
        elif live[out]:
            live[out] = 0
            for place in places_read(op, a, b):
                live[place] = 1
        else:
            continue
        kept[k] = 1
    table = function.table[np.frombuffer(kept, dtype=bool)]
    return Operations(table, function.constants, function.work, count)


def reuse_places(function: Operations) -> Operations:
    """The same with values in places of others that nobody reads any more.

    Each value has a place of its own before.
    """
    columns = function.table.T.tolist()
    last = [0] * function.work
    for k, (op, out, a, b) in enumerate(zip(*columns, strict=True)):
        if op != RESULT:
            last[out] = k
        for read in places_read(op, a, b):
            last[read] = k
    place, free, count = [0] * function.work, list[int](), 0
    rows: list[int] = []
    for k, (op, out, a, b) in enumerate(zip(*columns, strict=True)):
        first, second = a, b
        if op not in _NO_PLACES:
            second = b if op in TWO else a
            if last[a] == k:
                free.append(place[a])
            if second != a and last[second] == k:
                free.append(place[second])
            first = place[a]
            second = b if op == RESULT else place[second]
        to = out
        if op != RESULT:
            if not free:
                free.append(count)
                count += 1
            to = place[out] = free.pop()
        rows += (op, to, first, second)
    table = np.array(rows, dtype=np.int64).reshape(-1, 4)
    return Operations(table, function.constants, max(count, 1), function.results)


class OperationRows:
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
        """The value of an operation."""
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
        """The value that is a number."""
        key = (value, math.copysign(1.0, value))  # zeros of both signs are equal
        place = self._constants.get(key)
        if place is None:
            place = self._constants[key] = self.apply(ca.OP_CONST, len(self.constants), 0)
            self.constants.append(value)
            self._numbers[place] = value
        return place

    def read_constant(self, value: int) -> float | None:
        """The number that a value is, if it is one."""
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
