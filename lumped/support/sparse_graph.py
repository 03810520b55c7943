"""Sparse graphs for `scipy.sparse.csgraph`."""

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
