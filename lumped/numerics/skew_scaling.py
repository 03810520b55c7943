"""Scaling of states; undamped drives become skew-symmetric and couple torsions with speeds."""

from __future__ import annotations

import numpy as np
import scipy

from lumped.support.arrays import Boolean, Real

_SWEEPS = 20


def skew_scaling(a: scipy.sparse.csr_array) -> Real | None:
    """Scaling s so that ``s_i a_ij / s_j`` is skew-symmetric, or None if there is none.

    Parameters
    ----------
    a : csr_array, shape (n, n)
        Does not fall into parts; no stored zeros.

    Returns
    -------
    ndarray, shape (n,), or None
    """
    a.sort_indices()
    turned = scipy.sparse.csr_array(a.T)
    turned.sort_indices()
    same = np.array_equal(a.indptr, turned.indptr) and np.array_equal(a.indices, turned.indices)
    if not same or not a.nnz or a.diagonal().any():
        return None
    ratio = -turned.data / a.data
    if (ratio <= 0).any():
        return None
    order, before = scipy.sparse.csgraph.breadth_first_order(a, 0)
    i, j = np.repeat(np.arange(a.shape[0]), np.diff(a.indptr)), a.indices
    led = before[j] == i
    step = np.ones(a.shape[0])
    step[j[led]] = 1 / np.sqrt(ratio[led])
    scale, leader, steps = [1.0] * a.shape[0], before.tolist(), step.tolist()
    for k in order[1:].tolist():
        scale[k] = scale[leader[k]] * steps[k]
    found = np.array(scale)
    fits = np.abs((found[i] / found[j]) ** 2 / ratio - 1) < 1e-9
    return found if fits.all() else None


def two_colours(a: scipy.sparse.csr_array) -> Boolean | None:
    """Split into two sets that couple only with each other, or None; of each part on its own."""
    part = scipy.sparse.csgraph.connected_components(a, directed=False)[1]
    found = np.zeros(a.shape[0], dtype=bool)
    for first in np.unique(part, return_index=True)[1].tolist():
        order, before = scipy.sparse.csgraph.breadth_first_order(a, first, directed=False)
        colour, leader = {first: False}, before.tolist()
        for k in order[1:].tolist():
            colour[k] = not colour[leader[k]]
        found[list(colour)] = list(colour.values())
    i, j = a.nonzero()
    return found if (found[i] != found[j]).all() else None


def balance(a: scipy.sparse.csr_array) -> Real:
    """Scaling that makes rows and columns of ``s_i a_ij / s_j`` about equally long.

    Scales all at once, by half the step of Osborne's method, which scales one by one.
    """
    size = abs(a)
    size.setdiag(0)
    log = np.zeros(a.shape[0])
    for _ in range(_SWEEPS):
        scaled = (
            scipy.sparse.diags_array(np.exp(log)) @ size @ scipy.sparse.diags_array(np.exp(-log))
        )
        rows, columns = scaled.sum(axis=1), scaled.sum(axis=0)
        both = (rows > 0) & (columns > 0)
        log[both] += 0.25 * np.log(columns[both] / rows[both])
    return np.exp(log)
