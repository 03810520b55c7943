"""A positioning drive: position, speed and current control in cascade, against SciPy."""

import numpy as np
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import (
    AngleSensor,
    CurrentController,
    CurrentSensor,
    DCMotor,
    Filter,
    Gain,
    Ground,
    Inertia,
    Inverter,
    LimitedPI,
    Limiter,
    RateLimiter,
    Resistor,
    SpeedSensor,
    SpringDamper,
    SquareRootController,
    VoltageSource,
)

K, R, L, J_M, J_L, C, D = 0.64, 0.05, 1.5e-3, 0.15, 0.2, 4e3, 1.0
AIM, V_MAX, A, GAIN = 20.0, 60.0, 150.0, 12.0


class Axis(lp.Component):
    """Motor, elastic shaft and load under three controllers; the battery has a resistance."""

    position: SquareRootController = SquareRootController(K=GAIN, a=A, wanted=AIM)
    most: Limiter = Limiter(y_min=-V_MAX, y_max=V_MAX)
    slope: RateLimiter = RateLimiter(rate=400.0, T=2e-3)
    speed: LimitedPI = LimitedPI(k=30.0, T_i=0.05, y_min=-120.0, y_max=120.0)
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
        yield lp.connect(self.position.y, self.most.u)
        yield lp.connect(self.most.y, self.slope.u)
        yield lp.connect(self.slope.y, self.speed.wanted)
        yield lp.connect(self.speed.y, self.amperes.u)
        yield lp.connect(self.amperes.y, self.current.wanted)
        yield lp.connect(self.current.y, self.inverter.v)
        yield lp.connect(self.inverter.v_dc, self.current.limit)
        yield lp.connect(self.ammeter.i, self.measured.u)
        yield lp.connect(self.measured.y, self.current.measured)
        yield lp.connect(self.tacho.w, self.speed.measured, self.induced.u)
        yield lp.connect(self.induced.y, self.current.feed)
        yield lp.connect(self.turns.phi, self.position.measured)
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
    slope, x_w, x_i, v_out, v_f, i_f, i, w, twist, w_l, phi = x
    e = AIM - phi
    e_0 = A / GAIN**2
    fast = np.sign(e) * np.sqrt(2 * A * max(abs(e) - e_0 / 2, 0.0))
    wanted = np.clip(GAIN * e if abs(e) <= e_0 else fast, -V_MAX, V_MAX)
    u_w = 30.0 * (slope - w + x_w)
    torque = np.clip(u_w, -120.0, 120.0)
    e_i = torque / K - i_f
    u_i = 0.6 * (e_i + x_i) + K * w
    v = np.clip(u_i, -v_f, v_f)
    i_dc = (120.0 - np.sqrt(120.0**2 - 4 * 0.02 * v_out * i)) / (2 * 0.02)
    tau = C * twist + D * (w_l - w)
    return [
        np.clip((wanted - slope) / 2e-3, -400.0, 400.0),
        (slope - w + (torque - u_w) / 30.0) / 0.05,
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
    *("slope.y", "speed.x", "current.x", "inverter.v_out", "inverter.v_f", "measured.y"),
    *("motor.i", "motor.w", "shaft.phi_rel", "load.w", "turns.phi"),
)


def test_a_positioning_drive_follows_another_integrator():
    t = np.linspace(0.0, 1.5, 151)
    start = np.zeros(11)
    start[4] = 120.0
    expected = solve_ivp(
        rates, (0, 1.5), start, "DOP853", t, rtol=1e-9, atol=1e-10, max_step=2e-4
    ).y
    run = lp.simulate(lp.assemble(Axis()), until=1.5, grid=t, rtol=1e-9)
    print(run)
    for name, values in zip(NAMES, expected, strict=True):
        error = np.abs(run[name] - values).max() / np.ptp(values)
        print(f"{name}: largest error {error:.1e} of the range")
        assert error <= 2e-6
    assert abs(run["turns.phi"][-1] - AIM) < 1e-3
    met = {event.component for event in run.events}
    assert {"most", "speed"} <= met
