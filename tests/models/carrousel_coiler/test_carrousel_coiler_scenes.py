"""Carrousel coiler: elastic strip, turret, and the extreme cases."""

import numpy as np
import pytest

from lumped.errors import OptionError, SolverError
from lumped.models.carrousel_coiler import drive as coiler
from lumped.models.carrousel_coiler import scenes, turret

T, r, R, h, b, rho = 80e3, 0.305, 1.0, 1e-3, 1.25, 7850.0
J_EMPTY = 500 + 600 * 1.354**2  # at the mandrel, high gear
LOSSLESS = {"drive.eta": 1.0, "drive.mu": 0.0}


class TestElasticStrip:
    @pytest.mark.parametrize("parameters", [LOSSLESS, {}], ids=["lossless", "with losses"])
    def test_compensation_holds_the_tension(self, parameters):
        run = scenes.elastic_winding(1.0, grid=400, until=160.4, rtol=1e-9, parameters=parameters)
        assert np.abs(run["strip.T"] - T).max() < 3e-3
        assert run["drive.coil.R"][-1] == pytest.approx(R, rel=1e-5)

    @pytest.mark.parametrize(("free", "speed"), [(10.0, 39.0), (1.0, 124.0)])
    def test_a_shorter_strip_swings_faster_to_the_same_tension(self, free, speed):
        given = LOSSLESS | {"free": free}
        # slow: the radius stays
        run = scenes.elastic_winding(
            0.0, length=20.0, until=4.0, v=1.0, a=0.1, b=5.0, grid=40_000, parameters=given
        )
        assert run["strip.T"][-1] == pytest.approx(T - J_EMPTY * 0.1 / r**2, rel=1e-3)
        early = (run.t > 0) & (run.t < 0.8)
        swing = (run["strip.T"] - T + J_EMPTY * 0.1 / r**2)[early]
        crossings = run.t[early][1:][np.diff(np.sign(swing)) != 0]
        damped = np.pi / np.diff(crossings).mean()
        assert damped == pytest.approx(speed * np.sqrt(1 - 0.05**2), rel=0.01)

    def test_thick_strip_needs_the_controller(self):
        given = LOSSLESS | {"drive.h": 5e-3}
        options = {"until": 28.0, "grid": np.array([0.0, 28.0]), "rtol": 1e-9}
        run = scenes.elastic_winding(1.0, parameters=given, **options)
        assert run["strip.T"][-1] == pytest.approx(T, abs=0.01)
        run = scenes.elastic_winding(0.0, parameters=given, **options)
        radius = np.sqrt(r**2 + 5e-3 * 360 / np.pi)
        A = (J_EMPTY - np.pi * rho * b * r**4 / 2) * 5e-3 * 20.0**2 / (2 * np.pi)
        deviation = A / radius**4 + rho * b * 5e-3 * 20.0**2 / 4
        assert run["strip.T"][-1] - T == pytest.approx(deviation, rel=1e-3)

    def test_lost_tension_is_refused_with_values_and_units(self):
        text = r"T = 0 N instead of 80000 N, at t = \d\.\d+ s, coil radius R = 0\.305 m, line speed"
        with pytest.raises(SolverError, match=text) as caught:
            scenes.elastic_winding(0.0, a=6.0, until=3.0, grid=300)
        # zero to the rounding of 80 kN where the damper is as strong as the strip
        assert abs(caught.value.partial["strip.T"].min()) < 1e-9
        assert str(caught.value).startswith("The strip loses")


