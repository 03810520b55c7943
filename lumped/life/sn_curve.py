"""Cycles to failure over the amplitude of a cycle.

Source: Haibach, Betriebsfestigkeit (slope below the knee).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumped.errors import OptionError
from lumped.support.arguments import checked

__all__ = ["SNCurve"]

Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SNCurve:
    """Cycles to failure over the amplitude: ``N = cycles (knee / amplitude)^slope``.

    Parameters
    ----------
    knee : float
        Amplitude at the knee, in the unit of the amplitudes.
    cycles : float
        Cycles to failure there.
    slope : float
        Slope above the knee.
    below : {"elementary", "original", "haibach"}
        Below the knee: the same slope (elementary Miner), no damage (original Miner), or the slope
        ``2 slope - 1`` (Haibach).

    Raises
    ------
    OptionError
        If a number is not positive.
    """

    knee: float
    cycles: float
    slope: float
    below: Literal["elementary", "original", "haibach"] = "elementary"

    def __post_init__(self) -> None:
        for name in ("knee", "cycles", "slope"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0):
                raise OptionError(f"SNCurve: {name} = {value:g} must be positive and finite.")
        if self.below not in ("elementary", "original", "haibach"):
            raise OptionError(
                f"SNCurve: below = {self.below!r}: 'elementary', 'original' or 'haibach'."
            )

    @checked
    def damage(self, amplitudes: ArrayLike) -> Real:
        """Damage of one cycle of each amplitude, ``1 / N``.

        Parameters
        ----------
        amplitudes : array_like
            In the unit of the knee, not negative.
        """
        share = np.asarray(amplitudes, dtype=float) / self.knee
        slopes = {"elementary": self.slope, "original": np.inf, "haibach": 2 * self.slope - 1}
        with np.errstate(divide="ignore"):
            low = np.where(share < 1, share ** slopes[self.below], 0.0)
        found: Real = np.where(share < 1, low, share**self.slope) / self.cycles
        return found
