"""Derivatives where changes coincide, are only touched, or fall on the instant looked at."""

from functools import partial

import numpy as np
import pytest
from checks import by_complex_step, refused
from rows import assemble_one, in_a_row

import lumped as lp
from lumped import functionals as fun
from lumped.components import Clutch, Inertia
from lumped.errors import OptionError, SolverError
from lumped.ops import sin, where


class Ball(lp.Component):
    """A ball that bounces."""

    h0: lp.Param = lp.param("m", "height at the start", 1.0)
    e: lp.Param = lp.param("1", "restitution", 0.8)
    g: lp.Param = lp.param("m/s2", "gravity", 10.0)
    h: lp.Var = lp.var("m", "height", start=h0, state="always")
    v: lp.Var = lp.var("m/s", "velocity", state="always")
    f: lp.Var = lp.var("m/s2", "reaction, downwards")

    def equations(self):
        yield lp.der(self.h) == self.v
        yield lp.der(self.v) == -self.g - self.f
        yield lp.hold(self.f, self.v, gap=self.h, restitution=self.e)


class Brake(lp.Component):
    """A flywheel that friction stops."""

    J: lp.Param = lp.param("kg.m2", "inertia", 2.0)
    M: lp.Param = lp.param("N.m", "friction", 4.0)
    w0: lp.Param = lp.param("rad/s", "speed at the start", 10.0)
    w: lp.Var = lp.var("rad/s", "speed", start=w0, state="always")
    phi: lp.Var = lp.var("rad", "angle", state="always")
    tau: lp.Var = lp.var("N.m", "torque")

    def equations(self):
        yield lp.der(self.phi) == self.w
        yield self.J * lp.der(self.w) == -self.tau
        M = self.M
        yield lp.hold(self.tau, self.w, forward=M, backward=-M, upper=M, lower=-M)


def both(system, of, to, until, **options):
    """Derivatives backwards, after a look that those forwards agree."""
    back = lp.gradient(system, of=of, by=to, until=until, **options)
    forward = lp.sensitivity(system, of=of, by=to, until=until, **options)
    assert forward.values == pytest.approx(back.values, rel=1e-9, abs=1e-12)
    size = np.abs(back.derivatives).max(axis=1)[:, None]
    assert (np.abs(forward.slopes - back.derivatives) <= 1e-8 * size).all()
    return back


def bounced(h, e, g, until):
    """Height after one bounce and before the second."""
    fall = np.sqrt(2 * h / g)
    s = until - fall
    return e * g * fall * s - g * s**2 / 2


def test_two_balls_that_hit_at_once_do_not_know_of_each_other():
    system = lp.assemble(lp.compose(a=Ball(), b=Ball(e=0.5)))
    of = [fun.final("a.h"), fun.final("b.h"), fun.instant("b"), fun.loss("a", number=0)]
    # an energy of one of several changes at one instant is refused by name
    refused(SolverError, lambda: both(system, of, ["a.e"], 0.8), "loss(a, 0)", "a, b")
    found = both(system, of[:3], ["a.h0", "a.e", "b.h0", "b.e", "b.g"], 0.8)
    of_a = by_complex_step(lambda h, e: bounced(h, e, 10, 0.8), [1, 0.8])
    of_b = by_complex_step(lambda h, e, g: bounced(h, e, g, 0.8), [1, 0.5, 10])
    assert found.derivatives[0] == pytest.approx([*of_a, 0, 0, 0], rel=1e-9)
    assert found.derivatives[1] == pytest.approx([0, 0, *of_b], rel=1e-9)
    fall = np.sqrt(2 / 10)
    assert found.derivatives[2] == pytest.approx([0, 0, fall / 2, 0, -fall / 20], abs=1e-12)


