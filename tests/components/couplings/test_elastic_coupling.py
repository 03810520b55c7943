import numpy as np
import pytest
import scipy
from rows import assemble_row, in_a_row
from torsional_cases import RPM, columns

import lumped as lp
from lumped.components import (
    Damper,
    ElasticCoupling,
    Fixed,
    Inertia,
    QuadraticTorque,
    Speed,
    Torque,
)
from lumped.errors import EquationError

J1, J2 = 12.0, 30.0
JR = J1 * J2 / (J1 + J2)
ROWS = tuple(zip(range(0, 3500, 500), (60e3, 75e3, 95e3, 120e3, 150e3, 185e3, 225e3), strict=True))
TORQUES, STIFF = np.transpose(ROWS)
RATED = 2500.0, 1500 * RPM


def stiffness(torque):
    return np.interp(np.abs(torque), TORQUES, STIFF)


FAN = QuadraticTorque(tau_nominal=RATED[0], w_nominal=RATED[1])


def drive(motor=FAN, **coupling):
    """Two inertias and a coupling under torques on both sides."""
    given = {"stiffness": ROWS, "psi": 0.8, "w_loss": 90.0, **coupling}
    return assemble_row(
        motor=motor,
        gas=Torque(tau=0.0),
        engine=Inertia(J=J1),
        coupling=ElasticCoupling(**given),
        load=Inertia(J=J2),
        brake=Torque(tau=0.0),
    )


def wound(**coupling):
    """A coupling that a source of speed winds up."""
    given = {"stiffness": ROWS, "psi": 0.8, "w_loss": 90.0, **coupling}
    return assemble_row(wall=Fixed(), part=ElasticCoupling(**given), drive=Speed(w=0.0))


def twisted(angle, **coupling):
    """What a coupling answers to a twist."""
    return lp.start_point(wound(**coupling), start={"part.phi_rel": angle})


def shaken(w, k, psi, torque, d=0.0):
    """Complex angles of both masses, and power of the coupling, by the matrices of the drive."""
    kc = k * (1 + 1j * psi / (2 * np.pi))
    matrix = np.array([[kc - J1 * w**2 + 1j * w * d, -kc], [-kc, kc - J2 * w**2]])
    phi = np.linalg.solve(matrix, [torque, 0])
    return phi, 0.5 * k * psi * abs(phi[0] - phi[1]) ** 2 * w / (2 * np.pi)


@pytest.mark.parametrize("way", ["free", "at"])
@pytest.mark.parametrize("psi", [0.8, 1.6])
def test_a_progressive_coupling_vibrates_as_its_table_says(way, psi):
    table = columns("09_elastic_coupling", "progressive_linear.csv")
    motor = FAN if way == "free" else Torque(tau=0.0)
    system = drive(motor, extrapolate=True, psi=psi)
    speeds = table["n_rpm"] * RPM

    def at(w):
        mean = RATED[0] * (w / RATED[1]) ** 2
        torques = {"motor.tau": mean, "brake.tau": -mean}
        return lp.equilibrium(system, parameters=torques, start={"engine.w": w})

    mean = {"at": at} if way == "at" else {"shaft": "engine.phi", "free": "brake.tau"}
    response = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["coupling.tau", "coupling.phi_rel", "coupling.c", "engine.a", "load.a"],
        orders=[2],
        excitations={"gas.tau": {2: 600.0}},
        **mean,
    )
    heat = response.mean_power("coupling.power")[:, 0]
    errors = []
    for k, w in enumerate(speeds):
        mean = RATED[0] * (w / RATED[1]) ** 2
        # the torque of the fan grows with the speed
        d = -2 * mean / w if way == "free" else 0.0
        phi, power = shaken(2 * w, stiffness(mean), psi, 600.0, d)
        found = np.array([response["engine.a"][k, 0], response["load.a"][k, 0]])
        errors.append(np.abs(found / (-((2 * w) ** 2) * phi) - 1).max())
        errors.append(abs(heat[k] / power - 1))
    if psi == 0.8 and way == "at":
        for name, head in (
            ("coupling.tau", "coupling_torque_Nm"),
            ("coupling.phi_rel", "twist_rad"),
        ):
            errors.append(np.abs(response.magnitude(name, 2) / table[head] - 1).max())
        # the torque of a spring here counts from the flange that lags
        phase = np.degrees(np.angle(-response["coupling.tau"][:, 0]))
        missed = phase - table["coupling_torque_phase_deg"]
        errors.append(np.radians(np.abs((missed + 180) % 360 - 180).max()))
        errors.append(np.abs(heat / table["heat_W"] - 1).max())
        c = table["dynamic_stiffness_Nm_per_rad"]
        errors.append(np.abs(response.mean("coupling.c") / c - 1).max())
    print(f"{way}, psi {psi:g}: {max(errors):.1e}")
    assert max(errors) < 2e-8  # ten digits of the table; the balance of the mean


