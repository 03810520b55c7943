"""A search for the best design: scaled parameters, an objective and rows that are not negative."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Generic, TypeVar

import numpy as np

from lumped.compiler.system import Name, System
from lumped.errors import OptionError
from lumped.numerics.nlp import Solution
from lumped.numerics.sqp import bounded, sqp
from lumped.optimisation.design import Bounds, Key, bounds_of, varied

__all__ = ["DesignSearch"]

K = TypeVar("K", bound=Key)
"""Functionals of a kind of analysis."""


class DesignSearch(Generic[K]):
    """Sequential quadratic programming in scaled parameters.

    Parameters
    ----------
    theta : ndarray
        Parameters at the start.
    base : mapping of str to float
        The same by name.
    vary, weights, subject_to
        As for `optimise`.
    """

    tolerance = 1e-12
    """Relative change of the objective at which a search ends."""

    def __init__(
        self,
        system: System,
        theta: np.ndarray,
        base: Mapping[str, float],
        vary: Mapping[str, Bounds] | Mapping[Name, Bounds],
        weights: Mapping[K | str, float],
        subject_to: Mapping[K | str, Bounds],
    ) -> None:
        self.system, self.base = system, dict(base)
        self.names, box, self.scale = varied(system, vary, theta)
        self.start = box[:, 0]
        self.weights, self.bounds = dict(weights), dict(subject_to)
        self.keys = list(dict.fromkeys([*weights, *subject_to]))
        self.box = box / self.scale[:, None]
        self.count = 0
        for key in self.keys:
            if isinstance(key, str):
                system.places([key])
                if key in self.bounds:
                    raise OptionError(
                        f"optimise: {key} is a parameter; its bounds belong to `vary`."
                    )

    def functional(self, key: K, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A functional and its gradient by the scaled unknowns."""
        raise NotImplementedError

    def design(self, w: np.ndarray) -> dict[str, float]:
        """What varies, by name."""
        own = (w[: len(self.names)] * self.scale).tolist()
        return dict(zip(self.names, own, strict=True))

    def values_at(self, w: np.ndarray) -> dict[str, float]:
        """Parameters by name."""
        return self.base | self.design(w)

    def text(self, w: np.ndarray) -> str:
        """What varies, in words."""
        pairs = zip(self.names, w * self.scale, strict=False)
        return ", ".join(f"{name} = {value:.6g}" for name, value in pairs)

    def value(self, key: K | str, w: np.ndarray) -> tuple[float, np.ndarray]:
        """A number and its gradient by the scaled unknowns."""
        if not isinstance(key, str):
            return self.functional(key, w)
        name, slope = self.system.key(key), np.zeros(len(w))
        if name not in self.names:
            return self.base[name], slope
        place = self.names.index(name)
        slope[place] = self.scale[place]
        return float(w[place] * self.scale[place]), slope

    def bounded_rows(self, key: K | str, w: np.ndarray) -> list[tuple[float, np.ndarray, str]]:
        """What must not be negative for the bounds of a key."""
        return bounded(str(key), *self.value(key, w), *bounds_of(str(key), self.bounds[key]))

    def rows(self, w: np.ndarray) -> tuple[np.ndarray, np.ndarray, list[str]]:
        """What must not be negative, scaled, its gradients and names."""
        every = [row for key in self.bounds for row in self.bounded_rows(key, w)]
        values, slopes, labels = map(list, zip(*every, strict=True)) if every else ([], [], [])
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
            self.system.name,
            self.names,
            self.box,
            self.objective,
            self.rows,
            lambda: self.count,
            self.tolerance,
        )

    def found(self, w: np.ndarray) -> tuple[dict[str, float], dict[str, float], dict[Key, float]]:
        """Parameters, those at the start, and all numbers."""
        begin = dict(zip(self.names, self.start.tolist(), strict=True))
        numbers: dict[Key, float] = {
            k: self.value(k, w)[0] for k in self.keys if not isinstance(k, str)
        }
        return self.design(w), begin, numbers
