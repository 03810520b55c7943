"""Index reduction and state selection against formulations written by hand."""

import numpy as np
import pytest
from checks import worst
from rows import assemble_row, assemble_rows, in_a_row, in_rows

import lumped as lp
from lumped.components import (
    EllipticalGear,
    IdealGear,
    Inertia,
    Planetary,
    Position,
    Spring,
    Torque,
)
from lumped.components.translation import Mass
from lumped.ops import sin


def relative(received, expected):
    error = np.max(np.abs(np.asarray(received) - expected) / np.maximum(np.abs(expected), 1e-12))
    print(f"relative error {error:.2e}")
    return error


PAIR = in_a_row(
    drive=Torque(tau=7.0), a=Inertia(J=2.0), gear=IdealGear(ratio=3.0), b=Inertia(J=5.0)
)
"""Two inertias and a rigid gear: phi_a = ratio phi_b."""


def test_a_rigidly_geared_pair_has_two_states_and_the_reflected_inertia():
    system = lp.assemble(PAIR, keep=["a.phi"])
    assert system.state_names == ["a.phi", "a.w"]
    assert system.report()["index"] == 3
    rng = np.random.default_rng(2)
    for _ in range(20):
        ja, jb, ratio, tau = rng.uniform(0.1, 10, 4)
        parameters = {"a.J": ja, "b.J": jb, "gear.ratio": ratio, "drive.tau": tau}
        point = lp.start_point(system, parameters=parameters, start={"a.w": 4.0})
        expected = tau / (ja + jb / ratio**2)
        assert relative(point["a.a"], expected) < 1e-14
        assert relative(point["b.a"], expected / ratio) < 1e-14
        assert relative(point["b.w"], 4.0 / ratio) < 1e-14
        assert relative(point["gear.flange_b.tau"], -jb * expected / ratio) < 1e-13
    lone = lp.assemble(PAIR)
    assert lone.state_names == ["a.w"]


def test_a_train_of_rigid_gears_collapses_to_one_speed():
    n = 12
    rng = np.random.default_rng(4)
    inertia, ratio = rng.uniform(0.5, 2, n + 1), rng.uniform(0.5, 2, n)
    model = lp.compose(
        drive=Torque(tau=1.0),
        body=[Inertia(J=j) for j in inertia],
        gear=[IdealGear(ratio=r) for r in ratio],
        connections=lambda m: [
            *lp.chain(m.drive, m.body[0]),
            *(c for i in range(n) for c in lp.chain(m.body[i], m.gear[i], m.body[i + 1])),
        ],
    )
    point = lp.start_point(lp.assemble(model))
    speed = 1 / np.concatenate([[1.0], np.cumprod(ratio)])
    expected = speed / np.sum(inertia * speed**2)
    assert relative([point[f"body[{i}].a"] for i in range(n + 1)], expected) < 1e-12


def test_the_housing_of_a_gear_takes_the_difference_of_the_torques():
    model = in_rows(
        "drive a gear b",
        "gear.support housing.flange_a",
        drive=Torque(tau=6.0),
        a=Inertia(J=1.0),
        gear=IdealGear(ratio=4.0),
        b=Inertia(J=2.0),
        housing=Inertia(J=3.0),
    )
    point = lp.start_point(lp.assemble(model))
    # accelerations x = (a, b, h) with a - h = 4 (b - h): minimise Gauss' constraint
    constraint = np.array([[1.0, -4.0, 3.0]])
    masses = np.diag([1.0, 2.0, 3.0])
    kkt = np.block([[masses, constraint.T], [constraint, np.zeros((1, 1))]])
    expected = np.linalg.solve(kkt, [6.0, 0, 0, 0])[:3]
    assert relative([point[n] for n in ("a.a", "b.a", "housing.a")], expected) < 1e-13


ELLIPTICAL = {"a": Inertia(J=1.3), "gear": EllipticalGear(e=0.5), "b": Inertia(J=0.7)}
"""Inertia, elliptical gear, inertia: J_a, J_b, e."""


def test_a_variable_ratio_keeps_the_driving_angle_as_state():
    system = assemble_row(**ELLIPTICAL)
    assert system.state_names == ["a.phi", "a.w"]
    e = 0.5
    for phi, w in np.random.default_rng(5).uniform(-9, 9, (20, 2)):
        point = lp.start_point(system, start={"a.phi": phi, "a.w": w})
        # ratio and its slope from dphi_b/dphi_a = -(1 - e^2)/(1 + e^2 - 2 e cos phi)
        d = 1 + e * e - 2 * e * np.cos(phi)
        g, slope = -(1 - e * e) / d, (1 - e * e) * 2 * e * np.sin(phi) / d**2
        expected = -0.7 * g * slope * w**2 / (1.3 + 0.7 * g * g)
        assert abs(point["a.a"] - expected) < 1e-12 * max(1, w * w)
        assert relative(point["b.w"], g * w) < 1e-13


