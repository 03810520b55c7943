"""Extremes and integrals of quantities between steps, which are long at loose tolerances."""

import numpy as np
import pytest

import lumped as lp
from lumped import functionals as fun
from lumped.ops import sin

paired = lp.ensembles.paired


class Beat(lp.Component):
    """A slow and a fast oscillator, and their sum."""

    slow: lp.Param = lp.param("rad/s", "rate of the slow one", 3.0)
    fast: lp.Param = lp.param("rad/s", "rate of the fast one", 20.0)
    share: lp.Param = lp.param("1", "share of the fast one", 0.4)
    x: lp.Var = lp.var("1", "slow wave", 0.0, state="always")
    v: lp.Var = lp.var("1/s", "its rate over its angular rate", 1.0, state="always")
    y: lp.Var = lp.var("1", "fast wave", 0.0, state="always")
    u: lp.Var = lp.var("1/s", "its rate over its angular rate", 1.0, state="always")
    both: lp.Var = lp.var("1", "sum")
    still: lp.Var = lp.var("1", "what never changes")

    def equations(self):
        yield lp.der(self.x) == self.slow * self.v
        yield lp.der(self.v) == -self.slow * self.x
        yield lp.der(self.y) == self.fast * self.u
        yield lp.der(self.u) == -self.fast * self.y
        yield self.both == self.x + self.share * self.y
        yield self.still == self.share * 2


def crest(slow, fast, share, part):
    """Greatest value of a beat: all crests of its samples, each found by Newton's method."""

    def wave(t, order):
        turn = order * np.pi / 2
        return slow**order * np.sin(slow * t + turn) + share * fast**order * np.sin(fast * t + turn)

    t = np.linspace(*part, 4001)
    y = wave(t, 0)
    inner = t[1:-1][(y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:])]
    for _ in range(5):
        inner = inner - wave(inner, 1) / wave(inner, 2)
    return np.concatenate([y[[0, -1]], wave(inner, 0)]).max()


def test_extremes_of_a_beat_in_many_parts_of_a_run():
    rng = np.random.default_rng(3)
    count, until = 40, 1.7
    points = {
        "slow": rng.uniform(1, 6, count),
        "fast": rng.uniform(10, 60, count),
        "share": rng.uniform(0.02, 1, count),
    }
    parts = np.sort(rng.uniform(0, until, (12, 2)), axis=1).tolist()
    parts = [(0.0, until), *map(tuple, parts)]
    of, expected = {}, []
    for k, part in enumerate(parts):
        of[f"high {k}"] = fun.highest("both", between=part)
        of[f"low {k}"] = fun.lowest("both", between=part)
        rows = list(zip(*points.values(), strict=True))
        expected.append([crest(*row, part) for row in rows])
        # the least value is that of the same beat before the begin
        back = (-part[1], -part[0])
        expected.append([-crest(*row, back) for row in rows])
    system = lp.assemble(Beat())
    for rtol, limit in ((1e-4, 1e-3), (1e-6, 1e-5), (1e-9, 1e-8)):
        found = lp.ensemble(system, over=paired(points), until=until, of=of, rtol=rtol)
        error = np.abs(found.values - np.array(expected).T).max()
        print(f"rtol {rtol:g}: largest error of {found.values.size} extremes {error:.1e}")
        assert error < limit


def test_a_constant_has_no_swing():
    of = {
        "swing": fun.swing("still"),
        "high": fun.highest("still", between=(0.1, 0.2)),
        "low": fun.lowest("still"),
        "peak": fun.peak("still"),
        "mean": fun.mean("still"),
        "rms": fun.rms("still"),
    }
    share = np.array([0.3, -0.7, 0.0])
    found = lp.ensemble(lp.assemble(Beat()), over={"share": share}, until=1.0, of=of)
    assert (found["swing"] == 0).all()
    assert (found["high"] == 2 * share).all()
    assert (found["low"] == 2 * share).all()
    assert (found["peak"] == 2 * np.abs(share)).all()
    assert found["mean"] == pytest.approx(2 * share, rel=1e-14)
    assert found["rms"] == pytest.approx(2 * np.abs(share), rel=1e-14)


