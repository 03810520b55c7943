"""Symbolic solution of sparse linear systems.

Markowitz elimination (Management Science 3 (1957) 255) on terms of a tape. Each entry carries the
kind of its coefficient and its value at a generic point, so that a pivot is a number before it
is a function of parameters, and never zero at that point. What is left couples a few unknowns by
coefficients that vary during a run, any of which may pass zero; it is solved by orthogonal
factorisation, which needs no pivot.

Constraints that hold or slide (`lumped.switch`) come last, each with the coefficient of its own
reaction as pivot: whatever holds, their matrix is a principal part of the inverse inertias, padded
with ones, so that every such pivot is positive (a P-matrix; Cottle, Pang and Stone, The Linear
Complementarity Problem, 1992, ch. 3).
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from lumped.flattening.residual import VARYING
from lumped.flattening.tape import Tape, TapeTerm

_MOST_DENSE = 5
"""Unknowns up to which the orthogonal factorisation is taken."""


@dataclass(slots=True)
class Entry:
    """A coefficient: its term, its kind, its value at a generic point."""

    term: TapeTerm
    kind: int
    value: float


class SingularBlockError(Exception):
    """No pivot is left; the argument lists the rows without one."""


def solve(
    rows: list[dict[int, Entry]],
    right: list[tuple[TapeTerm, float]],
    tape: Tape,
    last: Mapping[int, int] | None = None,
) -> list[tuple[TapeTerm, float]]:
    """Solve ``sum_j rows[i][j] z_j == right[i]`` for z.

    Parameters
    ----------
    rows : list of dict of int to Entry
        Coefficients of each equation; used up.
    right : list of (Term, float)
        Right sides and their values at the generic point; used up.
    tape : Tape
        Where the terms are.
    last : mapping of int to int, optional
        Rows to be eliminated after all others, and the column of the pivot of each.

    Returns
    -------
    list of (Term, float)
        The unknowns 0 .. n-1 and their values at the generic point.

    Raises
    ------
    SingularBlockError
        If the system is singular at the generic point.
    """
    n = len(rows)
    holders: dict[int, set[int]] = {j: set() for j in range(n)}
    for i, row in enumerate(rows):
        for j in row:
            holders[j].add(i)
    system = _System(rows, right, tape, holders)
    pivots = dict(last or {})
    system.eliminate_cheapest(pivots)
    system.eliminate_given(pivots)
    return system.substitute_back()


@dataclass
class _System:
    """A linear system while it is solved.

    Attributes
    ----------
    holders : dict of int to set of int
        Rows not yet used up that hold each column.
    order : list of (list of int, list of int)
        Rows used up together, and the columns that they determine.
    """

    rows: list[dict[int, Entry]]
    right: list[tuple[TapeTerm, float]]
    tape: Tape
    holders: dict[int, set[int]]
    order: list[tuple[list[int], list[int]]] = field(default_factory=list)

    def eliminate_cheapest(self, last: Mapping[int, int]) -> None:
        """Use up all rows but the last, those with the best pivots first."""
        rows, barred = self.rows, frozenset(last.values())
        open_rows = set(range(len(rows))) - set(last)
        heap = [(*_cheapest(rows[i], self.holders, barred), i) for i in open_rows]
        heapq.heapify(heap)
        while heap:
            *cost, j, i = heapq.heappop(heap)
            if i not in open_rows:
                continue
            now = _cheapest(rows[i], self.holders, barred)
            if now[0] == _NO_PIVOT:
                continue
            if now > (*cost, j):
                heapq.heappush(heap, (*now, i))
                continue
            if now[0] == _VARIES and not last:
                rest, columns = self._find_coupled(i)
                if len(rest) == len(columns) <= _MOST_DENSE:
                    self.order.append((rest, columns))
                    open_rows.difference_update(rest)
                    continue
            open_rows.discard(i)
            for k in self._eliminate(i, now[-1]):
                if k in open_rows:
                    heapq.heappush(heap, (*_cheapest(rows[k], self.holders, barred), k))
        if open_rows:
            raise SingularBlockError(sorted(open_rows))

    def eliminate_given(self, pivots: dict[int, int]) -> None:
        """Use up rows with given pivots, those with the least fill-in first."""

        def fill(i: int) -> int:
            return (len(self.rows[i]) - 1) * (len(self.holders[pivots[i]]) - 1)

        heap = [(fill(i), i) for i in pivots]
        heapq.heapify(heap)
        while heap:
            cost, i = heapq.heappop(heap)
            if (now := fill(i)) > cost:
                heapq.heappush(heap, (now, i))
                continue
            if pivots[i] not in self.rows[i]:
                raise SingularBlockError([i])
            for _ in self._eliminate(i, pivots[i]):
                pass

    def _eliminate(self, i: int, j: int) -> Iterator[int]:
        """Use row i up for column j; yields each other row that changes."""
        self.order.append(([i], [j]))
        for c in self.rows[i]:
            self.holders[c].discard(i)
        for k in sorted(self.holders[j]):
            self._subtract(k, i, j)
            yield k
        self.holders[j].clear()

    def _subtract(self, k: int, i: int, j: int) -> None:
        """Row k minus the multiple of row i that removes column j."""
        row, right = self.rows[k], self.right
        pivot, mine = self.rows[i][j], row.pop(j)
        factor = mine.term / pivot.term
        ratio = mine.value / pivot.value
        kind = max(mine.kind, pivot.kind)
        for c, entry in self.rows[i].items():
            if c == j:
                continue
            old = row.get(c)
            value = (old.value if old else 0.0) - ratio * entry.value
            worst = max(kind, entry.kind, old.kind if old else 0)
            if worst == 0 and abs(value) <= 1e-14 * abs(ratio * entry.value):
                if old:
                    del row[c]
                    self.holders[c].discard(k)
                continue
            change = factor * entry.term
            row[c] = Entry(old.term - change if old else -change, worst, value)
            self.holders[c].add(k)
        right[k] = right[k][0] - factor * right[i][0], right[k][1] - ratio * right[i][1]

    def _find_coupled(self, start: int) -> tuple[list[int], list[int]]:
        """Open rows that share columns with a row, directly or through others; and the columns."""
        found, columns, stack = {start}, set(), [start]
        while stack:
            for column in self.rows[stack.pop()]:
                if column not in columns:
                    columns.add(column)
                    stack.extend(self.holders[column] - found)
                    found |= self.holders[column]
        return sorted(found), sorted(columns)

    def substitute_back(self) -> list[tuple[TapeTerm, float]]:
        """The unknowns."""
        result: list[tuple[TapeTerm, float]] = [(self.tape.zero, 0.0)] * len(self.rows)
        for group, columns in reversed(self.order):
            if len(group) > 1:
                for j, solved in zip(columns, self._solve_dense(group, columns), strict=True):
                    result[j] = solved
                continue
            (i,), (j,) = group, columns
            total, number = self.right[i]
            for c, entry in self.rows[i].items():
                if c != j:
                    total = total - entry.term * result[c][0]
                    number -= entry.value * result[c][1]
            pivot = self.rows[i][j]
            result[j] = (total / pivot.term, number / pivot.value)
        return result

    def _solve_dense(self, group: list[int], columns: list[int]) -> list[tuple[TapeTerm, float]]:
        """Solve a few equations together without pivots."""
        n = len(group)
        terms = [self.right[i][0] for i in group]
        symbols = ca.SX.sym("a", n * n + n)
        matrix, numbers = ca.SX.zeros(n, n), np.zeros((n, n))
        for a, i in enumerate(group):
            for b, j in enumerate(columns):
                if j in self.rows[i]:
                    matrix[a, b], numbers[a, b] = symbols[len(terms)], self.rows[i][j].value
                    terms.append(self.rows[i][j].term)
        if np.linalg.matrix_rank(numbers) < n:
            raise SingularBlockError(group)
        used = symbols[: len(terms)]
        function = ca.Function("dense", [used], [_solve_without_pivots(matrix, used[:n])])
        values = np.linalg.solve(numbers, [self.right[i][1] for i in group])
        return list(zip(self.tape.call(function, terms), values.tolist(), strict=True))


def _solve_without_pivots(matrix: ca.SX, right: ca.SX) -> ca.SX:
    """Solution by modified Gram-Schmidt steps of the matrix with its right side.

    With the right side as one more column they are as stable as reflections (Björck, BIT 7 (1967)
    1), also where equations nearly depend on each other.
    """
    columns, upper = ca.horzsplit(matrix), []
    for j, column in enumerate(columns):
        length = ca.norm_2(column)
        unit = column / length
        shares = [ca.dot(unit, other) for other in (*columns[j + 1 :], right)]
        columns[j + 1 :] = [
            other - share * unit for other, share in zip(columns[j + 1 :], shares[:-1], strict=True)
        ]
        right = right - shares[-1] * unit
        upper.append((length, shares))
    found: list[ca.SX] = []
    for length, shares in reversed(upper):
        rest = shares[-1]
        for share, later in zip(shares[:-1], reversed(found), strict=True):
            rest -= share * later
        found.append(rest / length)
    return ca.vertcat(*reversed(found))


_STEADY, _VARIES, _NO_PIVOT = 0, 1, 2


def _cheapest(
    row: dict[int, Entry], holders: dict[int, set[int]], barred: frozenset[int]
) -> tuple[int, bool, int, int, float, int]:
    """Class, smallness, kind, fill-in, relative size (negative), column of a row's best pivot."""
    largest = max((abs(e.value) for j, e in row.items() if j not in barred), default=0.0)
    best = (_NO_PIVOT, False, 0, 0, 0.0, -1)
    for j, entry in row.items():
        if j not in barred and abs(entry.value) > 1e-9 * largest:
            fill = (len(row) - 1) * (len(holders[j]) - 1)
            size = abs(entry.value) / largest
            steady = _VARIES if entry.kind == VARYING else _STEADY
            best = min(best, (steady, size < 0.01, entry.kind, fill, -size, j))
    return best
