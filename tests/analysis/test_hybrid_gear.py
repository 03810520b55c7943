"""Conditions that compare parameters only."""

import pytest

import lumped as lp


class Chooser(lp.Component):
    """Rates that tell whether conditions on a parameter hold."""

    k: lp.Param = lp.param("1", "what is compared", 1.0)
    above: lp.Var = lp.var("1", "grows while k > 1")
    least: lp.Var = lp.var("1", "grows while k >= 1")

    def equations(self):
        yield lp.der(self.above) == lp.ops.where(self.k > 1, 1, 0)
        yield lp.der(self.least) == lp.ops.where(self.k >= 1, 1, 0)


@pytest.mark.parametrize(("k", "expected"), [(0.5, (0, 0)), (1.0, (0, 1)), (2.0, (1, 1))])
def test_a_strict_condition_on_a_parameter_is_false_at_equality(k, expected):
    run = lp.simulate(lp.assemble(Chooser()), until=1.0, parameters={"k": k})
    received = (run["above"][-1], run["least"][-1])
    assert received == pytest.approx(expected, abs=1e-12)
