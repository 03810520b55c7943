"""What branches of periodic motions pass, against closed forms and an independent calculation."""

import numpy as np
import pytest
from periodic_motions import Ball, G, W, one_bounce
from scipy.special import ellipk

import lumped as lp
from lumped.ops import cos, where


@pytest.fixture(scope="module")
def bouncing():
    """One bounce in each period; instant and speeds by hand, as for its multipliers."""
    _, begin = one_bounce()
    orbit = lp.periodic(lp.assemble(Ball()), period=1.0, start=begin, warm_up=0)
    return lp.orbits.branch(orbit, along={"A": (0.1, 0.45)})


def test_a_bouncing_ball_turns_and_doubles_its_period_where_calculated_by_hand(bouncing):
    """Multipliers: z^2 - (1 + e^2 + (1 + e)^2 a / g) z + e^2 (Guckenheimer and Holmes, 1983, 2.4).

    One is 1 where the acceleration `a` of the plate is zero at the impact, and -1 where it is
    -2 g (1 + e^2) / (1 + e)^2; the speed of the plate is that which restores what an impact takes.
    """
    e = 0.6
    across = G / 2 * (1 - e) / (1 + e) / W
    along = 2 * G * (1 + e**2) / (1 + e) ** 2 / W**2
    (fold,), (doubling,) = bouncing.named("fold"), bouncing.named("period doubling")
    expected = [across, np.hypot(across, along)]
    assert [fold.value, doubling.value] == pytest.approx(expected, rel=1e-9)
    assert doubling.multiplier == pytest.approx(-1, abs=1e-8)
    assert len(bouncing.points) == 2


def test_a_branch_that_turns_leaves_its_range_twice_at_the_same_end(bouncing):
    """Before and after the fold; both motions there by hand, with an impact on either side."""
    assert bouncing.ends == ("the greatest value that was asked for is reached",) * 2
    assert bouncing.values[[0, -1]].tolist() == [0.45, 0.45]
    across = G / 2 * (1 - 0.6) / (1 + 0.6) / W
    assert bouncing.values.min() == pytest.approx(across, rel=1e-9)
    side = np.sqrt(0.45**2 - across**2)
    impacts = [next(e.time for e in bouncing.runs[i].events if e.loss) for i in (0, -1)]
    found = np.sort(0.45 * np.cos(W * np.array(impacts)))
    assert found == pytest.approx([-side, side], rel=1e-8)


def test_a_ball_settles_to_bounces_of_two_heights_on_the_branch_that_crosses(bouncing):
    (doubling,) = bouncing.named("period doubling")
    other = bouncing.switch(doubling)
    assert other.periods == pytest.approx(2.0)
    A = doubling.value + 0.01
    orbit = next(orbit for orbit in other.at(A) if orbit.stable)
    # the map from impact to impact: phase and speed upwards, by hand, from two others
    phase, up = np.arcsin(-G / 2 * 0.25 / (A * W)) + 0.1, G / 2
    heights = []
    for _ in range(2000):

        def above(t, phase=phase, up=up):
            start = A * np.cos(phase)
            return start + up * t - G / 2 * t**2 - A * np.cos(phase + W * t)

        low, high = 0.3, 2 * up / G + 0.3
        for _ in range(60):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if above(middle) > 0 else (low, middle)
        down, phase = up - G * low, phase + W * low
        plate = -A * W * np.sin(phase)
        up = plate + 0.6 * (plate - down)
        heights.append(up)
    wanted = sorted(heights[-2:])
    assert wanted[1] - wanted[0] > 0.1
    impacts = [event.time for event in orbit.run.events if event.loss]
    plates = [-A * W * np.sin(W * t) for t in impacts]
    found = sorted(
        plate + float(np.interp(t + 1e-9, orbit.run.t, orbit["v"]))
        for t, plate in zip(impacts, plates, strict=True)
    )
    print(found, wanted)
    assert found == pytest.approx(wanted, abs=1e-5)


