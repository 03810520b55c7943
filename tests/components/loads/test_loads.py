"""Loads that depend on the speed, eddy-current brakes and vehicles, against closed forms."""

import numpy as np
import pytest
from rows import assemble_row, assemble_rows, in_rows

import lumped as lp
from lumped.components import (
    EddyCurrentBrake,
    FixedTemperature,
    Inertia,
    InverseTorque,
    LinearTorque,
    QuadraticTorque,
    SignTorque,
    Speed,
    Torque,
    Vehicle,
)

KINDS = {
    "linear": LinearTorque,
    "quadratic": QuadraticTorque,
    "sign": SignTorque,
    "inverse": InverseTorque,
}
N, V, V0 = -40.0, 10.0, 2.0


def coasting(name, begin, until=1.0, **given):
    """Times and speeds of an inertia of 2 that a load brakes."""
    system = assemble_row(body=Inertia(J=2.0, w=begin), load=KINDS[name](tau_nominal=N, **given))
    run = lp.simulate(system, until=until, rtol=1e-10)
    return run.t, run["body.w"]


COASTING = [
    ("linear", {"w_nominal": V}, 25.0, lambda t: 25 * np.exp(N / V / 2 * t)),
    ("linear", {"w_nominal": V}, -25.0, lambda t: -25 * np.exp(N / V / 2 * t)),
    ("linear", {"w_nominal": V, "same_direction": True}, -5.0, lambda t: -5 * np.exp(2 * t)),
    ("quadratic", {"w_nominal": V}, 25.0, lambda t: 1 / (1 / 25 - N / V**2 / 2 * t)),
    ("quadratic", {"w_nominal": V}, -25.0, lambda t: -1 / (1 / 25 - N / V**2 / 2 * t)),
    (
        "quadratic",
        {"w_nominal": V, "same_direction": True},
        -2.0,
        lambda t: 1 / (-1 / 2 - N / V**2 / 2 * t),
    ),
    ("sign", {"w0": 0.1}, 25.0, lambda t: 25 + N / 2 * t),
    ("sign", {"w0": 0.1, "smooth": False}, -25.0, lambda t: -25 - N / 2 * t),
    (
        "sign",
        {"w0": V0, "smooth": False},
        5.0,
        lambda t: np.where(t < 0.15, 5 + N / 2 * t, V0 * np.exp(N / V0 / 2 * (t - 0.15))),
    ),
    ("inverse", {"w_nominal": V, "w0": V0}, 25.0, lambda t: np.sqrt(25**2 + N * V * t)),
    (
        "inverse",
        {"w_nominal": V, "w0": V0, "same_direction": True},
        -30.0,
        lambda t: -np.sqrt(30**2 - N * V * t),
    ),
    ("inverse", {"w_nominal": V, "w0": V0}, 1.0, lambda t: np.exp(N / V0 / 2 * t)),
    (
        "inverse",
        {"w_nominal": V, "w0": 50.0, "same_direction": True},
        20.0,
        lambda t: 20 + N * V / 50 / 2 * t,
    ),
]


@pytest.mark.parametrize(("name", "given", "begin", "speed"), COASTING)
def test_a_body_coasts_as_the_law_of_its_load_says(name, given, begin, speed):
    t, received = coasting(name, begin, **given)
    assert received == pytest.approx(speed(t), rel=1e-7, abs=1e-7)


def eddy(temperature, speed, alpha=0.004):
    """Braking torque at a speed and temperature, and the heat."""
    brake = EddyCurrentBrake(tau_max=100.0, w_nominal=10.0, alpha=alpha, T_ref=300.0, e=0.5)
    rows = ("source brake", "brake.heat air.port")
    parts = {"source": Speed(w=speed), "brake": brake, "air": FixedTemperature(T=temperature)}
    point = lp.start_point(assemble_rows(*rows, **parts))
    return point["brake.tau"], -point["brake.heat.Q"]


def test_an_eddy_current_brake_is_strongest_at_its_critical_speed():
    # excitation 0.5 gives a quarter; a resistance 1.4 times as large moves the speed by 1.4
    for temperature, critical in ((300.0, 10.0), (400.0, 14.0)):
        at, power = eddy(temperature, critical)
        assert at == pytest.approx(25.0, rel=1e-12)
        assert power == pytest.approx(25.0 * critical, rel=1e-12)
        # x and 1/x brake alike
        half, twice = (eddy(temperature, critical * x)[0] for x in (0.5, 2.0))
        assert half == pytest.approx(25.0 * 0.8, rel=1e-12)
        assert twice == pytest.approx(half, rel=1e-12)
        assert eddy(temperature, -critical)[0] == pytest.approx(-25.0, rel=1e-12)


# -- vehicle -----------------------------------------------------------------------------------

CAR = {"m": 1200.0, "J": 4.0, "R": 0.3, "A": 2.2, "cd": 0.3, "cr": 0.01}
G, RHO = 9.80665, 1.2


def driven(tau, *, inclination=0.0, wind=0.0, **given):
    car = Vehicle(**{**CAR, **given}, inclination=inclination, v_wind=wind)
    return in_rows("drive.flange car.wheel", drive=Torque(tau=tau), car=car)


def test_a_vehicle_runs_at_the_speed_where_drive_and_resistance_agree():
    wind, incline = -5.0, 0.02
    slope = np.arctan(incline)
    wanted = 30.0
    force = RHO / 2 * CAR["cd"] * CAR["A"] * (wanted - wind) ** 2
    force += CAR["m"] * G * (CAR["cr"] * np.cos(slope) + np.sin(slope))
    system = lp.assemble(driven(force * CAR["R"], inclination=incline, wind=wind))
    run = lp.simulate(system, until=3000.0)
    assert run["car.v"][-1] == pytest.approx(wanted, rel=1e-6)


def test_a_vehicle_without_resistance_accelerates_with_its_wheels():
    system = lp.assemble(driven(90.0, cd=0.0, cr=0.0), keep=["car.wheel.phi", "car.s"])
    run = lp.simulate(system, until=4.0)
    a = 90.0 / CAR["R"] / (CAR["m"] + CAR["J"] / CAR["R"] ** 2)
    assert run["car.v"] == pytest.approx(a * run.t, rel=1e-9, abs=1e-9)
    assert run["car.s"] == pytest.approx(a * run.t**2 / 2, rel=1e-9, abs=1e-9)
    assert run["car.wheel.phi"] == pytest.approx(run["car.s"] / CAR["R"], rel=1e-12)


def test_a_vehicle_slows_as_its_drag_and_its_rolling_resistance_say():
    model = lp.compose(car=Vehicle(**CAR, inclination=0.0, v_wind=0.0, v=3.0))
    run = lp.simulate(lp.assemble(model), until=60.0, rtol=1e-10)
    mass = CAR["m"] + CAR["J"] / CAR["R"] ** 2
    assert abs(run["car.v"][-1]) < 1e-6
    # drag k v^2 and rolling f down to the velocity at which rolling resistance falls
    k, f = RHO / 2 * CAR["cd"] * CAR["A"], CAR["cr"] * CAR["m"] * G
    angle = np.arctan(3.0 * np.sqrt(k / f)) - np.arctan(1e-3 * np.sqrt(k / f))
    slowed = [event.time for event in run.events if event.component == "car"]
    assert slowed == pytest.approx([mass / np.sqrt(k * f) * angle], rel=1e-8)
