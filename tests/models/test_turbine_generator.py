"""The turbine generator against tables made by another calculation, and one more by hand.

`tests/data/torsional/03_ieee_first_benchmark`: dq states and fluxes in fixed axes, integrated by
DOP853 and Radau in SciPy; both agree within 4e-9 pu.
"""

import numpy as np
import pytest
import scipy
from mill_by_hand import hertz
from torsional_cases import columns

import lumped as lp
from lumped.components import standard_parameters
from lumped.errors import OptionError
from lumped.models import machine
from lumped.models.turbine_generator import PUBLISHED, TORQUES
from lumped.models.turbine_generator.drive import (
    BASE,
    BEGIN,
    POWER,
    R_LINE,
    REACTIVE,
    SHAFTS,
    STANDARD,
    X_LINE,
    Train,
    TurbineGenerator,
)
from lumped.models.turbine_generator.scenes import FREE, clear_faults, per_unit, run_short_circuit
from lumped.points.direct_start import direct_start

CASE = "03_ieee_first_benchmark"
INERTIAS = (0.092897, 0.155589, 0.858670, 0.884215, 0.868495, 0.0342165)  # H, s
SPRINGS = (19.303, 34.929, 52.038, 70.858, 2.822)  # pu
FAULTS = {"abc": "three_phase_fault", "bc": "line_to_line_fault"}


def values(name):
    table = columns(CASE, f"{name}.csv", texts=("name",))
    (numbers,) = (column for key, column in table.items() if key != "name")
    return dict(zip(table["name"], numbers, strict=True))


def test_standard_parameters_give_the_circuit_of_the_benchmark():
    received, expected = standard_parameters(BASE, **STANDARD), values("machine_circuit")
    names = {"Ll": "L_ls", "Lad": "L_md", "Laq": "L_mq"}
    for name, value in expected.items():
        kind, winding = name[0], name[1:]
        known = names.get(name) or (f"R_{winding}" if kind == "R" else f"L_l{winding}")
        base = BASE.Z if kind == "R" else BASE.L
        assert received[known] / base == pytest.approx(value, rel=1e-9), name


def test_the_start_is_the_steady_state_of_the_phasors():
    system = lp.assemble(TurbineGenerator())
    point = lp.start_point(system, start={"gen.phi": 0.3}, free=FREE)
    expected = values("initial_state")
    scales = {"v": BASE.v, "i": BASE.i, "p": BASE.psi}
    for name, received in {
        "vd": point["gen.v_d"],
        "vq": point["gen.v_q"],
        "id": -point["gen.i_d"],
        "iq": -point["gen.i_q"],
        "ifd": point["gen.i_f"],
        "psi_d": point["gen.psi_d"],
        "psi_f": point["gen.psi_f"],
        "psi_1d": point["gen.psi_1d"],
        "psi_q": point["gen.psi_q"],
        "psi_1q": point["gen.psi_1q"],
        "psi_2q": point["gen.psi_2q"],
    }.items():
        assert received / scales[name[0]] == pytest.approx(expected[name], abs=1e-9), name
    found = point.parameters
    assert found["gen.v_f"] / BASE.v == pytest.approx(expected["efd"], rel=1e-8)
    assert -point["gen.tau"] / BASE.tau == pytest.approx(expected["Te"], abs=1e-9)
    assert found["turbine.steam"] / BASE.tau == pytest.approx(expected["Te"], abs=1e-9)
    inner = 1 - (R_LINE + 1j * X_LINE) * (POWER - 1j * REACTIVE)
    assert abs(found["bus.V"]) / BASE.v == pytest.approx(abs(inner), rel=1e-9)
    # its equations are not linear, and parameters follow from them
    assert direct_start(system, ()) is None


def test_phase_a_has_its_largest_voltage_when_the_fault_begins():
    for changed in ({}, {"gen.P_0": -0.5 * BASE.S, "fault.begin": 0.013, "bus.f": 50.0}):
        begin, f = changed.get("fault.begin", BEGIN), changed.get("bus.f", BASE.f)
        run = run_short_circuit(begin, parameters=changed, grid=200, rtol=1e-9)
        wires = [run[f"gen.{name}.v"][0] for name in "abc"]
        angles = 2 * np.pi * (-f * begin - np.arange(3) / 3)
        assert wires == pytest.approx(BASE.v * np.cos(angles), rel=1e-9)


