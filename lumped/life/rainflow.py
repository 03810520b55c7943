"""Cycles of a load, and the damage that they do.

Source: ASTM E1049-85, Standard Practices for Cycle Counting in Fatigue Analysis (its counting rule
through its published example).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumped.errors import OptionError
from lumped.life.sn_curve import SNCurve
from lumped.support.arguments import checked
from lumped.support.text_table import number, table

__all__ = ["Cycles", "rainflow"]

Real = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Cycles:
    """Cycles of a load.

    Attributes
    ----------
    ranges, means : ndarray, shape (k,)
        Range from one turning point to the other, and their mean.
    counts : ndarray, shape (k,)
        1 for a cycle, 0.5 for half of one.
    turning_points : ndarray, shape (t,)
        Where the load turned, with its first and last value.
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
    def damage(self, curve: SNCurve, *, per_unit: float = 1.0) -> float:
        """Sum of the shares of life that the cycles take (Palmgren and Miner).

        Parameters
        ----------
        curve : SNCurve
            Life over the amplitude; the mean has no effect.
        per_unit : float
            Stress for each unit of the load, such as ``16 / (pi d^3)`` for the torque of a shaft.

        Raises
        ------
        OptionError
            If `per_unit` is not positive.
        """
        if not (np.isfinite(per_unit) and per_unit > 0):
            raise OptionError(f"damage: per_unit = {per_unit:g} must be positive and finite.")
        return float((self.counts * curve.damage(0.5 * per_unit * self.ranges)).sum())

    def __repr__(self) -> str:
        ends, counts = self.classes(10)
        rows = [
            (number(low), number(high), f"{count:g}")
            for low, high, count in zip(ends[:-1], ends[1:], counts, strict=True)
        ]
        head = f"{self.total:g} cycles of {len(self.turning_points)} turning points"
        if len(self.residue):
            head += f", and a residue of {len(self.residue)}"
        return f"{head}\n" + table(("range above", "up to", "cycles"), rows)


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
        If a value is not finite, or there are less than two.
    """
    load = np.asarray(values, dtype=float).ravel()
    if len(load) < 2 or not np.isfinite(load).all():
        raise OptionError("rainflow: at least two finite values are needed.")
    points = _turning_points(load)
    found = _by_three(points) if rule == "three" else _by_four(points)
    cycles, residue = found
    begins, ends, counts = np.array(cycles, dtype=float).reshape(-1, 3).T
    return Cycles(
        np.abs(ends - begins), 0.5 * (begins + ends), counts, points, np.array(residue, dtype=float)
    )


def _turning_points(load: Real) -> Real:
    """First and last value, and those between at which the load turns; equal neighbours once."""
    kept = load[np.append(True, np.diff(load) != 0)]
    slope = np.sign(np.diff(kept))
    inner = np.flatnonzero(slope[1:] != slope[:-1]) + 1
    places = np.concatenate([[0], inner, [len(kept) - 1]]) if len(kept) > 1 else [0]
    found: Real = kept[places]
    return found


def _by_three(points: Real) -> tuple[list[tuple[float, float, float]], list[float]]:
    """Begin, end and count of cycles; nothing is left."""
    cycles: list[tuple[float, float, float]] = []
    held: list[float] = []
    for point in points.tolist():
        held.append(point)
        while len(held) >= 3 and abs(held[-1] - held[-2]) >= abs(held[-2] - held[-3]):
            if len(held) == 3:
                cycles.append((held[0], held[1], 0.5))
                held.pop(0)
            else:
                cycles.append((held[-3], held[-2], 1.0))
                del held[-3:-1]
    cycles += [(a, b, 0.5) for a, b in itertools.pairwise(held)]
    return cycles, []


def _by_four(points: Real) -> tuple[list[tuple[float, float, float]], list[float]]:
    """Begin, end and count of closed cycles, and the points that are left."""
    cycles: list[tuple[float, float, float]] = []
    held: list[float] = []
    for point in points.tolist():
        held.append(point)
        while len(held) >= 4:
            before, inner, after = (abs(held[i + 1] - held[i]) for i in (-4, -3, -2))
            if inner > before or inner > after:
                break
            cycles.append((held[-3], held[-2], 1.0))
            del held[-3:-1]
    return cycles, held
