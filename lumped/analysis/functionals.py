"""Numbers that sum up a run: what `lumped.gradient` differentiates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from lumped.errors import OptionError
from lumped.system import Name, System

__all__ = [
    "Final",
    "Functional",
    "Instant",
    "Integral",
    "Peak",
    "final",
    "highest",
    "instant",
    "integral",
    "lowest",
    "mean",
    "peak",
    "rms",
]


@dataclass(frozen=True, eq=False)
class Final:
    """Value of a quantity at the end of a run."""

    name: Name

    def label(self, system: System) -> str:
        """What it is, with full names."""
        return f"final({system.key(self.name)})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return system.quantity(self.name).unit


@dataclass(frozen=True, eq=False)
class Peak:
    """Extreme value of a quantity: largest size, highest or lowest value."""

    name: Name
    kind: Literal["peak", "highest", "lowest"]

    def label(self, system: System) -> str:
        """What it is, with full names."""
        return f"{self.kind}({system.key(self.name)})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return system.quantity(self.name).unit


@dataclass(frozen=True, eq=False)
class Integral:
    """Integral over time of a product of quantities, its mean, or the root of that of its square.

    Attributes
    ----------
    names : tuple of names
        The factors.
    """

    names: tuple[Name, ...]
    kind: Literal["integral", "mean", "rms"]

    def label(self, system: System) -> str:
        """What it is, with full names."""
        return f"{self.kind}({', '.join(system.key(name) for name in self.names)})"

    def unit(self, system: System) -> str:
        """Unit of its value: those of the factors beside each other."""
        units = [system.quantity(name).unit for name in self.names]
        return " ".join([*units, "s"] if self.kind == "integral" else units)

    def outcome(self, integral: float, until: float) -> tuple[float, float, float]:
        """Value, and its first and second derivatives by the integral of what is integrated.

        Raises
        ------
        OptionError
            If a root mean square is zero, where it has a kink.
        """
        if self.kind == "integral":
            return integral, 1.0, 0.0
        if self.kind == "mean":
            return integral / until, 1.0 / until, 0.0
        if not integral > 0:
            raise OptionError(
                f"rms({', '.join(map(str, self.names))}): this is zero throughout the run, where "
                "a root mean square has no derivative. Take the integral instead."
            )
        value = math.sqrt(integral / until)
        return value, 0.5 / (until * value), -0.25 / (until**2 * value**3)


@dataclass(frozen=True, eq=False)
class Instant:
    """Instant of an event, s.

    Attributes
    ----------
    component, after : str
        As in `Event`; an empty `after` means any.
    number : int
        Which of these, from 0; negative numbers count from the last.
    """

    component: str
    after: str
    number: int

    def label(self, system: System) -> str:
        """What it is, with full names."""
        what = f"{self.component}, {self.after}" if self.after else self.component
        return f"instant({what}, {self.number})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return "s"


Functional = Final | Peak | Integral | Instant


def final(name: Name) -> Final:
    """Value of a quantity at the end."""
    return Final(name)


def peak(name: Name) -> Peak:
    """Largest size of a quantity, ``max |y|``."""
    return Peak(name, "peak")


def highest(name: Name) -> Peak:
    """Largest value of a quantity."""
    return Peak(name, "highest")


def lowest(name: Name) -> Peak:
    """Least value of a quantity."""
    return Peak(name, "lowest")


def integral(*names: Name) -> Integral:
    """Integral over time of a quantity, or of a product: work is that of torque and speed."""
    return Integral(_some(names, "integral"), "integral")


def mean(*names: Name) -> Integral:
    """Mean over time of a quantity, or of a product: power is that of torque and speed."""
    return Integral(_some(names, "mean"), "mean")


def rms(*names: Name) -> Integral:
    """Root of the mean over time of the square of a quantity, or of a product."""
    return Integral(_some(names, "rms"), "rms")


def instant(component: str, after: str = "", number: int = 0) -> Instant:
    """Instant at which something happens in a component (see `Trajectory.events`).

    Parameters
    ----------
    component, after : str
        As in `Event`: the component, and its mode after the event in words (any if empty).
    number : int
        Which of these, from 0; negative numbers count from the last.
    """
    return Instant(component, after, number)


def _some(names: tuple[Name, ...], what: str) -> tuple[Name, ...]:
    if not names:
        raise OptionError(f"{what}: name at least one quantity.")
    return names
