"""Random drives by all methods, in machine code, as exported units, and with their derivatives."""

import shutil

import numpy as np
import pytest
from all_ways import Ways, drives, some_parameters

DRIVES = 3


@pytest.fixture(scope="module")
def scenes():
    return list(drives(DRIVES))


@pytest.mark.parametrize("k", range(DRIVES))
def test_all_ways_of_a_random_drive_agree_or_refuse(scenes, k, tmp_path):
    ways = Ways(scenes[k])
    ways.methods()
    ways.derivatives(some_parameters(scenes[k].system, np.random.default_rng(k)))
    if k == 0 and shutil.which("cc"):
        ways.unit(tmp_path)
    print(ways.found)
    agreed = [way for way, verdict in ways.found.items() if verdict == "agrees"]
    assert len(agreed) >= 3
    assert not [way for way in ways.found.items() if way[1].split()[0] in ("DEVIATES", "RAW")]
