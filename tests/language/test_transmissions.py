"""Periodic splines and transmission functions against interpolation by scipy and closed forms."""

import casadi as ca
import numpy as np
import pytest
from rows import assemble_row, in_a_row, in_rows
from scipy.integrate import quad
from scipy.interpolate import CubicSpline

import lumped as lp
from lumped.components import EllipticalGear, Inertia, NonCircularGear, Speed
from lumped.errors import EquationError, OptionError
from lumped.language.derivatives import partials
from lumped.language.lowering import lower
from lumped.ops import cos, periodic_spline, sin
from lumped.transmissions import from_ratio, through

TURN = 2 * np.pi


def derivatives(expression, places, orders=3):
    """Value and derivatives of an expression of the time at some places."""
    x = ca.SX.sym("x")
    found = [lower(expression, None, time=x)]
    for _ in range(orders - 1):
        found.append(partials(found[-1], x))
    both = ca.Function("f", [x], [ca.vertcat(*found)])
    return list(both(ca.DM(places).T).full())


def turned(gear, turns=3.3, **options):
    """Flange a turned at 1 rad/s against a body at b."""
    system = assemble_row(drive=Speed(w=1.0), gear=gear, body=Inertia(J=1.0), keep=["body.phi"])
    return lp.simulate(system, until=TURN * turns, rtol=1e-11, grid=400, **options)


def ellipse(x, e):
    """Angle of the driven one of two equal ellipses, by half angles."""
    whole = np.round(x / TURN)
    half = (x - TURN * whole) / 2
    return 2 * np.arctan((1 + e) / (1 - e) * np.tan(half)) + TURN * whole


class TestPeriodicSpline:
    rng = np.random.default_rng(3)
    xs = np.sort(rng.uniform(-1.0, 4.0, 30))
    ys = np.r_[rng.uniform(-2.0, 2.0, 29), 0.0]
    ys[-1] = ys[0]

    def test_cubic_is_that_of_scipy_with_its_derivatives_in_all_periods(self):
        places = np.r_[np.linspace(-40, 40, 999), self.xs]
        received = derivatives(periodic_spline(lp.time, self.xs, self.ys), places)
        curve = CubicSpline(self.xs, self.ys, bc_type="periodic")
        for order, values in enumerate(received):
            expected = curve(places, order)
            assert np.abs(values - expected).max() < 1e-9 * np.abs(expected).max()

    @pytest.mark.parametrize(("degree", "smooth"), [(3, 2), (5, 4)])
    def test_derivatives_have_no_jump_at_a_point_nor_at_the_end_of_the_period(self, degree, smooth):
        xs = np.linspace(0, TURN, 13)
        spline = periodic_spline(lp.time, xs, np.exp(np.sin(xs)), degree=degree)
        before, after = (derivatives(spline, xs + h, smooth + 1) for h in (-1e-9, 1e-9))
        for left, right in zip(before, after, strict=True):
            assert np.abs(left - right).max() < 1e-6

    @pytest.mark.parametrize(("degree", "order"), [(3, 4), (5, 6)])
    def test_error_falls_with_its_order(self, degree, order):
        places, errors = np.linspace(0, TURN, 500), []
        for count in (20, 40):
            xs = np.linspace(0, TURN, count + 1)
            spline = periodic_spline(lp.time, xs, np.exp(np.sin(xs)), degree=degree)
            errors.append(np.abs(derivatives(spline, places, 1)[0] - np.exp(np.sin(places))).max())
        assert abs(np.log2(errors[0] / errors[1]) - order) < 0.5

    @pytest.mark.parametrize(
        ("xs", "ys", "degree", "text"),
        [
            ([0, 1, 2], [0, 1, 0], 3, "3 places and 3 values; as many of each, at least 4"),
            ([0, 1, 2, 3], [0, 1, 0], 3, "4 places and 3 values"),
            ([0, 1, 1, 3], [0, 1, 2, 0], 3, "places must increase, but 1 -> 1"),
            ([0, 1, 2, 3], [0, 1, 2, 1], 3, "last value 1 must be the first, 0"),
            ([0, 1, 2, 3], [0, 1, np.nan, 0], 3, "finite"),
            ([0, 1, 2, 3], [0, 1, 2, 0], 2, "degree = 2"),
        ],
    )
    def test_points_that_make_no_curve_are_refused(self, xs, ys, degree, text):
        with pytest.raises(EquationError, match=text):
            periodic_spline(lp.time, xs, ys, degree=degree)


