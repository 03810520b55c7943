"""Steady state, steady rotation and rest."""

import numpy as np
import pytest
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    Backlash,
    Brake,
    Damper,
    ElastoBacklash,
    Fixed,
    IdealGear,
    Inertia,
    Speed,
    Spring,
    SpringDamper,
    Torque,
    translation,
)
from lumped.errors import SolverError, StartError
from lumped.points import equilibrium_search as module


def loaded(**load):
    """Motor torque, elastic shaft, gear and loaded body."""
    return lp.compose(
        motor=Torque(tau=30.0),
        a=Inertia(J=0.5, w=100.0),
        shaft=SpringDamper(c=400.0, d=0.2),
        gear=IdealGear(ratio=4.0),
        b=Inertia(J=2.0, phi=0.4),
        **load,
        connections=lambda m: [
            *lp.chain(m.motor, m.a, m.shaft, m.gear, m.b),
            *lp.chain(m.b, *(getattr(m, name) for name in load)),
        ],
    )


# -- steady rotation ---------------------------------------------------------------------------


@pytest.mark.parametrize("keep", [[], ["b.phi"], ["a.phi", "b.phi"]])
def test_a_loaded_drive_turns_at_its_given_speed_with_twisted_shaft(keep):
    system = lp.assemble(loaded(load=Torque(tau=-120.0)), keep=keep)
    point = lp.equilibrium(system)
    assert point["a.w"] == pytest.approx(100.0, rel=1e-12)
    assert point["b.w"] == pytest.approx(25.0, rel=1e-12)
    # the twist that carries the motor torque; negative as flange a drives
    assert point["shaft.phi_rel"] == pytest.approx(-30.0 / 400.0, rel=1e-10)
    run = lp.simulate(system, until=2.0, start=point, grid=4, rtol=1e-9)
    assert run["a.w"] == pytest.approx(np.full(5, 100.0), rel=1e-9)
    if keep:
        assert run["b.phi"] == pytest.approx(0.4 + 25.0 * run.t, rel=1e-9)


class Coupling(lp.Component):
    """Elastic coupling that hardens, without a twist of its own: tau = c (b - a) + k (b - a)^3."""

    flange_a = lp.Flange()
    flange_b = lp.Flange()
    c: lp.Param = lp.param("N.m/rad", "stiffness", 200.0)
    k: lp.Param = lp.param("N.m/rad3", "hardening", 5e4)

    def equations(self):
        twist = self.flange_b.phi - self.flange_a.phi
        yield self.flange_b.tau == self.c * twist + self.k * twist**3
        yield self.flange_a.tau == -self.flange_b.tau


def coupled(**coupling):
    return lp.compose(
        motor=Torque(tau=30.0),
        a=Inertia(J=0.5, w=100.0),
        coupling=Coupling(**coupling),
        b=Inertia(J=2.0),
        load=Torque(tau=-30.0),
        connections=lambda m: lp.chain(m.motor, m.a, m.coupling, m.b, m.load),
    )


def test_a_drive_of_absolute_angles_turns_steadily_too():
    system = lp.assemble(coupled())
    assert {"a.phi", "b.phi"} <= set(system.state_names)
    point = lp.equilibrium(system)
    twist = brentq(lambda x: 200.0 * x + 5e4 * x**3 + 30.0, -1, 0, xtol=1e-15)
    assert point["b.phi"] - point["a.phi"] == pytest.approx(twist, rel=1e-9)
    assert [point["a.w"], point["b.w"]] == pytest.approx([100.0, 100.0], rel=1e-12)
    rest = lp.equilibrium(system, rest=True)
    assert rest["b.phi"] - rest["a.phi"] == pytest.approx(twist, rel=1e-9)
    assert [rest["a.w"], rest["b.w"]] == [0.0, 0.0]


