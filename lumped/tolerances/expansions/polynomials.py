"""Orthonormal polynomials of independent random variables, and sets of their products."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lumped.support.arrays import Integer, Real

_MOST = 16
"""Greatest degree in one variable."""
_REACH, _NODES = 8.0, 8193
"""Range of a standard normal variable that holds all but 1e-15 of it, and nodes in it."""
_DISTINCT = 1e-10
"""Size of the next polynomial, of a variable with deviation one, that is nothing but rounding."""
_FLAT = 0.01
"""Change of a bounded parameter beyond five deviations, in its change within one."""


@dataclass(frozen=True, eq=False)
class Family:
    """Orthonormal polynomials of one random variable ``z`` with mean 0 and deviation 1.

    They follow ``off[k + 1] p[k + 1] = (z - diagonal[k]) p[k] - off[k] p[k - 1]``.

    Attributes
    ----------
    mean, deviation : float
        Of the parameter ``x = mean + deviation z``; 0 and 1 where z is the standard normal
        variable behind it.
    bounded : bool
        Whether z is the parameter itself.
    diagonal, off : ndarray, shape (m,), (m + 1,)
        Coefficients for degrees up to m.
    rates : ndarray, shape (m + 1,)
        Mean squares of the derivatives of the polynomials, with Stein's kernel as a weight.
    grid, kernel : ndarray
        Values of z, and Stein's kernel of its law there.
    """

    mean: float
    deviation: float
    bounded: bool
    diagonal: Real
    off: Real
    rates: Real
    grid: Real
    kernel: Real

    @property
    def most(self) -> int:
        """Greatest degree."""
        return len(self.diagonal)

    def weights(self, z: Real) -> Real:
        """Stein's kernel at values of z.

        With it as a weight, derivatives of different polynomials are orthogonal for normal,
        uniform and beta laws, and those of degree one are orthogonal to all others for any law.
        """
        return np.interp(z, self.grid, self.kernel)

    def values(self, z: Real, degree: int) -> tuple[Real, Real]:
        """Polynomials and their derivatives, shape (degree + 1, n) each."""
        p, dp = np.zeros((2, degree + 1, len(z)))
        p[0] = 1.0
        for k in range(degree):
            shifted = z - self.diagonal[k]
            p[k + 1], dp[k + 1] = shifted * p[k], p[k] + shifted * dp[k]
            if k:
                p[k + 1] -= self.off[k] * p[k - 1]
                dp[k + 1] -= self.off[k] * dp[k - 1]
            p[k + 1] /= self.off[k + 1]
            dp[k + 1] /= self.off[k + 1]
        return p, dp


NORMAL = Family(
    0.0,
    1.0,
    False,
    np.zeros(_MOST),
    np.sqrt(np.arange(_MOST + 1.0)),
    np.arange(_MOST + 1.0),
    np.array([-_REACH, _REACH]),
    np.ones(2),
)
"""Hermite's polynomials of a standard normal variable."""


def standard_normal() -> Real:
    """Values of a standard normal variable over which laws are summed up, shape (n,)."""
    return np.linspace(-_REACH, _REACH, _NODES)


def family_of(x: Real) -> Family:
    """Polynomials for a parameter whose values at `standard_normal` are `x`.

    A bounded parameter is the variable itself. Functions of it are as smooth as the drive makes
    them, while in the standard normal variable they have a flat beginning and end, which no
    polynomial follows, and in its probability roots at the ends unless it is uniform. Parameters
    without bounds use the normal variable, in which they are smooth, and normal ones linear;
    polynomials of a lognormal parameter itself do not even reach all functions of it.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Ascending or descending.

    Returns
    -------
    Family

    Notes
    -----
    D. Xiu, G. E. Karniadakis: The Wiener-Askey polynomial chaos for stochastic differential
    equations. SIAM Journal on Scientific Computing 24 (2002) 619-644. Coefficients by Stieltjes'
    procedure: W. Gautschi, Orthogonal Polynomials. Oxford 2004, section 2.2.3.1. Lognormal:
    O. G. Ernst, A. Mugler, H.-J. Starkloff, E. Ullmann, On the convergence of generalized
    polynomial chaos expansions. ESAIM: M2AN 46 (2012) 317-339.
    """
    if x[-1] < x[0]:
        return family_of(x[::-1])  # the normal law has no direction
    u = standard_normal()
    lowest, low, near, beside, high, highest = np.interp((-8, -5, -1, 1, 5, 8), u, x).tolist()
    if max(low - lowest, highest - high) > _FLAT * (beside - near):
        return NORMAL
    density = np.exp(-0.5 * u**2)
    weights = density / density.sum()
    mean = float(weights @ x)
    deviation = float(np.sqrt(weights @ (x - mean) ** 2))
    z = (x - mean) / deviation
    diagonal, off = _recurrence(z, weights)
    part = weights * z
    # from the nearer end, as the sum of all is zero only up to rounding
    above = np.where(u > 0, np.cumsum(part[::-1])[::-1], -np.cumsum(part) + part) - 0.5 * part
    kernel = np.maximum(above, 0.0) * np.gradient(z) / weights
    found = Family(mean, deviation, True, diagonal, off, np.zeros(0), z, kernel)
    _, slopes = found.values(z, found.most)
    return replace(found, rates=slopes**2 @ (weights * kernel))


