"""Sparse graphs and what `scipy.sparse.csgraph` finds in them."""

from __future__ import annotations

import numpy as np
import scipy


def links(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> scipy.sparse.csr_array:
    """Graph with an edge from each row to its column; several times faster than by way of COO."""
    sort = np.argsort(rows, kind="stable")
    begins = np.searchsorted(rows[sort], np.arange(shape[0] + 1))
    return scipy.sparse.csr_array(
        (np.ones(len(rows), dtype=np.int8), columns[sort], begins), shape=shape
    )


def find_sets(pairs: np.ndarray, count: int) -> np.ndarray:
    """Number of the set that each of `count` things is in, if pairs, shape (k, 2), are joined."""
    graph = links(pairs[:, 0], pairs[:, 1], (count, count))
    found: np.ndarray = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    return found


def find_reached(
    sources: np.ndarray, targets: np.ndarray, starts: np.ndarray, count: int
) -> np.ndarray:
    """Those of `count` things to which links lead from `starts`, themselves included, ascending."""
    rows = np.concatenate([sources, np.full(len(starts), count)])
    paths = links(rows, np.concatenate([targets, starts]), (count + 1, count + 1))
    order = scipy.sparse.csgraph.breadth_first_order(paths, count, return_predecessors=False)
    return np.sort(order[order < count])
