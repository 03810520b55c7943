"""Largest vibrations between the speeds of an order response."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lumped.support.arrays import Complex, Integer, Real
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum

Signals = Callable[[OrderResponse], Complex]
"""What counts of a vibration, shape (k, q)."""
Sizes = Callable[[Real, Complex], Real]
"""What is judged, shape (k,), from speeds and such signals."""

_WIDTH = 0.7
"""Width of a stretch of speeds over its distance from the nearest resonance."""
_SHARPEST = 1e-7
"""Least damping ratio that is told from none."""
_SAMPLES, _PASSES, _LOOKS = 9, 4, 2000
"""How resonances are followed that depend on the speed."""
_KNOWN = 1e-3
"""Share of a speed within which its modes are those of another."""
_DEGREE = 16
"""Of polynomials through signals beside a maximum."""
_POINTS, _ZOOMS, _FINE = 33, 5, 2049
_NEAR = 0.8
"""Share of the largest size, or of one, from which on a maximum is located."""
_AGREE = 1e-8
"""Relative difference of a maximum from that of the polynomials."""
_ROUNDS, _HALVINGS = 6, 50
_STEP, _ROUNDING = 1e-3, 1e-13
"""Of slopes, as a share of the width of a neighbourhood, and of sizes."""
_TOGETHER = 400
"""Speeds that are computed at once."""


@dataclass(frozen=True)
class OrderPeaks:
    """A size over the speed, with its maxima.

    Attributes
    ----------
    speeds, sizes : ndarray, shape (k,)
        Ascending speeds, rad/s, and the size at each; the maxima are among them.
    stretches : tuple of (float, float)
        Ends of the ranges of speeds in which the size exceeds one.
    missed : float
        Largest difference between a maximum and that of polynomials through its neighbourhood,
        over the largest size.
    """

    speeds: Real
    sizes: Real
    stretches: tuple[tuple[float, float], ...]
    missed: float


def find_crests(sizes: Real) -> Integer:
    """Where a curve is at least as high as on both sides."""
    high = np.concatenate([[-np.inf], sizes, [-np.inf]])
    inner = high[1:-1]
    return np.flatnonzero((inner >= high[:-2]) & (inner >= high[2:]))


def find_order_peaks(
    response: OrderResponse, signals: Signals, sizes: Sizes, between: tuple[float, float]
) -> OrderPeaks:
    """A size of a vibration over a range of speeds, with all its maxima.

    An amplitude of order o is analytic in the speed n but for poles ``s / (j o)``, s being the
    eigenvalues of the drive that turns at n. The range is cut into stretches that are narrow beside
    their distance from these, so that in each the amplitude changes little: a maximum is beside the
    largest of their ends, and polynomials through Chebyshev's points there follow the amplitudes to
    rounding (Trefethen, Approximation Theory and Approximation Practice (2013), theorem 8.2). The
    response at each maximum tells whether they do; if not, its neighbourhood is looked at again.

    Raises
    ------
    SolverError
        If the vibration cannot be computed at a speed in between.
    """
    low, high = between
    inside = (response.speeds >= low) & (response.speeds <= high)
    own = response.speeds[inside]
    found = _Curve(response, signals, sizes, between)
    found.add(own, signals(response)[inside])
    speeds = np.unique([low, high, *own])
    found.add(np.setdiff1d(_cut(response, speeds) if low < high else speeds, own))
    missed = 0.0
    for _ in range(_ROUNDS if low < high else 0):
        missed = found.locate()
        if missed <= _AGREE:
            break
    return OrderPeaks(found.speeds, found.sizes, found.find_stretches(), missed)


def fill_in(response: OrderResponse) -> OrderResponse:
    """A response with more speeds: narrow beside resonances, and where each order is largest.

    Of each quantity, all orders in phase count, too.
    """

    def list_signals(found: OrderResponse) -> Complex:
        return found.values.reshape(len(found.speeds), -1)

    def measure(signals: Complex) -> Real:
        each = np.abs(signals).reshape(*signals.shape[:-1], len(response.orders), -1)
        both = np.concatenate([each, each.sum(axis=-2, keepdims=True)], axis=-2)
        return both.reshape(*signals.shape[:-1], -1)

    curve = _Curve(response, list_signals, lambda speeds, _: speeds, (0.0, np.inf))
    speeds = _cut(response, response.speeds)
    tops = measure(list_signals(response.at_speeds(speeds))).argmax(axis=0)
    stretches, own = np.unique(tops, return_inverse=True)
    low = speeds[np.maximum(stretches - 1, 0)]
    high = speeds[np.minimum(stretches + 1, len(speeds) - 1)]
    inner = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, _FINE)
    sizes = measure(curve.follow(low, high)(inner))
    best = inner[own, sizes[own, :, np.arange(len(own))].argmax(axis=1)]
    return response.at_speeds(np.unique([*speeds, *best]))


class _Curve:
    """A size at speeds, which grow in number."""

    def __init__(
        self,
        response: OrderResponse,
        signals: Signals,
        sizes: Sizes,
        between: tuple[float, float],
    ) -> None:
        self._response, self._signals, self._sizes = response, signals, sizes
        self._between = between
        self.speeds, self.sizes = np.zeros(0), np.zeros(0)

    def _signals_at(self, speeds: Real) -> Complex:
        """Signals at speeds in any order."""
        distinct, back = np.unique(speeds, return_inverse=True)
        parts = [
            self._signals(self._response.at_speeds(distinct[k : k + _TOGETHER]))
            for k in range(0, len(distinct), _TOGETHER)
        ]
        found: Complex = np.concatenate(parts)[back]
        return found

    def _size(self, speeds: Real, signals: Complex) -> Real:
        """Sizes of signals; what is permitted is known at these speeds only."""
        return self._sizes(np.clip(speeds, *self._between), signals)

    def add(self, speeds: Real, signals: Complex | None = None) -> Real:
        """Sizes at more speeds, which are kept."""
        if not len(speeds):
            return speeds
        found = self._size(speeds, self._signals_at(speeds) if signals is None else signals)
        every, sizes = np.append(self.speeds, speeds), np.append(self.sizes, found)
        self.speeds, place = np.unique(every, return_index=True)
        self.sizes = sizes[place]
        return found

    def _approximate(self, begin: Real, end: Real) -> Callable[[Real], Real]:
        """Sizes by polynomials over stretches: a function of speeds, shape (stretches, p)."""
        follow = self.follow(begin, end)

        def sizes(speeds: Real) -> Real:
            found = self._size(speeds.ravel(), follow(speeds).reshape(speeds.size, -1))
            return found.reshape(speeds.shape)

        return sizes

    def follow(self, begin: Real, end: Real) -> Callable[[Real], Complex]:
        """Signals by polynomials over stretches, of speeds in each, shape (stretches, p)."""
        nodes = np.cos(np.pi * np.arange(_DEGREE, -1, -1) / _DEGREE)
        weights = (-1.0) ** np.arange(_DEGREE + 1)
        weights[[0, -1]] *= 0.5
        middle, half = 0.5 * (begin + end)[:, None], 0.5 * (end - begin)[:, None]
        at = np.clip(middle + half * nodes, begin[:, None], end[:, None])
        given = self._signals_at(at.ravel()).reshape(*at.shape, -1)

        def signals(speeds: Real) -> Complex:
            away = ((speeds - middle) / half)[..., None] - nodes
            met = np.abs(away) < 1e-14
            share = np.where(met, 1.0, weights / np.where(met, 1.0, away))
            share = np.where(met | ~met.any(axis=2, keepdims=True), share, 0.0)
            found: Complex = (share / share.sum(axis=2, keepdims=True)) @ given
            return found

        return signals

    def locate(self) -> float:
        """Add the maxima beside large sizes; by how much polynomials miss one of them."""
        crests, most = find_crests(self.sizes), float(self.sizes.max())
        size = self.sizes[crests]
        crests = crests[(size >= _NEAR * most) | ((size >= _NEAR) & (size <= 1))]
        low = self.speeds[np.maximum(crests - 1, 0)]
        high = self.speeds[np.minimum(crests + 1, len(self.speeds) - 1)]
        wide = high - low > 1e-11 * high
        low, high = low[wide], high[wide]
        if not len(low) or not most:
            return 0.0
        approximate, lines, width = self._approximate(low, high), np.arange(len(low)), high - low
        for _ in range(_ZOOMS):
            speeds = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, _POINTS)
            sizes = approximate(speeds)
            top = sizes.argmax(axis=1)
            best, told = speeds[lines, top], sizes[lines, top]
            low = speeds[lines, np.maximum(top - 1, 0)]
            high = speeds[lines, np.minimum(top + 1, _POINTS - 1)]
        best, told = _polish(approximate, best, told, _STEP * width)
        return float(np.abs(self.add(best) - told).max() / most)

    def find_stretches(self) -> tuple[tuple[float, float], ...]:
        """Where sizes exceed one; ends by polynomials."""
        above = np.concatenate([[False], self.sizes > 1, [False]])
        edges = np.flatnonzero(above[1:] != above[:-1])
        inner = edges[(edges > 0) & (edges < len(self.speeds))]
        ends = {0: float(self.speeds[0]), len(self.speeds): float(self.speeds[-1])}
        if len(inner):
            low, high = self.speeds[inner - 1], self.speeds[inner]
            approximate, after = self._approximate(low, high), above[1:][inner]
            for _ in range(_HALVINGS):
                middle = 0.5 * (low + high)
                is_after = (approximate(middle[:, None])[:, 0] > 1) == after
                low, high = np.where(is_after, low, middle), np.where(is_after, middle, high)
            ends |= dict(zip(inner.tolist(), high.tolist(), strict=True))
        pairs = edges.reshape(-1, 2).tolist()
        return tuple((ends[begin], ends[end]) for begin, end in pairs)


def _polish(
    approximate: Callable[[Real], Real], best: Real, told: Real, step: Real
) -> tuple[Real, Real]:
    """Where a slope vanishes beside the largest of samples, and the size there.

    Samples tell the place to the root of rounding only; where a maximum is a kink, they tell more.
    """
    low, high = best - step, best + step
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        beside = approximate(middle[:, None] + step[:, None] * np.array([-2, -1, 1, 2]))
        rises = beside @ np.array([1.0, -8.0, 8.0, -1.0]) > 0
        low, high = np.where(rises, middle, low), np.where(rises, high, middle)
    sizes = approximate(middle[:, None])[:, 0]
    better = (sizes >= told * (1 - _ROUNDING)) & (np.abs(middle - best) < 0.99 * step)
    return np.where(better, middle, best), np.where(better, sizes, told)


def _cut(response: OrderResponse, speeds: Real) -> Real:
    """Ends of stretches that are narrow beside their distance from resonances."""
    poles = _Poles(response, float(speeds[0]), float(speeds[-1]))
    found, begin, end = [speeds], speeds[:-1], speeds[1:]
    while len(begin):
        middle = 0.5 * (begin + end)
        wide = end - begin > _WIDTH * poles.find_distance(middle)
        begin, end, middle = begin[wide], end[wide], middle[wide]
        found.append(middle)
        begin, end = np.append(begin, middle), np.append(middle, end)
    return np.unique(np.concatenate(found))


class _Poles:
    """Poles of amplitudes over the speed, by the modes at some speeds, on lines between these.

    Modes that depend on the speed are taken where they resonate, too.
    """

    def __init__(self, response: OrderResponse, low: float, high: float) -> None:
        self._response, self._orders = response, response.orders
        self._known: dict[float, Complex] = {}
        steady = response.at_speeds(np.linspace(low, high, _SAMPLES)).rotation
        held = steady.x[:, ~steady.idle], steady.theta, steady.settings
        if all((part == part[0]).all() for part in held) and not steady.turns_matter:
            self._look(steady.speeds[:1])
            return
        self._look(steady.speeds)
        looks = np.linspace(low, high, _LOOKS)
        for _ in range(_PASSES):
            away = looks[:, None, None] - self._at(looks).real
            k, order, mode = np.nonzero(away[1:] * away[:-1] < 0)
            share = away[k, order, mode] / (away[k, order, mode] - away[k + 1, order, mode])
            met = np.unique(looks[k] + share * (looks[k + 1] - looks[k]))
            known = np.array(list(self._known))
            new = np.abs(met[:, None] - known).min(axis=1, initial=np.inf) > _KNOWN * met
            if not new.any():
                break
            self._look(met[new])

    def _look(self, speeds: Real) -> None:
        found = self._response.at_speeds(speeds)
        for k, speed in enumerate(speeds.tolist()):
            own = MeanSpectrum(found.small, found.rotation.at(k), found.orders).eigenvalues
            damping = np.abs(own.real) / np.abs(own) + self._response.damping_ratio
            damping = np.clip(damping, _SHARPEST, 1.0)
            self._known[speed] = np.abs(own) * (np.sqrt(1 - damping**2) + 1j * damping)

    def _at(self, speeds: Real) -> Complex:
        """Poles at speeds, shape (k, orders, modes)."""
        places = np.array(sorted(self._known))
        table = np.zeros((len(places), max(map(len, self._known.values()))), dtype=complex)
        for row, place in zip(table, places.tolist(), strict=True):
            row[: len(self._known[place])] = self._known[place]
        k = np.clip(np.searchsorted(places, speeds) - 1, 0, max(len(places) - 2, 0))
        after = np.minimum(k + 1, len(places) - 1)
        width = np.where(after > k, places[after] - places[k], 1.0)
        share = np.clip((speeds - places[k]) / width, 0, 1)[:, None]
        moved: Complex = (1 - share) * table[k] + share * table[after]
        return moved[:, None] / self._orders[:, None]

    def find_distance(self, speeds: Real) -> Real:
        """Distance of speeds from the nearest pole, or from standstill."""
        found = speeds.copy()
        for k in range(0, len(speeds), _TOGETHER):
            own = speeds[k : k + _TOGETHER]
            away = np.abs(own[:, None, None] - self._at(own))
            found[k : k + _TOGETHER] = np.minimum(own, away.min(axis=(1, 2), initial=np.inf))
        return found
