"""Extremes and integrals of quantities between steps, which are long at loose tolerances."""

import numpy as np
import pytest

import lumped as lp
from lumped import functionals as fun
from lumped.ops import sin


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
