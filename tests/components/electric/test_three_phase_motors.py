"""Motors of three phases: equivalent circuit, Kloss, stator axes, energy, field orientation."""

import numpy as np
import pytest
from rows import assemble_rows, in_a_row
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lumped as lp
from lumped.components import (
    InductionMotor,
    PIController,
    QuadraticTorque,
    Speed,
    SquirrelCageMotor,
    SynchronousMotor,
)

# 3 hp, 220 V, 60 Hz, of Krause et al., Analysis of Electric Machinery and Drive Systems
X = 2 * np.pi * 60
CAGE = {"R_s": 0.435, "R_r": 0.816, "L_m": 26.13 / X, "L_ls": 0.754 / X, "L_lr": 0.754 / X}
PAIRS, J, V, F = 2, 0.089, 220 * np.sqrt(2 / 3), 60.0


def motor(**given):
    return SquirrelCageMotor(**{**CAGE, "pairs": PAIRS, "J": J, "V": V, "f": F} | given)


def driven(part, load):
    return in_a_row(motor=part, load=load)


def circuit(s, V=V, f=F, R_s=CAGE["R_s"]):
    """Phasors of stator and rotor current and the torque of the T-circuit at a slip."""
    w = 2 * np.pi * f
    magnets, rotor = 1j * w * CAGE["L_m"], CAGE["R_r"] / s + 1j * w * CAGE["L_lr"]
    stator = V / (R_s + 1j * w * CAGE["L_ls"] + magnets * rotor / (magnets + rotor))
    cage = -stator * magnets / (magnets + rotor)
    return stator, cage, 1.5 * PAIRS / w * CAGE["R_r"] / s * abs(cage) ** 2


@pytest.mark.parametrize("f", [60.0, 12.0, -60.0])
def test_steady_state_is_that_of_the_equivalent_circuit_at_any_slip(f):
    system = lp.assemble(driven(motor(f=f), Speed(w=0.0)))
    for s in (2.0, 1.0, 0.4, 0.1, 0.02, 1e-4, -0.05, -0.6):
        w = 2 * np.pi * f * (1 - s) / PAIRS
        found = lp.equilibrium(system, parameters={"load.w": w})
        stator, cage, torque = circuit(s, f=f)
        received = found["motor.i_sd"] + 1j * found["motor.i_sq"]
        assert received == pytest.approx(stator, rel=1e-10)
        assert found["motor.i_rd"] + 1j * found["motor.i_rq"] == pytest.approx(cage, rel=1e-10)
        assert found["motor.i"] == pytest.approx(abs(stator), rel=1e-10)
        assert found["motor.tau"] == pytest.approx(torque, rel=1e-9)
        assert found["motor.P"] == pytest.approx(1.5 * V * stator.real, rel=1e-10)


def test_without_resistance_of_the_stator_the_torque_is_that_of_kloss():
    L_s, L_r = CAGE["L_m"] + CAGE["L_ls"], CAGE["L_m"] + CAGE["L_lr"]
    w, leak = 2 * np.pi * F, 1 - CAGE["L_m"] ** 2 / (L_s * L_r)
    curve = InductionMotor(
        w_s=w / PAIRS,
        tau_k=0.75 * PAIRS * (V / w) ** 2 * (1 - leak) / (leak * L_s),
        s_k=CAGE["R_r"] / (w * leak * L_r),
        J=J,
    )
    currents = lp.assemble(driven(motor(R_s=0.0), Speed(w=0.0)))
    kloss = lp.assemble(driven(curve, Speed(w=0.0)))
    for s in (1.5, 1.0, 0.3, 0.1, 0.01, 0.0, -0.2):
        at = {"load.w": w / PAIRS * (1 - s)}
        received = lp.equilibrium(currents, parameters=at)["motor.tau"]
        expected = lp.start_point(kloss, parameters=at)["motor.tau"]
        assert received == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_direct_current_brakes():
    """At zero frequency the rotor turns in a field that stands still."""
    w, amperes = 80.0, 10.0
    system = lp.assemble(driven(motor(f=0.0, V=CAGE["R_s"] * amperes), Speed(w=w)))
    found = lp.equilibrium(system)
    speed = 1j * PAIRS * w
    cage = speed * CAGE["L_m"] * amperes
    cage /= CAGE["R_r"] - speed * (CAGE["L_m"] + CAGE["L_lr"])
    expected = 1.5 * PAIRS * CAGE["L_m"] * (np.conj(cage) * amperes).imag
    assert expected < -1.0
    assert found["motor.tau"] == pytest.approx(expected, rel=1e-9)


def in_stator_axes(until, t, voltage, load):
    """Another formulation: complex currents in axes that stand still; speed and torque."""
    L_m, L_s, L_r = CAGE["L_m"], CAGE["L_m"] + CAGE["L_ls"], CAGE["L_m"] + CAGE["L_lr"]
    inverse = np.linalg.inv([[L_s, L_m], [L_m, L_r]])

    def torque(i):
        return 1.5 * PAIRS * L_m * (i[0] * np.conj(i[1])).imag

    def rates(at, x):
        i, w = x[:2], x[2].real
        emf = 1j * PAIRS * w * (L_m * i[0] + L_r * i[1])
        u = np.array([voltage(at) - CAGE["R_s"] * i[0], emf - CAGE["R_r"] * i[1]])
        return [*(inverse @ u), (torque(i) - load(w)) / J]

    x = solve_ivp(rates, (0, until), np.zeros(3, complex), "DOP853", t, rtol=1e-11, atol=1e-11).y
    return x[2].real, torque(x[:2])


C = 3e-4
FAN = QuadraticTorque(tau_nominal=-C, w_nominal=1.0)


def fan(w):
    return C * w * abs(w)