class TestLimits:
    def test_a_strip_that_is_too_long_is_refused_before_it_is_wound(self):
        text = r"3000 m and 1 mm makes a coil of 1\.024 m .* full coil has 1 m\. At most 2849\.35 m"
        with pytest.raises(OptionError, match=text):
            coiler.winding(length=3000.0)
        with pytest.raises(OptionError, match=text):
            scenes.elastic_winding(length=3000.0)

    def test_a_strip_that_does_not_reach_the_speed_is_refused(self):
        with pytest.raises(OptionError, match=r"300 m does not reach 20 m/s.*360 m"):
            coiler.winding(length=300.0)

    def test_standing_still_divides_by_nothing(self):
        assert scenes.tension_deviation(np.array([r, R]), v=0.0) == pytest.approx(0, abs=1e-9)

    def test_when_the_power_flows_back_the_loss_is_on_the_other_side(self):
        tension, brake = 5e3, 6.0
        run = coiler.winding(
            length=400.0, v=20.0, b=brake, grid=4000, parameters={"T": tension}, rtol=1e-11
        )
        slows = run.t > 20.0 + (400 - 200 - 200 / brake) / 20 + 1e-6
        radius, w = run["drive.coil.R"], run["drive.coil.w"]
        v = radius * w
        dw = -brake / radius - h * v**2 / (2 * np.pi * radius**3)
        J = 500.0 + np.pi * rho * b / 2 * (radius**4 - r**4)
        load = np.hypot(tension, 9.80665 * (2500 + run["drive.coil.m"]))
        at_gear = tension * radius + 93.75 + 0.003 * 0.2 * load + J * dw
        sides = np.where(at_gear > 0, at_gear / 0.92, at_gear * 0.92)
        expected = sides / 1.354 + 600 * 1.354 * dw
        before_end = slows & (run.t < run.t[-1] - 1e-6)
        received = -run["drive.motor.flange.tau"][before_end]
        assert (at_gear[before_end] < 0).any()
        assert received == pytest.approx(expected[before_end], rel=1e-8, abs=1e-4)


@pytest.fixture(scope="module")
def half():
    return turret.half_turn(grid=np.linspace(0, 12, 601))


class TestTurret:
    def test_torques_of_plane_geometry(self, half):
        """As drawn: x to the right, y up, winding clockwise over the top."""
        theta = half["turn.phi"]
        axis = 1.25 * np.array([np.cos(np.pi - theta), np.sin(np.pi - theta)])
        to_roll = np.array([[-4.0], [1.8]]) - axis
        D = np.hypot(*to_roll)
        radius = half["coil.R"]
        psi = np.arctan2(to_roll[1], to_roll[0]) - np.arccos(radius / D)
        contact = axis + radius * np.array([np.cos(psi), np.sin(psi)])
        pull = np.array([[-4.0], [1.8]]) - contact
        pull = T * pull / np.hypot(*pull)
        drawn = -2 * T * radius - (axis[0] * pull[1] - axis[1] * pull[0])
        # torque on the turret, anticlockwise; the source takes the opposite, clockwise
        assert half["turn.flange.tau"] == pytest.approx(drawn, rel=1e-10)
        assert drawn.max() / 1e3 == pytest.approx(-29, abs=0.5)
        assert drawn.min() / 1e3 == pytest.approx(-174, abs=0.5)
        assert np.abs(half["held.motor.tau"]) == pytest.approx(T * radius, rel=1e-12)

    def test_strip_at_the_line_speed(self, half):
        left = half["coil.L"] + half["path.length"] - turret.LINE * half.t
        assert left == pytest.approx(np.full(left.shape, left[0]), abs=1e-9)

    def test_another_ratio_of_the_sun_leaves_strip_and_power_as_they_are(self, half):
        run = turret.half_turn(grid=np.linspace(0, 12, 601), parameters={"k": 2.0})
        assert run["coil.w"] == pytest.approx(half["coil.w"], rel=1e-12)
        sun, turn = -run["held.motor.tau"], -run["turn.flange.tau"]
        assert np.abs(sun) == pytest.approx(2 * T * run["coil.R"], rel=1e-12)
        top = np.pi / 9
        Omega = top * np.clip(np.minimum(run.t, 12 - run.t) / 3, 0, 1)
        w_sun = (3 * Omega - run["coil.w"]) / 2  # Willis
        assert sun * w_sun + turn * Omega == pytest.approx(T * turret.LINE, rel=1e-12)

    def test_at_rest_it_is_a_plain_gear(self):
        run = turret.half_turn(turning=False, grid=np.linspace(0, 12, 41))
        assert run["coil.w"] * run["coil.R"] == pytest.approx(turret.LINE, rel=1e-10)
        assert run["path.length"] == pytest.approx(
            np.sqrt(np.hypot(-4 + 1.25, 1.8) ** 2 - run["coil.R"] ** 2), rel=1e-10
        )
