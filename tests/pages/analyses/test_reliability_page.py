"""What docs/analyses/reliability.md shows is true."""

import re

import numpy as np
import pytest
from page_code import read_page

from lumped.models.rotary_arm.loads import FIRST, OVERLOAD
from lumped.models.rotary_arm.parts import (
    D_SHAFT,
    K_JOURNAL,
    M_ARMS,
    M_MANDREL,
    M_SHAFT,
    M_TRAYS,
    M_WEIGHTS,
    MU,
    R_H,
    R_WEIGHTS,
    RATIO,
)

NAME = "analyses/reliability"


def shares():
    """Shares of lifts that need more than each motor has, from the torque by hand."""
    g, n = 9.80665, 1_000_000
    z = np.random.default_rng(0).standard_normal((3, n))
    mu, loss = MU * K_JOURNAL * np.exp(0.2 * z[0]), 0.15 * np.exp(0.05 * z[1])
    mandrel = M_MANDREL * (1 + 0.005 * z[2])
    weight = (M_TRAYS + M_ARMS / 2 + mandrel) * R_H - M_WEIGHTS * R_WEIGHTS
    load = M_TRAYS + M_ARMS + M_SHAFT + M_WEIGHTS + mandrel
    needed = g * (weight + mu * load * D_SHAFT / 2) / (RATIO * (1 - loss))
    return {kw: (needed > OVERLOAD * FIRST * kw / 210).mean() for kw in (210, 215)}


def test_the_arm_stalls_as_often_as_by_hand(names):
    found, n, page = shares(), 1_000_000, read_page(NAME)
    for kw, share in found.items():
        told = float(re.search(rf"{kw} kW: (\S+),", page)[1])
        off = np.sqrt((1 - share) / share / n)
        print(kw, told / share - 1, "+-", off)
        assert told == pytest.approx(share, rel=0.01 + 3 * off)
    low, high = re.search(r"interval: ([\d.]+) to ([\d.]+)", page).groups()
    assert float(low) < found[210] < float(high)
    # the whole run stalls about as often
    assert names["found"].interval[0] < found[210] < names["found"].interval[1]