def test_a_prescribed_angle_gives_the_torque_it_takes():
    angle = 3 * lp.time + 0.2 * sin(5 * lp.time)
    system = assemble_row(guide=Position(phi=angle), **ELLIPTICAL)
    assert system.state_names == []
    run = lp.simulate(system, until=3.0, grid=50)
    t, e = run.t, 0.5
    phi, w, a = 3 * t + 0.2 * np.sin(5 * t), 3 + np.cos(5 * t), -5 * np.sin(5 * t)
    d = 1 + e * e - 2 * e * np.cos(phi)
    g, slope = -(1 - e * e) / d, (1 - e * e) * 2 * e * np.sin(phi) / d**2
    expected = (1.3 + 0.7 * g * g) * a + 0.7 * g * slope * w**2
    assert worst(-run["guide.flange.tau"], expected) < 1e-13


def test_a_planetary_set_has_the_projected_mass_matrix():
    system = assemble_rows(
        "drive.flange s.flange_a gear.sun",
        "c.flange_a gear.carrier",
        "r.flange_a gear.ring",
        gear=Planetary(ratio=2.5),
        s=Inertia(J=1.0),
        c=Inertia(J=4.0),
        r=Inertia(J=2.0),
        drive=Torque(tau=3.0),
    )
    assert len(system.state_names) == 2
    point = lp.start_point(system)
    basis = np.array([[1, 0], [1 / 3.5, 2.5 / 3.5], [0, 1]])
    mass = basis.T @ np.diag([1.0, 4.0, 2.0]) @ basis
    expected = basis @ np.linalg.solve(mass, basis.T @ [3.0, 0, 0])
    assert relative([point[n] for n in ("s.a", "c.a", "r.a")], expected) < 1e-13
    assert relative(point["gear.ring.tau"], 2.5 * point["gear.sun.tau"]) < 1e-13


def test_springs_in_series_without_inertia_between_them_add_their_compliances():
    system = assemble_row(
        a=Inertia(J=1.0), one=Spring(c=100.0), two=Spring(c=300.0), b=Inertia(J=2.0)
    )
    assert len(system.state_names) == 3
    expected = np.sqrt(75.0 * 1.5) / (2 * np.pi)
    assert relative(lp.modes(system).hertz, expected) < 1e-14


def test_requested_outputs_decide_what_is_computed():
    model = in_rows(
        "one shaft two",
        "idle apart",
        one=Inertia(J=1.0, w=1.0),
        shaft=Spring(c=4.0),
        two=Inertia(J=1.0),
        apart=Inertia(J=2.0, w=3.0),
        idle=Torque(tau=0.0),
    )
    everything = lp.assemble(model)
    assert everything.state_names == ["one.w", "shaft.phi_rel", "two.w", "apart.w"]
    assert {x.what for x in everything.left_out} >= {"one.phi", "apart.phi"}
    only = lp.assemble(model, of=["apart.phi"])
    assert only.state_names == ["apart.phi", "apart.w"]
    assert {x.what for x in only.left_out} >= {"one.w", "shaft.phi_rel", "two.w"}
    run = lp.simulate(only, until=2.0, grid=2)
    assert run["apart.phi"] == pytest.approx([0, 3, 6], rel=1e-12)
    assert "not needed" in repr(only)
    assert "cyclic coordinate" in repr(everything)


def test_an_absolute_angle_that_cancels_is_left_out():
    class Sensor(lp.Component):
        """Torque by relative angle: tau = k (phi_b - phi_a)."""

        flange_a = lp.Flange()
        flange_b = lp.Flange()
        tau: lp.Var = lp.var("N.m", "torque")

        def equations(self):
            yield self.tau == 7.0 * (self.flange_b.phi - self.flange_a.phi)
            yield self.flange_b.tau == self.tau
            yield self.flange_a.tau == -self.tau

    n = 6
    model = lp.compose(
        body=[Inertia(J=1.0 + i) for i in range(n)],
        shaft=[Spring(c=100.0 + i) for i in range(n - 1)],
        across=Sensor(),
        connections=lambda m: [
            *(c for i in range(n - 1) for c in lp.chain(m.body[i], m.shaft[i], m.body[i + 1])),
            *lp.chain(m.body[0], m.across, m.body[n - 1]),
        ],
    )
    system = lp.assemble(model)
    assert not [name for name in system.state_names if name.endswith(".phi")]
    start = {f"shaft[{i}].phi_rel": 0.1 * (i + 1) for i in range(n - 1)}
    run = lp.simulate(system, until=0.1, start=start, grid=1)
    assert run["across.tau"][0] == pytest.approx(7.0 * 1.5, rel=1e-13)
    stiffness = np.zeros((n, n))
    for i, j, c in [*((i, i + 1, 100.0 + i) for i in range(n - 1)), (0, n - 1, 7.0)]:
        stiffness[np.ix_([i, j], [i, j])] += c * np.array([[1, -1], [-1, 1]])
    squares = np.linalg.eigvals(stiffness / (1.0 + np.arange(n))[:, None])
    expected = np.sqrt(np.sort(squares.real)[1:]) / (2 * np.pi)
    free = lp.modes(system)
    assert relative(free.hertz, expected) < 1e-11
    assert free.rigid == 1


