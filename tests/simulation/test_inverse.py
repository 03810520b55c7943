"""Inverse dynamics against closed forms."""

import numpy as np
import pytest
from checks import refused, worst
from linkages import Yoke
from rows import assemble_rows, in_a_row

import lumped as lp
from lumped import profiles
from lumped.components import (
    Backlash,
    BearingFriction,
    Clutch,
    DCMotor,
    Ground,
    IdealGear,
    Inertia,
    Spring,
    SpringDamper,
    Torque,
    VoltageSource,
    translation,
)
from lumped.errors import OptionError, SingularModelError, SolverError, StartError, UnknownNameError
from lumped.ops import cos, pi, sin, where

J_A, C, J_B = 2.0, 300.0, 1.0
FRICTION = ((0.0, 5.0), (10.0, 6.0))


def drive(**named):
    """A torque and what it drives, one after the other."""
    return in_a_row(motor=Torque(tau=0.0), **named)


def two_masses(**replaced):
    parts = {"a": Inertia(J=J_A), "shaft": Spring(c=C), "b": Inertia(J=J_B), **replaced}
    return lp.assemble(drive(**parts))


def seventh(x, order):
    """Derivatives of 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7."""
    law = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
    return (law.deriv(order) if order else law)(np.clip(x, 0, 1)) * ((x < 1) | (order == 0))


def test_a_rigid_drive_needs_the_torque_of_its_reflected_inertia():
    system = lp.assemble(drive(a=Inertia(J=0.02), gear=IdealGear(ratio=5.0), load=Inertia(J=1.5)))
    run = lp.inverse(system, motion={"load.phi": sin(3 * lp.time)}, drive="motor.tau", until=2.0)
    assert worst(run["motor.tau"], -9 * np.sin(3 * run.t) * (0.02 * 5 + 1.5 / 5)) < 1e-13
    assert worst(run["a.w"], 15 * np.cos(3 * run.t)) < 1e-13


@pytest.mark.parametrize("quantity", ["b.phi", "b.w", "b.a", "b.flange_b.phi"])
def test_a_spring_between_motor_and_load_takes_the_fourth_derivative_of_the_angle(quantity):
    T, h, t_0 = 0.8, 2.5, 0.1
    position = profiles.path(profiles.polynomial7(h, T), begin=t_0)
    order = {"b.w": 1, "b.a": 2}.get(quantity, 0)
    wanted = position
    for _ in range(order):
        wanted = lp.der(wanted)
    system = two_masses()
    run = lp.inverse(system, motion={quantity: wanted}, drive="motor.tau", until=1.2)
    inside = (run.t > t_0 + 1e-9) & (run.t < t_0 + T - 1e-9)
    x = (run.t[inside] - t_0) / T
    second, fourth = h / T**2 * seventh(x, 2), h / T**4 * seventh(x, 4)
    expected = (J_A + J_B) * second + J_A * J_B / C * fourth
    assert worst(run["motor.tau"][inside], expected) < 1e-11
    assert (
        worst(run["a.w"][inside], h / T * seventh(x, 1) + J_B / C * h / T**3 * seventh(x, 3))
        < 1e-11
    )
    outside = (run.t < t_0 - 1e-9) | (run.t > t_0 + T + 1e-9)
    assert np.abs(run["motor.tau"][outside]).max() < 1e-9 * np.abs(expected).max()


def test_several_motions_have_several_drives():
    model = in_a_row(
        left=Torque(tau=0.0),
        a=Inertia(J=J_A),
        shaft=Spring(c=C),
        b=Inertia(J=J_B),
        right=Torque(tau=0.0),
    )
    run = lp.inverse(
        lp.assemble(model),
        motion={model.a.phi: sin(2 * lp.time), model.b.phi: cos(3 * lp.time)},
        drive=[model.left.tau, model.right.tau],
        until=1.0,
    )
    a, b = np.sin(2 * run.t), np.cos(3 * run.t)
    assert worst(run["left.tau"], -4 * J_A * a + C * (a - b)) < 1e-12
    assert worst(run["right.tau"], -9 * J_B * b + C * (b - a)) < 1e-12


