"""Extremes and cycles in runs, which are enclosed inside steps, against closed forms."""

import numpy as np
import pytest
from ensemble_runs import CURVE, Alone, assert_same_bits, ran
from narrow_cams import Cam
from scipy.optimize import brentq

import lumped as lp
from lumped import functionals as fun
from lumped.kernel import engine
from lumped.ops import exp, sin, sqrt

METHODS = ["steps", "explicit", "implicit", "taylor"]
paired = lp.ensembles.paired


def found(model, of, over, until, method="steps", rtol=1e-6):
    """Functionals of runs, shape (runs, functionals)."""
    system = lp.assemble(model)
    runs = lp.ensemble(
        system, over=paired(over), until=until, of=of, method=method, rtol=rtol, workers=1
    )
    assert not runs.failures
    return runs.values


class Timed(lp.Component):
    """A state at rest for a while, and quantities of the time that it does not feel."""

    k: lp.Param = lp.param("rad/s", "angular rate", 3.0)
    at: lp.Param = lp.param("rad", "phase", 0.0)
    width: lp.Param = lp.param("s", "width of a dip", 0.1)
    x: lp.Var = lp.var("1", "slow", 0.0, state="always")
    wave: lp.Var = lp.var("1", "fast sine")
    ripple: lp.Var = lp.var("1", "fast sine upon a slow motion")
    dip: lp.Var = lp.var("1", "narrow dip")

    def equations(self):
        t = lp.time
        yield lp.der(self.x) == 1.0
        yield self.wave == sin(self.k * t + self.at)
        yield self.ripple == self.x * (2 - self.x) + 1e-3 * sin(self.k * t + self.at)
        yield self.dip == self.x - exp(-(((t - self.at) / self.width) ** 2))


def top_of(law, slope, bend, begin, end, count):
    """Greatest value of a law: all tops between samples, each by Newton's method."""
    t = np.linspace(begin, end, count)
    s = slope(t)
    t = t[:-1][(s[:-1] > 0) & (s[1:] <= 0)] + (t[1] - t[0]) / 2
    for _ in range(60):
        t = np.clip(t - slope(t) / bend(t), begin, end)
    return max(law(np.array([begin, end])).max(), law(t).max(initial=-np.inf))


