"""Wind: gusts and turbulence by their formulas, rotors at steady speed."""

import numpy as np
import pytest
from rows import assemble_row
from scipy.integrate import quad

import lumped as lp
from lumped.components import (
    Inertia,
    LinearTorque,
    Speed,
    Table,
    WindRotor,
    extreme_gust,
    operating_gust,
    turbulence,
)
from lumped.errors import EquationError, OptionError, SolverError

ROWS = ((2.0, 0.1), (8.0, 0.48), (12.0, 0.24))
R, RHO = 40.0, 1.225


def test_torque_follows_the_power_coefficient_at_its_rows():
    for x, c_p in ROWS:
        v = 9.0
        model = assemble_row(
            turn=Speed(w=x * v / R * (1 - 1e-12)), rotor=WindRotor(coefficients=ROWS, R=R, v=v)
        )
        point = lp.start_point(model)
        power = RHO / 2 * np.pi * R**2 * v**3 * c_p
        assert point["rotor.tau"] * point["rotor.w"] == pytest.approx(power, rel=1e-9)


@pytest.mark.parametrize(("v", "k"), [(8.0, 2.5e5), (11.0, 3e5)])
def test_it_settles_where_the_load_takes_its_torque(v, k):
    """Between two rows ``A v^2 (a + b w R / v) = k w``."""
    (x_1, p_1), (x_2, p_2) = ROWS[1:]
    b = (p_2 / x_2 - p_1 / x_1) / (x_2 - x_1)
    a = p_1 / x_1 - b * x_1
    A = RHO / 2 * np.pi * R**3
    w = A * v**2 * a / (k - A * v * R * b)
    assert x_1 < w * R / v < x_2
    model = assemble_row(
        rotor=WindRotor(coefficients=ROWS, R=R, v=v),
        body=Inertia(J=1e4, w=w * 0.9),
        load=LinearTorque(tau_nominal=-k, w_nominal=1.0),
    )
    run = lp.simulate(model, until=10.0, rtol=1e-11)
    assert run["body.w"][-1] == pytest.approx(w, rel=1e-9)


def test_a_gust_is_that_of_the_standard():
    system = assemble_row(
        turn=Speed(w=1.0),
        rotor=WindRotor(coefficients=ROWS, R=R, v=operating_gust(10.0, 6.0, begin=3.0)),
    )
    at = np.linspace(0.0, 20.0, 401)
    run = lp.simulate(system, until=20.0, grid=at)
    t = np.clip(at - 3.0, 0, 10.5)
    expected = 10 - 0.37 * 6 * np.sin(3 * np.pi * t / 10.5) * (1 - np.cos(2 * np.pi * t / 10.5))
    assert run["rotor.w"] * R / run["rotor.x"] == pytest.approx(expected, rel=1e-12)
    # highest in the middle: 2 times 0.37 v_gust; it begins with a dip
    assert expected.max() == pytest.approx(10 + 0.74 * 6, rel=1e-3)
    assert expected.min() < 9


def test_the_size_of_the_gust_is_the_lesser_of_two():
    """Class IA at 25 m/s, D = 80 m, z = 80 m: 3.3 x 0.16 (18.75 + 5.6) / (1 + 8 / 42)."""
    assert extreme_gust(25.0, 50.0, 0.16, 80.0, 80.0) == pytest.approx(
        3.3 * 0.16 * 24.35 / (1 + 8 / 42), rel=1e-12
    )
    assert extreme_gust(40.0, 37.5, 0.16, 80.0, 80.0) == pytest.approx(1.35 * 2.0, rel=1e-12)
    assert extreme_gust(25.0, 50.0, 0.16, 35.0, 50.0) == pytest.approx(
        3.3 * 0.16 * 24.35 / 1.1, rel=1e-12
    )


