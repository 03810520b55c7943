"""Rows over a grid from as few of them as their smoothness allows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lumped.support.arrays import Integer, Real

_ACCURATE = 1e-10
"""Difference from a row, relative to the largest number of its column."""
_ROUNDING = 1e-12
_NODES = (5, 9, 17, 33)
_SHORT = 16
"""Places of a range of which all rows are computed."""


def interpolate_rows(row: Callable[[int], tuple[Real, Real]], places: Real) -> Real:
    """Rows at all places, of which most are interpolated.

    A polynomial through rows near the Chebyshev points of a range is compared with four rows
    between them; where they differ it takes more, and then the range is halved. What is narrower
    than the distances of these rows is missed.

    Parameters
    ----------
    row : callable
        Row at the place of a number, and the size of what it was computed from, shapes (m,).
    places : ndarray, shape (n,)
        Ascending.

    Returns
    -------
    ndarray, shape (n, m)
    """
    known: dict[int, Real] = {}
    size = np.zeros(0)

    def at(number: int) -> Real:
        nonlocal size
        if number not in known:
            known[number], own = row(number)
            size = np.maximum(size, own) if len(known) > 1 else own
        return known[number]

    found = np.empty((len(places), len(at(0))))
    waiting = [(0, len(places) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < _SHORT:
            found[first : last + 1] = [at(k) for k in range(first, last + 1)]
            continue
        # nodes that are much nearer to each other than places would not be those of Chebyshev
        for count in [count for count in _NODES if count**2 <= 4 * (last - first)]:
            nodes = _nodes(places, first, last, count)
            tried = np.unique(_between_nodes(nodes))
            rows, wanted = (np.array([at(k) for k in some.tolist()]) for some in (nodes, tried))
            curve = _through(places[nodes], rows)
            missed = np.abs(curve(places[tried]) - wanted)
            allowed = _ACCURATE * np.abs(list(known.values())).max(axis=0)
            if (missed <= allowed + _ROUNDING * size).all():
                found[first : last + 1] = curve(places[first : last + 1])
                break
        else:
            middle = (first + last) // 2
            waiting += [(first, middle), (middle, last)]
    return found


def _nodes(places: Real, first: int, last: int, count: int) -> Integer:
    """Places nearest to the extremes of a Chebyshev polynomial; those of fewer are among them."""
    middle, half = 0.5 * (places[first] + places[last]), 0.5 * (places[last] - places[first])
    wanted = middle - half * np.cos(np.pi * np.arange(count) / (count - 1))
    above = np.clip(np.searchsorted(places, wanted), first + 1, last)
    nearer = wanted - places[above - 1] < places[above] - wanted
    return np.unique(above - nearer)


def _between_nodes(nodes: Integer) -> Integer:
    """Four places between neighbours, over the whole range."""
    begin = np.linspace(0, len(nodes) - 2, 4).astype(int)
    return np.asarray((nodes[begin] + nodes[begin + 1]) // 2)


def _through(nodes: Real, rows: Real) -> Callable[[Real], Real]:
    """The polynomial through rows, by its barycentric form.

    Source: Berrut and Trefethen, Barycentric Lagrange interpolation, SIAM Review 46 (2004) 501.
    """
    apart = (nodes[:, None] - nodes) * (4 / (nodes[-1] - nodes[0]))
    np.fill_diagonal(apart, 1.0)
    weights = 1 / apart.prod(axis=1)

    def at(places: Real) -> Real:
        away = places[:, None] - nodes
        hit = away == 0
        shares = weights / np.where(hit, 1.0, away)
        shares[hit.any(axis=1)] = 0.0
        shares[hit] = 1.0
        found: Real = (shares @ rows) / shares.sum(axis=1, keepdims=True)
        return found

    return at
