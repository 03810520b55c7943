"""Turns of the pilger mill and its reference files, computed independently with numpy and scipy."""

from pathlib import Path

import numpy as np

import lumped as lp
from lumped.models.pilger_mill import stand
from lumped.models.pilger_mill.stand import Mill

R, L, L1, E = 0.59, 4.25, 3.4, 0.33


def data(name):
    path = Path(__file__).parents[2] / "data" / "pilger_mill" / f"{name}.csv"
    return np.genfromtxt(path, delimiter=",", names=True)


def error(received, expected):
    """Largest difference over the range of the signal."""
    return np.abs(received - expected).max() / np.ptp(expected)


def turn(name, design="after", kind=Mill, degrees=None, **changes):
    w = stand.SPEED[name]
    degrees = np.arange(361.0) if degrees is None else degrees
    part = stand.mill(name, design, kind, **changes)
    return stand.revolution(stand.turn_mill(part, w * lp.time), w, degrees)
