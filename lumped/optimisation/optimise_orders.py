"""Parameters for which vibrations of an order response keep limits at all its speeds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lumped.errors import OptimisationError, OptionError
from lumped.functionals import Functional
from lumped.functionals.readings import OrderPeak, Reading, Separation
from lumped.numerics.nlp import Solution
from lumped.optimisation.design import Task
from lumped.optimisation.search import Row
from lumped.optimisation.spectral_search import SpectralSearch, Spectrum
from lumped.support.arrays import Boolean, Real
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import sizes_of, slope_of
from lumped.vibration.speeds.mean_campbell import speeds_that_show
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum
from lumped.vibration.speeds.order_designs import OrderDesigns
from lumped.vibration.speeds.order_peaks import OrderPeaks, find_crests

Spectra = Callable[[Real, Real], Sequence[MeanSpectrum]]
"""Spectra of a design, by its unknowns, at speeds, rad/s."""

_CROSSED = 1e-9
"""Share of an order's frequency by which a mode may be on the wrong side of it."""
_WIDEST = 0.95
"""Largest separation."""
_OVER = 1e-9
"""Share by which a limit may be exceeded at a speed that the search does not know."""
_LARGE = 0.3
"""Share of the largest maximum from which on others are watched from the start."""
_BESIDE = 0.99
"""Share of the largest maximum that is reached on its side."""
_SAME = 1e-7
"""Relative distance from a speed that is watched within which a maximum is the same."""


