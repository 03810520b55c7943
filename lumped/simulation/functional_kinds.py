"""Kinds of numbers that sum up a run or its modes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import casadi as ca

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.timeloop.cycle_count import DamageLaw

__all__ = [
    "At",
    "AtEvent",
    "Between",
    "Clearance",
    "Count",
    "Damage",
    "Damping",
    "Designed",
    "Final",
    "Frequency",
    "Functional",
    "Impact",
    "Instant",
    "Integral",
    "Modal",
    "OrderPeak",
    "Peak",
    "Separation",
    "Swing",
    "Vibrating",
    "factors",
    "product",
    "quantities",
    "unit_of",
    "watching",
]

Between = tuple[float, float]
"""First and last instant of a part of a run, s."""


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
    between: Between | None = None

    def __str__(self) -> str:
        return f"{self.kind}({self.name}{_part(self.between)})"

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
    between: Between | None = None

    def __str__(self) -> str:
        return f"{self.kind}({', '.join(self.names)}{_part(self.between)})"

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

    def outcome(self, integral: float, until: float) -> tuple[float, float]:
        """Value, and its derivative by the integral of what is integrated.

        Parameters
        ----------
        integral : float
            Of the product, or of its square.
        until : float
            End of the run, s.

        Raises
        ------
        OptionError
            If a root mean square is zero, where it has a kink.
        """
        span = until if self.between is None else self.between[1] - self.between[0]
        if self.kind == "integral":
            return integral, 1.0
        if self.kind == "mean":
            return integral / span, 1.0 / span
        if not integral > 0:
            raise OptionError(
                f"{self}: this is zero throughout the run, where "
                "a root mean square has no derivative. Take the integral instead."
            )
        value = math.sqrt(integral / span)
        return value, 0.5 / (span * value)


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
        return f"instant({_event(self.component, self.after, self.number)})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return "s"


@dataclass(frozen=True)
class Count:
    """How often an event happens.

    Attributes
    ----------
    component, after : str
        As in `Event`; an empty `after` means any.
    """

    component: str
    after: str

    def __str__(self) -> str:
        return f"count({_event(self.component, self.after, None)})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return "1"


@dataclass(frozen=True)
class At:
    """Sum of a product of quantities over given instants.

    Attributes
    ----------
    times : tuple of float
        Instants, s.
    names : tuple of names
        The factors.
    """

    times: tuple[float, ...]
    names: tuple[str, ...]

    def __str__(self) -> str:
        times = " + ".join(f"{t:.9g}" for t in self.times[:3])
        more = f" + {len(self.times) - 3} more" if len(self.times) > 3 else ""
        return f"at({times}{more}, {', '.join(self.names)})"

    def unit(self, system: System) -> str:
        """Unit of its value: those of the factors beside each other."""
        return " ".join(system.quantity(name).unit for name in self.names)


@dataclass(frozen=True)
class AtEvent:
    """A quantity, or a product, just before or after an event.

    Attributes
    ----------
    names : tuple of names
        The factors.
    component, after : str
        As in `Event`; an empty `after` means any.
    number : int or None
        Which of these, from 0; negative numbers count from the last; None for the sum over all.
    side : str
        Side of the event.
    """

    names: tuple[str, ...]
    component: str
    after: str
    number: int | None
    side: Literal["before", "after"]

    def __str__(self) -> str:
        what = _event(self.component, self.after, self.number)
        return f"at_event({', '.join(self.names)}, {what}, {self.side})"

    def unit(self, system: System) -> str:
        """Unit of its value: those of the factors beside each other."""
        return " ".join(system.quantity(name).unit for name in self.names)


@dataclass(frozen=True)
class Impact:
    """What an impact takes: energy, J, or impulse, N.s or N.m.s.

    Attributes
    ----------
    component : str
        As in `Event`.
    number : int or None
        Which of its impacts, from 0; negative numbers count from the last; None for their sum.
    """

    component: str
    number: int | None
    kind: Literal["loss", "impulse"]

    def __str__(self) -> str:
        return f"{self.kind}({_event(self.component, '', self.number)})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        if self.kind == "loss":
            return "J"
        switching = system.switching
        units = dict(zip(switching.names, switching.gap_units, strict=True))
        return "N.m.s" if units.get(self.component) == "rad" else "N.s"


@dataclass(frozen=True)
class Swing:
    """From trough to crest of a quantity, ``max y - min y``."""

    name: str

    def __str__(self) -> str:
        return f"swing({self.name})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return system.quantity(self.name).unit


@dataclass(frozen=True)
class Damage:
    """Share of life that the cycles of a load take (rainflow count, Palmgren and Miner).

    Attributes
    ----------
    name : str
        The load.
    law : DamageLaw
        What a cycle does.
    """

    name: str
    law: DamageLaw

    def __str__(self) -> str:
        scale = "" if self.law.scale == 1 else f" * {self.law.scale:.6g}"
        return f"damage({self.name}{scale}, {self.law})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return "1"


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


@dataclass(frozen=True)
class OrderPeak:
    """Largest vibration of a quantity over the speeds of an order response.

    Attributes
    ----------
    measure : str or float
        Of its synthesis over a cycle, or the order whose amplitude is meant.
    speeds : (float, float), optional
        First and last speed, rad/s.
    """

    name: str
    measure: Literal["maximum", "half range", "sum"] | float
    speeds: tuple[float, float] | None = None

    def __str__(self) -> str:
        what = self.measure if isinstance(self.measure, str) else f"order {self.measure:g}"
        part = "" if self.speeds is None else f", {self.speeds[0]:g} to {self.speeds[1]:g} rad/s"
        return f"order_peak({self.name}, {what}{part})"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return system.quantity(self.name).unit


@dataclass(frozen=True)
class Separation:
    """Least distance of critical speeds from speeds of operation, over the nearest of these.

    Attributes
    ----------
    orders : tuple of float
        Excitations for each turn.
    between : (float, float)
        First and last speed of operation, rad/s.
    """

    orders: tuple[float, ...]
    between: tuple[float, float]

    def __str__(self) -> str:
        orders = ", ".join(f"{order:g}" for order in self.orders)
        return f"separation(orders {orders}, {self.between[0]:g} to {self.between[1]:g} rad/s)"


def quantities(functional: object) -> tuple[str, ...]:
    """Names and formulas of what a functional looks at; none if it is something else."""
    if isinstance(functional, Integral | At | AtEvent):
        return functional.names
    return (functional.name,) if isinstance(functional, Final | Peak | Swing | Damage) else ()


def watching(system: System, of: Iterable[object]) -> System:
    """The system for runs of which functionals are wanted: they stop at the kinks of formulas."""
    return system.watching([name for functional in of for name in quantities(functional)])


def factors(system: System, functional: Integral) -> tuple[str, ...]:
    """Factors of what is integrated."""
    names = tuple(system.key(name) for name in functional.names)
    return names * (2 if functional.kind == "rms" else 1)


def product(system: System, names: tuple[str, ...]) -> ca.SX:
    """Product of quantities, as an expression."""
    return ca.SX(math.prod(ca.vertsplit(system.expressions(names))))


Functional = Final | Peak | Integral | Instant | At | AtEvent | Impact | Damage
Designed = Final | Peak | Integral | Swing
Modal = Frequency | Damping | Clearance
Vibrating = OrderPeak | Separation | Modal


def unit_of(system: System, functional: Designed | Vibrating | Functional) -> str:
    """Unit of a functional's value."""
    if isinstance(functional, Functional | OrderPeak):
        return functional.unit(system)
    if isinstance(functional, Designed):
        return system.quantity(functional.name).unit
    return "Hz" if isinstance(functional, Frequency) else "1"


def _event(component: str, after: str, number: int | None) -> str:
    """An event in words."""
    what = f"{component}, {after}" if after else component
    return f"{what}, {'all' if number is None else number}"


def _part(between: Between | None) -> str:
    return "" if between is None else f", {between[0]:.9g} to {between[1]:.9g} s"