def test_a_direct_start_swings_as_in_axes_that_stand_still():
    t = np.linspace(0.0, 0.6, 301)
    w, torque = in_stator_axes(0.6, t, lambda at: V * np.exp(1j * X * at), fan)
    run = lp.simulate(lp.assemble(driven(motor(), FAN)), until=0.6, grid=t, rtol=1e-10)
    assert np.abs(run["motor.w"] - w).max() < 1e-8 * w.max()
    assert np.abs(run["motor.tau"] - torque).max() < 1e-7 * torque.max()
    # the transient that the torque curve does not have: it swings through zero and beyond the peak
    steady = max(circuit(s)[2] for s in np.linspace(0.01, 1.0, 200))
    assert torque.max() > 1.5 * steady
    assert torque.min() < 0


def test_a_start_with_frequency_and_voltage_in_proportion_is_soft():
    t, rise = np.linspace(0.0, 2.0, 201), 2.0
    start = 0.05  # of the voltage, at standstill

    def voltage(at):
        return V * (start + (1 - start) * at / rise) * np.exp(1j * np.pi * F / rise * at**2)

    w, torque = in_stator_axes(2.0, t, voltage, fan)
    fed = motor(V=V * (start + (1 - start) * lp.time / rise), f=F / rise * lp.time)
    run = lp.simulate(lp.assemble(driven(fed, FAN)), until=2.0, grid=t, rtol=1e-10)
    assert np.abs(run["motor.w"] - w).max() < 1e-8 * w.max()
    assert np.abs(run["motor.tau"] - torque).max() < 1e-7 * torque.max()
    direct = lp.simulate(lp.assemble(driven(motor(), FAN)), until=0.6, rtol=1e-8)
    assert run["motor.i"].max() < 0.5 * direct["motor.i"].max()


def test_a_motor_with_a_fan_settles_where_their_torques_agree():
    slip = brentq(lambda s: circuit(s)[2] - fan(X / PAIRS * (1 - s)), 1e-6, 0.1, xtol=1e-15)
    found = lp.equilibrium(lp.assemble(driven(motor(), FAN)), start={"motor.w": 185.0})
    assert found["motor.w"] == pytest.approx(X / PAIRS * (1 - slip), rel=1e-9)


MAGNETS = {"psi": 0.12, "R": 0.3, "L_d": 4e-3, "L_q": 7e-3, "pairs": 3, "J": 0.01}


# -- permanent magnets -------------------------------------------------------------------------


def test_a_motor_with_shorted_windings_brakes_by_the_closed_form():
    """``-3/2 pairs psi^2 R w_e (R^2 + (w_e L_q)^2) / (R^2 + w_e^2 L_d L_q)^2``."""
    system = lp.assemble(driven(SynchronousMotor(**MAGNETS, v_d=0.0, v_q=0.0), Speed(w=0.0)))
    psi, R, L_d, L_q = (MAGNETS[k] for k in ("psi", "R", "L_d", "L_q"))
    for w in (-40.0, 5.0, 30.0, 300.0):
        e = 3 * w
        received = lp.equilibrium(system, parameters={"load.w": w})["motor.tau"]
        shared = R**2 + e**2 * L_d * L_q
        expected = -4.5 * psi**2 * R * e * (R**2 + e**2 * L_q**2) / shared**2
        assert received == pytest.approx(expected, rel=1e-9)


def test_a_synchronous_motor_swings_as_in_axes_that_stand_still():
    """Salient poles: the inductance seen from the stator turns with the rotor."""
    psi, R, L_d, L_q, pairs, J = (MAGNETS[k] for k in ("psi", "R", "L_d", "L_q", "pairs", "J"))
    v_d, v_q = -4.0, 20.0
    t = np.linspace(0.0, 0.3, 121)

    def seen(x):
        turn = np.exp(1j * x[2])
        own = (x[0] + 1j * x[1]) / turn - psi
        return turn * (own.real / L_d + 1j * own.imag / L_q), turn

    def rates(_, x):
        i, turn = seen(x)
        torque = 1.5 * pairs * ((x[0] - 1j * x[1]) * i).imag
        u = (v_d + 1j * v_q) * turn - R * i
        return [u.real, u.imag, pairs * x[3], (torque - fan(x[3])) / J]

    x = solve_ivp(rates, (0, 0.3), [psi, 0, 0, 0], "DOP853", t, rtol=1e-11, atol=1e-12).y
    i = seen(x)[0] / np.exp(1j * x[2])
    model = driven(SynchronousMotor(**MAGNETS, v_d=v_d, v_q=v_q), FAN)
    run = lp.simulate(lp.assemble(model), until=0.3, grid=t, rtol=1e-10)
    assert np.abs(run["motor.w"] - x[3]).max() < 1e-8 * x[3].max()
    received = run["motor.i_d"] + 1j * run["motor.i_q"]
    assert np.abs(received - i).max() < 1e-7 * np.abs(i).max()


def test_field_orientation_gives_the_torque_of_the_current_across_the_magnets():
    system = assemble_rows(
        *("along.y motor.v_d", "motor.i_d_meas along.measured", "motor load"),
        *("across.y motor.v_q", "motor.i_q_meas across.measured"),
        motor=SynchronousMotor(**MAGNETS),
        along=PIController(k=4.0, T_i=0.013, wanted=-3.0),
        across=PIController(k=7.0, T_i=0.023, wanted=20.0),
        load=Speed(w=50.0),
    )
    run = lp.simulate(system, until=1.0, grid=[1.0], rtol=1e-10)
    # salient poles add (L_d - L_q) i_d
    expected = 1.5 * 3 * (0.12 + 3e-3 * 3.0) * 20.0
    assert run["motor.tau"][-1] == pytest.approx(expected, rel=1e-8)
