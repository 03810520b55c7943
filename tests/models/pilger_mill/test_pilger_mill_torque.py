"""Cold pilger mill LG90: rods by (9) to (12), parts of the torque by (29) and (30), the optimum."""

import numpy as np
import pytest
from checks import apart
from pilger_turns import L1, E, L, R, data, turn

import lumped as lp
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.design import RANGES, find_weighted_optimum, run_revolution
from lumped.models.pilger_mill.stand import AsPrinted
from lumped.models.pilger_mill.torque import rod_motion, split_torque


@pytest.mark.parametrize("name", ["P", "F"])
class TestTurn:
    def test_rods_turn_by_the_closed_forms(self, name):
        w, f = stand.SPEED[name], np.radians(np.arange(361.0))
        t, t1 = np.arcsin((R * np.sin(f) + E) / L), np.arcsin(R * np.cos(f) / L1)
        bend = R * np.sin(t) * np.cos(f) ** 2 / (L * np.cos(t) ** 3)
        bend1 = R * np.sin(t1) * np.sin(f) ** 2 / (L1 * np.cos(t1) ** 3)
        expected = {
            "wL": w * R * np.cos(f) / (L * np.cos(t)),
            "wL1": -w * R * np.sin(f) / (L1 * np.cos(t1)),
            "xiL": w**2 * R / L * (bend - np.sin(f) / np.cos(t)),
            "xiL1": w**2 * R / L1 * (bend1 - np.cos(f) / np.cos(t1)),
        }
        received = rod_motion(turn(name))
        assert list(received) == list(expected)
        for key, values in expected.items():
            assert apart(received[key], values) < 1e-12, key

    def test_parts_of_the_torque_are_those_of_the_reference(self, name):
        table = data(f"curves_{name}")
        # MZ + Mf of a roll: greatest force on the slider times the pinion's radius over two
        share = 0.001 * 2e6 * 0.25 / 2 / (stand.SETS[name]["T_f"] / R * 0.19 / 2)
        load, total = table["Mroll_Nm"], table["M_paper_Nm_after"]
        expected = {
            "rolling": (1 - share) * load,
            "necks": share * load,
            "idle": 0.04 * total,
            "feed": np.full(361, stand.SETS[name]["M0"]),
            "inertia": table["Mg1_paper_Nm_after"] + table["Mg2_paper_Nm_after"],
        }
        received = split_torque(turn(name, kind=AsPrinted), stand.SPEED[name])
        assert list(received) == list(expected)
        for key, values in expected.items():
            # the greatest force lies between two of the degrees: 4e-5 of it are missed
            assert np.abs(received[key] - values).max() < 4e-5 * np.abs(total).max(), key

    def test_friction_of_the_necks_has_the_arm_of_half_their_diameter(self, name):
        """P f d / 2 for each roll: 250 N.m where the force is greatest, times 2 wG / w."""
        run = turn(name, kind=AsPrinted, degrees=np.arange(0.0, 360.01, 0.1))
        w = stand.SPEED[name]
        place = np.abs(run["mill.load.f"]).argmax()
        rolls = np.abs(run["mill.stand.v"][place]) / 0.19
        expected = 2 * rolls / w * 2e6 * 0.001 * 0.25 / 2
        received = split_torque(run, w)["necks"][place]
        assert received == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "m2", "U", "objective"),
    [("F", 7237.6, 3138.15, 2.00219), ("P", 7143.7, 3146.31, 2.01675)],
)
def test_weighted_optimum_by_ipopt_is_that_of_the_reference(name, m2, U, objective):
    found = find_weighted_optimum(name)
    # two methods of the reference differ by so much
    assert abs(found.parameters["m2"] - m2) < 0.3
    assert abs(found.parameters["U"] - U) < 0.1
    assert abs(found.objective - objective) < 2e-5


@pytest.mark.parametrize(
    ("name", "light", "F10", "even", "F20"),
    [("F", 7237.7, 312592, 7156.6, 84352.8), ("P", 6683.1, 58727.7, 7143.7, 84441.4)],
)
def test_ends_of_the_front_are_the_single_optima_of_the_reference(name, light, F10, even, F20):
    aims = lp.functionals.peak("force"), lp.functionals.swing("torque")
    front = lp.optimisation.pareto(run_revolution(name), vary=RANGES, minimise=aims, count=2)
    for design, mass in zip(front.designs, (light, even), strict=True):
        assert abs(design.parameters["m2"] - mass) < 0.3
    assert front.values[0, 0] == pytest.approx(F10, rel=1e-5)
    assert front.values[1, 1] == pytest.approx(F20, rel=2e-5)
    if name == "P":
        assert abs(front.designs[0].parameters["U"] - 3084.42) < 0.1


def test_rows_have_the_closed_forms_beside_them(machine_rows):
    rows = {row.quantity: row for row in machine_rows("pilger_mill")}
    w = 63.982 * np.pi / 30
    high, low = np.sqrt(L**2 - (R + E) ** 2), np.sqrt(L1**2 - R**2)  # where sin f = 1, cos f = 1
    expected = {
        "speed of the stand's rods at 0 deg (9)": w * R / np.sqrt(L**2 - E**2),
        "speed of the counterweight's rods at 90 deg (10)": -w * R / L1,
        "acceleration of the stand's rods at 90 deg (11)": -(w**2) * R / high,
        "acceleration of the counterweight's rods at 0 deg (12)": -(w**2) * R / low,
    }
    for quantity, value in expected.items():
        row = rows[f"set P, {quantity}"]
        assert row.computed == pytest.approx(value, rel=1e-12)
        assert row.remark.startswith(f"{value:.5f}")
    table = data("curves_P")
    idle = 0.04 * table["M_paper_Nm_after"] / 1e3
    for end, value in (("greatest", idle.max()), ("least", idle.min())):
        received = rows[f"set P, idle friction at the crank, {end}"].computed
        assert abs(received - value) < 1e-3 * idle.max()  # the rows have two angles a degree
