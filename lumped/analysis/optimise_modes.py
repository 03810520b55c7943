"""Parameters that put natural frequencies and damping ratios where they are wanted."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping

import numpy as np
import scipy

from lumped.analysis.design import Bounds, Key, Optimum, bounds_of, varied
from lumped.analysis.eigen_sensitivity import EigenSensitivity, eigen_sensitivity
from lumped.analysis.equilibrium import equilibrium
from lumped.analysis.functionals import Clearance, Damping, Frequency, Modal
from lumped.analysis.modes import Modes, modes
from lumped.analysis.nlp import Solution
from lumped.analysis.start import start_point
from lumped.errors import OptimisationError, OptionError
from lumped.system import Name

__all__ = ["ModalKey", "best_modes"]

ModalKey = Modal | str

_ACTIVE = 1e-6


def best_modes(
    begin: Modes,
    vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
    weights: Mapping[ModalKey, float],
    subject_to: Mapping[ModalKey, Bounds],
) -> Optimum:
    """The modal part of `optimise`: sequential quadratic programming with exact gradients."""
    return _Search(begin, vary, weights, subject_to).found()


class _Search:
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
        plain = start_point(self.system, self.base)
        self.steady = not np.array_equal(plain.x, begin.point.x)
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
            point = equilibrium(self.system, parameters=values) if self.steady else None
            own = modes(self.system, at=point, parameters=None if self.steady else values)
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
            low, high = bounds_of(str(key), given)
            for bound, sign in ((low, 1.0), (high, -1.0)):
                if np.isfinite(bound):
                    size = abs(bound) or 1.0
                    values.append(sign * (value - bound) / size)
                    slopes.append(sign * slope / size)
                    labels.append(
                        f"{key} = {value:.6g}, at {'least' if sign > 0 else 'most'} {bound:g}"
                    )
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
        tic = clock.perf_counter()
        first = self.box[:, 0]
        value, slope = self._objective(first)
        size = max(abs(value), float(np.abs(slope).max())) or 1.0
        idle = (
            np.abs(np.vstack([slope, self._rows(first)[1]]))[:, : len(self.names)].max(axis=0) == 0
        )
        if idle.any():
            names = [n for n, i in zip(self.names, idle, strict=True) if i]
            raise OptionError(
                f"optimise: {', '.join(names)} has no effect on objective and constraints. Leave "
                "it out of `vary`."
            )
        found = scipy.optimize.minimize(
            lambda w: tuple(v / size for v in self._objective(w)),
            first,
            jac=True,
            method="SLSQP",
            bounds=self.box[:, 1:],
            constraints={
                "type": "ineq",
                "fun": lambda w: self._rows(w)[0],
                "jac": lambda w: self._rows(w)[1],
            },
            options={"ftol": 1e-12, "maxiter": 200},
        )
        w = np.clip(found.x, self.box[:, 1], self.box[:, 2])
        values, slopes, labels = self._rows(w)
        violation = float(max(-values.min(initial=0.0), 0.0))
        if found.status != 0 or violation > 1e-6:
            worst = f"Worst violated: {labels[int(values.argmin())]}." if violation > 1e-6 else ""
            raise OptimisationError(
                f"{self.system.name}: no optimum found ({found.message} after {found.nit} "
                f"iterations). {worst} Widen bounds, or begin elsewhere.",
                found.message,
            )
        value, slope = self._objective(w)
        low, high = (np.abs(w - self.box[:, i]) <= _ACTIVE for i in (1, 2))
        near = np.flatnonzero(values <= _ACTIVE)
        unit = np.eye(len(w))
        active = np.vstack([slopes[near], unit[low], -unit[high]])
        residual, condition = float(np.abs(slope).max()) / size, 1.0
        if len(active):
            # least-squares multipliers, none negative
            held = scipy.optimize.lsq_linear(active.T, slope / size, (0.0, np.inf))
            residual = float(np.abs(active.T @ held.x - slope / size).max())
            condition = float(np.linalg.cond(active))
        own = self._at(w).modes
        n = len(self.names)
        keys = dict.fromkeys(k for k in [*self.weights, *self.bounds] if not isinstance(k, str))
        numbers: dict[Key, float] = {k: self._value(k, w)[0] for k in keys}
        pressing = [labels[i].partition(" = ")[0] for i in near]
        for sides, text in ((low, "lower"), (high, "upper")):
            pressing += [f"{self.names[i]} at its {text} bound" for i in np.flatnonzero(sides[:n])]
        solution = Solution(
            w,
            values,
            np.zeros(len(values)),
            np.zeros(len(w)),
            value,
            "SLSQP: " + found.message,
            int(found.nit),
            self.count,
            residual,
            violation,
            condition,
            clock.perf_counter() - tic,
        )
        return Optimum(
            own,
            dict(zip(self.names, (w[:n] * self.scale).tolist(), strict=True)),
            dict(zip(self.names, self.start.tolist(), strict=True)),
            value,
            numbers,
            tuple(dict.fromkeys(pressing)),
            0.0,
            solution,
        )
