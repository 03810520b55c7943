"""Electrical parts against the closed forms of small circuits."""

import itertools

import numpy as np
import pytest
from checks import assert_close
from rows import assemble_rows

import lumped as lp
from lumped.components import (
    Capacitor,
    CurrentSensor,
    CurrentSource,
    Ground,
    Inductor,
    Inverter,
    Resistor,
    VariableResistor,
    VoltageSensor,
    VoltageSource,
)

T = np.linspace(0.0, 0.5, 101)


def circuit(**parts):
    """Parts in a ring: n of each on p of the next; p of the first is on the ground."""

    def connections(m):
        ring = [getattr(m, name) for name in parts]
        for before, after in itertools.pairwise(ring):
            yield lp.connect(before.n, after.p)
        yield lp.connect(ring[-1].n, ring[0].p, m.ground.pin)

    return lp.compose(**parts, ground=Ground(), connections=connections)


@pytest.mark.parametrize("R", [1.0, 20.0])
def test_a_series_circuit_rings_or_creeps_as_the_textbook_says(R):
    """``L der(der(i)) + R der(i) + i / C = 0`` after a step of the voltage."""
    L, C, V = 0.1, 2e-3, 10.0
    poles = np.roots([L, R, 1 / C])
    expected = V / L * ((np.exp(poles[0] * T) - np.exp(poles[1] * T)) / (poles[0] - poles[1])).real
    model = circuit(
        source=VoltageSource(v=-V),
        resistor=Resistor(R=R),
        coil=Inductor(L=L),
        capacitor=Capacitor(C=C),
    )
    run = lp.simulate(lp.assemble(model), until=0.5, grid=T, rtol=1e-10)
    a, b = poles
    loaded = V * (1 + (b * np.exp(a * T) - a * np.exp(b * T)) / (a - b)).real
    assert_close(run["coil.i"], expected, 1e-8, "current")
    assert_close(run["capacitor.v"], loaded, 1e-8, "voltage")
    energy = L * run["coil.i"] ** 2 / 2 + C * run["capacitor.v"] ** 2 / 2
    assert (np.diff(V * C * run["capacitor.v"] - energy) >= -1e-9).all()  # heat only grows


def test_a_source_of_current_charges_a_capacitor_evenly():
    model = circuit(
        source=CurrentSource(i=-0.4),  # delivers 0.4 A at n
        meter=CurrentSensor(),
        capacitor=Capacitor(C=0.02, v=3.0),
    )
    system = lp.assemble(model, keep=["capacitor.v"])
    run = lp.simulate(system, until=0.5, grid=T, rtol=1e-10)
    assert_close(run["capacitor.v"], 3.0 + 20.0 * T, 1e-12, "voltage")
    assert_close(run["meter.i"], np.full(len(T), 0.4), 1e-14, "current")


def test_a_divider_divides_and_a_voltmeter_takes_nothing():
    """The upper resistor is a starter that is turned down."""
    system = assemble_rows(
        *("source.p upper.p", "upper.n lower.p meter.p", "lower.n meter.n source.n ground.pin"),
        source=VoltageSource(v=24.0),
        upper=VariableResistor(R=10.0 - 20.0 * lp.time),
        lower=Resistor(R=30.0),
        meter=VoltageSensor(),
        ground=Ground(),
    )
    run = lp.simulate(system, until=0.5, grid=T)
    assert_close(run["meter.v"], 24.0 * 30.0 / (40.0 - 20.0 * T), 1e-14, "voltage")
    assert_close(run["source.i"], 24.0 / (40.0 - 20.0 * T), 1e-14, "current")


def chopper(v):
    """A load on an inverter on a battery."""
    return assemble_rows(
        *("battery.p inside.p", "inside.n inverter.dc_p", "inverter.p load.p"),
        "battery.n inverter.dc_n inverter.n load.n ground.pin",
        battery=VoltageSource(v=120.0),
        inside=Resistor(R=0.5),
        inverter=Inverter(T_d=1e-3, T_f=2e-3, v=v, v_f=120.0),
        load=Resistor(R=3.0),
        ground=Ground(),
    )


def test_an_inverter_balances_power_with_its_battery():
    """``(120 - i / 2) i = 60^2 / 3`` in steady state; the smaller current is the stable one."""
    run = lp.simulate(chopper(60.0), until=0.1, grid=[0.1], rtol=1e-9)
    i = 120.0 - np.sqrt(120.0**2 - 2 * 1200.0)
    assert_close(run["inverter.i_dc"][-1], i, 1e-9, "battery current")
    assert_close(run["inverter.v_dc"][-1], 120.0 - i / 2, 1e-9, "direct voltage")


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_inverter_gives_no_more_than_its_direct_voltage(side):
    """With the load on the full voltage the battery sees ``R_i + R``, whatever the sign."""
    run = lp.simulate(chopper(side * 500.0), until=0.2, grid=[0.2], rtol=1e-9)
    assert_close(run["inverter.v_out"][-1], side * 120.0 * 3.0 / 3.5, 1e-9, "voltage")
    assert_close(run["inverter.i_dc"][-1], 120.0 / 3.5, 1e-9, "battery current")
