"""Laws of motion against what makes them: their ends, their peaks, their limits."""

import casadi as ca
import numpy as np
import pytest
from checks import refused

import lumped as lp
from lumped import profiles
from lumped.errors import OptionError

H, T = -0.7, 1.3
LAWS = {
    "polynomial5": (profiles.polynomial5, 2),
    "polynomial7": (profiles.polynomial7, 3),
    "cycloidal": (profiles.cycloidal, 2),
    "modified_sine": (profiles.modified_sine, 2),
}


class Follower(lp.Component):
    """A derivative of a given position: y = der(...(s))."""

    order: int = 0
    s = lp.Input("1", "position")
    y = lp.Output("1", "derivative")

    def equations(self):
        derivative = self.s
        for _ in range(self.order):
            derivative = lp.der(derivative)
        yield self.y == derivative


def followed(position, until, orders=4, grid=20_000):
    """Times, and the position with its derivatives; the run refuses a jump of those before."""
    runs = [
        lp.simulate(lp.assemble(Follower(order=k, s=position)), until=until, grid=grid)
        for k in range(orders)
    ]
    return runs[0].t, [run["y"] for run in runs]


@pytest.mark.parametrize("name", LAWS)
def test_a_law_moves_from_rest_to_rest_and_reaches_the_peaks_it_states(name):
    law, rest = LAWS[name]
    move = law(H, T)
    t, (s, v, a, j) = followed(profiles.path(move, begin=0.2, start=0.1), 2.0)
    assert np.ptp(s[t < 0.2]) == np.ptp(s[t > 0.2 + T]) == 0
    assert s[0] == 0.1
    assert s[-1] == pytest.approx(0.1 + H, rel=1e-14)
    for order, values in enumerate((s, v, a, j)):
        jumps = np.abs(np.diff(values)[np.diff(t) == 0])
        scale = max(abs(H), 1.0) / T**order
        assert order > rest or jumps.max() < 1e-12 * 100 * scale
    assert np.abs(v).max() == pytest.approx(move.speed, rel=1e-6)
    assert np.abs(a).max() == pytest.approx(move.acceleration, rel=1e-6)
    assert np.abs(j).max() == pytest.approx(move.jerk, rel=1e-6)
    for lower, upper in ((s, v), (v, a), (a, j)):
        integral = np.sum(np.diff(t) * (upper[1:] + upper[:-1]) / 2)
        assert integral == pytest.approx(lower[-1] - lower[0], abs=1e-6 * np.abs(upper).max())


def test_the_peaks_in_the_texts_are_those_of_the_formulas():
    x = ca.SX.sym("x")
    formulas = {
        "polynomial5": (10 * x**3 - 15 * x**4 + 6 * x**5, (15 / 8, 10 / 3**0.5, 60)),
        "polynomial7": (
            35 * x**4 - 84 * x**5 + 70 * x**6 - 20 * x**7,
            (35 / 16, 84 * 5**0.5 / 25, 105 / 2),
        ),
        "cycloidal": (x - ca.sin(2 * np.pi * x) / (2 * np.pi), (2, 2 * np.pi, 4 * np.pi**2)),
    }
    grid = np.linspace(0, 1, 100_001)
    for name, (formula, peaks) in formulas.items():
        move = LAWS[name][0](1.0, 1.0)
        assert (move.speed, move.acceleration, move.jerk) == pytest.approx(peaks, rel=1e-14)
        for peak in peaks:
            formula = ca.gradient(formula, x)
            values = np.abs(np.asarray(ca.Function("f", [x], [formula])(grid[None, :])))
            assert values.max() == pytest.approx(peak, rel=1e-8)


def test_the_modified_sine_has_the_factors_of_the_tables():
    # Norton, Cam Design and Manufacturing Handbook, to four digits
    move = profiles.modified_sine(1.0, 1.0)
    received = (move.speed, move.acceleration, move.jerk)
    assert received == pytest.approx((1.760, 5.528, 69.47), rel=3e-4)


