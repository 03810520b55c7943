"""Functionals at many values of parameters: what a scene asks of runs, modes and responses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lumped.errors import LumpedError, OptionError, UnknownNameError

__all__ = ["Array", "Evaluated", "Failures", "curvatures_along", "one_by_one"]

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
