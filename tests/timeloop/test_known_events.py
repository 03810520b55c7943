"""Events are met where a closed form says, by all methods.

``python tests/drives/known_events.py 30000`` tries so many, in lanes and in exported FMUs, too.
"""

import itertools

import numpy as np
import pytest
from checks import in_all_engines
from ensemble_runs import Alone, assert_same_bits, ran
from known_cases import PULSES, Known, families
from known_events import METHODS, Count, run_alone, run_in_lanes
from rows import assemble_row, in_rows
from scipy.integrate import quad

import lumped as lp
from lumped import functionals as fun
from lumped.components import Inertia, Torque
from lumped.components import translation as tr
from lumped.many_runs.native_runs import NativeRuns
from lumped.ops import exp, sin

FAMILIES = {family.name: family for family in families()}
STEPPERS = ("explicit", "implicit", "taylor")
t = lp.time


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", FAMILIES)
def test_events_are_met(name, method):
    family, count = FAMILIES[name], Count()
    cases = [family.case(np.random.default_rng((3, seed))) for seed in range(8)]
    run_alone(family, cases, method, count)
    assert count.cases == 8
    assert count.events >= 8
    assert (count.missed, count.invented, count.refused) == (0, 0, 0)
    assert count.worst < 1.0


@pytest.mark.parametrize("name", FAMILIES)
def test_lanes_meet_events(name):
    family, count = FAMILIES[name], Count()
    cases = [family.case(np.random.default_rng((3, seed))) for seed in range(8)]
    run_in_lanes(family, cases, count)
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
    count.compare_last_speed(Known({}, np.zeros(0), np.zeros(0), (2.0, 1e-8)), 0.0)
    assert count.missed == 1


# -- laws with a closed form of their own ----------------------------------------------------


def test_cams_in_lanes_switch_as_in_single_runs():
    widths, speed, until = np.radians(np.linspace(0.1, 5.0, 11)), 100.0, 1.0
    points = np.column_stack([widths, np.full(11, speed)])
    of, turns = {"count": fun.count("cam")}, 2 * np.pi * np.arange(17)
    # it is on where it is nearer than half of its width to 1 rad
    edges = 1.0 + np.add.outer(np.outer(widths, [-0.5, 0.5]), turns)
    expected = (edges < speed * until).sum(axis=(1, 2))
    for method in ("steps", "taylor"):
        given = FAMILIES["cams"].system, ["width", "speed"], points, of
        lanes, alone = (
            ran(*given, kind=kind, until=until, method=method) for kind in (NativeRuns, Alone)
        )
        assert_same_bits(lanes, alone)
        assert lanes.values[:, 0].tolist() == expected.tolist()


class Even(lp.Component):
    """``x = t - 1``, so steps are as long as the run; y counts while a condition on x holds."""

    x: lp.Var = lp.var("1", "x", -1.0)
    y: lp.Var = lp.var("1", "y", 0.0)
    law = None

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield lp.der(self.y) == lp.ops.where(type(self).law(self.x), 1.0, 0.0)


def even(law):
    """The component with a condition."""
    return lp.assemble(type("Law", (Even,), {"__doc__": ".", "law": staticmethod(law)})())


@pytest.mark.parametrize("method", STEPPERS)
@pytest.mark.parametrize("rate", [1.0, 7.0, 50.0, 300.0, 1000.0])
def test_a_sine_passes_its_limit_by_a_billionth(method, rate):
    by, until = 1e-9, min(12.0, 1000.0 / rate)
    run = lp.simulate(
        even(lambda x: lp.ops.sin(rate * x) > 1 - by), until=until, method=method, max_steps=10**6
    )
    half = 2 * np.arcsin(np.sqrt(by / 2))
    tops = 0.5 * np.pi + 2 * np.pi * np.arange(-int(rate), int(rate * until) + 1)
    expected = np.sort(np.concatenate([tops - half, tops + half])) / rate + 1.0
    expected = expected[(expected > 0) & (expected < until)]
    received = np.array([event.time for event in run.events])
    assert len(received) == len(expected)
    # a border is passed with the slope sqrt(2 by)
    np.testing.assert_allclose(received, expected, rtol=0, atol=1e-11 / np.sqrt(by) + 1e-12)


@pytest.mark.parametrize("method", STEPPERS)
@pytest.mark.parametrize("order", [1, 3, 5, 9])
def test_a_root_of_high_order_is_found_where_it_is(method, order):
    run = lp.simulate(even(lambda x: x**order > 0), until=3.0, method=method)
    assert [event.time for event in run.events] == [pytest.approx(1.0, rel=1e-12)]
    assert run["y"][-1] == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize("method", STEPPERS)
@pytest.mark.parametrize("order", [3, 5])
def test_a_body_lifts_where_its_force_turns(method, order):
    """``s'' = (t - 1)**n`` from 1 s on: ``s(3) = 2**(n + 2) / ((n + 1) (n + 2))``."""
    force = tr.Force(f=(t - 1.0) ** order)
    model = in_rows(
        "m.flange_a stop.flange_b g", m=tr.Mass(m=1.0, s=0.0, v=0.0), stop=tr.Stop(), g=force
    )
    run = lp.simulate(lp.assemble(model, keep=["m.s"]), until=3.0, method=method)
    assert [event.time for event in run.events] == [pytest.approx(1.0, rel=1e-12)]
    expected = 2 ** (order + 2) / ((order + 1) * (order + 2))
    assert run["m.s"][-1] == pytest.approx(expected, rel=1e-5)


def test_engines_find_the_same_instants():
    runs = [
        (FAMILIES["cams"].system, 2.0),
        (even(lambda x: lp.ops.sin(40 * x) > 1 - 1e-6), 0.3),
        (even(lambda x: x**5 > 0), 1.5),
    ]
    for (system, until), method in itertools.product(runs, STEPPERS):
        options = {"until": until, "method": method}
        llvm, c, python = in_all_engines(
            lambda s=system, o=options: [event.time for event in lp.simulate(s, **o).events]
        )
        assert len(llvm)
        assert llvm == c == python


def test_pulses_in_lanes_and_by_all_engines_have_the_bits_of_single_runs():
    law = 12 * exp(-(((t - 0.77) / 1e-5) ** 2)) + 14 * sin(t) * exp(-(((t - 1.5) / 0.01) ** 2))
    system = assemble_row(m=Torque(tau=law), a=Inertia(J=1.0, w=0.0))
    points = np.linspace(0.5, 2.0, 11)[:, None]
    of = {"w": fun.final("a.w")}
    for method in ("steps", "taylor"):
        lanes, alone = (
            ran(system, ["a.J"], points, of, kind=kind, until=1.6, method=method)
            for kind in (NativeRuns, Alone)
        )
        assert_same_bits(lanes, alone)
        total = 12e-5 * np.sqrt(np.pi) + 14e-2 * np.sqrt(np.pi) * np.sin(1.5) * np.exp(-0.25e-4)
        np.testing.assert_allclose(lanes.values[:, 0] * points[:, 0], total, rtol=1e-5)
    llvm, c, python = in_all_engines(lambda: lp.simulate(system, until=1.6)["a.w"][-1])
    assert llvm == c == python