def test_a_damped_twist_follows_the_motion_as_a_state():
    # J_B b'' = -(c x + d x') of the twist x = b - a: a first-order lag driven by the motion
    d, w = 20.0, 4.0
    system = two_masses(shaft=SpringDamper(c=C, d=d))
    run = lp.inverse(
        system, motion={"b.phi": sin(w * lp.time)}, drive="motor.tau", until=1.0, rtol=1e-10
    )
    assert run.system.state_names == ["shaft.phi_rel"]
    # d x' + c x = J_B w^2 sin(w t), x(0) = 0
    k = J_B * w**2 / (C**2 + (d * w) ** 2)
    expected = k * (C * np.sin(w * run.t) - d * w * (np.cos(w * run.t) - np.exp(-C / d * run.t)))
    assert worst(run["shaft.phi_rel"], expected) < 1e-8


def test_a_damping_of_zero_by_which_is_divided_is_named():
    """With d the twist is a lag of the motion of time constant d / c; without it there is none."""
    system = two_masses(shaft=SpringDamper(c=C, d=0.0))
    motion = {"b.phi": sin(4.0 * lp.time)}
    wanted = {"motion": motion, "drive": "motor.tau", "until": 1.0}
    refused(OptionError, lambda: lp.inverse(system, **wanted), "shaft.d = 0:", "Spring")
    lightly = lp.inverse(system, **wanted, parameters={"shaft.d": 1.0})
    slow = C / 1.0 * lightly.t > 40.0  # the lag has died out: k (C sin - d w cos)
    twist = 16.0 * J_B / (C**2 + 16.0) * (C * np.sin(4 * lightly.t) - 4.0 * np.cos(4 * lightly.t))
    assert worst(lightly["shaft.phi_rel"][slow], twist[slow]) < 1e-6


def test_friction_adds_its_torque_against_the_motion():
    system = lp.assemble(drive(a=Inertia(J=2.0), f=BearingFriction(characteristic=FRICTION)))
    run = lp.inverse(system, motion={"a.phi": 3 * sin(3 * lp.time)}, drive="motor.tau", until=2.0)
    w = 9 * np.cos(3 * run.t)
    moving = np.abs(w) > 1e-9
    expected = -54 * np.sin(3 * run.t) + np.sign(w) * (5 + 0.1 * np.abs(w))
    assert worst(run["motor.tau"][moving], expected[moving]) < 1e-12
    turns = [event.time for event in run.events]
    assert turns == pytest.approx([pi / 6, pi / 2], rel=1e-12)


def test_a_voltage_is_found_as_well():
    k, R, L, J = 0.4, 0.5, 0.01, 0.02
    system = assemble_rows(
        "supply.p motor.p",
        "supply.n motor.n ground.pin",
        supply=VoltageSource(v=0.0),
        ground=Ground(),
        motor=DCMotor(J=J, k=k, R=R, L=L),
    )
    run = lp.inverse(system, motion={"motor.w": sin(5 * lp.time)}, drive="supply.v", until=1.0)
    # i = J w' / k; v = R i + L i' + k w
    s, c = np.sin(5 * run.t), np.cos(5 * run.t)
    assert worst(run["supply.v"], R * J * 5 * c / k - L * J * 25 * s / k + k * s) < 1e-12


def test_a_mechanism_is_inverted_through_its_varying_ratio():
    # s = r sin(phi): torque m s'' r cos(phi) + J phi''
    J, m, r = 0.3, 2.0, 0.5
    system = lp.assemble(drive(a=Inertia(J=J), crank=Yoke(r=r), piston=translation.Mass(m=m)))
    motion = {"piston.s": r * sin(0.8 * sin(lp.time))}
    run = lp.inverse(system, motion=motion, drive="motor.tau", until=3.0)
    phi, w, a = 0.8 * np.sin(run.t), 0.8 * np.cos(run.t), -0.8 * np.sin(run.t)
    force = m * r * (np.cos(phi) * a - np.sin(phi) * w**2)
    assert worst(run["a.phi"], phi) < 1e-12
    assert worst(run["motor.tau"], J * a + r * np.cos(phi) * force) < 1e-10


