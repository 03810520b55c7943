"""Torque converters and fluid couplings against published points, roots and own integration."""

import numpy as np
import pytest
import scipy
from rows import assemble_row, assemble_rows

import lumped as lp
from lumped.components import (
    Clutch,
    FluidCoupling,
    Inertia,
    QuadraticTorque,
    Speed,
    Torque,
    TorqueConverter,
)
from lumped.errors import EquationError

# speed ratio, torque ratio, torque at 1000 1/min: test data of VECTO, European Commission
MEASURED = np.array(
    [
        *((0.0, 1.80, 377.80), (0.1, 1.71, 365.21), (0.2, 1.61, 352.62), (0.3, 1.52, 340.02)),
        *((0.4, 1.42, 327.43), (0.5, 1.33, 314.84), (0.6, 1.23, 302.24), (0.7, 1.14, 264.46)),
        *((0.8, 1.04, 226.68), (0.9, 1.02, 188.90), (1.0, 1.00, 0.00), (1.1, 0.999, -40.34)),
        *((1.222, 0.998, -80.34), (1.375, 0.997, -136.11), (1.571, 0.996, -216.52)),
        *((1.833, 0.995, -335.19), (2.2, 0.994, -528.77), (2.75, 0.993, -883.40)),
        *((4.4, 0.992, -2462.17), (11.0, 0.991, -16540.98)),
    ]
)
RPM = np.pi / 30
NU, MU, C = MEASURED.T / np.array([[1.0], [1.0], [(1000 * RPM) ** 2]])
ROWS = tuple(zip(NU.tolist(), MU.tolist(), C.tolist(), strict=True))
SLIPPING = ((0.0, 0.0), (0.05, 0.008), (0.3, 0.02), (1.0, 0.03))
J_P, J_T = 0.4, 2.5


def torques(w_p, w_t):
    nu = w_t / w_p
    tau_p = np.interp(nu, NU, C) * w_p**2
    return tau_p, np.interp(nu, NU, MU) * tau_p


def between(part, **parts):
    return assemble_row(pump=Inertia(J=J_P), part=part, turbine=Inertia(J=J_T), **parts)


# turbine in 1/min, its power in kW; pump in rad/s and N.m, as VECTO's own tests state them
@pytest.mark.parametrize(
    ("n_out", "kilowatts", "w_in", "tau_in"),
    [
        *((30, 10, 227.8707, 1780.6630), (60, 10, 162.8219, 901.5900)),
        *((90, 30, 230.4896, 1805.2978), (170, 50, 220.2397, 1626.0613)),
        *((190, 30, 164.3260, 892.7507), (190, 70, 246.4829, 2036.7399)),
    ],
)
def test_operating_points_are_those_that_vecto_states(n_out, kilowatts, w_in, tau_in):
    system, w_out = between(TorqueConverter(characteristic=ROWS)), n_out * RPM

    def point(w):
        return lp.start_point(system, start={"pump.w": w, "part.w_t": w_out})

    def missing(w):
        return point(w)["part.tau_t"] - 1e3 * kilowatts / w_out

    w = scipy.optimize.brentq(missing, 0.9 * w_in, 1.1 * w_in, xtol=1e-10)
    assert w == pytest.approx(w_in, abs=5.1e-5)
    assert point(w)["part.tau_p"] == pytest.approx(tau_in, abs=1e-3)


def test_a_steady_drive_runs_at_the_root_of_both_balances():
    system = assemble_row(
        push=Torque(tau=300.0),
        pump=Inertia(J=J_P),
        part=TorqueConverter(characteristic=ROWS),
        turbine=Inertia(J=J_T),
        fan=QuadraticTorque(tau_nominal=-400.0, w_nominal=100.0),
    )
    run = lp.simulate(system, until=60.0, rtol=1e-10)

    def missing(w):
        tau_p, tau_t = torques(*w)
        return tau_p - 300.0, tau_t - 400.0 * (w[1] / 100.0) ** 2

    w = scipy.optimize.root(missing, [110.0, 90.0], tol=1e-12).x
    assert [run["pump.w"][-1], run["turbine.w"][-1]] == pytest.approx(w, rel=1e-8)
    assert 0.5 < w[1] / w[0] < 0.95


def test_no_torque_at_equal_speeds_and_a_turbine_that_drives_in_overrun():
    system = between(TorqueConverter(characteristic=ROWS))
    level = lp.start_point(system, start={"pump.w": 80.0, "part.w_t": 80.0})
    assert abs(level["part.tau_p"]) < 1e-10
    point = lp.start_point(system, start={"pump.w": 60.0, "part.w_t": 90.0})
    assert (point["part.tau_p"], point["part.tau_t"]) == pytest.approx(torques(60, 90), rel=1e-12)
    assert point["part.tau_p"] < 0


def test_the_law_is_smooth_where_both_stand_still_and_where_the_pump_passes_through_it():
    system = between(TorqueConverter(characteristic=ROWS))

    def at(w_p, w_t):
        point = lp.start_point(system, start={"pump.w": w_p, "part.w_t": w_t})
        return np.array([point["part.tau_p"], point["part.tau_t"]])

    assert (at(0.0, 0.0) == 0).all()
    for p, t in ((1.0, 0.3), (0.2, 1.0), (-1.0, 0.4), (0.0, -1.0), (-0.3, -1.0)):
        large, small = at(100 * p, 100 * t), at(1e-4 * p, 1e-4 * t)
        assert small == pytest.approx(1e-12 * large, rel=1e-9)
        assert at(-p, -t) == pytest.approx(-at(p, t), rel=1e-12)
    assert at(1e-9, 50.0) == pytest.approx(at(-1e-9, 50.0), rel=1e-9)
    reference = C[-1] / NU[-1] ** 2, -C[0] / NU[-1] ** 2  # ends of the line through standstill
    assert at(0.0, 50.0)[0] == pytest.approx(50.0**2 * np.mean(reference), rel=1e-12)


