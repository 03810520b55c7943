"""What a slider moves, and between which ends."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, ParameterError, shown
from lumped.language.quantity import Param
from lumped.support.text_table import number
from lumped.support.units import amount, plain

Ends = tuple[float | str, float | str]
Wanted = Iterable[Name] | Mapping[Name, Ends] | Mapping[str, Ends]
"""Parameters to move, and the ends of their sliders."""
_STEPS = 400
"""Steps of a slider from end to end."""
_WIDE = 30.0
"""Ratio of the ends from which on steps are equal ratios."""


@dataclass(frozen=True)
class Slider:
    """A parameter and its range on the page.

    Attributes
    ----------
    name, unit, text : str
        Of the parameter.
    default : float
        Its value in the model.
    low, high : float
        Ends.
    is_ratio : bool
        Steps are equal ratios, not equal differences.
    """

    name: str
    unit: str
    text: str
    default: float
    low: float
    high: float
    is_ratio: bool

    @property
    def part(self) -> str:
        """Path of the component that has the parameter; empty for the model."""
        return self.name.rpartition(".")[0]

    @property
    def ends(self) -> tuple[float, float]:
        """Positions of the ends."""
        return self.position(self.low), self.position(self.high)

    @property
    def step(self) -> float:
        """Distance of neighbouring positions; the default is on one."""
        low, high = self.ends
        return (high - low) / _STEPS

    def position(self, value: float) -> float:
        """Where a value stands: its decadic logarithm, or itself."""
        return math.log10(value) if self.is_ratio else value

    def value(self, position: float) -> float:
        """The value at a position; next to an end or the default exactly these.

        Raises
        ------
        ParameterError
            If it is beyond the ends.
        """
        near = 1e-6 * (self.ends[1] - self.ends[0])
        for known in (self.default, self.low, self.high):
            if self.low <= known <= self.high and abs(position - self.position(known)) <= near:
                return known
        within = abs(position) < 400 or not self.is_ratio
        return self.check(10.0**position if self.is_ratio and within else position)

    def check(self, value: float) -> float:
        """The value itself.

        Raises
        ------
        ParameterError
            If it is beyond the ends.
        """
        if not self.low <= value <= self.high:
            raise ParameterError(
                f"{self.name} = {amount(value, self.unit)} ({self.text}): its slider goes from "
                f"{number(self.low)} to {number(self.high)}."
            )
        return value


def slider(system: System, theta: np.ndarray, name: Name, ends: Ends | None = None) -> Slider:
    """A slider of a parameter, which begins at its value in `theta`.

    Ends that are not given are those of its range, where this is narrow. Otherwise they are a tenth
    and ten times of a positive value, no value and twice the value of one that may have any sign,
    and -1 and 1 if it is zero; within its range.

    Raises
    ------
    UnknownNameError
        If the parameter does not exist, or is bound to others.
    ParameterError, UnitError
        If an end is no number, or out of the range of the parameter.
    OptionError
        If the ends are not in order, or the value lies beyond them.
    """
    (place,) = system.places([name])
    parameters = system.structure.parameters
    index = parameters.free[place]
    declared, default = parameters.declared[index], float(theta[place])
    key = parameters.names[index]
    low, high = _natural(declared, default) if ends is None else _check_ends(key, declared, ends)
    if not low < high:
        raise OptionError(f"The slider of {key} goes from {low:g} to {high:g}.")
    if not low <= default <= high:
        raise OptionError(
            f"The slider of {key} goes from {low:g} to {high:g}; the value of the model, "
            f"{amount(default, declared.unit)}, lies beyond. Change the ends."
        )
    is_ratio = low > 0 and high / low >= _WIDE
    return Slider(key, declared.unit, declared.text, default, low, high, is_ratio)


def _check_ends(key: str, declared: Param, ends: Ends) -> tuple[float, float]:
    if isinstance(ends, str) or len(ends) != 2:
        raise OptionError(f"sliders[{key}] = {shown(ends)}: give both ends, (low, high).")
    found = []
    for end in ends:
        value = plain(end, declared.unit, f"end of the slider of {key}", ParameterError)
        if why := declared.fault(value):
            raise ParameterError(
                f"end of the slider of {key} = {amount(value, declared.unit)} "
                f"({declared.text}) {why}."
            )
        found.append(value)
    return found[0], found[1]


def _natural(declared: Param, default: float) -> tuple[float, float]:
    least, most = declared.least, declared.most
    if np.isfinite(most) and np.isfinite(least) and most - least <= 1e3 * max(abs(default), 1e-3):
        return least, most
    if default > 0 and least >= 0:
        return max(default / 10, least), min(default * 10, most)
    low, high = sorted((0.0, 2 * default)) if default else (-1.0, 1.0)
    return max(low, least), min(high, most)


def sliders(system: System, theta: np.ndarray, wanted: Wanted) -> tuple[Slider, ...]:
    """Sliders of named parameters, in their order; a mapping gives their ends.

    Raises
    ------
    OptionError
        If none or one twice is named.
    UnknownNameError, ParameterError, UnitError, OptionError
        See `slider`.
    """
    if isinstance(wanted, Mapping):
        found = tuple(slider(system, theta, name, ends) for name, ends in wanted.items())
    else:
        found = tuple(slider(system, theta, name) for name in wanted)
    names = [each.name for each in found]
    if not names:
        raise OptionError(f"{system.name}: explore: name at least one parameter to move.")
    for name in names:
        if names.count(name) > 1:
            raise OptionError(f"{system.name}: the slider of {name} is named twice.")
    return found
