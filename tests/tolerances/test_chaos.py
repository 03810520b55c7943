"""Scatter by polynomials of the parameters, against closed forms and published statistics."""

from pathlib import Path

import numpy as np
import pytest
import scipy
import yaml

import lumped as lp
from benchmarks._ensemble_tasks import tasks
from lumped.errors import OptionError, SolverError
from lumped.tolerances.expansions.chaos import by_chaos
from tests.tolerances.given_scene import (
    ISHIGAMI_FIRST,
    ISHIGAMI_MEAN,
    ISHIGAMI_TOTAL,
    ISHIGAMI_VARIANCE,
    GivenScene,
    ishigami,
    lognormal,
    normal,
    uniform,
)

DATA = Path(__file__).parents[1] / "data" / "ensembles" / "tasks.yaml"


def shares(ranking, names):
    found = dict(ranking)
    return np.array([found[name] for name in names])


# -- formulas --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(3))
def test_forty_gradients_leave_a_billionth_of_the_function_of_ishigami(seed):
    scene = ishigami()
    found = by_chaos(scene, 40, seed, "sobol").spreads["y0"]
    u = np.random.default_rng(1).normal(size=(10_000, 3))
    missed = found.at(u) - scene.formula(scene.physical(u))[:, 0]
    assert np.mean(missed**2) < 1e-9 * ISHIGAMI_VARIANCE
    assert 1 - found.predicted < 1e-9
    assert found.mean == pytest.approx(ISHIGAMI_MEAN, abs=1e-4)
    assert found.std**2 == pytest.approx(ISHIGAMI_VARIANCE, rel=1e-5)
    assert shares(found.ranking, scene.names) == pytest.approx(ISHIGAMI_FIRST, abs=1e-5)
    assert shares(found.total, scene.names) == pytest.approx(ISHIGAMI_TOTAL, abs=1e-5)
    assert found.is_trusted


def test_shares_of_the_function_of_sobol_are_those_of_its_closed_form():
    """A product of (abs(4 x - 2) + a) / (1 + a): with kinks, from values alone."""
    a = np.array([0, 1, 4.5, 9, 99, 99, 99, 99])
    scene = GivenScene(
        [uniform(0.0, 1.0)] * 8,
        lambda x: ((np.abs(4 * x - 2) + a) / (1 + a)).prod(axis=1, keepdims=True),
        lambda x: np.zeros((len(x), 1, 8)),
    )
    found = by_chaos(scene, 500, 0, "sobol", gradients=False).spreads["y0"]
    own = 1 / (3 * (1 + a) ** 2)
    variance = (1 + own).prod() - 1
    assert shares(found.ranking, scene.names) == pytest.approx(own / variance, abs=0.02)
    total = own * (1 + own).prod() / (1 + own) / variance
    assert shares(found.total, scene.names) == pytest.approx(total, abs=0.02)
    # the error that is told is that at other points
    u = np.random.default_rng(1).normal(size=(4000, 8))
    y = scene.formula(scene.physical(u))[:, 0]
    missed = np.mean((found.at(u) - y) ** 2) / y.var()
    assert 0.5 < missed / (1 - found.predicted) < 2


def test_a_product_of_lognormal_parameters_has_its_closed_form():
    """Lognormal again; the third parameter has no effect."""
    scene = GivenScene(
        [lognormal(2.0, 0.1), lognormal(5.0, 0.2), uniform(0.0, 1.0)],
        lambda x: (x[:, 0] * x[:, 1] ** 2)[:, None],
        lambda x: np.column_stack([x[:, 1] ** 2, 2 * x[:, 0] * x[:, 1], np.zeros(len(x))])[:, None],
    )
    found = by_chaos(scene, 100, 0, "sobol").spreads["y0"]
    law = scipy.stats.lognorm(np.hypot(0.1, 0.4), scale=50.0)
    assert (found.mean, found.std) == pytest.approx((law.mean(), law.std()), rel=1e-4)
    assert found.skewness == pytest.approx(law.stats("s"), rel=0.02)
    for q in (0.01, 0.5, 0.99):
        assert found.quantile(q).value == pytest.approx(law.ppf(q), rel=2e-3)
    assert found.share(above=80.0).value == pytest.approx(law.sf(80.0), rel=0.01)
    assert found.share(below=30.0).value == pytest.approx(law.cdf(30.0), rel=0.01)
    assert dict(found.total)["p2"] < 1e-9
    u = np.random.default_rng(0).normal(size=(5, 3))
    assert found.at(u) == pytest.approx(scene.formula(scene.physical(u))[:, 0], rel=1e-3)


