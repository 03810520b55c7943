"""Parameters for which vibrations of an order response keep limits at all its speeds."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from lumped.errors import OptimisationError, OptionError
from lumped.functionals import Functional
from lumped.functionals.readings import OrderPeak, Reading, Separation
from lumped.numerics.nlp import Solution
from lumped.optimisation.design import Optimum, Task
from lumped.optimisation.spectral_search import SpectralSearch
from lumped.optimisation.speed_separation import WIDEST, Apart
from lumped.vibration.ordered.order_response import OrderResponse
from lumped.vibration.ordered.order_sensitivity import slope_of
from lumped.vibration.speeds.mean_spectrum import MeanSpectrum
from lumped.vibration.speeds.order_designs import OrderDesigns

_OVER = 1e-9
"""Share by which a limit may be exceeded at a speed that the search does not know."""


def best_orders(begin: OrderResponse, task: Task) -> Optimum:
    """The part of `optimise` for order responses."""
    search = _OrderSearch(begin, task)
    found = search.confirm()
    return search.optimum(search.response(found[0].w), *found)


class _OrderSearch(SpectralSearch):
    """With one margin more for each peak that is made small."""

    def __init__(self, begin: OrderResponse, task: Task) -> None:
        self.first, self.again = begin, OrderDesigns(begin, "optimise")
        point = begin.rotation.points[0]
        super().__init__(begin, point.theta, point.parameters, task)
        self.again.refuse_balancing(self.names, "vary")
        self.places = self.system.places(self.names)
        self.last: tuple[bytes, OrderResponse] | None = None
        self.spectra: tuple[bytes, dict[float, MeanSpectrum]] = b"", {}
        self.modes: int | None = None
        self.designs: set[bytes] = set()
        self.slopes: dict[tuple[OrderPeak, int], np.ndarray] = {}
        self.begin()
        self.peaks = [reading for reading in self.alone if isinstance(reading, OrderPeak)]
        self.inside = {key: self.again.inside(key) for key in self.peaks}
        sizes = {key: self._sizes(key, self.box[:, 0]) for key in self.peaks}
        self.watched = {key: _crests(sizes[key]) for key in self.peaks}
        self.minimised: dict[OrderPeak, int] = {}
        self.margin_of: dict[Separation, int] = {}
        self.size = {key: float(sizes[key].max()) for key in self.peaks}
        for key in self.peaks:
            self._check_peak(key)
            if Functional.of(key) in self.weights:
                self.minimised[key] = len(self.box)
                self.add_unknown(1.0)
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
        begin = self._least(key)
        _, high = self.bounds_of(key)
        if np.isfinite(high) or self.weights.get(Functional.of(key), 0.0) > 0 or not begin < WIDEST:
            raise OptionError(
                f"optimise: {key} can be made large (a negative weight), or bounded below by a "
                f"share under {WIDEST:g}."
            )
        self.apart[key] = Apart(key, self.spectra_at, self.box[:, 0], begin)
        if Functional.of(key) in self.weights:
            self.margin_of[key] = len(self.box)
            self.box = np.vstack([self.box, [(begin, begin, WIDEST)]])

    def _least(self, key: Separation) -> float:
        """The least separation that is asked for."""
        return max(self.bounds_of(key)[0], 0.0)

    def _check_peak(self, key: OrderPeak) -> None:
        low, high = self.bounds_of(key)
        if np.isfinite(low) or high <= 0 or self.weights.get(Functional.of(key), 0.0) < 0:
            raise OptionError(
                f"optimise: {key} can be made small or bounded above by a positive value."
            )
        if not self.size[key]:
            raise OptionError(f"optimise: {key} is zero: this quantity does not vibrate.")

    def response(self, w: np.ndarray) -> OrderResponse:
        """Vibration of a design."""
        u = w[: len(self.names)]
        if self.last is None or self.last[0] != u.tobytes():
            found = self.again.response(self.values_at(u))
            self.last, self.slopes = (u.tobytes(), found), {}
            self._count(u)
        return self.last[1]

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

    def spectrum(self, w: np.ndarray) -> _Spectrum:
        return _Spectrum(self.spectra_at(w, self.first.speeds[:1])[0], self.places)

    def of_reading(self, key: Reading, w: np.ndarray) -> tuple[float, np.ndarray]:
        if isinstance(key, Separation):
            return self._separation(key, w)
        if not isinstance(key, OrderPeak):
            return super().of_reading(key, w)
        slope = np.zeros(len(w))
        if key not in self.minimised:
            return float(self._sizes(key, w).max()), slope
        place, size = self.minimised[key], self.size[key]
        slope[place] = size
        return float(w[place] * size), slope

    def bound_rows(self, key: Any, w: np.ndarray) -> list[tuple[float, np.ndarray, str]]:
        reading = key.reading if isinstance(key, Functional) else None
        if isinstance(reading, Separation):
            least = self._least(reading)
            return [] if reading in self.margin_of else self._apart(reading, w, least)
        if not isinstance(reading, OrderPeak):
            return super().bound_rows(key, w)
        _, high = self.bounds_of(reading)
        limit = np.zeros(len(w))
        return self._below(reading, w, high, limit) if np.isfinite(high) else []

    def rows(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
        values, slopes, labels = super().rows(w)
        for key, place in self.minimised.items():
            limit = np.zeros(len(w))
            limit[place] = self.size[key]
            for value, slope, label in self._below(key, w, w[place] * self.size[key], limit):
                values = np.append(values, value)
                slopes = np.vstack([slopes, slope])
                labels.append(label)
        for apart, place in self.margin_of.items():
            for value, slope, label in self._apart(apart, w, w[place]):
                values = np.append(values, value)
                slopes = np.vstack([slopes, slope])
                labels.append(label)
        return values, slopes, labels

    def _apart(
        self, key: Separation, w: np.ndarray, margin: float
    ) -> list[tuple[float, np.ndarray, str]]:
        """How far modes keep away from orders at the speeds watched, which a margin moves."""
        found, n = [], len(self.names)
        for value, by, by_margin, label in self.apart[key].rows(w, margin):
            slope = np.zeros(len(w))
            slope[:n] = by[self.places] * self.scale
            if key in self.margin_of:
                slope[self.margin_of[key]] = by_margin
            found.append((value, slope, label))
        return found

    def _separation(self, key: Separation, w: np.ndarray) -> tuple[float, np.ndarray]:
        """The margin, where it is an unknown, or the least distance of a critical speed."""
        slope = np.zeros(len(w))
        if key in self.margin_of:
            slope[self.margin_of[key]] = 1.0
            return float(w[self.margin_of[key]]), slope
        return self.again.nearest(key, self.response(w))[0], slope

    def _below(
        self, key: OrderPeak, w: np.ndarray, limit: float, slope: np.ndarray
    ) -> list[tuple[float, np.ndarray, str]]:
        """How far a vibration stays below a limit, which has a gradient, at the speeds watched."""
        sizes, found = self._sizes(key, w), []
        unit, n = self.first.system.quantity(key.name).unit, len(self.names)
        for k in self.watched[key]:
            own = slope.copy()
            own[:n] -= self._slope(key, w, k) * self.scale
            rpm = self.first.rpm[self.inside[key][k]]
            text = f"{key} at {rpm:.6g} 1/min = {sizes[k]:.6g} {unit}, at most {limit:.6g}"
            found.append(((limit - sizes[k]) / self.size[key], own / self.size[key], text))
        return found

    def _sizes(self, key: OrderPeak, w: np.ndarray) -> np.ndarray:
        """What a peak is the largest of."""
        return self.again.sizes(key, self.response(w))

    def _slope(self, key: OrderPeak, w: np.ndarray, k: int) -> np.ndarray:
        """Derivatives at one of these speeds by what varies."""
        found = self.response(w)
        if (key, k) not in self.slopes:
            place = int(self.inside[key][k])
            by = slope_of(found, self.system.key(key.name), place, key.measure)[self.places]
            self.slopes[key, k] = by
        return self.slopes[key, k]

    def extend(self, w: np.ndarray) -> bool:
        """Watch the speeds, too, at which a design exceeds limits; whether there are any."""
        more = False
        for key in self.peaks:
            sizes = self._sizes(key, w)
            limits = [self.bounds_of(key)[1]]
            limits += [w[self.minimised[key]] * self.size[key]] if key in self.minimised else []
            beyond = [k for k in _crests(sizes) if sizes[k] > min(limits) * (1 + _OVER)]
            new = [k for k in beyond if k not in self.watched[key]]
            self.watched[key] += new
            more = more or bool(new)
        for wanted, apart in self.apart.items():
            place = self.margin_of.get(wanted)
            margin = self._least(wanted) if place is None else w[place]
            more = apart.extend(w, margin) or more
        return more


class _Spectrum:
    """Modes of the mean equations, with derivatives by what varies."""

    def __init__(self, modes: MeanSpectrum, places: list[int]) -> None:
        self.modes, self.places = modes, places

    @property
    def hertz(self) -> np.ndarray:
        return self.modes.hertz

    @property
    def damping(self) -> np.ndarray:
        return self.modes.damping

    def hertz_by(self, mode: int) -> np.ndarray:
        found: np.ndarray = self.modes.hertz_by(mode)[self.places]
        return found

    def damping_by(self, mode: int) -> np.ndarray:
        found: np.ndarray = self.modes.damping_by(mode)[self.places]
        return found


def _crests(sizes: np.ndarray) -> list[int]:
    """Where a curve is at least as high as on both sides."""
    high = np.concatenate([[-np.inf], sizes, [-np.inf]])
    inner = high[1:-1]
    found: list[int] = np.flatnonzero((inner >= high[:-2]) & (inner >= high[2:])).tolist()
    return found
