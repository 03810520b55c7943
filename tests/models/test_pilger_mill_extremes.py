"""Cold pilger mill LG90: numbers of its kinematics, and extreme cases."""

import numpy as np
import pytest
from checks import apart
from pilger_turns import E, L, R, data, turn

import lumped as lp
from lumped.errors import ParameterError, SolverError
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.stand import AsPrinted, Mill


class TestKinematics:
    """Numbers that follow from R, L, L1 and e."""

    def test_harmonics_of_the_accelerations_are_those_of_the_reference(self):
        run, w = turn("P"), stand.SPEED["P"]
        # two thirds of a unit of the last digit
        expected = {
            "stand": {"cos": {1: 1, 2: 0.140795, 4: -0.000711}, "sin": {1: -0.078459, 3: 0.001741}},
            "weight": {"cos": {2: -0.174855, 4: -0.001337}, "sin": {1: 1}},
        }
        for part, kinds in expected.items():
            series = np.fft.rfft(run[f"mill.{part}.a"][:-1]) * 2 / 360 / (w**2 * R)
            for kind, values in kinds.items():
                received = series.real if kind == "cos" else -series.imag
                for k, value in values.items():
                    assert abs(received[k] - value) < 7e-7, (part, kind, k)

    def test_extremes_are_those_of_the_reference(self):
        degrees = np.arange(0.0, 360.005, 0.01)
        run, w = turn("P", degrees=degrees), stand.SPEED["P"]
        v = run["mill.stand.v"] / w
        for at, value, place in ((v.argmax(), 0.603907, 78.03), (v.argmin(), -0.591098, 273.46)):
            assert abs(v[at] - value) < 5.1e-7
            assert abs(degrees[at] - place) < 0.0101
        lean = np.degrees(np.pi - run["mill.stand.psi"] % (2 * np.pi))
        lean_1 = np.degrees(run["mill.weight.psi"] % (2 * np.pi) - np.pi)
        assert abs(np.abs(lean).max() - 12.5018) < 5.1e-5
        assert abs(np.abs(lean_1).max() - 9.9931) < 5.1e-5
        ends = np.degrees([-np.arcsin(E / (L + R)), np.pi - np.arcsin(E / (L - R))])
        assert np.abs(ends - [-3.909564, 174.826962]).max() < 5.1e-7
        assert np.abs(np.diff(ends) - 178.7365).max() < 5.1e-5

    @pytest.mark.parametrize("kind", [Mill, AsPrinted])
    def test_inertia_does_no_work_over_a_cycle(self, kind):
        torque = stand.crank_torque(turn("P", kind=kind, T_f=0.0, M0=0.0))
        assert abs(torque[:-1].mean()) < 1e-12 * torque.max()


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
