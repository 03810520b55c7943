"""Intervals of quantiles and shares cover what they claim."""

import numpy as np
import pytest
import scipy

from lumped.tolerances.intervals import quantile_of, share_of


@pytest.mark.parametrize(("n", "q"), [(60, 0.5), (200, 0.05), (1000, 0.99)])
def test_intervals_of_quantiles_hold_the_true_one_in_95_percent(n, q):
    samples = np.sort(np.random.default_rng(7).exponential(size=(3000, n)), axis=1)
    true, inside, wide = -np.log(1 - q), 0, 0
    for row in samples:
        found = quantile_of(row, q)
        inside += found.low <= true <= found.high
        wide += found.low <= np.quantile(row, q) <= found.high
    share = inside / len(samples)
    # at least 95 %, and not much more: ranks are whole numbers
    assert 0.95 - 3 * np.sqrt(0.05 * 0.95 / 3000) < share < 0.98
    assert wide == len(samples)


def test_a_sample_that_is_too_small_tells_no_end():
    found = quantile_of(np.arange(100.0), 0.99)
    assert found.high == np.inf
    assert found.low > 90
    assert quantile_of(np.arange(100.0), 0.01).low == -np.inf


@pytest.mark.parametrize(("count", "n"), [(0, 30), (1, 10), (17, 50), (50, 50)])
def test_intervals_of_shares_are_those_of_clopper_and_pearson(count, n):
    expected = scipy.stats.binomtest(count, n).proportion_ci(0.95, "exact")
    found = share_of(count, n)
    assert found == pytest.approx((count / n, expected.low, expected.high), abs=1e-12)
