"""Data that make no sense are refused, with what would."""

import numpy as np
import pytest
from checks import refused
from rows import in_rows

import lumped as lp
from lumped.components import Cylinder, Inertia, Speed, Torque, Tyre, translation
from lumped.errors import LumpedError
from lumped.life import Bearing, LoadCase, SNCurve, duty_cycle, rainflow


def test_rainflow_refuses_a_table_of_several_columns():
    refused(LumpedError, lambda: rainflow(np.zeros((5, 2))), "shape (5, 2)", "(n,)")


def test_negative_load_of_a_wheel_is_refused():
    def rolling(f_n):
        tyre = Tyre(R=0.3, mu=1.0, f_n=f_n)
        parts = {"turn": Speed(w=90.0), "tyre": tyre, "slide": translation.Speed(v=25.0)}
        return lp.assemble(in_rows("turn.flange tyre.wheel", "tyre.hub slide.flange", **parts))

    refused(LumpedError, lambda: rolling(-1.0), "tyre.f_n", "-1")
    changed = {"tyre.f_n": -1.0}
    refused(LumpedError, lambda: lp.simulate(rolling(1.0), until=1.0, parameters=changed), "f_n")


def test_table_that_ends_long_before_the_cycle_is_refused():
    pot = Cylinder(strokes=2, pressure=((0, 1e5), (3, 2e5)), bore=0.1, r=0.05, L=0.2)
    model = in_rows("pot wheel", pot=pot, wheel=Inertia(J=1.0))
    refused(LumpedError, lambda: lp.assemble(model), "pot", "ends at 3 rad", "6.28319 rad")


def test_life_of_a_bearing_takes_units():
    bearing = Bearing(
        dynamic="50 kN", static="40 kN", e=0.3, Y_1=2.0, Y_2=2.0, Y_0=1.0, exponent=3.0
    )
    assert bearing.hours(1e4, speed="15 rpm") == pytest.approx(1e6 * 5.0**3.0 / (60 * 15), rel=1e-9)
    refused(LumpedError, lambda: bearing.hours(1e4, speed="fast"), "speed")
    refused(LumpedError, lambda: lp.ops.table([(0, 1), (1, 2)]), "table", "ys")


def test_input_that_is_an_expression_and_a_speed_as_a_shaft_are_named():
    model = in_rows("t wheel", t=Torque(tau=lp.ops.sin(lp.time)), wheel=Inertia(J=1.0))
    system = lp.assemble(model)
    given = {"inputs": ["t.tau"], "outputs": ["wheel.w"], "hertz": [1.0]}
    refused(LumpedError, lambda: lp.frequency_response(system, **given), "t.tau", "expression")
    turned = {"speeds": [1.0, 2.0], "of": ["t.tau"], "shaft": "wheel.w"}
    refused(LumpedError, lambda: lp.vibration.order_response(system, **turned), "is no angle")


def test_case_without_a_cycle_of_its_own_shows_none():
    curve = SNCurve(knee=60e6, cycles=2e6, slope=5.0)
    cases = {
        "start": LoadCase([0.0, 9.0, 0.0], step=1.0),
        "stop": LoadCase([0.0, -9.0, 0.0], step=1.0),
    }
    rows = str(duty_cycle(cases, curve=curve)).splitlines()
    assert "largest cycle" in rows[1]
    assert ["none" in row for row in rows[3:]] == [True, True, False]
    assert rows[5].split()[4] == "18"
