"""Gradients where the steps of the states say little about the derivatives; closed forms."""

import math

import numpy as np
import pytest
from checks import by_complex_step, in_all_engines
from rows import assemble_row, assemble_rows
from scipy.linalg import expm

import lumped as lp
from lumped import functionals, ops
from lumped.code.operations import operations_of
from lumped.components import Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.gradients.legs import legs_of
from lumped.gradients.spans import Carried, Span
from lumped.gradients.steps import steps_of
from lumped.kernel import engine
from lumped.numerics import rodas5p
from lumped.simulation.simulate import simulate
from lumped.timeloop.plants.many_points import CountedFunction

J, C, D, END = 1.0, 100.0, 0.1, 10.0


def oscillator(w=0.0):
    """``J w' + d w + c phi == 0``."""
    return assemble_row(body=Inertia(J=J, w=w), spring=SpringDamper(c=C, d=D), wall=Fixed())


def speed(c, d, w, end=END):
    """Speed of the oscillator at the end, for complex parameters too."""
    return (expm(np.array([[0, 1], [-c / J, -d / J]]) * end) @ np.array([0, w]))[1]


@pytest.mark.parametrize("method", ["explicit", "implicit", "auto"])
def test_a_drive_at_rest_has_the_derivatives_of_its_motion(method):
    """Steps grow without bound across rest, where a disturbance would swing."""
    found = lp.gradient(
        oscillator(), of=[functionals.final("body.w")], by=["body.w"], until=END, method=method
    )
    (right,) = by_complex_step(lambda w: speed(C, D, w), [0.0])
    assert found["final(body.w)", "body.w"] == pytest.approx(right, rel=1e-6)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_errors_are_below_what_was_asked_for(rtol):
    found = lp.gradient(
        oscillator(1.0),
        of=[functionals.final("body.w")],
        by=["spring.c", "spring.d", "body.w"],
        until=END,
        rtol=rtol,
    )
    right = by_complex_step(speed, [C, D, 1.0])
    # relative to the terms of which a derivative consists: amplitude and growth over 16 periods
    size = math.exp(-D / 2 * END) * np.array([END / 2 / math.sqrt(C), END, 1.0])
    errors = np.abs(found.derivatives[0] - right) / size
    assert (errors < 10 * rtol).all()
    assert 0 < found.errors[0] <= rtol


def test_an_integrand_faster_than_all_states_is_resolved():
    """A load that no state feels enters an integral with 30 periods in each step of the states."""

    class Ripple(lp.Component):
        """A torque that is only looked at."""

        amplitude: lp.Param = lp.param("N.m", "amplitude", 2.0)
        tau: lp.Var = lp.var("N.m", "the torque")

        def equations(self):
            yield self.tau == self.amplitude * ops.sin(300.0 * lp.time)

    system = assemble_rows(
        "body drag wall",
        body=Inertia(J=J, w=1.0),
        drag=Damper(d=0.1),
        wall=Fixed(),
        ripple=Ripple(),
    )
    of = functionals.integral("ripple.tau", "ripple.tau")
    found = lp.gradient(system, of=[of], by=["ripple.amplitude"], until=END)
    right = 2 * 2.0 * (END / 2 - math.sin(600 * END) / 1200)
    assert found.derivatives[0, 0] == pytest.approx(right, rel=1e-6)


def stiff_chain():
    return assemble_row(
        load=Torque(tau=3.0),
        a=Inertia(J=1.0),
        soft=SpringDamper(c=50.0, d=0.5),
        b=Inertia(J=0.5),
        stiff=SpringDamper(c=1e8, d=1e4),
        c=Inertia(J=0.2),
    )


def test_a_stiff_drive_agrees_with_the_exponential():
    """Implicit steps backwards, against a complex step through the matrix exponential."""
    to = {"a.J": 1.0, "b.J": 0.5, "soft.c": 50.0, "soft.d": 0.5, "load.tau": 3.0}

    def final(values):
        a, b, c, d, tau = values
        k = np.zeros((3, 3), dtype=complex)
        r = np.zeros((3, 3), dtype=complex)
        for stiffness, damping, i in ((c, d, 0), (1e8, 1e4, 1)):
            twist = np.zeros(3)
            twist[i], twist[i + 1] = -1, 1
            k += stiffness * np.outer(twist, twist)
            r += damping * np.outer(twist, twist)
        inverse = np.diag(1 / np.array([a, b, 0.2]))
        whole = np.zeros((7, 7), dtype=complex)
        whole[:3, 3:6] = np.eye(3)
        whole[3:6, :3], whole[3:6, 3:6] = -inverse @ k, -inverse @ r
        whole[3, 6] = tau / a
        start = np.zeros(7)
        start[6] = 1.0
        return (expm(whole * 2.0) @ start)[3]

    found = lp.gradient(
        stiff_chain(), of=[functionals.final("a.w")], by=list(to), until=2.0, method="implicit"
    )
    right = by_complex_step(lambda *values: final(values), list(to.values()))
    error = np.abs(found.derivatives[0] - right) / np.maximum(np.abs(right), 1e-2)
    assert error.max() < 1e-6


