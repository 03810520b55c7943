"""Parameters that put natural frequencies and damping ratios where they are wanted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lumped.compiler.system import Changes, Name
from lumped.errors import OptimisationError, OptionError
from lumped.numerics.sqp import bounded, sqp
from lumped.optimisation.design import Bounds, Key, Optimum, bounds_of, varied
from lumped.points.equilibrium import equilibrium
from lumped.points.moved_equilibrium import moved_point
from lumped.points.start import start_point
from lumped.simulation.functionals import Clearance, Damping, Frequency, Modal
from lumped.timeloop.result import Kept, OperatingPoint
from lumped.vibration.eigen_sensitivity import EigenSensitivity, eigen_sensitivity
from lumped.vibration.modes import Modes, modes

__all__ = ["ModalKey", "best_modes", "equilibrium_again"]

ModalKey = Modal | str


def best_modes(
    begin: Modes,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    weights: Mapping[ModalKey, float],
    subject_to: Mapping[ModalKey, Bounds],
) -> Optimum:
    """The modal part of `optimise`: sequential quadratic programming with exact gradients."""
    return _ModeSearch(begin, vary, weights, subject_to).found()


def equilibrium_again(point: OperatingPoint, parameters: Changes) -> OperatingPoint:
    """The equilibrium of other parameters, found as that of a point was."""
    system, kept = point.system, point.kept or Kept()
    p = system.structure.parameters
    return equilibrium(
        system,
        parameters=parameters,
        start=kept.start,
        free=[p.names[p.free[place]] for place in kept.free],
        rest=kept.rest,
        time=point.time,
    )


class _ModeSearch:
    """A programme in scaled parameters and one margin for each clearance."""

    def __init__(
        self,
        begin: Modes,
        vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
        weights: Mapping[ModalKey, float],
        subject_to: Mapping[ModalKey, Bounds],
    ) -> None:
        self.system, self.modes = begin.system, begin
        self.names, box, scale = varied(self.system, vary, begin.point.theta)
        self.scale, self.start = scale, box[:, 0]
        self.base = begin.point.parameters
        self.settled = moved_point(begin.point, []) is not None
        self.plain = np.array_equal(start_point(self.system, parameters=self.base).x, begin.point.x)
        self.weights, self.bounds = dict(weights), dict(subject_to)
        self.margins = [
            key for key in dict.fromkeys([*weights, *subject_to]) if isinstance(key, Clearance)
        ]
        for key in [*weights, *subject_to]:
            self._check(key)
        # sides on which frequencies lie of excitations
        self.sides = {
            key: np.where(begin.hertz[:, None] > np.array(key.excitations), 1.0, -1.0)
            for key in self.margins
        }
        first = [self._margin(key, begin).min() for key in self.margins]
        self.box = np.concatenate(
            [box / scale[:, None], np.array([(m, -np.inf, np.inf) for m in first]).reshape(-1, 3)]
        )
        self.last: tuple[bytes, EigenSensitivity] | None = None
        self.count = 0

    def _check(self, key: ModalKey) -> None:
        count = len(self.modes.hertz)
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

    def _margin(self, key: Clearance, found: Modes) -> np.ndarray:
        away = found.hertz[:, None] / np.array(key.excitations) - 1
        margin: np.ndarray = (self.sides[key] * away).ravel()
        return margin

    def _at(self, w: np.ndarray) -> EigenSensitivity:
        """Modes and their derivatives for scaled unknowns."""
        u = w[: len(self.names)]
        if self.last is None or self.last[0] != u.tobytes():
            values = self.base | dict(zip(self.names, (u * self.scale).tolist(), strict=True))
            own = modes(self.system, at=self._point(values))
            if len(own.hertz) != len(self.modes.hertz):
                raise OptimisationError(
                    f"{self.system.name}: at {self._text(u)} there are {len(own.hertz)} "
                    f"oscillating modes instead of {len(self.modes.hertz)}: one became a decay "
                    "or the reverse. Narrow `vary`.",
                    "modes lost",
                )
            slopes = eigen_sensitivity(own, to=self.names)
            if slopes.repeated:
                raise OptimisationError(
                    f"{self.system.name}: at {self._text(u)} mode {slopes.repeated[0]} "
                    f"({own.hertz[slopes.repeated[0]]:.6g} Hz) coincides with another and has no "
                    "derivative. Begin elsewhere.",
                    "repeated modes",
                )
            self.last, self.count = (u.tobytes(), slopes), self.count + 1
        return self.last[1]

    def _point(self, values: dict[str, float]) -> OperatingPoint:
        """The operating point of a design: found as that of the modes was, else held."""
        begin = self.modes.point
        if begin.kept is not None:
            return equilibrium_again(begin, values)
        if self.plain:
            return start_point(self.system, parameters=values)
        if self.settled:
            states = dict(zip(self.system.state_names, begin.x.tolist(), strict=True))
            return equilibrium(self.system, parameters=values, start=states, time=begin.time)
        return replace(begin, theta=self.system.theta(values))

    def _text(self, u: np.ndarray) -> str:
        pairs = zip(self.names, u * self.scale, strict=True)
        return ", ".join(f"{name} = {value:.6g}" for name, value in pairs)

    def _value(self, key: ModalKey, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A number and its gradient by the scaled unknowns."""
        found, slope = self._at(w), np.zeros(len(w))
        n = len(self.names)
        if isinstance(key, Frequency):
            slope[:n] = found.hertz[key.mode] * self.scale
            return float(found.modes.hertz[key.mode]), slope
        if isinstance(key, Damping):
            slope[:n] = found.damping[key.mode] * self.scale
            return float(found.modes.damping[key.mode]), slope
        if isinstance(key, Clearance):
            place = n + self.margins.index(key)
            slope[place] = 1.0
            return float(w[place]), slope
        if key in self.names:
            place = self.names.index(key)
            slope[place] = self.scale[place]
            return float(w[place] * self.scale[place]), slope
        return self.base[key], slope

    def _rows(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
        """What must not be negative, scaled, its gradients and names."""
        values, slopes, labels = [], [], []
        for key, given in self.bounds.items():
            value, slope = self._value(key, w)
            for row in bounded(str(key), value, slope, *bounds_of(str(key), given)):
                values.append(row[0])
                slopes.append(row[1])
                labels.append(row[2])
        found, n = self._at(w), len(self.names)
        for k, key in enumerate(self.margins):
            margin = self._margin(key, found.modes) - w[n + k]
            by = self.sides[key][:, :, None] * (
                (found.hertz * self.scale)[:, None, :] / np.array(key.excitations)[None, :, None]
            )
            more = np.zeros((len(margin), len(w)))
            more[:, :n], more[:, n + k] = by.reshape(len(margin), n), -1.0
            values += margin.tolist()
            slopes += list(more)
            labels += [str(key)] * len(margin)
        return np.array(values), np.array(slopes).reshape(-1, len(w)), labels

    def _objective(self, w: np.ndarray) -> tuple[float, np.ndarray]:
        total, slope = 0.0, np.zeros(len(w))
        for key, weight in self.weights.items():
            value, by = self._value(key, w)
            total, slope = total + weight * value, slope + weight * by
        return total, slope

    def found(self) -> Optimum:
        """Search, and check what was found by its own conditions of optimality."""
        solution, active = sqp(
            self.system.name, self.names, self.box, self._objective, self._rows, lambda: self.count
        )
        w, n = solution.w, len(self.names)
        own = self._at(w).modes
        keys = dict.fromkeys(k for k in [*self.weights, *self.bounds] if not isinstance(k, str))
        numbers: dict[Key, float] = {k: self._value(k, w)[0] for k in keys}
        return Optimum(
            own,
            dict(zip(self.names, (w[:n] * self.scale).tolist(), strict=True)),
            dict(zip(self.names, self.start.tolist(), strict=True)),
            solution.objective,
            numbers,
            active,
            0.0,
            solution,
        )
