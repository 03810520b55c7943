"""Searches from several starts, on a landscape with two valleys that is known."""

import numpy as np
import pytest

import lumped as lp
from lumped.components import Inertia, SpringDamper, Torque
from lumped.errors import OptionError

fun = lp.functionals
DEPTH = 0.3


class Landscape(lp.Component):
    """A height that grows with time at a rate of ``(p^2 - 1)^2 + 0.3 p + (q - 0.5)^2``."""

    p: lp.Param = lp.param("1", "place along the valleys", 0.9)
    q: lp.Param = lp.param("1", "place across them", 0.2)
    height: lp.Var = lp.var("1", "height", 0.0, state="always")
    far: lp.Var = lp.var("1", "place along the valleys, reached in a second", 0.0, state="always")

    def equations(self):
        """Constant rates."""
        p, q = self.p, self.q
        rate = (p * p - 1) * (p * p - 1) + DEPTH * p + (q - 0.5) * (q - 0.5)
        yield lp.der(self.height) == rate
        yield lp.der(self.far) == p


@pytest.fixture(scope="module")
def system():
    return lp.assemble(Landscape())


def valleys():
    """Places and heights of both valleys, the deeper one first."""
    roots = np.sort(np.roots([4.0, 0.0, -4.0, DEPTH]).real)
    low = roots[[0, 2]]
    return low, (low**2 - 1) ** 2 + DEPTH * low


def test_one_search_stays_in_its_valley_and_several_find_the_deeper_one(system):
    options = {"minimise": fun.final("height"), "until": 1.0}
    options["vary"] = {"p": (-2, 2), "q": (-1, 1)}
    place, height = valleys()
    alone = lp.optimise(system, **options)
    assert alone.parameters["p"] == pytest.approx(place[1], abs=1e-4)
    best = lp.optimise(system, **options, searches=4)
    assert best.parameters["p"] == pytest.approx(place[0], abs=1e-4)
    assert best.parameters["q"] == pytest.approx(0.5, abs=1e-4)
    assert best.objective == pytest.approx(height[0], abs=1e-9)
    found = [objective for objective, _ in best.others]
    assert found == sorted(found)
    assert any(value == pytest.approx(height[1], abs=1e-8) for value in found)
    assert "searches from other starts" in repr(best)
    assert best.start == {"p": 0.9, "q": 0.2}


def test_constraints_hold_from_every_start(system):
    best = lp.optimise(
        system,
        vary={"p": (-2, 2), "q": (-1, 1)},
        minimise={fun.final("height"): 1.0, "q": 0.1},
        subject_to=fun.final("far") >= -0.6,
        until=1.0,
        searches=3,
    )
    p = best.parameters["p"]
    assert p > -0.6 - 1e-7
    assert best.parameters["q"] == pytest.approx(0.45, abs=1e-4)
    inside = np.linspace(-0.6, 2, 200_001)
    least = ((inside**2 - 1) ** 2 + DEPTH * inside).min()
    assert (p * p - 1) ** 2 + DEPTH * p == pytest.approx(least, abs=1e-8)


def test_several_starts_need_bounds_and_a_system(system):
    options = {"minimise": fun.final("height"), "until": 1.0}
    with pytest.raises(OptionError, match="both bounds of p"):
        lp.optimise(system, vary={"p": (None, 2)}, **options, searches=2)
    with pytest.raises(OptionError, match="searches = 0"):
        lp.optimise(system, vary={"p": (-2, 2)}, **options, searches=0)
    run = lp.simulate(system, until=1.0)
    with pytest.raises(OptionError, match="for a system, modes or an"):
        lp.optimise(run, vary={"p": (-2, 2)}, minimise=fun.final("height"), searches=2)


def test_several_searches_find_the_softer_side_of_a_resonance():
    # a stiff coupling is best next to its bound, a soft one is better beyond the resonance
    c, d, speeds = (50.0, 2e4), 0.5, (80.0, 120.0)
    model = lp.compose(
        torque=Torque(tau=0.0),
        a=Inertia(J=1.0),
        coupling=SpringDamper(c=1.5e4, d=d),
        b=Inertia(J=1.0),
        load=Torque(tau=0.0),
        connections=lambda m: lp.chain(m.torque, m.a, m.coupling, m.b, m.load),
    )
    response = lp.vibration.order_response(
        lp.assemble(model),
        speeds=np.linspace(*speeds, 5),
        of=["coupling.tau"],
        excitations={"torque.tau": {1: 10.0}},
        shaft="a.phi",
        free="load.tau",
    )

    def largest(stiffness):
        w = np.linspace(*speeds, 20_001)
        joint = stiffness + 1j * w * d
        return np.abs(10.0 * joint / (2 * joint - w**2)).max()

    options = {"vary": {"coupling.c": c}, "minimise": fun.order_peak("coupling.tau")}
    alone = lp.optimise(response, **options)
    best = lp.optimise(response, **options, searches=5)
    assert alone.parameters["coupling.c"] == pytest.approx(c[1])
    assert alone.objective == pytest.approx(largest(c[1]), rel=1e-7)
    assert best.parameters["coupling.c"] == pytest.approx(c[0], rel=1e-3)
    assert best.objective == pytest.approx(largest(c[0]), rel=1e-4)
    assert best.start == {"coupling.c": 1.5e4}
    assert any(value == pytest.approx(largest(c[1]), rel=1e-6) for value, _ in best.others)
