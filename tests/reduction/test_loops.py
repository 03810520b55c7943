"""Closed linkages and other equations that are not linear in their unknowns."""

import numpy as np
import pytest
from linkages import FourBar, double_rocker, four_bar, pendulum, rocker_angle
from rows import assemble_row, assemble_rows, in_a_row, in_rows
from scipy.optimize import brentq
from scipy.special import ellipk

import lumped as lp
from lumped.components import Fixed, IdealGear, Inertia, Speed, Spring, Torque
from lumped.errors import StartError


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_four_bar_turns_a_hundred_times_without_drift(method):
    system = lp.assemble(four_bar(w=10.0))
    assert system.state_names == ["crank.phi", "crank.w"]
    turns = 100 if method == "explicit" else 10
    run = lp.simulate(system, until=turns * 0.8, rtol=1e-9, method=method, grid=turns * 40)
    a, b, q = run["crank.phi"], run["rocker.phi"], run["linkage.q"]
    print(f"{a[-1] / 2 / np.pi:.0f} turns, {run.statistics}")
    assert a[-1] > turns * 2 * np.pi
    gap = np.hypot(
        np.cos(a) + 3 * np.cos(q) - 3.2 - 2.5 * np.cos(b),
        np.sin(a) + 3 * np.sin(q) - 2.5 * np.sin(b),
    )
    assert gap.max() < 1e-12
    expected = rocker_angle(a)
    assert np.abs((b - expected + np.pi) % (2 * np.pi) - np.pi).max() < 1e-12
    energy = run["crank.w"] ** 2 + 1.5 * run["rocker.w"] ** 2
    assert energy == pytest.approx(energy[0], rel=1e-5)


def test_a_four_bar_accelerates_as_lagrange_says():
    system = lp.assemble(four_bar())
    rng = np.random.default_rng(0)
    for phi, w in rng.uniform(-3, 3, (10, 2)):
        point = lp.start_point(system, start={"crank.phi": phi, "crank.w": w})
        h = 1e-4
        samples = rocker_angle(phi + h * np.arange(-2, 3))
        g = (samples[0] - 8 * samples[1] + 8 * samples[3] - samples[4]) / (12 * h)
        bend = (-samples[0] + 16 * samples[1] - 30 * samples[2] + 16 * samples[3] - samples[4]) / (
            12 * h * h
        )
        expected = -3.0 * g * bend * w * w / (2.0 + 3.0 * g * g)
        assert point["rocker.w"] == pytest.approx(g * w, abs=1e-9)
        assert point["crank.a"] == pytest.approx(expected, abs=1e-5 * max(1, w * w))


def test_a_start_value_chooses_the_assembly():
    below = four_bar().with_({"rocker.phi": -1.9, "linkage.q": -0.8})
    above, mirrored = (
        lp.start_point(lp.assemble(model), start={"crank.phi": 0.0})["rocker.phi"]
        for model in (four_bar(), below)
    )
    assert above == pytest.approx(float(rocker_angle(0.0)), abs=1e-12)
    assert mirrored == pytest.approx(-above, abs=1e-12)


def test_a_linkage_that_cannot_be_closed_is_refused():
    system = lp.assemble(four_bar(phi=0.0))
    with pytest.raises(StartError, match=r"rocker\.phi.*linkage cannot be closed"):
        lp.start_point(system, parameters={"linkage.c": 0.2})


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_linkage_passes_the_dead_centres_of_its_crank(method):
    run = lp.simulate(
        lp.assemble(double_rocker(w=3.0)), until=20.0, rtol=1e-9, method=method, grid=4000
    )
    assert [(event.before, event.after) for event in run.events] == [
        ("crank.phi", "redundant coordinates")
    ]
    a, b, q = run["crank.phi"], run["rocker.phi"], run["linkage.q"]
    gap = np.hypot(
        2.6 * np.cos(a) + 1.2 * np.cos(q) - 3.0 - 2.5 * np.cos(b),
        2.6 * np.sin(a) + 1.2 * np.sin(q) - 2.5 * np.sin(b),
    )
    energy = run["crank.w"] ** 2 + 1.5 * run["rocker.w"] ** 2
    drift = np.abs(energy / energy[0] - 1).max()
    assert gap.max() < 1e-12
    assert drift < 1e-5
    assert (np.diff(np.sign(run["crank.w"])) != 0).sum() > 10  # dead centres passed
    assert np.abs(np.diff(a)).max() < 0.1  # nothing jumps where the states change
    assert np.abs(np.diff(run["rocker.w"])).max() < 1.0