def _recurrence(z: Real, weights: Real) -> tuple[Real, Real]:
    """Coefficients for values with weights that sum to one."""
    diagonal, off = [], [1.0]
    before, p = np.zeros_like(z), np.ones_like(z)
    for k in range(_MOST):
        diagonal.append(float(weights @ (z * p**2)))
        following = (z - diagonal[k]) * p - (off[k] * before if k else 0.0)
        size = float(np.sqrt(weights @ following**2))
        if size < _DISTINCT:  # a law of k + 1 values has no more
            diagonal.pop()
            break
        off.append(size)
        before, p = p, following / size
    return np.array(diagonal), np.array(off)


def list_exponents(most: Sequence[int], norm: float, count: int) -> Integer:
    """Degrees of products in each variable, shape (P, d); the first is the constant.

    Parameters
    ----------
    most : sequence of int
        Greatest degree in each variable.
    norm : float
        1 for the total degree; less for hyperbolic sets, which leave out products of many
        variables: ``sum(degree**norm)**(1 / norm)`` is limited.
    count : int
        Of products, at most; the limit is the greatest whole number that keeps to it.
    """
    chosen: list[_Product] = [()]
    for degree in range(1, max(most) + 1):
        every = _products_up_to(most, norm, degree**norm * (1 + 1e-12))
        found = list(itertools.islice(every, count + 1))
        if len(found) > count:
            break
        chosen += sorted(set(found) - set(chosen), key=_list_powers)
    exponents = np.zeros((len(chosen), len(most)), dtype=np.int64)
    for row, product in zip(exponents, chosen, strict=True):
        for place, degree in product:
            row[place] = degree
    return exponents


_Product = tuple[tuple[int, int], ...]
"""Variables of a product and their degrees, in ascending order of the variables."""


def _list_powers(product: _Product) -> tuple[int, list[int], list[int]]:
    """How many variables a product has, which, and their degrees."""
    return len(product), [place for place, _ in product], [degree for _, degree in product]


def _products_up_to(
    most: Sequence[int], norm: float, size: float, begun: _Product = ()
) -> Iterator[_Product]:
    """All products whose sum of ``degree**norm`` is limited, each begun with the same factors."""
    yield begun
    first = begun[-1][0] + 1 if begun else 0
    for place in range(first, len(most)):
        for degree in range(1, most[place] + 1):
            left = size - degree**norm
            if left < 0:
                break
            yield from _products_up_to(most, norm, left, (*begun, (place, degree)))


def products(families: Sequence[Family], z: Real, exponents: Integer) -> Real:
    """Products of polynomials at points.

    Parameters
    ----------
    families : sequence of Family
        One for each variable.
    z : ndarray, shape (n, d)
    exponents : ndarray of int, shape (P, d)

    Returns
    -------
    ndarray, shape (P, n)
    """
    tables = _tables(families, z, exponents)
    return _multiply([p for p, _ in tables], exponents, len(z))


def slopes_of_products(families: Sequence[Family], z: Real, exponents: Integer) -> Real:
    """Derivatives of products by each variable, shape (d, P, n)."""
    tables = _tables(families, z, exponents)
    found = np.zeros((len(families), len(exponents), len(z)))
    for i in range(len(families)):
        there = exponents[:, i] > 0
        chosen = [dp if i == j else p for j, (p, dp) in enumerate(tables)]
        found[i, there] = _multiply(chosen, exponents[there], len(z))
    return found


def _tables(families: Sequence[Family], z: Real, exponents: Integer) -> list[tuple[Real, Real]]:
    most = exponents.max(axis=0).tolist()
    return [f.values(z[:, j], most[j]) for j, f in enumerate(families)]


def _multiply(tables: Sequence[Real], exponents: Integer, count: int) -> Real:
    found = np.ones((len(exponents), count))
    for j, rows in enumerate(tables):
        there = exponents[:, j] > 0
        found[there] *= rows[exponents[there, j]]
    return found