def test_nine_functionals_at_once_are_each_alone():
    """More columns than go side by side."""
    system = oscillator(1.0)
    of = [functionals.at_time(1.0 + k, "body.w") for k in range(9)]
    to = ["spring.c", "spring.d"]
    together = lp.gradient(system, of=of, by=to, until=END)
    for k, one in enumerate(of):
        alone = lp.gradient(system, of=[one], by=to, until=END)
        assert together.derivatives[k] == pytest.approx(alone.derivatives[0], rel=1e-6)


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_the_sweep_has_the_same_bits_in_all_engines(method):
    system = stiff_chain() if method == "implicit" else oscillator(1.0)
    run = simulate(system, until=0.3, grid=None, method=method)
    (leg,) = legs_of(run)
    integrand = "soft.tau" if method == "implicit" else "spring.tau"
    steps = steps_of(system, ((integrand,),))
    n = len(system.state_names)
    adjoint = np.random.default_rng(2).normal(size=(n + 1, 3))
    span = leg.span()

    def swept():
        function = CountedFunction(operations_of(system.rhs))
        none = np.zeros((len(run.theta), 3)), *np.zeros((2, n + 1, 3))
        back = steps.back(span, Carried(adjoint, *none))
        again = steps.replay(span, np.arange(len(span.t)) % 3 == 0)
        return *back.carried, *back[1:], again, steps.evaluate_inside(span, function, n)

    first, *others = in_all_engines(swept)
    assert first[-2] == pytest.approx(leg.states(), rel=1e-12, abs=1e-15)
    for found in others:
        for one, other in zip(first, found, strict=True):
            assert (one == other).all()


@pytest.mark.parametrize("columns", [2, 4, 6, 8])
def test_compiled_columns_have_the_bits_of_the_interpreter(columns):
    system = stiff_chain()
    run = simulate(system, until=0.3, grid=None, method="implicit")
    (leg,) = legs_of(run)
    n, k = len(system.state_names), columns // 2
    adjoint = np.random.default_rng(3).normal(size=(n, k))
    steps = steps_of(system, ())
    none = np.zeros((len(run.theta), k)), *np.zeros((2, n, k))
    slow = steps.back(leg.span(), Carried(adjoint, *none))
    for name in ("pullback", "bent"):
        steps._columns(name, columns).for_more(10**6)
    fast = steps.back(leg.span(), Carried(adjoint, *none))
    for one, other in zip((*slow.carried, *slow[1:]), (*fast.carried, *fast[1:]), strict=True):
        assert (one == other).all()


def test_a_sweep_without_results_writes_no_columns(monkeypatch):
    """Integrals alone: machine code of two columns must not be called for none."""
    system = oscillator(1.0)
    run = simulate(system, until=1.0, grid=None)
    (leg,) = legs_of(run)
    n = len(system.state_names)
    steps = steps_of(system, (("spring.tau", "spring.tau"),))
    steps._columns("pullback", 2).for_more(10**6)
    called = []
    original = engine.call

    def noting(name, *given):
        called.append(given)
        return original(name, *given)

    monkeypatch.setattr(engine, "call", noting)
    none = np.zeros((n + 1, 0))
    found = steps.back(leg.span(), Carried(none, np.zeros((len(run.theta), 0)), none, none))
    (sweep,) = (given[1] for given in called if len(given) == 4)
    assert sweep.pullback.wide_address == sweep.bent.wide_address == 0
    # integral of (c phi + d w)^2 by the states between, with Simpson's rule
    t = np.linspace(0, 1, 20001)
    y = lp.simulate(system, until=1.0, grid=t, rtol=1e-10)["spring.tau"] ** 2
    simpson = (y[0] + y[-1] + 4 * y[1::2].sum() + 2 * y[2:-1:2].sum()) * (t[1] / 3)
    assert found.parts.sum() == pytest.approx(simpson, rel=1e-6)


def test_a_counted_function_is_compiled_when_that_pays_and_keeps_its_bits():
    system = oscillator(1.0)
    function = CountedFunction(operations_of(system.rhs))
    run = simulate(system, until=1.0, grid=None)
    (leg,) = legs_of(run)
    steps, n = steps_of(system, ()), len(system.state_names)
    slow = steps.evaluate_inside(leg.span(), function, n)
    function.for_more(10**6)
    assert function._record.address
    assert (steps.evaluate_inside(leg.span(), function, n) == slow).all()


def test_an_implicit_step_without_a_solution_is_an_error():
    """``I - h gamma a`` is zero: nothing stale may be taken for the states."""
    h, a = next(
        (h, 1 / (h * rodas5p.GAMMA))
        for h in np.linspace(1.0, 2.0, 100).tolist()
        if h * rodas5p.GAMMA * (1 / (h * rodas5p.GAMMA)) == 1.0
    )

    class Growth(lp.Component):
        """``x' == p x``."""

        p: lp.Param = lp.param("1/s", "growth", a)
        x: lp.Var = lp.var("1", "what grows", state="always")

        def equations(self):
            yield lp.der(self.x) == self.p * self.x

    system = lp.assemble(Growth())
    steps = steps_of(system, ())
    ends, none = np.array([0.0, h]), np.zeros((2, 0))
    span = Span(np.array([a]), ends, np.ones((2, 1)), none, np.array([True]))
    look = CountedFunction(operations_of(system.rhs))
    for action in (
        lambda: steps.replay(span, np.array([1, 0])),
        lambda: steps.evaluate_inside(span, look, 1),
        lambda: steps.back(span, Carried(*np.ones((4, 1, 1)))),
    ):
        with pytest.raises(
            lp.errors.SolverError, match=r"Growth: .* near t = 0 s cannot be solved"
        ):
            action()


def test_too_many_steps_are_refused_in_words():
    """A stiff drive at rest would need millions of explicit steps."""
    system = assemble_row(a=Inertia(J=1.0), shaft=SpringDamper(c=1e14, d=1.0), b=Inertia(J=1.0))
    with pytest.raises(lp.errors.SolverError, match="implicit"):
        lp.gradient(
            system, of=[functionals.final("a.w")], by=["a.w"], until=10.0, method="explicit"
        )
