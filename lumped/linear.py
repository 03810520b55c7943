"""Symbolic solution of small sparse linear systems.

Markowitz elimination (Management Science 3 (1957) 255) on SX entries. Each entry carries the
kind of its coefficient and its value at a generic point, so that a pivot is a number before it
is a function of parameters, and that before it varies; and is never zero at that point.
"""

from __future__ import annotations

import heapq
from dataclasses import dataclass

import casadi as ca

__all__ = ["Entry", "SingularBlockError", "solve"]


@dataclass(frozen=True)
class Entry:
    """A coefficient: its expression, its kind, its value at a generic point."""

    expression: ca.SX
    kind: int
    value: float


class SingularBlockError(Exception):
    """No pivot is left; the argument lists the rows without one."""


def solve(
    rows: list[dict[int, Entry]], right: list[tuple[ca.SX, float]]
) -> list[tuple[ca.SX, float]]:
    """Solve ``sum_j rows[i][j] z_j == right[i]`` for z.

    Parameters
    ----------
    rows : list of dict of int to Entry
        Coefficients of each equation; used up.
    right : list of (SX, float)
        Right sides and their values at the generic point; used up.

    Returns
    -------
    list of (SX, float)
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
    open_rows = set(range(n))
    order: list[tuple[int, int]] = []
    heap = [(*_cheapest(rows[i], holders), i) for i in range(n)]
    heapq.heapify(heap)
    while heap:
        *cost, j, i = heapq.heappop(heap)
        if i not in open_rows:
            continue
        now = _cheapest(rows[i], holders)
        if now[0] == _NO_PIVOT:
            continue
        if now > (*cost, j):
            heapq.heappush(heap, (*now, i))
            continue
        j = now[-1]
        order.append((i, j))
        open_rows.discard(i)
        for c in rows[i]:
            holders[c].discard(i)
        for k in sorted(holders[j]):
            _subtract(rows, right, holders, k, i, j)
            heapq.heappush(heap, (*_cheapest(rows[k], holders), k))
        holders[j].clear()
    if open_rows:
        raise SingularBlockError(sorted(open_rows))
    return _substituted(rows, right, order)


def _substituted(
    rows: list[dict[int, Entry]],
    right: list[tuple[ca.SX, float]],
    order: list[tuple[int, int]],
) -> list[tuple[ca.SX, float]]:
    result: list[tuple[ca.SX, float]] = [(ca.SX(0), 0.0)] * len(rows)
    for i, j in reversed(order):
        total, number = right[i]
        for c, entry in rows[i].items():
            if c != j:
                total = total - entry.expression * result[c][0]
                number -= entry.value * result[c][1]
        pivot = rows[i][j]
        result[j] = (total / pivot.expression, number / pivot.value)
    return result


_NO_PIVOT = 9


def _cheapest(row: dict[int, Entry], holders: dict[int, set[int]]) -> tuple[int, int, float, int]:
    """Kind, fill-in, relative size (negative) and column of the best pivot of a row."""
    largest = max((abs(e.value) for e in row.values()), default=0.0)
    best = (_NO_PIVOT, 0, 0.0, -1)
    for j, entry in row.items():
        if abs(entry.value) > 1e-9 * largest:
            fill = (len(row) - 1) * (len(holders[j]) - 1)
            best = min(best, (entry.kind, fill, -abs(entry.value) / largest, j))
    return best


def _subtract(
    rows: list[dict[int, Entry]],
    right: list[tuple[ca.SX, float]],
    holders: dict[int, set[int]],
    k: int,
    i: int,
    j: int,
) -> None:
    """Row k minus the multiple of row i that removes column j."""
    pivot, mine = rows[i][j], rows[k].pop(j)
    factor = mine.expression / pivot.expression
    ratio = mine.value / pivot.value
    kind = max(mine.kind, pivot.kind)
    for c, entry in rows[i].items():
        if c == j:
            continue
        old = rows[k].get(c)
        expression = (old.expression if old else 0) - factor * entry.expression
        value = (old.value if old else 0.0) - ratio * entry.value
        worst = max(kind, entry.kind, old.kind if old else 0)
        if worst == 0 and abs(value) <= 1e-14 * abs(ratio * entry.value):
            if old:
                del rows[k][c]
                holders[c].discard(k)
            continue
        rows[k][c] = Entry(expression, worst, value)
        holders[c].add(k)
    right[k] = (
        right[k][0] - factor * right[i][0],
        right[k][1] - ratio * right[i][1],
    )
