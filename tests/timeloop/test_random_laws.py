"""Random laws of time and state, with kinks and jumps, move a body as SciPy says piece by piece.

``python -m pytest tests/timeloop/test_random_laws.py --hypothesis-profile=long`` tries a thousand
of each.
"""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import assume, given, note
from hypothesis import strategies as st
from laws import RELATIONS, ChatterError, expression, motion, numbers
from rows import in_a_row

import lumped as lp
from lumped.components import Damper, Fixed, Inertia
from lumped.errors import OptionError

END, GRID = 2.0, np.linspace(0, 2.0, 33)
J, D = 0.7, 0.3

number = st.integers(-300, 300).map(lambda k: k / 100 + 0.0013)
slope = st.integers(5, 90).map(lambda k: k / 10)


def heights(count):
    return st.lists(number, min_size=count, max_size=count)


@st.composite
def argument(draw, leaves, inner):
    """What decides between pieces; it is never constant."""
    found = ("scale", draw(slope), (draw(leaves),))
    if draw(st.booleans()):
        found = ("scale", draw(slope) / 3, ("sin", ("+", found, ("number", draw(number)))))
    found = ("+", found, ("number", draw(number) / 2))
    return ("+", found, ("scale", 0.3, draw(inner))) if draw(st.booleans()) else found


def grammar(names):
    """Laws of the quantities named, of about the size of one."""
    leaves = st.sampled_from(names)
    leaf = st.one_of(
        number.map(lambda c: ("number", c)),
        st.tuples(leaves).map(lambda leaf: ("sin", ("scale", 2.3, leaf))),
        leaves.map(lambda name: ("tanh", (name,))),
    )

    def extend(inner):
        x = argument(leaves, inner)
        rows = st.tuples(heights(4), st.integers(-10, 10)).map(
            lambda r: ([r[1] / 10 + 0.7 * i for i in range(4)], r[0])
        )
        times = st.lists(
            st.integers(1, 199).map(lambda k: k / 100), min_size=3, max_size=3, unique=True
        )
        return st.one_of(
            st.tuples(st.just("+"), inner, inner),
            st.tuples(st.just("*"), inner, x.map(lambda a: ("sin", a))),
            x.map(lambda a: ("abs", a)),
            x.map(lambda a: ("sign", a)),
            st.tuples(st.sampled_from(["minimum", "maximum"]), x, inner),
            st.tuples(st.just("where"), st.sampled_from(list(RELATIONS)), x, inner, inner, inner),
            st.tuples(x, rows).map(lambda r: ("interpolate", r[0], *r[1])),
            st.tuples(times.map(sorted), heights(3)).map(lambda r: ("table", *r)),
            st.tuples(x, heights(6)).map(lambda r: ("spline", r[0], [*r[1], r[1][0]])),
            x.map(lambda a: ("cos", a)),
        )

    return st.recursive(leaf, extend, max_leaves=5)


class LawTorque(lp.Component):
    """Torque by a law of time, angle and speed."""

    flange = lp.Flange()
    law: Callable | None = None
    w: lp.Var = lp.var("rad/s", "speed")

    def equations(self):
        yield self.w == lp.der(self.flange.phi)
        yield self.flange.tau == -self.law(self.flange.phi, self.w)


def agree(tree, methods):
    """Compare all methods with the reference."""
    law = numbers(tree)
    start = (0.31, 1.17)
    try:
        expected, events = motion(law, J, D, start, GRID)
        beside, _ = motion(law, J * (1 + 1e-8), D, start, GRID)
    except ChatterError:
        assume(False)
    worth = np.abs(beside - expected).max()
    assume(worth < 1e-5)  # else a border is grazed
    push = LawTorque(law=lambda phi, w: expression(tree, lp.time, phi, w))
    model = in_a_row(ground=Fixed(), damper=Damper(d=D), body=Inertia(J=J), push=push)
    system = lp.assemble(model, keep=["body.phi"])
    note(f"events of the reference: {events}")
    begin = dict(zip(("body.phi", "body.w"), start, strict=True))
    for method in methods:
        try:
            run = lp.simulate(system, until=END, grid=GRID, rtol=1e-9, method=method, start=begin)
        except OptionError:
            assert method == "taylor"  # a spline has no series
            assert "spline" in str(tree)
            continue
        received = run.table(["body.phi", "body.w"])
        error = np.abs(received - expected).max()
        note(f"{method}: {error:.1e}, reference moves by {worth:.1e}")
        assert error < 1e-6 * np.abs(expected).max() + 10 * worth, method


@given(grammar(["t", "phi", "w"]))
def test_a_law_of_time_and_state_moves_a_body_alike_with_every_method(tree):
    agree(tree, ["auto", "steps", "explicit", "implicit", "taylor"])


@given(grammar(["t"]))
def test_a_law_of_the_time_alone_moves_a_body_alike_with_every_method(tree):
    agree(tree, ["auto", "explicit", "implicit", "taylor"])


@pytest.mark.parametrize("method", ["explicit", "implicit"])
def test_a_power_of_what_is_cut_at_zero_is_never_taken_of_less(method):
    """A torque ``max(1 - phi, 0)^1.5`` does the work ``1 / 2.5``; a step may pass its end."""
    push = LawTorque(law=lambda phi, w: lp.ops.maximum(1 - phi, 0.0) ** 1.5)
    model = in_a_row(body=Inertia(J=1.0), push=push)
    start = {"body.phi": 0.0, "body.w": 1.0}
    system = lp.assemble(model, keep=["body.phi"])
    run = lp.simulate(system, until=3.0, start=start, method=method, rtol=1e-9)
    assert run["body.w"][-1] == pytest.approx(np.sqrt(1 + 2 / 2.5), rel=1e-7)
