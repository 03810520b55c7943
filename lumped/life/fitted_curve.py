"""S-N curves from fatigue tests.

Source: ASTM E739, Standard Practice for Statistical Analysis of Linear or Linearized Stress-Life
and Strain-Life Fatigue Data.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import ArrayLike

from lumped.errors import OptionError
from lumped.life.sn_curve import Below, SNCurve, check_points
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, number, table


@dataclass(frozen=True, eq=False)
class FittedCurve(RichHtml):
    """S-N curve through tests, and how well they determine it.

    Attributes
    ----------
    curve : SNCurve
        Median life; its knee is at the lowest amplitude of the tests, below which nothing is known.
    amplitudes, cycles : ndarray, shape (k,)
        The tests.
    confidence : float
        Of the intervals.
    slope_interval : (float, float)
        In which the slope lies with this confidence.
    deviation : float
        Standard deviation of the decimal logarithm of the cycles.
    """

    curve: SNCurve
    amplitudes: Real
    cycles: Real
    confidence: float
    slope_interval: tuple[float, float]
    deviation: float

    @checked
    def band(self, amplitudes: ArrayLike) -> tuple[Real, Real]:
        """Median lives between which the whole line lies with the confidence of the fit.

        Parameters
        ----------
        amplitudes : array_like
            Within those of the tests.

        Returns
        -------
        low, high : ndarray
            Cycles.

        Raises
        ------
        OptionError
            If an amplitude lies outside the tests.
        """
        given = np.asarray(amplitudes, dtype=float)
        low, high = self.amplitudes.min(), self.amplitudes.max()
        if not ((given >= low) & (given <= high)).all():
            unit = self.curve.unit
            raise OptionError(
                f"band: amplitudes: the tests reach from {low:g} to {high:g} {unit}; nothing is "
                "known beyond."
            )
        x, k = np.log10(self.amplitudes), len(self.amplitudes)
        away = (np.log10(given) - x.mean()) ** 2 / ((x - x.mean()) ** 2).sum()
        factor = np.sqrt(2 * scipy.stats.f.ppf(self.confidence, 2, k - 2))
        half = factor * self.deviation * np.sqrt(1 / k + away)
        middle = -np.log10(self.curve.damage(given))
        return 10 ** (middle - half), 10 ** (middle + half)

    def __repr__(self) -> str:
        knee, unit = amounts("amplitude", self.curve.unit, float(self.curve.knee))
        slopes = self.curve.slope, *self.slope_interval
        lives = self.curve.cycles, *(float(v) for v in self.band(float(self.curve.knee)))
        rows = [
            ("slope", *(number(value, 4) for value in slopes)),
            (f"cycles at {knee} {unit}", *(number(value, 4) for value in lives)),
        ]
        head = (
            f"{len(self.cycles)} tests; standard deviation of lg N {number(self.deviation, 3)}, "
            f"intervals of {self.confidence:.0%} confidence"
        )
        return f"{head}\n" + table(("", "median", "from", "to"), rows)


@checked
def fit_sn_curve(
    tests: Sequence[tuple[float | str, float]],
    *,
    below: Below = "elementary",
    confidence: float = 0.95,
    unit: str = "Pa",
) -> FittedCurve:
    """Straight S-N curve in logarithmic scales through fatigue tests.

    The logarithm of the cycles is regressed on that of the amplitude, which the tests set; its
    scatter is taken as normal, the same at all amplitudes.

    Parameters
    ----------
    tests : sequence of (float or str, float)
        Amplitude and cycles to failure of each; tests without failure do not count here.
    below : {"elementary", "original", "haibach"} or float
        What holds below the tests (see `SNCurve`).
    confidence : float
        Of the intervals.
    unit : str
        SI unit of the amplitudes.

    Returns
    -------
    FittedCurve

    Raises
    ------
    OptionError
        If there are less than three tests or two amplitudes, a number is not positive, the cycles
        do not fall where the amplitude rises, or the confidence is not between 0 and 1.
    UnitError
        If an amplitude has a unit of another kind.
    """
    if not 0 < confidence < 1:
        raise OptionError(f"fit_sn_curve: confidence = {confidence:g} must be between 0 and 1.")
    found = check_points(tests, "tests", unit, "fit_sn_curve")
    amplitudes, cycles = np.array(found).reshape(-1, 2).T
    if len(found) < 3 or len(set(amplitudes.tolist())) < 2:
        raise OptionError(
            f"fit_sn_curve: {len(found)} tests at {len(set(amplitudes.tolist()))} amplitudes: at "
            "least three tests and two amplitudes are needed."
        )
    x, y = np.log10(amplitudes), np.log10(cycles)
    spread = ((x - x.mean()) ** 2).sum()
    slope = -((x - x.mean()) * (y - y.mean())).sum() / spread
    if not slope > 0:
        raise OptionError(
            f"fit_sn_curve: the slope is {slope:g}: over all tests the cycles to failure must fall "
            "where the amplitude rises."
        )
    off = y - y.mean() + slope * (x - x.mean())
    deviation = float(np.sqrt((off**2).sum() / (len(x) - 2)))
    half = scipy.stats.t.ppf(0.5 + 0.5 * confidence, len(x) - 2) * deviation / np.sqrt(spread)
    knee = float(amplitudes.min())
    at_knee = 10 ** (y.mean() - slope * (np.log10(knee) - x.mean()))
    curve = SNCurve(knee, float(at_knee), float(slope), below, unit=unit)
    interval = float(slope - half), float(slope + half)
    return FittedCurve(curve, amplitudes, cycles, confidence, interval, deviation)
