"""Motors and converter drives against closed forms, other integrators and energy balances."""

import numpy as np
import pytest
from checks import assert_close
from rows import assemble_row, assemble_rows
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    ConverterDrive,
    DCMotor,
    Ground,
    InductionMotor,
    Inertia,
    LoadShare,
    QuadraticTorque,
    QuasiStaticDCMotor,
    SeparatelyExcitedDCMotor,
    SeriesDCMotor,
    SpeedDrive,
    SpringDamper,
    Sum,
    Torque,
    VoltageSource,
)

RATED = {"k": 0.6366, "R": 0.05, "L": 1.5e-3, "J": 0.3}


def fan(c):
    """Load that grows with the square of the speed: ``tau = c w |w|``."""
    return QuadraticTorque(tau_nominal=-c, w_nominal=1.0)


class Fed(lp.Component):
    """A motor on a voltage, with a torque on its shaft, and what becomes of the energy."""

    source: VoltageSource = VoltageSource(v=100.0)
    ground: Ground = Ground()
    motor: lp.Component = DCMotor(**RATED)
    load: lp.Component = Torque(tau=-20.0)

    def connections(self):
        yield lp.connect(self.source.p, self.motor.p)
        yield lp.connect(self.source.n, self.motor.n, self.ground.pin)
        yield lp.connect(self.motor.flange, self.load.flange)


def linear(A, b, t):
    """Solution of ``der(x) = A x + b`` from zero."""
    steady = np.linalg.solve(A, b)
    return np.array([(expm(A * s) - np.eye(len(b))) @ steady for s in t])


@pytest.mark.parametrize("method", ["explicit", "implicit"])
@pytest.mark.parametrize("L", [1.5e-3, 0.05])  # overdamped, oscillating
def test_a_motor_on_a_voltage_follows_the_matrix_exponential(L, method):
    t = np.linspace(0.0, 1.0, 81)
    k, R, J = RATED["k"], RATED["R"], RATED["J"]
    A = np.array([[-R / L, -k / L], [k / J, 0.0]])
    expected = linear(A, np.array([100.0 / L, -20.0 / J]), t)
    system = lp.assemble(Fed(motor=DCMotor(**{**RATED, "L": L})))
    run = lp.simulate(system, until=1.0, grid=t, rtol=1e-10, method=method)
    assert_close(run["motor.i"], expected[:, 0], 1e-8, "current")
    assert_close(run["motor.w"], expected[:, 1], 1e-8, "speed")


def test_a_time_constant_of_a_microsecond_is_followed():
    """Beside a mechanical time constant of 37 ms: 1 to 37 000."""
    t = np.concatenate([[0.0], np.geomspace(1e-7, 1.0, 60)])
    k, R, J, L = RATED["k"], RATED["R"], RATED["J"], RATED["R"] * 1e-6
    slow, fast = sorted(np.abs(np.roots([1.0, R / L, k**2 / (L * J)]).real))
    # der(der(w)) + R/L der(w) + k^2/(L J) w = k v / (L J), from w = 0 and der(w) = 0
    final = 100.0 / k
    w = final * (1 - (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow))
    i = J / k * final * fast * slow / (fast - slow) * (np.exp(-slow * t) - np.exp(-fast * t))
    system = lp.assemble(Fed(motor=DCMotor(**{**RATED, "L": L}), load=Torque(tau=0.0)))
    run = lp.simulate(system, until=1.0, grid=t, rtol=1e-9)
    print(run.statistics)
    assert_close(run["motor.i"], i, 1e-6, "current")
    assert_close(run["motor.w"], w, 1e-7, "speed")
    assert run.statistics.method == "exact"
    for rtol, most in ((1e-6, 150), (1e-9, 500)):  # a million microseconds
        stepped = lp.simulate(system, until=1.0, rtol=rtol, method="steps")
        assert stepped.statistics.steps < most


