"""A load of many rows: what it costs, and derivatives over it against closed forms."""

import numpy as np
import pytest
from rows import assemble_row

import lumped as lp
from lumped import functionals as f
from lumped.components import Inertia, Torque
from lumped.functionals.functional import readings_of
from lumped.gradients.functional_values import RunReadings
from lumped.gradients.legs import record_run
from lumped.life import SNCurve
from lumped.timeloop.run_options import run_plan

J, ROWS = 2.0, 400
TIMES = np.linspace(0.0, 8.0, ROWS)
LOAD = 50.0 + 20.0 * np.random.default_rng(3).standard_normal(ROWS)
CURVE = SNCurve(30.0, 1e6, 5.0, unit="rad/s2")
KINDS = {"table": lambda e: e, "smooth": lp.ops.smooth}


def turned(tau):
    return assemble_row(torque=Torque(tau=tau), rotor=Inertia(J=J, w=0.0))


def legs_of(system, functionals, until):
    plan = run_plan(until, 1e-6, {"method": "explicit"}).by_steps("gradient", are_followed=True)
    run = record_run(system, plan)
    return RunReadings(run, readings_of(functionals), 1e-6, joins=True).course.legs


def test_smooth_passes_the_rows_of_a_table_one_by_one_and_tells_no_events():
    system = turned(lp.ops.smooth(lp.ops.table(TIMES, LOAD)))
    short = turned(lp.ops.smooth(lp.ops.table([0.0, 4.0, 8.0], [1.0, 0.0, 3.0])))
    assert system.rhs.n_instructions() == short.rhs.n_instructions()
    run = lp.simulate(system, until=8.0)
    assert run.events == ()
    assert run["rotor.w"][-1] == pytest.approx(np.trapezoid(LOAD, TIMES) / J, rel=1e-12)
    assert len(lp.simulate(turned(lp.ops.table(TIMES, LOAD)), until=8.0).events) == ROWS - 1


def test_smooth_of_a_table_of_the_state_or_that_repeats_stops_nowhere():
    waves = lp.ops.interpolate(lp.time, [0.0, 0.01, 0.02], [0.0, 1.0, 0.0], period=0.02)
    run = lp.simulate(turned(lp.ops.smooth(waves)), until=0.2, rtol=1e-9)
    assert run.statistics.segments == 1
    assert run["rotor.w"][-1] == pytest.approx(0.1 / J, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_points_of_a_table_cost_a_gradient_no_more_than_steps(kind):
    system = turned(KINDS[kind](lp.ops.table(TIMES, LOAD)))
    until, a = 7.99, LOAD / J
    wanted = [f.final("rotor.w"), f.rms("rotor.a"), f.peak("rotor.a"), f.damage("rotor.a", CURVE)]
    assert len(legs_of(system, wanted, until)) == 1
    found = lp.gradient(system, of=wanted, by=["rotor.J"], until=until, rtol=1e-9)
    at_end = np.interp(until, TIMES, a)
    t, y = np.append(TIMES[:-1], until), np.append(a[:-1], at_end)
    squares = (np.diff(t) * (y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2)).sum() / 3
    damage = f.damage("rotor.a", CURVE)
    d = lp.simulate(system, until=until, rtol=1e-9).value(damage)
    expected = np.array([np.trapezoid(y, t), np.sqrt(squares / until), a.max(), 5 * d]) / -J
    np.testing.assert_allclose(found.derivatives.ravel(), expected, rtol=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_both_sides_of_a_jump_of_a_load_are_seen(kind):
    load = lp.ops.table([0.0, 1.0, 1.0, 2.0, 3.0], [1.0, 5.0, -9.0, 4.0, 4.0])
    system = turned(KINDS[kind](load))
    highest = f.peak("rotor.a")
    assert len(legs_of(system, [highest], 2.5)) == 2
    assert len(legs_of(system, [f.rms("rotor.a")], 2.5)) == 1
    found = lp.gradient(system, of=[highest, f.lowest("rotor.a")], by=["rotor.J"], until=2.5)
    np.testing.assert_allclose(found.derivatives.ravel(), [-9.0 / J**2, 9.0 / J**2], rtol=1e-9)


def test_a_table_whose_points_move_keeps_them():
    class Late(lp.Component):
        flange = lp.Flange()
        t_0: lp.Param = lp.param("s", "begin", 0.3)

        def equations(self):
            load = lp.ops.interpolate(lp.time - self.t_0, [0.0, 1.0, 1.5], [0.0, 4.0, 0.0])
            yield self.flange.tau == -lp.ops.smooth(load)

    system = assemble_row(torque=Late(), rotor=Inertia(J=J, w=0.0))
    wanted = [f.final("rotor.w")]
    assert len(legs_of(system, wanted, 2.0)) == 2
    found = lp.gradient(system, of=wanted, by=["torque.t_0"], until=2.0)
    at_both = [4 * (-0.3), 4 * (1 - (2.0 - 0.3 - 1.0) / 0.5)]  # the first and last line go on
    assert found.derivatives.item() == pytest.approx((at_both[0] - at_both[1]) / J, rel=1e-8)
