import numpy as np
import pytest
import scipy

from lumped.numerics.settled_amplitudes import SETTLED, solve_amplitudes


def test_many_single_amplitudes_are_the_smallest_roots():
    """Oscillators that soften, 20 of 200 with three roots: ``|k(A) / (k(A) - r + j d)|``."""
    ratio, damping, push = np.linspace(0.3, 1.5, 200), 0.05, 0.02

    def follows(amplitude, ratio):
        k = np.interp(amplitude, (0.0, 0.1, 0.4, 1.0), (1.0, 0.95, 0.6, 0.4))
        return push * np.abs(k / (k - ratio + 1j * damping))

    received, missed = solve_amplitudes(
        lambda a, at: follows(a[:, 0], ratio[at])[:, None], np.zeros((200, 1))
    )
    grid, several, worst = np.linspace(0.0, 2.0, 40_001), 0, 0.0
    for found, r in zip(received[:, 0], ratio, strict=True):
        f = follows(grid, r) - grid
        falls = np.flatnonzero((f[:-1] > 0) & (f[1:] <= 0))
        several += len(falls) > 1
        a, b = grid[falls[0]], grid[falls[0] + 1]
        root = scipy.optimize.brentq(lambda x, r=r: follows(x, r) - x, a, b, xtol=1e-15)
        worst = max(worst, abs(found / root - 1))
    assert several >= 10
    assert worst < 10 * SETTLED
    assert missed.max() <= SETTLED


def test_amplitudes_that_act_on_each_other_settle():
    """``a = (2 + b) / (1 + a), b = 3 / (1 + a b)`` in two cases, against SciPy's hybrid method."""

    def follows(x, at):
        a, b = x.T
        return np.column_stack([(2 + b) / (1 + a), np.array([3.0, 1.0])[at] / (1 + a * b)])

    received, _ = solve_amplitudes(follows, np.zeros((2, 2)))
    for i, size in enumerate((3.0, 1.0)):
        expected = scipy.optimize.root(
            lambda x, size=size: [(2 + x[1]) / (1 + x[0]) - x[0], size / (1 + x[0] * x[1]) - x[1]],
            [1.0, 1.0],
            tol=1e-14,
        ).x
        assert received[i] == pytest.approx(expected, rel=1e-9)


def test_what_jumps_over_its_solution_is_told():
    received, missed = solve_amplitudes(lambda a, _: np.where(a < 1.0, 2.0, 0.5), np.zeros((1, 1)))
    assert received[0, 0] == pytest.approx(1.0, rel=1e-6)
    assert missed[0] > 0.1


def test_without_vibration_there_is_no_amplitude():
    received, missed = solve_amplitudes(lambda a, _: 0.5 * a, np.zeros((3, 2)))
    assert not received.any()
    assert not missed.any()
