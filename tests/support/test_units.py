"""Values with units against factors of the standards, and equations that mix kinds."""

import numpy as np
import pint
import pytest
from checks import refused
from rows import in_a_row, in_rows

import lumped as lp
from lumped.components import ConverterDrive, Inertia, SpeedSensor, Spring
from lumped.errors import UnitError
from lumped.models import MACHINES
from lumped.support.units import convert_value

DEGREE = np.pi / 180


@pytest.mark.parametrize(
    ("value", "unit", "expected"),
    [
        ("3.5 kN.m/deg", "N.m/rad", 3500 / DEGREE),
        ("1500 rpm", "rad/s", 1500 * 2 * np.pi / 60),
        ("2 turn", "rad", 4 * np.pi),
        ("0.4 mm", "m", 4e-4),
        ("12 t.m2", "kg.m2", 12e3),
        ("365 kgf.m", "N.m", 365 * 9.80665),
        ("4 %", "1", 0.04),
        ("0.7", "1", 0.7),
        ("20 degC", "K", 293.15),
        ("3 bar", "Pa", 3e5),
        ("2 mH", "H", 2e-3),
        ("90 1/min", "1/s", 1.5),
        ("2 kg.cm2", "kg.m2", 2e-4),
        ("-1e-3 N.m.s/deg", "N.m.s/rad", -1e-3 / DEGREE),
        ("1 mrad", "rad", 1e-3),
        ("2.5 urad", "rad", 2.5e-6),
        ("30 arcmin", "rad", 0.5 * DEGREE),
        ("3 kN.m/mrad", "N.m/rad", 3e6),
        ("2 N.m.s2/deg2", "N.m.s2/rad2", 2 / DEGREE**2),
        ("4 W/delta_degC", "W/K", 4.0),
        (pint.UnitRegistry().Quantity(60, "rpm"), "rad/s", 2 * np.pi),
        (pint.UnitRegistry().Quantity(4, "cm**2.0"), "m2", 4e-4),
    ],
)
def test_values_are_converted(value, unit, expected):
    assert convert_value(value, unit, "x =") == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("written", ["1 %", "0.5 dimensionless", "2 bit", "2 sr", "50 1/m", "3"])
def test_a_number_is_no_angle(written):
    refused(UnitError, lambda: convert_value(written, "rad", "x ="), "rad")


@pytest.mark.parametrize("written", ["45 deg", "5 turn", "1 mrad", "2 rad", "2 bit", "3 Hz"])
def test_an_angle_is_no_number(written):
    refused(UnitError, lambda: convert_value(written, "1", "x ="), "of the kind 1")


def test_a_difference_of_temperatures_is_no_temperature():
    with pytest.raises(UnitError, match="difference of temperatures"):
        convert_value("20 delta_degC", "K", "x =")


@pytest.mark.parametrize(
    ("written", "unit", "remedy"),
    [
        *((text, "1", "a plain number") for text in ("20 dB", "1 Np", "3 octave", "0 dB")),
        ("0 dBm", "W", "in W"),
    ],
)
def test_logarithms_are_refused(written, unit, remedy):
    with pytest.raises(UnitError) as caught:
        convert_value(written, unit, "gear.ratio =")
    text = str(caught.value)
    assert text.startswith(f"gear.ratio = '{written}': this unit is a logarithm")
    assert text.endswith(
        f"Give the value itself, {remedy}." if unit == "1" else f"itself {remedy}."
    )


@pytest.mark.parametrize("written", ["-300 degC", "-273.16 degC", "-460 degF", "-300 celsius"])
def test_temperatures_below_absolute_zero_are_refused(written):
    with pytest.raises(UnitError, match=r"part.T = .*: no temperature is below absolute zero"):
        convert_value(written, "K", "part.T =")


@pytest.mark.parametrize("written", ["-273.15 degC", "-459.67 degF", "0 K"])
def test_absolute_zero_is_a_temperature(written):
    assert abs(convert_value(written, "K", "part.T =")) < 1e-9


@pytest.mark.parametrize("written", ["3 m)", "3 N.m/", "3 9**9**9", "3 import os", "3 m+s", "3 ["])
def test_units_that_cannot_be_read_are_refused(written):
    with pytest.raises(UnitError, match="a number, a space and a unit, is needed"):
        convert_value(written, "N.m", "x =")


def test_a_unit_that_is_none_is_told_of_the_declaration():
    with pytest.raises(UnitError, match=r"declares a quantity in 'Nmm/foo', which is no unit"):
        convert_value("3 kN.m", "Nmm/foo", "x =")


