"""Steps by Taylor's series: coefficients, order, dense output, events, refusals, lanes."""

import casadi as ca
import numpy as np
import pytest
import scipy.special
from linkages import four_bar
from rows import one

import lumped as lp
from lumped import functionals as fun
from lumped.code.functions import compile_series
from lumped.code.operations import operations_of
from lumped.code.words import call
from lumped.errors import OptionError
from lumped.kernel import engine
from lumped.kernel.methods import taylor
from lumped.timeloop.plants.executable import smooth_executable

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


def series(rates, x, t, order=ORDER, p=(), m=()):
    """Coefficients that the code gives, one column for each state."""
    arguments = [ca.SX.sym("x", len(x)), ca.SX.sym("p", len(p)), ca.SX.sym("t")]
    arguments.append(ca.SX.sym("m", len(m)))
    given = operations_of(ca.Function("f", arguments, [ca.vertcat(*rates(*arguments))]))
    code = compile_series(given, order, len(x))
    out = np.full((order + 1) * given.results, np.nan)
    point = [np.array(v, dtype=float) for v in (x, p, m)]
    call(code.address("series"), point[0], point[1], t, point[2], out)
    return out.reshape(order + 1, given.results)


ONE = {
    name: (getattr(ca, name), getattr(np, name))
    for name in (
        *("sin", "cos", "tan", "exp", "expm1", "log", "log1p", "sqrt"),
        *("sinh", "cosh", "tanh"),
    )
}
ONE |= {
    f"a{name}": (getattr(ca, f"a{name}"), getattr(np, f"arc{name}"))
    for name in ("sin", "cos", "tan", "sinh", "tanh")
}
ONE |= {
    "acosh": (lambda u: ca.acosh(1.5 + u), lambda u: np.arccosh(1.5 + u)),
    "erf": (ca.erf, scipy.special.erf),
}
ALIKE = {
    "square": lambda u: u**2,
    "inverse": lambda u: 1 / u,
    "twice": lambda u: u + u,
    "negative": lambda u: -u,
    "whole power": lambda u: u**5,
    "negative power": lambda u: u**-3.0,
    "broken power": lambda u: u**1.7,
    "power to it": lambda u: 1.7**u,
    "power of both": lambda u: (1 + u) ** u,
    "difference from": lambda u: 2 - u,
    "over a number": lambda u: u / 3,
    "number over it": lambda u: 3 / u,
}
ONE |= {name: (law, law) for name, law in ALIKE.items()}


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
    assert order == pytest.approx(run.order + 1, abs=0.6)
    assert (np.abs(np.log2(np.divide(told, errors))) < 1).all()


@pytest.mark.parametrize("name", ["llvm", "c", "python"])
def test_all_engines_give_the_same_bits(name):
    system = lp.assemble(pendulum())
    options = {"until": 0.3, "grid": 5, "method": "taylor", "rtol": 1e-7}
    expected = lp.simulate(system, **options)
    with engine.using(name):
        found = lp.simulate(system, **options)
    np.testing.assert_array_equal(found.table(["q", "w"]), expected.table(["q", "w"]))


# -- runs ------------------------------------------------------------------------------------------


def pendulum():
    def equations(self):
        yield lp.der(self.q) == self.w
        yield lp.der(self.w) == -9.0 * lp.ops.sin(self.q)

    q, w = lp.var("rad", "angle", start=1.0), lp.var("rad/s", "speed")
    return one(q=q, w=w, equations=equations)


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
