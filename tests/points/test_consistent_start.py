"""Starts given by any quantities of mechanisms, and led by states that move there."""

import numpy as np
import pytest
from linkages import four_bar, rocker_angle
from scipy.integrate import solve_ivp

import lumped as lp
from benchmarks.published.car_axis import CAR_AXIS, CarAxis
from benchmarks.published.linkages import chain, chain_by_hand, double_four_bar
from lumped.components import Bar
from lumped.components import translation as tr
from lumped.errors import SolverError, StartError

RTOL = 1e-8


@pytest.mark.parametrize("given", [("yl", "vl", "yr", "vr"), ("xl", "xr", "ul", "ur")])
def test_the_car_axis_starts_by_any_of_its_quantities(given):
    values = {"xl": 0.0, "yl": 0.5, "xr": 1.0, "yr": 0.5}
    values |= {"ul": -0.5, "vl": 0.0, "ur": -0.5, "vr": 0.0}
    system = lp.assemble(CarAxis(**{name: values[name] for name in given}))
    run = lp.simulate(system, until=3.0, rtol=RTOL, grid=[3.0])
    for name, expected in CAR_AXIS.end.items():
        assert run[name][-1] == pytest.approx(expected, rel=100 * RTOL)


def test_the_gradient_of_a_run_led_by_other_states_is_that_of_differences():
    system, of = lp.assemble(CarAxis()), [lp.functionals.final("xr")]
    found = lp.gradient(system, of=of, by=["weight"], until=0.5, rtol=RTOL).derivatives[0, 0]
    ends = [
        lp.simulate(system, until=0.5, parameters={"weight": w}, rtol=1e-11, grid=[0.5])["xr"][-1]
        for w in (1 - 1e-4, 1 + 1e-4)
    ]
    assert found == pytest.approx((ends[1] - ends[0]) / 2e-4, rel=1e-5)


def test_a_run_from_the_point_that_was_found_is_the_same():
    system = lp.assemble(CarAxis())
    begins = lp.start_point(system), None
    ends = [
        lp.simulate(system, until=0.1, start=start, rtol=RTOL, grid=[0.1])["yl"][-1]
        for start in begins
    ]
    assert ends[0] == ends[1]


def test_an_ensemble_refuses_a_start_that_other_states_lead():
    of = [lp.functionals.final("yl")]
    with pytest.raises(SolverError, match="led by yl, yr"):
        lp.ensemble(lp.assemble(CarAxis()), over={"weight": [1.0, 1.1]}, of=of, until=0.1)


