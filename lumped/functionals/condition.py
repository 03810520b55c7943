"""Conditions: what a number that sums up a run, modes or a vibration may not pass."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from lumped.errors import OptionError, shown
from lumped.support.units import plain


class Bounded:
    """What ``<=`` and ``>=`` with a number make a condition of."""

    __slots__ = ()

    def __le__(self, most: float | str) -> Condition:
        return Condition(self, None, most)

    def __ge__(self, least: float | str) -> Condition:
        return Condition(self, least, None)


@dataclass(frozen=True, eq=False)
class Condition:
    """A number is at most, or at least, another one.

    Attributes
    ----------
    of : Bounded
        What is bounded, such as a functional.
    low, high : float or str or None
        Its bound, in the SI unit of the functional or with a unit, such as ``"5 kN.m"``; one of
        them is None.
    """

    of: Any
    low: float | str | None
    high: float | str | None

    def bounds(self, unit: str, analysis: str) -> tuple[float, float]:
        """Lower and upper bound as numbers in a unit; one is infinite.

        Raises
        ------
        UnitError
            If the bound has a unit of another dimension.
        OptionError
            If it is no number.
        """
        what = f"{analysis}: {self}:"
        if self.low is None:
            return -math.inf, plain(self.high, unit, what, OptionError)
        return plain(self.low, unit, what, OptionError), math.inf

    def __str__(self) -> str:
        sign, bound = ("<=", self.high) if self.low is None else (">=", self.low)
        return f"{self.of} {sign} {bound if isinstance(bound, str) else shown(bound)}"

    def __bool__(self) -> bool:
        raise OptionError(
            f"{self} is a condition of a design or a run, neither true nor false by itself. Give "
            "several as a list, such as [f >= 1, f <= 2], without `and` and without 1 <= f <= 2."
        )
