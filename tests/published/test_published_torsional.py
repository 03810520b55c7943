"""Natural frequencies of published trains and planetary gears."""

import numpy as np
import pytest

from benchmarks.published.torsional import (
    PLANETS,
    TRAINS,
    hertz_of,
    list_planetary,
    planetary,
)


@pytest.mark.parametrize("case", TRAINS, ids=lambda case: case.name)
def test_frequencies_are_those_published_and_recomputed(case):
    found = hertz_of(case.model())
    assert found == pytest.approx(case.recomputed, rel=2e-6)  # of their digits
    assert found[: len(case.printed)] == pytest.approx(case.printed, abs=case.digits)


@pytest.mark.parametrize("n", PLANETS)
def test_planets_have_six_pairs_and_as_many_rotations(n):
    found = hertz_of(planetary(n))
    assert found == pytest.approx(np.sort(list_planetary(n)), abs=0.051)
    repeated = np.diff(found) < 1e-6 * found[:-1]
    assert repeated.sum() == 6 + 3 * max(n - 4, 0)
