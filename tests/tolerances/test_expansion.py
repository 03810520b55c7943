"""Fits of polynomials to values and gradients, against closed forms and fits without a run."""

import numpy as np
import pytest
import scipy
from scipy.stats import qmc

from lumped.tolerances.expansions.expansion import fit_expansion
from lumped.tolerances.expansions.greedy import Rows
from lumped.tolerances.expansions.polynomials import (
    NORMAL,
    family_of,
    list_exponents,
    products,
    standard_normal,
)

UNIFORM = family_of(np.sqrt(3) * (2 * scipy.special.ndtr(standard_normal()) - 1))
RANDOM = np.random.default_rng(7)


@pytest.mark.parametrize("with_slopes", [True, False])
def test_mean_variance_and_shares_of_a_quadratic_function_are_exact(with_slopes):
    """z0 normal, z1 uniform: y = 2 + z0 + z0**2 + 3 z0 z1 + z1**2 has mean 4."""
    z = np.column_stack([RANDOM.normal(size=40), np.sqrt(3) * RANDOM.uniform(-1, 1, 40)])
    a, b = z.T
    slopes = np.column_stack([1 + 2 * a + 3 * b, 3 * a + 2 * b])
    y = 2 + a + a**2 + 3 * a * b + b**2
    found = fit_expansion([NORMAL, UNIFORM], z, y, slopes if with_slopes else None)
    own = np.array([1 + 2, 9 / 5 - 1])  # the fourth moment of z1 is 9 / 5
    assert (found.mean, found.variance) == pytest.approx((4, own.sum() + 9), rel=1e-11)
    assert found.shares()[0] == pytest.approx(own / (own.sum() + 9), rel=1e-11)
    assert found.shares()[1] == pytest.approx((own + 9) / (own.sum() + 9), rel=1e-11)
    assert found.values(z) == pytest.approx(y, rel=1e-11)


def test_a_constant_has_no_variance_and_no_shares():
    found = fit_expansion(
        [NORMAL] * 2, RANDOM.normal(size=(15, 2)), np.full(15, 3.0), np.zeros((15, 2))
    )
    assert (found.mean, found.variance, len(found.coefficients)) == (3.0, 0.0, 1)
    assert not np.any(found.shares())
    assert found.standard_errors == (0.0, 0.0)


def test_what_is_left_out_has_no_part_in_the_choice():
    """Other values in one part of the runs change all fits but the one without it."""
    z = np.column_stack([RANDOM.normal(size=60), np.sqrt(3) * RANDOM.uniform(-1, 1, 60)])
    y = np.exp(0.6 * z[:, 0]) + np.sin(2 * z[:, 1])
    exponents = list_exponents([6, 6], 1.0, 28)
    rows = Rows([NORMAL, UNIFORM], z, y, None, exponents)
    for part in (0, 7):
        other = np.where(rows.parts == part, 2 * y - 1, y)
        orders = []
        for values in (y, other):
            path = Rows([NORMAL, UNIFORM], z, values, None, exponents).begin(np.ones(1))[part]
            while path.extend():
                pass
            orders.append(path.order)
        assert orders[0] == orders[1]


def test_coefficients_are_those_of_least_squares_over_the_chosen_terms():
    z = np.column_stack([RANDOM.normal(size=40), np.sqrt(3) * RANDOM.uniform(-1, 1, 40)])
    y = np.exp(0.6 * z[:, 0]) + np.sin(2 * z[:, 1])
    exponents = list_exponents([6, 6], 1.0, 28)
    (found,) = Rows([NORMAL, UNIFORM], z, y, None, exponents).choose()
    table = products([NORMAL, UNIFORM], z, exponents).T
    errors = np.zeros(40)
    for part in range(11):
        kept, chosen = found.parts != part, np.flatnonzero(found.coefficients[part])
        alone = np.linalg.lstsq(table[kept][:, chosen], y[kept], rcond=None)[0]
        assert found.coefficients[part, chosen] == pytest.approx(alone, abs=1e-10)
        errors[~kept] = (y - table[:, chosen] @ alone)[~kept]
    assert found.error == pytest.approx(np.mean(errors**2), rel=1e-8)
    assert found.residuals == pytest.approx(y - table[:, chosen] @ alone, abs=1e-10)