# -- quantities that change faster than states -----------------------------------------------------


class Harmonics(lp.Component):
    """A sine and its harmonics, of which steps see the first only."""

    rate: lp.Param = lp.param("rad/s", "angular rate", 3.0)
    x: lp.Var = lp.var("1", "sine", 0.0, state="always")
    v: lp.Var = lp.var("1", "cosine", 1.0, state="always")
    second: lp.Var = lp.var("1", "of twice the rate")
    third: lp.Var = lp.var("1", "of three times the rate")
    fourth: lp.Var = lp.var("1", "of four times the rate")

    def equations(self):
        x, v = self.x, self.v
        yield lp.der(x) == self.rate * v
        yield lp.der(v) == -self.rate * x
        yield self.second == 2 * x * v
        yield self.third == 3 * x - 4 * x**3
        yield self.fourth == 4 * x * v * (1 - 2 * x**2)


def top(rate, a, b):
    """Greatest value of ``sin(rate t)`` from a to b."""
    first = np.ceil((rate * a / np.pi - 0.5) / 2)
    has_crest = np.pi * (2 * first + 0.5) <= rate * b
    return np.where(has_crest, 1.0, np.maximum(np.sin(rate * a), np.sin(rate * b)))


TOLERANCES = [(1e-3, 2e-2), (1e-4, 2e-3), (1e-6, 2e-5), (1e-8, 2e-7)]


@pytest.mark.parametrize(("rtol", "limit"), TOLERANCES)
def test_harmonics_of_a_sine_between_its_steps(rtol, limit):
    """A step turns the sine by a third of a period at the loosest tolerance."""
    rate, until, part = np.linspace(2.0, 30.0, 150), 1.0, (0.31, 0.77)
    of, expected = {}, []
    for k, name in enumerate(("x", "second", "third", "fourth"), 1):
        turn = k * rate
        of[f"highest {k}"] = fun.highest(name)
        of[f"part {k}"] = fun.highest(name, between=part)
        of[f"rms {k}"] = fun.rms(name)
        square = 0.5 - np.sin(2 * turn * until) / (4 * turn * until)
        expected += [top(turn, 0.0, until), top(turn, *part), np.sqrt(square)]
    system = lp.assemble(Harmonics())
    found = lp.ensemble(system, over={"rate": rate}, until=until, of=of, rtol=rtol)
    error = np.abs(found.values - np.array(expected).T).max(axis=0)
    assert error.max() < limit


class Unseen(lp.Component):
    """A slow state, and a quantity of the time that it does not feel."""

    rate: lp.Param = lp.param("rad/s", "angular rate", 100.0)
    x: lp.Var = lp.var("1", "what fades", 1.0, state="always")
    y: lp.Var = lp.var("1", "fast and fading")

    def equations(self):
        yield lp.der(self.x) == -self.x
        yield self.y == self.x * sin(self.rate * lp.time)


@pytest.mark.parametrize("method", ["steps", "implicit", "taylor"])
def test_a_quantity_that_no_state_feels(method):
    """Its sine turns by up to 9 000 rad in a step, by whole turns between samples at many rates."""
    rate = np.geomspace(1.0, 9e3, 60)
    of = {"rms": fun.rms("y"), "late": fun.peak("y", between=(0.5, 1.0)), "low": fun.lowest("y")}
    system = lp.assemble(Unseen())
    found = lp.ensemble(system, over={"rate": rate}, until=1.0, of=of, method=method)
    t = np.linspace(0.0, 1.0, 200_001)
    error = []
    for k, r in enumerate(rate):
        y = np.exp(-t) * np.sin(r * t)
        expected = [np.sqrt(np.trapezoid(y**2, t)), np.abs(y[len(t) // 2 :]).max(), y.min()]
        error.append(np.abs(found.values[k] - expected))
    worst = np.max(error, axis=0)
    assert worst.max() < 1e-3
