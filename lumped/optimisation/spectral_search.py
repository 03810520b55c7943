"""A programme in parameters whose numbers are natural frequencies, damping ratios and others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from lumped.errors import OptionError
from lumped.functionals import Functional
from lumped.functionals.functional import readings_of
from lumped.functionals.readings import Clearance, Damping, Frequency, Reading
from lumped.optimisation.design import Task, bounds_of
from lumped.optimisation.search import DesignSearch
from lumped.vibration.natural.modes import Modes
from lumped.vibration.ordered.order_response import OrderResponse


class Spectrum(Protocol):
    """Natural frequencies, Hz, and damping ratios, with derivatives by what varies."""

    @property
    def hertz(self) -> np.ndarray:
        """Natural frequencies, Hz, shape (m,)."""

    @property
    def damping(self) -> np.ndarray:
        """Damping ratios, shape (m,)."""

    def hertz_by(self, mode: int) -> np.ndarray:
        """Derivatives of a frequency, shape (p,)."""

    def damping_by(self, mode: int) -> np.ndarray:
        """Derivatives of a damping ratio, shape (p,)."""


class SpectralSearch(DesignSearch):
    """With one margin more for each clearance."""

    def __init__(
        self,
        what: Modes | OrderResponse,
        theta: np.ndarray,
        base: Mapping[str, float],
        task: Task,
    ) -> None:
        super().__init__(what, theta, base, task)
        self.margins = [r for r in self.alone if isinstance(r, Clearance)]
        self.sides: dict[Clearance, np.ndarray] = {}

    @property
    def alone(self) -> list[Reading]:
        """Readings that are functionals by themselves."""
        found = (key.reading for key in self.keys if isinstance(key, Functional))
        return [reading for reading in found if reading is not None]

    def spectrum(self, w: np.ndarray) -> Spectrum:
        """Frequencies and damping ratios for scaled unknowns."""
        raise NotImplementedError

    def begin(self) -> None:
        """Check the keys against the spectrum at the start, and add the margins."""
        keys = [key for key in self.keys if isinstance(key, Functional)]
        readings = readings_of(keys)
        own = any(reading.of == "modes" for reading in readings)
        hertz = self.spectrum(self.box[:, 0]).hertz if own else np.zeros(0)
        for reading in readings:
            self._check(reading, len(hertz))
        for key in keys:
            for reading in key.readings if key.reading is None else ():
                if not isinstance(reading, Frequency | Damping):
                    raise OptionError(
                        f"optimise: {key}: {reading} is bounded, or made large or small, by "
                        "itself, not in an expression."
                    )
        # sides on which frequencies lie of excitations
        self.sides = {
            key: np.where(hertz[:, None] > np.array(key.excitations), 1.0, -1.0)
            for key in self.margins
        }
        for wanted in self.margins:
            self.add_unknown(float(self._margin(wanted, hertz).min()))

    def add_unknown(self, first: float) -> None:
        """One more unknown beside the parameters."""
        self.box = np.vstack([self.box, [(first, -np.inf, np.inf)]])

    def _check(self, key: Reading, count: int) -> None:
        if isinstance(key, Frequency | Damping) and not 0 <= key.mode < count:
            raise OptionError(
                f"optimise: {key}: the modes at the start are 0 to {count - 1}, counted from the "
                "lowest."
            )
        if isinstance(key, Clearance):
            if not (key.excitations and min(key.excitations) > 0):
                raise OptionError(f"optimise: {key}: give positive frequencies in Hz.")
            _, high = self.bounds_of(key)
            if self.weights.get(Functional.of(key), 0.0) > 0 or np.isfinite(high):
                raise OptionError(
                    f"optimise: {key} can be made large (a negative weight) or bounded below."
                )

    def _margin(self, key: Clearance, hertz: np.ndarray) -> np.ndarray:
        away = hertz[:, None] / np.array(key.excitations) - 1
        margin: np.ndarray = (self.sides[key] * away).ravel()
        return margin

    def functional(self, key: Functional, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A functional and its gradient by the scaled unknowns."""
        found = [self.of_reading(reading, w) for reading in key.readings]
        values, slopes = (np.array(part) for part in zip(*found, strict=True))
        through = key.branches(values, 0.0)[0].slopes
        return float(key.value(values[None])[0]), through @ slopes

    def bounds_of(self, reading: Reading) -> tuple[float, float]:
        """Bounds of a reading that is a functional by itself."""
        key = Functional.of(reading)
        return bounds_of(str(key), self.bounds.get(key, (None, None)))

    def of_reading(self, key: Reading, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A reading and its gradient by the scaled unknowns."""
        slope, n = np.zeros(len(w)), len(self.names)
        if isinstance(key, Frequency):
            found = self.spectrum(w)
            slope[:n] = found.hertz_by(key.mode) * self.scale
            return float(found.hertz[key.mode]), slope
        if isinstance(key, Damping):
            found = self.spectrum(w)
            slope[:n] = found.damping_by(key.mode) * self.scale
            return float(found.damping[key.mode]), slope
        assert isinstance(key, Clearance)
        place = n + self.margins.index(key)
        slope[place] = 1.0
        return float(w[place]), slope

    def rows(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
        """With the distance of every mode from each margin."""
        values, slopes, labels = super().rows(w)
        n = len(self.names)
        for k, key in enumerate(self.margins):
            found = self.spectrum(w)
            margin = self._margin(key, found.hertz) - w[n + k]
            hertz_by = np.array([found.hertz_by(i) for i in range(len(found.hertz))])
            by = self.sides[key][:, :, None] * (
                (hertz_by * self.scale)[:, None, :] / np.array(key.excitations)[None, :, None]
            )
            more = np.zeros((len(margin), len(w)))
            more[:, :n], more[:, n + k] = by.reshape(len(margin), n), -1.0
            values = np.append(values, margin)
            slopes = np.vstack([slopes, more])
            labels += [str(key)] * len(margin)
        return values, slopes, labels