class TestThrough:
    def test_it_meets_its_points_in_every_turn(self):
        a = np.sort(np.r_[0.3, 0.3 + TURN, np.random.default_rng(1).uniform(0.5, 6.4, 12)])
        b = 1.5 * a + 0.2 * np.sin(a - 0.3)
        law = through(np.column_stack([a, b]))(lp.time)
        for turn in (-7, 0, 1, 5):
            received = derivatives(law, a + TURN * turn, 1)[0]
            assert np.abs(received - (b + 1.5 * TURN * turn)).max() < 1e-13 * max(1, abs(turn)) * 50

    def test_points_of_an_ellipse_make_elliptical_gears(self):
        e, a = 0.3, np.linspace(0, TURN, 361)
        run = turned(NonCircularGear(transmission=through(np.column_stack([a, -ellipse(a, e)]))))
        assert np.abs(run["body.phi"] + ellipse(run.t, e)).max() < 1e-8
        same = turned(EllipticalGear(e=e))
        assert np.abs(run["body.w"] - same["body.w"]).max() < 1e-6

    def test_points_on_a_line_make_a_gear_of_constant_ratio(self):
        a = np.linspace(0, TURN, 9)
        run = turned(NonCircularGear(transmission=through(np.column_stack([a, -2 * a]))))
        assert np.abs(run["body.w"] + 2).max() < 1e-14

    @pytest.mark.parametrize(
        ("points", "text"),
        [
            ([1.0, 2.0], "rows of two numbers"),
            ([(0, 0), (1, 1), (2, 2), (3, 3)], r"from 0 to 3 rad, which is 0\.477465 turns"),
            (
                [(0, 0), (1, 2), (2, 1), (4, 4), (TURN, TURN)],
                r"ratio w_b / w_a is .* at 1\.\d+ rad .* makes 1 turns",
            ),
        ],
    )
    def test_rows_that_make_no_gear_are_refused(self, points, text):
        with pytest.raises(OptionError, match=text):
            through(points)

    def test_rows_out_of_order_are_refused(self):
        with pytest.raises(EquationError, match="places must increase, but 3 -> 2"):
            through([(0, 0), (3, 2), (2, 3), (5, 5), (TURN, TURN)])


