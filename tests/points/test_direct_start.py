"""Starts that need no search: closed forms by hand, and the search itself as a second way."""

import numpy as np
import pytest
from hybrid_drives import RandomDrive
from rows import assemble_row

import lumped as lp
from lumped.components import Clutch, CrankSlider, IdealGear, Inertia, Spring
from lumped.errors import StartError
from lumped.models import MACHINES, machine
from lumped.points.direct_start import direct_start
from lumped.points.start_search import StartSearch

SEARCHED = {"turbine_generator"}
"""Machines that start in a steady state, from which parameters follow."""


class Geared(lp.Component):
    """Two shafts behind a gear; the speed of the load follows a parameter."""

    speed = lp.param("rad/s", "speed of the load", 3.0)
    motor: Inertia = Inertia(J=0.2)
    gear: IdealGear = IdealGear(ratio=4.0)
    table: Inertia = Inertia(J=5.0)
    shaft: Spring = Spring(c=1e3)
    load: Inertia = Inertia(J=2.0, w=speed, phi=0.1)

    def connections(self):
        yield from lp.chain(self.motor, self.gear, self.table, self.shaft, self.load)


def direct(system, theta, time=0.0, start=()):
    """States by the direct form; None if there is none."""
    unknowns = tuple(system.structure.tree.unknown(name) for name, _ in start)
    form = direct_start(system, unknowns)
    return None if form is None else form.states(theta, time, [value for _, value in start])


def test_given_speeds_and_twists_determine_what_is_no_state():
    system = lp.assemble(Geared(), keep=["load.phi"])
    point = lp.start_point(
        system, parameters={"speed": 2.0}, start={"table.w": 10.0, "shaft.tau": 50.0}
    )
    # tau on flange b is c times the twist
    expected = {"motor.w": 40.0, "load.w": 2.0, "shaft.phi_rel": 50.0 / 1e3, "load.phi": 0.1}
    for name, value in expected.items():
        assert point[name] == pytest.approx(value, abs=1e-13), name
    assert direct(system, point.theta, 0.0, (("table.w", 10.0), ("shaft.tau", 50.0)))


def test_a_slip_that_is_rounding_is_exactly_zero():

    system = assemble_row(
        a=Inertia(J=1.0, w=0.1 + 0.2), clutch=Clutch(f_max=10.0, u=1.0), b=Inertia(J=1.0, w=0.3)
    )
    point = lp.start_point(system)
    assert 0.1 + 0.2 != 0.3
    assert point["clutch.w_rel"] == 0.0
    assert point["clutch.position"] == 0.0


def test_a_mechanism_whose_ratio_changes_is_left_to_the_search():

    system = assemble_row(
        wheel=Inertia(J=1.0), crank=CrankSlider(r=0.1, L=0.4), keep=["crank.slider.s"]
    )
    unknown = system.structure.tree.unknown("crank.slider.s")
    assert direct_start(system, (unknown,)) is None


@pytest.mark.parametrize("name", [name for name in MACHINES if name not in SEARCHED])
def test_the_machines_start_as_the_search_says(name):
    system = machine(name).scene(grid=1).system
    theta = system.theta(None)
    found = direct(system, theta)
    assert found is not None
    searched = StartSearch(system, theta, {}, [], 0.0).solve()[system.structure.in_use]
    np.testing.assert_allclose(found[0], searched, rtol=1e-12, atol=1e-12)


def test_a_steady_state_from_which_parameters_follow_is_left_to_the_search():
    run = machine("turbine_generator").scene(grid=1)
    assert direct(run.system, run.system.theta(None)) is None
    point = run.point(0.0)
    for found, wanted in (("gen.P", "gen.P_0"), ("gen.Q", "gen.Q_0"), ("gen.V", "gen.V_0")):
        assert point[found] == pytest.approx(run.system.parameters[wanted], rel=1e-9)


def test_random_drives_start_as_the_search_says():
    worst, count = 0.0, 0
    for seed in range(24):
        drive = RandomDrive(seed)
        system = lp.assemble(drive.model(), keep=drive.names()[: drive.n])
        theta = system.theta(None)
        found = direct(system, theta)
        if found is None:
            continue
        try:
            searched = StartSearch(system, theta, {}, [], 0.0).solve()[system.structure.in_use]
        except StartError:
            continue
        count += 1
        error = np.abs(found[0] - searched) / (1.0 + np.abs(searched))
        worst = max(worst, float(error.max(initial=0.0)))
    assert count > 15
    assert worst < 1e-12
