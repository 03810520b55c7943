"""Sparse graphs and what CasADi and SciPy find in them.

Small drives need only CasADi: to load `scipy.sparse` takes longer than to assemble and run them.
"""

from __future__ import annotations

import casadi as ca
import numpy as np
import scipy


def pattern(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> ca.Sparsity:
    """Graph with an edge from each row to its column, for CasADi."""
    return ca.Sparsity.triplet(*shape, rows.tolist(), columns.tolist())


def find_sets(pairs: np.ndarray, count: int) -> np.ndarray:
    """Number of the set that each of `count` things is in, if pairs, shape (k, 2), are joined."""
    both = np.concatenate([pairs, pairs[:, ::-1]])
    return find_strong_sets(both[:, 0], both[:, 1], count)


def find_strong_sets(sources: np.ndarray, targets: np.ndarray, count: int) -> np.ndarray:
    """Number of the set of each of `count` things: links lead from any of a set to any other.

    Sets are numbered by their first member.
    """
    _, members, begins = pattern(sources, targets, (count, count)).scc()
    owner = np.empty(count, dtype=int)
    owner[members] = np.repeat(np.arange(len(begins) - 1), np.diff(begins))
    first = np.full(len(begins) - 1, count)
    np.minimum.at(first, owner, np.arange(count))
    found: np.ndarray = np.argsort(np.argsort(first))[owner]
    return found


def links(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> scipy.sparse.csr_array:
    """The same for SciPy; several times faster than by way of COO."""
    sort = np.argsort(rows, kind="stable")
    begins = np.searchsorted(rows[sort], np.arange(shape[0] + 1))
    return scipy.sparse.csr_array(
        (np.ones(len(rows), dtype=np.int8), columns[sort], begins), shape=shape
    )


def find_reached(
    sources: np.ndarray, targets: np.ndarray, starts: np.ndarray, count: int
) -> np.ndarray:
    """Those of `count` things to which links lead from `starts`, themselves included, ascending."""
    rows = np.concatenate([sources, np.full(len(starts), count)])
    paths = links(rows, np.concatenate([targets, starts]), (count + 1, count + 1))
    order = scipy.sparse.csgraph.breadth_first_order(paths, count, return_predecessors=False)
    return np.sort(order[order < count])