def test_parameters_and_start_values_change_a_run():
    system = two_masses()
    motion = {"a.w": 0.0}
    run = lp.inverse(
        system,
        motion=motion,
        drive="motor.tau",
        until=0.5,
        parameters={"b.J": 3.0},
        start={"b.w": 2.0},
        rtol=1e-10,
    )
    # the load swings against a motor that is held: c x, x = 2 / w sin(w t)
    w = np.sqrt(C / 3.0)
    assert worst(run["motor.tau"], -C * 2 / w * np.sin(w * run.t)) < 1e-7
    with pytest.raises(StartError, match=r"a\.w"):
        lp.inverse(system, motion=motion, drive="motor.tau", until=0.5, start={"a.w": 1.0})
    with pytest.raises(UnknownNameError, match=r"motor\.tau"):
        lp.inverse(
            system, motion=motion, drive="motor.tau", until=0.5, parameters={"motor.tau": 1.0}
        )


def refuses(kind, system, motion, drives, *words):
    refused(kind, lambda: lp.inverse(system, motion=motion, drive=drives, until=1.0), *words)


def test_a_motion_that_is_not_smooth_enough_is_refused_where_it_kinks():
    speed = where(lp.time >= 0.5, 1.0, 2 * lp.time)
    rigid = lp.assemble(drive(a=Inertia(J=2.0)))
    run = lp.inverse(rigid, motion={"a.w": speed}, drive="motor.tau", until=1.0)
    assert worst(run["motor.tau"], np.where(np.arange(len(run.t)) <= 250, 4.0, 0.0)) < 1e-13
    words = (
        "b.a would have to jump from 2 to 0 at t = 0.5 s",
        "behind a spring none of acceleration and jerk",
    )
    refuses(SolverError, two_masses(), {"b.w": speed}, "motor.tau", *words)


class Lever(lp.Component):
    """A force on a lever that passes its dead centre at 1 s."""

    flange = lp.Flange()
    u: lp.Input = lp.Input("N", "force")

    def equations(self):
        yield self.flange.tau == -self.u * (lp.time - 1.0)


def test_a_run_through_a_dead_centre_is_refused_and_kept_up_to_there():
    system = lp.assemble(in_a_row(motor=Lever(u=0.0), b=Inertia(J=J_B)))
    with pytest.raises(SolverError, match=r"t = 1 s.*as at a dead centre") as fault:
        lp.inverse(system, motion={"b.w": 3 * lp.time}, drive="motor.u", until=2.0, grid=20)
    run = fault.value.partial
    assert run.t[-1] == 1.0
    assert worst(run["motor.u"][:-1], 3 * J_B / (run.t[:-1] - 1)) < 1e-12


def test_a_drive_that_does_not_act_on_the_motion_is_refused():
    parts = {"motor": Torque(tau=0.0), "a": Inertia(J=1.0)}
    parts |= {"other": Torque(tau=3.0), "b": Inertia(J=1.0)}
    apart = assemble_rows("motor a", "other b", **parts)
    words = "motor.tau cannot bring about a prescribed b.w", "other.tau = 3"
    refuses(SingularModelError, apart, {"b.w": 1.0}, "motor.tau", *words)


@pytest.mark.parametrize(
    "part", [Clutch(f_max=10.0, u=1.0, characteristic=((0.0, 0.5),)), Backlash(b=0.1)]
)
def test_what_slips_or_opens_between_drive_and_motion_is_refused(part):
    system = two_masses(shaft=part)
    words = "motor.tau cannot bring about a prescribed b.w", "friction, a clutch or play"
    refuses(SingularModelError, system, {"b.w": sin(lp.time)}, "motor.tau", *words)
    # on the side of the drive the motion is free to choose
    run = lp.inverse(system, motion={"a.w": sin(lp.time)}, drive="motor.tau", until=0.2)
    assert worst(run["a.a"], np.cos(run.t)) < 1e-13


