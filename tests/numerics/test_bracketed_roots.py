"""Zeros of several functions at once against closed forms."""

import numpy as np
import pytest

from lumped.numerics.bracketed_roots import find_bracketed_roots

KINDS = [np.cos, lambda x: x**3 - 2.0, lambda x: np.expm1(20 * (x - 1.3)), lambda x: x - 1.1]
ZEROS = np.array([np.pi / 2, 2 ** (1 / 3), 1.3, 1.1])


def found_by(kinds, zeros, count):
    """Zeros of several functions between 0 and 2, and how often these were evaluated."""
    calls = []

    def function(which, x):
        calls.append(len(which))
        return np.array([kinds[i](v) for i, v in zip(which, x, strict=True)])

    begin, end = np.zeros(count), np.full(count, 2.0)
    ends = [function(np.arange(count), v) for v in (begin, end)]
    roots = find_bracketed_roots(function, begin, end, *ends, np.full(count, 1e-15))
    error = np.abs(roots / zeros - 1).max()
    print(f"error {error:.1e} after {len(calls) - 2} rounds")
    return error, len(calls) - 2


def test_roots_are_found_to_rounding_in_few_rounds():
    error, rounds = found_by(KINDS, ZEROS, len(KINDS))
    assert error < 1e-14
    assert rounds < 30
    # of one smooth function no more than of the secant rule
    error, rounds = found_by(KINDS[:1], ZEROS[:1], 1)
    assert error < 1e-14
    assert rounds <= 8


@pytest.mark.parametrize("power", [1, 3, 9])
def test_a_root_of_higher_order_is_closed_in(power):
    """A function that is flat at its root, as high as rounding lets it be seen."""

    def function(which, x):
        return (x - 0.7) ** power

    one = np.ones(1)
    root = find_bracketed_roots(
        function, 0 * one, one, -(0.7**power) * one, 0.3**power * one, 1e-9 * one
    )
    assert abs(root[0] - 0.7) < 1e-7


@pytest.mark.parametrize("at", [0.2, 0.5, 0.7321])
def test_a_jump_is_closed_in(at):
    one = np.ones(1)
    root = find_bracketed_roots(
        lambda which, x: np.where(x < at, -3.0, 3.0), 0 * one, one, -3 * one, 3 * one, 1e-14 * one
    )
    assert root[0] == pytest.approx(at, abs=2e-14)


def test_without_functions_there_are_no_roots():
    none = np.zeros(0)
    assert find_bracketed_roots(lambda which, x: x, none, none, none, none, none).shape == (0,)
