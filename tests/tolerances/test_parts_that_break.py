"""Damage that is infinite where the mean of a cycle reaches the ultimate strength."""

import numpy as np
import pytest
import scipy

import lumped as lp
from lumped import functionals as fun
from lumped.errors import SolverError
from lumped.life import SNCurve, goodman

ULTIMATE, MIDDLE, SCATTER, SWING = 100.0, 90.0, 10.0, 20.0
MEAN = {"mean": lp.normal(MIDDLE, SCATTER)}
PERIODS = 5.0


class Load(lp.Component):
    """A stress that swings about its mean, from valley to valley."""

    mean: lp.Param = lp.param("Pa", "mean", MIDDLE)
    stress: lp.Var = lp.var("Pa", "stress")
    x: lp.Var = lp.var("1", "what fades", 1.0, state="always")

    def equations(self):
        yield lp.der(self.x) == -self.x
        yield self.stress == self.mean - SWING * lp.ops.cos(2 * np.pi * lp.time)


@pytest.fixture(scope="module", name="part")
def swinging_part():
    return lp.assemble(Load())


@pytest.fixture(scope="module", name="damage")
def of_the_part():
    curve = SNCurve(knee=300.0, cycles=2e6, slope=5.0)
    return fun.damage("stress", curve, mean_stress=goodman(ULTIMATE))


def test_the_share_that_breaks_is_that_of_the_means(part, damage):
    """All cycles have the mean of the load."""
    found = lp.scatter(part, over=MEAN, of=damage, until=PERIODS, runs=2000)
    spread = found[str(damage)]
    exact = scipy.stats.norm.sf((ULTIMATE - MIDDLE) / SCATTER)
    share = spread.share(above=1e12)
    broken = found.points[:, 0] > ULTIMATE
    assert share.low < exact < share.high
    np.testing.assert_array_equal(np.isinf(found.values[:, 0]), broken)
    assert spread.missing.value == 0
    assert np.isinf([spread.mean, spread.quantile(0.99).value]).all()
    assert 0 < spread.quantile(0.5).value < 1
    assert dict(spread.causes(above=1e12))["mean"] > 0.4
    assert "nan " not in repr(found).partition("share of the variance")[2]
    found.plot()


def test_an_ensemble_tells_infinite_damage(part, damage):
    found = lp.ensemble(part, over={"mean": [10.0, 120.0, 130.0]}, until=PERIODS, of=[damage])
    assert found.failures == {}
    assert np.isinf(found[str(damage)]).tolist() == [False, True, True]
    assert np.isinf(found.quantile(str(damage), 0.5))
    assert found.quantile(str(damage), 0.0) == found[str(damage)][0]
    found.plot()


@pytest.mark.parametrize(
    "how", [{"search": "derivatives"}, {"search": "chaos", "gradients": False}]
)
def test_what_needs_smooth_functions_says_so(part, damage, how):
    with pytest.raises(SolverError, match=r"infinite in \d+ of 64 runs.*search='samples'"):
        lp.scatter(part, over=MEAN, of=damage, until=PERIODS, runs=64, **how)


def test_polynomials_with_gradients_tell_the_runs_that_break(part, damage):
    found = lp.scatter(part, over=MEAN, of=damage, until=PERIODS, runs=64, search="chaos")
    told = [i for i, reason in found.failures.items() if "breaks at once" in reason]
    assert told == np.flatnonzero(found.points[:, 0] > ULTIMATE).tolist()
    assert found[str(damage)].missing.value == len(found.failures) / 64


def test_there_is_no_derivative(part, damage):
    with pytest.raises(SolverError, match=r"reaches the ultimate strength.*Lower the load"):
        lp.gradient(part, of=[damage], by=["mean"], until=PERIODS, parameters={"mean": 120.0})
