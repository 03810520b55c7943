"""Templates serve several models and know none of them."""

import gc
import weakref
from collections.abc import Iterator

import numpy as np
import pytest

import lumped as lp
from lumped.errors import SingularModelError
from lumped.language.expression import Equation
from lumped.language.switch import Item
from lumped.ops import where

GAIN = {"now": 1.0}
BALL = {"restitution": 0.5, "strict": True, "kick": 2.0}


class Decay(lp.Component):
    """``x' == -gain x``, the gain a number of the module."""

    x = lp.var("m", "size", start=1.0)

    def equations(self) -> Iterator[Equation]:
        """Exponential decay."""
        yield lp.der(self.x) == -GAIN["now"] * self.x


class Careless(lp.Component):
    """Asks for a condition that only a change of a number makes wrong."""

    x = lp.var("m", "size", start=1.0)

    def equations(self) -> Iterator[Equation]:
        """Too many equations once the gain is 7."""
        yield lp.der(self.x) == -self.x
        if GAIN["now"] == 7.0:
            yield self.x == 1.0


class Ball(lp.Component):
    """A mass 1 on a floor whose restitution is a number of the module."""

    s = lp.var("m", "height", start=1.0)
    v = lp.var("m/s", "velocity", state="prefer")
    f = lp.var("N", "reaction")

    def equations(self) -> Iterator[Item]:
        """Free fall with g = 2, and impacts."""
        yield lp.der(self.s) == self.v
        yield lp.der(self.v) == -2 - self.f
        yield lp.hold(self.f, self.v, gap=self.s, restitution=BALL["restitution"])


class Switch(lp.Component):
    """What happens where a condition is met exactly, by choices of the module."""

    x = lp.var("m", "size", start=1.0)
    y = lp.var("m", "kicked", start=1.0)

    def equations(self) -> Iterator[Item]:
        """A branch at equality, and a new value of y when x has grown to 2."""
        at_one = self.x > 1 if BALL["strict"] else self.x >= 1
        yield lp.der(self.x) == where(at_one, 2.0, 1.0)
        yield lp.der(self.y) == 0
        yield lp.when(self.x >= 2, {self.y: BALL["kick"] * self.y})


def rate(model: lp.Component) -> float:
    """Rate of the only state at 1."""
    system = lp.assemble(model)
    (found,) = np.asarray(system.rhs([1.0], [], 0.0, [])).ravel()
    return float(found)


def test_a_number_that_changed_between_two_models_is_seen(monkeypatch: pytest.MonkeyPatch):
    for gain in (1.0, 2.0, 1.0):
        monkeypatch.setitem(GAIN, "now", gain)
        assert rate(Decay()) == -gain


@pytest.mark.parametrize("restitution", [0.5, 0.25, 0.0])
def test_restitution_that_changed_between_two_models_is_seen(
    restitution: float, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(BALL, "restitution", restitution)
    run = lp.simulate(lp.assemble(Ball()), until=1.25, rtol=1e-10)
    # it falls for 1 s, lands at 2 m/s, and is seen 0.25 s later
    expected = max(0.0, 2 * restitution * 0.25 - 0.25**2)
    assert run["s"][-1] == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("kick", [2.0, -3.0])
@pytest.mark.parametrize("strict", [True, False])
def test_strictness_and_new_values_that_changed_between_two_models_are_seen(
    strict: bool, kick: float, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setitem(BALL, "strict", strict)
    monkeypatch.setitem(BALL, "kick", kick)
    system = lp.assemble(lp.compose(part=Switch()))
    assert bool(system.switching.strict[0]) is strict
    run = lp.simulate(system, until=2.0)
    assert run["part.y"][-1] == pytest.approx(kick)


def test_conditions_are_told_with_the_names_of_the_model_at_hand():
    lp.assemble(lp.compose(first=Switch()))
    system = lp.assemble(lp.compose(second=Switch()))
    assert system.switching.relation_text(0, True) == ("second", "x > 1")
    assert lp.simulate(system, until=2.0).events[-1].component == "second"


def test_faults_name_the_instance_although_an_equal_one_was_sound(monkeypatch: pytest.MonkeyPatch):
    lp.assemble(lp.compose(first=Careless()))
    monkeypatch.setitem(GAIN, "now", 7.0)
    with pytest.raises(SingularModelError, match=r"second \(Careless\) brings 2 equations"):
        lp.assemble(lp.compose(second=Careless()))


def test_equations_are_printed_with_the_names_of_the_model_at_hand():
    lp.assemble(lp.compose(first=Decay()))
    tree = lp.assemble(lp.compose(second=Decay())).structure.flat
    node, text = tree.origin(0)
    assert node.path == "second"
    assert text == "der(second.x) = -1 * second.x"


def test_no_template_keeps_a_model_alive():
    class Lonely(Switch):
        """A class that only this test has."""

        f = lp.var("N", "reaction")

        def equations(self) -> Iterator[Item]:
            """Factors that no other class has, and everything that switches."""
            yield from super().equations()
            yield lp.when(self.y >= 0.123456789, {self.y: 0.0})
            yield lp.hold(self.f, self.x, gap=self.y, engaged=self.x > 0.123456789)

    model = lp.compose(part=Lonely())
    part = weakref.ref(model.part)
    system = lp.assemble(model)
    assert part() is not None
    del model, system
    gc.collect()
    assert part() is None
