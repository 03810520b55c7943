"""Battery: closed forms of its discharge, energy, and bad input."""

import numpy as np
import pytest
from checks import refused

import lumped as lp
from lumped.components import Battery, CurrentSource, Ground, Resistor
from lumped.errors import EquationError, ParameterError, SolverError

LINE = ((0.0, 300.0), (1.0, 400.0))
DATA = {"ocv": LINE, "R": 0.1, "R_1": 0.05, "T_1": 20.0, "Q": 3.6e5, "soc": 0.9}


class Loaded(lp.Component):
    """A battery and what takes its current."""

    battery: lp.Component = Battery(**DATA)
    load: lp.Component = CurrentSource(i=-200.0)
    ground: Ground = Ground()

    def connections(self):
        yield lp.connect(self.battery.p, self.load.p)
        yield lp.connect(self.battery.n, self.load.n, self.ground.pin)


@pytest.mark.parametrize("i", [200.0, -150.0])
def test_a_constant_current_has_a_closed_form(i):
    run = lp.simulate(lp.assemble(Loaded().with_({"load.i": -i})), until=150.0, rtol=1e-10)
    soc = 0.9 - i * run.t / 3.6e5
    i_1 = i * (1 - np.exp(-run.t / 20))
    assert run["battery.soc"] == pytest.approx(soc, abs=1e-9)
    assert run["battery.v"] == pytest.approx(300 + 100 * soc - 0.1 * i - 0.05 * i_1, abs=1e-6)


def test_a_resistor_discharges_it_by_an_exponential():
    """``Q soc' = -(a + b soc) / R`` with the open-circuit voltage ``a + b soc``."""
    given = DATA | {"R_1": 0.0, "Q": 1000.0}
    model = Loaded(battery=Battery(**given), load=Resistor(R=2.9))
    run = lp.simulate(lp.assemble(model), until=5.0, rtol=1e-10)
    expected = 390.0 * np.exp(-100.0 * run.t / (1000.0 * 3.0))
    received = 300 + 100 * run["battery.soc"]
    assert received == pytest.approx(expected, abs=1e-7 * 390)


def test_between_its_rows_the_voltage_is_straight():
    battery = Battery(ocv=((0.1, 300.0), (0.4, 300.0), (1.0, 420.0)), R=0.0, Q=1000.0, soc=0.9)
    run = lp.simulate(lp.assemble(Loaded(battery=battery)), until=3.9, rtol=1e-10)
    soc = 0.9 - 0.2 * run.t
    expected = np.interp(soc, [0.1, 0.4, 1.0], [300.0, 300.0, 420.0])
    assert run["battery.v"] == pytest.approx(expected, abs=1e-7)


def test_what_the_charge_loses_is_given_or_heats():
    """Work of the open-circuit voltage, given energy and heat, with the capacitance at rest."""
    run = lp.simulate(lp.assemble(Loaded()), until=600.0, grid=60_001, rtol=1e-10)
    soc, v, i_1 = (run[f"battery.{name}"] for name in ("soc", "v", "i_1"))
    heat = 0.1 * 200.0**2 + 0.05 * i_1**2
    kept = 20.0 * 0.05 * i_1[-1] ** 2 / 2
    received = np.trapezoid(200.0 * v + heat, run.t) + kept
    expected = 3.6e5 * (300 * (soc[0] - soc[-1]) + 50 * (soc[0] ** 2 - soc[-1] ** 2))
    assert received == pytest.approx(expected, rel=1e-8)


def test_an_empty_battery_ends_the_run():
    model = lp.assemble(Loaded(battery=Battery(**(DATA | {"Q": 1000.0}))))
    refused(SolverError, lambda: lp.simulate(model, until=10.0), "state of charge", "battery")


@pytest.mark.parametrize(
    ("changed", "kind", "text"),
    [
        ({"ocv": ((0.0, 300.0),)}, EquationError, "2 rows or more"),
        ({"ocv": ((0.0, 300.0), (0.5, 290.0))}, EquationError, "not fall with the charge"),
        ({"ocv": ((0.0, 0.0), (0.5, 290.0))}, EquationError, "must be positive"),
        ({"ocv": ((0.0, 300.0), (1.5, 310.0))}, EquationError, "from 0 to 1"),
        ({"ocv": ((0.5, 300.0), (0.5, 310.0))}, EquationError, "must increase"),
        ({"Q": 0.0}, ParameterError, "battery.Q = 0 A.s"),
        ({"R": -0.1}, ParameterError, "battery.R = -0.1 Ohm"),
        ({"T_1": 0.0}, ParameterError, "battery.T_1 = 0 s"),
    ],
)
def test_data_that_make_no_sense_are_refused(changed, kind, text):
    refused(kind, lambda: lp.assemble(Loaded(battery=Battery(**(DATA | changed)))), text)


def test_a_start_outside_of_the_rows_is_refused():
    model = lp.assemble(Loaded(battery=Battery(**(DATA | {"soc": 1.2}))))
    refused(SolverError, lambda: lp.simulate(model, until=1.0), "state of charge")
