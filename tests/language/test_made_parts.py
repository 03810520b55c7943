"""Parts and defaults that follow from structural choices."""

import itertools

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia, Spring
from lumped.errors import DeclarationError, EquationError, ParameterError
from lumped.language.component import Made
from lumped.language.given_numbers import read_given_number


def cut(rod):
    return [Spring(c=rod.c * rod.n) for _ in range(rod.n)]


class Rod(lp.Component):
    """``1 / c = sum(1 / c_i)`` in `n` springs, with a body at each end of a spring."""

    flange_a = lp.Flange(free=True)
    flange_b = lp.Flange(free=True)
    n: int = 2
    kind: str = "soft"
    c: lp.Param = lp.param(
        "N.m/rad", "stiffness", lambda rod: {"soft": 5.0, "hard": 50.0}[rod.kind]
    )
    J: lp.Param = lp.param("kg.m2", "inertia of each body", lambda rod: rod.c / 100)
    springs = Made(cut)
    bodies = Made(lambda rod: [Inertia(J=rod.J) for _ in range(rod.n + 1)])

    def connections(self):
        yield lp.connect(self.flange_a, self.bodies[0].flange_a)
        yield from lp.chain(
            self.bodies[0], *itertools.chain(*zip(self.springs, self.bodies[1:], strict=True))
        )
        yield lp.connect(self.bodies[-1].flange_b, self.flange_b)


class Pair(lp.Component):
    """Two rods with ``c`` from a level further out."""

    c: lp.Param = lp.param("N.m/rad", "stiffness", 7.0)
    rods = [Rod(), Rod(n=3, c=2 * c)]  # noqa: RUF012

    def connections(self):
        yield from lp.chain(*self.rods)


class Twice(lp.Component):
    """Two levels: ``c = 3 k``."""

    k: lp.Param = lp.param("N.m/rad", "stiffness", 4.0)
    pair: Pair = Pair(rods=[Rod(c=3 * k), Rod()])


def frequencies(n, c, J):
    """Free-free chain: springs c n, bodies J."""
    number = np.arange(1, n + 1)
    return 2 * np.sqrt(c * n / J) * np.sin(number * np.pi / (2 * (n + 1))) / (2 * np.pi)


@pytest.mark.parametrize("n", [1, 2, 5])
@pytest.mark.parametrize(("kind", "c"), [("soft", 5.0), ("hard", 50.0)])
def test_as_many_parts_as_a_structural_choice_says(n, kind, c):
    found = lp.modes(lp.assemble(lp.compose(rod=Rod(n=n, kind=kind)))).hertz
    received = found[found > 1e-6]
    expected = frequencies(n, c, c / 100)
    assert received == pytest.approx(expected, rel=1e-9)


def test_a_default_by_a_function_may_be_varied_and_given():
    system = lp.assemble(lp.compose(rod=Rod()))
    assert system.parameter_values()["rod.c"] == 5.0
    received = system.parameter_values({"rod.c": 8.0})
    assert received["rod.J"] == pytest.approx(0.08)
    assert received["rod.springs[1].c"] == pytest.approx(16.0)
    given = lp.assemble(lp.compose(rod=Rod(c=3.0))).parameter_values()
    assert given["rod.springs[0].c"] == pytest.approx(6.0)


def test_a_made_part_is_changed_through_what_it_is_made_of():
    model = lp.compose(rod=Rod(n=2))
    received = lp.assemble(model.with_({"rod.c": 11.0})).parameter_values()
    assert received["rod.springs[1].c"] == 22.0
    with pytest.raises(DeclarationError, match="'springs' follow from its own values"):
        model.with_({"rod.springs[1].c": 11.0})


def test_a_part_is_bound_to_a_parameter_two_levels_out():
    received = lp.assemble(Twice()).parameter_values()
    assert received["pair.rods[0].c"] == 12.0
    assert received["pair.rods[1].c"] == 5.0
    varied = lp.assemble(Twice()).parameter_values({"k": 5.0})
    assert varied["pair.rods[0].springs[0].c"] == 30.0


def test_a_part_inside_of_a_class_is_bound_to_its_parameters():
    received = lp.assemble(Pair()).parameter_values()
    assert received["rods[1].springs[2].c"] == pytest.approx(42.0)


def test_numbers_are_known_before_a_model_is_assembled():
    model = Twice()
    received = [read_given_number(rod, "J") for rod in model.pair.rods]
    expected = [0.12, 0.05]
    assert received == pytest.approx(expected)


def test_a_parameter_may_need_another_bound_one_twice():
    """``c`` by way of ``a`` and of ``b``, which needs ``a`` too: no circle."""

    class Diamond(lp.Component):
        """``c = a + b + a``."""

        x: lp.Param = lp.param("1", "free", 2.0)
        c: lp.Param = lp.param("1", "last", lambda d: d.a + d.b + d.a)
        a: lp.Param = lp.param("1", "first", lambda d: 2 * d.x)
        b: lp.Param = lp.param("1", "between", lambda d: d.a + 1)
        y = lp.Output("1", "result")

        def equations(self):
            yield self.y == self.c

    received = lp.start_point(lp.assemble(Diamond()))["y"]
    expected = 4.0 + 5.0 + 4.0
    assert received == expected


def test_a_circle_of_defaults_is_refused():
    class Circle(lp.Component):
        """``a = b``, ``b = a``."""

        a: lp.Param = lp.param("1", "one", lambda c: c.b)
        b: lp.Param = lp.param("1", "other", lambda c: c.a)

    with pytest.raises(ParameterError, match="in a circle"):
        lp.assemble(lp.compose(part=Circle()))


def test_what_makes_no_parts_is_refused():
    class Strange(lp.Component):
        """No parts: 0 = 0."""

        parts = Made(lambda part: [3.0])

    class Faulty(lp.Component):
        """No parts: 0 = 0."""

        parts = Made(lambda part: 1 / 0)

    with pytest.raises(DeclarationError, match=r"part \(Strange\): 'parts' is made as \[3\.0\]"):
        lp.assemble(lp.compose(part=Strange()))
    with pytest.raises(EquationError, match=r"part \(Faulty\): the parts 'parts' raised ZeroDiv"):
        lp.assemble(lp.compose(part=Faulty()))


def test_a_bound_parameter_out_of_range_is_not_told_beside_its_cause():
    class Narrow(lp.Component):
        """``b = 2 a``."""

        a: lp.Param = lp.param("1", "cause", above=0)
        b: lp.Param = lp.param("1", "effect", lambda n: 2 * n.a, above=0)

    with pytest.raises(ParameterError) as caught:
        lp.assemble(lp.compose(part=Narrow(a=-1.0)))
    assert "part.a = -1" in str(caught.value)
    assert "part.b" not in str(caught.value)
    with pytest.raises(ParameterError, match=r"part\.b = -3"):
        lp.assemble(lp.compose(part=Narrow(a=1.0, b=-3.0)))
