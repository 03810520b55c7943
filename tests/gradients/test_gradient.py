"""Gradients of functionals against closed forms, forward sensitivities and differences."""

import numpy as np
import pytest
from checks import by_complex_step, refused
from rows import assemble_row, one

import lumped as lp
from lumped import functionals as fun
from lumped.components import Damper, Fixed, Inertia, Torque
from lumped.errors import OptionError, SolverError, UnknownNameError
from lumped.models.carrousel_coiler import scenes as coiler
from lumped.models.carrousel_coiler.drive import TENSION, THICKNESS, WIDTH
from lumped.models.eccentric_shear import scenes as shear
from lumped.models.pilger_mill import drive as pilger
from lumped.models.reversing_mill import scenes as mill
from lumped.models.rotary_arm import control as arm
from lumped.ops import where


def by_differences(functions, point, step):
    """The same by central differences of sixth order, of functions of many points at once."""
    weights = np.array([-1 / 60, 3 / 20, -3 / 4, 3 / 4, -3 / 20, 1 / 60])
    h = step * np.abs(point)
    moved = point + np.array([-3, -2, -1, 1, 2, 3])[:, None] * np.diag(h)[:, None]
    values = functions(moved.reshape(-1, len(point))).reshape(len(point), 6, -1)
    return (weights @ values / h[:, None]).T


# -- closed forms ------------------------------------------------------------------------------

UNTIL = 3.0


def damped(t, k, d, x_0, v_0):
    """Position and speed of x'' + d x' + k x == 0."""
    w = np.sqrt(k - d**2 / 4)
    b = (v_0 + d / 2 * x_0) / w
    decay = np.exp(-d / 2 * t)
    x = decay * (x_0 * np.cos(w * t) + b * np.sin(w * t))
    v = -d / 2 * x + w * decay * (b * np.cos(w * t) - x_0 * np.sin(w * t))
    return x, v


@pytest.fixture
def oscillator():
    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == -self.k * self.x - self.d * self.v

    return lp.assemble(
        one(
            equations,
            k=lp.param("1/s2", "stiffness over mass", 4.0),
            d=lp.param("1/s", "damping over mass", 0.3),
            x=lp.var("m", "position", start=1.5),
            v=lp.var("m/s", "velocity", start=2.0),
        )
    )


POINT = np.array([4.0, 0.3, 1.5, 2.0])


