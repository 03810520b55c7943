"""A programme in parameters whose numbers are natural frequencies, damping ratios and others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from lumped.compiler.system import Name, System
from lumped.errors import OptionError
from lumped.numerics.nlp import Solution
from lumped.numerics.sqp import bounded, sqp
from lumped.optimisation.design import Bounds, Key, bounds_of, varied
from lumped.simulation.functionals import Clearance, Damping, Frequency, Vibrating

__all__ = ["SpectralSearch", "Spectrum", "VibratingKey"]

VibratingKey = Vibrating | str


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


class SpectralSearch:
    """Sequential quadratic programming in scaled parameters and one margin for each clearance.

    Parameters
    ----------
    theta : ndarray
        Parameters at the start.
    base : mapping of str to float
        The same by name.
    """

    def __init__(
        self,
        system: System,
        theta: np.ndarray,
        base: Mapping[str, float],
        vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
        weights: Mapping[VibratingKey, float],
        subject_to: Mapping[VibratingKey, Bounds],
    ) -> None:
        self.system, self.base = system, dict(base)
        self.names, box, self.scale = varied(system, vary, theta)
        self.start = box[:, 0]
        self.weights, self.bounds = dict(weights), dict(subject_to)
        self.keys = list(dict.fromkeys([*weights, *subject_to]))
        self.margins = [key for key in self.keys if isinstance(key, Clearance)]
        self.box = box / self.scale[:, None]
        self.count = 0
        self.sides: dict[Clearance, np.ndarray] = {}

    def spectrum(self, w: np.ndarray) -> Spectrum:
        """Frequencies and damping ratios for scaled unknowns."""
        raise NotImplementedError

    def begin(self) -> None:
        """Check the keys against the spectrum at the start, and add the margins."""
        own = {key for key in self.keys if isinstance(key, Frequency | Damping | Clearance)}
        hertz = self.spectrum(self.box[:, 0]).hertz if own else np.zeros(0)
        for key in self.keys:
            self._check(key, len(hertz))
        # sides on which frequencies lie of excitations
        self.sides = {
            key: np.where(hertz[:, None] > np.array(key.excitations), 1.0, -1.0)
            for key in self.margins
        }
        for key in self.margins:
            self.add_unknown(float(self._margin(key, hertz).min()))

    def add_unknown(self, first: float) -> None:
        """One more unknown beside the parameters."""
        self.box = np.vstack([self.box, [(first, -np.inf, np.inf)]])

    def _check(self, key: VibratingKey, count: int) -> None:
        if isinstance(key, str):
            self.system.places([key])
            if key in self.bounds:
                raise OptionError(f"optimise: {key} is a parameter; its bounds belong to `vary`.")
        if isinstance(key, Frequency | Damping) and not 0 <= key.mode < count:
            raise OptionError(
                f"optimise: {key}: the modes at the start are 0 to {count - 1}, counted from the "
                "lowest."
            )
        if isinstance(key, Clearance):
            if not (key.excitations and min(key.excitations) > 0):
                raise OptionError(f"optimise: {key}: give positive frequencies in Hz.")
            _, high = bounds_of(str(key), self.bounds.get(key, (None, None)))
            if self.weights.get(key, 0.0) > 0 or np.isfinite(high):
                raise OptionError(
                    f"optimise: {key} can be made large (a negative weight) or bounded below."
                )

    def _margin(self, key: Clearance, hertz: np.ndarray) -> np.ndarray:
        away = hertz[:, None] / np.array(key.excitations) - 1
        margin: np.ndarray = (self.sides[key] * away).ravel()
        return margin

    def values_at(self, w: np.ndarray) -> dict[str, float]:
        """Parameters by name."""
        own = (w[: len(self.names)] * self.scale).tolist()
        return self.base | dict(zip(self.names, own, strict=True))

    def text(self, w: np.ndarray) -> str:
        """What varies, in words."""
        pairs = zip(self.names, w * self.scale, strict=False)
        return ", ".join(f"{name} = {value:.6g}" for name, value in pairs)

    def value(self, key: VibratingKey, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A number and its gradient by the scaled unknowns."""
        slope, n = np.zeros(len(w)), len(self.names)
        if isinstance(key, Frequency):
            found = self.spectrum(w)
            slope[:n] = found.hertz_by(key.mode) * self.scale
            return float(found.hertz[key.mode]), slope
        if isinstance(key, Damping):
            found = self.spectrum(w)
            slope[:n] = found.damping_by(key.mode) * self.scale
            return float(found.damping[key.mode]), slope
        if isinstance(key, Clearance):
            place = n + self.margins.index(key)
            slope[place] = 1.0
            return float(w[place]), slope
        assert isinstance(key, str)
        name = self.system.key(key)
        if name in self.names:
            place = self.names.index(name)
            slope[place] = self.scale[place]
            return float(w[place] * self.scale[place]), slope
        return self.base[name], slope

    def bounded_rows(self, key: VibratingKey, w: np.ndarray) -> list[tuple[float, np.ndarray, str]]:
        """What must not be negative for the bounds of a key."""
        return bounded(str(key), *self.value(key, w), *bounds_of(str(key), self.bounds[key]))

    def rows(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
        """What must not be negative, scaled, its gradients and names."""
        every = [row for key in self.bounds for row in self.bounded_rows(key, w)]
        values, slopes, labels = map(list, zip(*every, strict=True)) if every else ([], [], [])
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
            values += margin.tolist()
            slopes += list(more)
            labels += [str(key)] * len(margin)
        return np.array(values), np.array(slopes).reshape(-1, len(w)), labels

    def objective(self, w: np.ndarray) -> tuple[float, np.ndarray]:
        """The weighted sum and its gradient."""
        total, slope = 0.0, np.zeros(len(w))
        for key, weight in self.weights.items():
            value, by = self.value(key, w)
            total, slope = total + weight * value, slope + weight * by
        return total, slope

    def solved(self) -> tuple[Solution, tuple[str, ...]]:
        """Best unknowns, checked by their own conditions of optimality, and what is active."""
        return sqp(
            self.system.name, self.names, self.box, self.objective, self.rows, lambda: self.count
        )

    def found(self, w: np.ndarray) -> tuple[dict[str, float], dict[str, float], dict[Key, float]]:
        """Parameters, those at the start, and all numbers."""
        best = dict(zip(self.names, (w[: len(self.names)] * self.scale).tolist(), strict=True))
        begin = dict(zip(self.names, self.start.tolist(), strict=True))
        return best, begin, {k: self.value(k, w)[0] for k in self.keys if not isinstance(k, str)}
