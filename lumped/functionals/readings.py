"""Readings of runs, modes and order responses: the leaves of functionals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from lumped.compiler.system import System
from lumped.functionals.damage_law import DamageLaw

Side = Literal["highest", "lowest", "peak"]
_SIGNS: dict[str, Literal[-1, 0, 1]] = {"highest": 1, "lowest": -1, "peak": 0}
Between = tuple[float, float]
"""First and last instant of a part of a run, s."""


@dataclass(frozen=True)
class Reading:
    """A number that is read in a result.

    Attributes
    ----------
    of : str
        What has it: "run", "modes" or "order response".
    smooth : bool
        Whether it has derivatives.
    """

    of: ClassVar[str] = "run"
    smooth: ClassVar[bool] = True

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return "1"


@dataclass(frozen=True)
class OfQuantities(Reading):
    """A reading of a product of quantities.

    Attributes
    ----------
    factors : tuple of str
        Names and formulas.
    """

    factors: tuple[str, ...]

    @property
    def text(self) -> str:
        """The factors as printed."""
        return ", ".join(self.factors)

    def unit(self, system: System) -> str:
        """Unit of its value: those of the factors beside each other."""
        return " ".join(system.quantity(name).unit for name in self.factors)


@dataclass(frozen=True)
class Extreme(OfQuantities):
    """Highest or lowest value of a product of quantities, or its peak, ``max |y|``.

    A peak is a reading of its own: enclosing the size costs half of enclosing both other extremes.
    """

    side: Side
    between: Between | None = None

    def __str__(self) -> str:
        return f"{self.side}({self.text}{_part(self.between)})"

    @property
    def sign(self) -> Literal[-1, 0, 1]:
        """1 for the highest value, -1 for the lowest, 0 for a peak."""
        return _SIGNS[self.side]


@dataclass(frozen=True)
class Integral(OfQuantities):
    """Integral over time of a product of quantities."""

    between: Between | None = None

    def __str__(self) -> str:
        return f"integral({self.text}{_part(self.between)})"

    @property
    def is_of_square(self) -> bool:
        """Whether a square is integrated: rounding may not leave it negative."""
        half = len(self.factors) // 2
        return self.factors[:half] == self.factors[half:]

    def unit(self, system: System) -> str:
        """Unit of its value."""
        return f"{super().unit(system)} s"


@dataclass(frozen=True)
class Span(Reading):
    """How long a run, or a part of it, lasts, s."""

    between: Between | None = None

    def __str__(self) -> str:
        return f"span({_part(self.between)[2:]})"

    def unit(self, system: System) -> str:
        """Seconds."""
        return "s"


@dataclass(frozen=True)
class AtEvent:
    """One side of an event.

    Attributes
    ----------
    component, after : str
        As in `Event`; an empty `after` means any.
    number : int or None
        Which of these, from 0; negative numbers count from the last; None for the sum over all.
    side : {"before", "after"}
    """

    component: str
    after: str
    number: int | None
    side: Literal["before", "after"]


@dataclass(frozen=True)
class Value(OfQuantities):
    """Value of a product of quantities at the end, at given instants (summed), or at an event.

    Attributes
    ----------
    at : tuple of float, AtEvent or None
        Instants, s; an event; or the end.
    """

    at: tuple[float, ...] | AtEvent | None = None

    def __str__(self) -> str:
        if self.at is None:
            return f"final({self.text})"
        if isinstance(self.at, AtEvent):
            what = _event(self.at.component, self.at.after, self.at.number)
            return f"at_event({self.text}, {what}, {self.at.side})"
        times = " + ".join(f"{t:.9g}" for t in self.at[:3])
        more = f" + {len(self.at) - 3} more" if len(self.at) > 3 else ""
        return f"at_time({times}{more}, {self.text})"


@dataclass(frozen=True)
class Occurrence(Reading):
    """What an event of a component is: its instant, its impulse or loss; or how many there are.

    Attributes
    ----------
    what : {"instant", "impulse", "loss", "count"}
        Impulse, N.s or N.m.s, and loss, J, are those of an impact.
    component, after : str
        As in `Event`; an empty `after` means any.
    number : int or None
        Which of these, from 0; negative numbers count from the last; None for all.
    """

    what: Literal["instant", "impulse", "loss", "count"]
    component: str
    after: str = ""
    number: int | None = None

    def __str__(self) -> str:
        return f"{self.what}({_event(self.component, self.after, self.number)})"

    @property
    def smooth(self) -> bool:  # type: ignore[override]
        """A number of events jumps."""
        return self.what != "count"

    def unit(self, system: System) -> str:
        """Unit of its value."""
        if self.what == "impulse":
            switching = system.switching
            units = dict(zip(switching.names, switching.gap_units, strict=True))
            return "N.m.s" if units.get(self.component) == "rad" else "N.s"
        return {"instant": "s", "loss": "J", "count": "1"}[self.what]


@dataclass(frozen=True)
class Cycles(OfQuantities):
    """Share of life that the cycles of a load take (rainflow count, Palmgren and Miner)."""

    law: DamageLaw

    def __str__(self) -> str:
        scale = "" if self.law.scale == 1 else f" * {self.law.scale:.6g}"
        return f"damage({self.text}{scale}, {self.law})"

    def unit(self, system: System) -> str:
        """A share."""
        return "1"


@dataclass(frozen=True)
class Frequency(Reading):
    """Natural frequency of a mode, Hz; modes count from 0, the lowest first."""

    of: ClassVar[str] = "modes"
    mode: int

    def __str__(self) -> str:
        return f"frequency({self.mode})"

    def unit(self, system: System) -> str:
        """Hertz."""
        return "Hz"


@dataclass(frozen=True)
class Damping(Reading):
    """Damping ratio of a mode; modes count from 0, the lowest first."""

    of: ClassVar[str] = "modes"
    mode: int

    def __str__(self) -> str:
        return f"damping({self.mode})"


@dataclass(frozen=True)
class Clearance(Reading):
    """Least relative distance ``|f / excitation - 1|`` of all modes from excitations, Hz."""

    of: ClassVar[str] = "modes"
    excitations: tuple[float, ...]

    def __str__(self) -> str:
        return f"clearance({', '.join(f'{f:g}' for f in self.excitations)})"


@dataclass(frozen=True)
class OrderPeak(Reading):
    """Largest vibration of a quantity over the speeds of an order response.

    Attributes
    ----------
    measure : str or float
        Of its synthesis over a cycle, or the order whose amplitude is meant.
    speeds : (float, float), optional
        First and last speed, rad/s.
    """

    of: ClassVar[str] = "order response"
    name: str
    measure: Literal["maximum", "half range", "sum"] | float
    speeds: tuple[float, float] | None = None

    def __str__(self) -> str:
        what = self.measure if isinstance(self.measure, str) else f"order {self.measure:g}"
        part = "" if self.speeds is None else f", {self.speeds[0]:g} to {self.speeds[1]:g} rad/s"
        return f"order_peak({self.name}, {what}{part})"

    def unit(self, system: System) -> str:
        """Unit of the quantity."""
        return system.quantity(self.name).unit


@dataclass(frozen=True)
class Separation(Reading):
    """Least distance of critical speeds from speeds of operation, over the nearest of these.

    Attributes
    ----------
    orders : tuple of float
        Excitations for each turn.
    between : (float, float)
        First and last speed of operation, rad/s.
    """

    of: ClassVar[str] = "order response"
    orders: tuple[float, ...]
    between: tuple[float, float]

    def __str__(self) -> str:
        orders = ", ".join(f"{order:g}" for order in self.orders)
        return f"separation(orders {orders}, {self.between[0]:g} to {self.between[1]:g} rad/s)"


def _event(component: str, after: str, number: int | None) -> str:
    """An event in words."""
    what = f"{component}, {after}" if after else component
    return f"{what}, {'all' if number is None else number}"


def _part(between: Between | None) -> str:
    return "" if between is None else f", {between[0]:.9g} to {between[1]:.9g} s"
