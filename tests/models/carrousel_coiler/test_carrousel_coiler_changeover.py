"""Carrousel coiler: changeover of the mandrels, and the parts of its drive."""

import coiler_by_hand
import numpy as np
import pytest

from lumped.errors import OptionError
from lumped.models.carrousel_coiler import changeover as scene
from lumped.models.carrousel_coiler import expansion, gearing, sizing, turret

T, r = 80e3, 0.305
STAGES, _ = scene.plan()


@pytest.fixture(scope="module")
def run():
    return scene.changeover(grid=np.linspace(0, STAGES.unloaded + 1, 4001), rtol=1e-9)


def at(run, time, name):
    return float(np.interp(time, run.t, run[name]))


class TestChangeover:
    def test_the_drive_of_the_turret_carries_tension_weight_and_inertia(self):
        t = np.linspace(0.05, 11.95, 120)
        run = scene.changeover(grid=np.concatenate([[0.0], 5.0 + t]), rtol=1e-10, until=16.95)
        place = np.isin(run.t, 5.0 + t)
        expected = coiler_by_hand.turret_torque(t)
        corners = np.isclose(t, 3.0) | np.isclose(t, 9.0)  # where the acceleration jumps
        received = -run["turn.flange.tau"][place]
        assert received[~corners] == pytest.approx(expected[~corners], rel=1e-5)

    def test_without_mass_it_is_the_half_turn_of_the_light_turret(self):
        light = {"rho": 0.0, "mandrel.J": 1e-6, "mandrel_2.J": 1e-6, "disc.J": 1e-6}
        grid = np.linspace(0.5, 11.5, 12)
        given = {"grid": np.concatenate([[0.0], 5.0 + grid]), "until": 16.5}
        run = scene.changeover(parameters=light, **given)
        wound = 5.0 * 5.0 + np.pi * (0.45**2 - r**2) / 1e-3
        begun = {"R_0": float(np.sqrt(r**2 + 1e-3 * wound / np.pi))}
        # the free strip is that of a coil which is a little larger, 1e-4 of the length
        plain = turret.half_turn(grid=grid, parameters=begun)
        received = run["turn.flange.tau"][np.isin(run.t, 5.0 + grid)]
        kept = np.isin(plain.t, grid)
        assert received == pytest.approx(plain["turn.flange.tau"][kept], rel=2e-3)

    def test_work_of_the_weight_over_half_a_turn_is_that_of_the_mass_added_on_the_way(self, run):
        """A coil of constant mass ends as high as it began."""
        during = (run.t > STAGES.turns) & (run.t < STAGES.turned)
        mass, angle = run["load.m"][during], run["turn.phi"][during]
        lift = np.trapezoid(mass * 9.80665 * 1.25 * np.cos(angle), angle)
        height = 1.25 * np.sin(angle)
        assert lift == pytest.approx(-np.trapezoid(height, mass) * 9.80665, rel=0.02)

    def test_stages_follow_each_other_as_the_figure_says(self, run):
        assert list(STAGES) == sorted(STAGES)
        assert at(run, STAGES.turned + 0.1, "turn.phi") == pytest.approx(np.pi, rel=1e-9)
        middle = 0.5 * (STAGES.turned + 15 + STAGES.slows)
        assert at(run, middle, "coil.w") * at(run, middle, "coil.R") == pytest.approx(20, rel=1e-4)
        assert at(run, STAGES.cut - 0.05, "coil.T") == pytest.approx(T)
        assert at(run, STAGES.cut + 0.05, "coil.T") == 0
        assert at(run, STAGES.cut, "coil.R") == pytest.approx(0.8, rel=1e-3)
        assert at(run, STAGES.cut + 0.05, "mandrel_2.w") * r == pytest.approx(5.0, rel=1e-3)
        assert at(run, STAGES.stops + 0.1, "coil.w") == pytest.approx(0, abs=1e-6)
        tail = at(run, STAGES.stops + 0.1, "coil.L") - at(run, STAGES.cut, "coil.L")
        assert tail == pytest.approx(12.0, rel=2e-3)
        assert run["load.m"][-1] == 0

    def test_mandrel_2_has_the_torques_of_its_speeding_up_and_of_its_tension(self, run):
        speeding = at(run, STAGES.cut - 2, "motor_2.flange.tau")
        assert abs(speeding) == pytest.approx(500 * 5.0 / r / 6.0, rel=1e-6)
        assert abs(at(run, STAGES.cut + 1, "motor_2.flange.tau")) == pytest.approx(T * r, rel=1e-9)


