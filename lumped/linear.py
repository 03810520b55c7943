"""Symbolic solution of small sparse linear systems.

Markowitz elimination (Management Science 3 (1957) 255) on SX entries. Each entry carries the
kind of its coefficient and its value at a generic point, so that a pivot is a number before it
is a function of parameters, and that before it varies; and is never zero at that point.
"""

from __future__ import annotations

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


def solve(rows: list[dict[int, Entry]], right: list[tuple[ca.SX, float]]) -> list[ca.SX]:
    """Solve ``sum_j rows[i][j] z_j == right[i]`` for z.

    Parameters
    ----------
    rows : list of dict of int to Entry
        Coefficients of each equation; used up.
    right : list of (SX, float)
        Right sides and their values at the generic point; used up.

    Returns
    -------
    list of SX
        The unknowns 0 .. n-1.

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
    while open_rows:
        pivot = _best(rows, holders, open_rows)
        if pivot is None:
            raise SingularBlockError(sorted(open_rows))
        i, j = pivot
        order.append(pivot)
        open_rows.discard(i)
        for c in rows[i]:
            holders[c].discard(i)
        for k in list(holders[j]):
            _subtract(rows, right, holders, k, i, j)
        holders[j].clear()
    result: list[ca.SX] = [ca.SX(0)] * n
    for i, j in reversed(order):
        total = right[i][0]
        for c, entry in rows[i].items():
            if c != j:
                total = total - entry.expression * result[c]
        result[j] = total / rows[i][j].expression
    return result


def _best(
    rows: list[dict[int, Entry]], holders: dict[int, set[int]], open_rows: set[int]
) -> tuple[int, int] | None:
    best, cost = None, (9, 0, 0.0)
    for i in sorted(open_rows):
        largest = max((abs(e.value) for e in rows[i].values()), default=0.0)
        for j, entry in rows[i].items():
            if abs(entry.value) <= 1e-9 * largest:
                continue
            fill = (len(rows[i]) - 1) * (len(holders[j]) - 1)
            mine = (entry.kind, fill, -abs(entry.value) / largest)
            if mine < cost:
                best, cost = (i, j), mine
        if best is not None and cost[:2] == (0, 0):
            break
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
