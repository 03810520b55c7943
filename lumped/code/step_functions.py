"""Parts of a function that are steps over one of its numbers, to be looked up.

A table whose piece is chosen by comparisons costs some ten operations for each piece. All that
follows from comparisons of one number with constants is constant between these constants.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lumped.code.operations import RESULT, SETTING, Operations, first_results, places_read

Real: TypeAlias = NDArray[np.float64]

_WORTH = 8
"""Comparisons of one number from which it is looked up."""
_JUMPS = {ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL}
"""Operations whose results stay the same but for jumps."""
_SAME: dict[int, Callable[..., Real]] = {
    ca.OP_ADD: np.add,
    ca.OP_SUB: np.subtract,
    ca.OP_MUL: np.multiply,
    ca.OP_NEG: np.negative,
    ca.OP_NOT: np.logical_not,
    ca.OP_TWICE: lambda x: x + x,
    ca.OP_IF_ELSE_ZERO: lambda c, x: np.where(c != 0, x, 0.0),
}
"""Operations that are made with all values of a step function at once."""


class _Steps(NamedTuple):
    """A number that is constant between constants with which number `of` is compared."""

    of: int
    values: Real


class TabulatedSteps(NamedTuple):
    """A function whose step functions are settings.

    Attributes
    ----------
    arguments : Operations
        The same inputs -> numbers that are compared, shape (a,).
    constants : tuple of ndarray
        What each of them is compared with, ascending.
    values : tuple of ndarray, shapes (constants + 1, steps)
        Step functions of each, below the first constant, from the first on, and so forth.
    rest : Operations
        The inputs with these step functions, one after the other, as further settings -> results.
    """

    arguments: Operations
    constants: tuple[Real, ...]
    values: tuple[Real, ...]
    rest: Operations

    def settings(self, arguments: Real) -> Real:
        """Step functions at points, shape (points, steps); of no number they are the first."""
        found = []
        for argument, constants, values in zip(
            arguments.T, self.constants, self.values, strict=True
        ):
            piece = np.searchsorted(constants, argument, side="right")
            found.append(values[np.where(np.isnan(argument), 0, piece)])
        return np.hstack(found)


class PieceNumbers(NamedTuple):
    """Numbers that stay the same in each smooth piece of a function.

    Attributes
    ----------
    arguments : Operations
        The same inputs -> what tells the pieces, shape (a,).
    constants : tuple of ndarray
        With what each of them is compared, ascending; of none, it is a number of a piece itself.
    """

    arguments: Operations
    constants: tuple[Real, ...]

    def settings(self, arguments: Real) -> Real:
        """Numbers of the pieces at points, shape (points, a)."""
        found = arguments.copy()
        for column, constants in zip(found.T, self.constants, strict=True):
            if len(constants):
                column[:] = np.searchsorted(constants, column, side="right")
        return found


def number_pieces(operations: Operations) -> PieceNumbers:
    """What tells the smooth pieces of a function apart."""
    table = operations.table
    given = _find_sources(table)
    found = _find_constants(operations, given, 1)
    for row, op in enumerate(table[:, 0].tolist()):
        if op == ca.OP_FABS:
            found[given[row][0]] = np.union1d(found.get(given[row][0], []), 0.0)
        elif op in _JUMPS and not (op == ca.OP_LE and given[row][1] in found):
            found[row] = np.zeros(0)
    return PieceNumbers(_at_rows(operations, list(found)), tuple(found.values()))


def tabulate_steps(operations: Operations, settings: int) -> TabulatedSteps | None:
    """A function with its step functions apart; None if it has none worth it.

    Results have the same bits: values of step functions are made by the same operations.

    Parameters
    ----------
    operations : Operations
        The function.
    settings : int
        How many settings it has.
    """
    table = operations.table
    given = _find_sources(table)
    compared = _find_constants(operations, given)
    if not compared:
        return None
    steps = _steps(operations, given, compared)
    used: dict[int, list[int]] = {number: [] for number in compared}
    for row in range(len(table)):
        for source in given[row] if row not in steps else ():
            own = steps.get(source)
            if own is not None and own.of >= 0 and source not in used[own.of]:
                used[own.of].append(source)
    used = {number: sources for number, sources in used.items() if sources}
    rest, count = table.copy(), settings
    for source in (source for each in used.values() for source in each):
        rest[source] = (SETTING, table[source, 1], count, 0)
        count += 1
    return TabulatedSteps(
        _at_rows(operations, list(used)),
        tuple(compared[number] for number in used),
        tuple(np.column_stack([steps[s].values for s in own]) for own in used.values()),
        first_results(replace(operations, table=rest), operations.results),
    )


def _at_rows(operations: Operations, found: list[int]) -> Operations:
    """The same inputs -> what operations in some rows give."""
    rows = []
    places = {row: place for place, row in enumerate(found)}
    for row in np.flatnonzero(operations.table[:, 0] != RESULT).tolist():
        rows.append(operations.table[row])
        if row in places:
            rows.append(np.array((RESULT, places[row], operations.table[row, 1], 0)))
    table = np.array(rows, dtype=np.int64).reshape(-1, 4)
    return first_results(replace(operations, table=table, results=len(found)), len(found))


def _find_sources(table: NDArray[np.int64]) -> list[tuple[int, ...]]:
    """Rows from which each row takes its arguments."""
    last: dict[int, int] = {}
    found: list[tuple[int, ...]] = []
    for row, (op, place, a, b) in enumerate(table.tolist()):
        found.append(tuple(last[k] for k in places_read(op, a, b)))
        if op != RESULT:
            last[place] = row
    return found


def _find_constants(
    operations: Operations, given: list[tuple[int, ...]], least: int = _WORTH
) -> dict[int, Real]:
    """Numbers, by their rows, and the constants that they are at least or not."""
    op = operations.table[:, 0]
    found: dict[int, set[float]] = {}
    for row in np.flatnonzero(op == ca.OP_LE).tolist():
        constant, number = given[row]
        if op[constant] == ca.OP_CONST and op[number] != ca.OP_CONST:
            value = float(operations.constants[operations.table[constant, 2]])
            found.setdefault(number, set()).add(value)
    return {n: np.array(sorted(values)) for n, values in found.items() if len(values) >= least}


def _steps(
    operations: Operations, given: list[tuple[int, ...]], compared: dict[int, Real]
) -> dict[int, _Steps]:
    """Rows that are constants (of number -1) or step functions."""
    found: dict[int, _Steps] = {}
    for row, (op, _, a, _) in enumerate(operations.table.tolist()):
        sources = given[row]
        if op == ca.OP_CONST:
            found[row] = _Steps(-1, operations.constants[a : a + 1])
        elif op == ca.OP_LE and sources[1] in compared and sources[0] in found:
            own = found[sources[0]]
            if own.of == -1:
                constants = compared[sources[1]]
                begins = np.append(-np.inf, constants)
                found[row] = _Steps(sources[1], (begins >= own.values).astype(float))
        elif op in _SAME and all(source in found for source in sources):
            of = {found[source].of for source in sources} - {-1}
            if len(of) <= 1:
                values = _SAME[op](*(found[source].values for source in sources))
                found[row] = _Steps(of.pop() if of else -1, np.asarray(values, dtype=float))
    return found
