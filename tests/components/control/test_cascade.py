"""Positioning drives: position, speed and current control in cascade, against closed forms."""

import numpy as np
import pytest
from rows import assemble_rows
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import lumped as lp
from lumped.components import (
    AngleSensor,
    CascadeControl,
    CurrentController,
    CurrentSensor,
    DCMotor,
    Filter,
    Gain,
    Ground,
    Inertia,
    Inverter,
    PointToPoint,
    Resistor,
    SpeedSensor,
    SpringDamper,
    Torque,
    VoltageSource,
)

K, R, L, J_M, J_L, C, D = 0.64, 0.05, 1.5e-3, 0.15, 0.2, 4e3, 1.0
AIM, V_MAX, A, GAIN = 20.0, 60.0, 150.0, 12.0


def axis():
    """Motor, elastic shaft and load under three controllers; the battery has a resistance."""
    feed = {"v_feed": 0.0, "f_feed": 0.0}
    return assemble_rows(
        *("control.y amperes.u", "amperes.y current.wanted", "current.y inverter.v"),
        *("inverter.v_dc current.limit", "ammeter.i measured.u", "measured.y current.measured"),
        *("tacho.w control.v_measured induced.u", "induced.y current.feed"),
        *("turns.phi control.measured", "battery.p inside.p", "inside.n inverter.dc_p"),
        *("inverter.p ammeter.p", "ammeter.n motor.p", "motor turns tacho", "motor shaft load"),
        "battery.n inverter.dc_n inverter.n motor.n ground.pin",
        control=CascadeControl(
            wanted=AIM, K=GAIN, a=A, v_max=V_MAX, k=30.0, T_i=0.05, f_max=120.0, **feed
        ),
        amperes=Gain(k=1 / K),
        current=CurrentController(k=0.6, T_i=0.03),
        induced=Gain(k=K),
        battery=VoltageSource(v=120.0),
        inside=Resistor(R=0.02),
        inverter=Inverter(T_d=2.5e-4, T_f=1e-3, v_f=120.0),
        ammeter=CurrentSensor(),
        measured=Filter(T=1e-3),
        motor=DCMotor(k=K, R=R, L=L, J=J_M),
        ground=Ground(),
        shaft=SpringDamper(c=C, d=D),
        load=Inertia(J=J_L),
        turns=AngleSensor(),
        tacho=SpeedSensor(),
    )


def rates(_, x):
    """The same by hand; the battery current is the smaller root of the balance of power."""
    x_w, x_i, v_out, v_f, i_f, i, w, twist, w_l, phi = x
    e = AIM - phi
    e_0 = A / GAIN**2
    fast = np.sign(e) * np.sqrt(2 * A * max(abs(e) - e_0 / 2, 0.0))
    wanted = np.clip(GAIN * e if abs(e) <= e_0 else fast, -V_MAX, V_MAX)
    u_w = 30.0 * (wanted - w + x_w)
    torque = np.clip(u_w, -120.0, 120.0)
    e_i = torque / K - i_f
    u_i = 0.6 * (e_i + x_i) + K * w
    v = np.clip(u_i, -v_f, v_f)
    i_dc = (120.0 - np.sqrt(120.0**2 - 4 * 0.02 * v_out * i)) / (2 * 0.02)
    tau = C * twist + D * (w_l - w)
    return [
        (wanted - w + (torque - u_w) / 30.0) / 0.05,
        (e_i + (v - u_i) / 0.6) / 0.03,
        (v - v_out) / 2.5e-4,
        (120.0 - 0.02 * i_dc - v_f) / 1e-3,
        (i - i_f) / 1e-3,
        (v_out - R * i - K * w) / L,
        (K * i + tau) / J_M,
        w_l - w,
        -tau / J_L,
        w,
    ]


NAMES = (
    *("control.speed.x", "current.x", "inverter.v_out", "inverter.v_f", "measured.y"),
    *("motor.i", "motor.w", "shaft.phi_rel", "load.w", "turns.phi"),
)