@pytest.mark.parametrize("keep", [[], ["fluid.phi_rel"], ["a.phi", "fluid.phi_rel"]])
def test_a_fluid_coupling_slips_steadily(keep):
    model = lp.compose(
        motor=Torque(tau=30.0),
        a=Inertia(J=0.5),
        fluid=Damper(d=2.0),
        b=Inertia(J=2.0),
        fan=Damper(d=0.5),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.motor, m.a, m.fluid, m.b, m.fan, m.wall),
    )
    point = lp.equilibrium(lp.assemble(model, keep=keep))
    assert point["b.w"] == pytest.approx(30.0 / 0.5, rel=1e-10)
    assert point["a.w"] == pytest.approx(30.0 / 0.5 + 30.0 / 2.0, rel=1e-10)


class Rotor(lp.Component):
    """Rotor without an angle: J der(w) = tau."""

    w: lp.Var = lp.var("rad/s", "speed", 3.0)

    def equations(self):
        yield 2.0 * lp.der(self.w) == 4.0


def test_a_speed_that_nothing_depends_on_must_not_grow():
    model = lp.compose(rotor=Rotor(), body=Inertia(J=1.0))
    with pytest.raises(SolverError, match=r"der\(rotor\.w\) stays at 2"):
        lp.equilibrium(lp.assemble(model))


class Tether(lp.Component):
    """Very soft spring to ground: tau = c phi."""

    flange = lp.Flange()

    def equations(self):
        yield self.flange.tau == 1e-2 * self.flange.phi