@pytest.mark.parametrize("phases", FAULTS)
def test_a_terminal_fault_follows_the_table(phases):
    table = columns(CASE, f"{FAULTS[phases]}.csv")
    grid = np.concatenate([[0.0], BEGIN + table["t_s"]])
    run = run_short_circuit(phases=phases, grid=grid, rtol=1e-9)
    later = np.isin(run.t, grid[1:])
    known = {
        "air_gap_torque_pu": per_unit(run, "gen.tau"),
        "LPA_LPB_pu": per_unit(run, SHAFTS["LPA-LPB"]),
        "LPB_GEN_pu": per_unit(run, SHAFTS["LPB-GEN"]),
        "gen_speed_deviation_pu": run["gen.w"] / BASE.speed - 1,
        "id_pu": -run["gen.i_d"] / BASE.i,
        "iq_pu": -run["gen.i_q"] / BASE.i,
        "ifd_pu": run["gen.i_f"] / BASE.i,
    }
    for name in list(table)[1:]:
        error = np.abs(known[name][later] - table[name]).max()
        print(f"{phases} {name}: largest deviation {error:.1e} pu")
        assert error < 1e-6


def by_hand(t):
    """Torques of a three-phase fault, pu: dq equations at shorted terminals, six masses."""
    c, s = values("machine_circuit"), values("initial_state")
    H, K = np.array(INERTIAS), np.array(SPRINGS)
    w_0, R = 2 * np.pi * 60, 0.0025
    shares = np.array([0.30, 0.26, 0.22, 0.22, 0.0, 0.0]) * s["Te"]
    # currents into the machine: d, f, 1d and q, 1q, 2q
    d = np.full((3, 3), c["Lad"]) + np.diag([c["Ll"], c["Lf"], c["L1d"]])
    q = np.full((3, 3), c["Laq"]) + np.diag([c["Ll"], c["L1q"], c["L2q"]])
    to_d, to_q = np.linalg.inv(d), np.linalg.inv(q)
    R_d, R_q = np.array([R, c["Rf"], c["R1d"]]), np.array([R, c["R1q"], c["R2q"]])
    given = np.array([0.0, s["efd"], 0.0])

    def torque(x):
        return x[3] * (to_d @ x[:3])[0] - x[0] * (to_q @ x[3:6])[0]

    def rates(_, x):
        psi_d, psi_q, angles, speeds = x[:3], x[3:6], x[6:12], x[12:]
        turned = speeds[4] * np.array([psi_q[0], 0, 0]), speeds[4] * np.array([psi_d[0], 0, 0])
        shafts = K * (angles[:-1] - angles[1:])
        net = shares - np.append(shafts, 0) + np.append(0, shafts)
        net[4] -= torque(x)
        return np.concatenate(
            [
                w_0 * (given - R_d * (to_d @ psi_d) + turned[0]),
                w_0 * (-R_q * (to_q @ psi_q) - turned[1]),
                w_0 * (speeds - 1),
                net / (2 * H),
            ]
        )

    twists = np.append(np.cumsum(shares)[:4], 0.0) / K
    fluxes = [s[f"psi_{name}"] for name in ("d", "f", "1d", "q", "1q", "2q")]
    begin = [*fluxes, 0.0, *-np.cumsum(twists), *np.ones(6)]
    found = scipy.integrate.solve_ivp(
        rates, (0, t[-1]), begin, "DOP853", t_eval=t, rtol=1e-10, atol=1e-11
    )
    angles = found.y[6:12]
    shafts = K[:, None] * (angles[:-1] - angles[1:])
    return dict(zip(TORQUES, [np.array([torque(x) for x in found.y.T]), *shafts], strict=True))


@pytest.fixture(scope="module")
def rows(machine_rows):
    return {row.quantity: row for row in machine_rows("turbine_generator")}


