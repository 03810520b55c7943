"""Harmonic drive against the three lines of a catalogue, Willis and an independent integration.

The work of the torque is checked for all components together, in `powers`.
"""

import numpy as np
import pytest
import scipy
from rows import assemble_rows

import lumped as lp
from lumped.components import Fixed, HarmonicDrive, Inertia, Position, Speed, Torque
from lumped.errors import EquationError, ParameterError

DRIVE = HarmonicDrive(ratio=100.0, K1=1.6e4, K2=2.5e4, K3=2.9e4, T1=14.0, T2=48.0)
ERRORS = ((2, 2e-4, 0.3), (4, 5e-5, 1.1))


def torque(twist):
    """The three lines."""
    twists = np.cumsum([0, 14 / 1.6e4, 34 / 2.5e4, 1.0])
    return np.sign(twist) * np.interp(abs(twist), twists, [0, 14, 48, 48 + 2.9e4])


@pytest.mark.parametrize("tau", [-90.0, -48.0, -20.0, 9.0, 14.0, 30.0, 70.0])
def test_twist_is_that_of_the_three_lines(tau):
    system = assemble_rows(
        "wall drive.wave_generator",
        "drive.flexspline body load",
        wall=Fixed(),
        drive=DRIVE,
        body=Inertia(J=1.0),
        load=Torque(tau=tau),
    )
    point = lp.equilibrium(system)
    assert np.isclose(torque(point["drive.phi_rel"]), tau, rtol=1e-9)
    assert np.isclose(point["drive.wave_generator.tau"], tau / 100, rtol=1e-9)


@pytest.mark.parametrize(
    ("held", "output", "ratio"),
    [("circular_spline", "flexspline", -100.0), ("flexspline", "circular_spline", 101.0)],
)
def test_speeds_are_those_of_willis(held, output, ratio):
    system = assemble_rows(
        "turn drive.wave_generator",
        f"wall drive.{held}",
        f"drive.{output} body",
        turn=Speed(w=50.0),
        wall=Fixed(),
        drive=DRIVE,
        body=Inertia(J=1.0, w=50 / ratio),
    )
    run = lp.simulate(system, until=1.0, rtol=1e-10)
    assert np.abs(run["body.w"] - 50 / ratio).max() < 1e-9


def test_vibration_by_the_kinematic_error_against_an_independent_integration():
    w, J = 60.0, 0.9
    system = assemble_rows(
        "turn drive.wave_generator",
        "drive.flexspline body load",
        turn=Position(phi=w * lp.time),
        drive=DRIVE.with_({"errors": ERRORS}),
        body=Inertia(J=J, phi=0.0, w=-w / 100),
        load=Torque(tau=-10.0),
        keep=["body.phi"],
    )
    run = lp.simulate(system, until=0.5, grid=100, rtol=1e-10)

    times, index = np.unique(run.t, return_inverse=True)

    def rates(t, x):
        error = sum(a * np.sin(n * w * t + p) for n, a, p in ERRORS)
        return x[1], (-10.0 - torque(x[0] + w * t / 100 - error)) / J

    found = scipy.integrate.solve_ivp(
        rates, (0, 0.5), (0.0, -w / 100), t_eval=times, rtol=1e-11, atol=1e-13, max_step=1e-4
    )
    assert np.ptp(run["drive.tau"]) > 15  # crosses T1
    assert np.abs(run["body.w"] - found.y[1][index]).max() < 1e-8


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"T2": 10.0}, r"drive\.T2 = 10 N\.m .* greater than drive\.T1 = 14 N\.m"),
        ({"K1": 0.0}, r"drive\.K1 = 0 N\.m/rad"),
        ({"ratio": -100.0}, r"drive\.ratio = -100 .* greater than 0"),
        ({"errors": ((2, 1e-4),)}, r"errors = .* order, amplitude \(rad\) and phase \(rad\)"),
    ],
)
def test_what_makes_no_sense_is_refused(wrong, message):
    with pytest.raises((ParameterError, EquationError), match=message):
        assemble_rows(
            "turn drive.wave_generator",
            "drive.flexspline body",
            turn=Speed(w=1.0),
            drive=DRIVE.with_(wrong),
            body=Inertia(J=1.0),
        )
