"""Borders of branches of periodic motions, against closed forms."""

import numpy as np
import pytest

import lumped as lp
from lumped.ops import cos


class UnderStop(lp.Component):
    """Linear oscillator ``m x'' + d x' + c x == F cos(W t)`` under a rigid stop."""

    h: lp.Var = lp.var("m", "gap", state="prefer")
    v: lp.Var = lp.var("m/s", "rate of the gap", state="prefer")
    x: lp.Var = lp.var("m", "position")
    f: lp.Var = lp.var("N", "reaction")
    c: lp.Param = lp.param("N/m", "stiffness", 4.0)
    d: lp.Param = lp.param("N.s/m", "damping", 0.2)
    F: lp.Param = lp.param("N", "force", 0.5)
    W: lp.Param = lp.param("rad/s", "its frequency", 1.3)
    rest: lp.Param = lp.param("m", "gap at rest", 0.9)

    def equations(self):
        yield self.h == self.rest - self.x
        yield self.v == lp.der(self.h)
        load = self.F * cos(self.W * lp.time) + self.d * self.v - self.c * self.x
        yield lp.der(self.v) == -load - self.f
        yield lp.hold(self.f, self.v, gap=self.h, restitution=0.7)


def under_stop(start=None, **parameters):
    period = 2 * np.pi / 1.3
    system = lp.assemble(UnderStop())
    begin = start or {"h": 0.9, "v": 0.0}
    warm_up = 0 if start else 60 * period
    return lp.periodic(system, period=period, warm_up=warm_up, parameters=parameters, start=begin)


def compliance(W):
    return 1 / np.abs(4.0 - W**2 + 0.2j * W)


@pytest.mark.parametrize("over", ["F", "W", "rest"])
def test_a_linear_oscillator_grazes_its_stop_where_its_amplitude_is_the_gap(over):
    """By force and gap the border is a quotient; by frequency a root of a polynomial in W^2."""
    square = (0.5 / 0.9) ** 2
    exact = {
        "F": 0.9 / compliance(1.3),
        "rest": 0.5 * compliance(1.3),
        "W": np.sqrt(np.roots([1, 0.2**2 - 8, 16 - square]).real.min()),
    }[over]
    between = {"F": (0.1, 5.0), "W": (1.0, 2.0), "rest": (0.05, 1.5)}[over]
    turns = 1 if over == "W" else None
    branch = lp.orbits.branch(under_stop(), over=over, between=between, turns=turns)
    (point,) = branch.points
    error = point.value / exact - 1
    print(f"{error:.1e}")
    assert (point.kind, point.component) == ("grazing", "UnderStop")
    assert abs(error) < 1e-9
    assert any("grazing of UnderStop; no motion near" in end for end in branch.ends)
    assert "grazing of UnderStop" in repr(branch)
    # before it nothing happens: the motions are linear
    W = branch.values if over == "W" else np.full(len(branch.values), 1.3)
    F = branch.values if over == "F" else 0.5
    assert branch["x"].amplitude == pytest.approx(F * compliance(W), rel=1e-8)


def test_a_border_at_the_very_start_of_a_period_is_found_too():
    """Without damping the mass is highest at the time zero."""
    begin = {"h": 0.9 - 0.5 / (4 - 1.3**2), "v": 0.0}
    orbit = under_stop(begin, d=1e-9)
    branch = lp.orbits.branch(orbit, over="F", between=(0.1, 5.0))
    (point,) = branch.points
    assert point.value == pytest.approx(0.9 * (4 - 1.3**2), rel=1e-9)


class Rubbing(lp.Component):
    """``x'' + x + F sign(x') == cos(W t)``."""

    x: lp.Var = lp.var("m", "position")
    v: lp.Var = lp.var("m/s", "its rate", state="always")
    f: lp.Var = lp.var("N", "friction")
    W: lp.Param = lp.param("rad/s", "frequency", 0.6)
    F: lp.Param = lp.param("N", "greatest friction", 0.1, min=0)

    def equations(self):
        yield self.v == lp.der(self.x)
        yield lp.der(self.v) == cos(self.W * lp.time) - self.x - self.f
        yield lp.hold(self.f, self.v, forward=self.F, backward=-self.F, upper=self.F, lower=-self.F)


@pytest.mark.parametrize("W", [0.6, 1.5])
def test_a_rubbing_oscillator_begins_to_stick_where_den_hartog_says(W):
    """Den Hartog, Forced vibrations with combined Coulomb and viscous friction, 1931."""
    period = 2 * np.pi / W
    system = lp.assemble(Rubbing(W=W))
    orbit = lp.periodic(system, period=period, warm_up=10 * period)
    branch = lp.orbits.branch(orbit, over="F", between=(0.05, 0.95), step=0.1)
    V, U = 1 / (1 - W**2), np.sin(np.pi / W) / (W * (1 + np.cos(np.pi / W)))
    exact = abs(V) / np.hypot(U, 1 / W**2)
    (point,) = branch.points
    print(f"{point.value / exact - 1:.1e}")
    assert (point.kind, point.component) == ("sticking", "Rubbing")
    assert point.value == pytest.approx(exact, rel=1e-8)
    # without a stop, his amplitude
    slides = branch.values <= exact
    wanted = np.sqrt(V**2 - (branch.values[slides] * U) ** 2)
    assert branch["x"].amplitude[slides] == pytest.approx(wanted, rel=1e-8)
