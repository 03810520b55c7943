"""Numbers that sum up a run or its modes: what is minimised, bounded or differentiated."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from lumped.arguments import checked
from lumped.connection import label
from lumped.errors import OptionError
from lumped.expression import Ref
from lumped.system import Name, System

__all__ = [
    "Clearance",
    "Damping",
    "Designed",
    "Final",
    "Frequency",
    "Functional",
    "Instant",
    "Integral",
    "Modal",
    "Peak",
    "Swing",
    "clearance",
    "damping",
    "final",
    "frequency",
    "highest",
    "instant",
    "integral",
    "lowest",
    "mean",
    "peak",
    "rms",
    "swing",
]


@dataclass(frozen=True)
class Final:
    """Value of a quantity at the end of a run."""

    name: str

    def __str__(self) -> str:
        return f"final({self.name})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return system.quantity(self.name).unit


@dataclass(frozen=True)
class Peak:
    """Extreme value of a quantity: largest size, highest or lowest value."""

    name: str
    kind: Literal["peak", "highest", "lowest"]

    def __str__(self) -> str:
        return f"{self.kind}({self.name})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return system.quantity(self.name).unit


@dataclass(frozen=True)
class Integral:
    """Integral over time of a product of quantities, its mean, or the root of that of its square.

    Attributes
    ----------
    names : tuple of names
        The factors.
    """

    names: tuple[str, ...]
    kind: Literal["integral", "mean", "rms"]

    def __str__(self) -> str:
        return f"{self.kind}({', '.join(self.names)})"

    @property
    def name(self) -> str:
        """The only factor.

        Raises
        ------
        OptionError
            If there are several.
        """
        if len(self.names) > 1:
            raise OptionError(f"{self}: a single quantity is needed here, not a product.")
        return self.names[0]

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
                f"{self}: this is zero throughout the run, where "
                "a root mean square has no derivative. Take the integral instead."
            )
        value = math.sqrt(integral / until)
        return value, 0.5 / (until * value), -0.25 / (until**2 * value**3)


@dataclass(frozen=True)
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

    def __str__(self) -> str:
        what = f"{self.component}, {self.after}" if self.after else self.component
        return f"instant({what}, {self.number})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return "s"


@dataclass(frozen=True)
class Swing:
    """From trough to crest of a quantity, ``max y - min y``."""

    name: str

    def __str__(self) -> str:
        return f"swing({self.name})"


@dataclass(frozen=True)
class Frequency:
    """Natural frequency of a mode, Hz; modes count from 0, the lowest first."""

    mode: int

    def __str__(self) -> str:
        return f"frequency({self.mode})"


@dataclass(frozen=True)
class Damping:
    """Damping ratio of a mode; modes count from 0, the lowest first."""

    mode: int

    def __str__(self) -> str:
        return f"damping({self.mode})"


@dataclass(frozen=True)
class Clearance:
    """Least relative distance ``|f / excitation - 1|`` of all modes from excitations, Hz."""

    excitations: tuple[float, ...]

    def __str__(self) -> str:
        return f"clearance({', '.join(f'{f:g}' for f in self.excitations)})"


Functional = Final | Peak | Integral | Instant
Designed = Final | Peak | Integral | Swing
Modal = Frequency | Damping | Clearance


@checked
def final(name: Name) -> Final:
    """Value of a quantity at the end."""
    return Final(_plain(name))


@checked
def peak(name: Name) -> Peak:
    """Largest size of a quantity, ``max |y|``."""
    return Peak(_plain(name), "peak")


@checked
def highest(name: Name) -> Peak:
    """Largest value of a quantity."""
    return Peak(_plain(name), "highest")


@checked
def lowest(name: Name) -> Peak:
    """Least value of a quantity."""
    return Peak(_plain(name), "lowest")


@checked
def swing(name: Name) -> Swing:
    """From trough to crest of a quantity."""
    return Swing(_plain(name))


@checked
def integral(*names: Name) -> Integral:
    """Integral over time of a quantity, or of a product: work is that of torque and speed."""
    return Integral(_some(names, "integral"), "integral")


@checked
def mean(*names: Name) -> Integral:
    """Mean over time of a quantity, or of a product: power is that of torque and speed."""
    return Integral(_some(names, "mean"), "mean")


@checked
def rms(*names: Name) -> Integral:
    """Root of the mean over time of the square of a quantity, or of a product."""
    return Integral(_some(names, "rms"), "rms")


@checked
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


@checked
def frequency(mode: int) -> Frequency:
    """Natural frequency of a mode, Hz; modes count from 0, the lowest first."""
    return Frequency(mode)


@checked
def damping(mode: int) -> Damping:
    """Damping ratio of a mode; modes count from 0, the lowest first."""
    return Damping(mode)


@checked
def clearance(excitations: Iterable[float]) -> Clearance:
    """Least relative distance ``|f / excitation - 1|`` of all modes from excitations.

    Each frequency stays on the side of each excitation on which a search begins.

    Parameters
    ----------
    excitations : iterable of float
        Frequencies to avoid, Hz.
    """
    return Clearance(tuple(float(f) for f in excitations))


def _plain(name: Name) -> str:
    if isinstance(name, str):
        return name
    if isinstance(name, Ref):
        return label(name)
    raise OptionError(f"'{name!r}' is neither a name nor a reference to a quantity.")


def _some(names: tuple[Name, ...], what: str) -> tuple[str, ...]:
    if not names:
        raise OptionError(f"{what}: name at least one quantity.")
    return tuple(map(_plain, names))