def test_peaks_of_the_three_phase_fault_are_those_by_hand(rows):
    t = np.linspace(0.0, 0.5, 15_001)
    peaks = columns(CASE, "three_phase_peaks.csv", texts=("where",))
    table = dict(zip(peaks["where"], peaks["extreme_pu"], strict=True))
    same = {"air gap": "air_gap", "LPA-LPB": "LPA_LPB_pu", "LPB-GEN": "LPB_GEN_pu"}
    for name, course in by_hand(t).items():
        row = rows[f"three-phase fault, {name}, largest torque"]
        largest = course[np.abs(course).argmax()]
        print(f"{name}: {row.computed:.7f}, by hand {largest:.7f}")
        assert row.computed == pytest.approx(largest, abs=2e-6)
        assert float(row.remark.split()[0]) == pytest.approx(largest, abs=2e-6)
        if name in same:
            assert row.computed == pytest.approx(table[same[name]], abs=1e-6)


def test_a_line_to_line_fault_has_the_peaks_of_the_table_between_its_rows(rows):
    table = columns(CASE, "line_to_line_fault.csv")
    for name, column in (("air gap", "air_gap_torque_pu"), ("LPB-GEN", "LPB_GEN_pu")):
        course = scipy.interpolate.CubicSpline(table["t_s"], table[column])
        found = course(np.linspace(0.0, 0.5, 50_001))
        expected = found[np.abs(found).argmax()]
        received = rows[f"line-to-line fault, {name}, largest torque"].computed
        # interpolation between milliseconds, of a line at up to 180 Hz
        assert received == pytest.approx(expected, rel=0.01)


def test_modes_are_those_of_the_benchmark():
    modes = lp.modes(lp.assemble(Train()))
    table = columns(CASE, "modes.csv")
    assert modes.hertz == pytest.approx(table["Hz"], rel=1e-9)
    assert np.round(modes.hertz, 2) == pytest.approx(PUBLISHED, abs=1e-9)
    found = lp.vibration.mass_elastic(modes, shaft="gen.phi")
    assert found.left_out == ()
    bodies = {name: f"turbine.{name.lower()}" for name in ("HP", "IP", "LPA", "LPB")}
    bodies |= {"GEN": "gen", "EXC": "turbine.exciter"}
    for mode in range(5):
        holzer = found.holzer(mode)
        angles = np.array([holzer.angle(name) for name in bodies.values()])
        shape = np.array([table[name][mode] for name in bodies])
        k = np.abs(shape).argmax()
        assert angles / angles[k] == pytest.approx(shape / shape[k], abs=1e-8)


def test_clearing_takes_the_peaks_of_single_runs():
    durations = (0.03, 0.0475)
    found = clear_faults(durations, until=0.3)
    for i, duration in enumerate(durations):
        run = run_short_circuit(0.3, parameters={"fault.end": BEGIN + duration}, grid=20_000)
        for name, torque in SHAFTS.items():
            expected = np.abs(run[torque]).max()
            assert found[name][i] == pytest.approx(expected, rel=1e-4)


def test_what_is_changed_changes():
    own, stiff = (
        {m.quantity: m.value for m in machine("turbine_generator").measures(change)}
        for change in ({}, {"turbine.lpb_gen.c": 2e8})
    )
    K = BASE.w * np.array([*SPRINGS[:3], 2e8 / BASE.tau, SPRINGS[4]])
    expected = hertz(2 * np.array(INERTIAS), [(i, i + 1, k) for i, k in enumerate(K)])
    received = [stiff[f"torsional frequency, mode {i}"] for i in range(1, 6)]
    assert received == pytest.approx(expected, rel=1e-9)
    name = "torque of the shaft LPB-GEN, least"
    assert stiff[name] < own[name] < 0


@pytest.mark.parametrize("name", FREE)
def test_what_follows_from_the_start_is_not_given(name):
    with pytest.raises(OptionError, match=rf"{name} follows from the steady state.*gen\.P_0"):
        run_short_circuit(0.1, parameters={name: 1.0})