def test_a_soft_tether_beside_a_stiff_coupling_keeps_a_drive_from_turning_for_ever():
    model = lp.compose(
        motor=Torque(tau=0.5),
        a=Inertia(J=0.5, w=100.0),
        coupling=Coupling(c=1e6),
        b=Inertia(J=2.0),
        tether=Tether(),
        connections=lambda m: lp.chain(m.motor, m.a, m.coupling, m.b, m.tether),
    )
    point = lp.equilibrium(lp.assemble(model))
    assert point["b.phi"] == pytest.approx(0.5 / 1e-2, rel=1e-6)
    assert [point["a.w"], point["b.w"]] == pytest.approx([0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("keep", [[], ["b.phi"]])
def test_the_speed_is_found_where_the_load_depends_on_it(keep):
    system = lp.assemble(loaded(brake=Damper(d=3.0), wall=Fixed()), keep=keep)
    point = lp.equilibrium(system)
    assert point["b.w"] == pytest.approx(4.0 * 30.0 / 3.0, rel=1e-10)
    assert point["shaft.phi_rel"] == pytest.approx(-30.0 / 400.0, rel=1e-10)


def test_a_motor_torque_follows_from_the_speed_that_it_shall_hold():
    system = lp.assemble(loaded(brake=Damper(d=3.0), wall=Fixed()))
    point = lp.equilibrium(system, free=["motor.tau"])
    assert point["a.w"] == pytest.approx(100.0, rel=1e-12)
    # 4 tau = d w / 4
    assert point.parameters["motor.tau"] == pytest.approx(3.0 * 100.0 / 16.0, rel=1e-10)
    with pytest.raises(StartError, match=r"not determine .* motor\.tau, brake\.d"):
        lp.equilibrium(system, free=["motor.tau", "brake.d"])


def test_a_speed_that_is_no_state_is_kept_too():
    model = lp.compose(
        motor=Torque(tau=1.0),
        a=Inertia(J=0.5),
        gear=IdealGear(ratio=4.0),
        b=Inertia(J=2.0),
        brake=Damper(d=3.0),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.motor, m.a, m.gear, m.b, m.brake, m.wall),
    )
    system = lp.assemble(model)
    for name, value in {"a.w": 80.0, "b.w": 20.0}.items():
        point = lp.equilibrium(system, start={name: value}, free=["motor.tau"])
        assert [point["a.w"], point["b.w"]] == pytest.approx([80.0, 20.0], rel=1e-12)
        assert point.parameters["motor.tau"] == pytest.approx(3.0 * 20.0 / 4.0, rel=1e-10)


def test_an_initial_equation_goes_on_to_hold_at_an_equilibrium():
    model = lp.compose(
        a=Inertia(J=0.5),
        shaft=SpringDamper(c=400.0, d=0.2),
        b=Inertia(J=2.0),
        connections=lambda m: lp.chain(m.a, m.shaft, m.b),
        initial_equations=lambda m: [m.a.w + m.b.w == 50.0],
    )
    point = lp.equilibrium(lp.assemble(model))
    assert [point["a.w"], point["b.w"]] == pytest.approx([25.0, 25.0], rel=1e-10)


# -- rest --------------------------------------------------------------------------------------


def hoist():
    """A load on a rope over a drum that an elastic brake holds; it was given speeds."""
    return lp.compose(
        wall=Fixed(),
        brake=Spring(c=900.0),
        drum=Inertia(J=0.3, w=20.0),
        rope=SpringDamper(c=50.0, d=0.1),
        load=Inertia(J=1.0, w=20.0),
        weight=Torque(tau=-45.0),
        connections=lambda m: lp.chain(m.wall, m.brake, m.drum, m.rope, m.load, m.weight),
    )


def test_at_rest_springs_carry_the_load_whatever_speeds_were_given():
    system = lp.assemble(hoist())
    point = lp.equilibrium(system, rest=True)
    received = [point[n] for n in ("drum.w", "load.w", "drum.a", "load.a")]
    assert received == pytest.approx([0.0] * 4, abs=1e-9)
    assert point["brake.phi_rel"] == pytest.approx(-45.0 / 900.0, rel=1e-10)
    assert point["rope.phi_rel"] == pytest.approx(-45.0 / 50.0, rel=1e-10)
    with pytest.raises(StartError, match=r"load\.w = 3 rad/s"):
        lp.equilibrium(system, rest=True, start={"load.w": 3.0})


@pytest.mark.parametrize("keep", [[], ["a.phi"]])
def test_a_balanced_drive_rests_where_it_was_put(keep):
    system = lp.assemble(loaded(load=Torque(tau=-120.0)), keep=keep)
    point = lp.equilibrium(system, rest=True)
    assert [point["a.w"], point["b.w"]] == [0.0, 0.0]
    assert point["shaft.phi_rel"] == pytest.approx(-30.0 / 400.0, rel=1e-10)


def test_what_is_driven_or_turned_does_not_rest():
    with pytest.raises(SolverError, match="no rest"):  # it would turn at 40 rad/s
        lp.equilibrium(lp.assemble(loaded(brake=Damper(d=3.0), wall=Fixed())), rest=True)
    turned = lp.compose(
        motor=Speed(w=10.0),
        a=Inertia(J=1.0),
        connections=lambda m: lp.chain(m.motor, m.a),
    )
    with pytest.raises(SolverError, match=r"no rest: a\.w = 10"):
        lp.equilibrium(lp.assemble(turned), rest=True)


def test_a_mass_hangs_at_rest():
    model = lp.compose(
        ceiling=translation.Fixed(),
        spring=translation.Spring(c=2e3),
        body=translation.Mass(m=4.0, v=1.0),
        weight=translation.Force(f=-4.0 * 9.81),
        connections=lambda m: lp.chain(m.ceiling, m.spring, m.body, m.weight),
    )
    point = lp.equilibrium(lp.assemble(model), rest=True)
    assert point["body.s"] == pytest.approx(-4.0 * 9.81 / 2e3, rel=1e-10)


# -- where Newton's method alone fails ---------------------------------------------------------


class Motor(lp.Component):
    """Motor with a steep characteristic: tau_shaft = T tanh((w_0 - w) / s)."""

    flange = lp.Flange()
    T: lp.Param = lp.param("N.m", "largest torque", 80.0)
    w_0: lp.Param = lp.param("rad/s", "speed without load", 150.0)
    s: lp.Param = lp.param("rad/s", "slip", 0.5)

    def equations(self):
        w = lp.der(self.flange.phi)
        yield self.flange.tau == -self.T * lp.ops.tanh((self.w_0 - w) / self.s)


class Fan(lp.Component):
    """Fan: tau = T_0 + k w |w|."""

    flange = lp.Flange()
    T_0: lp.Param = lp.param("N.m", "constant torque", 5.0)
    k: lp.Param = lp.param("N.m.s2", "fan constant", 1e-3)

    def equations(self):
        w = lp.der(self.flange.phi)
        yield self.flange.tau == self.T_0 + self.k * w * abs(w)


def fan_drive(k=1e-3, **values):
    return lp.compose(
        motor=Motor(),
        a=Inertia(J=0.5),
        shaft=SpringDamper(c=4e4, d=2.0),
        b=Inertia(J=3.0),
        fan=Fan(k=k, **values),
        connections=lambda m: lp.chain(m.motor, m.a, m.shaft, m.b, m.fan),
    )


@pytest.mark.parametrize("k", [0.0, 1e-3, 0.1])
def test_a_steep_motor_runs_up_to_its_steady_speed(k, monkeypatch):
    system = lp.assemble(fan_drive(k), keep=["a.phi"])
    point = lp.equilibrium(system)
    balance = lambda w: 80.0 * np.tanh((150.0 - w) / 0.5) - 5.0 - k * w * abs(w)  # noqa: E731
    expected = brentq(balance, 0.0, 200.0, xtol=1e-13)
    assert point["b.w"] == pytest.approx(expected, rel=1e-9)
    torque = 5.0 + k * expected**2
    assert point["shaft.phi_rel"] == pytest.approx(-torque / 4e4, rel=1e-8)
    if k == 0.0:  # Newton's method alone fails: nothing there reacts to the speed
        monkeypatch.setattr(module, "settled", lambda *_: None)
        with pytest.raises(SolverError, match="no equilibrium"):
            lp.equilibrium(system)


class Play(lp.Component):
    """Spring to ground without stiffness in the middle: tau = c (phi - b tanh(phi / b))."""

    flange = lp.Flange()
    c: lp.Param = lp.param("N.m/rad", "stiffness", 300.0)
    b: lp.Param = lp.param("rad", "play", 0.02)

    def equations(self):
        phi = self.flange.phi
        yield self.flange.tau == self.c * (phi - self.b * lp.ops.tanh(phi / self.b))


def test_a_spring_without_stiffness_where_the_search_begins_finds_its_rest(monkeypatch):
    model = lp.compose(
        drive=Torque(tau=4.0),
        body=Inertia(J=2.0),
        spring=Play(),
        connections=lambda m: lp.chain(m.drive, m.body, m.spring),
    )
    system = lp.assemble(model)
    expected = brentq(lambda p: 300.0 * (p - 0.02 * np.tanh(p / 0.02)) - 4.0, 0, 1, xtol=1e-15)
    for rest in (False, True):
        assert lp.equilibrium(system, rest=rest)["body.phi"] == pytest.approx(expected, rel=1e-9)
    monkeypatch.setattr(module, "settled", lambda *_: None)
    with pytest.raises(SolverError, match="no equilibrium"):
        lp.equilibrium(system)


def test_a_load_beyond_the_motor_is_refused():
    # reversed, the fan would drive; a constant load of 90 N.m beats 80 at every speed
    system = lp.assemble(fan_drive(0.0, T_0=90.0))
    with pytest.raises(SolverError, match=r"no equilibrium near the start values: der\("):
        lp.equilibrium(system)


# -- through play ------------------------------------------------------------------------------


def geared(torque=5.0, ratio=5.0, **starts):
    """Motor, play, gear, elastic shaft and a load that balances the motor."""
    return lp.compose(
        motor=Torque(tau=torque),
        a=Inertia(J=1.0),
        play=ElastoBacklash(c=1e3, d=1.0, b=0.01),
        b=Inertia(J=10.0),
        gear=IdealGear(ratio=ratio),
        shaft=SpringDamper(c=1e3, d=1.0),
        e=Inertia(J=20.0),
        load=Torque(tau=-torque * ratio),
        connections=lambda m: lp.chain(m.motor, m.a, m.play, m.b, m.gear, m.shaft, m.e, m.load),
    ).with_(starts)


@pytest.mark.parametrize("torque", [5.0, -5.0])
@pytest.mark.parametrize("start", [{}, {"a.w": 100.0}, {"e.w": -20.0}])
def test_a_loaded_drive_with_play_turns_steadily_from_the_default_start(torque, start):
    point = lp.equilibrium(lp.assemble(geared(torque)), start=start)
    speed = next((w if n == "a.w" else 5.0 * w for n, w in start.items()), 0.0)
    assert [point["a.w"], 5.0 * point["e.w"]] == pytest.approx([speed] * 2, rel=1e-9, abs=1e-9)
    # the flank carries the motor's torque; its twist counts from the edge of the play
    expected = -np.sign(torque) * (0.005 + 5.0 / 1e3)
    assert point["play.phi_rel"] == pytest.approx(expected, rel=1e-9)
    assert point["shaft.phi_rel"] == pytest.approx(-5.0 * torque / 1e3, rel=1e-9)
    assert point.lost == ()


@pytest.mark.parametrize("torque", [5.0, -5.0])
@pytest.mark.parametrize("damping", [0.0, 2.0])
def test_a_body_comes_to_rest_on_the_flank_of_a_play(torque, damping):
    model = lp.compose(
        wall=Fixed(),
        play=ElastoBacklash(c=100.0, d=damping, b=0.2),
        body=Inertia(J=1.0),
        load=Torque(tau=torque),
        connections=lambda m: lp.chain(m.wall, m.play, m.body, m.load),
    )
    system = lp.assemble(model)
    expected = np.sign(torque) * (0.1 + 5.0 / 100.0)
    for rest in (False, True):
        point = lp.equilibrium(system, rest=rest)
        assert point["play.phi_rel"] == pytest.approx(expected, rel=1e-9)
        assert point["body.w"] == pytest.approx(0.0, abs=1e-12)
    already = lp.equilibrium(system, start={"play.phi_rel": 1.2 * expected})
    assert already["play.phi_rel"] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("torque", [8.0, -8.0])
def test_a_train_of_many_plays_is_driven_through(torque):
    count = 6
    model = lp.compose(
        motor=Torque(tau=torque),
        first=Inertia(J=1.0, w=50.0),
        play=[ElastoBacklash(c=1e3 * (i + 1), d=0.5, b=0.01 * (i + 1)) for i in range(count)],
        wheel=[Inertia(J=0.5 + i) for i in range(count)],
        load=Torque(tau=-torque),
        connections=lambda m: lp.chain(
            m.motor,
            m.first,
            *(p for pair in zip(m.play, m.wheel, strict=True) for p in pair),
            m.load,
        ),
    )
    point = lp.equilibrium(lp.assemble(model))
    for i in range(count):
        expected = -np.sign(torque) * (0.005 * (i + 1) + 8.0 / (1e3 * (i + 1)))
        assert point[f"play[{i}].phi_rel"] == pytest.approx(expected, rel=1e-8)
        assert point[f"wheel[{i}].w"] == pytest.approx(50.0, rel=1e-9)


def test_a_rigid_play_closes_on_the_way_to_an_equilibrium():
    model = lp.compose(
        wall=Fixed(),
        shaft=SpringDamper(c=100.0, d=1.0),
        a=Inertia(J=1.0),
        play=Backlash(b=0.2),
        b=Inertia(J=2.0),
        load=Torque(tau=5.0),
        connections=lambda m: lp.chain(m.wall, m.shaft, m.a, m.play, m.b, m.load),
    )
    point = lp.equilibrium(lp.assemble(model))
    received = [point[n] for n in ("shaft.phi_rel", "play.phi_rel", "a.w", "b.w")]
    assert received == pytest.approx([0.05, 0.1, 0.0, 0.0], rel=1e-9, abs=1e-9)


def test_a_play_that_opens_is_no_steady_rotation():
    # nothing drives: both bodies turn at the given speed, and not one of them alone
    model = lp.compose(
        a=Inertia(J=1.0, w=100.0),
        play=ElastoBacklash(c=1e3, d=1.0, b=0.01),
        b=Inertia(J=10.0),
        connections=lambda m: lp.chain(m.a, m.play, m.b),
    )
    point = lp.equilibrium(lp.assemble(model))
    assert [point["a.w"], point["b.w"]] == pytest.approx([100.0, 100.0], rel=1e-12)
    assert abs(point["play.phi_rel"]) <= 0.005


def test_a_load_slides_until_a_spring_behind_a_gap_takes_what_friction_does_not_hold():
    model = lp.compose(
        wall=Fixed(),
        play=ElastoBacklash(c=100.0, d=1.0, b=0.2),
        body=Inertia(J=1.0),
        brake=Brake(f_max=2.0, u=1.0, characteristic=((0.0, 1.0),)),
        load=Torque(tau=5.0),
        connections=lambda m: lp.chain(m.wall, m.play, m.body, m.brake, m.load),
    )
    point = lp.equilibrium(lp.assemble(model))
    assert point["body.w"] == pytest.approx(0.0, abs=1e-12)
    # it rests where the spring takes from 5 - 2 to 5 + 2 N.m
    assert 0.1 + 3.0 / 100.0 - 1e-6 <= point["play.phi_rel"] <= 0.1 + 7.0 / 100.0 + 1e-6


# -- what is given -----------------------------------------------------------------------------


def test_a_given_speed_stays_although_a_given_twist_cannot():
    system = lp.assemble(geared())
    point = lp.equilibrium(system, start={"a.w": 100.0, "play.phi_rel": -0.006})
    assert [point["a.w"], point["e.w"]] == pytest.approx([100.0, 20.0], rel=1e-12)
    assert point["play.phi_rel"] == pytest.approx(-0.01, rel=1e-9)
    assert point.lost == ("play.phi_rel = -0.006 rad",)
    assert "not kept, as no equilibrium near the start does: play.phi_rel = -0.006" in repr(point)
    both = lp.equilibrium(system, start={"a.w": 100.0, "play.phi_rel": -0.01})
    assert [both["a.w"], both["play.phi_rel"]] == pytest.approx([100.0, -0.01], rel=1e-9)
    assert both.lost == ()


def test_what_is_asked_for_comes_before_what_instances_were_given():
    system = lp.assemble(geared(**{"a.w": 100.0}))
    point = lp.equilibrium(system, start={"e.w": 7.0})
    assert [point["a.w"], point["e.w"]] == pytest.approx([35.0, 7.0], rel=1e-12)
    assert point.lost == ("a.w = 100 rad/s",)


def test_an_initial_equation_that_no_equilibrium_keeps_is_named():
    model = lp.compose(
        push=Torque(tau=4.0),
        body=Inertia(J=0.5),
        brake=Damper(d=2.0),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.push, m.body, m.brake, m.wall),
        initial_equations=lambda m: [m.body.w == 50.0],
    )
    point = lp.equilibrium(lp.assemble(model))
    assert point["body.w"] == pytest.approx(2.0, rel=1e-10)
    (lost,) = point.lost
    assert "initial equation" in lost
    assert "body.w" in lost


def test_an_equilibrium_knows_its_time():
    torque = lp.ops.where(lp.time >= 1.0, 4.0, 0.0)
    model = lp.compose(
        push=Torque(tau=torque),
        body=Inertia(J=0.5),
        brake=Damper(d=2.0),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.push, m.body, m.brake, m.wall),
    )
    system = lp.assemble(model)
    point = lp.equilibrium(system, time=1.0)
    assert point.time == 1.0
    run = lp.simulate(system, until=3.0, start=point, grid=4)
    assert run.t[0] == 1.0
    assert run["body.w"] == pytest.approx(np.full(5, 2.0), rel=1e-9)
