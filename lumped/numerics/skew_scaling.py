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
    ratio = _ratios(a)
    if ratio is None or not a.nnz or a.diagonal().any() or (ratio >= 0).any():
        return None
    weights = _follow_ratios(a, -ratio)
    return None if weights is None else np.sqrt(weights)


def symmetric_weights(a: scipy.sparse.csr_array) -> Real | None:
    """Weights w, some negative, so that ``w_i a_ij`` is symmetric, or None if there are none.

    Drives of inertias, springs and dampers have them. Where ``A x == l x``, ``w x`` is then a left
    eigenvector, conjugated.

    Parameters
    ----------
    a : csr_array, shape (n, n)
        Does not fall into parts; no stored zeros.

    Returns
    -------
    ndarray, shape (n,), or None
    """
    ratio = _ratios(a)
    return None if ratio is None else _follow_ratios(a, ratio)


def _ratios(a: scipy.sparse.csr_array) -> Real | None:
    """``a_ji / a_ij`` for each number of a matrix; None if some have no counterpart."""
    a.sort_indices()
    turned = scipy.sparse.csr_array(a.T)
    turned.sort_indices()
    same = np.array_equal(a.indptr, turned.indptr) and np.array_equal(a.indices, turned.indices)
    return turned.data / a.data if same else None


def _follow_ratios(a: scipy.sparse.csr_array, ratio: Real) -> Real | None:
    """Numbers w with ``w_i / w_j`` in the ratio of each number of a matrix, or None."""
    order, before = scipy.sparse.csgraph.breadth_first_order(a, 0)
    i, j = np.repeat(np.arange(a.shape[0]), np.diff(a.indptr)), a.indices
    led = before[j] == i
    step = np.ones(a.shape[0])
    step[j[led]] = 1 / ratio[led]
    weight, leader, steps = [1.0] * a.shape[0], before.tolist(), step.tolist()
    for k in order[1:].tolist():
        weight[k] = weight[leader[k]] * steps[k]
    found = np.array(weight)
    fits = np.abs(found[i] / found[j] / ratio - 1) < 1e-9
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
