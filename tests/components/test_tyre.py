"""Tyres: steady slip, relaxation, standstill, locked wheels; rolling resistance that changes."""

import numpy as np
import pytest
from rows import in_rows

import lumped as lp
from lumped.components import Speed, Tyre, Vehicle, translation

R, LOAD, MU, B, C, E = 0.3, 4000.0, 1.1, 9.0, 1.5, -0.4
SIGMA, G = 0.4, 9.80665
TYRE = {"R": R, "mu": MU, "B": B, "C": C, "E": E, "sigma": SIGMA, "f_n": LOAD}


def force(k):
    x = B * np.asarray(k)
    x = x - E * (x - np.arctan(x))
    return LOAD * MU * np.sin(C * np.arctan(x))


def rolling(w, v, **given):
    """A tyre whose wheel and hub move as they are told."""
    parts = {"turn": Speed(w=w), "tyre": Tyre(**TYRE, **given), "slide": translation.Speed(v=v)}
    return in_rows("turn.flange tyre.wheel", "tyre.hub slide.flange", **parts)


@pytest.mark.parametrize(
    ("w", "v"), [(102.0, 30.0), (90.0, 30.0), (0.0, 20.0), (50.0, 0.0), (-40.0, -13.0), (20.0, 6.0)]
)
def test_steady_slip_has_the_force_of_the_formula(w, v):
    run = lp.simulate(lp.assemble(rolling(w, v)), until=5.0, rtol=1e-11, grid=[5.0])
    k = (R * w - v) / ((abs(v) + abs(R * w)) / 2)
    assert run["tyre.k"][-1] == pytest.approx(k, rel=1e-9, abs=1e-12)
    assert run["tyre.f"][-1] == pytest.approx(float(force(k)), rel=1e-9, abs=1e-6)
    torque = -run["turn.flange.tau"][-1]
    assert torque == pytest.approx(R * float(force(k)), rel=1e-9, abs=1e-6)


def test_slip_comes_within_the_relaxation_length():
    """At any speed: after a way of sigma a small force has reached 1 - 1/e of its final value."""
    for v in (5.0, 50.0):
        w = (1 + 1e-5) * v / R
        run = lp.simulate(lp.assemble(rolling(w, v)), until=4 * SIGMA / v, rtol=1e-10, atol=1e-15)
        expected = 1e-5 * (1 - np.exp(-v * run.t / SIGMA))
        assert np.abs(run["tyre.z"] - expected).max() < 1e-4 * 1e-5


def test_large_slip_builds_up_the_force_over_a_shorter_way():
    """By the secant of the formula: the tread slips at the deflection that gives the force."""
    v, w = 20.0, 26.0 / R
    V, k = (v + R * w) / 2, (R * w - v) / ((v + R * w) / 2)
    run = lp.simulate(lp.assemble(rolling(w, v)), until=0.05, rtol=1e-11)
    final = float(force(k)) / (LOAD * MU * B * C)
    way = SIGMA * final / k
    expected = final * (1 - np.exp(-V * run.t / way))
    assert way < 0.3 * SIGMA
    assert run["tyre.z"] == pytest.approx(expected, rel=1e-6, abs=1e-12)


def parked(m, slope, **given):
    """A body on a slope, held by a tyre whose wheel does not turn."""
    return in_rows(
        *("shaft.flange tyre.wheel", "tyre.hub car.flange_a downhill.flange"),
        shaft=Speed(w=0.0),
        tyre=Tyre(**TYRE, **given),
        car=translation.Mass(m=m, v=0.0),
        downhill=translation.Force(f=-m * G * slope),
    )


def test_a_parked_vehicle_swings_on_its_tyre_and_comes_to_rest():
    """Small motions: a spring of f_n mu B C / sigma with a damper of T_d times that."""
    m, slope, T_d = 400.0, 1e-4, 0.01
    stiff = LOAD * MU * B * C
    c, d = stiff / SIGMA, stiff / SIGMA * T_d
    run = lp.simulate(lp.assemble(parked(m, slope, T_d=T_d)), until=1.0, rtol=1e-10, atol=1e-13)
    decay = d / (2 * m)
    turn = np.sqrt(c / m - decay**2)
    final = m * G * slope / stiff
    swing = np.exp(-decay * run.t) * (np.cos(turn * run.t) + decay / turn * np.sin(turn * run.t))
    error = np.abs(run["tyre.z"] - final * (1 - swing)).max() / final
    slips = final * LOAD * MU * B * C / float(force(2.0))
    print(f"deflection of a parked vehicle: {error:.1e}, share of the greatest force {slips:.1e}")
    assert error < 2 * slips  # it slips by a share of second order


def test_a_parked_vehicle_stays_for_a_day():
    system = lp.assemble(parked(400.0, 0.1), keep=["car.s"])
    run = lp.simulate(system, until=86400.0, grid=[60.0, 86400.0])
    assert run["car.s"][0] < 0
    assert run["car.s"][1] == pytest.approx(run["car.s"][0], rel=1e-6)
    assert run["tyre.f"][1] == pytest.approx(400.0 * G * 0.1, rel=1e-6)


def test_a_locked_wheel_slides_to_a_stop_with_the_force_of_full_slip():
    """Then it swings by no more than the deflection that this force had made."""
    m, v = 400.0, 20.0
    model = parked(m, 0.0).with_({"car": translation.Mass(m=m, v=v)})
    final = float(force(-2.0)) / (LOAD * MU * B * C)
    system = lp.assemble(model, keep=["car.s"])
    run = lp.simulate(system, until=25.0, start={"tyre.z": final}, rtol=1e-10)
    a = float(force(-2.0)) / m  # negative
    sliding = v + a * run.t > 3 * 2.5  # the damping of standstill has no part yet
    assert run["car.v"][sliding] == pytest.approx(v + a * run.t[sliding], rel=1e-6)
    after = run.t > v / -a
    assert np.ptp(run["car.s"][after]) < 2 * SIGMA * -final
    assert abs(run["car.v"][-1]) < 1e-6
    assert run["car.s"][-1] == pytest.approx(v**2 / (-2 * a), abs=SIGMA * -final)


def test_rolling_resistance_may_change_on_the_way():
    """Gravel after 2 s: the coefficient is a signal."""
    gravel = lp.ops.where(lp.time >= 2.0, 0.2, 0.01)
    car = Vehicle(m=1000.0, R=R, A=0.0, cd=0.0, cr=gravel, inclination=0.0, v_wind=0.0, v=10.0)
    run = lp.simulate(lp.assemble(lp.compose(car=car)), until=4.0)
    expected = 10.0 - G * (0.01 * run.t + 0.19 * np.maximum(run.t - 2.0, 0))
    assert run["car.v"] == pytest.approx(expected, rel=1e-8)


def test_a_parked_vehicle_has_an_equilibrium_and_the_mode_of_its_tyre():
    m, T_d = 400.0, 0.006
    system = lp.assemble(parked(m, 0.05, T_d=T_d))
    point = lp.equilibrium(system)
    assert point["tyre.f"] == pytest.approx(m * G * 0.05, rel=1e-9)
    turn = np.sqrt(LOAD * MU * B * C / SIGMA / m)
    modes = lp.modes(system)
    assert modes.hertz == pytest.approx([turn / (2 * np.pi)], rel=1e-9)
    assert modes.damping == pytest.approx([T_d * turn / 2], rel=1e-9)
