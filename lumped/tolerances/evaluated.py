"""Functionals at many values of parameters: what a scene asks of runs, modes and responses."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lumped.compiler.system import System
from lumped.errors import LumpedError, OptionError, UnknownNameError
from lumped.functionals import Functional
from lumped.functionals.functional import readings_of

Array = NDArray[np.float64]
Failures = dict[int, str]
"""Why evaluations failed, by their number."""


class Evaluated(Protocol):
    """Functionals of one kind of analysis, for the values of d parameters.

    Attributes
    ----------
    labels, units : tuple of str
        The functionals as printed, and their units.
    error : float
        Relative error of their derivatives.
    """

    labels: tuple[str, ...]
    units: tuple[str, ...]
    error: float = 1e-9

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Functionals, shape (n, k); nan where one failed."""

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Functionals, and derivatives by the parameters, shapes (n, k) and (n, k, d)."""

    def curvatures(self, x: Array) -> Array | None:
        """Exact second derivatives at one point, shape (k, d, d); None where none are formed."""
        return None


class EvaluatedReadings(Protocol):
    """Readings of one kind of analysis; values, slopes and curvatures as in `Evaluated`."""

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Readings."""

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Readings and derivatives."""

    def curvatures(self, x: Array) -> Array | None:
        """Exact second derivatives at one point."""
        return None


class OfReadings(Evaluated):
    """Functionals from the readings of which they are made (see `Evaluated`).

    Parameters
    ----------
    kind : callable
        Evaluates readings, as ``kind(names=, of=)``.
    system : System
    of : mapping of str to functional
    names : tuple of str
        What varies.
    """

    def __init__(
        self,
        kind: Callable[..., EvaluatedReadings],
        system: System,
        of: Mapping[str, Functional],
        names: tuple[str, ...],
    ) -> None:
        self._of, readings = tuple(of.values()), readings_of(of.values())
        self._read = kind(names=names, of=readings)
        self._places = [[readings.index(r) for r in f.readings] for f in self._of]
        self.labels, self.units = tuple(of), tuple(f.unit(system) for f in of.values())

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Functionals of all designs."""
        read, failures = self._read.values(x)
        return self._values(read), failures

    def _values(self, read: Array) -> Array:
        pairs = zip(self._of, self._places, strict=True)
        return np.column_stack([f.value(read[:, own]) for f, own in pairs])

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Functionals and derivatives of all designs."""
        read, by, failures = self._read.slopes(x)
        found = np.full((len(x), len(self._of), by.shape[2]), np.nan)
        for k, (functional, own) in enumerate(zip(self._of, self._places, strict=True)):
            for i in np.flatnonzero(np.isfinite(read[:, own]).all(axis=1)).tolist():
                found[i, k] = functional.branches(read[i, own], 0.0)[0].slopes @ by[i, own]
        return self._values(read), found, failures

    def curvatures(self, x: Array) -> Array | None:
        """Those of readings; None for expressions of these."""
        found = self._read.curvatures(x)
        if found is None or any(functional.reading is None for functional in self._of):
            return None
        return found[[own[0] for own in self._places]]


def curvatures_along(
    slopes: Callable[[Array], Array], x: Array, along: Array, error: float
) -> Array:
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
    symmetric: Array = 0.5 * (found + found.swapaxes(-1, -2))
    return symmetric


def one_by_one(
    x: Array, shapes: Sequence[tuple[int, ...]], one: Callable[[Array], Sequence[Any]]
) -> tuple[list[Array], Failures]:
    """Results at one point after the other; nan where it fails.

    Parameters
    ----------
    x : ndarray, shape (n, d)
    shapes : sequence of tuple
        Of each result.
    one : callable
        Results at one point.

    Raises
    ------
    OptionError, UnknownNameError
        What is wrong at any point.
    """
    found = [np.full((len(x), *shape), np.nan) for shape in shapes]
    failures: Failures = {}
    for i, row in enumerate(x):
        try:
            for column, result in zip(found, one(row), strict=True):
                column[i] = result
        except (OptionError, UnknownNameError):
            raise
        except LumpedError as error:
            failures[i] = str(error)
    return found, failures
