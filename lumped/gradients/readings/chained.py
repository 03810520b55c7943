"""Functionals from the readings of which they are made: values and derivatives."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lumped.functionals import Functional
from lumped.functionals.functional import Branch, readings_of

_AGREE = 1e-5
"""Relative difference up to which derivatives to both sides are the same."""


@dataclass(frozen=True)
class Chained:
    """Functionals of which the readings are known.

    Attributes
    ----------
    functionals : tuple of Functional
        All of them.
    read : ndarray, shape (n,)
        Values of their readings (see `readings_of`).
    rtol : float
        Relative accuracy of these.
    """

    functionals: tuple[Functional, ...]
    read: np.ndarray
    rtol: float

    @cached_property
    def places(self) -> list[list[int]]:
        """Places of the readings of each functional."""
        numbers = {reading: i for i, reading in enumerate(readings_of(self.functionals))}
        return [[numbers[reading] for reading in f.readings] for f in self.functionals]

    @cached_property
    def values(self) -> np.ndarray:
        """Values of the functionals."""
        pairs = zip(self.functionals, self.places, strict=True)
        return np.array([f.value(self.read[None, own])[0] for f, own in pairs])

    @cached_property
    def branches(self) -> list[list[Branch]]:
        """Derivatives of each by its readings, on all sides of its kinks."""
        pairs = zip(self.functionals, self.places, strict=True)
        return [f.branches(self.read[own], self.rtol) for f, own in pairs]

    @property
    def has_kinks(self) -> bool:
        """Whether one stands at a kink."""
        return any(len(branches) > 1 for branches in self.branches)

    def counting(self, k: int) -> list[int]:
        """Readings by which a functional changes."""
        slopes = np.abs([branch.slopes for branch in self.branches[k]]).max(axis=0)
        return [place for place, slope in zip(self.places[k], slopes, strict=True) if slope]

    def slopes(self, by: np.ndarray, side: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the functionals, and which are none, shapes (len(functionals), m).

        Parameters
        ----------
        by : ndarray, shape (n, m)
            Derivatives of the readings.
        side : {0, 1, -1}
            To which side; 0 for both, which may differ at kinks.
        """
        found = np.zeros((len(self.functionals), by.shape[1]))
        absent = np.zeros(found.shape, dtype=bool)
        for k, (branches, own) in enumerate(zip(self.branches, self.places, strict=True)):
            rates = by[own]
            sides = [_through(branch, rates) for branch in branches]
            found[k] = sides[0]
            for branch, other in zip(branches[1:], sides[1:], strict=True):
                if side:
                    found[k] = np.where(branch.lies(side * rates), other, found[k])
                else:
                    absent[k] |= differ(sides[0], other)
        return found, absent

    def find_lost(self, absent: np.ndarray) -> np.ndarray:
        """Which derivatives are none because those of readings are none, as `slopes`."""
        rows = [absent[self.counting(k)].any(axis=0) for k in range(len(self.functionals))]
        return np.array(rows, dtype=bool).reshape(len(rows), absent.shape[1])


def _through(branch: Branch, rates: np.ndarray) -> np.ndarray:
    """Derivatives on one side of kinks; readings without influence need have none."""
    counts = branch.slopes != 0
    found: np.ndarray = branch.slopes[counts] @ rates[counts]
    return found


def differ(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Where derivatives to both sides are different."""
    size = np.maximum(np.abs(one), np.abs(other))
    least = 1e-9 * size.max(initial=0.0)
    found: np.ndarray = np.abs(one - other) > _AGREE * size + least
    return found
