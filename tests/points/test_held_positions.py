"""What is held stays held when an equilibrium moves with parameters."""

import numpy as np
import pytest
from differences import slope
from drives_at_points import Fan
from rows import assemble_row, assemble_rows, in_a_row, in_rows
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    Backlash,
    Brake,
    Clutch,
    Damper,
    ElastoBacklash,
    Fixed,
    IdealGear,
    Inertia,
    PickUp,
    QuadraticTorque,
    SpringDamper,
    Stop,
    SwingingMass,
    Torque,
    translation,
)
from lumped.errors import OptionError, SolverError


def derivatives(point, of, to):
    return lp.points.equilibrium_sensitivity(point, of=[of], by=to).derivatives[0]


def test_a_stuck_brake_stays_where_it_is():
    """Closed form: tau = c2 c3 (phi_wall - phi_brake) / (c2 + c3)."""
    model = in_rows(
        "b brake",
        "b s2 b2 s3 wall",
        b=Inertia(J=1.0),
        brake=Brake(f_max=100.0, u=1.0),
        s2=SpringDamper(c=50.0, d=1.0),
        b2=Inertia(J=1.0),
        s3=SpringDamper(c=70.0, d=1.0),
        wall=Fixed(),
    )
    point = lp.equilibrium(lp.assemble(model), start={"b.phi": 0.2})
    received = derivatives(point, "s3.tau", ["wall.phi0", "s2.c", "s3.c"])
    expected = [50 * 70 / 120, -0.2 * (70 / 120) ** 2, -0.2 * (50 / 120) ** 2]
    assert received == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("keep", [(), ("b.phi",)])
def test_two_stuck_brakes_keep_the_twist_between_them(keep):
    """The absolute angle may be left out: the brakes hold its differences all the same."""
    model = in_rows(
        "a shaft b",
        "a one",
        "b two",
        a=Inertia(J=1.0),
        one=Brake(f_max=100.0, u=1.0),
        shaft=SpringDamper(c=50.0, d=1.0, phi_rel=0.3),
        b=Inertia(J=1.0),
        two=Brake(f_max=100.0, u=1.0),
    )
    point = lp.equilibrium(lp.assemble(model, keep=keep))
    received = derivatives(point, "one.tau", ["shaft.c", "shaft.phi_rel0"])
    assert np.abs(received) == pytest.approx([0.3, 50.0], rel=1e-9)


def test_a_locked_clutch_keeps_the_angle_at_which_it_locked():
    """Two springs in series between walls, the clutch between them locked at 0.25 rad."""
    system = assemble_row(
        left=Fixed(),
        s1=SpringDamper(c=30.0, d=1.0),
        a=Inertia(J=1.0),
        clutch=Clutch(f_max=100.0, u=1.0),
        b=Inertia(J=2.0),
        s2=SpringDamper(c=60.0, d=1.0),
        right=Fixed(),
    )
    point = lp.equilibrium(system, start={"clutch.phi_rel": 0.25})
    assert point["clutch.phi_rel"] == pytest.approx(0.25, rel=1e-9)
    # tau (1 / c1 + 1 / c2) == phi_right - phi_left - 0.25
    received = derivatives(point, "s1.tau", ["right.phi0", "s1.c", "s2.c"])
    e = -0.25
    expected = [20.0, e * (60 / 90) ** 2, e * (30 / 90) ** 2]
    assert received == pytest.approx(expected, rel=1e-9)


def test_a_body_that_is_carried_keeps_its_place_on_the_shaft():
    """The held speed of a body picked up is the derivative of no quantity."""
    system = assemble_rows(
        "wall spring a torque",
        "a body",
        wall=Fixed(),
        spring=SpringDamper(c=40.0, d=1.0),
        a=Inertia(J=1.0),
        body=PickUp(J=0.5, u=1.0),
        torque=Torque(tau=8.0),
        keep=["body.phi"],
    )
    point = lp.equilibrium(system, start={"a.phi": 0.2, "body.phi": 1.0})
    received = derivatives(point, "body.phi", ["torque.tau", "spring.c"])
    # the shaft turns by tau / c, and the body with it
    assert received == pytest.approx([1 / 40, -8.0 / 40**2], rel=1e-9)