class OrderSearch(SpectralSearch):
    """The part of `optimise` for order responses.

    With one unknown more for each peak that is made small.
    """

    def __init__(self, begin: OrderResponse, task: Task) -> None:
        self.first, self.again = begin, OrderDesigns(begin, "optimise")
        super().__init__(begin, begin.rotation.points[0], task)
        self.again.refuse_balancing(self.names, "vary")
        self.places = self.system.places(self.names)
        self.last: tuple[bytes, OrderResponse] | None = None
        self.spectra: tuple[bytes, dict[float, MeanSpectrum]] = b"", {}
        self.modes: int | None = None
        self.designs: set[bytes] = set()
        self.slopes: dict[tuple[OrderPeak, float], np.ndarray] = {}
        self.curves: dict[OrderPeak, OrderPeaks] = {}
        self.begin()
        self.peaks = [reading for reading in self.alone if isinstance(reading, OrderPeak)]
        self.watched = {key: self._crests(key, self.box[:, 0], _LARGE) for key in self.peaks}
        self.size = {key: self._largest(key, self.box[:, 0]) for key in self.peaks}
        self._watch()
        for key in self.peaks:
            self._check_peak(key)
            if Functional.of(key) in self.weights:
                self.add_unknown(key, 1.0, self.size[key])
        self.apart: dict[Separation, Apart] = {}
        for wanted in self.alone:
            if isinstance(wanted, Separation):
                self._begin_apart(wanted)

    def solve_design(self) -> tuple[Solution, tuple[str, ...]]:
        """Best unknowns, for which limits hold at all speeds.

        The limits hold at some speeds; those at which the best design exceeds them are added, until
        there are none (exchange method: Hettich and Kortanek, SIAM Review 35 (1993) 380).
        """
        iterations, seconds = 0, 0.0
        while True:
            solution, active = super().solve_design()
            iterations, seconds = iterations + solution.iterations, seconds + solution.seconds
            if not self.extend(solution.w):
                return replace(solution, iterations=iterations, seconds=seconds), active
            self.box[:, 0] = solution.w

    def _begin_apart(self, key: Separation) -> None:
        begin, _ = self._asked(key, self.box[:, 0])
        _, high = self.bounds_of(key)
        if (
            np.isfinite(high)
            or self.weights.get(Functional.of(key), 0.0) > 0
            or not begin < _WIDEST
        ):
            raise OptionError(
                f"optimise: {key} can be made large (a negative weight), or bounded below by a "
                f"share under {_WIDEST:g}."
            )
        self.apart[key] = Apart(key, self.spectra_at, self.box[:, 0], begin)
        if Functional.of(key) in self.weights:
            self.add_unknown(key, begin, 1.0, (begin, _WIDEST))

    def _asked(self, key: Separation, w: np.ndarray) -> tuple[float, np.ndarray]:
        """The least separation that is asked for, and its gradient where it is an unknown."""
        if key in self.unknown:
            return self.of_reading(key, w)
        return max(self.bounds_of(key)[0], 0.0), np.zeros(len(w))

    def _check_peak(self, key: OrderPeak) -> None:
        low, high = self.bounds_of(key)
        if np.isfinite(low) or high <= 0 or self.weights.get(Functional.of(key), 0.0) < 0:
            raise OptionError(
                f"optimise: {key} can be made small or bounded above by a positive value."
            )
        if not self.size[key]:
            raise OptionError(f"optimise: {key} is zero: this quantity does not vibrate.")

    def result(self, w: np.ndarray) -> OrderResponse:
        """Vibration of a design."""
        u = w[: len(self.names)]
        if self.last is None or self.last[0] != u.tobytes():
            found = self.again.response(self.values_at(u))
            self.last, self.curves = (u.tobytes(), found), {}
            self._count(u)
        return self.last[1]

    def _watch(self) -> None:
        """Compute designs at the speeds that are watched."""
        speeds = sorted({speed for own in self.watched.values() for speed in own})
        self.there: tuple[bytes, OrderResponse] | None = None
        if speeds:
            self.few = OrderDesigns(self.first.at_speeds(np.array(speeds)), "optimise")

    def _response_watched(self, w: np.ndarray) -> OrderResponse:
        u = w[: len(self.names)]
        if self.there is None or self.there[0] != u.tobytes():
            found = self.few.response(self.values_at(u))
            self.there, self.slopes = (u.tobytes(), found), {}
            self._count(u)
        return self.there[1]

    def _count(self, u: np.ndarray) -> None:
        self.designs.add(u.tobytes())
        self.count = len(self.designs)

    def spectra_at(self, w: np.ndarray, speeds: np.ndarray) -> list[MeanSpectrum]:
        """Natural vibrations of a design at speeds, each at its mean state."""
        u = w[: len(self.names)]
        if self.spectra[0] != u.tobytes():
            self.spectra = u.tobytes(), {}
            self._count(u)
        known = self.spectra[1]
        new = np.array(sorted(set(speeds.tolist()) - known.keys()))
        if len(new):
            values = self.values_at(u)
            over = self.first.turning(new, values, self.again.at(values))
            for k, speed in enumerate(new.tolist()):
                found = MeanSpectrum(self.first.small, over.at(k), self.first.orders)
                self.modes = len(found.hertz) if self.modes is None else self.modes
                if len(found.hertz) != self.modes:
                    raise OptimisationError(
                        f"{self.system.name}: at {self.text(w)} and {speed * 30 / np.pi:.6g} 1/min "
                        f"there are {len(found.hertz)} oscillating modes instead of {self.modes}: "
                        "one became a decay or the reverse. Narrow `vary`.",
                        "modes lost",
                    )
                known[speed] = found
        return [known[speed] for speed in speeds.tolist()]

    def spectrum(self, w: np.ndarray) -> Spectrum:
        """Vibrations of a design at the first speed."""
        own = self.spectra_at(w, self.first.speeds[:1])[0]
        return Spectrum(
            own.hertz,
            own.damping,
            lambda mode: own.hertz_by(mode)[self.places],
            lambda mode: own.damping_by(mode)[self.places],
        )

    def of_reading(self, key: Reading, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A reading and its gradient, zero where rows hold it instead."""
        if key in self.unknown or not isinstance(key, OrderPeak | Separation):
            return super().of_reading(key, w)
        if isinstance(key, OrderPeak):
            value = self._largest(key, w)
        else:
            value = self.again.nearest(key, self.result(w))[0]
        return value, np.zeros(len(w))

    def bound_rows(self, key: Any, w: np.ndarray) -> list[Row]:
        """What must not be negative for the bounds of a key, at all speeds watched."""
        reading = key.reading if isinstance(key, Functional) else None
        if isinstance(reading, Separation):
            return [] if reading in self.unknown else self._apart(reading, w)
        if not isinstance(reading, OrderPeak):
            return super().bound_rows(key, w)
        _, high = self.bounds_of(reading)
        return self._below(reading, w, high, np.zeros(len(w))) if np.isfinite(high) else []

    def more_rows(self, w: np.ndarray) -> list[Row]:
        """What is made small or large is an unknown, up to which vibrations and modes keep."""
        found = super().more_rows(w)
        for key in self.unknown:
            if isinstance(key, OrderPeak):
                found += self._below(key, w, *self.of_reading(key, w))
            elif isinstance(key, Separation):
                found += self._apart(key, w)
        return found

    def _apart(self, key: Separation, w: np.ndarray) -> list[Row]:
        """How far modes keep away from orders at the speeds watched, which a margin moves."""
        found, (margin, slope) = [], self._asked(key, w)
        for value, by, by_margin, label in self.apart[key].rows(w, margin):
            own = by_margin * slope
            own[: len(self.names)] += by[self.places] * self.scale
            found.append((value, own, label))
        return found

    def _below(self, key: OrderPeak, w: np.ndarray, limit: float, slope: np.ndarray) -> list[Row]:
        """How far a vibration stays below a limit, which has a gradient, at the speeds watched."""
        response, found = self._response_watched(w), []
        unit, n = response.system.quantity(key.name).unit, len(self.names)
        sizes = sizes_of(response, response.system.key(key.name), key.measure)
        for speed in self.watched[key]:
            own, k = slope.copy(), response.number_of(speed, "optimise")
            own[:n] -= self._slope(key, response, k) * self.scale
            rpm = response.rpm[k]
            text = f"{key} at {rpm:.6g} 1/min = {sizes[k]:.6g} {unit}, at most {limit:.6g}"
            found.append(((limit - sizes[k]) / self.size[key], own / self.size[key], text))
        return found

    def _slope(self, key: OrderPeak, response: OrderResponse, k: int) -> np.ndarray:
        """Derivatives at one of the speeds watched by what varies."""
        place = key, float(response.speeds[k])
        if place not in self.slopes:
            of = self.system.key(key.name)
            self.slopes[place] = slope_of(response, of, k, key.measure)[self.places]
        return self.slopes[place]

    def _curve(self, key: OrderPeak, w: np.ndarray) -> OrderPeaks:
        """What a peak is the largest of, over the speed."""
        response = self.result(w)
        if key not in self.curves:
            self.curves[key] = self.again.curve(key, response)
        return self.curves[key]

    def _largest(self, key: OrderPeak, w: np.ndarray) -> float:
        return float(self._curve(key, w).sizes.max())

    def _crests(self, key: OrderPeak, w: np.ndarray, share: float) -> list[float]:
        """Speeds of maxima above a share of the largest."""
        curve = self._curve(key, w)
        crests = find_crests(curve.sizes)
        high = curve.sizes[crests] > share * curve.sizes.max()
        found: list[float] = curve.speeds[crests[high]].tolist()
        return found

    def _watch_crest(self, key: OrderPeak, w: np.ndarray, speed: float) -> bool:
        """Watch a maximum instead of a speed on its side; whether that is new.

        Two speeds of one maximum hold it by rows that are nearly the same.
        """
        watched, curve, response = self.watched[key], self._curve(key, w), self._response_watched(w)
        sizes = sizes_of(response, response.system.key(key.name), key.measure)
        place = int(np.abs(np.array(watched) - speed).argmin())
        own = watched[place]
        if abs(own - speed) <= _SAME * speed:
            return False
        low, high = sorted((own, speed))
        size = sizes[response.number_of(own, "optimise")]
        between = curve.sizes[(curve.speeds > low) & (curve.speeds < high)]
        if size > _BESIDE * curve.sizes.max() and between.min(initial=np.inf) >= size:
            watched[place] = speed
        else:
            watched.append(speed)
        return True

    def extend(self, w: np.ndarray) -> bool:
        """Watch the speeds, too, at which a design exceeds limits; whether there are any."""
        more = False
        for key in self.peaks:
            most = self._largest(key, w)
            limits = [self.bounds_of(key)[1]]
            limits += [self.of_reading(key, w)[0]] if key in self.unknown else []
            beyond = min(limits) * (1 + _OVER)
            for speed in self._crests(key, w, beyond / most) if most > beyond else []:
                more = self._watch_crest(key, w, speed) or more
        if more:
            self._watch()
        for wanted, apart in self.apart.items():
            more = apart.extend(w, self._asked(wanted, w)[0]) or more
        return more


class Apart:
    """The modes of a design beside the orders of a `Separation`.

    A mode is above or below an order at all speeds of operation and a margin beyond; what counts is
    ``side (2 pi f(n) / (order n) - 1)`` at speeds ``n = a + share (b - a)`` between the ends
    ``a = low (1 - margin)`` and ``b = high (1 + margin)``. Only some are watched: those of the
    least values, to which `extend` adds.

    Parameters
    ----------
    key : Separation
        What is asked for.
    spectra : callable
        See `Spectra`.
    w : ndarray
        Unknowns at the start, where the sides are chosen.
    margin : float
        The margin there.
    """

    def __init__(self, key: Separation, spectra: Spectra, w: Real, margin: float) -> None:
        self.key, self.spectra = key, spectra
        self.orders = np.array(key.orders)
        speeds, away = self._away(w, margin)
        self.sides = np.where(away.min(axis=0) >= (-away).min(axis=0), 1.0, -1.0)
        least = self.sides * away
        wrong = least.min(axis=0) <= max(float(least.min()), 0.0)
        self.watched = self._list_worst(speeds, least, wrong, margin)

    def rows(self, w: Real, margin: float) -> list[tuple[float, Real, float, str]]:
        """What must not be negative: value, derivatives by all parameters and by the margin."""
        begin, end = self._ends(margin)
        low, high = self.key.between
        shares = np.array([share for _, _, share in self.watched])
        speeds = begin + shares * (end - begin)
        found = []
        for (o, mode, share), speed, spectrum in zip(
            self.watched, speeds.tolist(), self.spectra(w, speeds), strict=True
        ):
            order, side = self.orders[o], self.sides[o, mode]
            factor = side * 2 * np.pi / (order * speed)
            hertz = float(spectrum.hertz[mode])
            moved = share * (high + low) - low
            by_margin = factor * (spectrum.hertz_by_speed(mode) - hertz / speed) * moved
            text = (
                f"{self.key}: mode {mode} at {speed * 30 / np.pi:.6g} 1/min = {hertz:.6g} Hz, at "
                f"{'least' if side > 0 else 'most'} {order * speed / (2 * np.pi):.6g}"
            )
            found.append((factor * hertz - side, factor * spectrum.hertz_by(mode), by_margin, text))
        return found

    def extend(self, w: Real, margin: float) -> bool:
        """Watch the speeds, too, at which a design is on the wrong side; whether there are any."""
        speeds, away = self._away(w, margin)
        least = self.sides * away
        worst = self._list_worst(speeds, least, least.min(axis=0) < -_CROSSED, margin)
        new = [each for each in worst if each not in self.watched]
        self.watched += new
        return bool(new)

    def _ends(self, margin: float) -> tuple[float, float]:
        low, high = self.key.between
        return low * (1 - margin), high * (1 + margin)

    def _list_worst(
        self, speeds: Real, least: Real, chosen: Boolean, margin: float
    ) -> list[tuple[int, int, float]]:
        """Where between the ends chosen modes are least apart from orders: (order, mode, share)."""
        begin, end = self._ends(margin)
        shares = (speeds - begin) / (end - begin) if end > begin else np.zeros(len(speeds))
        worst = shares[least.argmin(axis=0)]
        return [(o, mode, float(worst[o, mode])) for o, mode in np.argwhere(chosen).tolist()]

    def _away(self, w: Real, margin: float) -> tuple[Real, Real]:
        """Speeds that show on which side modes are, and their distance from orders there.

        Shapes (speeds,) and (speeds, orders, modes).
        """

        def hertz(speeds: Real) -> Real:
            return np.array([each.hertz for each in self.spectra(w, speeds)])

        speeds = speeds_that_show(hertz, *self._ends(margin), list(self.key.orders))
        found = 2 * np.pi * hertz(speeds)[:, None] / (speeds[:, None] * self.orders)[..., None] - 1
        return speeds, found
