"""Values with units: converted once, on input to a model."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from typing import Any

import numpy as np

from lumped.errors import LumpedError, OptionError, UnitError, shown
from lumped.support.known_units import measure

_LINEAR = 1e-9
"""Relative difference that is rounding of a conversion."""

Dimension = dict[str, float]
"""Powers of mass, length, time, current and temperature."""


def has_unit(value: object) -> bool:
    """Whether a value is a text such as ``"3.5 kN.m/deg"`` or a pint quantity."""
    if isinstance(value, float | int):
        return False
    return isinstance(value, str) or (hasattr(value, "magnitude") and hasattr(value, "units"))


def plain(
    value: Any, unit: str, what: str, fault: Callable[[str], LumpedError], more: str = ""
) -> float:
    """A number, or a value with a unit, as a number in the unit of a quantity.

    Parameters
    ----------
    value, unit, what
        See `convert_value`.
    fault : callable
        Makes an error from its text, if the value is neither.
    more : str
        Further words of the text, after the unit.

    Raises
    ------
    UnitError
        See `convert_value`.
    """
    if type(value) is float:
        return value
    if has_unit(value):
        return convert_value(value, unit, what)
    if not isinstance(value, bool | np.bool_ | np.complexfloating) and not getattr(
        value, "ndim", 0
    ):
        with suppress(Exception):  # a foreign type may raise anything
            return float(value)
    kind = "" if unit == "1" else f" in {unit}"
    raise fault(f"{what} {shown(value)}: a number{kind}{more} is needed.")


def convert_value(value: Any, unit: str, what: str) -> float:
    """A value with a unit as a number in the unit of a quantity.

    Angles are a dimension of their own here: a stiffness in N.m/rad is not a torque, a ratio or
    slope is not an angle, and a speed in Hz or 1/min is not one in rad/s (say ``rpm``). Units are
    of one kind if they agree in SI units, with the radian as a base unit. Logarithmic units, such
    as dB and Np, are refused.

    Parameters
    ----------
    value : str or pint.Quantity
        Such as ``"3.5 kN.m/deg"``; a dot multiplies, as in ``N.m``, digits after a unit are powers.
    unit : str
        Unit of the quantity, SI.
    what : str
        Name of the value, with which an error begins.

    Raises
    ------
    UnitError
        If the text cannot be read, the dimension is another, or the unit is not among those of
        `lumped.support.known_units` and pint is not installed.
    """
    if isinstance(value, str):
        number, _, given = value.strip().partition(" ")
        given, is_text = given.strip(), True
    else:
        number, given, is_text = value.magnitude, str(value.units), False
    wanted_text = "a number" if unit == "1" else f"a number in {unit}"
    needed = f"{what} {value!r}: {wanted_text}, or a number, a space and a unit, is needed"
    try:
        size = float(number)
    except (TypeError, ValueError):
        raise UnitError(f"{needed}, such as '3.5 {'%' if unit == '1' else unit}'.") from None
    if not given and unit != "1":
        raise UnitError(f"{needed}, such as '{number} {unit}'.")
    spelling = _spell_for_pint(given) if is_text else given
    return _convert_to_si(size, given, spelling, unit, f"{what} {value!r}", needed)


def convert_number(value: float, given: str, unit: str, said: str) -> float:
    """A number of one unit in another; both as in `convert_value`.

    Parameters
    ----------
    value : float
        The number.
    given, unit : str
        Its unit, and the SI unit wanted.
    said : str
        With which an error begins.

    Raises
    ------
    UnitError
        See `convert_value`.
    """
    return _convert_to_si(
        value, given, _spell_for_pint(given), unit, said, f"{said}: a unit is needed"
    )


def _convert_to_si(
    size: float, given: str, spelling: str, unit: str, said: str, needed: str
) -> float:
    """A number in an SI unit; errors begin with `said`, or with what is needed to read the unit."""
    if given == unit:
        return size
    known, si = measure(given), measure(unit)
    if known is not None and si is not None and si.is_si:
        if known.powers == si.powers:
            return _above_zero(known.factor * size + known.zero, known.zero, said)
        free = [{k: n for k, n in m.powers.items() if k != "rad"} for m in (known, si)]
        hint = _angle_hint(unit, "rad" in known.powers) if free[0] == free[1] else ""
        raise UnitError(f"{said}: the unit must be of the kind {unit}.{hint}")
    try:
        registry = _registry()
    except UnitError as fault:
        raise UnitError(f"{said}: {fault}") from None
    wanted = _read_declared(unit)
    try:
        if re.search(r"\d\s*\*\*", spelling):
            raise ValueError("a number has no power")
        quantity = registry.Quantity(size, spelling)
        kind = quantity.to_root_units().units
    except Exception as fault:  # pint raises the errors of Python's parser
        raise UnitError(f"{needed} ({str(fault) or 'it cannot be read'}).") from None
    if kind != wanted.to_root_units().units:
        hint = ""
        if quantity.dimensionality == wanted.dimensionality:  # as if angles were numbers
            hint = _angle_hint(unit, "radian" in str(kind))
        raise UnitError(f"{said}: the unit must be of the kind {unit}.{hint}")
    if unit == "K" and "delta" in str(quantity.units):
        raise UnitError(f"{said}: a difference of temperatures is no temperature; write degC or K.")
    zero, one, two = _course(spelling, str(wanted.units))
    if abs((two - one) - (one - zero)) > _LINEAR * abs(two - zero):
        raise UnitError(
            f"{said}: this unit is a logarithm, which is another factor for amplitudes than for "
            "powers (20 dB: 10 and 100). Give the value itself"
            f"{', a plain number' if unit == '1' else f' in {unit}'}."
        )
    return _above_zero(float(quantity.m_as(wanted.units)), zero, said)


@cache
def _course(spelling: str, wanted: str) -> tuple[float, float, float]:
    """What 0, 1 and 2 of a unit are in another: where its zero is, and whether it is linear."""
    quantity = _registry().Quantity
    zero, one, two = (float(quantity(k, spelling).m_as(wanted)) for k in (0.0, 1.0, 2.0))
    return zero, one, two


def _above_zero(kelvin: float, zero: float, said: str) -> float:
    """A value of which that of a scale with a zero of its own is no impossible temperature."""
    if zero and kelvin < -_LINEAR * zero:
        raise UnitError(f"{said}: no temperature is below absolute zero, -273.15 degC.")
    return kelvin


def _angle_hint(unit: str, given: bool) -> str:
    if not given:
        needed = " An angle is missing: rad, deg or turn; a speed may be in rpm."
        return needed if "rad" in unit else ""
    if unit == "1":
        return " An angle is not a plain number: a slope is a tangent, a ratio has no unit or %."
    return " There is an angle too many or too few."


def read_time(value: Any, what: str) -> float:
    """A time, given as a number in s or with a unit.

    Parameters
    ----------
    value : float, str or pint.Quantity
        Such as ``0.5`` or ``"500 ms"``.
    what : str
        Name of the time, with which an error begins.

    Raises
    ------
    UnitError
        If the text cannot be read, or is no time.
    OptionError
        If it is no number.
    """
    return plain(value, "s", f"{what} =", OptionError, " or a text such as '500 ms'")


@cache
def dimension(unit: str) -> Dimension:
    """Dimension of a unit; angles are numbers."""
    found = _read_declared(unit).dimensionality
    return {name: float(power) for name, power in found.items()}


def format_dimension(found: Dimension) -> str:
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


def _read_declared(unit: str) -> Any:
    """One unit, as a component declares it."""
    try:
        return _registry().Quantity(1.0, _spell_for_pint(unit))
    except UnitError:
        raise
    except Exception as fault:
        raise UnitError(
            f"A component declares a quantity in {unit!r}, which is no unit ({fault}). Write it "
            "such as 'N.m.s/rad', '1/s2', or '1' where there is none."
        ) from None


@cache
def _registry() -> Any:
    try:
        import pint
    except ImportError:
        raise UnitError(
            "this unit needs pint: pip install lumped[units], or use SI units."
        ) from None
    return pint.UnitRegistry()


def _spell_for_pint(unit: str) -> str:
    """A unit as pint reads it: ``N.m.s/rad2`` becomes ``N*m*s/rad**2``."""
    powers = re.sub(r"([A-Za-z])(-?\d+)", r"\1**\2", unit)
    products = re.sub(r"\.(?!\d)", "*", powers)  # a dot before a digit is a decimal point
    return products.replace("Ohm", "ohm") or "dimensionless"


def amount(value: float, unit: str) -> str:
    """A value with its unit in words; ``"1"`` is not said."""
    return f"{value:g}" if unit == "1" else f"{value:g} {unit}"