class TestFromRatio:
    @pytest.mark.parametrize("e", [0.1, 0.3, 0.5])
    def test_ratio_of_an_ellipse_makes_elliptical_gears(self, e):
        law = from_ratio(lambda x: -(1 - e * e) / (1 + e * e - 2 * e * cos(x)), turns=-1)
        run = turned(NonCircularGear(transmission=law))
        assert np.abs(run["body.phi"] + ellipse(run.t, e)).max() < 1e-8
        same = turned(EllipticalGear(e=e))
        assert np.abs(run["body.w"] - same["body.w"]).max() < 1e-6

    def test_ratio_is_met_with_its_integral_and_its_slope(self):
        run = turned(
            NonCircularGear(
                transmission=from_ratio(lambda x: 2 + 0.5 * sin(x) + 0.2 * cos(3 * x), turns=2)
            )
        )
        t = run.t
        angle = 2 * t + 0.5 * (1 - np.cos(t)) + 0.2 / 3 * np.sin(3 * t)
        assert np.abs(run["body.phi"] - angle).max() < 1e-9
        assert np.abs(run["body.w"] - (2 + 0.5 * np.sin(t) + 0.2 * np.cos(3 * t))).max() < 1e-8
        assert np.abs(run["body.a"] - (0.5 * np.cos(t) - 0.6 * np.sin(3 * t))).max() < 1e-5

    def test_half_a_turn_for_each_turn(self):
        law = from_ratio(lambda x: 0.5 + 0.1 * cos(2 * x), turns=0.5)
        received = derivatives(law(lp.time), np.arange(5) * TURN, 1)[0]
        assert np.abs(received - np.arange(5) * TURN / 2).max() < 1e-13

    def test_factor_in_the_error_closes_the_turn(self):
        def ratio(x):
            return 1 / (1 + 0.4 * cos(x))

        integral = quad(lambda x: 1 / (1 + 0.4 * np.cos(x)), 0, TURN, epsabs=1e-13)[0] / TURN
        with pytest.raises(OptionError, match=f"turns b by {integral:.9g} turns") as caught:
            from_ratio(ratio)
        factor = 1 / integral
        assert f"multiply the ratio by {factor:.9g}" in str(caught.value)
        assert callable(from_ratio(lambda x: ratio(x) * factor))

    @pytest.mark.parametrize(
        ("ratio", "given", "text"),
        [
            (lambda x: 1 + 2 * cos(x), {}, "ratio w_b / w_a is -0.00.* at 2.09.* rad"),
            (lambda x: 1 + 0 * x, {"turns": -1}, "makes -1 turns"),
            (lambda x: 1 + 0.1 * (x - np.pi), {}, "0.68.* at 0 and 1.3.* pitch curve"),
            (lambda x: 1 + 0 * x, {"pieces": 3}, "pieces = 3"),
        ],
    )
    def test_ratio_that_makes_no_gear_is_refused(self, ratio, given, text):
        with pytest.raises(OptionError, match=text):
            from_ratio(ratio, **given)

    def test_energy_of_free_bodies_is_kept(self):
        model = in_a_row(
            left=Inertia(J=1.0, w=1.0),
            gear=NonCircularGear(
                transmission=from_ratio(lambda x: -(1 + 0.5 * cos(x) + 0.2 * sin(2 * x)), turns=-1)
            ),
            right=Inertia(J=2.0),
        )
        run = lp.simulate(lp.assemble(model), until=50.0, rtol=1e-10)
        energy = run["left.w"] ** 2 + 2 * run["right.w"] ** 2
        # a step over ends of pieces, where the fifth derivative jumps, is of third order there
        assert np.abs(energy / energy[0] - 1).max() < 3e-6


@pytest.mark.parametrize(
    "gear",
    [
        EllipticalGear(e=0.4, phase=0.3),
        NonCircularGear(transmission=from_ratio(lambda x: -(1 + 0.4 * cos(x)), turns=-1)),
    ],
)
def test_on_a_housing_that_turns_the_power_into_all_flanges_is_none(gear):
    model = in_rows(
        "a gear b",
        "gear.support housing.flange_a",
        a=Inertia(J=1.0, w=3.0),
        b=Inertia(J=2.0),
        housing=Inertia(J=5.0, w=0.7),
        gear=gear,
    )
    run = lp.simulate(lp.assemble(model), until=20.0, rtol=1e-10)
    tau = [run[f"gear.{end}.tau"] for end in ("flange_a", "flange_b", "support")]
    w = [run[f"{body}.w"] for body in ("a", "b", "housing")]
    assert np.abs(sum(tau)).max() < 1e-12 * np.abs(tau).max()
    power = np.multiply(tau, w)
    assert np.abs(power.sum(axis=0)).max() < 1e-12 * np.abs(power).max()
    momentum = w[0] + 2 * w[1] + 5 * w[2]  # nothing holds the three
    assert np.abs(momentum / momentum[0] - 1).max() < 3e-7
