"""Matching of rows to columns: each row gets a column of its own, as far as that is possible."""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy

from lumped.support.sparse_graph import find_reached, links, pattern

_MANY = 2000
"""Links from which on SciPy matches: the time that CasADi needs may grow with their square."""


def can_match_all(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> bool:
    """Whether each row can have a column of its own, and none is left."""
    if len(rows) < _MANY:
        return shape[0] == shape[1] == ca.sprank(pattern(rows, columns, shape))
    return shape[0] == shape[1] and bool((match_rows(rows, columns, shape) >= 0).all())


def match_rows(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Column matched to each row, -1 for none; SciPy's choice where there are several."""
    if len(rows) < _MANY and can_match_all(rows, columns, shape):
        sets, order, partner, *_ = pattern(rows, columns, shape).btf()
        if sets == shape[0]:  # there is no other choice
            only = np.empty(shape[0], dtype=int)
            only[order] = partner
            return only
    found: np.ndarray = scipy.sparse.csgraph.maximum_bipartite_matching(
        links(rows, columns, shape), perm_type="column"
    )
    return found


def find_overdetermined(
    rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]
) -> np.ndarray:
    """Rows that compete for too few columns (Dulmage and Mendelsohn), ascending."""
    if len(rows) < _MANY:
        _, order, *_, parts, _ = pattern(rows, columns, shape).btf()
        return np.sort(np.array(order[: parts[2]], dtype=int))
    match = match_rows(rows, columns, shape)
    unmatched = np.flatnonzero(match < 0)
    if not len(unmatched):
        return unmatched
    return find_competing(links(rows, columns, shape), match, unmatched)


def invert(match: np.ndarray, count: int) -> np.ndarray:
    """Row matched to each column, -1 for none."""
    rows = np.full(count, -1)
    rows[match[match >= 0]] = np.flatnonzero(match >= 0)
    return rows


def find_competing(
    graph: scipy.sparse.csr_array, match: np.ndarray, starts: np.ndarray
) -> np.ndarray:
    """Rows that alternating paths from the rows `starts` reach, themselves included."""
    n, m = graph.shape
    to = invert(match, m)[graph.indices]
    known = to >= 0
    rows = np.repeat(np.arange(n), np.diff(graph.indptr))
    return find_reached(rows[known], to[known], starts, n)
