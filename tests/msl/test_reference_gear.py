"""Gears with loss, loads, vehicles and heat: reference results of the Modelica Standard Library."""

import numpy as np
import pytest
from specification import build, read
from test_reference_cases import POSITIONS, outside_of_tube

import lumped as lp

CASES = (
    "mt_rot_braking",
    "rot_eddy_current_brake",
    "rot_lossy_gear_1",
    "rot_lossy_gear_3",
    "rot_rolling_wheel",
    "tr_vehicle",
)
NEAR = 1e-6
"""Reference tables give instants of events with about seven digits, s."""

NEAR_STANDSTILL = 1e-4
"""The vehicle rolls out at 0.1 m/s2: an error of 1e-6 of its 7 m/s is one of 7e-5 s."""


def simulated(case, grid):
    keep = [q for q in case.columns if q.rpartition(".")[2] in POSITIONS]
    system = lp.assemble(build(case), keep=keep)
    return lp.simulate(system, until=case.stop, start=case.start, rtol=1e-9, grid=grid)


def curve(run, column):
    # losses in the table are positive, a heat flow is positive into the component
    return -run[column] if column.endswith(".Q") else run[column]


@pytest.mark.parametrize("name", CASES)
def test_the_trajectory_follows_the_reference(name):
    case = read(name)
    at_times, fine = simulated(case, case.t), simulated(case, 4000)
    rule = case.facts["tolerance"]
    last_at_its_time = np.append(np.diff(case.t) > 0, True)
    events = case.facts["experiment"].get("event_times", [])
    calm = np.all([np.abs(case.t - t) > NEAR for t in [0.0, *events]], axis=0)
    faults = []
    for column, expected in case.columns.items():
        difference = np.abs(curve(at_times, column) - expected)
        if column.endswith(".position"):
            passes = not difference[calm].any()
            print(f"{name} {column}: equal at {calm.sum()} of {len(calm)} points: {passes}")
        else:
            span = np.ptp(expected)
            pointwise = difference[last_at_its_time].max() / span
            width = rule["relative_width"] * case.stop
            tube = outside_of_tube(fine.t, curve(fine, column), case, expected, width).max() / span
            print(f"{name} {column}: {pointwise:.1e} of the range, {tube:.1e} within the window")
            passes = pointwise <= 1e-4 and tube <= rule["relative_height"]
        if not passes:
            faults.append(column)
    assert not faults


@pytest.mark.parametrize("name", CASES)
def test_changes_happen_at_the_instants_of_the_reference_and_at_no_other(name):
    case = read(name)
    run = simulated(case, 10)
    listed = case.facts["experiment"].get("event_times", [])
    # an event at the start is the reference leaving its first guess of the modes
    expected = [t for t in listed if t > NEAR]
    near = NEAR_STANDSTILL if name == "tr_vehicle" else NEAR
    found = [event.time for event in run.events]
    missed = [t for t in expected if np.abs(np.subtract(found, t)).min(initial=1.0) > near]
    # the reference passes over kinks of prescribed signals, which change no mode, and over those of
    # the law of a load that is smooth where they are
    received = [e.time for e in run.events if e.kind != "time" and e.component != "inverse"]
    more = [t for t in received if np.abs(np.subtract(expected, t)).min(initial=1.0) > near]
    assert (missed, more) == ([], [])
