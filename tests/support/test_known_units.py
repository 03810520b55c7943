"""Units that are known without pint, against pint and against powers counted by hand."""

import pint
import pytest

from lumped.support.known_units import _UNITS, measure

REGISTRY = pint.UnitRegistry()
SPELT = {"kWh": "kW*h", "%": "percent"}


@pytest.mark.parametrize("unit", _UNITS)
def test_a_known_unit_is_the_one_of_pint(unit):
    received = measure(unit)
    base = "*".join(f"{name}**{power}" for name, power in received.powers.items())
    spelt = SPELT.get(unit, unit.replace("Ohm", "ohm"))
    one, three = (REGISTRY.Quantity(size, spelt).to(base or "1") for size in (1.0, 3.0))
    assert received.factor + received.zero == pytest.approx(one.magnitude, rel=1e-14)
    assert 3 * received.factor + received.zero == pytest.approx(three.magnitude, rel=1e-14)
    radians = REGISTRY.Quantity(1.0, spelt).to_root_units().units
    assert received.powers.get("rad", 0) == radians._units.get("radian", 0)


@pytest.mark.parametrize(
    ("unit", "powers"),
    [
        ("N.m.s/rad2", {"kg": 1, "m": 2, "s": -1, "rad": -2}),
        ("rad/(s.N.m)", {"rad": 1, "s": 1, "kg": -1, "m": -2}),
        ("1/s2", {"s": -2}),
        ("V.s", {"kg": 1, "m": 2, "s": -2, "A": -1}),
        ("m.s/m", {"s": 1}),
        ("1", {}),
    ],
)
def test_units_are_powers_of_base_units(unit, powers):
    assert measure(unit) == (powers, 1.0, 0.0)


@pytest.mark.parametrize(
    ("unit", "factor"),
    [("kN.m/deg", 180e3 / 3.141592653589793), ("kg.cm2", 1e-4), ("1/min", 1 / 60)],
)
def test_factors_multiply(unit, factor):
    assert measure(unit).factor == pytest.approx(factor, rel=1e-15)


@pytest.mark.parametrize(
    "unit", ["parsec", "N.m/s.rad", "N/m/s", "/s", "N/", "N..m", "degC/m", "N**2", "N m", "kkN"]
)
def test_what_is_ambiguous_or_unknown_is_left_to_pint(unit):
    assert measure(unit) is None
