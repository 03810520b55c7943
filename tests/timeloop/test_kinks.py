"""Kinks mean the same however they are written, and are found: against quadrature and SciPy."""

import itertools
import operator

import casadi as ca
import fmpy
import numpy as np
import pytest
from rows import assemble_row, assemble_rows
from scipy.integrate import quad, solve_ivp

import lumped as lp
from lumped.components import Inertia, Position, SpringDamper, Torque, translation
from lumped.errors import SolverError
from lumped.numerics.interval_bounds import interval_bounds

ops, t = lp.ops, lp.time
METHODS = ("auto", "explicit", "implicit", "taylor")

OF_TIME = {
    "maximum": (ops.maximum(0.0, t - 1.0), lambda x: max(0.0, x - 1.0)),
    "minimum": (ops.minimum(t, 1.0), lambda x: min(x, 1.0)),
    "abs": (abs(t - 1.0), lambda x: abs(x - 1.0)),
    "sign": (ops.sign(t - 0.7), lambda x: np.sign(x - 0.7)),
    "interpolate": (
        ops.interpolate(t, [0.5, 1.0, 1.5], [0.0, 0.0, 3.0]),
        lambda x: max(0.0, 6.0 * (x - 1.0)),
    ),
    "table with a jump": (
        ops.table([0.5, 1.0, 1.0, 1.5], [1.0, 2.0, -1.0, 3.0]),
        lambda x: np.interp(x, [0.5, 1.0, 1.0 + 1e-12, 1.5], [1.0, 2.0, -1.0, 3.0]),
    ),
    "nested": (
        ops.where(abs(t - 1.0) < 0.3, ops.maximum(ops.sin(9.0 * t), 0.0), -1.0),
        lambda x: max(np.sin(9.0 * x), 0.0) if abs(x - 1.0) < 0.3 else -1.0,
    ),
    "curve against a curve": (
        ops.where(ops.sin(7.0 * t) > 0.4 * t * t, 1.0, ops.cos(t)),
        lambda x: 1.0 if np.sin(7.0 * x) > 0.4 * x * x else np.cos(x),
    ),
    "piece of a piece": (
        ops.interpolate(abs(t - 0.9), [0.0, 0.2, 0.5], [1.0, 0.0, 2.0]),
        lambda x: np.interp(abs(x - 0.9), [0.0, 0.2, 1.5], [1.0, 0.0, 2.0 / 0.3 * 1.3]),
    ),
}


def turned(tau, **given):
    return assemble_row(torque=Torque(tau=tau), rotor=Inertia(**({"J": 1.0, "w": 0.0} | given)))


@pytest.mark.parametrize("name", OF_TIME)
def test_a_torque_of_time_has_the_integral_of_quadrature(name):
    expression, function = OF_TIME[name]
    knots = np.linspace(0, 2, 101)
    expected = sum(
        quad(function, a, b, epsabs=1e-12, epsrel=1e-12, limit=500)[0]
        for a, b in itertools.pairwise(knots)
    )
    for method in METHODS:
        run = lp.simulate(turned(expression), until=2.0, method=method, rtol=1e-9)
        assert run["rotor.w"][-1] == pytest.approx(expected, abs=3e-8), method


@pytest.mark.parametrize("method", METHODS)
def test_a_square_wave_changes_at_all_its_instants(method):
    w = 1e4
    run = lp.simulate(turned(ops.where(ops.sin(w * t) > 0, 1.0, 0.0)), until=1.0, method=method)
    expected = np.arange(1, int(w / np.pi) + 1) * np.pi / w
    assert len(expected) == 3183
    found = np.array([event.time for event in run.events])
    assert found == pytest.approx(expected, rel=1e-13)
    on = 0.5 * expected[1::2].size * 2 * np.pi / w  # all full turns, half of each
    rest = 1.0 - expected[1::2][-1]
    assert run["rotor.w"][-1] == pytest.approx(on + min(rest, np.pi / w), rel=1e-9)


