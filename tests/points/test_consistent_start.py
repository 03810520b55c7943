"""Starts given by any quantities of mechanisms, and led by states that move there."""

import numpy as np
import pytest
from elastic_crank import END, ElasticCrank
from linkages import four_bar, rocker_angle
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import Bar
from lumped.components import translation as tr
from lumped.errors import SolverError, StartError
from lumped.ops import sin, sqrt

RTOL = 1e-8


class CarAxis(lp.Component):
    """Of the Test Set for IVP Solvers (Mazzia, Bari): index 3, starts where yl, yr must lead."""

    xl: lp.Var = lp.var("1", "", 0.0)
    yl: lp.Var = lp.var("1", "", 0.5)
    xr: lp.Var = lp.var("1", "", 1.0)
    yr: lp.Var = lp.var("1", "", 0.5)
    ul: lp.Var = lp.var("1", "", -0.5)
    vl: lp.Var = lp.var("1", "", 0.0)
    ur: lp.Var = lp.var("1", "", -0.5)
    vr: lp.Var = lp.var("1", "", 0.0)
    weight: lp.Param = lp.param("1", "", 1.0)
    l1: lp.Var = lp.var("1", "")
    l2: lp.Var = lp.var("1", "")

    def equations(self):
        yb = 0.1 * sin(10.0 * lp.time)
        xb, k, g = sqrt(1.0 - yb**2), 10.0 * 1e-4 / 2, self.weight
        xl, yl, xr, yr, l1, l2 = self.xl, self.yl, self.xr, self.yr, self.l1, self.l2
        left, right = sqrt(xl**2 + yl**2), sqrt((xr - xb) ** 2 + (yr - yb) ** 2)
        for position, speed in ((xl, self.ul), (yl, self.vl), (xr, self.ur), (yr, self.vr)):
            yield lp.der(position) == speed
        yield k * lp.der(self.ul) == (0.5 - left) * xl / left + l1 * xb + 2 * l2 * (xl - xr)
        yield k * lp.der(self.vl) == (0.5 - left) * yl / left + l1 * yb + 2 * l2 * (yl - yr) - k * g
        yield k * lp.der(self.ur) == (0.5 - right) * (xr - xb) / right - 2 * l2 * (xl - xr)
        yield k * lp.der(self.vr) == (0.5 - right) * (yr - yb) / right - 2 * l2 * (yl - yr) - k * g
        yield xb * xl + yb * yl == 0
        yield (xl - xr) ** 2 + (yl - yr) ** 2 == 1.0


CAR = {
    "xl": 0.0493455784275402809122,
    "yl": 0.496989460230171153861,
    "xr": 1.04174252488542151681,
    "yr": 0.373911027265361256927,
}
"""Its reference at t = 3."""


@pytest.mark.parametrize("given", [(), ("yl", "vl", "yr", "vr"), ("xl", "xr", "ul", "ur")])
def test_the_car_axis_runs_from_its_published_start(given):
    values = {"xl": 0.0, "yl": 0.5, "xr": 1.0, "yr": 0.5}
    values |= {"ul": -0.5, "vl": 0.0, "ur": -0.5, "vr": 0.0}
    system = lp.assemble(CarAxis(**{name: values[name] for name in given}))
    run = lp.simulate(system, until=3.0, rtol=RTOL, grid=[3.0])
    for name, expected in CAR.items():
        assert run[name][-1] == pytest.approx(expected, rel=100 * RTOL)


def test_the_elastic_crank_runs_from_its_published_start():
    system = lp.assemble(ElasticCrank())
    run = lp.simulate(system, until=0.1, rtol=RTOL, grid=[0.1])
    for name, expected in END.items():  # the reference itself is good to 3e-8
        assert run[name][-1] == pytest.approx(expected, rel=10 * RTOL)


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


class Point(lp.Component):
    """A mass in a plane."""

    px = lp.LinearFlange(free=True)
    py = lp.LinearFlange(free=True)
    x: lp.Var = lp.var("m", "")
    y: lp.Var = lp.var("m", "")
    u: lp.Var = lp.var("m/s", "")
    v: lp.Var = lp.var("m/s", "")

    def equations(self):
        yield self.px.s == self.x
        yield self.py.s == self.y
        yield self.u == lp.der(self.x)
        yield self.v == lp.der(self.y)
        yield lp.der(self.u) == self.px.f
        yield lp.der(self.v) == self.py.f - 9.81


