"""Steps by Taylor's series: coefficients, order, dense output, events, refusals, lanes."""

import casadi as ca
import numpy as np
import pytest
import scipy.special
from ensemble_runs import Alone, all_functionals, assert_same_bits, drive, ran
from linkages import four_bar
from scipy.linalg import expm

import lumped as lp
from lumped import functionals as fun
from lumped.code.functions import compiled_series
from lumped.code.operations import joined, operations_of
from lumped.code.taylor import series_of
from lumped.code.words import call
from lumped.components import Backlash, Clutch, Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.errors import OptionError
from lumped.kernel import engine
from lumped.kernel.methods import taylor
from lumped.many_runs.native_runs import NativeRuns
from lumped.timeloop.plants.executable import executable, smooth_executable

ORDER, AT = 14, 0.3


# -- coefficients ----------------------------------------------------------------------------------


def inner(t, sin=np.sin):
    """An argument between 0.2 and 0.9 whose series has no end."""
    return 0.45 + 0.2 * sin(1.3 * t) + 0.1 * t


def coefficients_of(function, t, order):
    """Taylor coefficients by Cauchy's integral over a circle."""
    n, r = 256, 0.4
    z = t + r * np.exp(2j * np.pi * np.arange(n) / n)
    return (np.fft.fft(function(z)) / n / r ** np.arange(n))[:order].real


def series(rates, x, t, order=ORDER, p=(), m=(), integrands=None):
    """Coefficients that the code gives, one column for each state and integral."""
    arguments = [ca.SX.sym("x", len(x)), ca.SX.sym("p", len(p)), ca.SX.sym("t")]
    arguments.append(ca.SX.sym("m", len(m)))

    def operations(made):
        results = made(*arguments)
        return operations_of(ca.Function("f", arguments, [ca.vertcat(*results)]))

    given = operations(rates)
    if integrands is not None:
        given = joined(given, operations(integrands))
    code = compiled_series(given, order, len(x))
    out = np.full((order + 1) * given.results, np.nan)
    point = [np.array(v, dtype=float) for v in (x, p, m)]
    call(code.address("series"), point[0], point[1], t, point[2], out)
    return out.reshape(order + 1, given.results)


ONE = {
    "sin": (ca.sin, np.sin),
    "cos": (ca.cos, np.cos),
    "tan": (ca.tan, np.tan),
    "exp": (ca.exp, np.exp),
    "expm1": (ca.expm1, np.expm1),
    "log": (ca.log, np.log),
    "log1p": (ca.log1p, np.log1p),
    "sqrt": (ca.sqrt, np.sqrt),
    "square": (lambda u: u**2, lambda u: u**2),
    "inverse": (lambda u: 1 / u, lambda u: 1 / u),
    "twice": (lambda u: u + u, lambda u: 2 * u),
    "negative": (lambda u: -u, lambda u: -u),
    "asin": (ca.asin, np.arcsin),
    "acos": (ca.acos, np.arccos),
    "atan": (ca.atan, np.arctan),
    "sinh": (ca.sinh, np.sinh),
    "cosh": (ca.cosh, np.cosh),
    "tanh": (ca.tanh, np.tanh),
    "asinh": (ca.asinh, np.arcsinh),
    "acosh": (lambda u: ca.acosh(1.5 + u), lambda u: np.arccosh(1.5 + u)),
    "atanh": (ca.atanh, np.arctanh),
    "erf": (ca.erf, scipy.special.erf),
    "whole power": (lambda u: u**5, lambda u: u**5),
    "negative power": (lambda u: u**-3, lambda u: u**-3.0),
    "broken power": (lambda u: u**1.7, lambda u: u**1.7),
    "power to it": (lambda u: 1.7**u, lambda u: 1.7**u),
    "power of both": (lambda u: (1 + u) ** u, lambda u: (1 + u) ** u),
    "difference from": (lambda u: 2 - u, lambda u: 2 - u),
    "over a number": (lambda u: u / 3, lambda u: u / 3),
    "number over it": (lambda u: 3 / u, lambda u: 3 / u),
}


@pytest.mark.parametrize("name", ONE)
def test_coefficients_of_a_function_of_time_are_those_of_cauchys_integral(name):
    symbolic, numeric = ONE[name]
    found = series(lambda x, p, t, m: [symbolic(inner(t, ca.sin))], [1.0], AT)[:, 0]
    expected = coefficients_of(lambda z: numeric(inner(z)), AT, ORDER)
    assert found[0] == 1.0
    # the error of the integral grows as the circle's radius to the order falls
    tolerance = 1e-13 * 0.4 ** -np.arange(ORDER) * max(1.0, np.abs(expected).max())
    error = np.abs(found[1:] * np.arange(1, ORDER + 1) - expected)
    assert (error <= tolerance).all()


