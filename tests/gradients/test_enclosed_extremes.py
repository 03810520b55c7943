"""Extremes and turning points of finished runs, which are enclosed inside steps."""

import numpy as np
import pytest
from narrow_cams import Cam
from scipy.optimize import brentq

import lumped as lp
from lumped import functionals as fun
from lumped.errors import SolverError
from lumped.gradients.legs import SmoothParts, legs_of
from lumped.gradients.readings.extremes import extremes, highest_points, range_of, turning_points_in
from lumped.gradients.steps import steps_of
from lumped.kernel import engine
from lumped.life import SNCurve, turning_points
from lumped.ops import exp, sin, sqrt

METHODS = ["explicit", "implicit"]
CURVE = SNCurve(1.0, 1e6, 5.0)  # the damage of a cycle is 1e-6 times its amplitude to the fifth


class Pulses(lp.Component):
    """A ramp, and narrow pulses of the time that it does not feel."""

    slope: lp.Param = lp.param("1/s", "slope of a ramp", 0.1)
    height: lp.Param = lp.param("1", "height of a pulse", 1.0)
    at: lp.Param = lp.param("s", "its instant", 0.37)
    width: lp.Param = lp.param("s", "its width", 1e-5)
    x: lp.Var = lp.var("1", "ramp", 0.0, state="always")
    up: lp.Var = lp.var("1", "ramp and a pulse")
    down: lp.Var = lp.var("1", "ramp less a pulse")
    alone: lp.Var = lp.var("1", "pulse")
    two: lp.Var = lp.var("1", "pulses of the same height and another one, upside down")

    def equations(self):
        def pulse(at):
            return self.height * exp(-(((lp.time - at) / self.width) ** 2))

        yield lp.der(self.x) == self.slope
        yield self.up == self.x + pulse(self.at)
        yield self.down == self.x - pulse(self.at)
        yield self.alone == pulse(self.at)
        yield self.two == pulse(0.25) + pulse(0.75) - pulse(self.at)


WIDTHS = [1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2]


def place_of_top(slope, width):
    """Where slope * t + exp(-((t - at) / width)^2) is highest: (t - at) / width."""
    return brentq(lambda s: slope * width - 2 * s * np.exp(-(s**2)), 0.0, 0.5, xtol=1e-16)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("width", WIDTHS)
def test_a_pulse_that_no_state_feels(width, method):
    """Values and derivatives by the slope of the ramp, by height and instant of the pulse."""
    system = lp.assemble(Pulses(width=width))
    of = [fun.highest("up"), fun.peak("up"), fun.lowest("down")]
    of += [fun.highest("up", between=(0.5, 0.9)), fun.highest("up", between=(0.3, 0.4))]
    to = ["slope", "height", "at"]
    found = lp.gradient(system, of=of, by=to, until=1.0, method=method)
    slope, height, at = 0.1, 1.0, 0.37
    s = place_of_top(slope, width)
    top = slope * (at + s * width) + height * np.exp(-(s**2))
    by_top = [at + s * width, np.exp(-(s**2)), slope]
    low = slope * (at - s * width) - height * np.exp(-(s**2))
    by_low = [at - s * width, -np.exp(-(s**2)), slope]
    expected = [top, top, low, 0.09, top]
    slopes = [by_top, by_top, by_low, [0.9, 0.0, 0.0], by_top]
    assert found.values == pytest.approx(expected, abs=1e-9)
    off = np.abs(found.derivatives - slopes)
    # an instant is rounded, and the slope of the pulse changes by 2 / width^2 in a second
    assert (off <= [1e-7, 1e-7, 1e-7 + 4e-15 / width**2]).all(), off


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("width", WIDTHS[:4])
def test_pulses_of_the_same_height_are_all_found(width, method):
    system = lp.assemble(Pulses(width=width))
    run = lp.simulate(system, until=1.0, grid=None, method=method)
    course = SmoothParts(run, legs_of(run), steps_of(system, ()), 1e-7)
    for kind, times in {
        "peak": [0.25, 0.37, 0.75],
        "highest": [0.25, 0.75],
        "lowest": [0.37],
    }.items():
        found = extremes(course, getattr(fun, kind)("two").reading)
        assert sorted(top.time for top in found) == pytest.approx(times, abs=1e-8 * width)
        assert [abs(top.value) for top in found] == pytest.approx([1.0] * len(times), abs=1e-15)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(("w", "b"), [(1.0, 1e-3), (30.0, 0.01), (3000.0, 0.1)])
