"""The diesel engine against tables made with matrices, a balance of energies and closed forms."""

import numpy as np
import pytest
import scipy
from torsional_cases import FIRST, INERTIAS, STIFFNESSES, columns, peak_share

import lumped as lp
from lumped.components import ViscousDamper
from lumped.models.diesel_genset import BY_SCIPY, NATURAL
from lumped.models.diesel_genset.drive import (
    C_COUPLING,
    D_RING,
    J_GENERATOR,
    J_RING,
    PSI,
    RPM,
    D,
    Genset,
    load,
)
from lumped.models.diesel_genset.pressure import CURVE, PEAK
from lumped.models.diesel_genset.scenes import (
    CASES,
    FUEL,
    SPEEDS,
    mean_modes,
    misfiring,
    response,
    run_up,
    solve_crankshaft,
    vector_sums,
)

CASE = "02_six_cylinder_crankshaft"
TABLES = {
    "all cylinders fire": ("synthesis_shafts_1_8.csv", ""),
    "cylinder 1 compresses only": ("misfire_cylinder1.csv", "compression_only_"),
    "cylinder 1 has no gas": ("misfire_cylinder1.csv", "no_gas_"),
}
OUTER = {8: "shaft_8.tau_c", 1: "shaft_1.tau_c"}


def matrices():
    """Frequencies, Hz, and shapes of the crankshaft without damping."""
    K = np.zeros((9, 9))
    for i, c in enumerate(STIFFNESSES):
        K[i : i + 2, i : i + 2] += c * np.array([[1, -1], [-1, 1]])
    squares, shapes = scipy.linalg.eigh(K, np.diag(INERTIAS))
    return np.sqrt(squares[1:]) / (2 * np.pi), shapes[:, 1:]


@pytest.fixture(scope="module")
def rows(machine_rows):
    return {row.quantity: row for row in machine_rows("diesel_genset")}


def test_pressures_are_the_digitised_ones():
    curve, peak = columns(CASE, "pressure_curve.csv"), columns(CASE, "peak_pressure.csv")
    assert np.array(CURVE) == pytest.approx(np.transpose(list(curve.values())), rel=1e-12)
    assert np.array(PEAK) == pytest.approx(np.transpose(list(peak.values())), rel=1e-12)
    for rpm in (800.0, 1013.0, 2222.0, 2600.0):
        assert load(rpm * RPM) == pytest.approx(peak_share(rpm), rel=1e-12)


def test_natural_frequencies_are_those_of_the_matrices(rows):
    table = columns(CASE, "natural_frequencies.csv")["Hz"]
    hertz, _ = matrices()
    assert table == pytest.approx(hertz[:5], rel=1e-9)
    for i, (known, expected) in enumerate(zip(NATURAL, hertz, strict=False), 1):
        assert rows[f"natural frequency, mode {i}"].computed == pytest.approx(expected, rel=1e-9)
        assert float(known) == pytest.approx(expected, abs=6e-5)


@pytest.mark.parametrize("case", CASES)
def test_vibrations_are_those_of_the_matrices(rows, case):
    name, prefix = TABLES[case]
    table, steady = columns(CASE, name), solve_crankshaft(case)
    assert np.array_equal(table["rpm"], SPEEDS)
    for k, (number, torque) in enumerate(OUTER.items()):
        expected = table[f"{prefix}shaft{number}_maxabs"]
        received = steady.synthesis(torque).maximum
        error = np.abs(received / expected - 1).max()
        print(f"{case}, shaft {number}: {error:.1e}")
        assert error < 5e-4  # harmonics of the kinked table by other points
        assert float(BY_SCIPY[case][k]) == pytest.approx(expected.max(), abs=6e-3)
        row = rows[f"shaft {number}, largest torque, {case}"]
        assert row.computed == pytest.approx(expected.max(), rel=1e-4)


def test_sums_have_the_peaks_of_the_picture(rows):
    table = columns(CASE, "synthesis_shafts_1_8.csv")
    for number in OUTER:
        sums = table[f"shaft{number}_sum_of_amplitudes"]
        row = rows[f"shaft {number}, largest sum of amplitudes"]
        assert row.computed == pytest.approx(sums.max(), rel=1e-4)
        assert row.computed == pytest.approx(row.published, rel=0.01)
        speed = rows[f"shaft {number}, speed there"]
        assert speed.computed == table["rpm"][sums.argmax()]
        assert abs(speed.computed - speed.published) < 25