TWO = {
    "product": (lambda u, v: u * v, lambda u, v: u * v),
    "quotient": (lambda u, v: u / v, lambda u, v: u / v),
    "sum": (lambda u, v: u + v, lambda u, v: u + v),
    "difference": (lambda u, v: u - v, lambda u, v: u - v),
    "angle": (ca.atan2, lambda u, v: np.arctan(u / v)),
    "hypotenuse": (ca.hypot, lambda u, v: np.sqrt(u**2 + v**2)),
}


@pytest.mark.parametrize("name", TWO)
@pytest.mark.parametrize("still", [None, 0, 1])
def test_coefficients_of_functions_of_two_arguments(name, still):
    """Both vary, or one of them is a parameter."""
    symbolic, numeric = TWO[name]

    def both(z, exp, sin, fixed):
        found = [inner(z, sin), 0.5 + exp(-0.8 * z)]
        if still is not None:
            found[still] = fixed
        return found

    def rates(x, p, t, m):
        return [symbolic(*both(t, ca.exp, ca.sin, p[0]))]

    found = series(rates, [0.0], AT, p=[0.7])[:, 0]
    expected = coefficients_of(lambda z: numeric(*both(z, np.exp, np.sin, 0.7 + 0 * z)), AT, ORDER)
    tolerance = 1e-13 * 0.4 ** -np.arange(ORDER) * max(1.0, np.abs(expected).max())
    assert (np.abs(found[1:] * np.arange(1, ORDER + 1) - expected) <= tolerance).all()


def test_coefficients_of_solutions_in_closed_form():
    """``1 / (1 + t)``, a sine and cosine, ``tan``, and an integral beside them."""
    found = series(
        lambda x, p, t, m: [-(x[0] ** 2), x[2], -x[1], 1 + x[3] ** 2],
        [1.0, 0.0, 1.0, 0.0],
        0.0,
        order=9,
        integrands=lambda x, p, t, m: [x[1] * x[2]],
    )
    np.testing.assert_allclose(found[:, 0], (-1.0) ** np.arange(10), rtol=1e-14)
    factorial = scipy.special.factorial(np.arange(10))
    sine = np.array([0, 1, 0, -1] * 3)[:10] / factorial
    np.testing.assert_allclose(found[:, 1], sine, atol=1e-16)
    np.testing.assert_allclose(found[1::2, 3], [1, 1 / 3, 2 / 15, 17 / 315, 62 / 2835], rtol=1e-14)
    half = -0.25 * np.array([2.0**k * np.cos(k * np.pi / 2) for k in range(10)]) / factorial
    half[0] = 0.0  # sin^2 / 2 is (1 - cos 2 t) / 4
    np.testing.assert_allclose(found[:, 4], half, atol=1e-16)


def test_what_depends_on_parameters_and_settings_alone_needs_no_recurrence():
    """Any operation on them, and a choice that they make."""

    def rates(x, p, t, m):
        step = ca.floor(p[0]) + ca.fmod(p[1], 2.0) + ca.fabs(p[1]) + (p[0] < p[1])
        return [step * x[0], ca.if_else(m[0] > 0, x[1], ca.sqrt(x[0] - 5)), p[0] * p[1]]

    found = series(rates, [1.0, 1.0, 0.0], 0.0, order=3, p=[2.5, 3.5], m=[1.0])
    rate = 2 + 1.5 + 3.5 + 1
    np.testing.assert_allclose(found[:, 0], [1, rate, rate**2 / 2, rate**3 / 6])
    np.testing.assert_allclose(found[:, 1], [1, 1, 1 / 2, 1 / 6])
    np.testing.assert_allclose(found[:, 2], [0, 8.75, 0, 0])


def test_many_operations_are_written_in_parts():
    """A chain of masses with more operations than one function takes, and products in it."""
    n = 300
    x0 = 1 + 0.1 * np.sin(np.arange(n))

    def rates(x, p, t, m):
        return [-x[i] * (x[i] - x[i - 1]) if i else -x[0] for i in range(n)]

    found = series(rates, x0, 0.0, order=30)  # more than fits on the stack
    symbolic = [ca.SX.sym("x", n), ca.SX.sym("p", 0), ca.SX.sym("t"), ca.SX.sym("m", 0)]
    f = ca.vertcat(*rates(*symbolic))
    expected, derivative = [x0], f
    for k in range(1, 4):
        value = ca.Function("f", symbolic[:1], [derivative])(x0)
        expected.append(np.array(value).ravel() / scipy.special.factorial(k))
        derivative = ca.jtimes(derivative, symbolic[0], f)
    np.testing.assert_allclose(found[:4], expected, rtol=1e-12)


