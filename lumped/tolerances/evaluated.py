"""Functionals at many values of parameters: what a scene asks of runs, modes and responses."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from lumped.compiler.system import System
from lumped.errors import LumpedError, OptionError, UnknownNameError
from lumped.functionals import Functional
from lumped.functionals.functional import readings_of
from lumped.support.arrays import Real

Failures = dict[int, str]
"""Why evaluations failed, by their number."""


class Evaluation(NamedTuple):
    """What evaluations gave.

    Attributes
    ----------
    values : ndarray, shape (n, k)
        Functionals; nan where one failed.
    slopes : ndarray, shape (n, k, d)
        Their derivatives by the parameters; shape (n, k, 0) where none were asked for.
    failures : dict of int to str
    """

    values: Real
    slopes: Real
    failures: Failures

    @classmethod
    def unknown(cls, n: int, k: int, d: int) -> Evaluation:
        """Room for results."""
        return cls(np.full((n, k), np.nan), np.full((n, k, d), np.nan), {})


class Evaluated(ABC):
    """Functionals of one kind of analysis, for the values of d parameters.

    Attributes
    ----------
    labels, units : tuple of str
        The functionals as printed, and their units.
    error : float
        Relative error of their derivatives.
    notes : tuple of str
        What the nominal analysis knows of its own accuracy.
    """

    error: float = 1e-9
    notes: tuple[str, ...] = ()

    def __init__(self, system: System, names: tuple[str, ...], of: Mapping[str, Functional]):
        self._system, self._names, self._of = system, names, dict(of)
        self.labels, self.units = tuple(of), tuple(f.unit(system) for f in of.values())

    @abstractmethod
    def evaluate(self, x: Real, with_slopes: bool) -> Evaluation:
        """Functionals at parameters of shape (n, d), and derivatives if they are asked for."""

    def curvatures(self, x: Real) -> Real | None:
        """Exact second derivatives at one point, shape (k, d, d); None where none are formed."""
        return None


class OfReadings(Evaluated):
    """Functionals from the readings of which they are made (see `Evaluated`)."""

    def __init__(self, system: System, names: tuple[str, ...], of: Mapping[str, Functional]):
        super().__init__(system, names, of)
        self._readings = readings_of(of.values())
        self._places = [[self._readings.index(r) for r in f.readings] for f in of.values()]

    def evaluate(self, x: Real, with_slopes: bool) -> Evaluation:
        """Functionals of all designs, and their derivatives if they are asked for."""
        d = len(self._names) if with_slopes else 0
        read = Evaluation.unknown(len(x), len(self._readings), d)
        self._read_together(x, read)
        known = ~(np.isnan(read.values).any(axis=1) | np.isnan(read.slopes).any(axis=(1, 2)))
        for i in np.flatnonzero(~known).tolist():
            try:
                read.values[i], read.slopes[i] = self._read_alone(x[i], with_slopes)
            except (OptionError, UnknownNameError):
                raise
            except LumpedError as error:
                read.failures[i] = str(error)
        values, slopes, _ = Evaluation.unknown(len(x), len(self._of), d)
        pairs = zip(self._of.values(), self._places, strict=True)
        for k, (functional, own) in enumerate(pairs):
            own_values = read.values[:, own]
            values[:, k] = functional.value(own_values)
            for i in np.flatnonzero(np.isfinite(own_values).all(axis=1) & with_slopes).tolist():
                by = functional.branches(own_values[i], 0.0)[0].slopes
                slopes[i, k] = by @ read.slopes[i, own]
        return Evaluation(values, slopes, read.failures)

    def _read_together(self, x: Real, found: Evaluation) -> None:
        """Fill in readings of designs that are found side by side."""

    @abstractmethod
    def _read_alone(self, row: Real, with_slopes: bool) -> tuple[Real, Real]:
        """Readings of one design and their derivatives, shapes (m,) and (m, d) or (m, 0)."""

    def curvatures(self, x: Real) -> Real | None:
        """Those of readings; None for expressions of these."""
        if any(functional.reading is None for functional in self._of.values()):
            return None
        found = self._curvatures(x)
        return None if found is None else found[[own[0] for own in self._places]]

    def _curvatures(self, x: Real) -> Real | None:
        """Exact second derivatives of readings, shape (m, d, d)."""
        return None


def curvatures_along(slopes: Callable[[Real], Real], x: Real, along: Real, error: float) -> Real:
    """Second derivatives along directions, by central differences of first ones.

    Slopes are taken at ``h = error**(1/3)`` of each direction to both sides. That leaves out
    ``h**2 / 6`` times their third derivative along it, and their own error adds at most ``error /
    h`` times their size: both ``error**(2/3)``, 1e-4 for runs with ``rtol=1e-6``, where directions
    are as long as parameters scatter.

    Parameters
    ----------
    slopes : callable
        Derivatives at points of shape (n, d), shape (n, ..., d).
    x : ndarray, shape (d,)
        The point.
    along : ndarray, shape (m, d)
        The directions.
    error : float
        Relative error of the slopes.

    Returns
    -------
    ndarray, shape (..., m, m)
        Not a number where slopes are none.
    """
    h = np.cbrt(error)
    after, before = np.split(slopes(np.concatenate([x + h * along, x - h * along])), 2)
    found = np.moveaxis((after - before) @ along.T / (2 * h), 0, -2)
    symmetric: Real = 0.5 * (found + found.swapaxes(-1, -2))
    return symmetric
