import numpy as np
import pytest

from lumped.numerics.interpolated_rows import interpolate_rows

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