def test_a_play_in_contact_stays_in_contact():
    """Closed form: a = tau / c + b / 2."""
    model = in_a_row(
        t=Torque(tau=8.0),
        a=Inertia(J=1.0),
        play=Backlash(b=0.1),
        b=Inertia(J=1.0),
        spring=SpringDamper(c=40.0, d=1.0),
        wall=Fixed(),
    )
    point = lp.equilibrium(lp.assemble(model), start={"a.phi": 0.25, "b.phi": 0.2})
    received = derivatives(point, "a.phi", ["play.b", "t.tau", "spring.c"])
    assert received == pytest.approx([0.5, 1 / 40, -8 / 40**2], rel=1e-9)


def test_a_body_stays_on_its_stop():
    """Closed form: f = -c s_max."""
    model = in_rows(
        "push body",
        "body spring wall",
        push=translation.Force(f=50.0),
        body=translation.MassWithStops(m=1.0, s_min=-0.1, s_max=0.2),
        spring=translation.SpringDamper(c=100.0, d=1.0),
        wall=translation.Fixed(),
    )
    point = lp.equilibrium(lp.assemble(model), start={"body.s": 0.2})
    received = derivatives(point, "spring.f", ["body.s_max", "spring.c", "push.f"])
    assert received == pytest.approx([-100.0, -0.2, 0.0], rel=1e-9, abs=1e-12)


def pendulum():
    """A pendulum on a spring whose other end a stuck brake holds at 0.6 rad."""
    return assemble_rows(
        "b brake",
        "b spring",
        "spring p",
        "t p",
        b=Inertia(J=1.0),
        brake=Brake(f_max=100.0, u=1.0),
        spring=SpringDamper(c=50.0, d=1.0),
        p=SwingingMass(m=2.0, R=0.5, J=0.1),
        t=Torque(tau=0.0),
    )


def angle(m):
    """Closed form: c (0.6 - phi) == m g R cos(phi)."""
    balance = lambda phi: 50.0 * (0.6 - phi) - m * 9.80665 * 0.5 * np.cos(phi)  # noqa: E731
    return brentq(balance, -2.0, 2.0, xtol=1e-15)


def stiffness(m):
    return 50.0 - m * 9.80665 * 0.5 * np.sin(angle(m))


def hertz(m):
    return np.sqrt(stiffness(m) / (0.1 + m * 0.25)) / (2 * np.pi)


def test_frequencies_at_a_stuck_brake_inherit_it():
    system = pendulum()
    point = lp.equilibrium(system, start={"b.phi": 0.6})
    found = lp.vibration.eigen_sensitivity(lp.modes(system, at=point), by=["p.m"])
    expected = slope(hertz, 2.0, 1e-3)
    assert found.hertz[0, 0] == pytest.approx(expected, rel=1e-8)
    assert found.moving
    assert "moves with the parameters" in repr(found)


def test_shapes_at_a_stuck_brake_inherit_it():
    system = pendulum()
    point = lp.equilibrium(system, start={"b.phi": 0.6})
    found = lp.vibration.shape_sensitivity(lp.modes(system, at=point), of=["p.tau_g"], by=["p.m"])
    expected = slope(lambda m: -m * 9.80665 * 0.5 * np.sin(angle(m)), 2.0, 1e-3)
    assert found["p.tau_g", "p.m"][0] == pytest.approx(expected, rel=1e-8)


def test_responses_at_a_stuck_brake_inherit_it():
    system = pendulum()
    point = lp.equilibrium(system, start={"b.phi": 0.6})
    answer = lp.frequency_response(
        system, inputs=["t.tau"], outputs=["p.phi"], hertz=[0.0, 1.0], at=point
    )
    found = lp.vibration.response_sensitivity(answer, by=["p.m"])
    w = 2 * np.pi
    dynamic = [lambda m: 1 / stiffness(m) + 0j]
    dynamic.append(lambda m: 1 / (stiffness(m) + 1j * w - w**2 * (0.1 + m * 0.25)))
    expected = [slope(f, 2.0, 1e-3) for f in dynamic]
    assert found["p.phi", "t.tau", "p.m"] == pytest.approx(np.array(expected), rel=1e-8)
    assert found.moving