# -- steps -----------------------------------------------------------------------------------------


def made(rates, x, rtol=1e-9, t=0.0):
    """A run of a few states that stands somewhere, ready for steps by series, and its code."""
    n = len(x)
    arguments = [ca.SX.sym("x", n), ca.SX.sym("p", 0), ca.SX.sym("t"), ca.SX.sym("m", 0)]
    function = ca.Function("rates", arguments, [ca.vertcat(*rates(arguments[0], arguments[2]))])
    code = smooth_executable(arguments, {"rates": function}, lambda: function, 0)
    code.compile()
    run = code.new_run(np.zeros(0), t, np.array(x, dtype=float), np.zeros(0))
    run.rtol, run.atol[:] = rtol, 1e-3 * rtol
    code.taylor.add_to(run, rtol)
    return run, code


def stepped(run, h):
    """The error of a step that is told, and states after it."""
    taylor.expand(run)
    run.t_new = run.t + h
    return taylor.step(run, h), run.new.copy()


def test_the_error_of_a_step_falls_with_its_order_and_is_told():
    """``x' = -x^2``, whose solution is ``x / (1 + x t)``."""
    errors, told = [], []
    lengths = np.array([0.3, 0.15])
    for h in lengths:
        run, _code = made(lambda x, t: [-(x[0] ** 2)], [1.0], rtol=1e-4)
        error, new = stepped(run, h)
        errors.append(abs(new[0] - 1 / (1 + h)))
        told.append(error * (run.atol[0] + run.rtol))
    order = np.log2(errors[0] / errors[1])
    print(f"order {run.order}, error falls with {order:.2f}, told {np.divide(told, errors)}")
    assert order == pytest.approx(run.order + 1, abs=0.6)
    assert (np.abs(np.log2(np.divide(told, errors))) < 1).all()


def test_values_inside_a_step_are_as_accurate_as_its_end():
    run, _code = made(lambda x, t: [x[1], -x[0]], [0.0, 1.0], rtol=1e-9)
    taylor.expand(run)
    stepped(run, run.h)
    assert 2.5 < run.h < 5.0  # about four radians where no state is near zero
    out = np.zeros(2)
    for part in np.linspace(0, 1, 11):
        taylor.interpolate(run, part, out)
        exact = np.sin(part * run.h), np.cos(part * run.h)
        np.testing.assert_allclose(out, exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["llvm", "c", "python"])
def test_all_engines_give_the_same_bits(name):
    system = lp.assemble(pendulum())
    options = {"until": 0.3, "grid": 5, "method": "taylor", "rtol": 1e-7}
    expected = lp.simulate(system, **options)
    with engine.using(name):
        found = lp.simulate(system, **options)
    np.testing.assert_array_equal(found.table(["q", "w"]), expected.table(["q", "w"]))


# -- runs ------------------------------------------------------------------------------------------


def one(**attributes):
    """A model that is one component with these equations."""
    equations = attributes.pop("equations")
    kind = type("Part", (lp.Component,), {"__doc__": "Under test.", **attributes})
    kind.equations = equations
    return kind()


def pendulum():
    def equations(self):
        yield lp.der(self.q) == self.w
        yield lp.der(self.w) == -9.0 * lp.ops.sin(self.q)

    q, w = lp.var("rad", "angle", start=1.0), lp.var("rad/s", "speed")
    return one(q=q, w=w, equations=equations)


INERTIAS, STIFFNESSES, DELAY, TORQUE = (0.5, 1.2, 3.0), (4e4, 2.5e4), 1e-4, 100.0


def three_masses(**load):
    shafts = [SpringDamper(c=c, d=DELAY * c) for c in STIFFNESSES]
    return lp.compose(
        motor=Torque(tau=TORQUE),
        mass=[Inertia(J=J) for J in INERTIAS],
        shaft=shafts,
        **load,
        connections=lambda m: lp.chain(
            m.motor, m.mass[0], m.shaft[0], m.mass[1], m.shaft[1], m.mass[2]
        ),
    )


