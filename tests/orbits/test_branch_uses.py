"""Branches of drives: where a brake ceases to stick and slip, how an axis with play oscillates."""

import numpy as np
import pytest
from periodic_motions import Slider
from scipy.optimize import brentq

import lumped as lp
from lumped.errors import OptionError
from lumped.ops import where


def stuck_again(u):
    """Highest velocity after the shoe let go, less that of the rim: a damped vibration, by hand."""
    c, d, m = 9.0, 0.4, 2.0
    fade, w = d / (2 * m), np.sqrt(c / m - (d / (2 * m)) ** 2)
    start = (5.0 - 3.0 - d * u) / c  # from where it would rest
    sine = (u + fade * start) / w
    cosine, sine = u, -fade * sine - w * start  # of the velocity
    turn = np.arctan2(w * sine - fade * cosine, fade * sine + w * cosine)
    t = (turn + np.pi * np.arange(4)) / w
    t = t[t > 1e-9]
    return (np.exp(-fade * t) * (cosine * np.cos(w * t) + sine * np.sin(w * t))).max() - u


def test_a_brake_shoe_sticks_and_slips_up_to_a_speed():
    orbit = lp.periodic(lp.assemble(Slider(d=0.4, u=0.2)), near=8.0)
    branch = lp.orbits.branch(orbit, along={"u": (0.05, 4.0)})
    exact = brentq(stuck_again, 0.1, 3.0, xtol=1e-14)
    (point,) = branch.points
    assert (point.kind, point.component) == ("sticking", "Slider")
    assert point.value == pytest.approx(exact, rel=1e-8)
    assert branch.values.max() == point.value
    # while it sticks only the phase is free
    assert branch.largest.max() < 1e-8


class Axis(lp.Component):
    """Motor under control of the load's position, with elastic play between both."""

    motor: lp.Var = lp.var("rad", "angle of the motor", start=0.1)
    w_motor: lp.Var = lp.var("rad/s", "its speed")
    load: lp.Var = lp.var("rad", "angle of the load", start=0.1)
    w_load: lp.Var = lp.var("rad/s", "its speed")
    twist: lp.Var = lp.var("rad", "relative angle")
    J: lp.Param = lp.param("kg.m2", "inertia of the motor", 1.0)
    J_load: lp.Param = lp.param("kg.m2", "inertia of the load", 4.0)
    d: lp.Param = lp.param("N.m.s/rad", "damping of the motor by its control", 2.0)
    d_load: lp.Param = lp.param("N.m.s/rad", "damping of the load", 0.2)
    c: lp.Param = lp.param("N.m/rad", "stiffness", 20.0)
    b: lp.Param = lp.param("rad", "play", 0.02)
    k: lp.Param = lp.param("N.m/rad", "gain", 10.0)

    def equations(self):
        yield lp.der(self.motor) == self.w_motor
        yield lp.der(self.load) == self.w_load
        yield self.twist == self.motor - self.load
        half = self.b / 2
        over = where(
            self.twist > half, self.twist - half, where(self.twist < -half, self.twist + half, 0.0)
        )
        control = -self.k * self.load - self.d * self.w_motor
        yield self.J * lp.der(self.w_motor) == control - self.c * over
        yield self.J_load * lp.der(self.w_load) == self.c * over - self.d_load * self.w_load


def described(k):
    """Gain of the play and frequency at which the loop oscillates, by its describing function."""
    J, J_load, d, d_load = 1.0, 4.0, 2.0, 0.2
    q = (d + d_load) / (J * d_load + J_load * d)
    gain = (k - d * d_load * q) / ((J + J_load) * q - J * J_load * q**2)
    return gain, np.sqrt(gain * q)


def gain_of(amplitude, half, c):
    """Describing function of elastic play (Gelb and Vander Velde, 1968, appendix B)."""
    r = half / amplitude
    return c * (1 - 2 / np.pi * (np.arcsin(r) + r * np.sqrt(1 - r**2)))


@pytest.fixture(scope="module")
def oscillating():
    return lp.periodic(lp.assemble(Axis()), near=4.0, warm_up=200.0)


def test_an_axis_with_play_oscillates_nearly_as_its_describing_function_says(oscillating):
    branch = lp.orbits.branch(oscillating, along={"k": (10.0, 20.0)})
    twists = np.abs(branch.harmonics("twist", 1)[:, 1])
    rows = []
    for k, period, twist in zip(branch.values, branch.periods, twists, strict=True):
        gain, w = described(k)
        amplitude = brentq(lambda A, g=gain: gain_of(A, 0.01, 20.0) - g, 0.0100001, 10.0)
        rows.append((k, 2 * np.pi / period / w - 1, twist / amplitude - 1))
    gains, frequency, size = np.abs(rows).T
    high = gains > 17  # where the loop is nearly linear, so that harmonics fade
    assert branch.stable.all()
    assert frequency.max() < 0.05
    assert size.max() < 0.08
    assert frequency[high].max() < 0.003
    assert size[high].max() < 0.015


def test_its_oscillation_is_as_large_as_its_play(oscillating):
    """Nothing but the play has a length, so that the amplitude follows it and the period stays."""
    branch = lp.orbits.branch(oscillating, along={"b": (0.005, 0.1)})
    ratio = branch["load"].amplitude / branch.values
    spreads = np.ptp(branch.periods) / branch.periods[0], np.ptp(ratio) / ratio[0]
    print(spreads)
    assert max(spreads) < 1e-7
    with pytest.raises(OptionError, match="which nothing prescribes; that is no period"):
        lp.orbits.branch(oscillating, along={"k": (4.0, 14.0)}, turns=1)