def geared():
    """A motor, a gear and a fan: ``tau ratio == 20 (w / (10 ratio))^2`` with the fan's sign."""
    return assemble_row(
        motor=Torque(tau=5.0),
        a=Inertia(J=0.3),
        gear=IdealGear(ratio=3.0),
        b=Inertia(J=0.2),
        fan=QuadraticTorque(tau_nominal=-20.0, w_nominal=10.0),
    )


def test_a_given_speed_stays_where_a_torque_was_found_for_it():
    """Closed form: tau = 20 (w / (10 ratio))^2 / ratio at the given w = 15 rad/s."""
    point = lp.equilibrium(geared(), start={"a.w": 15.0}, free=["motor.tau"])
    found = lp.points.equilibrium_sensitivity(point, of=["a.w", "b.w", "gear.flange_b.tau"])
    assert "motor.tau" not in found.by
    assert found["a.w", "gear.ratio"] == pytest.approx(0.0, abs=1e-12)
    assert found["b.w", "gear.ratio"] == pytest.approx(-15 / 9, rel=1e-9)
    load = lambda ratio: 20 * (15 / (10 * ratio)) ** 2  # noqa: E731
    assert abs(found["gear.flange_b.tau", "gear.ratio"]) == pytest.approx(
        abs(slope(load, 3.0, 1e-3)), rel=1e-7
    )
    with pytest.raises(OptionError, match=r"motor\.tau is free at this equilibrium"):
        lp.points.equilibrium_sensitivity(point, of=["b.w"], by=["motor.tau"])


def test_a_given_speed_stays_in_decays_too():
    """The decay of ``(J_a + J_b / ratio^2) dw = -2 k w / ratio^3`` at the given w."""
    system = geared()
    point = lp.equilibrium(system, start={"a.w": 15.0}, free=["motor.tau"])
    found = lp.vibration.eigen_sensitivity(lp.modes(system, at=point), by=["gear.ratio"])
    decay = lambda r: -2 * 0.2 * 15 / r**3 / (0.3 + 0.2 / r**2)  # noqa: E731
    assert found.modes.decays == pytest.approx([decay(3.0)], rel=1e-9)
    assert found.decays[0, 0] == pytest.approx(slope(decay, 3.0, 1e-3), rel=1e-7)


def test_a_free_drive_keeps_the_speed_that_was_given_on_the_shaft_that_it_was_given_to():
    """Nothing determines the speed: that of the second shaft was given, so it stays."""
    system = assemble_row(a=Inertia(J=0.3), gear=IdealGear(ratio=3.0), b=Inertia(J=0.2))
    for given, other, expected in (("a.w", "b.w", -12.0 / 9), ("b.w", "a.w", 12.0)):
        point = lp.equilibrium(system, start={given: 12.0})
        received = [derivatives(point, name, ["gear.ratio"])[0] for name in (given, other)]
        assert received == pytest.approx([0.0, expected], rel=1e-9, abs=1e-12)


def test_at_rest_no_speed_appears():
    model = in_a_row(
        t=Torque(tau=6.0), a=Inertia(J=1.0, w=5.0), spring=SpringDamper(c=30.0, d=1.0), wall=Fixed()
    )
    point = lp.equilibrium(lp.assemble(model), rest=True)
    assert derivatives(point, "a.w", ["t.tau"]) == pytest.approx([0.0], abs=1e-15)
    assert derivatives(point, "a.phi", ["t.tau"]) == pytest.approx([1 / 30], rel=1e-9)


