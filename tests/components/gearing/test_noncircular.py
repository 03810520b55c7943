"""Non-circular gears against closed forms of the two ellipses and quadrature."""

import numpy as np
import pytest
from rows import in_a_row

import lumped as lp
from lumped.components import EllipticalGear, Inertia, NonCircularGear, Position, Speed
from lumped.components.gearing.noncircular import elliptical, slowest_at
from lumped.errors import EquationError, ParameterError

ECCENTRICITIES = [0.0, 0.6, 0.9, 0.99, 0.999]


def pair(gear: lp.Component, drive: lp.Component) -> lp.Component:
    return in_a_row(drive=drive, gear=gear, body=Inertia(J=1.0))


def turned(gear: lp.Component, turns: float = 1.0, **options: object) -> lp.Trajectory:
    """Flange a turned at 1 rad/s; kept are both angles, speeds and torques."""
    system = lp.assemble(pair(gear, Speed(w=1.0)), keep=["gear.flange_a.phi"])
    return lp.simulate(system, until=2 * np.pi * turns, rtol=1e-10, **options)


class TestEllipticalGear:
    def test_angle_is_exact_for_a_slender_ellipse(self):
        """Half angles in long double, at angles of the driver as doubles."""
        e, x = 0.99, np.linspace(-20, 20, 81)
        model = pair(EllipticalGear(e=e), Position(phi=0.0))
        system = lp.assemble(model, keep=["body.phi"])
        received = [-lp.start_point(system, parameters={"drive.phi": v})["body.phi"] for v in x]
        wide = x.astype(np.longdouble)
        whole = np.round(wide / (2 * np.arccos(np.longdouble(-1))))
        half = wide / 2 - whole * np.arccos(np.longdouble(-1))
        ratio = (1 + np.longdouble(e)) / (1 - np.longdouble(e))
        expected = 2 * np.arctan(ratio * np.tan(half)) + whole * 2 * np.arccos(np.longdouble(-1))
        assert np.abs(received - expected).max() < 2e-13

    @pytest.mark.parametrize("e", ECCENTRICITIES)
    def test_ratio_is_that_of_the_radii_of_two_ellipses_that_touch(self, e):
        x = np.linspace(-np.pi, np.pi, 2001)
        run = turned(EllipticalGear(e=e, phase=np.pi), grid=x + np.pi)
        near = (1 - e * e) / (1 + e * np.cos(x + np.pi))  # from its focus, half axis 1
        received, expected = -run["body.w"], near / (2 - near)
        assert np.abs(received / expected - 1).max() < 1e-9 / (1 - e)

    @pytest.mark.parametrize(
        ("e", "expected"), [(0.6, 303.86), (0.9, 347.95), (0.99, 358.85), (0.999, 359.885)]
    )
    def test_half_turn_of_the_slow_side_takes_most_of_a_turn(self, e, expected):
        """Reference of the shear's extreme cases, printed to the digits given."""
        phase = slowest_at(0.0, e)
        drive = Position(phi=elliptical(lp.time - np.pi / 2, e, 0.0))
        model = pair(EllipticalGear(e=e, phase=phase), drive)
        run = lp.simulate(lp.assemble(model, keep=["drive.flange.phi"]), until=np.pi, grid=2)
        span = run["drive.flange.phi"][-1] - run["drive.flange.phi"][0]
        assert abs(-run["body.phi"][-1] - np.pi / 2) < 1e-12 / (1 - e)
        assert abs(np.degrees(span) - expected) < (0.005 if e < 0.999 else 0.0005)

    @pytest.mark.parametrize("e", [0.6, 0.9, 0.99, 0.999])
    def test_ratio_changes_fastest_by_the_limit_law(self, e):
        """Greatest slope of the ratio: 4.98, 117, 1.29e4, 1.30e6 -> (3 sqrt3 / 4) / (1 - e)^2."""
        expected = {0.6: 4.98, 0.9: 117.0, 0.99: 1.29e4, 0.999: 1.30e6}[e]
        grid = np.pi + np.linspace(-3, 3, 4001) * (1 - e)
        run = turned(EllipticalGear(e=e, phase=np.pi), grid=[0.0, *grid])
        received = np.abs(run["body.a"]).max()
        assert abs(received / expected - 1) < 5e-3
        assert abs(received * (1 - e) ** 2 / (0.75 * np.sqrt(3)) - 1) < 2 * (1 - e)

    def test_circles_turn_evenly_whatever_the_phase(self):
        for phase in (0.0, 1.0, 4.0):
            run = turned(EllipticalGear(e=0.0, phase=phase), grid=100)
            assert np.array_equal(run["body.w"], np.full(len(run.t), -1.0))
            assert np.abs(run["body.phi"] + run.t).max() < 2e-13

    @pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
    def test_two_opposed_pairs_undo_each_other(self, e):
        angle = 1.3
        slow = -(elliptical(angle, e, angle) + np.pi)
        model = in_a_row(
            drive=Speed(w=1.0),
            there=EllipticalGear(e=e, phase=angle),
            back=EllipticalGear(e=e, phase=slow),
            body=Inertia(J=1.0),
        )
        run = lp.simulate(lp.assemble(model, keep=["body.phi"]), until=20.0, rtol=1e-10)
        assert np.abs(run["body.phi"] - run.t).max() < 1e-8

    @pytest.mark.parametrize("e", [1.0, -0.1])
    def test_eccentricity_out_of_range_is_refused(self, e):
        with pytest.raises(
            ParameterError, match=rf"gear\.e = {e:g} .eccentricity of the ellipses. must be"
        ):
            lp.assemble(pair(EllipticalGear(e=e), Speed(w=1.0)))


class TestNonCircularGear:
    def test_ratio_is_the_derivative_of_the_transmission(self):
        gear = NonCircularGear(transmission=lambda x: -(2 * x + 0.3 * lp.ops.sin(3 * x)))
        run = turned(gear, grid=400)
        expected = -(2 + 0.9 * np.cos(3 * run.t))
        assert np.abs(run["body.w"] - expected).max() < 1e-12

    def test_torque_accelerates_what_the_transmission_demands(self):
        gear = NonCircularGear(transmission=lambda x: x**3 + x)
        run = turned(gear, turns=0.5, grid=100)
        expected = -2.0 * 0.5 * (3 * run.t**2 + 1) * 6 * run.t
        assert np.abs(run["drive.flange.tau"] - expected).max() < 1e-8 * np.abs(expected).max()

    def test_ellipses_are_a_special_case(self):
        e, grid = 0.4, 300
        law = NonCircularGear(transmission=lambda x: -elliptical(x, e, 0.7))
        received = turned(law, grid=grid)["body.w"]
        expected = turned(EllipticalGear(e=e, phase=0.7), grid=grid)["body.w"]
        assert np.abs(received - expected).max() < 1e-13

    def test_without_a_function_it_is_refused(self):
        with pytest.raises(EquationError, match="a function of the angle of flange a"):
            lp.assemble(pair(NonCircularGear(), Speed(w=1.0)))
