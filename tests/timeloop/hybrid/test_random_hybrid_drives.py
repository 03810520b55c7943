"""Random drives with all that is not smooth move as a reference of their own says.

``python tests/drives/random_drives.py 0 1000`` tries a thousand.
"""

import pytest
from random_drives import compare


@pytest.mark.parametrize("seed", range(6))
def test_random_drives_move_as_gauss_principle_says(seed):
    error, worth, when, method, _, events = compare(seed)
    print(f"{method}, {events} events, error {error:.1e}, reference moves by {worth:.0e}")
    assert when is None