def test_a_wave_reaches_a_condition_through_other_components():
    class Comparator(lp.Component):
        u = lp.Input("1", "compared with zero")
        y = lp.Output("N.m", "torque")

        def equations(self):
            yield self.y == ops.where(self.u > 0, 1.0, 0.0)

    class Wave(lp.Component):
        y = lp.Output("1", "wave")

        def equations(self):
            yield self.y == ops.sin(1000.0 * t)

    system = assemble_rows(
        "wave.y compare.u",
        "compare.y torque.tau",
        "torque rotor",
        wave=Wave(),
        compare=Comparator(),
        torque=Torque(),
        rotor=Inertia(J=1.0),
    )
    assert len(lp.simulate(system, until=2.0).events) == int(2000 / np.pi)


def test_changes_without_end_are_refused_by_name():
    system = turned(ops.where(ops.sin(1.0 / (t - 0.5)) > 0, 1.0, 0.0))
    with pytest.raises(SolverError, match=r"sin\(1 / \(time - 0.5\)\).*torque.*near t = 0.49"):
        lp.simulate(system, begin=0.49, until=1.0)


class Law(lp.Component):
    """A torque that depends on the speed."""

    flange = lp.Flange()
    w: lp.Var = lp.var("rad/s", "speed")
    law: object = None

    def equations(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == self.law(self.w)


PLACES, HEIGHTS = [-2.0, -0.5, 0.0, 0.3, 1.0, 2.5], [-1.0, -0.2, 0.0, 0.8, 0.5, 1.5]
OF_SPEED = {
    "abs": (lambda w: 0.3 * w * abs(w) + 0.2 * abs(w - 0.4),) * 2,
    "sign beside others": (
        lambda w: 0.5 * ops.sign(w - 0.5) + 0.1 * w,
        lambda w: 0.5 * np.sign(w - 0.5) + 0.1 * w,
    ),
    "sign alone": (lambda w: 0.5 * ops.sign(w + 3.0), lambda w: 0.5),
    "minimum": (lambda w: ops.minimum(w, 0.5), lambda w: min(w, 0.5)),
    "maximum": (lambda w: ops.maximum(0.0, w), lambda w: max(0.0, w)),
    "rows": (
        lambda w: ops.interpolate(w, PLACES, HEIGHTS),
        lambda w: np.interp(w, PLACES, HEIGHTS),
    ),
}


SWING = 2.0 * ops.sin(3.0 * t)


def braked(law, tau=SWING, w=-0.8):
    load = law if isinstance(law, lp.Component) else Law(law=law)
    return assemble_rows(
        "torque rotor.flange_a load", torque=Torque(tau=tau), rotor=Inertia(J=1.0, w=w), load=load
    )


def follow(function, until, longest):
    """Speed at the end by SciPy, with steps that see each kink."""
    options = {"rtol": 1e-10, "atol": 1e-12, "max_step": longest}
    found = solve_ivp(
        lambda t, y: [2 * np.sin(3 * t) - function(y[0])], (0, until), [-0.8], **options
    )
    return found.y[0, -1]


@pytest.mark.parametrize("name", OF_SPEED)
def test_a_torque_of_the_speed_follows_scipy(name):
    law, function = OF_SPEED[name]
    expected = follow(function, 4, 2e-3)
    for method in METHODS[1:]:
        run = lp.simulate(braked(law), until=4.0, method=method, rtol=1e-9)
        assert run["rotor.w"][-1] == pytest.approx(expected, abs=2e-6), method


def test_many_rows_cost_one_margin():
    places = np.linspace(-5, 5, 2000)
    system = braked(lambda w: ops.interpolate(w, places.tolist(), np.sin(places).tolist()))
    assert system.margins.size1_out(0) == 1
    short = braked(lambda w: ops.interpolate(w, [-5.0, 0.0, 5.0], [1.0, 0.0, 3.0]))
    assert system.rhs.n_instructions() == short.rhs.n_instructions()


def test_a_run_past_many_rows_follows_the_curve_through_them():
    places = np.linspace(-5, 5, 1000)
    law = np.tanh(2 * places) + 0.1 * places
    run = lp.simulate(
        braked(lambda w: ops.interpolate(w, places.tolist(), law.tolist())), until=2.0, rtol=1e-9
    )
    expected = follow(lambda w: np.interp(w, places, law), 2, 1e-3)
    assert run["rotor.w"][-1] == pytest.approx(expected, abs=1e-7)
    crossed = np.abs(np.diff(np.searchsorted(places, run["rotor.w"]))).sum()
    assert len(run.events) >= crossed > 50


def test_rows_may_be_parameters():
    class Rows(lp.Component):
        flange = lp.Flange()
        low: lp.Param = lp.param("N.m", "torque at rest", 0.2)
        high: lp.Param = lp.param("N.m", "torque at 1 rad/s", 0.9)
        w: lp.Var = lp.var("rad/s", "speed")

        def equations(self):
            yield self.w == lp.der(self.flange.phi)
            yield self.flange.tau == ops.interpolate(
                self.w, [0.0, 1.0, 3.0], [self.low, self.high, self.high]
            )

    system = braked(Rows(), 1.5, 0.0)

    def at(low, high):  # the speed rises exponentially up to 1 rad/s, then evenly
        k = high - low
        there = np.log((1.5 - low) / (1.5 - low - k)) / k
        return 1.0 + (1.5 - high) * (3.0 - there)

    run = lp.simulate(system, until=3.0, rtol=1e-10)
    assert run["rotor.w"][-1] == pytest.approx(at(0.2, 0.9), rel=1e-9)
    found = lp.sensitivity(
        system, until=3.0, of=["rotor.w"], by=["load.low", "load.high"], rtol=1e-10
    )
    for name, step in (("load.low", (1e-6, 0)), ("load.high", (0, 1e-6))):
        high, low = at(0.2 + step[0], 0.9 + step[1]), at(0.2 - step[0], 0.9 - step[1])
        assert found["rotor.w", name][-1] == pytest.approx((high - low) / 2e-6, rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize(
    ("motion", "jumps"),
    [
        (abs(t - 0.5), r"first\.w .*jump from -1 to 1"),
        (ops.minimum(2 * t, 1.0), r"first\.w .*jump from 2 to 0"),
        (ops.sign(t - 0.5), r"second\.phi .*jump from -1 to 1"),
        (ops.where(t >= 0.5, 1.0, -1.0), r"second\.phi .*jump from -1 to 1"),
    ],
    ids=["abs", "minimum", "sign", "where"],
)
def test_a_prescribed_motion_with_a_kink_is_refused_however_it_is_written(motion, jumps, method):
    system = assemble_row(
        position=Position(phi=motion),
        first=Inertia(J=0.5),
        shaft=SpringDamper(c=50.0, d=0.5),
        second=Inertia(J=0.3),
    )
    with pytest.raises(SolverError, match=rf"{jumps} at t = 0\.5"):
        lp.simulate(system, until=1.0, method=method)


def test_smooth_takes_the_kink_but_not_the_stop():
    law, _ = OF_SPEED["abs"]
    run = lp.simulate(braked(lambda w: ops.smooth(law(w))), until=4.0, rtol=1e-9)
    stopped = lp.simulate(braked(law), until=4.0, rtol=1e-9)
    assert len(run.events) == 0
    assert len(stopped.events) > 3
    assert run["rotor.w"][-1] == pytest.approx(stopped["rotor.w"][-1], abs=1e-6)


def test_what_a_branch_does_not_need_is_not_watched():
    def law(w):
        return ops.where(w > 10.0, ops.maximum(w, 0.0) + abs(w + 0.1), 0.0)

    run = lp.simulate(braked(law), until=4.0)
    assert run["rotor.w"].min() < 0 < run["rotor.w"].max()
    assert run.events == ()


def test_a_unit_has_the_tables_and_the_waves(tmp_path):
    spline = ops.periodic_spline(t, [0.0, 0.2, 0.3, 0.6, 0.7], [0.0, 1.0, -1.0, 0.5, 0.0])
    tau = spline + ops.interpolate(t, [0.1, 0.5, 0.9], [0.0, 1.0, -1.0]) + 2.0 * ops.sin(9.0 * t)
    system = braked(lambda w: ops.interpolate(w, PLACES, HEIGHTS), tau)
    run = lp.simulate(system, until=2.0, method="explicit", rtol=1e-9)
    unit = lp.export_fmu(system, tmp_path / "unit.fmu", outputs=["rotor.w"], rtol=1e-9)
    found = fmpy.simulate_fmu(
        str(unit.path), stop_time=2.0, output_interval=2.0, fmi_type="CoSimulation"
    )
    assert found["rotor.w"][-1] == pytest.approx(run["rotor.w"][-1], abs=1e-7)
    assert not unit.notes
    wavy = turned(ops.where(ops.sin(30.0 * t) > 0, 1.0, 0.0))
    told = lp.export_fmu(wavy, tmp_path / "wavy.fmu", outputs=["rotor.w"])
    assert "sin(30 * time)" in told.notes[0]


@pytest.mark.parametrize("seed", range(20))
def test_bounds_hold_what_a_function_takes_inside_them(seed):
    rng = np.random.default_rng(seed)
    x = ca.SX.sym("x")
    pool = [x, ca.SX(float(rng.normal())), ca.SX(float(rng.normal()))]
    one = [ca.sin, ca.cos, ca.exp, ca.fabs, ca.tanh, ca.atan, ca.floor, ca.sign, lambda a: a * a]
    two = [operator.add, operator.sub, operator.mul, operator.truediv, ca.fmin, ca.fmax, ca.atan2]
    two.append(lambda a, b: ca.if_else(a > b, a, 2 * b))
    for _ in range(8):
        if rng.random() < 0.5:
            pool.append(one[rng.integers(len(one))](pool[rng.integers(len(pool))]))
        else:
            a, b = (pool[i] for i in rng.integers(len(pool), size=2))
            pool.append(two[rng.integers(len(two))](a, b))
    function = ca.Function("f", [x], [ca.densify(pool[-1])])
    low = rng.uniform(-3, 3, 50)
    high = low + 10 ** rng.uniform(-3, 0.5, 50)
    found = interval_bounds(function)(low[None, :], high[None, :])
    least, most = (np.asarray(v).ravel() for v in found)
    for share in np.linspace(0, 1, 41):
        values = np.asarray(function((low + share * (high - low))[None, :])).ravel()
        fine = np.isfinite(values)
        slack = 1e-12 * (1 + np.abs(values))
        assert (values >= least - slack)[fine].all()
        assert (values <= most + slack)[fine].all()


def test_a_prescribed_motion_passes_a_kink_of_a_ratio():
    class TwoRatios(lp.Component):
        """Rack that moves half as far for a turn from 1 rad on."""

        a = lp.Flange()
        b = lp.LinearFlange()

        def equations(self):
            phi = self.a.phi
            yield lp.lossless(self.b.s == ops.where(phi < 1, phi, 0.5 * phi + 0.5), self.a, self.b)

    model = lp.compose(
        rack=TwoRatios(),
        drive=translation.Position(s=2 * t),
        body=Inertia(J=1.0),
        connections=lambda m: [
            lp.connect(m.drive.flange, m.rack.b),
            lp.connect(m.rack.a, m.body.flange_a),
        ],
    )
    run = lp.simulate(lp.assemble(model), until=1.0)
    received = [event.time for event in run.events], run["body.phi"][-1], run["body.w"][-1]
    assert received == (pytest.approx([0.5], abs=1e-12), pytest.approx(3.0), pytest.approx(4.0))