def touching():
    """An elastic play between two springs, whose flank just touches: no torque."""
    return assemble_rows(
        "left s1 a play b s2 right",
        "b force",
        left=Fixed(phi0=-0.05),
        s1=SpringDamper(c=30.0, d=1.0),
        a=Inertia(J=1.0),
        play=ElastoBacklash(c=100.0, b=0.1, d=1.0),
        b=Inertia(J=1.0),
        s2=SpringDamper(c=60.0, d=1.0),
        right=Fixed(),
        force=Torque(tau=0.0),
    )


def test_a_flank_that_just_touches_has_two_derivatives_which_is_refused():
    system = touching()
    point = lp.equilibrium(system, start={"a.phi": -0.05, "b.phi": 0.0})
    for of in (["s1.tau"], ["b.phi"]):
        with pytest.raises(SolverError, match=r"at t = 0 s .* border of play .* right\.phi0 moves"):
            lp.points.equilibrium_sensitivity(point, of=of, by=["right.phi0"])
    # without torque a stiffness has no effect on either side
    assert derivatives(point, "s1.tau", ["s1.c"]) == pytest.approx([0.0], abs=1e-12)
    with pytest.raises(SolverError, match=r"border of play .* play\.b moves it across"):
        lp.vibration.eigen_sensitivity(lp.modes(system, at=point), by=["play.b"])
    answer = lp.frequency_response(
        system, inputs=["force.tau"], outputs=["b.phi"], hertz=[1.0], at=point
    )
    with pytest.raises(SolverError, match=r"border of play .* play\.b moves it across"):
        lp.vibration.response_sensitivity(answer, by=["play.b"])


def test_a_contact_without_force_and_friction_at_its_limit_are_refused():
    """On one side the contact opens; on one side the brake slides."""
    model = in_rows(
        "wall spring a t",
        "stop a",
        wall=Fixed(),
        spring=SpringDamper(c=40.0, d=1.0),
        a=Inertia(J=1.0),
        stop=Stop(),
        t=Torque(tau=0.0),
    )
    point = lp.equilibrium(lp.assemble(model), start={"stop.gap": 0.0})
    with pytest.raises(SolverError, match=r"border of stop .* t\.tau moves it across"):
        lp.points.equilibrium_sensitivity(point, of=["a.phi"], by=["t.tau"])
    held = in_rows(
        "wall spring a",
        "a brake",
        wall=Fixed(),
        spring=SpringDamper(c=40.0, d=1.0, phi_rel=0.25),
        a=Inertia(J=1.0),
        brake=Brake(f_max=20.0, u=1.0),
    )
    point = lp.equilibrium(lp.assemble(held))
    assert point["brake.position"] == 0
    assert abs(point["brake.tau"]) == pytest.approx(10.0, rel=1e-12)
    with pytest.raises(SolverError, match=r"brake \(stuck, with its reaction exactly at its limit"):
        lp.points.equilibrium_sensitivity(point, of=["a.phi"], by=["spring.c"])


def test_pieces_that_join_smoothly_have_a_derivative_where_they_meet():
    model = in_rows(
        "t a d wall",
        "a fan",
        t=Torque(tau=0.0),
        a=Inertia(J=1.0),
        d=Damper(d=4.0),
        wall=Fixed(),
        fan=Fan(),
    )
    point = lp.equilibrium(lp.assemble(model))
    assert derivatives(point, "a.w", ["t.tau", "fan.k"]) == pytest.approx([0.25, 0.0], rel=1e-9)


def test_what_cannot_move_while_it_is_held_is_named():
    """Two stuck brakes and a rigid gear between them: its ratio cannot change."""
    system = assemble_rows(
        "a gear b",
        "a one",
        "b two",
        a=Inertia(J=1.0, phi=0.3),
        one=Brake(f_max=100.0, u=1.0),
        gear=IdealGear(ratio=2.0),
        b=Inertia(J=1.0),
        two=Brake(f_max=100.0, u=1.0),
        keep=["a.phi", "b.phi"],
    )
    with pytest.raises(SolverError, match=r"gear\.ratio changes while one, two stay held"):
        lp.points.equilibrium_sensitivity(lp.equilibrium(system), of=["a.phi"], by=["gear.ratio"])
