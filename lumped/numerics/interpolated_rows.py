"""Rows over a grid from as few of them as their smoothness allows."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import scipy

from lumped.support.arrays import Integer, Real

_ACCURATE = 1e-10
"""Difference from a row, relative to the largest number of its column."""
_ROUNDING = 1e-12
_NODES = (5, 9, 17, 33)
_DEGREES = (2, 4, 6)
"""Degrees of polynomials of two numbers."""
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
    known = _KnownRows(row)
    found = np.empty((len(places), known.at([0]).shape[1]))
    waiting = [(0, len(places) - 1)]
    while waiting:
        first, last = waiting.pop()
        if last - first < _SHORT:
            found[first : last + 1] = known.at(range(first, last + 1))
            continue
        # nodes that are much nearer to each other than places would not be those of Chebyshev
        for count in [count for count in _NODES if count**2 <= 4 * (last - first)]:
            nodes = _nodes(places, first, last, count)
            tried = np.unique(_between_nodes(nodes))
            curve = _through(places[nodes], known.at(nodes))
            if known.agree(tried, curve(places[tried])):
                found[first : last + 1] = curve(places[first : last + 1])
                break
        else:
            middle = (first + last) // 2
            waiting += [(first, middle), (middle, last)]
    return found


def fit_rows(row: Callable[[int], tuple[Real, Real]], places: Real) -> Real:
    """Rows at all places, as a polynomial in two numbers of each place if they are one.

    As in `interpolate_rows` some are compared; where they differ, all rows are computed.

    Parameters
    ----------
    row : callable
        As there.
    places : ndarray, shape (n, 2)

    Returns
    -------
    ndarray, shape (n, m)
    """
    known, count = _KnownRows(row), len(places)
    for degree in _DEGREES:
        curves = _polynomials(places, degree)
        if 4 * curves.shape[1] > count:
            break
        # approximate Fekete points (Sommariva and Vianello, Comp. Math. Appl. 57 (2009) 1324)
        chosen = scipy.linalg.qr(curves.T, mode="r", pivoting=True)[1]
        nodes = np.sort(chosen[: curves.shape[1]])
        found: Real = curves @ np.linalg.solve(curves[nodes], known.at(nodes))
        tried = np.unique(_between_nodes(nodes))
        if known.agree(tried, found[tried]):
            return found
    return known.at(range(count))


class _KnownRows:
    """Rows that were computed."""

    def __init__(self, row: Callable[[int], tuple[Real, Real]]) -> None:
        self._row = row
        self._known: dict[int, Real] = {}
        self._size: Real | float = 0.0

    def at(self, numbers: Iterable[int]) -> Real:
        """Rows at the places of numbers."""
        for k in numbers:
            if k not in self._known:
                self._known[k], size = self._row(k)
                self._size = np.maximum(self._size, size)
        return np.array([self._known[k] for k in numbers])

    def agree(self, numbers: Iterable[int], wanted: Real) -> bool:
        """Whether rows are those wanted."""
        missed = np.abs(wanted - self.at(numbers))
        allowed = _ACCURATE * np.abs(list(self._known.values())).max(axis=0)
        return bool((missed <= allowed + _ROUNDING * self._size).all())


def _polynomials(places: Real, degree: int) -> Real:
    """Orthonormal polynomials of two numbers up to a degree, in columns."""
    low, high = places.min(axis=0), places.max(axis=0)
    scaled = (2 * places - low - high) / np.where(high > low, high - low, 1.0)
    one, two = np.polynomial.chebyshev.chebvander(scaled.T, degree)
    every = [one[:, i] * two[:, k] for i in range(degree + 1) for k in range(degree + 1 - i)]
    curves, sizes, _ = scipy.linalg.qr(np.column_stack(every), mode="economic", pivoting=True)
    # on a line or a parabola they are fewer
    count = int((np.abs(np.diagonal(sizes)) > _ACCURATE * abs(sizes[0, 0])).sum())
    own: Real = curves[:, :count]
    return own


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
