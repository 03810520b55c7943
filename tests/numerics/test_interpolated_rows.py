import numpy as np
import pytest

from lumped.numerics.interpolated_rows import fit_rows, interpolate_rows

PLACES = np.sort(np.random.default_rng(1).uniform(5.0, 300.0, 900))


@pytest.mark.parametrize(
    ("law", "most"),
    [
        (lambda x: np.array([1.0, x**2, 3 - 1e-3 * x**3]), 9),
        (lambda x: np.array([np.sin(x / 40), np.exp(-x / 100), 1 / (x + 20)]), 120),
        (lambda x: np.array([max(x - 111.0, 0.0) ** 2, x, 1.0]), 250),
        (lambda x: np.array([float(x > 200.0), x, 1.0]), 250),
    ],
)
def test_rows_between_those_computed_are_theirs(law, most):
    asked = []

    def row(k):
        asked.append(k)
        found = law(PLACES[k])
        return found, np.abs(found)

    found = interpolate_rows(row, PLACES)
    wanted = np.array([law(x) for x in PLACES])
    error = np.abs(found - wanted) / np.abs(wanted).max(axis=0)
    assert error.max() < 1e-9
    assert len(asked) == len(set(asked)) <= most


@pytest.mark.parametrize("count", [1, 2, 16, 17, 18, 40, 100])
def test_short_grids(count):
    places = np.arange(count) + 1.0
    found = interpolate_rows(lambda k: (np.array([places[k] ** 2]), np.ones(1)), places)
    np.testing.assert_allclose(found[:, 0], places**2, rtol=1e-13)


@pytest.mark.parametrize(
    ("law", "most"),
    [
        (lambda x, y: np.array([1.0, x * y + 3 * x**2, y - 1e-3 * x]), 10),
        (lambda x, y: np.array([np.exp(-x / 2000) * np.cos(y / 5), 1 / (x + 4000)]), 80),
        (lambda x, y: np.array([abs(y - 0.3), x, 1.0]), len(PLACES)),
    ],
)
@pytest.mark.parametrize(
    "path", [lambda x: np.interp(x, (5, 80, 90, 300), (0, 1, 0.2, 0.7)), np.zeros_like]
)
def test_rows_that_follow_two_numbers(law, most, path):
    places = np.column_stack([PLACES, path(PLACES)])
    asked = []

    def row(k):
        asked.append(k)
        found = law(*places[k])
        return found, np.abs(found)

    found = fit_rows(row, places)
    wanted = np.array([law(*pair) for pair in places])
    error = np.abs(found - wanted) / np.abs(wanted).max(axis=0)
    assert error.max() < 1e-9
    assert len(asked) == len(set(asked)) <= most


@pytest.mark.parametrize("count", [1, 2, 23, 24, 40])
def test_few_rows_that_follow_two_numbers(count):
    places = np.column_stack([np.arange(count) + 1.0, np.sin(np.arange(count))])
    found = fit_rows(lambda k: (places[k] ** 2, np.ones(2)), places)
    np.testing.assert_allclose(found, places**2, atol=1e-12 * count**2)
