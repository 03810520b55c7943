"""Cycles of a load, and the damage that they do.

Source: ASTM E1049-85, Standard Practices for Cycle Counting in Fatigue Analysis (its counting rule
through its published example).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from lumped.errors import OptionError
from lumped.functionals.damage_law import MeanStress
from lumped.life.sn_curve import SNCurve
from lumped.support.arguments import checked
from lumped.support.arrays import Real
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.cycle_count import count_cycles, damage_of_cycles


@dataclass(frozen=True, eq=False)
class Cycles(RichHtml):
    """Cycles of a load.

    Attributes
    ----------
    ranges, means : ndarray, shape (k,)
        Range from one turning point to the other, and their mean.
    counts : ndarray, shape (k,)
        1 for a cycle, 0.5 for half of one; of a distribution how many there are.
    turning_points : ndarray, shape (t,)
        Where the load turned, with its first and last value; none of a distribution.
    residue : ndarray, shape (r,)
        Turning points that close no cycle; empty where they count as half cycles.
    """

    ranges: Real
    means: Real
    counts: Real
    turning_points: Real
    residue: Real

    @property
    def total(self) -> float:
        """Number of cycles."""
        return float(self.counts.sum())

    @checked
    def classes(self, number: int = 20) -> tuple[Real, Real]:
        """Cycles in classes of equal width from zero to the largest range.

        The upper end belongs to a class.

        Parameters
        ----------
        number : int
            Of classes.

        Returns
        -------
        ends : ndarray, shape (number + 1,)
        cycles : ndarray, shape (number,)

        Raises
        ------
        OptionError
            If there is no class.
        """
        if number < 1:
            raise OptionError(f"classes: number = {number} must be at least 1.")
        ends = np.linspace(0.0, float(self.ranges.max(initial=0.0)), number + 1)
        place = np.clip(np.searchsorted(ends, self.ranges, side="left") - 1, 0, number - 1)
        found: Real = np.bincount(place, self.counts, number).astype(float)
        return ends, found

    @checked
    def equivalent(self, slope: float, *, cycles: float = 1e6) -> float:
        """Amplitude that does the same damage in a number of equal cycles, at one slope.

        Parameters
        ----------
        slope : float
            Of the S-N curve.
        cycles : float
            Their number.

        Raises
        ------
        OptionError
            If a number is not positive.
        """
        if not (slope > 0 and cycles > 0):
            raise OptionError(
                f"equivalent: slope = {slope:g} and cycles = {cycles:g} must be positive."
            )
        largest = self.ranges.max(initial=0.0)
        if not largest:
            return 0.0
        sum_ = (self.counts * (self.ranges / largest) ** slope).sum() / cycles
        return float(0.5 * largest * sum_ ** (1 / slope))

    @checked
    def damage(
        self, curve: SNCurve, *, scale: float = 1.0, mean_stress: MeanStress | None = None
    ) -> float:
        """Sum of the shares of life that the cycles take (Palmgren and Miner).

        Parameters
        ----------
        curve : SNCurve
            Life over the amplitude.
        scale : float
            Stress for each unit of the load, such as ``16 / (pi d^3)`` for the torque of a shaft.
        mean_stress : MeanStress, optional
            How the mean of a cycle counts, such as ``lumped.life.goodman("700 MPa")``; it has no
            effect by default.

        Raises
        ------
        OptionError
            If `scale` is not positive, or the mean of a cycle reaches the ultimate strength.
        """
        return damage_of(self, curve, scale, mean_stress)[0]

    def __repr__(self) -> str:
        ends, counts = self.classes(10)
        rows = [
            (number(low), number(high), f"{count:g}")
            for low, high, count in zip(ends[:-1], ends[1:], counts, strict=True)
        ]
        head = f"{self.total:g} cycles"
        if len(self.turning_points):
            head += f" of {len(self.turning_points)} turning points"
        if len(self.residue):
            head += f", and a residue of {len(self.residue)}"
        return f"{head}\n" + table(("range above", "up to", "cycles"), rows)


def damage_of(
    cycles: Cycles, curve: SNCurve, scale: float, mean_stress: MeanStress | None
) -> tuple[float, Real]:
    """Damage of all cycles, and of each.

    Raises
    ------
    OptionError
        If `scale` is not positive, or the mean of a cycle reaches the ultimate strength.
    """
    if not scale > 0:
        raise OptionError(f"damage: scale = {scale:g} must be positive.")
    law = curve.law(mean_stress, scale)
    sum_, found = damage_of_cycles(cycles.ranges, cycles.means, cycles.counts, law)
    if np.isinf(sum_):
        mean = scale * cycles.means[np.argmax(found[:, 0])]
        raise OptionError(
            f"damage: a cycle has the mean {mean:g} {curve.unit}, which reaches the ultimate "
            f"strength ({mean_stress}): the part breaks at once."
        )
    return sum_, found[:, 0]


@checked
def rainflow(values: ArrayLike, *, rule: Literal["three", "four"] = "three") -> Cycles:
    """Cycles of a load by rainflow counting.

    Parameters
    ----------
    values : array_like, shape (n,)
        The load over the time, such as ``run["shaft.tau"]`` on a grid that shows its extremes.
    rule : {"three", "four"}
        Points that a cycle is found from: three with the start point, what is left being half
        cycles (ASTM E1049-85); or four, what is left being the residue.

    Returns
    -------
    Cycles

    Raises
    ------
    OptionError
        If the shape is another, a value is not finite, or there are less than two.
    """
    load = np.asarray(values, dtype=float)
    if load.ndim != 1 or len(load) < 2:
        raise OptionError(
            f"rainflow: values of the shape {load.shape}: at least two values of one load are "
            "needed, shape (n,), such as one column of a table."
        )
    found = count_cycles(load, rule=rule)
    begins, ends = load[found.cycles.T]
    return Cycles(
        np.abs(ends - begins),
        0.5 * (begins + ends),
        found.weights,
        load[found.turning],
        load[found.residue],
    )
