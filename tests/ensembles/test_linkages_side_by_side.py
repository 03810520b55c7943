"""Ensembles of linkages that are closed by iteration: side by side, each like its single run."""

import numpy as np
import pytest
from ensemble_runs import (
    Alone,
    all_functionals,
    assert_equal_to_single_runs,
    assert_events_are_those,
    assert_same_bits,
    event_functionals,
    ran,
)
from linkages import FourBar
from rows import assemble_rows

import lumped as lp
from lumped.components import Brake, Inertia, Torque
from lumped.kernel.run import DONE, NO_START
from lumped.many_runs.native_runs import NativeRuns
from lumped.ops import sin

NAMES, UNTIL = ("crank.J", "rocker.J", "bars.r"), 2.0


@pytest.fixture(scope="module")
def rocker():
    """A four-bar whose crank is driven to and fro and braked."""
    return assemble_rows(
        "drive crank bars rocker",
        "crank brake",
        drive=Torque(tau=9.0 * sin(5.0 * lp.time)),
        crank=Inertia(J=2.0, phi=2.0, w=1.0),
        bars=FourBar(),
        rocker=Inertia(J=3.0, phi=1.9),
        brake=Brake(f_max=2.0, u=1.0, characteristic=((0.0, 1.0),)),
    )


@pytest.fixture(scope="module")
def points():
    factors = np.random.default_rng(7).uniform(0.95, 1.05, (21, len(NAMES)))
    return factors * (2.0, 3.0, 1.0)


def test_they_go_side_by_side_with_the_bits_of_one_by_one(rocker, points):
    of = all_functionals(rocker, UNTIL)
    found = ran(rocker, NAMES, points, of, UNTIL, NativeRuns, rtol=1e-8)
    assert_same_bits(found, ran(rocker, NAMES, points, of, UNTIL, Alone, rtol=1e-8))
    assert (found.status == DONE).all()


def test_each_has_the_values_and_events_of_its_single_run(rocker, points):
    names = ["crank.phi", "crank.w", "rocker.phi", "bars.q"]
    found, runs = assert_equal_to_single_runs(
        rocker, NAMES, points[:9], names, UNTIL, (0.7, 1.3), event_functionals(rocker), rtol=1e-8
    )
    assert_events_are_those(found, runs)
    assert sum(len(run.events) for run in runs) > 9


def test_runs_without_a_start_take_no_steps(rocker, points):
    """A crank longer than all else does not close the linkage."""
    some = points[:9].copy()
    some[[2, 3, 7], 2] = 9.0
    of = all_functionals(rocker, UNTIL)
    found = ran(rocker, NAMES, some, of, UNTIL, NativeRuns)
    assert_same_bits(found, ran(rocker, NAMES, some, of, UNTIL, Alone))
    fails = found.status == NO_START
    assert np.flatnonzero(fails).tolist() == [2, 3, 7]
    assert (found.steps[fails] == 0).all()
    assert (found.steps[~fails] > 0).all()