def speeds(times):
    """Speeds of three masses by the exponential of their matrix."""
    matrix = np.zeros((6, 6))
    matrix[0, 2:4] = matrix[1, 3:5] = 1.0, -1.0
    for k, c in enumerate(STIFFNESSES):
        pull = np.zeros(6)
        pull[k], pull[2 + k], pull[3 + k] = c, DELAY * c, -DELAY * c
        matrix[2 + k] -= pull / INERTIAS[k]
        matrix[3 + k] += pull / INERTIAS[k + 1]
    matrix[2, 5] = TORQUE / INERTIAS[0]
    return np.array([expm(t * matrix)[2:5, 5] for t in times])


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-9, 1e-12])
def test_three_masses_at_output_times_inside_long_steps(rtol):
    run = lp.simulate(lp.assemble(three_masses()), until=0.5, grid=200, rtol=rtol, method="taylor")
    exact = speeds(run.t)
    error = np.abs(run.table([f"mass[{k}].w" for k in range(3)]) - exact).max() / exact.max()
    print(f"rtol {rtol:g}: {run.statistics.steps} steps, error {error / rtol:.2g} rtol")
    assert run.statistics.method == "taylor"
    assert error < max(3 * rtol, 1e-13)


def test_a_clutch_sticks_when_both_speeds_are_one():
    model = lp.compose(
        a=Inertia(J=1.0, w=30.0),
        clutch=Clutch(f_max=9.0, characteristic=((0.0, 1.0),), peak=1.0, u=1.0),
        b=Inertia(J=1.5, w=0.0),
        connections=lambda m: lp.chain(m.a, m.clutch, m.b),
    )
    run = lp.simulate(lp.assemble(model), until=5.0, method="taylor", rtol=1e-9)
    instant = 30.0 / (9.0 / 1.0 + 9.0 / 1.5)
    assert [e.time for e in run.events if e.after == "stuck"] == [pytest.approx(instant, rel=1e-13)]
    assert run["b.w"][-1] == pytest.approx(12.0, rel=1e-13)


def test_instants_between_the_pieces_of_an_oscillation():
    """A spring of one stiffness to the left and four times that to the right."""

    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == lp.ops.where(self.x >= 0, -4 * self.x, -self.x)

    x, v = lp.var("m", "position", start=1.0), lp.var("m/s", "velocity")
    run = lp.simulate(
        lp.assemble(one(x=x, v=v, equations=equations)), until=20.0, rtol=1e-10, method="taylor"
    )
    halves = np.cumsum([np.pi / 4, *np.tile([np.pi, np.pi / 2], 10)])
    received = [event.time for event in run.events]
    np.testing.assert_allclose(received, halves[halves < 20], rtol=0, atol=1e-9)


def test_a_short_dip_before_another_event_in_a_long_step():
    """A body turns back just after it leaves; another condition changes a little later."""

    def equations(self):
        t = lp.time
        yield lp.der(self.x) == 1e-3 - 0.2 * t + t**2 + 0 * self.y
        yield lp.der(self.y) == 1.0
        yield lp.der(self.n) == lp.ops.where(self.x >= -5e-6, 0.0, 1.0)
        yield lp.der(self.k) == lp.ops.where(self.y >= 0.25, 1.0, 0.0)

    names = {name: lp.var("1", "counted", start=0.0) for name in "xynk"}
    run = lp.simulate(
        lp.assemble(one(**names, equations=equations)), until=1.0, rtol=1e-9, method="taylor"
    )
    x = np.poly1d([1 / 3, -0.1, 1e-3, 0.0])
    crossings = sorted(r.real for r in (x + 5e-6).roots if abs(r.imag) < 1e-9 and 0 < r.real < 1)
    expected = sorted([*crossings, 0.25])
    np.testing.assert_allclose([e.time for e in run.events], expected, atol=1e-9)


def test_backlash_is_crossed_in_the_time_of_free_flight():
    model = lp.compose(
        a=Inertia(J=1.0, w=2.0),
        play=Backlash(b=0.1),
        b=Inertia(J=1.0, w=0.0),
        connections=lambda m: lp.chain(m.a, m.play, m.b),
    )
    runs = [
        lp.simulate(lp.assemble(model), until=0.2, method=m, rtol=1e-9)
        for m in ("taylor", "explicit")
    ]
    events = [[e.time for e in run.events] for run in runs]
    assert events[0]
    np.testing.assert_allclose(*events, rtol=1e-11)