def test_a_pendulum_in_cartesian_coordinates_turns_over_and_keeps_its_period():
    g, length = 9.81, 2.0
    system = lp.assemble(pendulum(v=2 * np.sqrt(g * length) * 1.05))
    assert len(system.state_names) == 2
    run = lp.simulate(system, until=30.0, rtol=1e-10, grid=3000)
    x, y = run["across.s"], run["down.s"]
    radius = np.abs(np.hypot(x, y) - length).max()
    energy = 0.5 * (run["across.v"] ** 2 + run["down.v"] ** 2) - g * y
    drift = np.abs(energy - energy[0]).max() / (2 * g * length)
    angle = np.unwrap(np.arctan2(x, y)) / (2 * np.pi)
    turns = angle[-1]
    assert turns > 10
    assert radius < 1e-12
    assert drift < 1e-6
    # a turn takes 2 k sqrt(l/g) K(k^2), k = 2 sqrt(g l) / v (Whittaker, Analytical Dynamics, 44)
    expected = 13 * 2 * np.sqrt(length / g) / 1.05 * ellipk(1 / 1.05**2)
    assert np.interp(13.0, angle, run.t) == pytest.approx(expected, rel=1e-5)


def test_elastic_parallel_gear_paths_run_a_hundred_turns():
    model = in_rows(
        "a one g1 b",
        "a g2 b",
        a=Inertia(J=1.0, w=10.0),
        one=Spring(c=1e3),
        g1=IdealGear(ratio=2.0),
        g2=IdealGear(ratio=2.0),
        b=Inertia(J=2.0),
    )
    run = lp.simulate(lp.assemble(model, keep=["a.phi"]), until=70.0, rtol=1e-9)
    assert run["a.phi"][-1] > 200 * np.pi
    assert np.abs(run["a.phi"] - 2 * run["b.phi"]).max() < 1e-9


