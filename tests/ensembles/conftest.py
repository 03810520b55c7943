"""What several files of this folder run."""

import pytest
from oscillator import oscillator


@pytest.fixture(scope="module")
def system():
    return oscillator()