@pytest.mark.parametrize(
    ("way", "duration"), [(3.0, 3.0 / 2 + 2 / 4), (-0.25, 2 * (0.25 / 4) ** 0.5)]
)
def test_a_trapezoid_takes_the_time_of_its_formula(way, duration):
    move = profiles.trapezoidal(way, v_max=2.0, a_max=4.0)
    assert move.duration == pytest.approx(duration, rel=1e-14)
    t, (s, v, a) = followed(profiles.path(move), 1.5 * duration, orders=3)
    assert s[-1] == way
    assert np.abs(v).max() == pytest.approx(min(2.0, (4 * abs(way)) ** 0.5), rel=1e-6)
    moving = t < duration * (1 - 1e-9)
    assert set(np.round(np.abs(a[moving]), 9)) <= {0.0, 4.0}
    assert np.abs(np.diff(v)[np.diff(t) == 0]).max() < 1e-12


@pytest.mark.parametrize(
    ("way", "limits", "pieces"),
    [
        (10.0, (2.0, 4.0, 40.0), 7),  # all limits reached
        (10.0, (0.1, 4.0, 40.0), 5),  # acceleration not reached
        (1.0, (2.0, 4.0, 40.0), 6),  # speed not reached
        (-0.001, (2.0, 4.0, 40.0), 4),  # nor is the acceleration
    ],
)
def test_an_s_curve_keeps_its_limits_and_is_as_quick_as_they_allow(way, limits, pieces):
    v_max, a_max, j_max = limits
    move = profiles.s_curve(way, *limits)
    assert len(move.pieces) == pieces
    t, (s, v, a, j) = followed(profiles.path(move), move.duration)
    assert s[-1] == pytest.approx(way, rel=1e-12)
    assert abs(v[-1]) < 1e-12 * v_max
    assert abs(a[-1]) < 1e-12 * a_max
    for values in (s, v, a):
        assert np.abs(np.diff(values)[np.diff(t) == 0]).max() < 1e-12 * 10
    assert np.abs(v).max() <= v_max * (1 + 1e-12)
    assert np.abs(a).max() <= a_max * (1 + 1e-12)
    assert np.abs(v).max() == pytest.approx(move.speed, rel=1e-6)
    assert np.abs(a).max() == pytest.approx(move.acceleration, rel=1e-3)
    # bang-bang: at every instant one of the limits is reached
    on_limit = np.isclose(np.abs(j), j_max, rtol=1e-9)
    on_limit |= np.isclose(np.abs(a), a_max, rtol=1e-9) | np.isclose(np.abs(v), v_max, rtol=1e-9)
    assert on_limit[t < move.duration * (1 - 1e-9)].all()


def test_moves_and_dwells_follow_each_other():
    there, back = profiles.polynomial5(2.0, 0.5), profiles.cycloidal(-2.0, 1.0)
    position = profiles.path(there, profiles.dwell(0.25), back, there, begin=0.1, start=1.0)
    grid = [0.05, 0.35, 0.6, 0.7, 0.85, 1.35, 1.85, 2.1, 2.35, 3.0]
    _, (s,) = followed(position, 3.0, 1, grid)
    assert s == pytest.approx([1, 2, 3, 3, 3, 2, 1, 2, 3, 3], abs=1e-12)


@pytest.mark.parametrize(
    ("action", "part"),
    [
        (lambda: profiles.cycloidal(0.0, 1.0), "distance = 0.0"),
        (lambda: profiles.cycloidal(1.0, -1.0), "duration = -1.0"),
        (lambda: profiles.trapezoidal(1.0, 0.0, 1.0), "v_max = 0.0"),
        (lambda: profiles.s_curve(1.0, 1.0, 1.0, float("inf")), "j_max = inf"),
        (lambda: profiles.trapezoidal(float("nan"), 1.0, 1.0), "distance = nan"),
        (lambda: profiles.dwell(0.0), "duration = 0.0"),
        (lambda: profiles.path(), "no moves"),
        (lambda: profiles.path([profiles.dwell(1.0)]), "a list as path(*moves)"),
        (lambda: profiles.path(1.0), "path: 1.0 is no move"),
        (lambda: profiles.path(profiles.dwell(1.0), begin=float("inf")), "begin = inf s"),
    ],
)
def test_values_that_make_no_sense_are_named(action, part):
    refused(OptionError, action, part)