def sums(k, d, x_0, v_0):
    """Final position, mean and root mean square of x, work of v on x, by Gauss-Legendre."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    t, w = UNTIL / 2 * (nodes + 1), UNTIL / 2 * weights
    x, v = damped(t, k, d, x_0, v_0)
    last = damped(np.array([UNTIL]), k, d, x_0, v_0)[0][0]
    return np.array([last, w @ x / UNTIL, np.sqrt(w @ x**2 / UNTIL), w @ (x * v)])


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_damped_oscillation_has_the_gradients_of_its_closed_form(oscillator, method):
    of = [fun.final("x"), fun.mean("x"), fun.rms("x"), fun.integral("x", "v")]
    to = ["k", "d", "x", "v"]
    found = lp.gradient(oscillator, of=of, by=to, until=UNTIL, rtol=1e-11, method=method)
    assert method in found.run.statistics.method
    assert found.values == pytest.approx(sums(*POINT), rel=1e-9)
    assert found.derivatives == pytest.approx(by_complex_step(sums, POINT), rel=1e-8, abs=1e-9)


def test_a_run_without_states_has_derivatives_too():
    system = assemble_row(motor=Torque(tau=0.0), a=Inertia(J=2.0), oil=Damper(d=0.7), wall=Fixed())
    run = lp.inverse(system, motion={"a.w": lp.ops.sin(lp.time)}, drive="motor.tau", until=1.0)
    of = [fun.integral("motor.tau", "motor.tau"), fun.highest("motor.tau")]
    found = lp.gradient(run.system, of=of, by=["a.J", "oil.d"], until=1.0)
    # tau = J cos t + d sin t, greatest where tan t = d / J
    J, d, s, c = 2.0, 0.7, np.sin(1.0), np.cos(1.0)
    integral = [J * (1 + s * c) + d * s**2, d * (1 - s * c) + J * s**2]
    top = [J / np.hypot(J, d), d / np.hypot(J, d)]
    assert found.derivatives == pytest.approx(np.array([integral, top]), rel=1e-10)
    forward = lp.sensitivity(run.system, of=["motor.tau"], by=["a.J"], until=1.0)
    assert forward["motor.tau", "a.J"] == pytest.approx(np.cos(forward.run.t), abs=1e-12)


# -- the machines --------------------------------------------------------------------------------


def rolling():
    system = mill.skidding(until=1e-3).system
    of = [fun.peak("upper.spindle.tau"), fun.rms("upper.shaft.tau"), fun.final("lower.motor.w")]
    to = ["M_s", "M_k", "upper.spindle.c", "lower.gearbox.J"]
    start = dict.fromkeys(mill.SHAFTS, mill.RATED)
    return system, [*of, fun.instant("gap", "forward")], to, 0.2, start, {}, 2


def winding():
    system = coiler.elastic_winding(until=1e-3).system
    stretch = TENSION * coiler.FREE / (coiler.MODULUS * WIDTH * THICKNESS)
    of = [fun.peak("drive.motor.flange.tau"), fun.rms("strip.T"), fun.final("drive.mandrel.w")]
    to = ["drive.rotor.J", "drive.eta", "free"]
    return system, of, to, 2.0, {"strip.s_rel": stretch}, {}, 0


def piercing():
    system = pilger.running(until=1e-3).system
    of = [fun.peak("motor.tau"), fun.rms("motor.tau"), fun.final("motor.w")]
    to = ["motor.J", "gear.ratio", "mill.T_f", "mill.L"]
    return system, of, to, 0.6, {"motor.w": pilger.GEAR * pilger.SPEED["P"]}, {}, 0


def cutting():
    # over the instants at which the carriage is taken along and let go
    system = shear.free_run(until=1e-3).system
    start = {"motor.w": shear.SPEED, "motor.phi": 0.0, "motor.i": 0.0}
    start |= shear.seat_support(shear.PrintedShear)
    of = [fun.peak("motor.tau"), fun.rms("motor.tau"), fun.final("motor.w")]
    to = ["loaded.cut.tau_max", "motor.k"]
    return system, of, to, 2.0, start, {"eps": 0.1}, 3


def taking():
    # already moving, over the instant at which the mandrel is taken
    system = arm.run_controlled(until=1e-3).system
    start = {"arm.phi": arm.BEGIN, "motor.tau": 0.0, "motor.x": 0.0, "motor.w": 2.0}
    start |= {"arm.mandrel.phi": arm.ADOPTED.pick_up, "arm.table.gap": 0.0}
    of = [fun.lowest("arm.trays.w"), fun.rms("motor.tau"), fun.final("arm.trays.w")]
    to = ["motor.J", "arm.m_x", "reducer.eta", "arm.arms.m"]
    return system, of, to, 1.0, start, {}, 2


@pytest.mark.parametrize("scene", [rolling, winding, piercing, cutting, taking])
def test_the_machines_agree_with_differences_of_sixth_order(scene):
    system, of, to, until, start, changed, events = scene()
    options = {"of": of, "until": until, "start": start, "parameters": changed, "rtol": 1e-12}
    found = lp.gradient(system, by=to, **options)
    assert len(found.run.events) >= events
    assert not found.shared
    point = np.array([(system.parameters | changed)[name] for name in to])

    def values(points):
        over = [dict(zip(to, point, strict=True)) for point in points.tolist()]
        return lp.ensemble(system, over=over, **options).values

    # the drill begins beside the speed of its controller: a wide step sees the bend of its swing
    step, limit = (1e-4, 1e-7) if scene is piercing else (1e-3, 1e-8)
    error = (found.derivatives - by_differences(values, point, step)) * point
    error = np.abs(error / found.values[:, None])
    print(f"\n{scene.__name__}: largest error of p/y dy/dp {error.max():.1e}, of")
    print(np.abs(found.relative).max(axis=1))
    assert error.max() < limit


def test_shares_of_indeterminate_constraints_that_let_go_are_told():
    # at rest reducer and bearings both hold the arm
    run = arm.run_controlled(until=1e-3, grid=2)
    system, held, gain = run.system, run["motor.tau"][0], arm.BANDWIDTH * arm.J_M
    start = {"arm.phi": arm.BEGIN, "motor.tau": held, "motor.x": held / gain}
    start |= {"arm.mandrel.phi": arm.ADOPTED.pick_up, "arm.table.gap": 0.0}
    of, to = [fun.final("motor.tau")], ["motor.J"]
    found = lp.gradient(system, of=of, by=to, until=0.05, start=start)
    assert found.shared == (found.run.events[0].time,)
    assert "shares of indeterminate constraints" in repr(found)


# -- results and faults --------------------------------------------------------------------------


def test_rankings_are_relative_and_the_tornado_shows_them(oscillator):
    found = lp.gradient(oscillator, of=[fun.rms("x")], until=UNTIL)
    assert found.by == ("k", "d")
    ranked = found.ranked("rms(x)")
    expected = by_complex_step(sums, POINT)[2, :2] * POINT[:2] / sums(*POINT)[2]
    assert dict(ranked) == pytest.approx(dict(zip(["k", "d"], expected, strict=True)), rel=1e-6)
    assert abs(ranked[0][1]) >= abs(ranked[1][1])
    axis = found.plot().axes[0]
    bars = [bar.get_width() for bar in axis.patches]
    assert bars == pytest.approx([value for _, value in ranked])
    assert "change of rms(x) by 1 % of the parameter, %" in axis.get_xlabel()
    forward = lp.sensitivity(oscillator, of=["x"], by=["k", "d", "x", "v"], until=UNTIL, rtol=1e-9)
    slopes = by_complex_step(sums, POINT)[0] * POINT / sums(*POINT)[0]
    assert dict(forward.ranked("x")) == pytest.approx(
        dict(zip(["k", "d", "x", "v"], slopes, strict=True)), rel=1e-6
    )
    at = dict(forward.ranked("x", at=0.0))
    assert at == pytest.approx({"k": 0.0, "d": 0.0, "x": 1.0, "v": 0.0}, abs=1e-12)
    assert len(forward.plot("x").axes[0].patches) == 4


def test_what_cannot_be_differentiated_is_named(oscillator):
    def call(of=None, to=("k",), **options):
        chosen = [fun.rms("x")] if of is None else of
        return lambda: lp.gradient(oscillator, of=chosen, by=to, until=1.0, **options)

    for kind, action, *words in (
        (OptionError, call(of=()), "at least one functional"),
        (OptionError, call(to=()), "nothing to vary"),
        (UnknownNameError, call(of=[fun.peak("y")]), "'y'"),
        (OptionError, call(of=["x"]), "each one of lumped.functionals"),
        (UnknownNameError, call(to=["y"]), "'y'"),
        (
            *(OptionError, call(of=[fun.instant("clutch", "stuck")])),
            *("instant(clutch, stuck, 0)", "Events are: none"),
        ),
        (
            *(SolverError, call(of=[fun.rms("x")], start={"x": 0.0, "v": 0.0})),
            *("rms(x)", "a root of zero"),
        ),
        (UnknownNameError, lambda: call()().ranked("rms(v)"), "'rms(v)' was not differentiated"),
        (OptionError, fun.integral, "at least one quantity"),
    ):
        refused(kind, action, *words)


def test_a_functional_that_nothing_changes_spoils_no_other():
    system = lp.assemble(
        lp.compose(
            a=Inertia(J=1.0, w=2.0),
            load=Torque(tau=1.0),
            b=Inertia(J=3.0, w=1.0),
            brake=Torque(tau=-1.0),
            connections=lambda m: (*lp.chain(m.load, m.a), *lp.chain(m.brake, m.b)),
        )
    )
    found = lp.gradient(
        system, of=[fun.final("a.w"), fun.final("b.w")], by=["a.J", "load.tau"], until=1.0
    )
    # w_a = 2 + tau t / J
    assert found.derivatives[0] == pytest.approx([-1.0, 1.0], rel=1e-12)
    assert (found.derivatives[1] == 0.0).all()
    assert "final(b.w)" in repr(found)


def test_events_that_coincide_without_touching_each_other_have_a_gradient():
    def equations(self):
        yield lp.der(self.x) == self.a
        first = where(self.x >= self.first, 1, 0)
        yield lp.der(self.y) == first + where(self.x <= self.second, 1, 0)

    system = lp.assemble(
        one(
            equations,
            a=lp.param("1/s", "rate", 1.0),
            first=lp.param("1", "border", 0.5),
            second=lp.param("1", "border", 0.5),
            x=lp.var("1", "position"),
            y=lp.var("1", "what switches"),
        )
    )
    to = ["first", "second", "a"]
    found = lp.gradient(system, of=[fun.final("y")], by=to, until=1.0)
    # y = 1 - first / a + second / a
    assert found.derivatives[0] == pytest.approx([-1.0, 1.0, 0.0], abs=1e-12)
    forward = lp.sensitivity(system, of=["y"], by=to, until=1.0)
    assert forward.derivatives[-1, 0] == pytest.approx([-1.0, 1.0, 0.0], abs=1e-12)