@pytest.mark.parametrize("method", METHODS)
def test_fast_sines_of_the_time(method):
    """The run is one step long, or few: a sine turns by 1 to 1 000 rad in it."""
    rng = np.random.default_rng(5)
    k, at = np.geomspace(1.0, 1000.0, 60), rng.uniform(0, 2 * np.pi, 60)
    of = {"high": fun.highest("wave"), "low": fun.lowest("wave"), "peak": fun.peak("wave")}
    of |= {"ripple": fun.highest("ripple", between=(0.1, 0.93))}
    values = found(Timed(), of, {"k": k, "at": at}, 1.0, method)
    for row, a, b in zip(values, k, at, strict=True):

        def has(turn, a=a, b=b):
            return (a + b - turn) // (2 * np.pi) > (b - turn) // (2 * np.pi)

        ends = np.sin([b, a + b])
        high = 1.0 if has(np.pi / 2) else ends.max()
        low = -1.0 if has(-np.pi / 2) else ends.min()
        ripple = top_of(
            lambda t, a=a, b=b: t * (2 - t) + 1e-3 * np.sin(a * t + b),
            lambda t, a=a, b=b: 2 - 2 * t + 1e-3 * a * np.cos(a * t + b),
            lambda t, a=a, b=b: -2 - 1e-3 * a * a * np.sin(a * t + b),
            *(0.1, 0.93, 40001),
        )
        expected = [high, low, max(high, -low), ripple]
        np.testing.assert_allclose(row, expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_narrow_dips(method):
    """They are down to a millionth of the run long, and of what is left of a step."""
    rng = np.random.default_rng(6)
    width = np.geomspace(1e-6, 1e-2, 30)
    at = rng.uniform(0.05, 0.95, 30)
    values = found(Timed(), {"low": fun.lowest("dip")}, {"width": width, "at": at}, 1.0, method)
    # the lowest point of t - exp(-((t - at) / width)^2)
    s = np.zeros(30)
    for _ in range(50):
        s = -0.5 * width * np.exp(s**2)
    expected = np.minimum(at + width * s - np.exp(-(s**2)), -0.0)
    np.testing.assert_allclose(values[:, 0], expected, rtol=0, atol=1e-9)


CAM = {"lift": fun.highest("lift"), "roof": fun.highest("roof"), "saw": fun.highest("saw")}
CAM |= {"still": fun.swing("still"), "size": fun.peak("still")}


@pytest.mark.parametrize("method", METHODS)
def test_a_narrow_cam_and_edges(method):
    """A turn and a half, and no step feels them: the speed is constant."""
    count = 12
    w, b = np.geomspace(1.0, 3000.0, count), np.geomspace(1e-3, 0.3, count)
    until = 9.0
    for speed, half in zip(w, b, strict=True):
        end = until / speed
        row = found(Cam(), CAM, {"w": [speed], "b": [half]}, end, method)[0]
        # 2 pi is passed; the factor beside it changes slowly
        near = 2 * np.pi + np.linspace(-half, half, 100_001)
        lift = np.exp(-((np.sin(near / 2) / half) ** 2)) * (1 + 0.1 * np.cos(near / 7))
        roof = 2 - 0.1 * np.cos(1.0)
        # sin == cos at pi / 4
        expected = [lift.max(), roof, np.sqrt(0.5), 0.0, 1.0]
        np.testing.assert_allclose(row, expected, rtol=0, atol=2e-9)


@pytest.mark.parametrize("method", ["steps", "taylor"])
def test_lanes_and_engines_find_the_same_bits(method):
    system = lp.assemble(Cam())
    points = np.column_stack([np.geomspace(1.0, 300.0, 13), np.geomspace(1e-3, 0.3, 13)])
    given = system, ["w", "b"], points, CAM, 0.4
    expected = ran(*given, method=method)
    assert_same_bits(ran(*given, kind=Alone, method=method), expected)
    with engine.using("c"):
        assert_same_bits(ran(*given, kind=Alone, method=method), expected)
    with engine.using("python"):
        few = ran(system, ["w", "b"], points[2:4], CAM, 0.4, kind=Alone, method=method)
    np.testing.assert_array_equal(few.values, expected.values[2:4])


class Swing(lp.Component):
    """Two oscillators, and quantities that are much faster than both."""

    a: lp.Param = lp.param("rad/s", "rate of one", 3.0)
    b: lp.Param = lp.param("rad/s", "rate of the other", 7.0)
    n: lp.Param = lp.param("1", "how much faster", 20.0)
    x: lp.Var = lp.var("1", "sine", 0.0, state="always")
    u: lp.Var = lp.var("1", "cosine", 1.0, state="always")
    y: lp.Var = lp.var("1", "other sine", 0.0, state="always")
    v: lp.Var = lp.var("1", "other cosine", 1.0, state="always")
    product: lp.Var = lp.var("1", "of both, and a wave of the first")
    narrow: lp.Var = lp.var("1", "peaks where the first passes a value")

    def equations(self):
        yield lp.der(self.x) == self.a * self.u
        yield lp.der(self.u) == -self.a * self.x
        yield lp.der(self.y) == self.b * self.v
        yield lp.der(self.v) == -self.b * self.y
        yield self.product == self.x * self.y + 0.2 * sin(self.n * self.x)
        yield self.narrow == 0.1 * self.y - exp(-((self.n * (self.x - 0.4)) ** 2))


@pytest.mark.parametrize("method", METHODS)
def test_extremes_of_random_swings(method):
    """What is off is what the states are: tolerances of 1e-10."""
    rng = np.random.default_rng(8)
    count, until = 60, 1.3
    over = {"a": rng.uniform(1, 9, count), "b": rng.uniform(1, 9, count)}
    over["n"] = np.exp(rng.uniform(0, 6, count))
    of = {"peak": fun.peak("product"), "high": fun.highest("product"), "low": fun.lowest("narrow")}
    values = found(Swing(), of, over, until, method, 1e-10)
    t = np.linspace(0, until, 200_001)
    for row, a, b, n in zip(values, *over.values(), strict=True):
        x, y = np.sin(a * t), np.sin(b * t)
        product = x * y + 0.2 * np.sin(n * x)
        narrow = 0.1 * y - np.exp(-((n * (x - 0.4)) ** 2))
        expected = [np.abs(product).max(), product.max(), narrow.min()]
        # samples are below the top by an eighth of the bend at most
        h = t[1]
        bends = [0.2 * (n * a) ** 2 + (a + b) ** 2 + n * a * a, 2 * (n * a) ** 2 + b * b]
        below = np.array([bends[0], bends[0], bends[1]]) * h * h / 8
        off = (row - expected) * [1, 1, -1]
        assert (off > -1e-7).all(), (a, b, n, off)
        assert (off < below + 1e-7).all(), (a, b, n, off)


class Pulses(lp.Component):
    """A load with a narrow pulse upon a ramp that no state feels."""

    at: lp.Param = lp.param("s", "instant", 0.5)
    width: lp.Param = lp.param("s", "width", 1e-3)
    x: lp.Var = lp.var("1", "ramp", 0.0, state="always")
    load: lp.Var = lp.var("1", "load")
    alone: lp.Var = lp.var("1", "pulse without a ramp")
    gap: lp.Var = lp.var("1", "root that has no value for an instant")

    def equations(self):
        pulse = exp(-(((lp.time - self.at) / self.width) ** 2))
        yield lp.der(self.x) == 1.0
        yield self.load == self.x - 3 * pulse
        yield self.alone == pulse
        yield self.gap == sqrt((lp.time - self.at) ** 2 - self.width**2)


@pytest.mark.parametrize("method", METHODS)
def test_cycles_of_a_narrow_pulse(method):
    """The load goes from 0 to `top`, to `low`, to 1: three half cycles, or two and a whole one."""
    width = np.geomspace(1e-8, 1e-2, 21)
    at = np.linspace(0.2, 0.9, 21)
    values = found(
        Pulses(), {"damage": fun.damage("load", CURVE)}, {"at": at, "width": width}, 1.0, method
    )
    expected = []
    for t, w in zip(at, width, strict=True):

        def slope(s, w=w):
            return w + 6 * s * np.exp(-(s**2))

        tops = [brentq(slope, -9.0, -1.0), brentq(slope, -0.5, 0.0)]
        high, low = (t + w * s - 3 * np.exp(-(s**2)) for s in tops)
        # rainflow: 0 to high lies within high to low to 1, and no cycle closes in between
        ranges = np.array([high, high - low, 1.0 - low])
        expected.append(0.5 * CURVE.damage(ranges / 2).sum())
    np.testing.assert_allclose(values[:, 0], expected, rtol=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_a_pulse_between_zeros_is_a_cycle(method):
    """Nothing tells the size of the load before: half a cycle up and half a one down."""
    width = np.geomspace(1e-7, 1e-2, 15)
    at = np.linspace(0.2, 0.8, 15)
    of = {"damage": fun.damage("alone", CURVE)}
    values = found(Pulses(), of, {"at": at, "width": width}, 1.0, method)
    np.testing.assert_allclose(values[:, 0], CURVE.damage(np.array([0.5])).sum(), rtol=1e-7)


@pytest.mark.parametrize("method", METHODS)
def test_damage_of_a_load_without_a_value_for_an_instant_is_refused(method):
    over = paired({"at": [0.37, 0.51], "width": [1e-4, 1e-3]})
    of = {"damage": fun.damage("gap", CURVE)}
    runs = lp.ensemble(lp.assemble(Pulses()), over=over, until=1.0, of=of, method=method, workers=1)
    assert sorted(runs.failures) == [0, 1]
    assert all("not a number" in fault for fault in runs.failures.values())
