"""Borders of branches of periodic motions, against closed forms."""

import numpy as np
import pytest
from scipy.linalg import expm

import lumped as lp
from lumped.errors import SolverError
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


def hit_at(v, F, W):
    """Gap at rest with which the stop is hit once in each period at a speed, in closed form.

    Between impacts there is the motion without stop and a free vibration, whose speed the impacts
    change by ``1.7 v``; what is left of it after a period repeats.
    """
    free = expm(np.array([[0.0, 1.0], [-4.0, -0.2]]) * 2 * np.pi / W)
    x, rate = np.linalg.solve(np.eye(2) - free, [0.0, -1.7])
    return x * v + np.sqrt((F * compliance(W)) ** 2 - ((0.7 + rate) * v / W) ** 2)


def speed_of_impact(run):
    """Speed before the only impact of a run; zero without one."""
    return -run.pieces[0].x[-1, 1] if len(run.pieces) > 1 else 0.0


@pytest.mark.parametrize("over", ["F", "W", "rest"])
def test_a_linear_oscillator_grazes_its_stop_where_its_amplitude_is_the_gap(over):
    """By force and gap the border is a quotient; by frequency a root of a polynomial in W^2.

    On one side nothing happens, on the other impacts at speeds that begin with zero.
    """
    square = (0.5 / 0.9) ** 2
    exact = {
        "F": 0.9 / compliance(1.3),
        "rest": 0.5 * compliance(1.3),
        "W": np.sqrt(np.roots([1, 0.2**2 - 8, 16 - square]).real.min()),
    }[over]
    between = {"F": (0.1, 2.6), "W": (1.0, 1.95), "rest": (0.19, 1.5)}[over]
    turns = 1 if over == "W" else None
    branch = lp.orbits.branch(under_stop(), along={over: between}, turns=turns)
    (point,) = branch.named("grazing")
    assert point.component == "UnderStop"
    assert point.value == pytest.approx(exact, rel=1e-9)
    assert all("was asked for is reached" in end for end in branch.ends)
    assert "grazing of UnderStop" in repr(branch)
    v = np.array([speed_of_impact(run) for run in branch.runs])
    W, F, rest = (
        branch.values if name == over else np.full(len(v), value)
        for name, value in (("W", 1.3), ("F", 0.5), ("rest", 0.9))
    )
    assert branch["x"].amplitude[v == 0] == pytest.approx((F * compliance(W))[v == 0], rel=1e-8)
    struck = np.flatnonzero(v)
    assert [hit_at(v[i], F[i], W[i]) for i in struck] == pytest.approx(rest[struck], rel=1e-8)
    assert len(struck) > 5
    assert v[struck].min() < 0.01


def test_low_impacts_are_unstable_up_to_a_fold():
    """Both from the side without impacts and from that with them, as by hand."""
    period = 2 * np.pi / 1.3
    calm = under_stop()
    struck = lp.periodic(calm.system, period=period, warm_up=100 * period, parameters={"F": 2.3})
    free = expm(np.array([[0.0, 1.0], [-4.0, -0.2]]) * period)
    x, rate = np.linalg.solve(np.eye(2) - free, [0.0, -1.7])
    v = x * 0.9 / (x**2 + ((0.7 + rate) / 1.3) ** 2)  # where the force is least
    least = np.hypot(0.9 - x * v, (0.7 + rate) * v / 1.3) / compliance(1.3)
    for begin in (calm, struck):
        branch = lp.orbits.branch(begin, along={"F": (0.1, 2.6)})
        (grazing,), (fold,) = branch.named("grazing"), branch.named("fold")
        assert grazing.value == pytest.approx(0.9 / compliance(1.3), rel=1e-9)
        assert fold.value == pytest.approx(least, rel=1e-9)
        low, high = sorted((grazing.number, fold.number))
        inside = [i for i in range(low + 1, high) if speed_of_impact(branch.runs[i])]
        assert len(inside) > 5
        assert (branch.largest[inside] > 1).all()
        assert branch.stable.sum() >= len(branch.values) - len(inside) - 2
        for i in inside[::4]:
            run, F = branch.runs[i], branch.values[i]
            speed, t = speed_of_impact(run), run.pieces[0].t[-1]
            before, after = (F * np.cos(1.3 * t) - 3.6 - 0.2 * u for u in (speed, -0.7 * speed))
            jump = np.array([[-0.7, 0.0], [(after + 0.7 * before) / speed, -0.7]])
            wanted = np.abs(np.linalg.eigvals(jump @ free)).max()
            assert branch.largest[i] == pytest.approx(wanted, rel=1e-6)
    middle = 0.5 * (grazing.value + fold.value)
    stable = [orbit.stable for orbit in branch.at(middle)]
    assert sorted(stable) == [False, True, True]