def test_a_positioning_drive_follows_another_integrator():
    t = np.linspace(0.0, 1.5, 151)
    start = np.zeros(10)
    start[3] = 120.0
    expected = solve_ivp(
        rates, (0, 1.5), start, "DOP853", t, rtol=1e-9, atol=1e-10, max_step=1e-3
    ).y
    run = lp.simulate(axis(), until=1.5, grid=t, rtol=1e-9)
    print(run)
    for name, values in zip(NAMES, expected, strict=True):
        error = np.abs(run[name] - values).max() / np.ptp(values)
        print(f"{name}: largest error {error:.1e} of the range")
        assert error <= 2e-6
    assert abs(run["turns.phi"][-1] - AIM) < 1e-3
    met = {event.component for event in run.events}
    assert {"control.most", "control.speed"} <= met


J, FAR = 0.5, {"K": 8.0, "v_max": 1e3, "k": 20.0, "T_i": 0.3, "f_max": 1e4}


def table(move, v=1.0, f=J, load=0.0, **control):
    """A rigid drive under cascade control that follows a move and is told shares of its rates."""
    return assemble_rows(
        *("move.s control.wanted", "move.v speed.u", "speed.y control.v_feed"),
        *("move.a torque.u", "torque.y control.f_feed", "control.y drive.tau"),
        *("turns.phi control.measured", "tacho.w control.v_measured"),
        "drive load body turns tacho",
        move=move,
        speed=Gain(k=v),
        torque=Gain(k=f),
        control=CascadeControl(**(FAR | control)),
        drive=Torque(),
        load=Torque(tau=load),
        body=Inertia(J=J),
        turns=AngleSensor(),
        tacho=SpeedSensor(),
    )


def test_with_the_move_fed_forward_a_rigid_drive_follows_without_error():
    move = PointToPoint(distance=3.0, v_max=2.0, a_max=6.0, start_time=0.1)
    run = lp.simulate(table(move), until=3.0, grid=300, rtol=1e-10)
    assert run["turns.phi"] == pytest.approx(run["move.s"], abs=1e-9)
    assert run["turns.phi"][-1] == pytest.approx(3.0, abs=1e-9)
    cruising = (run.t > 0.5) & (run.t < 1.5)
    late = lp.simulate(table(move, v=0.0, f=0.0), until=3.0, grid=run.t, rtol=1e-10)
    lag = (late["move.s"] - late["turns.phi"])[cruising]
    assert lag[-1] == pytest.approx(2.0 / FAR["K"], rel=0.05)  # v / K, once transients are gone


def test_within_its_limits_a_cascade_is_a_linear_system():
    """A step of the load: ``der(x) = A x + b`` for angle, speed and integral part."""
    K, k, T_i = (FAR[name] for name in ("K", "k", "T_i"))
    A = np.array([[0, 1, 0], [-k * K / J, -k / J, k / J], [-K / T_i, -1 / T_i, 0]])
    steady = np.linalg.solve(A, [0, -5.0 / J, 0])
    t = np.linspace(0.0, 2.0, 81)
    expected = np.array([(expm(A * s) - np.eye(3)) @ steady for s in t])
    still = PointToPoint(distance=0.0, v_max=1.0, a_max=1.0)
    run = lp.simulate(table(still, load=-5.0), until=2.0, grid=t, rtol=1e-10)
    for name, values in zip(("turns.phi", "body.w", "control.speed.x"), expected.T, strict=True):
        assert np.abs(run[name] - values).max() < 1e-8 * np.abs(values).max()


def test_a_long_step_runs_at_its_limits_of_speed_and_torque_as_another_integrator_says():
    step = PointToPoint(distance=6.0, v_max=1e6, a_max=1e9, start_time=-1.0)
    t = np.linspace(0.0, 3.0, 121)

    def rates(_, y):
        phi, w, x = y
        v = np.clip(8.0 * (6.0 - phi), -4.0, 4.0)
        u = 20.0 * (v - w + x)
        f = np.clip(u, -6.0, 6.0)
        return [w, f / J, (v - w + (f - u) / 20.0) / 0.3]

    expected = solve_ivp(
        rates, (0, 3), [0, 0, 0], "DOP853", t, rtol=1e-10, atol=1e-11, max_step=1e-3
    ).y
    system = table(step, v=0.0, f=0.0, v_max=4.0, f_max=6.0)
    run = lp.simulate(system, until=3.0, grid=t, rtol=1e-10)
    assert run["turns.phi"] == pytest.approx(expected[0], abs=1e-6)
    assert run["body.w"] == pytest.approx(expected[1], abs=1e-6)
    met = {event.component for event in run.events}
    assert {"control.most", "control.speed"} <= met