def test_a_stop_at_the_instant_at_which_another_part_is_switched():
    t = lp.param("s", "when it is switched", 5.0)
    pushed = one_pushed(t)
    found = both(pushed, [fun.final("a.phi"), fun.final("x")], ["t", "a.M"], 7.0)
    # x = 7 - t
    assert found.derivatives == pytest.approx(np.array([[0.0, -6.25], [-1.0, 0.0]]), abs=1e-9)


def one_pushed(t):
    class Both(lp.Component):
        """A brake, and something else that a switch moves."""

        a: Brake = Brake()
        x: lp.Var = lp.var("m", "position", state="always")

        def equations(self):
            yield lp.der(self.x) == where(lp.time >= self.t, 1, 0)

    Both.t = t
    return lp.assemble(type("Pushed", (Both,), {"t": t, "__doc__": "Both."})())


def test_an_impact_on_the_end_of_the_run_has_one_sided_derivatives_only():
    system = lp.assemble(lp.compose(a=Ball(h0=1.25)))  # falls for half a second
    of, to = [fun.final("a.v")], ["a.h0"]
    for call in (lp.gradient, lp.sensitivity):
        refused(SolverError, lambda c=call: c(system, of=of, by=to, until=0.5), "t = 0.5 s")
    height = lp.gradient(system, of=[fun.at_time(0.3, "a.h")], by=to, until=0.5)
    assert height.derivatives[0, 0] == pytest.approx(1.0)


def test_a_value_at_the_instant_of_an_impact_has_one_sided_derivatives_only():
    system = lp.assemble(lp.compose(a=Ball(h0=1.25)))
    of = [fun.at_time(0.5, "a.v")]
    options = {"of": of, "by": ["a.h0"], "until": 0.8}
    for call in (lp.gradient, lp.sensitivity):
        refused(SolverError, lambda c=call: c(system, **options), "t = 0.5 s", "a changes")
    # restitution does not move the first impact: v = e g t after it
    found = both(system, of, ["a.e"], 0.8)
    assert found.derivatives[0, 0] == pytest.approx(5.0)
    # a greater height: it comes later, v = -g t still; a smaller: v = e g t' - g (t - t')
    slope = 0.5 * np.sqrt(2 / (1.25 * 10))
    for side, expected in (("right", 0.0), ("left", (0.8 * 10 + 10) * slope)):
        one_side = lp.sensitivity(system, of=of, by=["a.h0"], until=0.8, side=side)
        assert one_side.slopes[0, 0] == pytest.approx(expected, abs=1e-9)


def touched(rate):
    """A vibration of amplitude a that touches the border b = 1, and what depends on it."""

    def equations(self):
        yield lp.der(self.x) == self.v
        yield lp.der(self.v) == -4 * self.x
        yield lp.der(self.y) == rate(self)

    return assemble_one(
        equations,
        a=(a := lp.param("m", "amplitude", 1.0)),
        b=lp.param("m", "border", 1.0),
        x=lp.var("m", "position", state="always"),
        v=lp.var("m/s", "velocity", start=2 * a, state="always"),
        y=lp.var("1", "sum", state="always"),
    )


def test_a_border_that_is_touched_matters_only_where_rates_jump():
    jumps = touched(lambda self: where(self.x > self.b, 1, 0))
    wanted = {"of": [fun.final("y")], "by": ["a"], "until": 2.0}
    for call in (lp.gradient, lp.sensitivity):
        refused(SolverError, lambda c=call: c(jumps, **wanted), "t = 0.785", "One only touches")
    bends = touched(lambda self: where(self.x > self.b, self.x - self.b, 0))
    # what is beyond the border for a moment, by rounding, is the root of that
    for call in (lp.gradient, lp.sensitivity):
        found = call(bends, of=[fun.final("y")], by=["a", "b"], until=2.0)
        assert abs(found["final(y)", "a"]) < 1e-4
        assert abs(found["final(y)", "b"]) < 1e-4
    found = both(bends, [fun.final("x")], ["a", "b"], 2.0)
    assert found.derivatives[0] == pytest.approx([np.sin(4.0), 0.0], rel=1e-8)
    clear = touched(lambda self: where(self.x > 1.01 * self.b, 1, 0))
    found = both(clear, [fun.final("y")], ["a", "b"], 2.0)
    assert (found.derivatives == 0.0).all()


