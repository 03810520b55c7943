"""Values with units: converted once, where they enter a model."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from lumped.errors import OptionError, UnitError

__all__ = ["Dimension", "converted", "dimension", "has_unit", "in_seconds", "written"]

Dimension = dict[str, float]
"""Powers of mass, length, time, current and temperature."""


def has_unit(value: object) -> bool:
    """Whether a value is a text such as ``"3.5 kN.m/deg"`` or a pint quantity."""
    if isinstance(value, float | int):
        return False
    return isinstance(value, str) or (hasattr(value, "magnitude") and hasattr(value, "units"))


def converted(value: Any, unit: str, what: str) -> float:
    """A value with a unit as a number in the unit of a quantity.

    Angles are a dimension of their own here: a stiffness in N.m/rad is not a torque, and a speed
    in Hz or 1/min is not one in rad/s (say ``rpm``).

    Parameters
    ----------
    value : str or pint.Quantity
        Such as ``"3.5 kN.m/deg"``; a dot multiplies, as in ``N.m``, digits after a unit are powers.
    unit : str
        Unit of the quantity, SI.
    what : str
        What the value is for, to begin an error with.

    Raises
    ------
    UnitError
        If the text cannot be read, the dimension is another, or pint is not installed.
    """
    if isinstance(value, str):
        number, _, given_unit = value.strip().partition(" ")
    else:
        number, given_unit = value.magnitude, str(value.units)
    wanted_text = "a number" if unit == "1" else f"a number in {unit}"
    needed = f"{what} {value!r}: {wanted_text}, or a number, a space and a unit, is needed"
    try:
        size = float(number)
    except (TypeError, ValueError):
        raise UnitError(f"{needed}, such as '3.5 {'%' if unit == '1' else unit}'.") from None
    if given_unit == unit:
        return size
    registry = _registry()
    wanted = registry.Unit(_spelt(unit))
    try:
        given = registry.Quantity(size, _spelt(given_unit))
    except (AttributeError, TypeError, ValueError, SyntaxError) as fault:
        raise UnitError(f"{needed} ({fault}).") from None
    if not given.is_compatible_with(wanted):
        hint = ""
        angles = (wanted / registry.radian, wanted * registry.radian)
        if "rad" in unit and any(given.is_compatible_with(other) for other in angles):
            hint = " An angle is missing: rad, deg or turn; a speed may be in rpm."
        raise UnitError(f"{what} {value!r}: the unit must be of the kind {unit}.{hint}")
    return float(given.m_as(wanted))


def in_seconds(value: Any, what: str) -> float:
    """A time, given as a number in s or with a unit.

    Parameters
    ----------
    value : float, str or pint.Quantity
        Such as ``0.5`` or ``"500 ms"``.
    what : str
        What the time is called, to begin an error with.

    Raises
    ------
    UnitError
        If the text cannot be read, or is no time.
    OptionError
        If it is no number.
    """
    if has_unit(value):
        return converted(value, "s", f"{what} =")
    try:
        return float(value)
    except (TypeError, ValueError):
        raise OptionError(
            f"{what} = {value!r}: a time is needed, as a number in s or a text such as '500 ms'."
        ) from None


@cache
def dimension(unit: str) -> Dimension:
    """Dimension of a unit; angles are numbers."""
    found = _registry().Unit(_spelt(unit)).dimensionality
    return {name: float(power) for name, power in found.items() if name != "[angle]"}


def written(found: Dimension) -> str:
    """A dimension as a product of SI base units."""
    base = {
        "[mass]": "kg",
        "[length]": "m",
        "[time]": "s",
        "[current]": "A",
        "[temperature]": "K",
    }
    parts = [f"{base.get(n, n)}^{p:g}" if p != 1 else base.get(n, n) for n, p in found.items()]
    return " ".join(parts) or "number"


@cache
def _registry() -> Any:
    try:
        import pint
    except ImportError:
        raise UnitError(
            "Values with units need pint: pip install lumped[units], or give a number in SI units."
        ) from None
    registry: Any = pint.UnitRegistry()
    registry.define("radian = [angle] = rad")
    registry.define("turn = 2 * pi * radian = _ = revolution = cycle")
    registry.define("revolution_per_minute = revolution / minute = rpm")
    registry.define("degree = pi / 180 * radian = deg")
    return registry


def _spelt(unit: str) -> str:
    """A unit as pint reads it: ``N.m.s/rad2`` becomes ``N*m*s/rad**2``."""
    powers = re.sub(r"([A-Za-z])(-?\d+)", r"\1**\2", unit)
    return powers.replace(".", "*").replace("Ohm", "ohm") or "dimensionless"
