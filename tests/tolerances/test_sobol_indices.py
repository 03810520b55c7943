"""Shares in the variance by sampling, against closed forms and SciPy's formulas."""

import numpy as np
import pytest
import scipy

import lumped as lp
from lumped import functionals as fun
from lumped.errors import OptionError, SolverError
from lumped.tolerances import sobol_indices
from lumped.tolerances.sobol_indices import indices_of
from tests.tolerances.drives import wheel
from tests.tolerances.given_scene import (
    ISHIGAMI_FIRST,
    ISHIGAMI_TOTAL,
    GivenScene,
    ishigami,
    normal,
)


def test_intervals_hold_the_closed_form_of_ishigami():
    found = indices_of(ishigami(), 1024, 0, 0.95)
    assert found.runs == 1024 * 5
    for received, interval, expected in (
        (found.first[0], found.first_interval[0], ISHIGAMI_FIRST),
        (found.total[0], found.total_interval[0], ISHIGAMI_TOTAL),
    ):
        assert received == pytest.approx(expected, abs=0.03)
        assert ((interval[:, 0] <= expected) & (expected <= interval[:, 1])).all()
        assert (np.diff(interval) < 0.3).all()


def test_shares_are_those_of_scipy_for_the_same_values():
    scene = ishigami()
    found = indices_of(scene, 256, 3, 0.95)
    values = scene.formula(scene.asked[0])[:, 0].reshape(5, 256)
    given = {"f_A": values[:1], "f_B": values[1:2], "f_AB": values[2:, None]}
    expected = scipy.stats.sobol_indices(func=given, n=256)
    assert found.first[0] == pytest.approx(expected.first_order, rel=1e-12)
    assert found.total[0] == pytest.approx(expected.total_order, rel=1e-12)


def test_intervals_of_random_pairs_hold_as_often_as_they_say():
    """Sum of two normal parameters with deviations 2 and 1: shares 0.8 and 0.2."""
    scene = GivenScene([normal(0.0, 2.0), normal(5.0, 1.0)], lambda x: x.sum(1)[:, None], None)
    inside, count = 0, 60
    for seed in range(count):
        low, high = indices_of(scene, 100, seed, 0.8).total_interval[0, 0]
        inside += low <= 0.8 <= high
    assert inside >= 0.7 * count  # points of Sobol are closer than random ones


def test_pairs_with_a_failed_run_are_left_out_and_told():
    def formula(x):
        return np.where(x[:, :1] > 2.5, np.nan, x.sum(axis=1, keepdims=True))

    scene = GivenScene([normal(0.0, 1.0), normal(0.0, 2.0)], formula, None)
    found = indices_of(scene, 512, 0, 0.95)
    assert 0 < found.left_out[0] < 20
    assert found.total[0] == pytest.approx([0.2, 0.8], abs=0.03)
    assert f"at most {found.left_out[0]} of 512 pairs" in repr(found)
    assert "the formula has no value here" in repr(found)
    lost = GivenScene([normal(0.0, 1.0)], lambda x: np.where(x > -2, np.nan, x), None)
    with pytest.raises(
        SolverError, match=r"0 of 64 pairs have y0; 16 are needed\. Run 0: the form"
    ):
        indices_of(lost, 64, 0, 0.95)


def test_a_constant_has_no_shares():
    scene = GivenScene([normal(0.0, 1.0)] * 2, lambda x: np.ones((len(x), 1)), None)
    found = indices_of(scene, 32, 0, 0.95)
    assert not found.first.any()
    assert not found.total.any()


SPEED = {"w": fun.final("body.w")}


def test_shares_of_a_drive_are_those_of_its_closed_form():
    """Speed of a body after one second: the sum of its torques over its inertia."""
    over = {"one.tau": lp.normal(20.0, 2.0), "two.tau": lp.uniform(9.0, 15.0)}
    found = sobol_indices(wheel(), over=over, of=SPEED, until=1.0, pairs=256)
    assert found.total[0] == pytest.approx(np.array([4.0, 3.0]) / 7, abs=0.03)
    assert found.names == ("one.tau", "two.tau")


def test_wrong_options_are_refused():
    over = {"one.tau": lp.normal(20.0, 2.0), "two.tau": lp.normal(12.0, 1.0)}
    options = {"of": SPEED, "until": 1.0}
    with pytest.raises(OptionError, match="pairs = 8: at least 16 are needed"):
        sobol_indices(wheel(), over=over, pairs=8, **options)
    with pytest.raises(OptionError, match="confidence = 95: a number between 0 and 1"):
        sobol_indices(wheel(), over=over, confidence=95, **options)
    together = lp.distributions.correlated(over, [[1.0, 0.5], [0.5, 1.0]])
    with pytest.raises(OptionError, match=r"one.tau, two.tau are correlated"):
        sobol_indices(wheel(), over=together, **options)
