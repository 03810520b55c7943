"""A programme in parameters whose numbers are natural frequencies, damping ratios and others."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lumped.errors import OptimisationError, OptionError
from lumped.functionals import Functional
from lumped.functionals.functional import readings_of
from lumped.functionals.readings import Clearance, Damping, Frequency, Reading
from lumped.optimisation.design import Task, bounds_of
from lumped.optimisation.search import DesignSearch, Row
from lumped.vibration.natural.eigen_sensitivity import eigen_sensitivity
from lumped.vibration.natural.find_modes import modes
from lumped.vibration.natural.mode_designs import ModeDesigns
from lumped.vibration.natural.modes import Modes

_FREE = (-np.inf, np.inf)


class Spectrum(NamedTuple):
    """Natural frequencies and damping ratios of a design.

    Attributes
    ----------
    hertz, damping : ndarray, shape (m,)
        Natural frequencies, Hz; damping ratios.
    hertz_by, damping_by : callable
        Derivatives of one of each by what varies, shape (p,), for the number of a mode.
    """

    hertz: np.ndarray
    damping: np.ndarray
    hertz_by: Callable[[int], np.ndarray]
    damping_by: Callable[[int], np.ndarray]


class SpectralSearch(DesignSearch):
    """With an unknown more for each clearance.

    Attributes
    ----------
    unknown : dict of Reading to (int, float)
        Place and size of the unknowns that stand for readings.
    """

    @property
    def alone(self) -> list[Reading]:
        """Readings that are functionals by themselves."""
        found = (key.reading for key in self.keys if isinstance(key, Functional))
        return [reading for reading in found if reading is not None]

    def spectrum(self, w: np.ndarray) -> Spectrum:
        """Frequencies and damping ratios of a design."""
        raise NotImplementedError

    def begin(self) -> None:
        """Check the keys against the spectrum at the start, and add the margins."""
        self.unknown: dict[Reading, tuple[int, float]] = {}
        self.sides: dict[Clearance, np.ndarray] = {}
        keys = [key for key in self.keys if isinstance(key, Functional)]
        readings = readings_of(keys)
        has_modes = any(reading.of == "modes" for reading in readings)
        hertz = self.spectrum(self.box[:, 0]).hertz if has_modes else np.zeros(0)
        for reading in readings:
            self._check(reading, len(hertz))
        for functional in keys:
            for reading in functional.readings if functional.reading is None else ():
                if not isinstance(reading, Frequency | Damping):
                    raise OptionError(
                        f"optimise: {functional}: {reading} is bounded, or made large or small, by "
                        "itself, not in an expression."
                    )
        for key in self.alone:
            if isinstance(key, Clearance):
                above = hertz[:, None] > np.array(key.excitations)
                self.sides[key] = np.where(above, 1.0, -1.0)
                self.add_unknown(key, float(self._margin(key, hertz).min()))

    def add_unknown(
        self, key: Reading, first: float, size: float = 1.0, box: tuple[float, float] = _FREE
    ) -> None:
        """One more unknown beside the parameters, which stands for a reading over its size."""
        self.unknown[key] = len(self.box), size
        self.box = np.vstack([self.box, [(first, *box)]])

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
        """How far modes keep away from excitations, shape (modes, excitations)."""
        away = hertz[:, None] / np.array(key.excitations) - 1
        margin: np.ndarray = self.sides[key] * away
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
        place, size = self.unknown[key]
        slope[place] = size
        return float(w[place] * size), slope

    def more_rows(self, w: np.ndarray) -> list[Row]:
        """The distance of every mode from each margin."""
        found, n = [], len(self.names)
        for key, sides in self.sides.items():
            own, (place, _) = self.spectrum(w), self.unknown[key]
            away = self._margin(key, own.hertz) - w[place]
            for mode, side in enumerate(sides):
                by = own.hertz_by(mode) * self.scale
                for i, hertz in enumerate(key.excitations):
                    slope = np.zeros(len(w))
                    slope[:n], slope[place] = side[i] * by / hertz, -1.0
                    found.append((float(away[mode, i]), slope, str(key)))
        return found


class ModeSearch(SpectralSearch):
    """The modal part of `optimise`: parameters that put frequencies where they are wanted."""

    def __init__(self, begin: Modes, task: Task) -> None:
        super().__init__(begin, begin.point, task)
        self.designs = ModeDesigns(begin)
        self.last: tuple[bytes, Modes, Spectrum] | None = None
        self.begin()

    def result(self, w: np.ndarray) -> Modes:
        """Modes of a design."""
        return self._analyse(w)[1]

    def spectrum(self, w: np.ndarray) -> Spectrum:
        """Frequencies and damping ratios of a design."""
        return self._analyse(w)[2]

    def _analyse(self, w: np.ndarray) -> tuple[bytes, Modes, Spectrum]:
        u = w[: len(self.names)]
        if self.last is None or self.last[0] != u.tobytes():
            own = modes(self.system, at=self.designs.point(self.values_at(u)))
            if len(own.hertz) != len(self.designs.begin.hertz):
                raise OptimisationError(
                    f"{self.system.name}: at {self.text(u)} there are {len(own.hertz)} "
                    f"oscillating modes instead of {len(self.designs.begin.hertz)}: one became a "
                    "decay or the reverse. Narrow `vary`.",
                    "modes lost",
                )
            by = eigen_sensitivity(own, by=self.names)
            if by.repeated:
                raise OptimisationError(
                    f"{self.system.name}: at {self.text(u)} mode {by.repeated[0]} "
                    f"({own.hertz[by.repeated[0]]:.6g} Hz) coincides with another and has no "
                    "derivative. Begin elsewhere.",
                    "repeated modes",
                )
            slopes = by.hertz.__getitem__, by.damping.__getitem__
            self.last = u.tobytes(), own, Spectrum(own.hertz, own.damping, *slopes)
            self.count += 1
        return self.last