def test_a_switch_to_a_branch_that_crosses_is_the_root_of_the_parameter():
    """``x' = mu x - x^3`` beside ``y' = cos(t) - y``: x is zero, or the root of mu."""

    class Fork(lp.Component):
        x: lp.Var = lp.var("1", "forks")
        y: lp.Var = lp.var("1", "driven")
        mu: lp.Param = lp.param("1", "parameter", -1.0)

        def equations(self):
            yield lp.der(self.x) == self.mu * self.x - self.x**3
            yield lp.der(self.y) == cos(lp.time) - self.y

    orbit = lp.periodic(lp.assemble(Fork()), period=2 * np.pi, warm_up=60)
    branch = lp.orbits.branch(orbit, along={"mu": (-1, 1)})
    (point,) = branch.points
    assert point.kind == "branch point"
    assert abs(point.value) < 1e-8
    assert (branch.stable == (branch.values <= 1e-7)).all()
    other = branch.switch(point)
    assert other["x"].highest ** 2 == pytest.approx(other.values, abs=1e-8)
    assert other.values.max() == 1.0


def test_a_torus_begins_where_a_spiral_ceases_to_fade():
    """A spiral with rates ``mu +- j w`` beside a driven state: its multipliers, exactly."""
    w = 0.37

    class Spiral(lp.Component):
        a: lp.Var = lp.var("1", "first")
        b: lp.Var = lp.var("1", "second")
        y: lp.Var = lp.var("1", "driven")
        mu: lp.Param = lp.param("1/s", "growth", -0.5)

        def equations(self):
            square = self.a**2 + self.b**2
            yield lp.der(self.a) == (self.mu - square) * self.a - w * self.b
            yield lp.der(self.b) == (self.mu - square) * self.b + w * self.a
            yield lp.der(self.y) == cos(lp.time) - self.y

    orbit = lp.periodic(lp.assemble(Spiral()), period=2 * np.pi, warm_up=100)
    branch = lp.orbits.branch(orbit, along={"mu": (-0.5, 0.25)})
    (point,) = branch.points
    assert point.kind == "Neimark-Sacker"
    assert abs(point.value) < 1e-8
    exact = np.exp(2 * np.pi * 1j * w)
    assert abs(point.multiplier.real - exact.real) < 1e-8
    assert abs(abs(point.multiplier.imag) - exact.imag) < 1e-8


class Held(lp.Component):
    """Free vibration ``x'' = -f(x)`` whose energy is brought to E, in N, m and kg."""

    cubic: float = 0.0
    x: lp.Var = lp.var("m", "position", start=1.0)
    v: lp.Var = lp.var("m/s", "its rate")
    E: lp.Param = lp.param("J", "energy", 0.5)
    play: lp.Param = lp.param("m", "half the play", 0.0)

    def equations(self):
        yield lp.der(self.x) == self.v
        over = where(
            self.x > self.play,
            self.x - self.play,
            where(self.x < -self.play, self.x + self.play, 0.0),
        )
        if self.cubic:
            over = self.x
        energy = 0.5 * self.v**2 + 0.5 * over**2 + 0.25 * self.cubic * over**4
        force = over + self.cubic * over**3
        yield lp.der(self.v) == -force - 0.2 * (energy - self.E) * self.v


def test_the_backbone_of_a_cubic_spring_is_its_elliptic_integral():
    """Period 4 K(m) / sqrt(1 + k A^2), m = k A^2 / (2 (1 + k A^2)), E = A^2 / 2 + k A^4 / 4."""
    k = 0.8
    orbit = lp.periodic(lp.assemble(Held(cubic=k)), near=6.0, warm_up=200)
    branch = lp.orbits.branch(orbit, along={"E": (0.05, 3.0)})
    square = (-1 + np.sqrt(1 + 4 * k * branch.values)) / k
    wanted = 4 * ellipk(k * square / (2 * (1 + k * square))) / np.sqrt(1 + k * square)
    assert branch.periods == pytest.approx(wanted, rel=1e-8)
    assert branch["x"].amplitude == pytest.approx(np.sqrt(square), rel=1e-7)
    assert branch.values.min() == 0.05
    assert branch.values.max() == 3.0


def test_the_backbone_of_a_play_is_its_closed_form():
    """Half a vibration on each flank, and twice the way through the play at the full speed."""
    b = 0.3
    orbit = lp.periodic(lp.assemble(Held(play=b)), near=8.0, warm_up=200)
    branch = lp.orbits.branch(orbit, along={"E": (0.05, 3.0)})
    speed = np.sqrt(2 * branch.values)
    assert branch.periods == pytest.approx(2 * np.pi + 4 * b / speed, rel=1e-8)
    assert branch["x"].amplitude == pytest.approx(b + speed, rel=1e-8)
    assert not branch.points