@pytest.mark.parametrize("sign", [1, -1])
def test_the_static_law_has_the_stated_stiffness_as_its_slope(sign):
    law = scipy.integrate.solve_ivp(
        lambda _, tau: stiffness(tau), (0, 0.03), [0.0], rtol=1e-12, atol=1e-9, max_step=1e-4
    )
    worst = 0.0
    for twist, tau in zip(law.t[10::40], law.y[0, 10::40], strict=True):
        point = twisted(sign * twist, extrapolate=True)
        worst = max(worst, abs(point["part.tau_c"] / (sign * tau) - 1))
        worst = max(worst, abs(point["part.c"] / stiffness(tau) - 1))
    print(f"{worst:.1e}")
    assert worst < 1e-7  # the steps of the reference pass over kinks
    assert law.y[0, -1] > 2500


def test_it_has_its_stiffness_without_torque_too():
    assert twisted(0.0)["part.c"] == pytest.approx(60e3, rel=1e-14)


def test_equal_and_falling_stiffness_is_exact():
    # c = 100 up to 10 N.m, then falls to 50 at 20 N.m: tau = 10 + 20 (1 - exp(-5 (x - 0.1)))
    rows = ((0, 100.0), (10, 100.0), (20, 50.0))
    for twist, tau in ((0.05, 5.0), (0.2, 10 + 20 * (1 - np.exp(-0.5)))):
        assert twisted(twist, stiffness=rows)["part.tau_c"] == pytest.approx(tau, rel=1e-13)
    softest = 0.1 + np.log(2) / 5
    point = twisted(softest + 0.1, stiffness=rows, extrapolate=True)
    assert point["part.tau_c"] == pytest.approx(20 + 50 * 0.1, rel=1e-13)


def test_rows_of_twist_and_torque_are_joined_by_lines():
    rows = ((0, 0), (0.05, 2000), (0.1, 5000))
    for twist, tau, c in ((0.02, 800, 4e4), (-0.08, -3800, 6e4)):
        point = twisted(twist, stiffness=(), twist=rows)
        assert point["part.tau_c"] == pytest.approx(tau, rel=1e-13)
        assert point["part.c"] == pytest.approx(c, rel=1e-13)


def test_temperature_and_torque_change_stiffness_and_damping():
    warm = ((293.0, 1.0, 1.0), (353.0, 0.7, 0.6))
    damping = ((0, 1.2), (1000, 0.8), (3000, 0.5))
    cold = twisted(0.02)
    found = twisted(0.02 / 0.85, over_temperature=warm, damping=damping, T=323.0)
    # d tau / d phi = k c(tau) makes tau = F(k phi)
    assert found["part.tau_c"] == pytest.approx(cold["part.tau_c"], rel=1e-13)
    assert found["part.c"] == pytest.approx(0.85 * cold["part.c"], rel=1e-13)
    model = in_a_row(
        wall=Fixed(),
        part=ElasticCoupling(
            stiffness=ROWS, psi=0.9, w_loss=90.0, over_temperature=warm, damping=damping, T=323.0
        ),
        rotor=Inertia(J=1.0, w=0.3),
    )
    point = lp.start_point(lp.assemble(model), start={"part.phi_rel": 0.02 / 0.85})
    psi = 0.9 * 0.8 * np.interp(point["part.tau_c"], *np.transpose(damping))
    d = psi * point["part.c"] / (2 * np.pi * 90.0)
    assert point["part.power"] == pytest.approx(d * 0.3**2, rel=1e-12)


def test_factors_over_the_frequency_hold_at_each_order():
    rows = ((20.0, 0.9, 1.1), (90.0, 1.0, 1.0), (400.0, 1.25, 0.7))
    system = drive(over_frequency=rows)
    load = {"brake.tau": -1300.0, "motor.tau_nominal": 1300.0, "motor.w_nominal": 60.0}
    point = lp.equilibrium(system, parameters=load, start={"engine.w": 60.0})
    speeds = np.linspace(25.0, 95.0, 8)
    response = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["coupling.phi_rel"],
        excitations={"gas.tau": {1: 60.0, 4: 30.0j}},
        at=point,
    )
    heat = response.mean_power("coupling.power")
    where, stiff, loss = np.transpose(rows)
    for o, (order, torque) in enumerate(((1, 60.0), (4, 30.0j))):
        w = order * speeds
        k, psi = stiffness(1300.0) * np.interp(w, where, stiff), 0.8 * np.interp(w, where, loss)
        d = -2 * 1300.0 / 60.0
        for i in range(len(w)):
            phi, power = shaken(w[i], k[i], psi[i], torque, d)
            assert response["coupling.phi_rel"][i, o] == pytest.approx(phi[1] - phi[0], rel=1e-9)
            assert heat[i, o] == pytest.approx(power, rel=1e-9)


