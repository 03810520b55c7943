"""Solution of ``der(x) = A x + g(t)`` in closed form, for a polynomial g.

Modal superposition gives each time independently, so no error accumulates: with
``s = t - begin``, a mode ``der(q) = l q + sum(c_k s^k)`` is
``q = phi_0(l s) q_0 + sum(c_k k! s^(k+1) phi_(k+1)(l s))`` with ``phi_0 = exp`` and
``phi_(k+1)(z) = (phi_k(z) - 1/k!) / z`` (Hochbruck and Ostermann, Acta Numerica 19 (2010) 209).
Undamped drives take their modes from singular values, as in `lumped.numerics.eigen`. If
eigenvectors are nearly parallel, the exponential of the matrix leads from one time to the next.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import scipy

from lumped.numerics.eigen import zero_rounding
from lumped.numerics.skew_scaling import skew_scaling, two_colours
from lumped.support.arrays import Boolean, Complex, Real

_EPS = float(np.finfo(float).eps)
_WORST = 1e3
"""Condition of eigenvectors up to which they are used."""
_TERMS = 22
_PATTERNS = 16
"""Patterns of nonzeros whose parts are kept."""
_MOST_GROWTH = 600.0
"""Logarithm of the largest growth that a number can hold, with some to spare."""
_Split = tuple[np.ndarray, np.ndarray, list[np.ndarray]]


class ClosedForm:
    """Closed form of the solution for one matrix.

    Parameters
    ----------
    a : ndarray or csc_array, shape (n, n)
        Constant matrix; sparse above 500 states.

    Attributes
    ----------
    words : tuple of str
        How its parts are solved.
    """

    def __init__(self, a: Real | scipy.sparse.csc_array) -> None:
        if isinstance(a, np.ndarray):
            found = _split_pattern(len(a), (a != 0).tobytes())
        else:
            a = scipy.sparse.csr_array(a)
            a.eliminate_zeros()
            found = _split(a != 0)
        self._core, self._idle, parts = found
        self._integrated = a[self._idle][:, self._core]
        self._parts = [(own, _part(a[self._core[own]][:, self._core[own]])) for own in parts]
        self.words = tuple(sorted({part.words for _, part in self._parts}))

    def solve(self, x: Real, terms: Real, s: Real) -> Real:
        """States at times after the begin.

        Parameters
        ----------
        x : ndarray, shape (n,)
            States at the begin.
        terms : ndarray, shape (degree + 1, n)
            Coefficients of the powers of s in g.
        s : ndarray, shape (k,)
            Times since the begin, increasing, s.

        Returns
        -------
        ndarray, shape (k, n)
        """
        found = np.empty((len(s), len(x)))
        core, idle = self._core, self._idle
        integrals = np.empty((len(s), len(core)))
        for own, part in self._parts:
            at = core[own]
            found[:, at], integral = part.solve(x[at], terms[:, at], s, integrate=len(idle) > 0)
            if integral is not None:
                integrals[:, own] = integral
        if not len(idle):
            return found
        powers = np.stack([s ** (k + 1) / (k + 1) for k in range(len(terms))], axis=1)
        found[:, idle] = x[idle] + (self._integrated @ integrals.T).T + powers @ terms[:, idle]
        return found

    def rounding(self, span: float) -> float:
        """Estimate of the error by rounding over a span in s, relative to the largest state."""
        return max((part.rounding(span) for _, part in self._parts), default=_EPS)


@lru_cache(_PATTERNS)
def _split_pattern(states: int, pattern: bytes) -> _Split:
    return _split(np.frombuffer(pattern, dtype=bool).reshape(states, states))


def _split(a: Boolean | scipy.sparse.csr_array) -> _Split:
    """States on which others depend, all others, and the former in parts, by nonzeros."""
    idle = a.sum(axis=0) == 0
    kept, other = np.flatnonzero(~idle), np.flatnonzero(idle)
    if not len(kept):
        return kept, other, []
    core = scipy.sparse.csr_array(a[kept][:, kept])
    count, label = scipy.sparse.csgraph.connected_components(core, directed=False)
    ends = np.cumsum(np.bincount(label, minlength=count))[:-1]
    return kept, other, np.split(np.argsort(label, kind="stable"), ends)


def _part(a: Real | scipy.sparse.csr_array) -> _Modal | _Coupled | _Stepped:
    """States that depend on each other; `words` say how they are solved."""
    full = a if isinstance(a, np.ndarray) else a.toarray()
    if full.diagonal().any():
        return _general(full)
    sparse = scipy.sparse.csr_array(a)
    sparse.eliminate_zeros()
    scale = skew_scaling(sparse)
    if scale is None:
        return _general(full)
    skew = scale[:, None] * full / scale[None, :]
    is_small = isinstance(a, np.ndarray)
    colour = _colour(len(a), (a != 0).tobytes()) if is_small else two_colours(sparse)
    if colour is not None:
        return _Coupled(skew, scale, colour)
    angular, vectors = scipy.linalg.eigh(1j * skew)
    values = zero_rounding(-1j * angular, len(angular))
    return _Modal(values, vectors / scale[:, None], vectors.conj().T * scale, 1.0, "modes")


@lru_cache(_PATTERNS)
def _colour(states: int, pattern: bytes) -> Boolean | None:
    nonzero = np.frombuffer(pattern, dtype=bool).reshape(states, states)
    return two_colours(scipy.sparse.csr_array(nonzero))


def _general(a: Real) -> _Modal | _Stepped:
    balanced, _, _, scale, _ = scipy.linalg.lapack.dgebal(a, scale=1, permute=0)
    values, vectors = np.linalg.eig(balanced)
    sizes = np.linalg.svd(vectors, compute_uv=False)
    if not sizes[0] <= _WORST * sizes[-1]:
        return _Stepped(balanced, scale)
    condition = float(sizes[0] / sizes[-1])
    back = np.linalg.inv(vectors) / scale
    one = values.imag >= 0  # the real part of a pair is twice that of one of them
    forth = scale[:, None] * vectors[:, one] * np.where(values[one].imag > 0, 2.0, 1.0)
    return _Modal(values[one], forth, back[one], condition, "eigenvectors")


@dataclass(frozen=True, eq=False)
class _Modal:
    """Eigenvalues (of a real matrix one of each pair), eigenvectors as columns, their inverse."""

    values: Complex
    vectors: Complex
    inverse: Complex
    condition: float
    words: str

    def solve(self, x: Real, terms: Real, s: Real, *, integrate: bool) -> tuple[Real, Real | None]:
        """States at the times s, and their integrals from zero to s if asked for, shapes (k, n)."""
        q, integral = _modes(
            self.values, self.inverse @ x, terms @ self.inverse.T, s, integrate=integrate
        )
        back = self.vectors.T
        return (q @ back).real, None if integral is None else (integral @ back).real

    def rounding(self, span: float) -> float:
        """Estimate of the error by rounding over a span, relative to the largest state."""
        return _phase(self._pace, span) * self.condition

    @cached_property
    def _pace(self) -> tuple[float, float]:
        return _find_pace(self.values)


class _Coupled:
    """Torsions and speeds that couple only with each other, undamped.

    With ``der(z_1) = B z_2``, ``der(z_2) = -B' z_1`` and ``B = U S W'``, the modes are
    ``c = U' z_1 - i W' z_2`` and ``der(c) = i S c``.
    """

    words = "singular values"

    def __init__(self, skew: Real, scale: Real, colour: Boolean) -> None:
        self._one, self._two = np.flatnonzero(colour), np.flatnonzero(~colour)
        u, angular, w = scipy.linalg.svd(skew[np.ix_(self._one, self._two)])
        k = max(len(u), len(w))
        self._u = np.zeros((len(u), k))
        self._w = np.zeros((len(w), k))
        self._u[:, : len(u)], self._w[:, : len(w)] = u, w.T
        angular = np.concatenate([angular, np.zeros(k - len(angular))])
        self._values = zero_rounding(1j * angular, len(angular))
        self._scale, self._pace = scale, _find_pace(self._values)

    def _c(self, rows: Real) -> Complex:
        scaled = rows * self._scale
        return scaled[..., self._one] @ self._u - 1j * (scaled[..., self._two] @ self._w)

    def _z(self, c: Complex) -> Real:
        found = np.empty((len(c), len(self._scale)))
        found[:, self._one] = c.real @ self._u.T
        found[:, self._two] = -c.imag @ self._w.T
        return found / self._scale

    def solve(self, x: Real, terms: Real, s: Real, *, integrate: bool) -> tuple[Real, Real | None]:
        c, integral = _modes(self._values, self._c(x), self._c(terms), s, integrate=integrate)
        return self._z(c), None if integral is None else self._z(integral)

    def rounding(self, span: float) -> float:
        return _phase(self._pace, span)


class _Stepped:
    """Exponential of the matrix, from one time to the next; powers of time and integrals added."""

    words = "exponential of the matrix"

    def __init__(self, balanced: Real, scale: Real) -> None:
        self._a, self._scale = balanced, scale
        self._fastest = float(scipy.linalg.eigvals(balanced).real.max())

    def solve(self, x: Real, terms: Real, s: Real, *, integrate: bool) -> tuple[Real, Real | None]:
        n, m = len(x), len(terms)
        whole = np.zeros((2 * n + m, 2 * n + m))  # states, powers of s over k!, integrals
        whole[:n, :n] = self._a
        factorials = np.array([math.factorial(k) for k in range(m)])
        whole[:n, n : n + m] = (terms * factorials[:, None] / self._scale).T
        whole[n : n + m, n : n + m] = np.diag(np.ones(m - 1), -1)
        whole[n + m :, :n] = np.eye(n)
        z = np.concatenate([x / self._scale, np.eye(m)[0], np.zeros(n)])
        found, before = np.empty((len(s), len(z))), 0.0
        known: list[tuple[float, Real]] = []
        for i, time in enumerate(s.tolist()):
            h = time - before
            same = [e for step, e in known if abs(step - h) <= 4 * _EPS * time]
            if not same:
                known = [*known[-3:], (h, scipy.linalg.expm(whole * h))]
            found[i] = z = (same[0] if same else known[-1][1]) @ z
            before = time
        return found[:, :n] * self._scale, found[:, n + m :] * self._scale

    def rounding(self, span: float) -> float:
        if self._fastest * span > _MOST_GROWTH:
            return np.inf
        size = float(scipy.linalg.norm(self._a, 2))
        return 2 * _EPS * (5 + size * span)


def _find_pace(values: Complex) -> tuple[float, float]:
    """Decay of the slowest mode, and the largest eigenvalue, 1/s."""
    return float(-values.real.max()), float(np.abs(values).max())


def _phase(pace: tuple[float, float], span: float) -> float:
    """What rounding in the largest eigenvalue does to the slowest mode while it lasts."""
    decay, largest = pace
    if -decay * span > _MOST_GROWTH:
        return np.inf
    lasting = min(span, 1 / decay) if decay > 0 else span
    return 2 * _EPS * (5 + largest * lasting)


def _modes(
    values: Complex, q: Complex, terms: Complex, s: Real, *, integrate: bool
) -> tuple[Complex, Complex | None]:
    """Modes, and their integrals if they are asked for, shapes (k, modes)."""
    phi = _phis(np.multiply.outer(s, values), len(terms) + int(integrate))
    found = phi[0] * q
    integral = s[:, None] * phi[1] * q if integrate else None
    for k, c in enumerate(terms):
        if c.any():
            power = math.factorial(k) * s[:, None] ** (k + 1)
            found += power * phi[k + 1] * c
            if integral is not None:
                integral += power * s[:, None] * phi[k + 2] * c
    return found, integral


def _phis(z: Complex, highest: int) -> list[Complex]:
    """phi_0 to phi_highest."""
    if highest == 1:
        away = np.where(z == 0.0, 1.0, z)
        with np.errstate(over="ignore", invalid="ignore"):
            return [np.exp(z), np.where(z == 0.0, 1.0, np.expm1(z) / away)]
    small = np.abs(z) < 1
    with np.errstate(over="ignore", invalid="ignore"):
        found = [np.exp(z)]
    near = z[small]
    series = np.zeros_like(near)
    for j in range(_TERMS, -1, -1):
        series = series * near + 1 / math.factorial(highest + j)
    low = [series]
    for k in range(highest - 1, 0, -1):
        low.append(low[-1] * near + 1 / math.factorial(k))
    far = np.where(small, 1.0, z)
    for k in range(highest):
        found.append((found[k] - 1 / math.factorial(k)) / far)
    for k, values in zip(range(highest, 0, -1), low, strict=True):
        found[k][small] = values
    return found
