"""What docs/analyses/identify.md shows is true."""

import re
from pathlib import Path

import numpy as np
import pytest

import lumped as lp

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "analyses" / "identify.md").read_text()
TRUTH = {"mill.T_f": 58298.95, "mill.m1": 8431.17, "shaft.J": 3000.0, "motor.T": 0.02}


@pytest.fixture(scope="module")
def shown():
    names, code = {}, re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0]
    exec(compile(code.replace("tests/data", str(ROOT / "tests" / "data")), "page", "exec"), names)
    return names


def test_it_prints_what_stands_there(shown):
    def numbers(text):
        rows = [line.split() for line in text.splitlines() if line.startswith(tuple(TRUTH))]
        return {row[0]: [float(v) for v in row[1:-1] if v != ".."] for row in rows}

    printed = numbers(re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)[0])
    received = numbers(repr(shown["found"]))
    assert set(printed) == set(TRUTH)
    for name in TRUTH:
        assert received[name] == pytest.approx(printed[name], rel=1e-4)


def test_intervals_hold_the_numbers_of_the_other_program(shown):
    found = shown["found"]
    for name, (low, high) in found.intervals.items():
        assert low <= TRUTH[name] <= high
    assert abs(found.deviation - 1) < 3 / np.sqrt(2 * 722)
    assert found.unknown == ()


def test_without_noise_they_are_found(shown):
    data = shown["data"]
    found = lp.identify(
        shown["system"],
        vary=shown["vary"],
        t=data["t_s"],
        measured={"motor.w": data["wm_rad_s"], "motor.tau": data["T_Nm"]},
        sigma=shown["noise"],
        parameters=shown["found"].start,
        start={"motor.w": shown["w"]},
        rtol=1e-9,
    )
    for name, value in TRUTH.items():
        assert found.parameters[name] == pytest.approx(value, rel=2e-7)