def test_a_run_loses_what_the_response_says_at_the_stated_frequency():
    w = 2 * 70.0
    model = in_a_row(
        gas=Torque(tau=0.0),
        engine=Inertia(J=J1, w=0.0),
        coupling=ElasticCoupling(stiffness=((0, 8e4), (3000, 8e4)), psi=0.8, w_loss=w),
        load=Inertia(J=J2),
        bearing=Damper(d=3.0),
        ground=Fixed(),
    )
    response = lp.vibration.order_response(
        lp.assemble(model), speeds=[70.0], of=["coupling.tau"], excitations={"gas.tau": {2: 600.0}}
    )
    pushed = model.with_({"gas": Torque(tau=600.0 * lp.ops.cos(w * lp.time))})
    orbit = lp.periodic(lp.assemble(pushed), period=2 * np.pi / w, rtol=1e-10)
    run = orbit.run
    mean = np.trapezoid(run["coupling.power"], run.t) * w / (2 * np.pi)
    assert response.mean_power("coupling.power")[0, 0] == pytest.approx(mean, rel=1e-7)
    largest = 0.5 * 8e4 * np.abs(run["coupling.phi_rel"]).max() ** 2
    assert mean * 2 * np.pi / w == pytest.approx(0.8 * largest, rel=1e-4)  # at points of the run


def test_energy_of_a_run_balances_at_another_temperature():
    warm = ((293.0, 1.0, 1.0), (353.0, 0.7, 0.6))
    model = in_a_row(
        wall=Fixed(),
        part=ElasticCoupling(
            stiffness=ROWS, psi=0.8, w_loss=90.0, over_temperature=warm, T=323.0, phi_rel=0.029
        ),
        rotor=Inertia(J=J1, w=0.0),
    )
    run = lp.simulate(lp.assemble(model), until=0.3, rtol=1e-9, certify=True)
    energy = run.certificate.energy
    print(energy)
    assert "part" in energy.components
    assert energy.error < 1e-7


def test_free_swings_about_a_mean_torque_have_its_stiffness():
    system = drive(psi=0.0)
    mean = 1300.0
    load = {"brake.tau": -mean, "motor.tau_nominal": mean, "motor.w_nominal": 1e3}
    point = lp.equilibrium(system, parameters=load, start={"engine.w": 1e3})
    found = lp.modes(system, at=point).hertz
    wanted = np.sqrt(stiffness(mean) / JR) / (2 * np.pi)
    assert found[np.argmin(np.abs(found - wanted))] == pytest.approx(wanted, rel=1e-5)


def test_limits_of_the_catalogue_are_judged():
    coupling = ElasticCoupling(
        stiffness=ROWS, psi=0.8, w_loss=90.0, tau_max=2900.0, tau_vibratory=400.0, power_max=30.0
    )
    limits = lp.compose(coupling=coupling).coupling.limits()
    response = lp.vibration.order_response(
        drive(),
        speeds=np.linspace(25.0, 60.0, 30),
        of=["coupling.tau"],
        shaft="engine.phi",
        free="brake.tau",
        orders=[1, 2],
        excitations={"gas.tau": {1: 30.0, 2: 200.0}},
    )
    verdict = lp.vibration.verdict(response, limits)
    by_name = {result.name: result for result in verdict.results}

    def heat(speed):
        mean = RATED[0] * (speed / RATED[1]) ** 2
        own = stiffness(mean), 0.8
        return sum(
            shaken(order * speed, *own, torque, -2 * mean / speed)[1]
            for order, torque in ((1, 30.0), (2, 200.0))
        )

    last = response.mean_power("coupling.power").sum(axis=1)[-1]
    assert last == pytest.approx(heat(response.speeds[-1]), rel=1e-9)
    fine = np.linspace(25.0, 60.0, 3501)
    result = by_name["coupling heat"]
    assert result.permitted == 30.0
    assert result.value == pytest.approx(max(map(heat, fine)), rel=1e-5)
    assert set(by_name) == {"coupling heat", "coupling largest torque", "coupling vibration"}
    assert by_name["coupling largest torque"].measure == "with mean"


def test_without_limits_there_is_nothing_to_judge():
    with pytest.raises(EquationError, match="no limit is stated"):
        ElasticCoupling(stiffness=ROWS, psi=0.8, w_loss=90.0).limits()


def test_a_coupling_of_twice_the_size_is_two_side_by_side():
    rows = {
        "damping": ((0, 0.9), (3000, 1.2)),
        "over_temperature": ((280, 1.1, 0.9), (340, 0.8, 1.1)),
        "over_amplitude": ((0, 1.1, 0.9), (2000, 0.7, 1.2)),
    }
    one = twisted(0.011, **rows, T=320.0, amplitude=300.0)
    two = twisted(0.011, **rows, T=320.0, amplitude=600.0, size=2.0)
    for name in ("tau_c", "c", "tau"):
        print(f"{name} {two[f'part.{name}'] / one[f'part.{name}'] - 2:.1e}")
        assert two[f"part.{name}"] == pytest.approx(2 * one[f"part.{name}"], rel=1e-14)