def test_correlated_parameters_have_a_distribution_but_no_shares():
    """Sum of two normal parameters with a correlation, and a uniform one."""
    mixing = np.array([[1.0, 0.0, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
    scene = GivenScene(
        [normal(1.0, 2.0), normal(4.0, 1.0), uniform(-1.0, 1.0)],
        lambda x: x.sum(axis=1)[:, None],
        lambda x: np.ones((len(x), 1, 3)),
        mixing,
    )
    found = by_chaos(scene, 20, 0, "sobol").spreads["y0"]
    assert found.expansion.degree == 1
    variance = 4 + 1 + 2 * 0.6 * 2 + 1 / 3
    assert (found.mean, found.std**2) == pytest.approx((5.0, variance), rel=1e-12)
    # squared covariances of parameters and sum, over their variances
    expected = np.array([(4 + 0.6 * 2) ** 2 / 4, (1 + 0.6 * 2) ** 2, 1 / 3]) / variance
    assert shares(found.ranking, scene.names) == pytest.approx(expected, abs=2e-3)
    with pytest.raises(OptionError, match="p0, p1 are correlated"):
        _ = found.total


def test_what_jumps_is_not_trusted_and_what_fails_is_told():
    def formula(x):
        jumps = (x[:, 0] * x[:, 1] > 0).astype(float)
        fails = np.where(x[:, 0] > 1.0, np.nan, x[:, 1])
        return np.column_stack([jumps, fails])

    scene = GivenScene(
        [normal(0.0, 1.0)] * 2, formula, lambda x: np.tile([[0.0, 0.0], [0.0, 1.0]], (len(x), 1, 1))
    )
    found = by_chaos(scene, 128, 0, "sobol")
    jumps, fails = found.spreads["y0"], found.spreads["y1"]
    assert not jumps.is_trusted
    assert "not to be trusted" in jumps.trust()
    assert "search='samples'" in jumps.trust()
    lost = int((found.points[:, 0] > 1).sum())
    assert fails.missing.value == pytest.approx(lost / 128)
    assert len(found.failures) == lost
    assert f"{lost} of 128 runs have no value" in found.notes[0]
    assert (fails.mean, fails.std) == pytest.approx((0, 1), abs=1e-12)


def test_too_few_runs_are_refused():
    with pytest.raises(OptionError, match="runs = 9: at least 10 are needed"):
        by_chaos(ishigami(), 9, 0, "sobol")
    lost = GivenScene(
        [normal(0.0, 1.0)], lambda x: np.where(x > -2, np.nan, x), lambda x: np.ones((len(x), 1, 1))
    )
    with pytest.raises(SolverError, match=r"0 of 20 runs have y0.*Run 0: the formula has no"):
        by_chaos(lost, 20, 0, "sobol")


def test_a_functional_without_derivatives_says_how_to_go_on():
    def none(x):
        raise OptionError("count has no derivatives.")

    scene = GivenScene([normal(0.0, 1.0)], lambda x: x, none)
    with pytest.raises(OptionError, match=r"no derivatives\. Or fit .* gradients=False"):
        by_chaos(scene, 20, 0, "sobol")
    assert by_chaos(scene, 20, 0, "sobol", gradients=False).spreads["y0"].std == pytest.approx(1)


# -- drives ----------------------------------------------------------------------------------------


def test_statistics_of_three_masses_are_those_of_a_hundred_thousand_runs():
    """Mean and deviation lie in the intervals that 100 000 random runs leave.

    Quantiles are met to a tenth of the deviation.
    """
    task = tasks()["a"]
    figures = yaml.safe_load(DATA.read_text())["a"]["peak_torque"]
    nominal = dict(zip(task.names, (0.5, 1.2, 3.0, 4e4, 2.5e4), strict=True))
    over = {name: lp.uniform(0.9 * value, 1.1 * value) for name, value in nominal.items()}
    found = lp.scatter(
        lp.assemble(task.model),
        over=over,
        of=task.of,
        until=task.until,
        search="chaos",
        runs=512,
        gradients=False,
    )
    u = scipy.special.ndtri(scipy.stats.qmc.Sobol(5, seed=0).random(2**14))
    both = np.max([found[label].at(u) for label in task.of], axis=0)
    n = 100_000
    assert abs(both.mean() - figures["mean"]) < 1.96 * figures["std"] / np.sqrt(n)
    assert abs(both.std() - figures["std"]) < 1.96 * figures["std"] / np.sqrt(2 * n)
    for q in ("q001", "q500", "q999"):
        level = float(q[1:]) / 1000
        off = np.quantile(both, level) - figures[q]
        assert abs(off) < 0.1 * figures["std"]
