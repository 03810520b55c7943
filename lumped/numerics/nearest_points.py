"""Points of a surface ``g(u) == 0`` that are nearest to the origin, with exact gradients of g."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lumped.support.arrays import Real

FURTHEST = 8.0
"""Radius within which points are searched; a probability of 6e-16 is left beyond."""

_LONGEST = 4.0
"""Length of a step."""
_CLOSE = 1e-7
"""Distance from the surface, and from where its normal meets the origin, at which a search ends."""
_GOOD = 1e-3
"""The same that counts as found where rounding, or the error of runs, lets a search go no nearer.
The distance of the point is then exact to a millionth."""
_SAME = 0.05
"""Distance of two points, relative to that from the origin, below which they are one."""
_FLAT = 1e-12
"""Gradient, relative to g, that is rounding."""
_SHORTEST, _SHORT = 2.0**-10, 2.0**-3
"""Share of a step, and of one from a point that counts as found."""
_LEAST = 1e-3
"""Share of g that a step must take away at the border."""
_MOST = 60
"""Evaluations of a search."""


class Search:
    """One search, which says where it needs a value and a gradient next.

    Sequential quadratic programming for ``min |u|^2 / 2`` under ``g(u) == 0``: the first step is
    that of Hasofer, Lind, Rackwitz and Fiessler, later ones use the curvature that the gradients
    have shown (damped BFGS; Powell 1978). Steps are shortened until they make the merit function
    ``|u|^2 / 2 + c |g|`` smaller.

    Parameters
    ----------
    begin : ndarray, shape (d,)
        Where it begins.

    Attributes
    ----------
    next : ndarray, shape (d,)
        Where it needs g and its gradient.
    ended : bool
        Whether it has come to its end.
    u, slope : ndarray, shape (d,)
        Point reached, and the gradient there.
    g : float
        The value there; nan if there is none.

    Notes
    -----
    P.-L. Liu, A. Der Kiureghian: Optimization algorithms for structural reliability. Structural
    Safety 9 (1991) 161-177. Y. Zhang, A. Der Kiureghian: Two improved algorithms for reliability
    analysis. Proc. 6th IFIP WG 7.5, 1995, 297-304 (merit function).
    """

    def __init__(self, begin: Real) -> None:
        self.next = np.array(begin, dtype=float)
        self.u, self.g, self.slope = self.next, np.nan, np.zeros(len(begin))
        self.ended, self.count = False, 0
        self._curved = np.eye(len(begin))
        self._step, self._share, self._price, self._multiplier = self.slope, 1.0, 0.0, 0.0

    def take(self, g: float, slope: Real) -> None:
        """Go on with the value and the gradient at `next`; not numbers where there are none."""
        self.count += 1
        known = bool(np.isfinite(g) and np.isfinite(slope).all())
        if self.count == 1 and known:
            self._arrive(g, slope)
        elif known and self._is_better(g):
            self._learn(slope)
            self._arrive(g, slope)
        elif self.count == 1 or self._share < 2 * (_SHORT if self.is_found else _SHORTEST):
            self.ended = True
        else:
            self._share /= 2
            self.next = self.u + self._share * self._step
        self.ended = self.ended or self.count >= _MOST

    @property
    def is_flat(self) -> bool:
        """Whether g does not change at the point, rounding apart."""
        return bool(_norm(self.slope) <= _FLAT * abs(self.g))

    @property
    def is_on_surface(self) -> bool:
        """Whether the point lies on the surface."""
        size = _norm(self.slope)
        return size > 0 and abs(self.g) / size <= _GOOD * (1 + _norm(self.u))

    @property
    def is_found(self) -> bool:
        """Whether the point lies on the surface, and the normal there meets the origin."""
        return self._is_within(_GOOD)

    def _is_within(self, tolerance: float) -> bool:
        size = _norm(self.slope)
        if not (np.isfinite(self.g) and size > 0):
            return False
        normal = self.slope / size
        aside = _norm(self.u - normal * (normal @ self.u))
        near = tolerance * (1 + _norm(self.u))
        return abs(self.g) / size <= near and aside <= near

    def _arrive(self, g: float, slope: Real) -> None:
        is_stuck = abs(g) > (1 - _LEAST) * abs(self.g) and _norm(self.next) > FURTHEST - _CLOSE
        self.u, self.g, self.slope = self.next, g, slope
        if self.is_flat or is_stuck or self._is_within(_CLOSE):
            self.ended = True
            return
        if not self._find_step():
            self._curved = np.eye(len(self.u))
            self.ended = not self._find_step()
        self._share = 1.0
        self.next = self.u + self._step

    def _find_step(self) -> bool:
        """The step, and the weight of g in the merit function; whether this falls along it."""
        both = np.linalg.solve(self._curved, np.column_stack([self.u, self.slope]))
        self._multiplier = float((self.g - self.slope @ both[:, 0]) / (self.slope @ both[:, 1]))
        aim = self.u - both[:, 0] - self._multiplier * both[:, 1]
        aim *= min(1.0, FURTHEST / max(_norm(aim), FURTHEST))
        step = aim - self.u
        length = _norm(step)
        self._step = step * min(1.0, _LONGEST / max(length, _LONGEST))
        inward, nearer = float(self.u @ self._step), self._nearer()
        self._price = 2 * abs(self._multiplier)
        if nearer > 0:
            self._price = max(self._price, 2 * inward / nearer)
        return length > _CLOSE and inward < self._price * nearer

    def _nearer(self) -> float:
        """How much smaller the size of g becomes along the step, at first."""
        return -float(np.sign(self.g) * (self.slope @ self._step))

    def _is_better(self, g: float) -> bool:
        here = self.u @ self.u / 2 + self._price * abs(self.g)
        there = self.next @ self.next / 2 + self._price * abs(g)
        falls = self._price * self._nearer() - self.u @ self._step
        return bool(there <= here - 1e-4 * self._share * falls)

    def _learn(self, slope: Real) -> None:
        """Curvature of the Lagrangian along the last step."""
        step = self.next - self.u
        turned = step + self._multiplier * (slope - self.slope)
        bent = self._curved @ step
        own, seen = float(step @ bent), float(step @ turned)
        if seen < 0.2 * own:
            share = 0.8 * own / (own - seen)
            turned = share * turned + (1 - share) * bent
        self._curved = (
            self._curved + np.outer(turned, turned) / (step @ turned) - np.outer(bent, bent) / own
        )


def is_same(u: Real, other: Real) -> bool:
    """Whether two points nearest to the origin are one."""
    return _norm(u - other) < _SAME * (1 + _norm(u))


def search_together(
    slopes: Callable[[Real], tuple[Real, Real]], begins: Sequence[Real], known: Sequence[Real] = ()
) -> list[Search]:
    """Searches from several points, whose next evaluations are made together.

    Parameters
    ----------
    slopes : callable
        Values, shape (n,), and gradients, shape (n, d), at points of shape (n, d).
    begins : sequence of ndarray, each of shape (d,)
        Where they begin.
    known : sequence of ndarray, each of shape (d,)
        Points found before; a search that comes to one of them ends.
    """
    every = [Search(begin) for begin in begins]
    while under_way := [
        search
        for search in every
        if not (search.ended or any(is_same(search.next, u) for u in known))
    ]:
        values, gradients = slopes(np.array([search.next for search in under_way]))
        for search, value, gradient in zip(under_way, values, gradients, strict=True):
            search.take(float(value), gradient)
    return every


def _norm(vector: Real) -> float:
    return float(np.linalg.norm(vector))