def test_without_inductance_the_speed_rises_as_an_exponential():
    t = np.linspace(0.0, 0.5, 41)
    k, R, J = RATED["k"], RATED["R"], RATED["J"]
    rate, final = k**2 / (R * J), 100.0 / k - 20.0 * R / k**2
    motor = QuasiStaticDCMotor(k=k, R=R, J=J)
    run = lp.simulate(lp.assemble(Fed(motor=motor)), until=0.5, grid=t, rtol=1e-10)
    w = final * (1 - np.exp(-rate * t))
    assert_close(run["motor.w"], w, 1e-9, "speed")
    assert_close(run["motor.i"], (100.0 - k * w) / R, 1e-9, "current")


def test_a_series_motor_with_a_fan_settles_where_voltage_and_torque_balance():
    k, R, c, V = 0.0063, 0.06, 0.0029, 100.0
    motor = SeriesDCMotor(k=k, R=R, L=2e-3, J=0.15)
    system = lp.assemble(Fed(motor=motor, load=fan(c)))
    # k i^2 = c w^2, so i = w sqrt(c / k); V = R i + k i w
    ratio = np.sqrt(c / k)
    w = brentq(lambda w: R * ratio * w + k * ratio * w**2 - V, 1.0, 1e4, xtol=1e-13)
    run = lp.simulate(system, until=60.0, grid=[60.0], rtol=1e-9)
    found = lp.equilibrium(system, start={"motor.w": 100.0, "motor.i": 50.0})
    for what, values in (("run", run), ("equilibrium", found)):
        assert_close(np.atleast_1d(values["motor.w"])[-1], w, 1e-8, f"speed, {what}")
        assert_close(np.atleast_1d(values["motor.i"])[-1], ratio * w, 1e-8, f"current, {what}")


class Shunt(Fed):
    """A motor with its field on the same pins."""

    motor: SeparatelyExcitedDCMotor = SeparatelyExcitedDCMotor(
        k=0.4, R=0.05, L=1.5e-3, R_f=60.0, L_f=12.0, J=0.3
    )

    def connections(self):
        yield from super().connections()
        yield lp.connect(self.source.p, self.motor.field_p)
        yield lp.connect(self.source.n, self.motor.field_n)


def test_a_shunt_motor_follows_another_integrator():
    t = np.linspace(0.0, 2.0, 101)
    k, R, L, R_f, L_f, J, V, load = 0.4, 0.05, 1.5e-3, 60.0, 12.0, 0.3, 100.0, 20.0

    def rates(_, x):
        i, w, i_f = x
        return [(V - R * i - k * i_f * w) / L, (k * i_f * i - load) / J, (V - R_f * i_f) / L_f]

    expected = solve_ivp(rates, (0, 2), [0, 0, 0], "DOP853", t, rtol=1e-11, atol=1e-11).y
    run = lp.simulate(lp.assemble(Shunt()), until=2.0, grid=t, rtol=1e-10)
    for name, values in zip(("motor.i", "motor.w", "motor.i_f"), expected, strict=True):
        assert_close(run[name], values, 1e-8, name)


# -- induction motor ---------------------------------------------------------------------------