def test_a_narrow_cam_an_edge_and_a_jump(w, b, method):
    """A turn and a half; 2 pi is passed, where the factor beside the cam falls slowly."""
    system = lp.assemble(Cam(w=w, b=b))
    run = lp.simulate(system, until=9.0 / w, grid=None, method=method)
    near = 2 * np.pi + np.linspace(-b, b, 200_001)
    lift = np.exp(-((np.sin(near / 2) / b) ** 2)) * (1 + 0.1 * np.cos(near / 7))
    # the edges at 1 and 1 + pi are equal, and 1 + 2 pi too
    expected = {"lift": lift.max(), "roof": 2 - 0.1 * np.cos(1.0), "jump": 9.3 - 4.0}
    places = {"lift": [near[lift.argmax()]], "jump": [9.3]}
    places["roof"] = [1.0 + k * np.pi for k in range(3)]
    course = SmoothParts(run, legs_of(run), steps_of(system, ()), 1e-7)
    for name, value in expected.items():
        found = extremes(course, fun.highest(name).reading)
        assert found[0].value == pytest.approx(value, abs=1e-9)
        angles = sorted(0.3 + w * top.time for top in found)
        assert angles == pytest.approx(places[name], abs=2e-5 * b if name == "lift" else 1e-7)
    course.legs[0].cut(4.5 / w)
    before = extremes(course, fun.highest("jump", between=(0.0, 4.5 / w)).reading)
    assert [before[0].value, 0.3 + w * before[0].time] == pytest.approx([4.0, 4.0], abs=1e-8)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("width", WIDTHS)
def test_damage_of_a_pulse(width, method):
    """The load goes from 0 to `high`, to `low`, to its end; no cycle closes in between."""
    system = lp.assemble(Pulses(width=width, slope=1.0, height=3.0))
    run = lp.simulate(system, until=1.0, grid=None, method=method)
    tops = [
        brentq(lambda s: width + 6 * s * np.exp(-(s**2)), *between, xtol=1e-16)
        for between in ((-9.0, -1.0), (-0.5, 0.0))
    ]
    high, low = (0.37 + width * s - 3 * np.exp(-(s**2)) for s in tops)
    assert turning_points(run, "down") == pytest.approx([0.0, high, low, 1.0], abs=1e-8)
    ranges = np.array([high, high - low, 1.0 - low])
    found = lp.gradient(
        system, of=[fun.damage("down", CURVE)], by=["height"], until=1.0, method=method
    )
    expected = 0.5e-6 * ((ranges / 2) ** 5).sum()
    assert found.values[0] == pytest.approx(expected, rel=1e-6)
    # low falls with the height by exp(-s^2), high by almost nothing
    falls = np.exp(-(np.array(tops) ** 2))
    by = np.array([-falls[0], falls[1] - falls[0], falls[1]])
    expected = 0.5e-6 * (5 * (ranges / 2) ** 4 * by / 2).sum()
    assert found.derivatives[0, 0] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("grid", [None, 7])
@pytest.mark.parametrize("width", WIDTHS[:4])
def test_turning_points_of_pulses_that_are_zero_elsewhere(width, grid):
    run = lp.simulate(lp.assemble(Pulses(width=width)), until=1.0, grid=grid)
    assert turning_points(run, "alone") == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)
    expected = [0.0, 1.0, -1.0, 1.0, 0.0]
    assert turning_points(run, "two") == pytest.approx(expected, abs=1e-9)


class Wave(lp.Component):
    """A slow ramp, and a wave that is much faster."""

    k: lp.Param = lp.param("rad/s", "rate", 1000.0)
    x: lp.Var = lp.var("1", "ramp", 0.0, state="always")
    y: lp.Var = lp.var("1", "wave")

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield self.y == sin(self.k * self.x)


@pytest.mark.parametrize("method", METHODS)
def test_a_wave_turns_hundreds_of_times_in_a_step(method):
    system = lp.assemble(Wave())
    run = lp.simulate(system, until=1.0, grid=None, method=method)
    found = turning_points(run, "y")
    count = int(1000 / np.pi - 0.5) + 1
    expected = [0.0, *(-1.0) ** np.arange(count), np.sin(1000.0)]
    assert found == pytest.approx(expected, abs=1e-9)


def test_engines_list_the_same_points():
    system = lp.assemble(Pulses(width=1e-3))
    steps = steps_of(system, ())
    for method in METHODS:
        run = lp.simulate(system, until=1.0, grid=None, method=method)
        (leg,) = legs_of(run)

        def listed(span):
            tops, _ = highest_points(steps, span, ("up",), 0, 0.1, 1e-6)
            turns = turning_points_in(steps, span, ("down",), 1e-6)
            return tops, turns, np.array(range_of(steps, span, ("two",), (0.0, 0.0)))

        expected = listed(leg.span())
        assert len(expected[0]) > 0
        assert len(expected[1]) == 2
        assert expected[2] == pytest.approx([-1.0, 1.0], abs=1e-9)
        for name in ("c", "python"):
            with engine.using(name):
                for own, other in zip(listed(leg.span()), expected, strict=True):
                    np.testing.assert_array_equal(own, other)


class Gap(lp.Component):
    """A quantity that has no value for an instant."""

    at: lp.Param = lp.param("1", "where", 0.37)
    x: lp.Var = lp.var("1", "ramp", 0.0, state="always")
    y: lp.Var = lp.var("1", "root")

    def equations(self):
        yield lp.der(self.x) == 1.0
        yield self.y == sqrt((self.x - self.at) ** 2 - 1e-8)


def test_what_has_no_value_for_an_instant_is_refused():
    damage = fun.damage("y", CURVE)
    with pytest.raises(SolverError, match="y is not finite somewhere"):
        lp.gradient(lp.assemble(Gap()), of=[damage], by=["at"], until=1.0, method="explicit")