class Hardening(lp.Component):
    """Massless hardening spring: tau = c x + k x^3."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    k: lp.Param = lp.param("N.m/rad3", "hardening", min=0)
    tau: lp.Var = lp.var("N.m", "torque on flange b")

    def equations(self):
        x = self.flange_b.phi - self.flange_a.phi
        yield self.tau == 10.0 * x + self.k * x**3
        yield self.flange_b.tau == self.tau
        yield self.flange_a.tau == -self.tau


def test_hardening_springs_in_series_share_the_torque():
    system = assemble_row(
        wall=Fixed(), one=Hardening(k=50.0), two=Hardening(k=400.0), body=Inertia(J=1.0, phi=1.0)
    )
    assert len(system.state_names) == 2
    run = lp.simulate(system, until=3.0, rtol=1e-9, grid=60)
    for phi, tau in zip(run["body.phi"], run["two.tau"], strict=True):
        middle = brentq(
            lambda x, phi=phi: (10 * x + 50 * x**3) - (10 * (phi - x) + 400 * (phi - x) ** 3),
            -2,
            2,
            xtol=1e-15,
        )
        assert tau == pytest.approx(10 * middle + 50 * middle**3, abs=1e-10)
    stored = 0.5 * run["body.w"] ** 2
    for name, k in (("one", 50.0), ("two", 400.0)):
        x = run[f"{name}.flange_b.phi"] - run[f"{name}.flange_a.phi"]
        stored = stored + 5 * x**2 + k / 4 * x**4
    assert np.abs(stored / stored[0] - 1).max() < 1e-6


def test_an_implicit_quantity_is_solved_again_where_a_torque_jumps():
    model = in_a_row(
        wall=Fixed(),
        one=Hardening(k=50.0),
        two=Hardening(k=400.0),
        pull=Torque(tau=lp.ops.where(lp.time >= 0.5, 30.0, -2.0)),
    )
    run = lp.simulate(lp.assemble(model), until=1.0, grid=4)
    assert run.events[0].component == "pull.tau"
    for name, k in (("one", 50.0), ("two", 400.0)):
        twist = run[f"{name}.flange_b.phi"] - run[f"{name}.flange_a.phi"]
        torque = np.where(np.arange(len(run.t)) < 3, -2.0, 30.0)
        expected = [
            brentq(lambda x, k=k, t=t: 10 * x + k * x**3 - t, -3, 3, xtol=1e-15) for t in torque
        ]
        assert np.abs(twist - expected).max() < 1e-12


def test_a_driven_linkage_comes_to_rest_and_has_modes():
    system = assemble_rows(
        "drive crank linkage rocker",
        "crank.flange_a shaft.flange_a",
        "shaft wall",
        drive=Torque(tau=2.0),
        crank=Inertia(J=2.0, phi=0.5),
        shaft=Spring(c=40.0, phi_rel0=0.0),
        wall=Fixed(phi0=0.5),
        linkage=FourBar(),
        rocker=Inertia(J=3.0, phi=1.9),
    )
    point = lp.equilibrium(system)
    assert point["crank.phi"] == pytest.approx(0.55, rel=1e-10)
    h = 1e-5
    g = float(rocker_angle(0.55 + h) - rocker_angle(0.55 - h)) / (2 * h)
    expected = np.sqrt(40.0 / (2.0 + 3.0 * g * g)) / (2 * np.pi)
    assert lp.modes(system, at=point).hertz == pytest.approx([expected], rel=1e-8)


def test_initial_equations_hold_for_what_a_linkage_moves():
    # the crank stands where the rocker is at 1.75 rad, and turns so that the rocker has 2 rad/s
    model = in_a_row(
        crank=Inertia(J=2.0),
        linkage=FourBar(),
        rocker=Inertia(J=3.0, phi=1.9),
        initial_equations=lambda m: [m.rocker.phi == 1.75, lp.der(m.rocker.phi) == 2.0],
    )
    point = lp.start_point(lp.assemble(model))
    angle, h = point["crank.phi"], 1e-5
    slope = (rocker_angle(angle + h) - rocker_angle(angle - h)) / (2 * h)
    assert rocker_angle(angle) == pytest.approx(1.75, rel=1e-9)
    assert point["crank.w"] == pytest.approx(2.0 / slope, rel=1e-8)


def test_an_initial_equation_for_the_jerk_behind_a_linkage_sets_the_speed_of_its_crank():
    model = in_a_row(
        motor=Speed(w=1.0),
        linkage=FourBar(),
        rocker=Inertia(J=3.0, phi=1.9),
        initial_equations=lambda m: [lp.der(m.rocker.a) == 5.0],
    )
    point = lp.start_point(lp.assemble(model), free=["motor.w"])
    # at constant speed the jerk is w^3 times the third derivative of the rocker's angle
    angle, h = point["motor.flange.phi"], 2e-3
    assert np.cos(rocker_angle(angle) - 1.9) == pytest.approx(1.0, abs=1e-12)
    near = [rocker_angle(angle + k * h) for k in (-3, -2, -1, 1, 2, 3)]
    third = np.dot([1 / 8, -1, 13 / 8, -13 / 8, 1, -1 / 8], near) / h**3
    assert point.parameters["motor.w"] == pytest.approx(np.cbrt(5.0 / third), rel=1e-6)


class Slack(lp.Component):
    """Spring to ground without stiffness in the middle: tau = c (phi - b tanh(phi / b))."""

    flange = lp.Flange()

    def equations(self):
        phi = self.flange.phi
        yield self.flange.tau == 300.0 * (phi - 0.02 * lp.ops.tanh(phi / 0.02))


def test_a_linkage_settles_where_a_slack_spring_holds_it():
    model = in_rows(
        "drive crank linkage rocker",
        "crank spring",
        drive=Torque(tau=-200.0),
        crank=Inertia(J=2.0),
        spring=Slack(),
        linkage=FourBar(),
        rocker=Inertia(J=3.0, phi=1.9),
    )
    point = lp.equilibrium(lp.assemble(model))
    expected = brentq(lambda p: 300.0 * (p - 0.02 * np.tanh(p / 0.02)) + 200.0, -2, 0, xtol=1e-15)
    assert point["crank.phi"] == pytest.approx(expected, rel=1e-9)
    assert np.cos(point["rocker.phi"] - rocker_angle(expected)) == pytest.approx(1.0, abs=1e-12)


def test_the_sum_of_two_equations_mends_a_singular_matrix_of_derivatives():
    class Amplifier(lp.Component):
        u1: lp.Var = lp.var("V", "voltage of the first node", 0.8, state="prefer")
        u2: lp.Var = lp.var("V", "voltage of the second node")

        def equations(self):
            yield lp.der(self.u1) - lp.der(self.u2) == -self.u1
            yield 0 == 1 - self.u1 - self.u2

    run = lp.simulate(lp.assemble(Amplifier()), until=3.0, rtol=1e-9)
    assert run["u1"][-1] == pytest.approx(0.8 * np.exp(-1.5), rel=1e-7)
    assert run["u2"][-1] == pytest.approx(1 - 0.8 * np.exp(-1.5), rel=1e-7)