class TestTurbulence:
    v, sigma, z, T, dt = 12.0, 1.8, 90.0, 600.0, 0.05

    def spectrum(self, f):
        L = 8.1 * 42.0
        return 4 * self.sigma**2 * L / self.v / (1 + 6 * f * L / self.v) ** (5 / 3)

    def test_it_has_the_spectrum_of_kaimal(self):
        times, speeds = map(np.array, turbulence(self.v, self.sigma, self.z, self.T, self.dt))
        n = len(times) - 1
        assert times[-1] == pytest.approx(self.T, rel=1e-12)
        assert speeds[-1] == speeds[0]
        lines = np.fft.rfft(speeds[:-1]) / n
        f = np.arange(1, n // 2) / self.T
        assert lines[0].real == pytest.approx(self.v, rel=1e-12)
        received = 2 * np.abs(lines[1:-1]) ** 2 * self.T
        assert received == pytest.approx(self.spectrum(f), rel=1e-8)

    def test_its_variance_is_that_of_the_spectrum_between_its_frequencies(self):
        assert quad(self.spectrum, 0, np.inf)[0] == pytest.approx(self.sigma**2, rel=1e-6)
        _, speeds = turbulence(self.v, self.sigma, self.z, self.T, self.dt)
        f = np.arange(1, round(self.T / self.dt) // 2) / self.T
        expected = self.spectrum(f).sum() / self.T
        assert np.var(speeds[:-1]) == pytest.approx(expected, rel=1e-10)
        assert 0.85 * self.sigma**2 < expected < self.sigma**2

    def test_a_seed_gives_the_same_wind_and_another_seed_another_one(self):
        one, again, other = (
            np.array(turbulence(self.v, self.sigma, self.z, 60.0, 0.5, seed=s)[1])
            for s in (3, 3, 4)
        )
        assert np.array_equal(one, again)
        assert np.abs(one - other).max() > 0.1 * self.sigma

    def test_a_rotor_turns_with_it(self):
        times, speeds = turbulence(self.v, self.sigma, self.z, 20.0, 0.5)
        model = lp.compose(
            wind=Table(times=times, values=speeds),
            rotor=WindRotor(coefficients=ROWS, R=R),
            turn=Speed(w=2.0),
            connections=lambda m: [
                lp.connect(m.wind.y, m.rotor.v),
                *lp.chain(m.turn, m.rotor),
            ],
        )
        run = lp.simulate(lp.assemble(model), until=20.0, grid=times)
        assert 2.0 * R / run["rotor.x"] == pytest.approx(speeds, rel=1e-9)


class TestRefused:
    @pytest.mark.parametrize(
        ("rows", "words"),
        [
            ((), "rows of tip speed ratio"),
            (((0.0, 0.0), (8.0, 0.4)), "from zero must increase, but 0 -> 0"),
            (((8.0, 0.4), (7.0, 0.3)), "8 -> 7"),
        ],
    )
    def test_rows_that_fall(self, rows, words):
        with pytest.raises(EquationError, match=words):
            assemble_row(turn=Speed(w=1.0), rotor=WindRotor(coefficients=rows, R=R, v=9.0))

    def test_a_rotor_that_runs_beyond_its_table(self):
        model = assemble_row(
            rotor=WindRotor(coefficients=ROWS, R=R, v=9.0), body=Inertia(J=1e4, w=2.6)
        )
        with pytest.raises(SolverError, match="tip speed ratio"):
            lp.simulate(model, until=10.0)

    @pytest.mark.parametrize(
        ("v", "words"),
        [
            (-5 * lp.ops.cos(lp.time), "speed of the wind = -5 m/s"),
            (0.0, "or wind above zero"),
        ],
    )
    def test_wind_from_behind_and_none(self, v, words):
        rotor = WindRotor(coefficients=ROWS, R=R, v=v)
        with pytest.raises(SolverError, match=words):
            lp.simulate(assemble_row(rotor=rotor, body=Inertia(J=1e4, w=0.1)), until=1.0)

    def test_a_gust_beyond_the_extreme_wind(self):
        """``0.8 1.4 50 = 56 m/s``."""
        assert extreme_gust(55.9, 50.0, 0.16, 80.0, 80.0) == pytest.approx(0.135, rel=1e-9)
        with pytest.raises(OptionError, match=r"v = 60 m/s.* 56 m/s"):
            extreme_gust(60.0, 50.0, 0.16, 80.0, 80.0)

    @pytest.mark.parametrize(
        ("given", "words"),
        [
            ({"sigma": -1.0}, "sigma = -1"),
            ({"step": 0.7}, "even multiple"),
            ({"duration": -5.0}, "duration = -5"),
        ],
    )
    def test_turbulence_of_no_sense(self, given, words):
        with pytest.raises(OptionError, match=words):
            turbulence(**{"v": 9.0, "sigma": 1.0, "z": 80.0, "duration": 60.0, "step": 0.5} | given)
