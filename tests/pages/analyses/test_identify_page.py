"""What docs/analyses/identify.md shows is true."""

import re

import numpy as np
import pytest
from page_code import read_page

import lumped as lp

NAME, PRINTS = "analyses/identify", False
TRUTH = {"mill.T_f": 58298.95, "mill.m1": 8431.17, "shaft.J": 3000.0, "motor.T": 0.02}


def test_it_prints_what_stands_there(names):
    def numbers(text):
        rows = [line.split() for line in text.splitlines() if line.startswith(tuple(TRUTH))]
        return {row[0]: [float(v) for v in row[1:-1] if v != ".."] for row in rows}

    printed = numbers(re.findall(r"```text\n(.*?)```", read_page(NAME), re.DOTALL)[0])
    received = numbers(repr(names["found"]))
    assert set(printed) == set(TRUTH)
    for name in TRUTH:
        assert received[name] == pytest.approx(printed[name], rel=1e-4)


def test_intervals_hold_the_numbers_of_the_other_program(names):
    found = names["found"]
    for name, (low, high) in found.intervals.items():
        assert low <= TRUTH[name] <= high
    assert abs(found.deviation - 1) < 3 / np.sqrt(2 * 722)
    assert found.unknown == ()


def test_without_noise_they_are_found(names):
    data = names["data"]
    found = lp.identify(
        names["system"],
        vary=names["vary"],
        t=data["t_s"],
        measured={"motor.w": data["wm_rad_s"], "motor.tau": data["T_Nm"]},
        sigma=names["noise"],
        parameters=names["found"].start,
        start={"motor.w": names["w"]},
        rtol=1e-9,
    )
    for name, value in TRUTH.items():
        assert found.parameters[name] == pytest.approx(value, rel=2e-7)
