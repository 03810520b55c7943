"""Coefficients of the methods of integration against those published elsewhere, and their order."""

import numpy as np
import pytest
from scipy.integrate import DOP853

from lumped.numerics import dop853


@pytest.mark.parametrize("name", ["B", "C", "D", "E3", "E5", "A_EXTRA", "C_EXTRA"])
def test_coefficients_of_dop853_are_those_of_scipy(name):
    np.testing.assert_array_equal(np.array(getattr(dop853, name)), getattr(DOP853, name))


def test_rows_of_dop853_are_those_of_scipy():
    for row, expected in zip(dop853.A, DOP853.A, strict=True):
        np.testing.assert_array_equal(row, expected[: len(row)])
        assert not expected[len(row) :].any()


def rate(t, y):
    """Four quantities that act on each other, with every kind of derivative."""
    a, b, c, d = y
    return np.array([b * c - np.sin(t * a), a * a - d, np.cos(b) + t * d, a * b * c - d**3])


def combined(h, weights):
    """A combination of the thirteen stages of one step."""
    y, stages = np.array([0.7, -0.4, 0.3, 0.9]), []
    for row, c in zip(dop853.A, dop853.C, strict=True):
        shift = sum((w * k for w, k in zip(row, stages, strict=False)), np.zeros(4))
        stages.append(rate(0.2 + c * h, y + h * shift))
    new = y + h * sum(w * k for w, k in zip(dop853.B, stages, strict=True))
    stages.append(rate(0.2 + h, new))
    return h * sum(w * k for w, k in zip(weights, stages, strict=True))


def test_the_linear_estimate_of_the_error_is_of_order_seven():
    """Half the step gives less than a 100th: the order is above log2(100) = 6.6."""
    coarse, fine = (np.abs(combined(h, dop853.E6)).max() for h in (0.05, 0.025))
    assert 1e-16 < fine < coarse / 100
    assert coarse < 1e-11
