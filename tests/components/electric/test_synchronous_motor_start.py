"""Start of a synchronous motor through natural frequencies, and passages in closed form.

`tests/data/torsional/04_synchronous_motor_start`: DOP853 of SciPy at 1e-10.
"""

from pathlib import Path

import numpy as np
import pytest
from checks import refused
from rows import assemble_row, assemble_rows
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import (
    Fixed,
    Inertia,
    QuadraticTorque,
    SpringDamper,
    SynchronousMotorStart,
    Torque,
)
from lumped.errors import EquationError

DATA = Path(__file__).parents[2] / "data" / "torsional" / "04_synchronous_motor_start"
SPEEDS = (0, 0.2, 0.4, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.98, 1)
AVERAGE = (0.80, 0.85, 0.90, 0.95, 1.00, 1.05, 1.05, 1.00, 0.80, 0.45, 0)
PULSATING = (0.60, 0.62, 0.65, 0.68, 0.70, 0.72, 0.70, 0.65, 0.55, 0.40, 0.30)
TORQUES = tuple(zip(SPEEDS, AVERAGE, PULSATING, strict=True))
F, PAIRS, RATED = 60.0, 2, 40e3
W_S = 2 * np.pi * F / PAIRS


def motor(**given):
    numbers = {"J": 600.0, "tau_n": RATED, "f": F, "pairs": PAIRS, "torques": TORQUES}
    return SynchronousMotorStart(**(numbers | given))


def train(shafts, bodies, **given):
    """Motor, shafts and bodies in a row; the last body is a compressor."""
    return assemble_rows(
        "motor shafts/bodies load",
        motor=motor(**given),
        shafts=[SpringDamper(c=c, d=d) for c, d in shafts],
        bodies=[Inertia(J=J) for J in bodies],
        load=QuadraticTorque(tau_nominal=-0.3 * RATED, w_nominal=W_S),
    )


def columns(name):
    return np.genfromtxt(DATA / f"{name}.csv", delimiter=",", names=True)


def test_a_start_passes_the_natural_frequency_as_the_table_says():
    table = columns("two_mass_start")
    system = train([(6.0e6, 1200.0)], [900.0])
    run = lp.simulate(system, until=8.486, grid=table["t_s"], rtol=1e-9)
    at = np.searchsorted(run.t, table["t_s"] - 1e-12)
    peak = np.abs(table["shaft1_Nm"]).max()
    error = np.abs(-run["shafts[0].tau"][at] - table["shaft1_Nm"]).max() / peak
    print(f"shaft torque: largest deviation {error:.1e} of the peak")
    assert error < 1e-4
    assert run["motor.w"][at] * 30 / np.pi == pytest.approx(table["motor_rpm"], abs=1e-3)
    assert run["motor.f_p"][at] == pytest.approx(table["twice_slip_Hz"], abs=1e-4)


@pytest.mark.parametrize("phase", [0.0, 2.0])
def test_a_train_of_three_masses_starts_as_in_another_formulation(phase):
    """Absolute angles, and the pulsation from the angle of the rotor instead of its speed."""
    J = np.array([600.0, 80.0, 900.0])
    c, d = np.array([9.0e6, 5.0e6]), np.array([900.0, 700.0])

    def rates(t, x):
        phi, w = x[:3], x[3:]
        twist = c * -np.diff(phi) + d * -np.diff(w)
        share = w[0] / W_S
        drive = np.interp(share, SPEEDS, AVERAGE)
        swing = np.interp(share, SPEEDS, PULSATING)
        angle = phase + 2 * (2 * np.pi * F * t - PAIRS * phi[0])
        load = 0.3 * (w[2] / W_S) * abs(w[2] / W_S)
        torque = [RATED * (drive + swing * np.cos(angle)), 0.0, -RATED * load]
        return [*w, *((torque + np.diff([0.0, *-twist, 0.0])) / J)]

    t = np.linspace(0.0, 3.0, 601)
    x = solve_ivp(rates, (0, 3), np.zeros(6), "DOP853", t, rtol=1e-9, atol=1e-9).y
    expected = c[:, None] * -np.diff(x[:3], axis=0) + d[:, None] * -np.diff(x[3:], axis=0)
    system = train(zip(c, d, strict=True), J[1:], phase=phase)
    run = lp.simulate(system, until=3.0, grid=t, rtol=1e-10)
    at = np.searchsorted(run.t, t - 1e-12)
    for number in range(2):
        received = -run[f"shafts[{number}].tau"][at]
        error = np.abs(received - expected[number]).max() / np.abs(expected[number]).max()
        print(f"shaft {number}, phase {phase}: largest deviation {error:.1e} of the peak")
        assert error < 1e-6


W, NU = 2 * np.pi * 20.0, 2 * np.pi * 60.0


def passage(zeta, sigma):
    """``x'' + 2 zeta W x' + W^2 x = W^2 cos(NU t - sigma t^2 / 2)``, from 60 Hz down to 1 Hz."""
    system = assemble_row(
        wall=Fixed(),
        shaft=SpringDamper(c=W**2, d=2 * zeta * W),
        body=Inertia(J=1.0),
        drive=Torque(tau=W**2 * lp.ops.cos(NU * lp.time - sigma * lp.time**2 / 2)),
    )
    until = (NU - 2 * np.pi) / sigma
    run = lp.simulate(system, until=until, grid=40_001, rtol=1e-10)
    return run.t, run["shaft.phi_rel"]


def duhamel(end, zeta, sigma):
    """Duhamel's integral of the passage, by Gauss's rule."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    edges = np.linspace(0.0, end, int(400 * end) + 2)
    t = edges[:-1, None] + edges[1] * (nodes + 1) / 2
    damped = W * np.sqrt(1 - zeta**2)
    answer = np.exp(-zeta * W * (end - t)) * np.sin(damped * (end - t)) * W**2 / damped
    return (answer * np.cos(NU * t - sigma * t**2 / 2) @ weights).sum() * edges[1] / 2


@pytest.mark.parametrize(("zeta", "rate"), [(0.02, 2.0), (0.0, 5.0), (0.01, 2.0), (0.05, 20.0)])
def test_a_passage_follows_the_integral_of_duhamel(zeta, rate):
    t, x = passage(zeta, 2 * np.pi * rate)
    for k in (np.abs(x).argmax(), len(t) // 2, len(t) - 1):
        assert x[k] == pytest.approx(duhamel(t[k], zeta, 2 * np.pi * rate), abs=1e-6)


@pytest.mark.parametrize(
    ("rows", "text"),
    [
        ((), "has no rows of three numbers"),
        (((0.0, 1.0),), "has no rows of three numbers"),
        (((0.0, 1.0, 0.1), (0.0, 1.0, 0.1)), "speeds must increase"),
        (((-0.1, 1.0, 0.1), (1.0, 0.0, 0.1)), "begin at -0.1"),
        (((0.0, 1.0, -0.1), (1.0, 0.0, 0.1)), "amplitude -0.1"),
    ],
)
def test_torques_that_make_no_sense_are_refused(rows, text):
    refused(EquationError, lambda: lp.assemble(lp.compose(motor=motor(torques=rows))), text)
