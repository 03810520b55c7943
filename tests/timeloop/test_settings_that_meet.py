"""Two `when` that set one state: at one instant an error, at different instants both count."""

import numpy as np
import pytest
from rows import assemble_one, assemble_rows

import lumped as lp
from lumped import functionals as fun
from lumped.errors import SolverError
from lumped.kernel.engine import using


def counting(first, second, **quantities):
    """A model that adds 1 and multiplies by 10 when two conditions become true."""

    def equations(self):
        yield lp.der(self.x) == 0
        yield lp.der(self.angle) == 1.0
        yield lp.when(first(self), {self.x: self.x + 1})
        yield lp.when(second(self), {self.x: self.x * 10})

    given = {"x": lp.var("1", "set", 1.0), "angle": lp.var("1", "rises with the time")}
    return assemble_one(equations=equations, **given, **quantities)


SAME = {
    "times": (lambda m: lp.time >= 1.0, lambda m: lp.time >= 1.0),
    "states": (lambda m: m.angle >= 1.0, lambda m: 2 * m.angle >= 2.0),
    "both": (lambda m: lp.time >= 1.0, lambda m: m.angle >= 1.0),
}


@pytest.mark.parametrize("engine", ["llvm", "c", "python"])
@pytest.mark.parametrize("kind", SAME)
def test_two_settings_of_a_state_at_one_instant_are_an_error(kind, engine):
    system = counting(*SAME[kind])
    with using(engine), pytest.raises(SolverError) as caught:
        lp.simulate(system, until=2.0)
    text = str(caught.value)
    assert "t = 1 s two settings of x meet: One when" in text
    assert "Write both as one `when`" in text
    partial = caught.value.partial
    assert partial.t[-1] == pytest.approx(1.0, abs=1e-12)
    assert (partial["x"][partial.t < 1.0] == 1.0).all()


def test_settings_at_different_instants_follow_each_other():
    system = counting(lambda m: m.angle >= 1.0, lambda m: m.angle >= 1.0 + 1e-9)
    assert lp.simulate(system, until=2.0)["x"][-1] == (1 + 1) * 10
    system = counting(lambda m: lp.time >= 1.5, lambda m: m.angle >= 1.0)
    assert lp.simulate(system, until=2.0)["x"][-1] == 1 * 10 + 1


def test_a_setting_that_another_one_causes_comes_after_it():
    system = counting(lambda m: lp.time >= 1.0, lambda m: m.x >= 2.0)
    assert lp.simulate(system, until=2.0)["x"][-1] == (1 + 1) * 10


def test_settings_of_two_components_are_told_by_both():
    class Pulse(lp.Component):
        """Adds to what it is connected with."""

        y = lp.Output("1", "count")
        x: lp.Var = lp.var("1", "count")
        t_0: lp.Param = lp.param("s", "instant")

        def equations(self):
            yield lp.der(self.x) == 0
            yield self.y == self.x
            yield lp.when(lp.time >= self.t_0, {self.x: self.x + 1})

    class Reset(lp.Component):
        """Sets the count of another to zero."""

        u: lp.Input = lp.Input("1", "count")
        t_0: lp.Param = lp.param("s", "instant")
        seen: lp.Var = lp.var("1", "the same count")

        def equations(self):
            yield self.seen == self.u
            yield lp.when(lp.time >= self.t_0, {self.u: 0.0})

    system = assemble_rows("a.y b.u", a=Pulse(t_0=1.0), b=Reset(t_0=1.0))
    with pytest.raises(SolverError, match=r"meet: a when time >= .*, and b when time >= "):
        lp.simulate(system, until=2.0)
    run = lp.simulate(system, until=2.0, parameters={"b.t_0": 1.5})
    assert run["a.x"].max() == 1.0
    assert run["a.x"][-1] == 0.0


def test_in_ensembles_the_variants_with_two_settings_fail():
    def equations(self):
        yield lp.der(self.x) == 0
        yield lp.when(lp.time >= 1.0, {self.x: self.x + 1})
        yield lp.when(lp.time >= self.late, {self.x: self.x * 10})

    quantities = {"x": lp.var("1", "set", 1.0), "late": lp.param("s", "instant", 1.0)}
    system = assemble_one(equations=equations, **quantities)
    over = {"late": np.repeat([0.5, 1.0, 1.5], 8)}  # more than are run side by side
    found = lp.ensemble(system, over=over, until=2.0, of={"x": fun.final("x")})
    expected = np.repeat([1 * 10 + 1, np.nan, (1 + 1) * 10], 8)
    assert np.array_equal(found["x"], expected, equal_nan=True)
    assert "two settings of x meet" in found.failures[8]
