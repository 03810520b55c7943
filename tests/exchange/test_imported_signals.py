"""Signals of units of FMI: their types, units, instants and order, by units of a few lines of C."""

import numpy as np
import pytest
from c_units import FEEDTHROUGH, SIGNALS, STAIR, UNITS, c_unit
from imported_drives import T_S
from rows import assemble_rows

import lumped as lp
from lumped import errors
from lumped.components import SampleHold, from_fmu
from lumped.ops import sin


def test_time_events_of_a_unit_are_met(tmp_path):
    """The unit fails where a step goes beyond its next event."""
    path = c_unit(
        tmp_path,
        "stair",
        '<Int32 name="counter" valueReference="0" causality="output"/>',
        STAIR,
        flags='hasEventMode="true" canHandleVariableCommunicationStepSize="true"',
    )
    for T_s in (0.3, 2.5):
        unit = from_fmu(path, T_s=T_s)
        times = np.arange(1, 10 / T_s) * T_s
        run = lp.simulate(lp.assemble(lp.compose(stair=unit)), until=10.0, grid=times + 0.1 * T_s)
        assert np.array_equal(run["stair.counter"], 1 + np.floor(times + 1e-9))


@pytest.fixture(scope="module")
def feedthrough(tmp_path_factory):
    folder = tmp_path_factory.mktemp("feedthrough")
    return c_unit(folder, "feedthrough", SIGNALS, FEEDTHROUGH, units=UNITS, arrays=(20, 30))


def test_signals_of_all_types_arrive_in_si_units(feedthrough):
    given = {"speed": 50.0, "temperature": 300.0, "moment": 4e3, "plain": 7.0}
    given |= {f"three_{i}": float(i) for i in (1, 2, 3)}
    unit = from_fmu(feedthrough, axis_k_1=1.0, mode=4, label="given", on=1.0, gear=3.0, **given)
    system = lp.assemble(lp.compose(unit=unit))
    for name, unit_of_it in (("speed", "rad/s"), ("temperature", "K"), ("moment", "N.m")):
        assert system.quantity(f"unit.{name}").unit == unit_of_it
    run = lp.simulate(lp.assemble(lp.compose(unit=unit)), until=0.1)
    expected = {"is_on": 1, "gear_out": 3, "mode_out": 4, "is_given": 1}
    expected |= {f"{n}_out": given[n] for n in ("speed", "temperature", "moment", "plain")}
    expected |= {f"three_out_{i}": float(2 * i - 1) for i in (1, 2, 3)}
    for name, value in expected.items():
        assert abs(run[f"unit.{name}"][-1] - value) <= 1e-12 * abs(value), name
    with pytest.raises(
        errors.DeclarationError, match=r"^unit .feedthrough.: mode = 1.5: .* of type Int32"
    ):
        lp.assemble(lp.compose(unit=unit.with_({"mode": 1.5})))
    doubled = lp.simulate(run.system, until=0.1, parameters={"unit.axis_k_1": 2.0})
    assert abs(doubled["unit.speed_out"][-1] - 100.0) < 1e-12


def test_one_file_may_be_read_with_different_units(feedthrough):
    """The equations of both components are the same, but not what their values mean."""
    given = dict.fromkeys(("speed", "temperature", "moment", "on", "gear", *THREE), 0.0)
    given |= {"plain": 7000.0, "axis_k_1": 1.0}
    units = {name: from_fmu(feedthrough, units={"plain": name}, **given) for name in ("N", "kN")}
    run = lp.simulate(lp.assemble(lp.compose(**units)), until=0.1)
    assert run["N.plain_out"][-1] == 7000.0
    assert abs(run["kN.plain_out"][-1] - 7.0) < 1e-12


THREE = ("three_1", "three_2", "three_3")


def chain_of(path, names):
    """Units that pass a signal on, declared in an order of their own."""
    idle = dict.fromkeys(("speed", "temperature", "moment", "on", "gear", *THREE), 0.0)
    idle |= {"axis_k_1": 1.0, "T_s": T_S}
    parts = {
        "first": from_fmu(path, plain=sin(30 * lp.time), **idle),
        "second": from_fmu(path, **idle),
        "hold": SampleHold(T_s=T_S),
    }
    declared = {name: parts[name] for name in names}
    return assemble_rows("first.plain_out hold.u", "hold.y second.plain", **declared)


@pytest.mark.parametrize("names", [("first", "hold", "second"), ("second", "hold", "first")])
def test_a_value_passes_all_units_within_one_instant(feedthrough, names):
    times = np.arange(0.5, 30) * T_S
    run = lp.simulate(chain_of(feedthrough, names), until=0.3, grid=times)
    exact = np.sin(30 * np.floor(times / T_S) * T_S)
    assert np.abs(run["second.plain_out"] - exact).max() < 1e-12
