"""Loads and life of bearings by hand."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Damper, Fixed, Inertia
from lumped.errors import OptionError, UnitError
from lumped.life import (
    Bearing,
    equivalent_load,
    mean_speed,
    reliability_factor,
    temperature_factor,
)

TAPER = Bearing("1000 kN", "1.9 MN", e=0.35, Y_1=1.9, Y_2=2.9, Y_0=1.9)
BALL = Bearing(35.1e3, 23.2e3, e=0.22, Y_1=0.0, Y_2=1.99, Y_0=0.5, X_2=0.56, exponent=3.0)


class TestLoad:
    def test_a_small_axial_load_counts_with_the_first_factors(self):
        assert TAPER.dynamic_load(100e3, 30e3) == pytest.approx(100e3 + 1.9 * 30e3)

    def test_a_large_axial_load_counts_with_the_second_factors(self):
        assert TAPER.dynamic_load(100e3, -60e3) == pytest.approx(67e3 + 2.9 * 60e3)

    def test_the_border_belongs_to_the_first_factors(self):
        assert TAPER.dynamic_load(100e3, 35e3) == pytest.approx(100e3 + 1.9 * 35e3)

    def test_a_ball_bearing_carries_a_small_axial_load_for_nothing(self):
        assert BALL.dynamic_load(5e3, 1e3) == pytest.approx(5e3)
        assert BALL.dynamic_load(5e3, 2e3) == pytest.approx(0.56 * 5e3 + 1.99 * 2e3)

    def test_static_load(self):
        assert TAPER.static_load(-100e3, 40e3) == pytest.approx(100e3 + 1.9 * 40e3)


class TestLife:
    def test_a_ball_bearing_by_hand(self):
        """C = 35.1 kN, P = 3.51 kN: a thousand million revolutions, 11 111 h at 1500 rpm."""
        assert BALL.revolutions(3.51e3) == pytest.approx(1e9, rel=1e-12)
        speed = 1500 * 2 * np.pi / 60
        assert BALL.hours(3.51e3, speed=speed) == pytest.approx(1e9 / (60 * 1500), rel=1e-12)

    def test_a_roller_bearing_by_hand(self):
        """C / P = 8: 2^10 million revolutions, as 8^(10/3) is 2^10."""
        assert TAPER.revolutions(125e3) == pytest.approx(1024e6, rel=1e-12)

    def test_a_load_at_the_rating_lasts_a_million_revolutions(self):
        assert TAPER.revolutions(1000e3) == pytest.approx(1e6, rel=1e-14)

    def test_life_of_a_run_and_its_slope(self):
        """A body runs down in oil: the force on the bearing is 100 times its torque k w."""
        model = lp.compose(
            body=Inertia(J=2.0, w=50.0),
            drag=Damper(d=0.5),
            wall=Fixed(),
            connections=lambda m: [*lp.chain(m.body, m.drag, m.wall)],
        )
        radial = 100 * model.drag.tau
        of = BALL.dynamic_load(radial, 0.5 * radial), model.body.w
        life = BALL.hours(equivalent_load(of, exponent=3.0), speed=mean_speed(of[1]))
        found = lp.gradient(lp.assemble(model), of=[life], by=["drag.d"], until=3.0, rtol=1e-10)

        def hours(k):
            c = k / 2
            turned = 50 * (1 - np.exp(-3 * c)) / c
            done = (50 * k) ** 3 * 50 * (1 - np.exp(-12 * c)) / (4 * c)
            load = 100 * (0.56 + 0.5 * 1.99) * (done / turned) ** (1 / 3)
            return 1e6 * (35.1e3 / load) ** 3 / (60 * turned / 3 * 60 / (2 * np.pi))

        assert found.values[0] == pytest.approx(hours(0.5), rel=1e-7)
        slope = (hours(0.5 + 1e-4) - hours(0.5 - 1e-4)) / 2e-4
        assert found.derivatives[0, 0] == pytest.approx(slope, rel=1e-5)


class TestFactors:
    @pytest.mark.parametrize(
        ("percent", "printed"),
        [(90, 1.0), (95, 0.62), (96, 0.53), (97, 0.44), (98, 0.33), (99, 0.21)],
    )
    def test_reliability_as_the_table_of_the_standard(self, percent, printed):
        assert reliability_factor(percent) == pytest.approx(printed, abs=0.005)

    def test_temperature_as_the_table(self):
        printed = {20: 1, 120: 1, 125: 0.95, 150: 0.9, 175: 0.85, 225: 0.75, 250: 0.7, 300: 0.6}
        received = [temperature_factor(f"{t} degC") for t in printed]
        assert received == pytest.approx(list(printed.values()), abs=1e-12)
        assert temperature_factor(273.15 + 275) == pytest.approx(0.65)


class TestRefusals:
    def test_reliabilities_outside_of_the_table(self):
        for percent in (50.0, 100.0):
            with pytest.raises(OptionError, match="90 to less than 100"):
                reliability_factor(percent)

    def test_hot_bearings_beyond_the_table(self):
        with pytest.raises(OptionError, match="350 degC: the table ends"):
            temperature_factor("350 degC")

    def test_ratings(self):
        with pytest.raises(OptionError, match="dynamic = -1 N must be positive"):
            Bearing(-1.0, 1.0, e=0.3, Y_1=1, Y_2=1, Y_0=1)
        with pytest.raises(UnitError):
            Bearing("5 kg", 1.0, e=0.3, Y_1=1, Y_2=1, Y_0=1)
        with pytest.raises(OptionError, match="e = 0"):
            Bearing(1.0, 1.0, e=0.0, Y_1=1, Y_2=1, Y_0=1)
        with pytest.raises(OptionError, match="exponent = -3"):
            Bearing(1.0, 1.0, e=0.3, Y_1=1, Y_2=1, Y_0=1, exponent=-3.0)

    @pytest.mark.parametrize(("load", "speed"), [(-5.0, 1.0), (0.0, 1.0), (5.0, 0.0)])
    def test_no_load_and_no_speed(self, load, speed):
        with pytest.raises(OptionError, match=r"(load|speed) = \S+ \S+ must be positive"):
            TAPER.hours(load, speed=speed)
