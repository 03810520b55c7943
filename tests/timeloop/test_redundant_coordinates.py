"""Runs on in redundant coordinates, where no choice of states leads a linkage well."""

import numpy as np
import pytest
from linkages import pendulum
from scipy.integrate import solve_ivp

import lumped as lp
from lumped.components import Bar
from lumped.components import translation as tr
from lumped.errors import StartError

G, LENGTH = 9.81, 2.0


def swing(v, until):
    """Angle from below and its rate of a pendulum pushed at its lowest place, by SciPy."""

    def rates(_, z):
        return [z[1], -G / LENGTH * np.sin(z[0])]

    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    return solve_ivp(rates, (0, until), [0.0, v / LENGTH], **options).y[:, -1]


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_errors_follow_the_tolerance_in_all_coordinates(rtol, method):
    v, until = 8.0, 4.0
    run = lp.simulate(lp.assemble(pendulum(v)), until=until, rtol=rtol, method=method, grid=[until])
    assert [event.after for event in run.events] == ["redundant coordinates"]
    phi, w = swing(v, until)
    found = [run[name][-1] for name in ("across.s", "down.s", "across.v", "down.v")]
    expected = LENGTH * np.array([np.sin(phi), np.cos(phi), np.cos(phi) * w, -np.sin(phi) * w])
    assert found == pytest.approx(expected, abs=100 * rtol * v)


def test_steps_are_about_those_of_the_angle():
    """Steps are of order eight, and coordinates have up to twice the frequencies of the angle."""

    class Angle(lp.Component):
        phi: lp.Var = lp.var("rad", "", 0.0)
        w: lp.Var = lp.var("rad/s", "", 4.0)

        def equations(self):
            yield lp.der(self.phi) == self.w
            yield lp.der(self.w) == -G / LENGTH * lp.ops.sin(self.phi)

    steps = [
        lp.simulate(lp.assemble(model), until=60.0, rtol=1e-8, grid=None, method="explicit").steps
        for model in (pendulum(8.0), Angle())
    ]
    assert steps[0] < 1.65 * steps[1]


def bars(**starts):
    """A parallelogram of two bars of 0.5 m and a coupler of 1 m."""
    crank = {"length": 0.5, "m": 1.0, "J": 0.02}
    parts = {
        "b1": Bar(**crank, w=2.0, **starts),
        "b2": Bar(length=1.0, m=1.0, J=0.08),
        "b3": Bar(**crank),
        "ox": tr.Fixed(),
        "oy": tr.Fixed(),
        "px": tr.Fixed(s0=1.0),
        "py": tr.Fixed(),
    }

    def connections(m):
        yield lp.connect(m.ox.flange, m.b1.a_x)
        yield lp.connect(m.oy.flange, m.b1.a_y)
        yield lp.connect(m.b1.b_x, m.b2.a_x)
        yield lp.connect(m.b1.b_y, m.b2.a_y)
        yield lp.connect(m.b2.b_x, m.b3.b_x)
        yield lp.connect(m.b2.b_y, m.b3.b_y)
        yield lp.connect(m.px.flange, m.b3.a_x)
        yield lp.connect(m.py.flange, m.b3.a_y)

    return lp.compose(connections=lambda m: list(connections(m)), **parts)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_a_parallelogram_turns_through_positions_with_all_bars_in_line(rtol):
    """Without gravity the coupler moves to and fro without turning, the cranks evenly."""
    start = {"b2.phi": 0.0, "b3.phi": 1.0}
    run = lp.simulate(lp.assemble(bars(phi=1.0)), until=6.0, rtol=rtol, start=start, grid=60)
    for name in ("b1.phi", "b3.phi"):
        assert run[name] == pytest.approx(1.0 + 2.0 * run.t, abs=100 * rtol)
    assert np.abs(run["b2.phi"]).max() < 100 * rtol


@pytest.mark.parametrize("near", [1e-9, -1e-7, 1e-5, -1e-3])
def test_a_parallelogram_starts_beside_the_position_with_all_bars_in_line(near):
    start = {"b1.phi": near, "b2.phi": 0.0, "b3.phi": near, "b2.w": 0.0, "b3.w": 2.0}
    run = lp.simulate(lp.assemble(bars()), until=3.0, rtol=1e-8, start=start, grid=30)
    assert run["b3.phi"] == pytest.approx(near + 2.0 * run.t, abs=1e-7)
    assert np.abs(run["b2.phi"]).max() < 1e-7


@pytest.mark.parametrize("near", [1e-9, 1e-7, 1e-4])
def test_a_parallelogram_falls_from_rest_beside_the_position_with_all_bars_in_line(near):
    """Its cranks turn alike: 0.415 kg.m2 and 1 kg.m in all, by SciPy."""
    model = bars().with_({f"b{k}.g": G for k in (1, 2, 3)})
    start = {f"b{k}.phi": near * (k != 2) for k in (1, 2, 3)}
    start |= {f"b{k}.w": 0.0 for k in (1, 2, 3)}
    run = lp.simulate(lp.assemble(model), until=1.0, rtol=1e-8, start=start, grid=[1.0])

    def rates(_, z):
        return [z[1], -G * np.cos(z[0]) / 0.415]

    end = solve_ivp(rates, (0, 1), [near, 0.0], "DOP853", rtol=1e-12, atol=1e-12).y[0, -1]
    assert [run["b1.phi"][-1], run["b3.phi"][-1]] == pytest.approx([end, end], abs=1e-6)


def test_speeds_that_fit_no_branch_are_refused():
    """In line the joints allow them, as 0.5 2 + 0.5 = 0.5 3, but none turns so on the way on."""
    start = {"b1.phi": 1e-11, "b2.phi": 0.0, "b3.phi": 1e-11, "b2.w": 0.5, "b3.w": 3.0}
    with pytest.raises(StartError, match=r"nearly in line.*fit none of the branches"):
        lp.start_point(lp.assemble(bars()), start=start)


def test_a_start_in_line_is_refused_with_the_linkage():
    with pytest.raises(StartError, match=r"singular position: constraints of b1, b2, b3.*beside"):
        lp.start_point(lp.assemble(bars(phi=0.0)))


def test_runs_go_on_from_points_of_such_runs():
    system = lp.assemble(pendulum(8.0))
    run = lp.simulate(system, until=2.0, rtol=1e-10, grid=20)
    for time in run.t[::3]:
        point = run.point(time)
        assert len(point.system.state_names) == 2
        assert point["down.s"] == pytest.approx(run["down.s"][run.t == time][0], abs=1e-13)
        if time < 2.0:
            again = lp.simulate(system, until=2.0, start=point, rtol=1e-10, grid=[2.0])
            assert again["across.s"][-1] == pytest.approx(run["across.s"][-1], abs=1e-8)
