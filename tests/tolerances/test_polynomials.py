"""Orthonormal polynomials and sets of their products, against closed forms and quadrature."""

import itertools
from math import comb, factorial

import numpy as np
import pytest
import scipy

from lumped.tolerances.expansions.polynomials import (
    NORMAL,
    family_of,
    list_exponents,
    products,
    slopes_of_products,
    standard_normal,
)

SCORES = standard_normal()
SHARES = scipy.special.ndtr(SCORES)
TRIANGLE = scipy.stats.triang(0.3, 1.0, 2.0)
"""Between 1 and 3, most likely 1.6."""


def test_normal_parameters_have_the_polynomials_of_hermite():
    z = np.linspace(-3, 3, 7)
    received, slopes = NORMAL.values(z, 6)
    expected = [scipy.special.eval_hermitenorm(k, z) / np.sqrt(factorial(k)) for k in range(7)]
    assert received == pytest.approx(np.array(expected), abs=1e-13)
    assert slopes[1:] == pytest.approx(received[:-1] * np.sqrt(np.arange(1, 7))[:, None], abs=1e-13)


@pytest.mark.parametrize(("low", "high"), [(2.0, 5.0), (5.0, 2.0)])
def test_uniform_parameters_have_the_polynomials_of_legendre(low, high):
    family = family_of(low + (high - low) * SHARES)
    assert family.bounded
    assert (family.mean, family.deviation) == pytest.approx((3.5, 3 / np.sqrt(12)), rel=1e-13)
    t = np.linspace(-1, 1, 9)
    received, _ = family.values(np.sqrt(3) * t, 10)
    expected = [np.sqrt(2 * k + 1) * scipy.special.eval_legendre(k, t) for k in range(11)]
    assert received == pytest.approx(np.array(expected), abs=1e-11)
    assert family.weights(np.sqrt(3) * t) == pytest.approx(1.5 * (1 - t**2), abs=1e-4)


def integral(function):
    """Of a function over the triangular law, by quadrature over its density."""
    return sum(
        scipy.integrate.quad(lambda x: function(x) * TRIANGLE.pdf(x), *ends, epsabs=1e-13)[0]
        for ends in ((1.0, 1.6), (1.6, 3.0))
    )


def test_triangular_parameters_have_polynomials_of_their_own():
    family = family_of(TRIANGLE.ppf(SHARES))
    assert (family.mean, family.deviation) == pytest.approx((TRIANGLE.mean(), TRIANGLE.std()))

    def polynomial(k, x):
        return family.values(np.array([(x - family.mean) / family.deviation]), 5)[0][k, 0]

    pairs = itertools.combinations_with_replacement(range(6), 2)
    error = [
        integral(lambda x, i=i, j=j: polynomial(i, x) * polynomial(j, x)) - (i == j)
        for i, j in pairs
    ]
    assert np.abs(error).max() < 1e-5


def test_the_kernel_of_a_law_meets_the_identity_of_stein():
    """Mean of z g(z) is that of kernel times g', here with g = sin."""
    family = family_of(TRIANGLE.ppf(SHARES))
    middle, width = TRIANGLE.mean(), TRIANGLE.std()
    expected = integral(lambda x: (x - middle) / width * np.sin((x - middle) / width))
    received = integral(
        lambda x: family.weights((x - middle) / width) * np.cos((x - middle) / width)
    )
    assert received == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(
    "values", [3.0 + SCORES, np.exp(0.1 * SCORES), scipy.stats.expon.isf(SHARES[::-1])]
)
def test_parameters_without_bounds_use_the_normal_variable(values):
    assert family_of(values) is NORMAL


def test_a_law_of_three_values_has_polynomials_up_to_degree_two():
    assert family_of(np.searchsorted([0.2, 0.7], SHARES).astype(float)).most == 2


@pytest.mark.parametrize(("norm", "degree"), [(1.0, 5), (0.5, 9)])
def test_a_set_holds_all_products_up_to_its_degree(norm, degree):
    rows = list_exponents([degree] * 3, norm, 500)
    assert rows[0].tolist() == [0, 0, 0]
    everything = itertools.product(range(degree + 1), repeat=3)
    expected = {row for row in everything if sum(k**norm for k in row) <= degree**norm * (1 + 1e-9)}
    assert {tuple(row) for row in rows.tolist()} == expected
    assert len(rows) == len(expected)
    assert norm < 1 or len(rows) == comb(degree + 3, 3)


def test_a_set_keeps_within_its_count_and_the_degrees_of_each_variable():
    assert len(list_exponents([16] * 10, 1.0, 300)) == 286
    assert len(list_exponents([5] * 3, 1.0, comb(8, 3))) == comb(8, 3)
    assert len(list_exponents([2] * 1200, 1.0, 1500)) == 1201
    assert list_exponents([4, 1], 1.0, 100).max(axis=0).tolist() == [4, 1]


def test_derivatives_of_products_are_those_of_differences():
    families = (NORMAL, family_of(SHARES), family_of(TRIANGLE.ppf(SHARES)))
    exponents = list_exponents([5] * 3, 1.0, 100)
    z, step = np.random.default_rng(0).uniform(-1.2, 1.2, (6, 3)), 1e-5
    slopes = slopes_of_products(families, z, exponents)
    for j in range(3):
        ahead, behind = z.copy(), z.copy()
        ahead[:, j] += step
        behind[:, j] -= step
        both = [products(families, at, exponents) for at in (ahead, behind)]
        assert slopes[j] == pytest.approx((both[0] - both[1]) / (2 * step), abs=1e-7)