def test_units_enter_at_every_boundary():
    model = in_a_row(
        a=Inertia(J="0.02 t.m2"),
        shaft=Spring(c=pint.UnitRegistry().Quantity(1.0, "kN*m/degree")),
        b=Inertia(J=5.0),
    ).with_({"b.J": "7 kg.m2"})
    system = lp.assemble(model)
    assert system.parameters["a.J"] == 20.0
    assert system.parameters["shaft.c"] == pytest.approx(1e3 / DEGREE)
    assert system.parameters["b.J"] == 7.0
    point = lp.start_point(system, parameters={"b.J": "9000 kg.cm2"}, start={"a.w": "30 rpm"})
    assert point.parameters["b.J"] == pytest.approx(0.9)
    assert point["a.w"] == pytest.approx(np.pi)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda s: Inertia(J="3 foo"), "'foo' is not defined"),
        (lambda s: lp.start_point(s, parameters={"a.J": "3 m"}), r"a\.J = '3 m': .*kg\.m2"),
    ],
)
def test_wrong_dimensions_are_refused_with_the_path(make, text, two_mass):
    with pytest.raises(UnitError, match=text):
        make(lp.assemble(two_mass))


def test_without_pint_the_remedy_is_named(without_pint):
    refused(UnitError, lambda: Inertia(J="3 lb.ft2"), "pip install lumped[units]")
    assert Inertia(J="3 t.m2")._values["J"] == 3000.0
    assert convert_value("1500 rpm", "rad/s", "x =") == pytest.approx(50 * np.pi, rel=1e-15)
    without_pint.undo()
    assert Inertia(J="3 lb.ft2")._values["J"] == pytest.approx(3 * 0.45359237 * 0.3048**2)


class Wrong(lp.Component):
    """An inertia whose author forgot one derivative and compares speed with angle."""

    flange = lp.Flange()
    J: lp.Param = lp.param("kg.m2", "inertia", 1.0, above=0)
    w: lp.Var = lp.var("rad/s", "speed")
    tau: lp.Var = lp.var("N.m", "torque")

    def equations(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.J * self.w == self.flange.tau
        yield lp.hold(self.tau, self.w, upper=self.J, forward=self.w, lower=0.0, backward=0.0)
        yield lp.when(self.w >= self.J, {self.w: lp.ops.sin(self.flange.tau)})


def test_equations_of_mixed_kinds_are_all_listed():
    with pytest.raises(UnitError) as caught:
        lp.check_units(Wrong())
    text = str(caught.value)
    print(text)
    assert "J * w == flange.tau: kg m^2 s^-1 against kg m^2 s^-2" in text
    assert text.count("Wrong (Wrong)") == 5
    assert "der(flange.phi)" not in text


class Law(lp.Component):
    """A damper whose law a test gives."""

    flange = lp.Flange()
    d: lp.Param = lp.param("N.m.s/rad", "damping", 1.0)
    m: lp.Param = lp.param("kg", "mass", 1.0)
    w: lp.Var = lp.var("rad/s", "speed")
    law: object = None

    def equations(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == self.law(self)


@pytest.mark.parametrize(
    ("law", "fits"),
    [
        (lambda c: c.d * (c.w + 1.0), True),
        (lambda c: c.d * lp.ops.maximum(c.w, 1.0), True),
        (lambda c: c.d * lp.ops.where(c.w > 1.0, c.w, 2.0), True),
        (lambda c: c.d * c.w * lp.ops.where(c.w > 1.0, 1.0, 2.0), True),
        (lambda c: c.d * c.w * lp.ops.atan2(c.w, 1.0), True),
        (lambda c: 5.0, True),
        (lambda c: c.w * lp.ops.where(c.w > 1.0, 1.0, 2.0), False),
        (lambda c: 2.0 * c.w, False),
        (lambda c: c.d * c.w * lp.ops.sin(c.w), False),
        (lambda c: c.d * lp.ops.maximum(c.w, c.m + 1.0), False),
        (lambda c: c.d * lp.ops.where(c.m > c.w, c.w, 2.0), False),
    ],
)
def test_numbers_beside_quantities_are_in_their_units(law, fits):
    if fits:
        assert lp.check_units(Law(law=law)) == 2
        return
    with pytest.raises(UnitError, match=r"flange\.tau == .* against "):
        lp.check_units(Law(law=law))


def test_signals_of_different_kinds_are_found():
    model = in_rows(
        "drive speed",
        "speed.w drive.wanted",
        speed=SpeedSensor(),
        drive=ConverterDrive(tau_max=1.0, P_max=1.0, T=1.0, J=1.0),
    )
    with pytest.raises(UnitError, match=r"speed\.w joined to drive\.wanted: s\^-1 against"):
        lp.check_units(model)


@pytest.mark.parametrize("name", MACHINES)
def test_the_machines_mix_no_kinds(name):
    """All components defined for a machine, wherever its modules name one."""
    import importlib
    import inspect
    import pkgutil

    import lumped.models

    found = 0
    for info in pkgutil.walk_packages(lumped.models.__path__, "lumped.models."):
        if not info.name.startswith(f"lumped.models.{name}"):
            continue
        module = importlib.import_module(info.name)
        for _, cls in inspect.getmembers(module, inspect.isclass):
            if issubclass(cls, lp.Component) and cls.__module__ == module.__name__:
                found += lp.check_units(cls())
    assert found > 0
