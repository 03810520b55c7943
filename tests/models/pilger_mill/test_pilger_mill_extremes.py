"""Cold pilger mill LG90: numbers of its kinematics, and extreme cases."""

import numpy as np
import pytest
from checks import apart
from pilger_turns import E, R, data, turn

import lumped as lp
from lumped.errors import ParameterError, SolverError
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.stand import Mill


class TestExtremes:
    def test_massless_rods_are_no_special_case(self):
        run = turn("P", m_rod=0.0, m_rod_1=0.0)
        table, p = data("curves_P"), stand.SETS["P"] | stand.DESIGNS["after"]
        w = stand.SPEED["P"]
        rolls = 1100 * (0.21 / 0.19) ** 2
        stroke = (p["m1"] + rolls) * table["a_m_s2"] * table["V_m_s"] / w
        expected = stroke + p["m2"] * table["a1_m_s2"] * table["V1_m_s"] / w
        received = stand.crank_torque(run) - table["Mroll_Nm"] - p["M0"]
        assert apart(received, expected) < 1e-9

    @pytest.mark.parametrize(
        ("length", "force", "torque"),
        [(4.25, None, 87e3), (42.5, 6.2e3, 8.2e3), (4250.0, 62, 81), (4.25e6, 0.062, 0.081)],
    )
    def test_long_rods_balance_to_first_order(self, length, force, torque):
        """Equal masses along x and y and S = (M + mq) R leave what the rods' slope does.

        The reference counts the rolls for the torque and not for the force.
        """
        w, p = stand.SPEED["P"], stand.SETS["P"]
        angle = np.radians(np.arange(361.0))
        runs = []
        for mass in (p["m1"], p["m1"] + 1100 * (0.21 / 0.19) ** 2):
            balanced = p | {"m1": mass, "m2": mass, "U": (mass + p["m_pin"]) * R / 4}
            free = {"m_rod": 0.0, "m_rod_1": 0.0, "T_f": 0.0, "M0": 0.0}
            part = Mill(**balanced | free | {"L": length, "L1": 0.8 * length})
            part = part.with_({"rolls.J": 1e-9})
            runs.append(stand.revolution(stand.turn_mill(part, w * lp.time), w, np.degrees(angle)))
        if length > 5:
            slope = np.abs(runs[0]["mill.stand.a"] / w**2 - R * np.cos(angle)).max()
            assert abs(slope * length / (R * (R + E)) - 1) < 0.02
            assert abs(np.hypot(*stand.shaking_force(runs[0]).T).max() / force - 1) < 0.01
        assert abs(np.ptp(stand.crank_torque(runs[1])) / torque - 1) < 0.01

    def test_position_keeps_its_digits_but_those_lost_beside_a_long_rod(self):
        length = 4.25e6
        run = turn("P", L=length, T_f=0.0)
        f = np.radians(np.arange(361.0))
        rise = R * np.sin(f) + E
        expected = -R * np.cos(f) + rise**2 / (2 * length)
        received = run["mill.stand.s"] + length
        assert 0 < np.abs(received - expected).max() < 4 * np.finfo(float).eps * length

    def test_one_train_without_other_inertia_is_singular_at_its_dead_centre(self):
        part = stand.mill("P", T_f=0.0, M0=-1e3, m_rod=0.0, m_rod_1=0.0, m2=0.0, U=0.0, m_pin=0.0)
        with pytest.raises(SolverError, match=r"step size shrank|not a finite number"):
            lp.simulate(lp.assemble(part), until=60.0, start={"crank.phi": 0.5})

    @pytest.mark.parametrize("key", ["m1", "m2", "U", "R"])
    def test_negative_masses_and_lengths_are_named(self, key):
        with pytest.raises(ParameterError, match=rf"mill\.{key} = -1"):
            turn("P", **{key: -1.0})