def test_gradients_do_the_work_of_several_runs():
    """Over five normal parameters: exp(a z) has the mean exp(a a / 2), a lognormal law."""
    slope = np.array([0.3, 0.2, 0.2, 0.1, 0.3])
    z = scipy.special.ndtri(qmc.Sobol(5, seed=1).random(64))
    y = np.exp(z @ slope)
    square = slope @ slope
    expected = np.exp(square / 2)
    both = fit_expansion([NORMAL] * 5, z, y, y[:, None] * slope)
    values = fit_expansion([NORMAL] * 5, z, y)
    errors = [abs(one.mean / expected - 1) for one in (both, values)]
    assert errors[0] < 1e-3
    assert errors[0] < 0.3 * errors[1]
    variance = np.exp(square) * (np.exp(square) - 1)
    assert both.variance == pytest.approx(variance, rel=1e-2)


def test_gradients_that_contradict_the_values_are_left_out():
    """A jump is not seen by derivatives."""
    z = np.sqrt(3) * (2 * qmc.Sobol(2, seed=2).random(128) - 1)
    y = 3.0 * (z[:, 0] > 0.2) + z[:, 1]
    found = fit_expansion([UNIFORM] * 2, z, y, np.tile([0.0, 1.0], (128, 1)))
    assert not found.with_slopes
    far = np.sqrt(3) * RANDOM.uniform(-1, 1, (4000, 2))
    missed = np.mean((found.values(far) - 3.0 * (far[:, 0] > 0.2) - far[:, 1]) ** 2) / y.var()
    assert 0.5 < missed / (1 - found.q2) < 2
    assert found.q2 < 0.97


def test_noise_is_not_predicted():
    z = RANDOM.normal(size=(100, 3))
    found = fit_expansion([NORMAL] * 3, z, RANDOM.normal(size=100), RANDOM.normal(size=(100, 3)))
    assert found.q2 < 0.2


def test_standard_errors_hold_in_repetitions():
    """A kink keeps polynomials from converging: abs(z0) has the mean sqrt(2 / pi)."""
    count, missed = 100, np.zeros(2)
    mean, deviation = np.sqrt(2 / np.pi), np.sqrt(1 - 2 / np.pi + 0.25)
    for repetition in range(count):
        z = np.random.default_rng(repetition).normal(size=(100, 2))
        found = fit_expansion([NORMAL] * 2, z, np.abs(z[:, 0]) + 0.5 * z[:, 1])
        off = np.array([found.mean - mean, np.sqrt(found.variance) - deviation])
        missed += np.abs(off) > 1.96 * np.array(found.standard_errors)
    assert (missed <= 0.16 * count).all()
    assert (missed >= 0.01 * count).all()


def test_the_standard_error_of_a_quantile_holds_in_repetitions():
    """Of z0 + z1**2 / 4, with quantiles by quadrature over z1."""
    expected = scipy.optimize.brentq(
        lambda y: (
            scipy.integrate.quad(
                lambda b: (
                    scipy.special.ndtr(y - b**2 / 4) * np.exp(-(b**2) / 2) / np.sqrt(2 * np.pi)
                ),
                -9,
                9,
            )[0]
            - 0.95
        ),
        0,
        9,
    )
    many = scipy.special.ndtri(np.clip(qmc.Sobol(2, seed=0).random(2**14), 1e-9, 1 - 1e-9))
    missed, count = 0, 100
    for repetition in range(count):
        random = np.random.default_rng(repetition)
        z = random.normal(size=(60, 2))
        noise = 0.1 * random.normal(size=60)  # as if of a rough functional
        found = fit_expansion([NORMAL] * 2, z, z[:, 0] + z[:, 1] ** 2 / 4 + noise)
        values = found.values(many)
        level = float(np.quantile(values, 0.95))
        missed += abs(level - expected) > 1.96 * found.error_near(many, values, level)
    assert 0.01 * count <= missed <= 0.14 * count
