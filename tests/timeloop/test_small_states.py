"""States that are so small throughout that the absolute tolerance governs them."""

import pytest
from rows import assemble_one

import lumped as lp

GRIDS = [None, 1, 500, [0.0, 10.0], [10.0]]


@pytest.fixture(scope="module")
def pulse():
    """A state that rises to 1e-4 at 0.05 s and is gone later on; another one rests."""

    def equations(self):
        yield lp.der(self.x) == -20.0 * self.x
        yield lp.der(self.y) == 2e-4 * 2.718281828459045 * 10.0 * self.x - 20.0 * self.y
        yield lp.der(self.z) == 0

    quantities = {
        "x": lp.var("1", "decays", 1.0),
        "y": lp.var("1", "rises and decays"),
        "z": lp.var("1", "rests"),
    }
    return assemble_one(equations=equations, **quantities)


# y(t) = 2e-4 e 10 t exp(-20 t), at most 1e-4 at t = 1/20
@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("method", ["explicit", "implicit", "taylor"])
@pytest.mark.parametrize(("atol", "expected"), [(1e-9, ("y",)), (1e-11, ())])
def test_small_states_are_those_of_the_steps_whatever_is_recorded(
    pulse, grid, method, atol, expected
):
    """The limit is atol / rtol, ten times and a tenth of the peak."""
    options = {"until": 10.0, "rtol": 1e-6, "atol": atol, "method": method}
    assert lp.simulate(pulse, grid=grid, **options).statistics.small == expected


def test_a_peak_before_a_reset_counts():
    def equations(self):
        yield lp.der(self.x) == 1e-3
        yield lp.when(self.x >= 1e-4, {self.x: 0.0})

    system = assemble_one(x=lp.var("1", "sawtooth"), equations=equations)
    for atol, expected in ((1.01e-10, ("x",)), (0.99e-10, ())):
        for grid in (None, [1.0]):
            run = lp.simulate(system, until=1.05, rtol=1e-6, atol=atol, grid=grid)
            assert run.statistics.small == expected