def launch(w, closed, grip):
    """Accelerations of pump and turbine, with a clutch that slips beside the converter."""
    tau_p, tau_t = torques(*w)
    rub = grip if closed else 0.0
    return np.array([(220.0 - tau_p - rub) / J_P, (tau_t + rub) / J_T])


def test_a_launch_with_lock_up_is_that_of_an_own_integration_and_its_energy_closes():
    locks = lp.ops.where(lp.time >= 1.2, 1.0, 0.0)
    system = assemble_rows(
        "push pump part turbine",
        "pump lock turbine",
        push=Torque(tau=220.0),
        pump=Inertia(J=J_P, w=60.0),
        part=TorqueConverter(characteristic=ROWS),
        lock=Clutch(f_max=1000.0, c_geo=0.1, characteristic=((0.0, 2.4),), u=locks),
        turbine=Inertia(J=J_T, w=0.0),
    )
    run = lp.simulate(system, until=2.5, rtol=1e-10, grid=20_000)
    grip = 240.0

    def rates(closed):
        return lambda t, y: [
            *launch(y[:2], closed, grip),
            220.0 * y[0],
            torques(*y[:2])[0] * y[0]
            - torques(*y[:2])[1] * y[1]
            + closed * grip * abs(y[0] - y[1]),
        ]

    accuracy = {"rtol": 1e-11, "atol": 1e-11, "max_step": 2e-3}
    first = scipy.integrate.solve_ivp(rates(False), (0, 1.2), [60.0, 0, 0, 0], **accuracy)

    def level(t, y):
        return y[0] - y[1]

    level.terminal = True
    second = scipy.integrate.solve_ivp(
        rates(True), (1.2, 2.5), first.y[:, -1], events=level, **accuracy
    )
    instant, (w, _, work, heat) = second.t[-1], second.y[:, -1]
    stuck = next(e.time for e in run.events if e.component == "lock" and e.after == "stuck")
    assert stuck == pytest.approx(instant, rel=1e-8)
    assert run["pump.w"][-1] == pytest.approx(w + 220.0 / (J_P + J_T) * (2.5 - instant), rel=1e-8)
    assert work + J_P * 60.0**2 / 2 == pytest.approx((J_P + J_T) * w**2 / 2 + heat, rel=1e-9)
    lost = run["part.tau_p"] * run["part.w_p"] - run["part.tau_t"] * run["part.w_t"]
    lost = lost + run["lock.tau"] * run["lock.w_rel"]
    assert np.trapezoid(lost, run.t) == pytest.approx(heat, rel=1e-6)
    assert np.abs(run["part.tau_p"][run.t > stuck + 1e-6]).max() < 1e-9


def test_a_fluid_coupling_carries_the_capacity_of_its_slip_whichever_side_drives():
    slip, capacity = np.transpose(SLIPPING)
    system = between(FluidCoupling(characteristic=SLIPPING))
    for w_a, w_b in ((100.0, 97.0), (97.0, 100.0), (-100.0, -60.0), (50.0, 0.0), (20.0, -30.0)):
        point = lp.start_point(system, start={"pump.w": w_a, "turbine.w": w_b})
        fast = max(abs(w_a), abs(w_b))
        size = np.interp(abs(w_b - w_a) / fast, slip, capacity) * fast**2
        assert point["part.tau"] == pytest.approx(size * np.sign(w_b - w_a), rel=1e-12)


def test_a_fluid_coupling_slips_as_much_as_its_load_asks():
    system = assemble_row(
        drive=Speed(w=150.0),
        part=FluidCoupling(characteristic=SLIPPING),
        turbine=Inertia(J=J_T),
        load=Torque(tau=-200.0),
    )
    run = lp.simulate(system, until=30.0, rtol=1e-10)
    slip, capacity = np.transpose(SLIPPING)
    wanted = np.interp(200.0 / 150.0**2, capacity, slip)
    assert 1 - run["turbine.w"][-1] / 150.0 == pytest.approx(wanted, rel=1e-8)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        ((), ("rows", "such as")),
        (ROWS[1:], ("0.1", "stall")),
        (ROWS[:10], ("(1, 1, 0)", "overrun")),
        ((*ROWS[:4], *ROWS[2:]), ("increase", "0.3 -> 0.2")),
        ((*ROWS[:9], (0.9, 1.2, C[9]), *ROWS[10:]), ("0.9", "efficiency 1.08")),
        ((*ROWS[:9], (0.9, 1.0, -0.01), *ROWS[10:]), ("-0.01 N.m.s2/rad2", "0.9", "above 0")),
        ((*ROWS[:11], (1.5, 0.6, -0.01)), ("1.5", "efficiency 1.11")),
    ],
)
def test_rows_that_cannot_be_are_refused(rows, words):
    with pytest.raises(EquationError) as error:
        between(TorqueConverter(characteristic=rows))
    for word in ("part (TorqueConverter)", *words):
        assert word in str(error.value)


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (((0.0, 0.1), (1.0, 0.2)), ("0.1 N.m.s2/rad2", "(0, 0)")),
        (((0.0, 0.0), (1.0, -0.2)), ("-0.2 N.m.s2/rad2", "slip 1")),
    ],
)
def test_rows_of_a_coupling_that_would_drive_are_refused(rows, words):
    with pytest.raises(EquationError) as error:
        between(FluidCoupling(characteristic=rows))
    for word in ("part (FluidCoupling)", *words):
        assert word in str(error.value)