def test_the_end_of_the_run_can_be_varied():
    def equations(self):
        yield lp.der(self.x) == -self.k * self.x

    system = assemble_one(
        equations,
        k=lp.param("1/s", "rate", 0.7),
        x=lp.var("1", "what decays", start=2.0, state="always"),
    )
    T, k = 1.5, 0.7
    x = 2 * np.exp(-k * T)
    of = [
        fun.final("x"),
        fun.integral("x"),
        fun.mean("x"),
        fun.rms("x"),
        fun.lowest("x"),
        fun.highest("x"),
        fun.at_time(0.5, "x"),
        fun.integral("x", between=(0.2, 1.0)),
    ]
    found = both(system, of, ["until", "k"], T)
    mean, square = (2 - x) / (k * T), (4 - x**2) / (2 * k * T)
    rms = np.sqrt(square)
    expected = [-k * x, x, (x - mean) / T, (x**2 - square) / (2 * rms * T), -k * x, 0.0, 0.0, 0.0]
    assert found["final(x)", "until"] == pytest.approx(-k * x)
    assert found.derivatives[:, 0] == pytest.approx(expected, rel=1e-9)


def test_steps_do_not_hide_what_is_fast_beside_what_is_slow():
    # the only state turns evenly: steps as long as the run
    def equations(self):
        yield lp.der(self.phi) == self.w
        yield self.y == (1 + self.a * self.phi) * sin(37.0 * self.phi)

    system = assemble_one(
        equations,
        w=lp.param("rad/s", "speed", 1.0),
        a=lp.param("1", "growth", 0.03),
        phi=lp.var("rad", "angle", state="always"),
        y=lp.var("1", "what swings"),
    )
    T = 6.0
    found = both(system, [fun.rms("y"), fun.highest("y"), fun.lowest("y")], ["a"], T)
    t = np.linspace(0, T, 2_000_001)
    y, slope = (1 + 0.03 * t) * np.sin(37 * t), t * np.sin(37 * t)
    weights = np.full(len(t), t[1])
    weights[1:-1:2] *= 4 / 3
    weights[2:-1:2] *= 2 / 3
    weights[[0, -1]] /= 3
    rms = np.sqrt(weights @ y**2 / T)
    assert found.values == pytest.approx([rms, y.max(), y.min()], rel=1e-8)
    expected = [weights @ (y * slope) / T / rms, slope[y.argmax()], slope[y.argmin()]]
    assert found.derivatives[:, 0] == pytest.approx(expected, rel=1e-6)
    assert found.run.steps < 30


def test_a_start_value_that_others_determine_is_refused():
    def equations(self):
        yield self.top == self.bottom + self.length
        yield lp.der(self.bottom) == -self.bottom

    system = assemble_one(
        equations,
        length=lp.param("m", "length", 1.0),
        bottom=lp.var("m", "lower end", state="always"),
        top=lp.var("m", "upper end"),
    )
    run = {"of": [fun.final("bottom")], "until": 1.0, "start": {"top": 3.0}}
    found = lp.gradient(system, by=["top", "length"], **run)
    assert found.derivatives[0] == pytest.approx([np.exp(-1), -np.exp(-1)])
    refused(OptionError, lambda: lp.gradient(system, by=["bottom"], **run), "bottom")


def test_a_start_value_and_the_parameter_that_it_is_both_count():
    system = lp.assemble(lp.compose(a=Ball(h0=2.0)))
    found = both(system, [fun.at_time(0.1, "a.h")], ["a.h0", "a.h"], 0.2)
    assert found.derivatives[0] == pytest.approx([1.0, 1.0])


