"""Variables of units of FMI as quantities in SI units."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Any, NamedTuple, Self

from lumped.support.known_units import measure

_BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
_USUAL = (
    *("1", "rad", "rad/s", "rad/s2", "N.m", "N", "m", "m/s", "m/s2", "s", "1/s", "kg", "kg.m2"),
    *("A", "V", "W", "K", "Pa", "Ohm", "H", "F", "T", "Wb", "N/m", "N.s/m", "N.m/rad"),
    *("N.m.s/rad", "N.m/A", "V.s/rad", "W/K", "m2", "m3"),
)
"""Units as components write them; the first of a dimension is taken."""


class _Quantity(NamedTuple):
    """An SI unit; one in the file is `factor` of it, and its zero is at `zero`."""

    unit: str
    factor: float
    zero: float


def of_unit(name: str | None, base: Any) -> _Quantity | None:
    """The SI unit of a unit in a file; None if nobody knows it.

    Parameters
    ----------
    name : str, optional
        Its name; without one, a number.
    base : BaseUnit of FMPy, optional
        Its powers of SI base units, factor and offset.
    """
    if not name:
        return _Quantity("1", 1.0, 0.0)
    known = measure(name)
    if base is None:
        if known is None:
            return None
        return _Quantity(_write_unit(known.powers), known.factor, known.zero)
    powers = {unit: int(getattr(base, unit)) for unit in _BASE if int(getattr(base, unit))}
    factor, zero = float(base.factor), float(base.offset)
    if known is not None and known.is_si and known.powers == powers and factor == 1 and not zero:
        return _Quantity(name, 1.0, 0.0)
    return _Quantity(_write_unit(powers), factor, zero)


def _write_unit(powers: dict[str, int]) -> str:
    """The SI unit with these powers of base units."""
    for usual in _USUAL:
        known = measure(usual)
        if known is not None and known.powers == powers:
            return usual
    return ".".join(f"{unit}{power}" if power != 1 else unit for unit, power in powers.items())


@dataclass(frozen=True)
class Signal:
    """An input, output or parameter of a unit.

    Attributes
    ----------
    name, text : str
        In the file.
    variable : (int, str, int)
        Value reference, type and number of values.
    unit : str
        SI unit.
    factor, zero : float
        One of what the unit computes in is so much in the SI unit, and zero is there.
    start : tuple of float
        Start values, SI; empty where the file has none.
    least, largest : float or None
        Its range, SI.
    """

    name: str
    text: str
    variable: tuple[int, str, int]
    unit: str
    factor: float
    zero: float
    start: tuple[float, ...]
    least: float | None
    largest: float | None

    @property
    def size(self) -> int:
        """Number of values."""
        return self.variable[2]

    @classmethod
    def of(cls, variable: Any, quantity: _Quantity) -> Self:
        """A variable that FMPy read."""
        unit, factor, zero = quantity
        zero = 0.0 if variable.relativeQuantity else zero

        def in_si(text: str | None) -> float | None:
            if text is None:
                return None
            word = str(text).lower()
            value = float(word == "true") if word in ("true", "false") else float(text)
            return value * factor + zero

        size = prod(int(_extent(each)) for each in variable.dimensions)
        texts = [] if variable.start is None else str(variable.start).split()
        start = tuple(value for value in map(in_si, texts) if value is not None)
        return cls(
            variable.name,
            variable.description or "",
            (variable.valueReference, variable.type, size),
            unit,
            factor,
            zero,
            start * size if len(start) == 1 else start,
            in_si(variable.min),
            in_si(variable.max),
        )


def _extent(dimension: Any) -> str:
    """Extent of an array; that which a structural parameter has at first."""
    found = dimension.start if dimension.variable is None else dimension.variable.start
    return str(found)
