"""Searches that begin in a valley far away, or where derivatives are zero, against known optima."""

import numpy as np
import pytest

import lumped as lp
from lumped import functionals as fun
from lumped.errors import OptionError


class Two(lp.Component):
    """Two numbers and a state that rests."""

    a = lp.param("1", "first", 0.0)
    b = lp.param("1", "second", 0.0)
    x = lp.var("1", "nothing")

    def equations(self):
        yield lp.der(self.x) == 0 * self.a


def least(objective, start, bounds=(-5.0, 5.0)):
    """Where an objective of both numbers is least, from a start."""
    system = lp.assemble(Two(**dict(zip("ab", start, strict=True))))
    of = fun.final(objective(system.model.a, system.model.b))
    found = lp.optimise(system, vary=dict.fromkeys("ab", bounds), minimise=of, until=0.01)
    return found, [found.parameters[name] for name in "ab"]


def rosenbrock(a, b):
    return (1 - a) ** 2 + 100 * (b - a**2) ** 2


@pytest.mark.parametrize("start", [(-1.2, 1.0), (4.0, -4.0), (-5.0, 5.0)])
def test_a_search_goes_on_in_a_narrow_valley(start):
    found, received = least(rosenbrock, start)
    assert received == pytest.approx([1.0, 1.0], abs=1e-4)
    assert found.solution.residual < 1e-6


def test_a_parameter_without_slope_at_the_start_is_searched_too():
    _, received = least(lambda a, b: (1 - a) ** 2 + (b - a**2) ** 2, (0.0, 0.0))
    assert received == pytest.approx([1.0, 1.0], abs=1e-4)


def test_a_saddle_is_left():
    _, received = least(lambda a, b: a**2 - b**2 + b**4, (0.0, 0.0))
    assert np.abs(received) == pytest.approx([0.0, np.sqrt(0.5)], abs=1e-4)


def test_what_has_no_effect_anywhere_is_told():
    with pytest.raises(OptionError, match=r"b has no effect .* at the start and beside it"):
        least(lambda a, b: (1 - a) ** 2, (0.0, 0.0))
