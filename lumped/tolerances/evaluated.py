"""Functionals at many values of parameters: what a scene asks of runs, modes and responses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from lumped.errors import LumpedError, OptionError, UnknownNameError

__all__ = ["Array", "Evaluated", "Failures", "one_by_one"]

Array = NDArray[np.float64]
Failures = dict[int, str]
"""Why evaluations failed, by their number."""


class Evaluated(Protocol):
    """Functionals of one kind of analysis, for the values of d parameters."""

    labels: tuple[str, ...]
    units: tuple[str, ...]

    def values(self, x: Array) -> tuple[Array, Failures]:
        """Functionals, shape (n, k); nan where one failed."""

    def slopes(self, x: Array) -> tuple[Array, Array, Failures]:
        """Functionals, and derivatives by the parameters, shapes (n, k) and (n, k, d)."""

    def curvature(self, x: Array, k: int) -> Array:
        """Second derivatives of functional k at one point, shape (d, d)."""


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