def test_functionals_that_ask_for_what_is_not_there_are_refused():
    system = lp.assemble(lp.compose(a=Ball()))

    for of, text in (
        (fun.at_time(2.0, "a.h"), "the run ends at 0.8 s"),
        (fun.loss("a", number=3), "there are 1 impacts of a"),
        (fun.at_event("a.v", "a", number=4), "there are 1 such events"),
        (fun.peak("a.h", between=(0.1, 3.0)), "ends at 0.8 s"),
    ):
        options = {"of": [of], "by": ["a.e"], "until": 0.8}
        refused(OptionError, lambda o=options: lp.gradient(system, **o), text)
    for wrong in (
        lambda: fun.at_time(-1.0, "a.h"),
        lambda: fun.mean("a.h", between=(1.0, 1.0)),
        lambda: fun.at_event("a.v", "a", side="here"),
    ):
        refused(OptionError, wrong)


def test_changes_that_coincide_but_for_rounding_coincide():
    # 3 * 0.1 and 0.3 differ by rounding: one brake stops at 3 * 0.1 / 0.7, the other at 0.3 / 0.7
    parts = {"a": Brake(J=3 * 0.1, M=0.7, w0=1.0), "b": Brake(J=0.3, M=0.7, w0=1.0)}
    system = lp.assemble(lp.compose(**parts))
    found = both(system, [fun.final("a.phi"), fun.instant("b")], ["a.J", "b.J"], 1.0)
    assert found.derivatives == pytest.approx(np.array([[0.5 / 0.7, 0], [0, 1 / 0.7]]), abs=1e-9)

    def equations(self):
        yield lp.der(self.x) == self.a
        yield lp.der(self.z) == self.b
        first = where(self.x > 1.0, where(self.z > 1.0, 1, 0), 0)
        yield lp.der(self.y) == first

    for other in (0.3, 0.1 + 0.2, 3 * 0.1):
        gate = assemble_one(
            equations,
            a=lp.param("1/s", "rate", 0.3),
            b=lp.param("1/s", "rate", other),
            x=lp.var("1", "one", state="always"),
            z=lp.var("1", "other", state="always"),
            y=lp.var("1", "sum", state="always"),
        )
        for call, of in (
            (lp.gradient, fun.final("y")),
            (lp.sensitivity, fun.final("y")),
            (lp.sensitivity, "y"),
        ):
            action = partial(call, gate, of=[of], by=["a"], until=5.0)
            refused(SolverError, action, "t = 3.33333", "coincide", "One")


def test_instants_of_changes_that_coincide_have_slopes_to_both_sides():
    """Two clutches pull three bodies together, both until 10 s where F = 1 is that of both.

    With more, c sticks at 10 / (2 F - 1) and d at 10; with less, d at 10 / (2 - F) and c at 10 / F.
    """
    law = ((0.0, 1.0),)
    model = in_a_row(
        a=Inertia(J=1.0, w=10.0),
        c=Clutch(f_max=1.0, u=1.0, characteristic=law),
        m=Inertia(J=1.0, w=0.0),
        d=Clutch(f_max=1.0, u=1.0, characteristic=law),
        b=Inertia(J=1.0, w=-10.0),
    )
    system = lp.assemble(model)
    for of in ("b.w", fun.final("b.w")):
        found = lp.sensitivity(system, of=[of], by=["c.f_max"], until=15.0, grid=10)
        sides = {i.components: (i.slopes[0], i.left[0]) for i in found.instants}
        assert sides[("c",)] == pytest.approx((-20.0, -10.0), rel=1e-6)
        assert sides[("d",)] == pytest.approx((0.0, 10.0), rel=1e-6, abs=1e-6)
    alone = lp.sensitivity(system, of=["b.w"], by=["c.f_max"], until=15.0, side="left")
    assert all(i.left is None for i in alone.instants)
