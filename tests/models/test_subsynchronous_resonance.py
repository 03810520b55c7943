"""Series capacitor and turbine generator against the same plant in NumPy, in d and q."""

import numpy as np
import pytest
from checks import by_complex_step, refused
from rotor_axes import axis

import lumped as lp
from lumped.components import SeriesCapacitor
from lumped.errors import ParameterError
from lumped.models.turbine_generator import WORST
from lumped.models.turbine_generator.drive import (
    BASE,
    POWER,
    R_LINE,
    REACTIVE,
    SHAFTS,
    STANDARD,
    X_LINE,
    Compensated,
)
from lumped.models.turbine_generator.scenes import FREE, find_growth, find_rated_point

W = 2 * np.pi * 60
H = np.array((0.092897, 0.155589, 0.858670, 0.884215, 0.868495, 0.0342165))
K = np.array((19.303, 34.929, 52.038, 70.858, 2.822))


def by_hand(X_c):
    """Eigenvalues in per unit: fluxes of d and q with the line, capacitor, six angles and speeds.

    All axes turn with the rotor; currents flow into the machine.
    """
    (d, R_d), (q, R_q) = (
        axis(STANDARD[f"X_{a}"], STANDARD[f"T_{a}o"], STANDARD["X_l"], STANDARD["R_a"], W)
        for a in "dq"
    )
    with_d, with_q = (x + np.diag([X_LINE, 0, 0]) for x in (d, q))
    current = -(POWER - 1j * REACTIVE)
    rotor = np.exp(-1j * (np.angle(1 - (R_d[0] + 1j * q[0, 0]) * current) - np.pi / 2))
    bus = 1 + (R_LINE + 1j * (X_LINE - X_c)) * current
    v, i, e, u = (x * rotor for x in (1, current, bus, -1j * X_c * current))
    i_f = (v.imag - R_d[0] * i.imag - d[0, 0] * i.real) / d[0, 1]
    v_f = R_d[1] * i_f
    begin_d, begin_q = np.array([i.real, i_f, 0]), np.array([i.imag, 0, 0])
    torque = (q @ begin_q)[0] * i.real - (d @ begin_d)[0] * i.imag
    steam = torque * np.array([0.30, 0.26, 0.22, 0.22, 0.0, 0.0])
    twists = np.append(np.cumsum(steam)[:4], 0.0) / K
    angles = np.append(0.0, -np.cumsum(twists))
    angles -= angles[4]
    to_d, to_q = np.linalg.inv(with_d), np.linalg.inv(with_q)
    R_d, R_q = (R + np.array([R_LINE, 0, 0]) for R in (R_d, R_q))

    def rates(*x):
        x = np.array(x)
        psi_d, psi_q, u_d, u_q, angle, speed = x[:3], x[3:6], x[6], x[7], x[8:14], x[14:]
        i_d, i_q, w = to_d @ psi_d, to_q @ psi_q, speed[4]
        c, s = np.cos(angle[4]), np.sin(angle[4])
        v_d, v_q = e.real * c + e.imag * s - u_d, e.imag * c - e.real * s - u_q
        shafts = K * (angle[:-1] - angle[1:])
        net = steam - np.append(shafts, 0) + np.append(0, shafts)
        net[4] += (d @ i_d)[0] * i_q[0] - (q @ i_q)[0] * i_d[0]
        one = np.array([1.0, 0, 0])
        return np.concatenate(
            [
                W * (v_d * one + [0, v_f, 0] - R_d * i_d + w * psi_q[0] * one),
                W * (v_q * one - R_q * i_q - w * psi_d[0] * one),
                W * np.array([X_c * i_d[0] + w * u_q, X_c * i_q[0] - w * u_d]),
                W * (speed - 1),
                net / (2 * H),
            ]
        )

    steady = np.concatenate([with_d @ begin_d, with_q @ begin_q, [u.real, u.imag], angles, [1] * 6])
    assert np.abs(rates(*steady)).max() < 1e-9
    return np.linalg.eigvals(by_complex_step(rates, steady))


@pytest.mark.parametrize("X_c", [0.05, 0.371, *(X_c for X_c, _ in WORST.values())])
def test_all_eigenvalues_are_those_by_hand(X_c):
    system = lp.assemble(Compensated())
    point = find_rated_point(system, {"X_c": X_c})
    received = np.linalg.eigvals(lp.linearise(system, at=point).A)
    at_rest = np.abs(received) < 1e-9  # both currents of the open fault
    assert at_rest.sum() == 2
    received, expected = received[~at_rest], by_hand(X_c)
    assert len(received) == len(expected)
    distances = np.abs(received[:, None] - expected)
    assert distances.min(axis=0).max() < 1e-7
    assert distances.min(axis=1).max() < 1e-7


@pytest.mark.parametrize("mode", WORST)
def test_each_mode_grows_fastest_at_its_worst_reactance(mode):
    X_c, printed = WORST[mode]
    received = find_growth([X_c - 0.002, X_c, X_c + 0.002])[:, mode - 1]
    expected = by_hand(X_c).real.max()
    assert received[1] == pytest.approx(expected, abs=1e-7)
    assert printed == pytest.approx(expected, abs=1e-6)
    assert received[1] > max(received[0], received[2])


class Shaken(Compensated):
    """The same plant, which begins in any state."""

    def initial_equations(self):
        return iter(())


def test_a_run_grows_at_the_rate_of_its_eigenvalue():
    """The excited mode alone: ``Re(a exp(s t))`` times its shape, added to the steady state."""
    X_c, _ = WORST[1]
    system = lp.assemble(Compensated())
    point = find_rated_point(system, {"X_c": X_c})
    roots, shapes = np.linalg.eig(lp.linearise(system, at=point).A)
    root, shape = roots[np.argmax(roots.real)], shapes[:, np.argmax(roots.real)]
    twist = SHAFTS["LPB-GEN"].replace("tau", "phi_rel")
    k = system.state_names.index(twist)
    shape *= 1e-6 / shape[k]
    run = lp.simulate(
        lp.assemble(Shaken().with_({"gen.steady": False})),
        until=0.5,
        grid=501,
        start=dict(zip(system.state_names, point.x + shape.real, strict=True)),
        parameters={"X_c": X_c} | {name: point.parameters[name] for name in FREE},
        rtol=1e-12,
    )
    received = run[twist] - point[twist]
    expected = 1e-6 * np.exp(root * run.t).real
    assert root.real == pytest.approx(by_hand(X_c).real.max(), abs=1e-7)
    assert received == pytest.approx(expected, abs=1e-4 * 1e-6 * np.exp(0.5 * root.real))


def test_a_capacitance_of_zero_is_refused():
    model = Compensated(capacitor=SeriesCapacitor(C=0.0, f=BASE.f))
    refused(ParameterError, lambda: lp.assemble(model), "capacitor.C = 0 F")
