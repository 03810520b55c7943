"""Events are met where a closed form says, by all methods.

``python tests/drives/known_events.py 30000`` tries so many, in lanes and as exported units, too.
"""

import numpy as np
import pytest
from known_cases import PULSES, Known, families
from known_events import METHODS, Count, by_runs, in_lanes
from scipy.integrate import quad

FAMILIES = {family.name: family for family in families()}
TOLD = ("Triangle on a brake", "Triangle on a body")
"""Pulses whose kinks are known before the run."""


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", TOLD)
def test_short_pulses_of_time_are_met(name, method):
    family, count = FAMILIES[name], Count()
    cases = [family.case(np.random.default_rng((3, seed))) for seed in range(8)]
    by_runs(family, cases, method, count)
    assert count.cases == 8
    assert count.events >= 8
    assert (count.missed, count.invented, count.refused) == (0, 0, 0)
    assert count.worst < 1.0


@pytest.mark.parametrize("name", TOLD)
def test_lanes_meet_short_pulses_of_time(name):
    family, count = FAMILIES[name], Count()
    cases = [family.case(np.random.default_rng((3, seed))) for seed in range(8)]
    in_lanes(family, cases, count)
    assert (count.missed, count.invented) == (0, 0)
    assert count.worst < 1.0


@pytest.mark.parametrize("shape", PULSES, ids=lambda shape: type(shape).__name__)
def test_pulses_have_the_areas_and_levels_that_are_said(shape):
    def height(u):
        return {
            "Gaussian": np.exp(-(u**2)),
            "Lorentzian": 1 / (1 + u**2),
            "Triangle": max(1 - abs(u), 0.0),
            "Product": 1 / np.cosh(u) ** 2,
        }[type(shape).__name__]

    for times in (1.5, 20.0):
        begin = -shape.reached(times)
        assert height(begin) == pytest.approx(1 / times, rel=1e-12)
        end = shape.stops(times, begin)
        points = [u for u in (-1.0, 0.0, 1.0, 5.0) if begin < u < end]
        area, _ = quad(height, begin, end, points=points, epsabs=1e-12, limit=200)
        assert shape.area(end) - shape.area(begin) == pytest.approx(area, abs=1e-10)
        assert times * area == pytest.approx(end - begin, abs=1e-8)


@pytest.mark.parametrize(
    ("received", "expected"),
    [
        ([0.1, 0.5, 0.6], (0, 0)),
        ([0.1, 0.6], (1, 0)),
        ([], (3, 0)),
        ([0.1, 0.3, 0.5, 0.6], (0, 1)),
        ([0.1, 0.5, 0.61], (1, 1)),
    ],
)
def test_missed_and_invented_events_are_counted(received, expected):
    count = Count()
    count.compare(Known({}, np.array([0.1, 0.5, 0.6]), np.full(3, 1e-9)), np.array(received))
    assert (count.missed, count.invented) == expected
    assert count.events == 3


def test_errors_are_told_in_tolerances():
    count = Count()
    count.compare(Known({}, np.array([0.1, 0.5]), np.full(2, 1e-9)), np.array([0.1, 0.5 + 3e-9]))
    assert count.worst == pytest.approx(3.0, rel=1e-6)
    count.weigh(Known({}, np.zeros(0), np.zeros(0), (2.0, 1e-8)), 0.0)
    assert count.missed == 1
