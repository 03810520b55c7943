"""Units to show, against factors of the standards, and which choice counts."""

from math import pi

import numpy as np
import pytest

import lumped as lp
from lumped.errors import OptionError, UnitError, UnknownNameError
from lumped.support.display_units import choose_units, display

RPM = 60 / (2 * pi)


@pytest.mark.parametrize(
    ("unit", "shown", "factor"),
    [
        ("rad/s", "rpm", RPM),
        ("rad/s", "1/min", RPM),
        ("Hz", "1/min", 60.0),
        ("1/s", "Hz", 1.0),
        ("rad", "deg", 180 / pi),
        ("N.m", "kN.m", 1e-3),
        ("N.m/rad", "kN.m/rad", 1e-3),
        ("N.m/rad", "N.m/deg", pi / 180),
        ("Pa", "MPa", 1e-6),
        ("Pa", "GPa", 1e-9),
        ("Pa", "bar", 1e-5),
        ("W", "kW", 1e-3),
        ("m", "mm", 1e3),
        ("s", "ms", 1e3),
        ("N", "kN", 1e-3),
        ("kg.m2", "kg.cm2", 1e4),
    ],
)
def test_units_of_the_trade_need_no_pint(without_pint, unit, shown, factor):
    received = display("part.q", unit, {unit: shown})
    assert received.unit == shown
    assert received.value(3.7) == pytest.approx(3.7 * factor, rel=1e-15)
    assert received.offset == 0.0
    with pytest.raises(UnitError, match=r"part\.q \(N\.m\).*'lbf\.ft': .*lumped\[units\]"):
        display("part.q", "N.m", {"N.m": "lbf.ft"})


def test_other_units_are_those_of_pint():
    received = display("m.tau", "N.m", {"tau": "lbf.ft"})
    assert received.factor == pytest.approx(1 / (0.45359237 * 9.80665 * 0.3048), rel=1e-14)


def test_temperatures_have_an_offset_and_their_differences_none():
    kelvin = np.array([273.15, 293.15, 373.15])
    celsius, fahrenheit = (display("oil.T", "K", {"K": unit}) for unit in ("degC", "degF"))
    np.testing.assert_allclose(celsius.value(kelvin), [0.0, 20.0, 100.0], atol=1e-12)
    np.testing.assert_allclose(fahrenheit.value(kelvin), [32.0, 68.0, 212.0], atol=1e-10)
    assert display("oil.T", "K", {"K": "degC"}, is_change=True) == ("K", 1.0, 0.0)


def test_a_path_goes_before_a_last_name_and_that_before_a_unit():
    units = {"rad/s": "turn/s", "w": "rpm", "motor.w": "deg/s"}
    assert display("motor.w", "rad/s", units).unit == "deg/s"
    assert display("pump.w", "rad/s", units).unit == "rpm"
    assert display("shaft.w_rel", "rad/s", units).unit == "turn/s"
    assert display("shaft.tau", "N.m", units) == ("N.m", 1.0, 0.0)


@pytest.mark.parametrize(
    ("units", "length", "time"),
    [({"s": "ms"}, "m", "ms"), ({"s": "mm"}, "mm", "s"), ({"body.s": "cm", "s": "h"}, "cm", "h")],
)
def test_a_key_that_may_be_a_name_or_a_unit_is_what_its_unit_fits(units, length, time):
    assert display("body.s", "m", units).unit == length
    assert display("time", "s", units).unit == time
    assert choose_units(units, ["body.s", "time"]) == units


def test_what_is_not_chosen_is_shown_as_usual():
    assert display("speed", "rad/s", {"N.m": "kN.m"}, usual="1/min").unit == "1/min"
    assert display("speed", "rad/s", {"rad/s": "rad/s"}, usual="1/min").unit == "rad/s"


def test_arrays_in_si_units_are_not_copied():
    values = np.arange(3.0)
    assert display("m.w", "rad/s", {}).value(values) is values


