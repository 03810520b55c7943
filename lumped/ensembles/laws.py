"""What a distribution of a parameter is: as it is written, and in numbers of its unit."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from lumped.errors import OptionError, ParameterError
from lumped.support.units import amount, has_unit, plain

Array = NDArray[np.float64]
Amount = float | str
"""A number in SI units, or a text with a unit."""


@dataclass(frozen=True)
class Parameter:
    """What a distribution is for.

    Attributes
    ----------
    name : str
        With which errors begin.
    unit : str
        Its SI unit.
    nominal : float or None
        Its value in the model; None for a factor.
    """

    name: str
    unit: str
    nominal: float | None

    def value(self, what: str, given: object) -> float:
        """One of its values, as a number in its unit.

        Raises
        ------
        UnitError
            If its unit is of another dimension.
        ParameterError
            If it is no number.
        """
        found = plain(given, self.unit, f"{self.name}: {what} =", ParameterError)
        if not math.isfinite(found):
            raise ParameterError(f"{self.name}: {what} = {given} must be a finite number.")
        return found

    def width(self, what: str, given: Any) -> float:
        """A difference of its values, greater than zero; 5 degC is 5 K here.

        Raises
        ------
        UnitError
            If its unit is of another dimension.
        ParameterError
            If it is no number.
        OptionError
            If it is not greater than zero.
        """
        found = self.value(what, given)
        if isinstance(given, str):
            found -= self.value(what, f"0 {given.strip().partition(' ')[2]}")
        elif has_unit(given):
            found -= self.value(what, type(given)(0.0, given.units))
        if not found > 0:
            self.refuse(
                f"{what} = {self.amount(found)} must be greater than zero. Leave out a parameter "
                "that does not vary."
            )
        return found

    def amount(self, value: float) -> str:
        """A value with the unit."""
        return amount(value, self.unit)

    def check_order(self, low: float, high: float) -> None:
        """Refuse ends of a range that are not in order.

        Raises
        ------
        OptionError
            With both.
        """
        if not low < high:
            self.refuse(
                f"low = {self.amount(low)} must be less than high = {self.amount(high)}. Give the "
                "smaller one first."
            )

    def refuse(self, text: str) -> NoReturn:
        """Refuse a distribution of this parameter.

        Raises
        ------
        OptionError
            Always.
        """
        raise OptionError(f"{self.name}: {text}")


@dataclass(frozen=True)
class Law:
    """A distribution in numbers of the unit of its parameter.

    Attributes
    ----------
    quantile : callable
        Value for each probability, array to array.
    below, above : callable
        Probability of less, and of more, than a number.
    at_score : callable
        Value for each number of a standard normal variable, which has the same probability, and
        its derivative by that number. Both tails keep their digits.
    origin : (Distribution, Parameter) or None
        From which copies make it anew.
    """

    quantile: Callable[[Array], Array]
    below: Callable[[float], float]
    above: Callable[[float], float]
    at_score: Callable[[Array], tuple[Array, Array]]
    origin: tuple[Distribution, Parameter] | None = None

    def __reduce__(self) -> tuple[Any, ...]:
        return law_of, self.origin


class Distribution(ABC):
    """A distribution as it was written, with units perhaps."""

    @abstractmethod
    def law(self, of: Parameter) -> Law:
        """The distribution in numbers.

        Raises
        ------
        LumpedError
            If what was given is no distribution of this parameter.
        """


def law_of(distribution: Distribution, of: Parameter) -> Law:
    """A distribution in numbers, which can be copied to other processes."""
    return replace(distribution.law(of), origin=(distribution, of))