class Rod(lp.Component):
    """A rod without mass."""

    ax = lp.LinearFlange(grounded=True)
    ay = lp.LinearFlange(grounded=True)
    bx = lp.LinearFlange()
    by = lp.LinearFlange()
    force: lp.Var = lp.var("N/m", "")

    def equations(self):
        x, y = self.bx.s - self.ax.s, self.by.s - self.ay.s
        yield x**2 + y**2 == 1.0
        for flange, length, sign in ((self.bx, x, 1), (self.by, y, 1), (self.ax, x, -1)):
            yield flange.f == sign * self.force * length
        yield self.ay.f == -self.force * y


def chain(n, angle):
    """Pendulums of 1 m and 1 kg below each other, at rest at an angle to the vertical."""
    masses = [
        Point(x=(i + 1) * np.sin(angle), y=-(i + 1) * np.cos(angle), u=0.0, v=0.0) for i in range(n)
    ]

    def connections(m):
        for i in range(n):
            more = i + 1 < n
            yield lp.connect(m.rod[i].bx, m.mass[i].px, *[m.rod[j].ax for j in [i + 1] if more])
            yield lp.connect(m.rod[i].by, m.mass[i].py, *[m.rod[j].ay for j in [i + 1] if more])

    parts = {"mass": masses, "rod": [Rod() for _ in range(n)]}
    return lp.compose(connections=lambda m: list(connections(m)), **parts)


def lagrange(n, angle, until):
    """The same in angles: last positions by SciPy."""
    below = np.minimum.outer(n - np.arange(n), n - np.arange(n))

    def rates(_, z):
        a, w = z[:n], z[n:]
        gap = a[:, None] - a[None, :]
        weight = 9.81 * (n - np.arange(n)) * np.sin(a)
        return [*w, *np.linalg.solve(below * np.cos(gap), -(below * np.sin(gap)) @ w**2 - weight)]

    begin = [angle] * n + [0.0] * n
    found = solve_ivp(rates, (0, until), begin, "DOP853", rtol=1e-12, atol=1e-12).y[:n, -1]
    return np.cumsum(np.sin(found)), -np.cumsum(np.cos(found))


@pytest.mark.parametrize("n", [2, 3, 4, 5])
@pytest.mark.parametrize("above", [0.0, 1e-9])
def test_a_chain_falls_from_the_horizontal_as_in_angles(n, above):
    angle = np.pi / 2 - above
    run = lp.simulate(lp.assemble(chain(n, angle)), until=0.8, rtol=RTOL, grid=[0.8])
    for i, (x, y) in enumerate(zip(*lagrange(n, angle, 0.8), strict=True)):
        received = run[f"mass[{i}].x"][-1], run[f"mass[{i}].y"][-1]
        assert received == pytest.approx((x, y), abs=100 * RTOL * n)


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


def double_four_bar():
    """A02 of IFToMM: two windows of bars of 1 m."""

    def connections(k):
        up = k.u0, k.u1, k.u2
        for i in range(3):
            yield lp.connect(k.gx[i].flange, up[i].a_x)
            yield lp.connect(k.gy[i].flange, up[i].a_y)
        for way in "xy":
            a, b = f"a_{way}", f"b_{way}"
            yield lp.connect(getattr(k.u0, b), getattr(k.o0, a))
            yield lp.connect(getattr(k.u1, b), getattr(k.o0, b), getattr(k.o1, a))
            yield lp.connect(getattr(k.u2, b), getattr(k.o1, b))

    bars = {name: Bar(length=1.0, m=1.0, J=1 / 12) for name in ("u0", "u1", "u2", "o0", "o1")}
    ground = {"gx": [tr.Fixed(s0=float(i)) for i in range(3)], "gy": [tr.Fixed() for _ in "abc"]}
    return lp.compose(connections=lambda k: list(connections(k)), **bars, **ground)


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