class TestParts:
    def test_ratio_split(self):
        """Mandrels 1.6 m apart with a wheel of 1 m: 0.6 m on the core shaft, 1.667 in the seat."""
        found = gearing.split_ratio(1.354, distance=1.6, wheel=1.0)
        assert (found.seat, found.reducer) == pytest.approx((1 / 0.6, 1.354 * 0.6))

    @pytest.mark.parametrize("gear", ["high", "low"])
    def test_both_pairs_of_the_coaxial_reducer_have_one_distance(self, gear):
        pair = gearing.stage(gear)
        assert pair.centre == pytest.approx(0.58, rel=1e-12)
        assert np.gcd(*pair.teeth) == 1

    def test_low_gear_has_the_larger_stresses(self):
        loads = {"peak": 60e3}
        high, low = (
            gearing.rate_gears(gearing.stage(g), loads, strength=gearing.strength())["peak"]
            for g in ("high", "low")
        )
        assert low.root < high.root
        assert low.contact < high.contact

    def test_life_of_the_bearing_from_the_spectrum_of_the_run(self):
        run = gearing.coil_run()
        radial, axial = gearing.pinion_forces()
        levels = gearing.spectrum(run, classes=200)
        load = 1.5 * (0.67 * radial + 3.0 * axial) * levels.equivalent()
        rpm = levels.mean_speed * 30 / np.pi
        expected = 1e6 * (2.0e6 / load) ** (10 / 3) / (60 * rpm)
        assert run.value(gearing.bearing_hours()) == pytest.approx(expected, rel=1e-4)

    def test_two_gears_are_asked_for_above_a_range_of_ten(self):
        assert sizing.needs_two_gears()
        assert not sizing.needs_two_gears(v_max=20.0)  # 9.836 with the speed of example 3.1

    def test_the_gear_is_chosen_for_a_strip(self):
        assert [sizing.gear_for(v, T) for v, T in ((20.0, 80e3), (13.0, 100e3))] == ["high", "low"]


class TestExpansion:
    def test_without_friction_the_work_of_the_cylinder_is_that_of_the_segments(self):
        force = expansion.pull(1e3, friction=0.0)
        assert force * 0.01 == pytest.approx(4e3 * expansion.radial_travel(0.01), rel=1e-12)
        assert expansion.hold(1e3, friction=0.0) == pytest.approx(force, rel=1e-12)

    def test_forces_of_a_wedge_in_equilibrium(self):
        """Normal force n and friction mu n on the slope: the segment is in equilibrium radially."""
        slope, mu, radial = 0.2, 0.1, 1e3
        n = radial / (np.cos(slope) - mu * np.sin(slope))
        assert expansion.pull(radial, slope, mu) == pytest.approx(
            4 * n * (np.sin(slope) + mu * np.cos(slope)), rel=1e-12
        )

    def test_a_slope_below_the_angle_of_friction_holds_itself(self):
        assert expansion.hold(1e3, slope=0.05, friction=0.1) < 0

    def test_a_wrap_presses_as_the_pressure_of_a_belt(self):
        """Pressure T / (r b) over the projection of a quarter, r b sqrt(2)."""
        assert expansion.segment_force() == pytest.approx(T / r * r * np.sqrt(2), rel=1e-12)


def test_a_coil_too_small_for_the_line_speed_is_refused():
    with pytest.raises(OptionError, match="does not reach"):
        scene.changeover(radius=0.5)