def test_a_motion_too_near_to_grazing_is_not_taken_for_another():
    branch = lp.orbits.branch(under_stop(), along={"F": (0.4, 2.1)})
    (grazing,) = branch.named("grazing")
    text = r"between motions \d+ and \d+ of the branch was not found .* further from the border"
    with pytest.raises(SolverError, match=text):
        branch.at(grazing.value * (1 - 1e-6))


def test_a_border_at_the_very_start_of_a_period_is_found_too():
    """Without damping the mass is highest at the time zero."""
    begin = {"h": 0.9 - 0.5 / (4 - 1.3**2), "v": 0.0}
    orbit = under_stop(begin, d=1e-9)
    branch = lp.orbits.branch(orbit, along={"F": (0.1, 5.0)})
    (point,) = branch.points
    assert point.value == pytest.approx(0.9 * (4 - 1.3**2), rel=1e-9)


class Kept(lp.Component):
    """Free vibration ``x'' = -x`` under an elastic stop; its energy is brought to E."""

    h: lp.Var = lp.var("m", "gap", state="prefer", start=0.4)
    v: lp.Var = lp.var("m/s", "rate of the gap", state="prefer")
    x: lp.Var = lp.var("m", "position")
    f: lp.Var = lp.var("N", "reaction")
    E: lp.Param = lp.param("J", "energy", 0.2)

    def equations(self):
        yield self.h == 1.0 - self.x
        yield self.v == lp.der(self.h)
        energy = 0.5 * self.v**2 + 0.5 * self.x**2
        yield lp.der(self.v) == self.x - 0.2 * (energy - self.E) * self.v - self.f
        yield lp.hold(self.f, self.v, gap=self.h, restitution=1.0)


def test_a_free_vibration_lacks_what_is_beyond_an_elastic_stop():
    """Its period is that of a cut cosine; impacts that come to the begin of it are no hindrance."""
    orbit = lp.periodic(lp.assemble(Kept()), near=6.3, warm_up=200.0)
    branch = lp.orbits.branch(orbit, along={"E": (0.1, 1.0)})
    (point,) = branch.points
    assert point.value == pytest.approx(0.5, rel=1e-8)
    above = branch.values > 0.5
    size = np.sqrt(2 * branch.values)
    wanted = 2 * np.pi - 2 * np.arccos(np.minimum(1 / size, 1))
    assert branch.periods == pytest.approx(wanted, rel=1e-7)
    assert above.sum() > 10
    assert branch.values.max() == 1.0
    assert len(branch.values) < 100


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
    branch = lp.orbits.branch(orbit, along={"F": (0.05, 0.95)}, step=0.1)
    V, U = 1 / (1 - W**2), np.sin(np.pi / W) / (W * (1 + np.cos(np.pi / W)))
    exact = abs(V) / np.hypot(U, 1 / W**2)
    (point,) = branch.points
    assert (point.kind, point.component) == ("sticking", "Rubbing")
    assert point.value == pytest.approx(exact, rel=1e-8)
    # without a stop, his amplitude
    slides = branch.values <= exact
    wanted = np.sqrt(V**2 - (branch.values[slides] * U) ** 2)
    assert branch["x"].amplitude[slides] == pytest.approx(wanted, rel=1e-8)