@pytest.mark.parametrize("a", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("w_s", [157.08, -104.72])
def test_an_induction_motor_starts_along_the_curve_of_kloss(a, w_s):
    t = np.linspace(0.0, 1.5, 101)
    s_k, tau_k, J, c = 0.2, 60.0, 0.05, 4e-4

    def rates(_, w):
        s = 1 - w / w_s
        torque = 2 * tau_k * (1 + a * s_k) / (s / s_k + s_k / s + 2 * a * s_k)
        return (np.sign(w_s) * torque - c * w * np.abs(w)) / J

    expected = solve_ivp(rates, (0, 1.5), [0.0], "DOP853", t, rtol=1e-12, atol=1e-11).y[0]
    motor = InductionMotor(w_s=w_s, tau_k=tau_k, s_k=s_k, a=a, J=J)
    run = lp.simulate(assemble_row(motor=motor, load=fan(c)), until=1.5, grid=t, rtol=1e-10)
    assert_close(run["motor.w"], expected, 1e-8, "speed")


# -- converter drives --------------------------------------------------------------------------


def test_a_converter_drive_keeps_to_constant_torque_and_constant_power():
    t = np.linspace(0.0, 3.0, 121)

    def rates(at, x):
        w, tau = x
        limit = min(50.0, 3000.0 / max(abs(w), 1e-9))
        wanted = 80.0 if at < 2.0 else 5.0
        return [tau / 0.5, (min(wanted, limit) - tau) / 0.01]

    first = solve_ivp(rates, (0, 2 - 1e-14), [0, 0], "DOP853", t[:80], rtol=1e-11, atol=1e-10)
    at_two = solve_ivp(rates, (0, 2 - 1e-14), [0, 0], "DOP853", rtol=1e-11, atol=1e-10).y[:, -1]
    second = solve_ivp(rates, (2, 3), at_two, "DOP853", t[80:], rtol=1e-11, atol=1e-10)
    expected = np.hstack([first.y, second.y])
    wanted = lp.ops.table([0.0, 2.0, 2.0], [80, 80, 5])
    drive = ConverterDrive(tau_max=50.0, P_max=3000.0, T=0.01, J=0.1, wanted=wanted)
    system = assemble_row(drive=drive, body=Inertia(J=0.4))
    run = lp.simulate(system, until=3.0, grid=t, rtol=1e-10)
    assert_close(run["drive.w"], expected[0], 1e-7, "speed")
    assert_close(run["drive.tau"], expected[1], 1e-6, "torque")
    power = (run["drive.tau"] * run["drive.w"])[60:80]
    assert power == pytest.approx(3000.0, rel=0.02)  # the loop lags by 10 ms


def shared(right, *rows, **more):
    """Two speed-controlled drives on the ends of one shaft, and a load at the right one."""
    given = {"tau_max": 500.0, "P_max": 1e5, "T": 5e-3, "J": 1.0, "k": 50.0, "T_i": 0.2}
    return assemble_rows(
        "left shaft right load",
        *rows,
        left=SpeedDrive(wanted=100.0, droop=0.01, **given),
        right=SpeedDrive(droop=0.03, **given, **right),
        shaft=SpringDamper(c=1e5, d=50.0),
        load=Torque(tau=-240.0),
        **more,
    )


def test_droop_shares_a_load_against_the_slopes_of_the_drives():
    run = lp.simulate(shared({"wanted": 100.0}), until=20.0, grid=[20.0], rtol=1e-9)
    received = [run[f"{name}.tau"][-1] for name in ("left", "right")]
    expected = pytest.approx([180.0, 60.0], rel=1e-6)  # 0.01 tau_l = 0.03 tau_r, sum 240
    assert received == expected
    assert run["left.w"][-1] == pytest.approx(100.0 - 0.01 * 180.0, rel=1e-8)


def test_a_load_share_trim_brings_the_torques_to_their_shares():
    system = shared(
        {},
        *("left.tau_meas trim.other", "right.tau_meas trim.own"),
        *("trim.y wanted.b", "wanted.y right.wanted"),
        wanted=Sum(a=100.0),
        trim=LoadShare(share=0.4, k=0.002, T_i=0.1, y_max=5.0),
    )
    run = lp.simulate(system, until=60.0, grid=[60.0], rtol=1e-9)
    received = [run[f"{name}.tau"][-1] for name in ("left", "right")]
    assert received == pytest.approx([144.0, 96.0], rel=1e-6)
    # left: w = 100 - 0.01 144; right: w = 100 + y - 0.03 96
    assert run["trim.y"][-1] == pytest.approx(0.03 * 96 - 0.01 * 144, rel=1e-6)


def test_a_speed_drive_does_not_wind_up_at_its_limit():
    """After a start at the torque limit the overshoot is that of the linear control alone."""
    drive = SpeedDrive(
        wanted=100.0, tau_max=50.0, P_max=1e6, T=1e-3, J=1.0, k=50.0, T_i=0.2, phi=0.0
    )
    run = lp.simulate(lp.assemble(lp.compose(drive=drive)), until=6.0, grid=3000, rtol=1e-8)
    limited = [e for e in run.events if e.component == "drive"]
    received = run["drive.w"].max()
    assert limited
    assert received < 101.0  # 190 without back calculation
    assert run["drive.w"][-1] == pytest.approx(100.0, abs=1e-6)