@pytest.mark.parametrize(
    ("units", "text"),
    [
        ({"rad/s": "Hz"}, r"motor\.w \(rad/s\) .*'Hz': .*An angle is missing.*rpm"),
        ({"w": "kN"}, r"motor\.w \(rad/s\) cannot be shown in 'kN': .*of the kind rad/s"),
        ({"motor.w": "foo"}, r"motor\.w \(rad/s\) .*'foo' is not defined"),
    ],
)
def test_a_unit_that_does_not_fit_is_told_with_the_quantity(units, text):
    with pytest.raises(UnitError, match=text):
        display("motor.w", "rad/s", units)


def test_values_in_decibels_are_no_multiples():
    with pytest.raises(UnitError, match=r"gain .* in 'dB': this unit is a logarithm"):
        display("gain", "1", {"gain": "dB"})


@pytest.mark.parametrize(
    ("units", "error", "text"),
    [
        ({"motr.w": "rpm"}, UnknownNameError, r"'motr\.w' is neither.*Nearest: motor\.w"),
        ({"kN": "N"}, UnknownNameError, r"'kN' is neither an SI unit nor a name"),
        ({"rad/s": "kN"}, UnitError, r"rad/s cannot be shown in 'kN'"),
        ("metric", OptionError, r"units = 'metric'.*'engineering'"),
        ({"w": 3}, OptionError, r"a mapping of names or SI units"),
        (["rpm"], OptionError, r"a mapping of names or SI units"),
    ],
)
def test_wrong_choices_are_refused(units, error, text):
    with pytest.raises(error, match=text):
        choose_units(units, ["motor.w", "shaft.tau"])


@pytest.mark.parametrize(
    ("units", "text"),
    [
        ({"w": "foo"}, r"display_units: w cannot be shown in 'foo'.*not defined"),
        ({"N.m": "W"}, r"display_units: N\.m cannot be shown in 'W'"),
    ],
)
def test_a_wrong_choice_leaves_the_session_as_it_was(units, text):
    with lp.display_units("engineering"):
        with pytest.raises(UnitError, match=text):
            lp.display_units(units)
        assert display("motor.w", "rad/s").unit == "1/min"


def test_what_the_session_chose_counts_where_it_fits():
    with lp.display_units({"T": "degC", "motor.w": "rpm"}):
        assert display("oil.T", "K").unit == "degC"
        assert display("drive.T", "s") == ("s", 1.0, 0.0)
        assert display("motor.w", "m/s") == ("m/s", 1.0, 0.0)
    with pytest.raises(UnitError, match=r"drive\.T \(s\) cannot be shown in 'degC'"):
        display("drive.T", "s", {"T": "degC"})


@pytest.mark.parametrize("label", ["peak(motor.w)", "highest(motor.w, between 0 and 1)"])
def test_numbers_that_sum_up_a_run_answer_to_the_names_of_their_quantity(label):
    for key in (label, "motor.w", "w"):
        assert display(label, "rad/s", {key: "rpm"}).unit == "rpm"
        assert choose_units({key: "rpm"}, [label])
    assert display(label.replace("peak", "instant"), "s", {"motor.w": "rpm"}).unit == "s"


def test_the_session_shows_what_was_chosen_last_and_a_context_ends():
    try:
        lp.display_units({"rad/s": "rpm"})
        assert display("motor.w", "rad/s").value(pi) == pytest.approx(30.0)
        with lp.display_units("engineering"):
            assert display("motor.w", "rad/s").unit == "1/min"
            with lp.display_units(None):
                assert display("motor.w", "rad/s").unit == "rad/s"
            assert display("shaft.tau", "N.m").unit == "kN.m"
        assert display("shaft.tau", "N.m").unit == "N.m"
        assert display("motor.w", "rad/s").unit == "rpm"
    finally:
        lp.display_units(None)
    assert display("motor.w", "rad/s").unit == "rad/s"
