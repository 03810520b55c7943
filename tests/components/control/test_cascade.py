"""Positioning drives: position, speed and current control in cascade, against closed forms."""

import numpy as np
import pytest
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


class Axis(lp.Component):
    """Motor, elastic shaft and load under three controllers; the battery has a resistance."""

    control: CascadeControl = CascadeControl(
        wanted=AIM, K=GAIN, a=A, v_max=V_MAX, k=30.0, T_i=0.05, f_max=120.0, v_feed=0.0, f_feed=0.0
    )
    amperes: Gain = Gain(k=1 / K)
    current: CurrentController = CurrentController(k=0.6, T_i=0.03)
    induced: Gain = Gain(k=K)
    battery: VoltageSource = VoltageSource(v=120.0)
    inside: Resistor = Resistor(R=0.02)
    inverter: Inverter = Inverter(T_d=2.5e-4, T_f=1e-3, v_f=120.0)
    ammeter: CurrentSensor = CurrentSensor()
    measured: Filter = Filter(T=1e-3)
    motor: DCMotor = DCMotor(k=K, R=R, L=L, J=J_M)
    ground: Ground = Ground()
    shaft: SpringDamper = SpringDamper(c=C, d=D)
    load: Inertia = Inertia(J=J_L)
    turns: AngleSensor = AngleSensor()
    tacho: SpeedSensor = SpeedSensor()

    def connections(self):
        yield lp.connect(self.control.y, self.amperes.u)
        yield lp.connect(self.amperes.y, self.current.wanted)
        yield lp.connect(self.current.y, self.inverter.v)
        yield lp.connect(self.inverter.v_dc, self.current.limit)
        yield lp.connect(self.ammeter.i, self.measured.u)
        yield lp.connect(self.measured.y, self.current.measured)
        yield lp.connect(self.tacho.w, self.control.v_measured, self.induced.u)
        yield lp.connect(self.induced.y, self.current.feed)
        yield lp.connect(self.turns.phi, self.control.measured)
        yield lp.connect(self.battery.p, self.inside.p)
        yield lp.connect(self.inside.n, self.inverter.dc_p)
        yield lp.connect(self.inverter.p, self.ammeter.p)
        yield lp.connect(self.ammeter.n, self.motor.p)
        returns = (self.battery.n, self.inverter.dc_n, self.inverter.n, self.motor.n)
        yield lp.connect(*returns, self.ground.pin)
        yield from lp.chain(self.motor.flange, self.shaft, self.load)
        yield lp.connect(self.motor.flange, self.turns.flange, self.tacho.flange)


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
    run = lp.simulate(lp.assemble(Axis()), until=1.5, grid=t, rtol=1e-9)
    print(run)
    for name, values in zip(NAMES, expected, strict=True):
        error = np.abs(run[name] - values).max() / np.ptp(values)
        print(f"{name}: largest error {error:.1e} of the range")
        assert error <= 2e-6
    assert abs(run["turns.phi"][-1] - AIM) < 1e-3
    met = {event.component for event in run.events}
    assert {"control.most", "control.speed"} <= met


J, FAR = 0.5, {"K": 8.0, "v_max": 1e3, "k": 20.0, "T_i": 0.3, "f_max": 1e4}


class Table(lp.Component):
    """A rigid drive under cascade control that follows a move; `known` is what it is told of it."""

    move: PointToPoint = PointToPoint(distance=3.0, v_max=2.0, a_max=6.0, start_time=0.1)
    known: list[Gain] = [Gain(k=1.0), Gain(k=J)]  # noqa: RUF012
    control: CascadeControl = CascadeControl(**FAR)
    drive: Torque = Torque()
    load: Torque = Torque(tau=0.0)
    body: Inertia = Inertia(J=J)
    turns: AngleSensor = AngleSensor()
    tacho: SpeedSensor = SpeedSensor()

    def connections(self):
        yield lp.connect(self.move.s, self.control.wanted)
        yield lp.connect(self.move.v, self.known[0].u)
        yield lp.connect(self.move.a, self.known[1].u)
        yield lp.connect(self.known[0].y, self.control.v_feed)
        yield lp.connect(self.known[1].y, self.control.f_feed)
        yield lp.connect(self.control.y, self.drive.tau)
        yield lp.connect(self.drive.flange, self.load.flange, self.body.flange_a)
        yield lp.connect(self.body.flange_b, self.turns.flange, self.tacho.flange)
        yield lp.connect(self.turns.phi, self.control.measured)
        yield lp.connect(self.tacho.w, self.control.v_measured)


def test_with_the_move_fed_forward_a_rigid_drive_follows_without_error():
    run = lp.simulate(lp.assemble(Table()), until=3.0, grid=300, rtol=1e-10)
    assert run["turns.phi"] == pytest.approx(run["move.s"], abs=1e-9)
    assert run["turns.phi"][-1] == pytest.approx(3.0, abs=1e-9)
    cruising = (run.t > 0.5) & (run.t < 1.5)
    blind = Table(known=[Gain(k=0.0), Gain(k=0.0)])
    late = lp.simulate(lp.assemble(blind), until=3.0, grid=run.t, rtol=1e-10)
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
    model = Table(load=Torque(tau=-5.0), move=still)
    run = lp.simulate(lp.assemble(model), until=2.0, grid=t, rtol=1e-10)
    for name, values in zip(("turns.phi", "body.w", "control.speed.x"), expected.T, strict=True):
        assert np.abs(run[name] - values).max() < 1e-8 * np.abs(values).max()


def test_a_long_step_runs_at_its_limits_of_speed_and_torque_as_another_integrator_says():
    control = CascadeControl(K=8.0, v_max=4.0, k=20.0, T_i=0.3, f_max=6.0)
    step = PointToPoint(distance=6.0, v_max=1e6, a_max=1e9)
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
    blind = [Gain(k=0.0), Gain(k=0.0)]
    model = Table(control=control, known=blind, move=step.with_({"start_time": -1.0}))
    run = lp.simulate(lp.assemble(model), until=3.0, grid=t, rtol=1e-10)
    assert run["turns.phi"] == pytest.approx(expected[0], abs=1e-6)
    assert run["body.w"] == pytest.approx(expected[1], abs=1e-6)
    met = {event.component for event in run.events}
    assert {"control.most", "control.speed"} <= met
