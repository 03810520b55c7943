"""Templates serve several models and know none of them."""

import gc
import weakref
from collections.abc import Iterator

import numpy as np
import pytest

import lumped as lp
from lumped.errors import SingularModelError
from lumped.expression import Equation

GAIN = {"now": 1.0}


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


def rate(model: lp.Component) -> float:
    """Rate of the only state at 1."""
    system = lp.assemble(model)
    (found,) = np.asarray(system.rhs([1.0], [], 0.0, [])).ravel()
    return float(found)


def test_a_number_that_changed_between_two_models_is_seen(monkeypatch: pytest.MonkeyPatch):
    for gain in (1.0, 2.0, 1.0):
        monkeypatch.setitem(GAIN, "now", gain)
        assert rate(Decay()) == -gain


def test_faults_name_the_instance_although_an_equal_one_was_sound(
    monkeypatch: pytest.MonkeyPatch,
):
    lp.assemble(lp.compose(first=Careless()))
    monkeypatch.setitem(GAIN, "now", 7.0)
    with pytest.raises(SingularModelError, match=r"second \(Careless\) brings 2 equations"):
        lp.assemble(lp.compose(second=Careless()))


def test_equations_are_printed_with_the_names_of_the_model_at_hand():
    lp.assemble(lp.compose(first=Decay()))
    tree = lp.assemble(lp.compose(second=Decay()))._flat
    node, text = tree.origin(0)
    assert node.path == "second"
    assert text == "der(second.x) = -1 * second.x"


def test_no_template_keeps_a_model_alive():
    class Lonely(Decay):
        """A class that only this test has."""

        def equations(self) -> Iterator[Equation]:
            """Decay with a factor that no other class has."""
            yield lp.der(self.x) == -0.123456789 * self.x

    model = lp.compose(part=Lonely())
    part = weakref.ref(model.part)
    system = lp.assemble(model)
    assert part() is not None
    del model, system
    gc.collect()
    assert part() is None
