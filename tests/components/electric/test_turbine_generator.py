"""Terminal faults of a turbine generator against tables made by another calculation.

`tests/data/torsional/03_ieee_first_benchmark`: dq states and fluxes in fixed axes, integrated by
DOP853 and Radau in SciPy; both agree within 4e-9 pu.
"""

from pathlib import Path

import numpy as np
import pytest
from benchmark_generator import (
    BASE,
    FREE,
    LINE,
    STANDARD,
    H,
    K,
    P,
    Q,
    TurbineGenerator,
    faulted,
    rotor_angle,
)

import lumped as lp
from lumped.components import Inertia, Spring, standard_parameters

DATA = Path(__file__).parents[2] / "data" / "torsional" / "03_ieee_first_benchmark"
FAULTS = {"abc": "three_phase_fault", "bc": "line_to_line_fault"}


def columns(name):
    return np.genfromtxt(DATA / f"{name}.csv", delimiter=",", names=True)


def values(name):
    rows = np.genfromtxt(DATA / f"{name}.csv", delimiter=",", skip_header=1, dtype=None)
    return {str(row[0]): float(row[1]) for row in rows}


def test_standard_parameters_give_the_circuit_of_the_benchmark():
    received, expected = standard_parameters(BASE, **STANDARD), values("machine_circuit")
    names = {"Ll": "L_ls", "Lad": "L_md", "Laq": "L_mq"}
    for name, value in expected.items():
        kind, winding = name[0], name[1:]
        known = names.get(name) or (f"R_{winding}" if kind == "R" else f"L_l{winding}")
        base = BASE.Z if kind == "R" else BASE.L
        assert received[known] / base == pytest.approx(value, rel=1e-9), name


def test_the_start_is_the_steady_state_of_the_phasors():
    model = TurbineGenerator()
    point = lp.start_point(lp.assemble(model), start={"gen.phi": 0.3}, free=FREE, time=-0.01)
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
    assert found["steam"] / BASE.tau == pytest.approx(expected["Te"], abs=1e-9)
    assert abs(found["bus.V"]) / BASE.v == pytest.approx(abs(1 - LINE * (P - 1j * Q)), rel=1e-9)


@pytest.mark.parametrize("phases", FAULTS)
def test_a_terminal_fault_follows_the_table(phases):
    table = columns(FAULTS[phases])
    # the voltage of phase a is at its maximum
    run = faulted(phases, 0.5, table["t_s"], rotor_angle() - np.pi / 2)
    names = {
        "air_gap_torque_pu": ("gen.tau", -BASE.tau),
        "LPA_LPB_pu": ("shafts[2].tau", -BASE.tau),
        "LPB_GEN_pu": ("shafts[3].tau", -BASE.tau),
        "id_pu": ("gen.i_d", -BASE.i),
        "iq_pu": ("gen.i_q", -BASE.i),
        "ifd_pu": ("gen.i_f", BASE.i),
    }
    for column in table.dtype.names[1:]:
        if column == "gen_speed_deviation_pu":
            received = run("gen.w") / BASE.speed - 1
        else:
            name, scale = names[column]
            received = run(name) / scale
        error = np.abs(received - table[column]).max()
        print(f"{phases} {column}: largest deviation {error:.1e} pu")
        assert error < 1e-6


def test_peaks_of_the_three_phase_fault_are_those_of_the_table():
    grid = np.linspace(0.0, 0.5, 15_001)
    run = faulted("abc", 0.5, grid, rotor_angle() - np.pi / 2)
    rows = np.genfromtxt(DATA / "three_phase_peaks.csv", delimiter=",", skip_header=1, dtype=None)
    names = {"air_gap": "gen.tau", "LPA_LPB_pu": "shafts[2].tau", "LPB_GEN_pu": "shafts[3].tau"}
    for where, extreme, at in rows:
        course = -run(names[str(where)]) / BASE.tau
        k = np.abs(course).argmax()
        assert course[k] == pytest.approx(extreme, abs=1e-6)
        assert grid[k] == pytest.approx(at, abs=1e-9)


def test_modes_are_those_of_the_benchmark():
    shafts = [Spring(c=k * BASE.tau) for k in K]
    bodies = [Inertia(J=BASE.J(h)) for h in H]
    line = lp.chain(*[x for pair in zip(bodies, shafts, strict=False) for x in pair], bodies[-1])
    train = lp.compose(shafts=shafts, bodies=bodies, connections=list(line))
    received = lp.modes(lp.assemble(train)).hertz
    assert received[-5:] == pytest.approx(columns("modes")["Hz"], rel=1e-9)
    # IEEE, as printed
    assert received[-5:] == pytest.approx([15.71, 20.21, 25.55, 32.28, 47.46], abs=0.0051)