@pytest.mark.parametrize("law", [profiles.polynomial5, profiles.polynomial7])
def test_friction_carries_nothing_while_the_motion_stands_still(law):
    parts = {"a": Inertia(J=1.0), "f": BearingFriction(characteristic=((0, 3.0),))}
    system = lp.assemble(drive(**parts, load=Torque(tau=-10.0)), keep=["a.phi"])
    moves = law(1.0, 0.5), profiles.dwell(0.2), law(-1.0, 0.5), profiles.dwell(0.2)
    motion = {"a.phi": profiles.path(*moves)}
    run = lp.inverse(system, motion=motion, drive="motor.tau", until=1.4, grid=140)
    rests = ((run.t > 0.501) & (run.t < 0.699)) | (run.t > 1.201)
    assert run["f.tau"][rests] == pytest.approx(0.0, abs=1e-9)
    assert run["motor.tau"][rests] == pytest.approx(10.0, abs=1e-9)
    first, back = (run.t > 0.001) & (run.t < 0.499), (run.t > 0.701) & (run.t < 1.199)
    assert run["f.tau"][first] == pytest.approx(3.0)
    assert run["f.tau"][back] == pytest.approx(-3.0)


def test_dry_friction_behind_a_spring_is_refused():
    system = lp.assemble(
        drive(
            a=Inertia(J=1.0),
            shaft=Spring(c=C),
            b=Inertia(J=1.0),
            f=BearingFriction(characteristic=FRICTION),
        )
    )
    motion = {"b.w": 2.0 + sin(lp.time)}
    refuses(SingularModelError, system, motion, "motor.tau", "dry friction behind a spring")


def test_dry_friction_behind_a_damped_coupling_is_refused_for_its_reason():
    system = lp.assemble(
        drive(
            a=Inertia(J=1.0),
            shaft=SpringDamper(c=300.0, d=0.05),
            b=Inertia(J=2.0),
            f=BearingFriction(characteristic=FRICTION),
            gear=IdealGear(ratio=2.0),
            load=Inertia(J=1.0),
        ),
        keep=["b.phi"],
    )
    motion = {"b.phi": profiles.path(profiles.polynomial7(1.0, 0.5))}
    refuses(SingularModelError, system, motion, "motor.tau", "dry friction behind a spring")


@pytest.mark.parametrize(
    ("kind", "motion", "drives", "words"),
    [
        (
            *(OptionError, {"b.w": 1.0, "a.w": 1.0}, "motor.tau"),
            ["2 motions (b.w, a.w) and 1 drives (motor.tau)"],
        ),
        (OptionError, {"b.w": 1.0}, [], ["drives (none)"]),
        (
            *(OptionError, {"b.w": 1.0, "a.w": 1.0}, ["motor.tau"] * 2),
            ["each motion needs a drive of its own"],
        ),
        (
            *(OptionError, {"b.w": 1.0}, "a.w"),
            ["a.w (angular velocity, rad/s) of a (Inertia) is not an input", "motor.tau"],
        ),
        (OptionError, {"b.w": "fast"}, "motor.tau", ["b.w = 'fast'", "rad/s"]),
        (OptionError, {"b.w": "3"}, "motor.tau", ["b.w = '3'", "rad/s"]),
        (OptionError, {"b.w": float("nan")}, "motor.tau", ["finite"]),
        (UnknownNameError, {"b.omega": 1.0}, "motor.tau", ["b.omega"]),
        (UnknownNameError, {"b.w": 1.0}, "motor.torque", ["motor.torque"]),
    ],
)
def test_slips_in_the_call_are_named(kind, motion, drives, words):
    refuses(kind, two_masses(), motion, drives, *words)
