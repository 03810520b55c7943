"""Places of the entries in the factors of a sparse matrix, chosen once for a pattern."""

from __future__ import annotations

import numpy as np
import scipy

from lumped.kernel.run import Pattern


def pattern_of(
    rows: np.ndarray, columns: np.ndarray, n: int, colour: np.ndarray | None = None
) -> Pattern:
    """Pattern of the factors of ``I - h J`` with pivots on the diagonal.

    Pivots are taken in the order of least degree on the pattern of ``J + J'`` (as in SuperLU),
    which keeps the factors of drive trains nearly as sparse as the matrix.

    Parameters
    ----------
    rows, columns : ndarray of int, shape (k,)
        Nonzeros of the Jacobian.
    n : int
        Number of states.
    colour : ndarray of int, shape (n,), optional
        Group of each column if the Jacobian is found along directions.
    """
    group = np.zeros(0, dtype=np.int64) if colour is None else colour
    count = 0 if colour is None else int(colour.max()) + 1
    order = _order(rows, columns, n)
    place = np.empty(n, dtype=np.int64)
    place[order] = np.arange(n)
    lower = _find_fill(place[rows], place[columns], n)
    upper: list[list[int]] = [[] for _ in range(n)]
    for i, found in enumerate(lower):
        for k in found:
            upper[k].append(i)
    at, begin, diagonal = [], [0], []
    for i in range(n):
        diagonal.append(begin[-1] + len(lower[i]))
        at += [*lower[i], i, *upper[i]]
        begin.append(len(at))
    columns_of = np.array(at, dtype=np.int64)
    row_of = np.repeat(np.arange(n), np.diff(begin))
    # entries are in the order of row and column, so their numbers are found by bisection
    wanted = place[rows] * n + place[columns]
    entry = np.searchsorted(row_of * n + columns_of, wanted)
    return Pattern(
        nonzeros=len(rows),
        entries=len(at),
        row=np.array(rows, dtype=np.int64),
        column=np.array(columns, dtype=np.int64),
        place=entry.astype(np.int64),
        order=order.astype(np.int64),
        begin=np.array(begin, dtype=np.int64),
        diagonal=np.array(diagonal, dtype=np.int64),
        at=columns_of,
        colours=count,
        colour=group,
        grouped=np.argsort(group[columns], kind="stable") if count else group,
        first_grouped=np.searchsorted(np.sort(group[columns]), np.arange(count + 1))
        if count
        else group,
    )


def _order(rows: np.ndarray, columns: np.ndarray, n: int) -> np.ndarray:
    """States in the order in which they become pivots."""
    ones = np.ones(len(rows))
    both = scipy.sparse.csc_array((ones, (rows, columns)), shape=(n, n))
    degree = 1.0 + np.asarray(both.sum(axis=0)).ravel() + np.asarray(both.sum(axis=1)).ravel()
    dominant = (scipy.sparse.diags_array(degree) + both + both.T).tocsc()
    factors = scipy.sparse.linalg.splu(
        dominant,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return np.argsort(factors.perm_c)


def _find_fill(rows: np.ndarray, columns: np.ndarray, n: int) -> list[list[int]]:
    """Columns below each pivot in the rows of the factors, of the symmetric pattern.

    Row by row along the elimination tree (Liu, SIAM Journal on Matrix Analysis 11 (1990) 134).
    """
    pairs = {(max(i, j), min(i, j)) for i, j in zip(rows.tolist(), columns.tolist(), strict=True)}
    given: list[list[int]] = [[] for _ in range(n)]
    for i, j in pairs:
        if i != j:
            given[i].append(j)
    parent, mark = [-1] * n, [-1] * n
    found: list[list[int]] = []
    for i in range(n):
        mark[i] = i
        row = []
        for j in given[i]:
            while mark[j] != i:
                mark[j] = i
                row.append(j)
                if parent[j] < 0:
                    parent[j] = i
                j = parent[j]
        found.append(sorted(row))
    return found
