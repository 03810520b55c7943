"""Determinants of sparse matrices of formulas, without division, in named parts."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from lumped.errors import OptionError
from lumped.vibration.formulas.names import Names
from lumped.vibration.formulas.to_sympy import load_sympy

_MOST = 400
"""Minors beyond which nobody reads the formula."""

Entries = dict[tuple[int, int], Any]


def determinant(entries: Entries, n: int, names: Names | None) -> Any:
    """Determinant of a matrix by named parts, minors of the first rows.

    Each minor is expanded by its last row into those before it. Rows are in the order of Cuthill
    and McKee, so that few sets of columns occur: two for each row of a chain, whose minors are the
    recurrence of Holzer.

    Parameters
    ----------
    entries : dict of (int, int) to sympy expression
        What is not zero.
    n : int
        Number of rows.
    names : Names, optional
        To which the parts are added; without it there are none.

    Raises
    ------
    OptionError
        If there are too many minors.
    """
    sympy = load_sympy()
    if not n:
        return sympy.Integer(1)
    order = _narrow(entries, n)
    place = {row: k for k, row in enumerate(order)}
    rows: list[list[tuple[int, Any]]] = [[] for _ in range(n)]
    for (i, j), value in entries.items():
        rows[place[i]].append((place[j], value))
    sets = _find_sets(rows, n)
    done: dict[frozenset[int], Any] = {frozenset(): sympy.Integer(1)}
    for k, wanted in enumerate(sets[1:]):
        found = {}
        for columns in wanted:
            terms = [
                (-1) ** sum(c > j for c in columns) * value * done[columns - {j}]
                for j, value in sorted(rows[k], key=lambda entry: entry[0])
                if j in columns and columns - {j} in done
            ]
            if terms:
                found[columns] = sympy.Add(*terms)
        if names and k < n - 1:
            found = {c: names.new("D", v) if v.is_Add else v for c, v in found.items()}
        done = found
    return done.get(frozenset(range(n)), sympy.Integer(0))


def _narrow(entries: Entries, n: int) -> list[int]:
    i, j = np.array([*entries]).reshape(-1, 2).T
    pattern = scipy.sparse.csr_array((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), (n, n))
    found: list[int] = scipy.sparse.csgraph.reverse_cuthill_mckee(
        pattern, symmetric_mode=True
    ).tolist()
    return found if found[0] <= found[-1] else found[::-1]


def _find_sets(rows: list[list[tuple[int, Any]]], n: int) -> list[list[frozenset[int]]]:
    """Sets of columns of the minors of the first rows, from which the whole follows."""
    sets: list[set[frozenset[int]]] = [{frozenset(range(n))}]
    for k in range(n - 1, -1, -1):
        ends = {j for row in rows[:k] for j, _ in row}
        before = {
            columns - {j}
            for columns in sets[-1]
            for j, _ in rows[k]
            if j in columns and columns - {j} <= ends
        }
        sets.append(before)
        if sum(map(len, sets)) > _MOST:
            raise OptionError(
                f"a determinant of {n} rows has more than {_MOST} minors, which is no formula to "
                "read. Give numbers for parameters, or take a part of the drive; modes and "
                "eigen_sensitivity compute drives of any size."
            )
    return [sorted(columns, key=sorted) for columns in reversed(sets)]


def is_forest(entries: Entries, n: int) -> bool:
    """Whether couplings are mutual and close no circle."""
    links = [(i, j) for i, j in entries if i != j]
    if any((j, i) not in entries for i, j in links):
        return False
    pattern = scipy.sparse.coo_array(
        (np.ones(len(links)), np.array(links).reshape(-1, 2).T), (n,) * 2
    )
    parts = scipy.sparse.csgraph.connected_components(pattern, directed=False)[0]
    return bool(len(links) // 2 == n - parts)


def find_way(entries: Entries, first: int, last: int) -> list[int] | None:
    """Rows from one to another by couplings, where there is only one way; None if there is none."""
    before: dict[int, int] = {first: first}
    stack = [first]
    while stack:
        k = stack.pop()
        for i, j in entries:
            if i == k and j not in before:
                before[j] = k
                stack.append(j)
    if last not in before:
        return None
    way = [last]
    while way[-1] != first:
        way.append(before[way[-1]])
    return way[::-1]
