"""Orders of a vibration put together over a cycle."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Literal

import numpy as np

from lumped.errors import OptionError
from lumped.support.arrays import Complex, Real

_LONGEST = 1000
"""Turns after which orders must repeat."""
_FINE = 32
"""Points for each period of the highest order, between which extremes are then located."""
_STEPS = 6


@dataclass(frozen=True, eq=False)
class Synthesis:
    """A quantity over a cycle, from its orders, at each speed; without its mean.

    Attributes
    ----------
    name, unit : str
        The quantity.
    speeds : ndarray, shape (k,)
        Speeds, rad/s.
    orders : ndarray, shape (o,)
        Periods for each turn.
    amplitudes : ndarray of complex, shape (k, o)
        ``sum Re(amplitude exp(j order angle))``.
    """

    name: str
    unit: str
    speeds: Real
    orders: Real
    amplitudes: Complex

    @property
    def maximum(self) -> Real:
        """Largest size over the cycle, shape (k,)."""
        (_, high), (_, low) = self.extremes
        return np.maximum(np.abs(high), np.abs(low))

    @property
    def half_range(self) -> Real:
        """Half the difference between highest and lowest value over the cycle, shape (k,)."""
        (_, high), (_, low) = self.extremes
        return 0.5 * (high - low)

    @property
    def sum(self) -> Real:
        """Sum of the amplitudes, as if all orders met in phase, shape (k,)."""
        found: Real = np.abs(self.amplitudes).sum(axis=1)
        return found

    def measure(self, name: Literal["maximum", "half range", "sum"]) -> Real:
        """One of these by its name, shape (k,)."""
        found: Real = getattr(self, name.replace(" ", "_"))
        return found

    @property
    def has_cycle(self) -> bool:
        """Whether the orders repeat together after some turns."""
        try:
            return self.turns > 0
        except OptionError:
            return False

    def at(self, angle: Real) -> Real:
        """Values at angles of the shaft, rad, shape (k, angles)."""
        found: Real = (
            self.amplitudes @ np.exp(1j * self.orders[:, None] * np.ravel(angle)[None, :])
        ).real
        return found

    @cached_property
    def turns(self) -> int:
        """Turns after which all orders repeat.

        Raises
        ------
        OptionError
            If they do not within a thousand turns.
        """
        shares = [Fraction(float(o)).limit_denominator(_LONGEST) for o in self.orders]
        for share, order in zip(shares, self.orders, strict=True):
            if abs(float(share) - order) > 1e-9 * order:
                raise OptionError(
                    f"{self.name}: order {order:.9g} does not repeat within {_LONGEST} turns, so "
                    "that there is no cycle; take the sum of the amplitudes, `sum`."
                )
        found = lcm(*(share.denominator for share in shares))
        if found > _LONGEST:
            raise OptionError(
                f"{self.name}: the orders repeat together only after {found} turns; take fewer "
                "orders, or the sum of the amplitudes, `sum`."
            )
        return found

    @cached_property
    def extremes(self) -> tuple[tuple[Real, Real], tuple[Real, Real]]:
        """Angles and values of the highest and of the lowest value, shapes (k,).

        The greatest of all: a value lies at most ``h^2 / 8 sum(order^2 abs(amplitude))`` above the
        nearest of samples a distance h apart (Taylor), so each sample that is not lower than that
        below the greatest is a place near which it is looked for.
        """
        numbers = np.rint(self.orders * self.turns).astype(int)
        points = 1 << int(_FINE * numbers.max() - 1).bit_length()
        spectrum = np.zeros((len(self.speeds), points // 2 + 1), dtype=complex)
        spectrum[:, numbers] = self.amplitudes
        values = np.fft.irfft(spectrum * (points / 2), points, axis=1)
        step = 2 * np.pi * self.turns / points
        angle, low = self._highest(-values, -self.amplitudes, step)
        return self._highest(values, self.amplitudes, step), (angle, -low)

    def _highest(self, values: Real, amplitudes: Complex, step: float) -> tuple[Real, Real]:
        """Angles of the highest values, and these, shapes (k,), from samples, shape (k, n)."""
        above = step**2 / 8 * (np.abs(amplitudes) @ self.orders**2)
        k, sample = np.nonzero(values >= (values.max(axis=1) - above)[:, None])
        begin: Real = np.multiply(step, sample, dtype=np.float64)
        angle, each = begin, amplitudes[k]
        for _ in range(_STEPS):
            turning = each * np.exp(1j * self.orders * angle[:, None])
            slope = (1j * self.orders * turning).real.sum(axis=1)
            bend = (-(self.orders**2) * turning).real.sum(axis=1)
            towards = -slope / np.where(bend == 0, np.inf, bend)
            angle = np.clip(angle + towards, begin - step, begin + step)
        found: Real = (each * np.exp(1j * self.orders * angle[:, None])).real.sum(axis=1)
        best = np.lexsort((found, k))[np.cumsum(np.bincount(k, minlength=len(values))) - 1]
        return angle[best], found[best]