class Cam(lp.Component):
    """Follower on a cam, defined for positive angles only: s = r phi^1.5."""

    flange_a = lp.Flange()
    flange_b = lp.LinearFlange()
    r: lp.Param = lp.param("m", "rise at one radian", 0.1, above=0)

    def equations(self):
        a, b = self.flange_a, self.flange_b
        yield lp.lossless(b.s == self.r * a.phi**1.5, a, b)


def test_an_angle_stays_that_enters_by_a_law_without_value_at_some_angles():
    system = assemble_row(shaft=Inertia(J=1.0), cam=Cam(), follower=Mass(m=2.0))
    assert system.state_names == ["shaft.phi", "shaft.w"]
    point = lp.start_point(system, start={"shaft.phi": 0.7, "shaft.w": 3.0})
    slope, bend = 0.15 * 0.7**0.5, 0.075 / 0.7**0.5
    expected = -2 * slope * bend * 9 / (1 + 2 * slope**2)
    assert relative(point["shaft.a"], expected) < 1e-13


def test_long_tables_as_structural_choices_are_told_apart():
    from lumped.components import Table

    times = np.linspace(0, 1, 1501)
    flat, bump = np.zeros(1501), np.zeros(1501)
    bump[750] = 5.0
    model = lp.compose(a=Table(times=times, values=flat), b=Table(times=times, values=bump))
    run = lp.simulate(lp.assemble(model), until=1.0, grid=[0.0, 0.5, 1.0])
    assert run["a.y"] == pytest.approx([0, 0, 0])
    assert run["b.y"] == pytest.approx([0, 5, 0], abs=1e-9)


def test_a_load_torque_may_follow_the_speed_of_a_neighbour():
    class Fan(lp.Component):
        """Driven rotor with a load that grows with the square of its speed: tau = -k w^2."""

        k: lp.Param = lp.param("N.m.s2/rad2", "load factor", 0.5)
        drive: Torque = Torque(tau=8.0)
        rotor: Inertia = Inertia(J=2.0)
        load: Torque = Torque(tau=-k * rotor.w**2)

        def connections(self):
            yield lp.connect(self.drive.flange, self.rotor.flange_a, self.load.flange)

    for model in (Fan(), Fan(rotor=Inertia(J=2.0))):
        run = lp.simulate(lp.assemble(model), until=2.0, rtol=1e-10)
        expected = 4 * np.tanh(run.t)  # J w' = T - k w^2: w = sqrt(T/k) tanh(t sqrt(T k) / J)
        assert np.abs(run["rotor.w"] - expected).max() < 1e-8


def test_the_report_tells_what_became_of_the_model():
    report = assemble_row(**ELLIPTICAL).report()
    assert report["index"] == 3
    assert report["states"] == len(report.states) == 2
    assert list(report.seconds) == ["flatten", "reduce", "prune"]
    text = repr(report)
    assert "a.phi: leads what constraints tie to it" in text
    assert "solved together" in text
    chain = in_a_row(a=Inertia(J=1.0), shaft=Spring(c=4.0), b=Inertia(J=1.0))
    report = lp.assemble(chain).report()
    assert report.states["shaft.phi_rel"] == "declared state='prefer'; constraints determine others"
    assert report.states["a.w"] == "its derivative occurs in the equations"
    assert "a.phi: cyclic coordinate" in repr(report)


def test_the_report_names_ports_that_are_open_and_stand_still():
    """A mesh forgotten on the carrier stands on the ground, which is no error."""
    model = lp.compose(
        sun=Inertia(J=1.0),
        mesh=[IdealGear(ratio=-1.0), IdealGear(ratio=3.0)],
        carrier=Inertia(J=1.0),
        planet=Inertia(J=1.0),
        ring=Inertia(J=1.0),
        connections=lambda m: [
            *lp.chain(m.sun, m.mesh[0], m.planet, m.mesh[1], m.ring),
            lp.connect(m.carrier.flange_a, m.mesh[0].support),
        ],
    )
    report = lp.assemble(model).report()
    assert report.still == ("mesh[1].support",)
    assert "left open and held still\n  mesh[1].support" in repr(report)
