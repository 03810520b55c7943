"""Start values of quantities that an implicit equation determines."""

import numpy as np
import pytest

import lumped as lp
from lumped import functionals as fun
from lumped.errors import StartError
from lumped.ops import where


class Rig(lp.Component):
    """A state and what follows from it by a cubic equation."""

    x: lp.Var = lp.var("1", "decays")
    y: lp.Var = lp.var("1", "root of a cubic")
    z: lp.Var = lp.var("1", "follows from the root")
    k: lp.Param = lp.param("1", "factor", 2.0)

    def equations(self):
        yield lp.der(self.x) == -self.x
        yield self.y**3 + self.y == self.k * self.x
        yield self.z == 3 * self.y**2


class Switched(Rig):
    """The same with a condition of the root that the state meets."""

    def equations(self):
        yield lp.der(self.x) == where(self.y > 0.5, -self.x, -2 * self.x)
        yield self.y**3 + self.y == self.k * where(self.x > 4.0, 2 * self.x, self.x)
        yield self.z == 3 * self.y**2


@pytest.fixture(scope="module", params=[Rig, Switched])
def system(request):
    return lp.assemble(request.param())


def cubic(y, k=2.0):
    return (y**3 + y) / k


@pytest.mark.parametrize("y", [1.0, 0.0, -2.0, 0.3])
def test_a_given_root_holds_and_the_state_follows(system, y):
    point = lp.start_point(system, start={"y": y})
    assert point["y"] == pytest.approx(y, abs=2e-9)
    assert point["x"] == pytest.approx(cubic(y), abs=2e-9)
    assert point.residual <= 1e-9


def test_what_follows_from_the_root_holds(system):
    point = lp.start_point(system, start={"z": 3.0})
    assert abs(point["y"]) == pytest.approx(1.0, abs=2e-9)
    assert point["x"] == pytest.approx(cubic(point["y"]), abs=2e-9)


def test_a_free_parameter_meets_state_and_root(system):
    point = lp.start_point(system, start={"x": 1.0, "y": 1.5}, free=["k"])
    assert point.parameters["k"] == pytest.approx(1.5**3 + 1.5, rel=4e-9)


def test_values_that_fit_hold_and_others_are_refused(system):
    point = lp.start_point(system, start={"x": 1.0, "y": 1.0})
    assert (point["x"], point["y"]) == (1.0, pytest.approx(1.0, abs=1e-12))
    for start in ({"x": 1.0, "y": 2.0}, {"x": 1.0, "z": 4.0}):
        with pytest.raises(StartError, match=r"contradict each other: . = . cannot hold together"):
            lp.start_point(system, start=start)
        with pytest.raises(StartError):
            lp.simulate(system, until=1.0, start=start)


def test_a_run_begins_there_and_its_gradient_is_that_of_the_closed_form():
    system = lp.assemble(Rig(y=1.5))
    run = lp.simulate(system, until=1.0, rtol=1e-10)
    assert run["x"][-1] == pytest.approx(cubic(1.5) * np.exp(-1.0), rel=1e-8)
    # x(1) = (y^3 + y) / k e^-1
    found = lp.gradient(system, of=[fun.final("x")], by=["k", "y"], until=1.0, rtol=1e-8)
    expected = np.exp(-1.0) * np.array([-cubic(1.5) / 2.0, (3 * 1.5**2 + 1) / 2.0])
    assert found.derivatives[0] == pytest.approx(expected, rel=1e-6)


def test_of_a_closed_linkage_the_value_still_chooses_the_assembly():
    """Of a crank of 1 and rod of 2 the slider is left or right of the crank."""

    class Linkage(lp.Component):
        phi: lp.Var = lp.var("rad", "angle of the crank", 1.0, state="always")
        s: lp.Var = lp.var("m", "position of the slider")
        v: lp.Var = lp.var("m/s", "its speed")

        def equations(self):
            yield lp.der(self.phi) == 1.0
            yield (self.s - lp.ops.cos(self.phi)) ** 2 + lp.ops.sin(self.phi) ** 2 == 4.0
            yield self.v == lp.der(self.s)

    for near, side in ((2.0, 1), (-1.0, -1)):
        point = lp.start_point(lp.assemble(Linkage(s=near)))
        expected = np.cos(1.0) + side * np.sqrt(4.0 - np.sin(1.0) ** 2)
        assert point["s"] == pytest.approx(expected, abs=1e-12)