@pytest.mark.parametrize("n", [2, 3, 4, 5])
@pytest.mark.parametrize("above", [0.0, 1e-9])
def test_a_chain_falls_from_the_horizontal_as_in_angles(n, above):
    angle = np.pi / 2 - above
    run = lp.simulate(lp.assemble(chain(n, angle)), until=0.8, rtol=RTOL, grid=[0.8])
    hand = chain_by_hand(n, angle)
    found = solve_ivp(hand.rate, (0, 0.8), hand.start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    received = [run[f"mass[{i}].{way}"][-1] for i in range(n) for way in "xy"]
    assert received == pytest.approx(hand.read(found), abs=100 * RTOL * n)


class Pendulum(lp.Component):
    """A mass on a circle of 1 m."""

    x: lp.Var = lp.var("m", "", 1.0)
    y: lp.Var = lp.var("m", "")
    u: lp.Var = lp.var("m/s", "")
    v: lp.Var = lp.var("m/s", "")
    force: lp.Var = lp.var("N/m", "")

    def equations(self):
        yield lp.der(self.x) == self.u
        yield lp.der(self.y) == self.v
        yield lp.der(self.u) == -self.force * self.x
        yield lp.der(self.v) == -self.force * self.y - 9.81
        yield self.x**2 + self.y**2 == 1


SAME = {"x": 0.6, "y": -0.8, "u": 0.4, "v": 0.3}


@pytest.mark.parametrize("names", ["xyuv", "yuv", "xyv", "xyu", "yv", "xu", "yu"])
def test_starts_given_by_other_quantities_make_the_same_run(names):
    start = {name: SAME[name] for name in names}
    run = lp.simulate(lp.assemble(Pendulum()), until=1.0, rtol=1e-9, start=start, grid=[0.0, 1.0])
    for name, expected in SAME.items():
        assert run[name][0] == pytest.approx(expected, abs=1e-12)
    angle = np.arctan2(0.6, 0.8)
    found = solve_ivp(
        lambda _, z: [z[1], -9.81 * np.sin(z[0])], (0, 1), [angle, 0.5], rtol=1e-11, atol=1e-11
    ).y[0, -1]
    assert (run["x"][-1], run["y"][-1]) == pytest.approx((np.sin(found), -np.cos(found)), abs=1e-7)


@pytest.mark.parametrize(
    "start",
    [{"x": 1.0, "y": 0.1}, {"y": 1.5}, {"x": 1.0, "y": 0.0, "u": 0.4}, dict(SAME, v=0.4)],
)
def test_contradicting_starts_are_refused_with_their_equations(start):
    with pytest.raises(StartError, match=r"x\*\*2 \+ y\*\*2 = 1") as fault:
        lp.start_point(lp.assemble(Pendulum()), start=start)
    assert all(f"{name} = {value:g}" in str(fault.value) for name, value in start.items())


class Two(lp.Component):
    """Two masses and their distance, which shall lead."""

    x1: lp.Var = lp.var("m", "", 0.0)
    v1: lp.Var = lp.var("m/s", "", 1.0)
    x2: lp.Var = lp.var("m", "", 0.5)
    v2: lp.Var = lp.var("m/s", "", 3.0)
    gap: lp.Var = lp.var("m", "", state="prefer")
    w: lp.Var = lp.var("m/s", "", state="prefer")

    def equations(self):
        yield lp.der(self.x1) == self.v1
        yield lp.der(self.x2) == self.v2
        yield lp.der(self.v1) == self.gap - 0.5
        yield lp.der(self.v2) == -(self.gap - 0.5)
        yield self.gap == self.x2 - self.x1
        yield self.w == lp.der(self.gap)


def test_declared_starts_win_over_defaults_of_preferred_states():
    system = lp.assemble(Two())
    point = lp.start_point(system)
    expected = {"x1": 0.0, "x2": 0.5, "v1": 1.0, "v2": 3.0, "gap": 0.5, "w": 2.0}
    assert {name: point[name] for name in expected} == pytest.approx(expected, abs=1e-14)
    assert not point.lost
    # gap'' = -2 (gap - 0.5)
    run = lp.simulate(system, until=1.0, rtol=1e-10, grid=[1.0])
    assert run["gap"][-1] == pytest.approx(0.5 + 2 * np.sin(np.sqrt(2)) / np.sqrt(2), rel=1e-8)


def test_a_given_start_wins_over_declared_ones_which_are_named():
    point = lp.start_point(lp.assemble(Two()), start={"gap": 0.2})
    assert point["gap"] == pytest.approx(0.2, abs=1e-14)
    assert point["x2"] - point["x1"] == pytest.approx(0.2, abs=1e-14)
    assert any(text.startswith("x") for text in point.lost)
    assert "not kept: x" in repr(point)


@pytest.mark.parametrize("angle", [np.pi / 2, 1.0, 0.4, -0.7])
def test_a_linkage_closes_within_half_a_turn_of_its_guesses(angle):
    point = lp.start_point(lp.assemble(double_four_bar()), start={"u0.phi": angle})
    found = {name: point[f"{name}.phi"] for name in ("u0", "u1", "u2", "o0", "o1")}
    assert all(abs(value) <= np.pi for value in found.values())
    ends = [i + np.exp(1j * found[f"u{i}"]) for i in range(3)]
    for i in (0, 1):
        assert ends[i + 1] - ends[i] == pytest.approx(np.exp(1j * found[f"o{i}"]), abs=1e-9)


@pytest.mark.parametrize("crank", [0.3, 1.0, 1.8, 2.6])
def test_a_given_angle_of_the_rocker_holds_and_the_crank_follows(crank):
    rocker = rocker_angle(crank)
    point = lp.start_point(lp.assemble(four_bar()), start={"rocker.phi": rocker})
    assert point["rocker.phi"] == pytest.approx(rocker, abs=1e-9)
    found = rocker_angle(point["crank.phi"]) - rocker
    assert np.exp(1j * found) == pytest.approx(1.0, abs=1e-9)  # whole turns are none
    assert not any("rocker" in text for text in point.lost)


def crossed_parallelogram(given):
    """Bars of 0.84 m on a frame of 0.576 m, joined by a bar as long as the frame."""
    lengths = {"a": 0.84, "b": 0.576, "c": 0.84}
    bars = {n: Bar(length=lengths[n], m=1.0, J=0.1, **given[n]) for n in lengths}

    def connections(m):
        yield lp.connect(m.left.flange, m.a.a_x)
        yield lp.connect(m.right.flange, m.c.a_x)
        yield lp.connect(m.low.flange, m.a.a_y, m.c.a_y)
        for one, other in ((m.a.b_x, m.b.a_x), (m.a.b_y, m.b.a_y)):
            yield lp.connect(one, other)
        for one, other in ((m.b.b_x, m.c.b_x), (m.b.b_y, m.c.b_y)):
            yield lp.connect(one, other)

    ground = {"left": tr.Fixed(), "right": tr.Fixed(s0=lengths["b"]), "low": tr.Fixed()}
    return lp.compose(connections=lambda m: list(connections(m)), **bars, **ground)


def test_start_values_that_do_not_hold_beside_a_singular_position_are_named():
    """All bars in line but for 2e-7 rad, where rounding cannot tell both assemblies apart."""
    # 0.84 a^2 + 0.576 b^2 = 0.84 c^2 and 0.84 a + 0.576 b = 0.84 c, to second order
    a, share = 1.4e-7, 0.576 / 0.84
    b = 2 * a / (1 - share)
    angles = {"a": a, "b": b, "c": a + share * b}
    given = {name: {"phi": phi, "w": phi / a} for name, phi in angles.items()}
    point = lp.start_point(lp.assemble(crossed_parallelogram(given)))
    named = {text.split()[0] for text in point.lost}
    for name, values in given.items():
        for key, value in values.items():
            holds = abs(point[f"{name}.{key}"] - value) <= 1e-9 * max(1.0, abs(value))
            assert holds or f"{name}.{key}" in named
