"""Motor torque of the eccentric shear at constant speed, against reference files and bounds."""

import numpy as np
import pytest
from checks import apart
from shear_by_hand import DEGREES, data, nearest

from lumped.models import eccentric_shear
from lumped.models.eccentric_shear.scenes import SLOW, CrankTurned, Demand, MotorTurned, turn
from lumped.models.eccentric_shear.stand import CENTRE_RECTANGLE, CENTRE_SINE, IDLE, PULSE, SPEED

ELLIPSES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
PULSES = ("half-sine", "rectangle")


def at_degrees(demand: Demand) -> np.ndarray:
    return demand.tau[nearest(demand.phi)]


class TestTorque:
    @pytest.mark.parametrize("e", ELLIPSES)
    @pytest.mark.parametrize("pulse", PULSES)
    def test_torque_at_constant_crank_speed_is_that_of_the_reference(self, pulse, e):
        kind = "sine" if pulse == "half-sine" else "rect"
        for law, speed in (("var", SPEED), ("const", SLOW * SPEED)):
            demand = turn(CrankTurned, e, pulse, speed=speed, grid=DEGREES / speed)
            expected = data("torque")[f"M_{kind}_{law}J_e{e:.1f}"]
            assert apart(at_degrees(demand), expected) < 1e-9

    @pytest.mark.parametrize("e", ELLIPSES)
    def test_torque_at_constant_motor_speed_is_that_of_the_reference(self, e):
        instants = data("gear")[f"q_rad_e{e:.1f}"] / SPEED
        instants[-1] = 2 * np.pi / SPEED
        demand = turn(MotorTurned, e, grid=instants)
        expected = data("torque")[f"M_sine_constmotorspeed_e{e:.1f}"]
        rows = np.abs(demand.phi[:, None] - DEGREES).argmin(axis=0)
        assert apart(demand.tau[rows], expected) < 1e-9

    @pytest.mark.parametrize("J", [5.4e3, 51e3, 54e3, 56e3])
    @pytest.mark.parametrize("e", [0.4, 0.5])
    def test_motor_of_any_inertia_takes_the_torque_of_equation_20(self, J, e):
        """The part of the motor by hand, all else from the file at J = 54 t.m2."""
        run = turn(CrankTurned, e, grid=DEGREES / SPEED, parameters={"motor.J": J})
        y = DEGREES - CENTRE_SINE
        slope = -2 * e * (1 - e**2) * np.sin(y) / (1 + e**2 - 2 * e * np.cos(y)) ** 2
        expected = data("torque")[f"M_sine_varJ_e{e:.1f}"] + (J - 54e3) * SPEED**2 * slope
        assert apart(at_degrees(run), expected) < 1e-9

    @pytest.mark.parametrize(("idle", "expected"), [(0.0, (1.50, 1.68)), (IDLE, (1.40, 1.50))])
    def test_constant_motor_speed_gives_the_other_reading_of_the_equivalent_load(
        self, idle, expected
    ):
        received = eccentric_shear.reductions(
            "rms", motion=MotorTurned, parameters={"loaded.idle.tau": -idle}
        )
        assert np.abs(np.subtract(received, expected)).max() < 0.0051

    def test_best_ellipse_is_that_of_the_reference(self):
        tried = (0.554, 0.564, 0.574)
        received = eccentric_shear.reductions(ellipses=tried, speed=SLOW * SPEED)
        assert received[1] == max(received)
        assert abs(received[1] - 3.56) < 0.0051
        assert abs(eccentric_shear.reductions(ellipses=(0.564,))[0] - 3.00) < 0.0051

    @pytest.mark.parametrize(
        ("pulse", "e", "degrees", "expected"),
        [
            ("half-sine", 0.4, -6.5, 2.37),
            ("half-sine", 0.5, -8.5, 3.20),
            ("rectangle", 0.4, -6.0, 1.67),
            ("rectangle", 0.5, -6.5, 1.72),
        ],
    )
    def test_ratio_that_is_greatest_before_the_middle_does_better(
        self, pulse, e, degrees, expected
    ):
        centre = CENTRE_SINE if pulse == "half-sine" else CENTRE_RECTANGLE
        even = turn(CrankTurned, 0.0, pulse, grid=4000)
        shifted = turn(CrankTurned, e, pulse, slowest=centre + np.radians(degrees), grid=4000)
        assert abs(even.peak / shifted.peak - expected) < 0.005

    def test_best_ellipse_for_a_rectangle_reaches_the_bound(self):
        even = turn(CrankTurned, 0.0, "rectangle", speed=SLOW * SPEED, grid=2000)
        best = turn(
            *(CrankTurned, float(np.tan(np.pi / 4 - PULSE / 4)), "rectangle"),
            speed=SLOW * SPEED,
            grid=2000,
        )
        assert abs(even.peak / best.peak * np.sin(PULSE / 2) - 1) < 1e-9

    @pytest.mark.parametrize(
        ("e", "expected", "printed", "right"),
        [(0.4, 2.33, 302.75, 157.27), (0.5, 2.86, 389.25, 162.23)],
    )
    def test_printed_phase_raises_the_peak(self, e, expected, printed, right):
        phase = eccentric_shear.printed_phase(e)
        factor = (1 + e) / (1 - e)
        assert abs(np.degrees(factor * CENTRE_RECTANGLE) - printed) < 0.0051
        exact = 2 * np.arctan(factor * np.tan(CENTRE_RECTANGLE / 2))  # (9) at the middle of the cut
        assert abs(np.degrees(exact) - right) < 0.0051
        if e == 0.5:
            assert abs(np.degrees(phase) - 9.9) < 0.051
        even = turn(CrankTurned, 0.0, "rectangle", grid=4000)
        found = turn(CrankTurned, e, "rectangle", slowest=phase, grid=4000)
        assert abs(found.peak / even.peak - expected) < 0.005

    def test_phase_of_circles_does_not_matter(self):
        received = turn(CrankTurned, 0.0, slowest=0.3, grid=400)
        expected = turn(CrankTurned, 0.0, slowest=2.0, grid=400)
        assert np.array_equal(received.tau, expected.tau)