def test_phase_diagrams_follow_from_the_shape_and_the_firing_order():
    sums = vector_sums([0.5, 1.5, 3.0, 5.0])
    amplitudes = matrices()[1][2:8, 0] / matrices()[1][0, 0]
    for k, order in enumerate(sums.orders):
        turned = amplitudes * np.exp(-1j * order * np.array(FIRST) * 2 * np.pi / 3)
        # damping, and the speed in the masses' torque, change the shape a little
        assert abs(sums.values[0, k]) == pytest.approx(abs(turned.sum()), abs=2e-3)


def test_the_fluid_is_near_the_best_one():
    """Den Hartog's for the inertia of the first mode, seen from the pulley."""
    hertz, shapes = matrices()
    shape = shapes[:, 0] / shapes[0, 0]
    inertia = float(np.array(INERTIAS) @ shape**2)
    best = ViscousDamper.optimum(J_RING / inertia)
    assert pytest.approx(2 * J_RING * 2 * np.pi * hertz[0] * best.ring, rel=0.01) == D_RING


def test_the_coupling_vibrates_as_two_masses_behind_it():
    """Below all other modes engine and generator are two inertias on the coupling."""
    engine, generator = sum(INERTIAS) + J_RING, float(J_GENERATOR)
    for flywheel in (2.075, 3.0):
        modes = mean_modes(Genset(), {"flywheel.J": flywheel})
        table = lp.vibration.mass_elastic(modes, shaft="flywheel.phi")
        inverse = 1 / (engine + flywheel - 2.075) + 1 / generator
        expected = np.sqrt(C_COUPLING * inverse) / (2 * np.pi)
        assert table.hertz[0] == pytest.approx(expected, rel=1e-2)
    rpm = np.array([900.0, 1130.0, 1500.0])
    found = response(rpm, misfiring(Genset(), "no gas"), ["coupling.tau"])
    expected = []
    for n in rpm:
        # order 0.5 of five cylinders is that of the missing one, reversed
        gas = np.hypot(*harmonic(0.5)) * load(n * RPM)
        w, stiff = 0.5 * n * RPM, C_COUPLING * (1 + 1j * PSI / (2 * np.pi))
        matrix = np.diag([-engine * w**2 + 6 * 2.0j * w, -generator * w**2])
        matrix = matrix + stiff * np.array([[1, -1], [-1, 1]])
        twist = np.diff(np.linalg.solve(matrix, [gas, 0.0]))[0]
        expected.append(abs(stiff * twist))
    received = found.magnitude("coupling.tau", 0.5)
    assert received == pytest.approx(expected, rel=0.005)


def harmonic(order):
    """Of the torque of the gas of a cylinder at the pressure of the curve, N.m."""
    table, name = columns(CASE, "cylinder_harmonics_1000.csv"), "firing_{}_Nm"
    k = list(table["order"]).index(order)
    return [table[name.format(part)][k] / peak_share(1000.0) for part in ("re", "im")]


def test_the_start_gains_the_work_of_the_gas():
    run = run_up(1.2, grid=4000)
    w, t = run["flywheel.w"], run.t
    cycle = np.interp(run["flywheel.phi"][-1] - 4 * np.pi * np.arange(4), run["flywheel.phi"], t)
    inertia = sum(INERTIAS) + J_RING + J_GENERATOR
    slope = np.diff(np.interp(cycle, t, w)) / np.diff(cycle)
    expected = 6 * FUEL * harmonic(0)[0] / inertia
    assert slope.mean() == pytest.approx(expected, rel=0.01)
    # order 3 passes the natural frequency of the coupling in the first half second
    torque = np.abs(run["coupling.tau"])
    assert t[torque.argmax()] < 0.5
    assert torque.max() > 5 * 6 * FUEL * harmonic(0)[0] * J_GENERATOR / inertia


def test_the_load_that_balances_falls_with_the_damping_of_the_throws():
    system, speeds = lp.assemble(Genset()), np.linspace(44.0, 251.0, 300)
    found = lp.vibration.order_response(
        system,
        speeds=speeds,
        of=["coupling.tau"],
        shaft="flywheel.phi",
        turns=2,
        free="electric.tau",
    )
    torque = found.rotation.theta[:, system.places(["electric.tau"])[0]]
    np.testing.assert_allclose(torque - torque[0], 6 * D * (speeds - speeds[0]), atol=1e-6)