def test_a_root_at_zero_is_passed_in_another_way():
    """``v' = -x^1.5`` has no series at ``x = 0``; there ``v^2 / 2 + x^2.5 / 2.5`` stays."""

    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == -(self.x**1.5)

    x, v = lp.var("m", "position", start=0.0), lp.var("m/s", "velocity", start=1.0)
    system = lp.assemble(one(x=x, v=v, equations=equations))
    run = lp.simulate(system, until=1.0, method="taylor", rtol=1e-9)
    np.testing.assert_allclose(run["v"] ** 2 / 2 + run["x"] ** 2.5 / 2.5, 0.5, rtol=1e-8)
    of = [fun.final("x"), fun.peak("v"), fun.rms("v")]
    given = {"until": 1.0, "rtol": 1e-9, "method": "taylor"}
    lanes, alone = (
        ran(system, [], np.zeros((9, 0)), {str(f): f for f in of}, kind=kind, **given)
        for kind in (NativeRuns, Alone)
    )
    assert_same_bits(lanes, alone)
    assert lanes.values[0, 0] == pytest.approx(run["x"][-1], rel=1e-15)


def test_a_switch_that_no_coefficient_shows_is_not_jumped_over():
    """All coefficients of ``1 + tanh(1000 (t - 1))`` at 0 are rounded to zero; it holds after 1."""

    def equations(self):
        yield lp.der(self.x) == 1 + lp.ops.tanh(1e3 * (lp.time - 1.0))

    system = lp.assemble(one(x=lp.var("m", "position", start=0.0), equations=equations))
    run = lp.simulate(system, until=2.0, method="taylor", rtol=1e-8)
    print(run.statistics)
    assert run["x"][-1] == pytest.approx(2.0, rel=1e-8)


def test_refusals_name_what_has_no_series_and_what_to_do():
    arguments = [ca.SX.sym("x", 1), ca.SX.sym("p", 0), ca.SX.sym("t"), ca.SX.sym("m", 0)]
    refused = {"floor": ca.floor, "fabs": ca.fabs, "a comparison": lambda x: x < 1}
    refused["a choice by the value"] = lambda x: ca.if_else(x, 2.0, 0.0)
    for name, operation in refused.items():
        function = ca.Function("rates", arguments, [operation(arguments[0])])
        code = smooth_executable(arguments, {"rates": function}, lambda f=function: f, 0)
        with pytest.raises(OptionError, match=f"contain {name} of .* take method='steps'"):
            code.taylor.order(1e-6)
    system = lp.assemble(four_bar(w=10.0))
    options = {"until": 0.1, "method": "taylor"}
    with pytest.raises(OptionError, match=r"closed linkage.* take method='steps'"):
        lp.simulate(system, **options)
    with pytest.raises(OptionError, match=r"closed linkage.* take method='steps'"):
        lp.ensemble(system, over={"linkage.r": [0.9, 1.0]}, of=[fun.final("crank.w")], **options)


def stiff_shaft():
    """A spring of a millisecond, damped, between bodies that move in seconds."""
    return lp.compose(
        motor=Torque(tau=10 * lp.ops.sin(2 * lp.time)),
        rotor=Inertia(J=1.0),
        shaft=SpringDamper(c=1e6, d=2e3),
        load=Inertia(J=1.0),
        slip=Damper(d=1.0),
        ground=Fixed(),
        connections=lambda m: lp.chain(m.motor, m.rotor, m.shaft, m.load, m.slip, m.ground),
    )


def test_series_give_way_where_stability_holds_their_steps():
    """The two bodies turn as one: ``2 w' + w == 10 sin(2 t)``, but for a twist of 1e-5 rad."""
    system = lp.assemble(stiff_shaft())
    run = lp.simulate(system, until=20.0, method="taylor", rtol=1e-6)
    t = run.t
    rigid = 10 / 17 * (np.sin(2 * t) - 4 * np.cos(2 * t) + 4 * np.exp(-t / 2))
    error = np.abs(run["load.w"] - rigid).max() / np.abs(rigid).max()
    print(f"{run.statistics.method}, {run.statistics.steps} steps, error {error:.1e}")
    assert run.statistics.method == "taylor then implicit"
    assert "series until" in run.statistics.why
    assert run.statistics.steps < 1000  # by series alone 11 000
    assert error < 1e-4


W, SWING, PUSH = 10.0, 3.0, 5.0


