"""Piecewise polynomials: their pieces and borders, and the settings of a run for a piece."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

FIXED = 5
"""Settings of a piece before its coefficients: number, begin, and three of its margin."""


@dataclass(frozen=True)
class Pieces:
    """Polynomials of an argument, one after the other.

    Attributes
    ----------
    begins : tuple of float, shape (n,)
        Begins of the pieces, increasing. Without a period the first piece also applies below its
        begin, and the last one has no end.
    rows : tuple of tuple of float, shape (n, degree + 1)
        Coefficients of each piece by falling powers of the distance from its begin.
    period : float, optional
        Period after which the pieces repeat; the last one ends a period after the first begins.
    """

    begins: tuple[float, ...]
    rows: tuple[tuple[float, ...], ...]
    period: float | None = None

    @property
    def count(self) -> int:
        """Number of pieces (of one period)."""
        return len(self.begins)

    @property
    def width(self) -> int:
        """Number of settings of a piece."""
        return FIXED + len(self.rows[0])

    @cached_property
    def _begins(self) -> np.ndarray:
        return np.array(self.begins)

    @cached_property
    def table(self) -> np.ndarray:
        """Settings of the pieces, shape (n, width).

        With ``s`` the distance from the begin, the margin ``k0 + s (k1 + k2 s)`` is positive inside
        the piece and zero at its borders, where it falls outwards with the slope 1.
        """
        n, begins = self.count, self._begins
        if self.period is None:
            lengths = np.append(np.diff(begins), np.inf)
        else:
            lengths = np.diff(np.append(begins, begins[0] + self.period))
        margin = np.column_stack([np.zeros(n), np.ones(n), -1.0 / lengths])
        if self.period is None:
            margin[0] = (lengths[0], -1.0, 0.0) if n > 1 else (1.0, 0.0, 0.0)
            margin[-1, 2] = 0.0
        return np.column_stack([np.arange(n), begins, margin, np.array(self.rows)])

    def number(self, place: np.ndarray) -> np.ndarray:
        """Number of the piece at each place; beyond one period the numbers go on."""
        begins = self._begins
        if self.period is None:
            found: np.ndarray = np.searchsorted(begins[1:], place, side="right")
            return found
        cycle = np.floor((place - begins[0]) / self.period)
        inside = np.searchsorted(begins[1:], place - cycle * self.period, side="right")
        found = cycle.astype(int) * self.count + inside
        # rounding of the quotient may name the neighbour
        found = found + (place >= self.begin(found + 1))
        return found - (place < self.begin(found))

    def begin(self, number: np.ndarray) -> np.ndarray:
        """Begins of pieces; the first one without a period has the place from which s counts."""
        begins = self._begins
        if self.period is None:
            found: np.ndarray = begins[np.clip(number, 0, self.count - 1)]
            return found
        cycle, inside = np.divmod(number, self.count)
        return np.asarray(begins[inside] + cycle * self.period)

    def settings(self, number: np.ndarray) -> np.ndarray:
        """Settings of a run in a piece, shape (..., width)."""
        number = np.asarray(number)
        found: np.ndarray = self.table[number % self.count].copy()
        found[..., 0] = number
        found[..., 1] = self.begin(number)
        return found