def driven_spring():
    """An undamped mass on a spring under a swinging torque."""
    return lp.compose(
        ground=Fixed(),
        spring=SpringDamper(c=W**2, d=0.0),
        body=Inertia(J=1.0, w=1.0),
        motor=Torque(tau=PUSH * lp.ops.sin(SWING * lp.time)),
        connections=lambda m: lp.chain(m.ground, m.spring, m.body, m.motor),
    )


def test_series_stay_where_longer_steps_would_not_be_accurate():
    run = lp.simulate(lp.assemble(driven_spring()), until=400.0, method="taylor", rtol=1e-6)
    assert run.statistics.steps > 600  # after 500 a trial is due in any case
    assert run.statistics.method == "taylor"


def test_a_long_run_goes_on_by_series():
    runs = [
        lp.simulate(lp.assemble(driven_spring()), until=3000.0, grid=300, rtol=1e-10, method=method)
        for method in ("auto", "auto", "steps")
    ]
    twice, t = runs[:2], runs[0].t
    size = PUSH / (W**2 - SWING**2)
    exact = size * np.sin(SWING * t) + (1 - size * SWING) / W * np.sin(W * t)
    errors = [np.abs(run["spring.phi_rel"] - exact).max() for run in runs]
    print([(r.statistics.method, r.statistics.steps) for r in runs], errors)
    assert [run.statistics.method for run in runs] == [*["explicit then taylor"] * 2, "explicit"]
    assert 50_000 < runs[0].statistics.steps < 0.7 * runs[2].statistics.steps
    np.testing.assert_array_equal(*(run["spring.phi_rel"] for run in twice))
    assert max(errors) < 1e-7 * np.abs(exact).max()


# -- many runs -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("kind", "seed"), [("hybrid", 704), ("hybrid", 709), ("smooth", 2101), ("smooth", 2105)]
)
def test_lanes_give_the_bits_of_single_runs(kind, seed):
    system, until, varied, points = drive(kind, seed)
    of = all_functionals(system, until)
    options = {"method": "taylor", "rtol": 1e-7}
    lanes = ran(system, varied, points, of, until, **options)
    assert_same_bits(lanes, ran(system, varied, points, of, until, Alone, **options))
    close = ran(system, varied, points, of, until, method="explicit", rtol=1e-10)
    for label, a, b in zip(of, lanes.values.T, close.values.T, strict=True):
        if label.startswith(("final", "peak", "rms")):
            assert np.nanmax(np.abs(a - b)) < 1e-5 * (1e-3 + np.nanmax(np.abs(b))), label


def test_functionals_of_long_steps_against_those_of_many_points():
    system, times = lp.assemble(three_masses()), np.linspace(0, 0.5, 20001)
    of = {
        "peak": fun.peak("shaft[0].tau"),
        "rms": fun.rms("shaft[1].tau"),
        "mean": fun.mean("mass[1].w"),
        "part": fun.mean("mass[1].w", between=(0.1003, 0.3001)),
    }
    over = {"mass[0].J": [0.5, 0.51]}
    found = lp.ensemble(system, over=over, until=0.5, of=of, method="taylor", rtol=1e-9)
    run = lp.simulate(system, until=0.5, grid=times, method="explicit", rtol=1e-12)
    shafts = run.table(["shaft[0].tau", "shaft[1].tau"])
    expected = [
        np.abs(shafts[:, 0]).max(),
        np.sqrt(np.trapezoid(shafts[:, 1] ** 2, times) / 0.5),
        np.trapezoid(run["mass[1].w"], times) / 0.5,
    ]
    np.testing.assert_allclose(found.values[0, :3], expected, rtol=2e-6)
    inside = (times >= 0.1003 - 1e-12) & (times <= 0.3001 + 1e-12)
    part = np.trapezoid(run["mass[1].w"][inside], times[inside]) / 0.1998
    assert found.values[0, 3] == pytest.approx(part, rel=2e-6)


def test_integrals_have_series_where_those_are_as_good_as_the_steps():
    """Beside a linear system only linear quantities; beside others all."""
    linear, other = lp.assemble(three_masses()), lp.assemble(pendulum())
    for system, is_kept in ((linear, False), (other, True)):
        x = system.inputs[0]
        square = operations_of(ca.Function("q", system.inputs, [x[0] ** 2]))
        plain = operations_of(ca.Function("q", system.inputs, [3 * x[0]]))
        own = executable(system).taylor
        assert (own.with_integrals(square) is not own) == is_kept
        assert own.with_integrals(plain) is not own
        assert series_of(plain).is_linear
        assert not series_of(square).is_linear
