"""Problems of Hock and Schittkowski, Test Examples for Nonlinear Programming Codes, 1981."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from lumped.ops import exp, sin


class Published(NamedTuple):
    """A problem of inequalities with its published least value.

    Attributes
    ----------
    goal : callable
        The objective of ``x1, x2, ...``.
    start, low, high : tuple of float or None
        Start and bounds of each.
    rows : callable
        What must not be negative.
    least : float
    """

    goal: Callable
    start: tuple
    low: tuple
    high: tuple
    rows: Callable
    least: float


def none(*x):
    return ()


def rosenbrock(a, b):
    return 100 * (b - a**2) ** 2 + (1 - a) ** 2


def box(*x):
    return -x[0] * x[1] * x[2]


N = None
ROOT3 = np.sqrt(3.0)
PUBLISHED = {
    1: Published(rosenbrock, (-2, 1), (N, -1.5), (N, N), none, 0.0),
    3: Published(lambda a, b: b + 1e-5 * (b - a) ** 2, (10, 1), (N, 0), (N, N), none, 0.0),
    4: Published(lambda a, b: (a + 1) ** 3 / 3 + b, (1.125, 0.125), (1, 0), (N, N), none, 8 / 3),
    5: Published(
        lambda a, b: sin(a + b) + (a - b) ** 2 - 1.5 * a + 2.5 * b + 1,
        (0, 0),
        (-1.5, -3),
        (4, 3),
        none,
        -ROOT3 / 2 - np.pi / 3,
    ),
    10: Published(
        lambda a, b: a - b,
        (-10, 10),
        (N, N),
        (N, N),
        lambda a, b: (-3 * a**2 + 2 * a * b - b**2 + 1,),
        -1.0,
    ),
    11: Published(
        lambda a, b: (a - 5) ** 2 + b**2 - 25,
        (4.9, 0.1),
        (N, N),
        (N, N),
        lambda a, b: (b - a**2,),
        -8.498464223,
    ),
    12: Published(
        lambda a, b: 0.5 * a**2 + b**2 - a * b - 7 * a - 7 * b,
        (0, 0),
        (N, N),
        (N, N),
        lambda a, b: (25 - 4 * a**2 - b**2,),
        -30.0,
    ),
    18: Published(
        lambda a, b: 0.01 * a**2 + b**2,
        (2, 2),
        (2, 0),
        (50, 50),
        lambda a, b: (a * b - 25, a**2 + b**2 - 25),
        5.0,
    ),
    19: Published(
        lambda a, b: (a - 10) ** 3 + (b - 20) ** 3,
        (20.1, 5.84),
        (13, 0),
        (100, 100),
        lambda a, b: ((a - 5) ** 2 + (b - 5) ** 2 - 100, 82.81 - (a - 6) ** 2 - (b - 5) ** 2),
        -6961.81381,
    ),
    21: Published(
        lambda a, b: 0.01 * a**2 + b**2 - 100,
        (2, -1),
        (2, -50),
        (50, 50),
        lambda a, b: (10 * a - b - 10,),
        -99.96,
    ),
    22: Published(
        lambda a, b: (a - 2) ** 2 + (b - 1) ** 2,
        (2, 2),
        (N, N),
        (N, N),
        lambda a, b: (2 - a - b, b - a**2),
        1.0,
    ),
    24: Published(
        lambda a, b: ((a - 3) ** 2 - 9) * b**3 / (27 * ROOT3),
        (1, 0.5),
        (0, 0),
        (N, N),
        lambda a, b: (a / ROOT3 - b, a + ROOT3 * b, 6 - a - ROOT3 * b),
        -1.0,
    ),
    29: Published(
        box,
        (1, 1, 1),
        (N, N, N),
        (N, N, N),
        lambda a, b, c: (48 - a**2 - 2 * b**2 - 4 * c**2,),
        -16 * np.sqrt(2.0),
    ),
    30: Published(
        lambda a, b, c: a**2 + b**2 + c**2,
        (1, 1, 1),
        (1, -10, -10),
        (10, 10, 10),
        lambda a, b, c: (a**2 + b**2 - 1,),
        1.0,
    ),
    31: Published(
        lambda a, b, c: 9 * a**2 + b**2 + 9 * c**2,
        (1, 1, 1),
        (-10, 1, -10),
        (10, 10, 1),
        lambda a, b, c: (a * b - 1,),
        6.0,
    ),
    33: Published(
        lambda a, b, c: (a - 1) * (a - 2) * (a - 3) + c,
        (0, 0, 3),
        (0, 0, 0),
        (N, N, 5),
        lambda a, b, c: (c**2 - b**2 - a**2, a**2 + b**2 + c**2 - 4),
        np.sqrt(2.0) - 6,
    ),
    34: Published(
        lambda a, b, c: -a,
        (0, 1.05, 2.9),
        (0, 0, 0),
        (100, 100, 10),
        lambda a, b, c: (b - exp(a), c - exp(b)),
        -np.log(np.log(10.0)),
    ),
    35: Published(
        lambda a, b, c: (
            9 - 8 * a - 6 * b - 4 * c + 2 * a**2 + 2 * b**2 + c**2 + 2 * a * b + 2 * a * c
        ),
        (0.5, 0.5, 0.5),
        (0, 0, 0),
        (N, N, N),
        lambda a, b, c: (3 - a - b - 2 * c,),
        1 / 9,
    ),
    36: Published(
        box,
        (10, 10, 10),
        (0, 0, 0),
        (20, 11, 42),
        lambda a, b, c: (72 - a - 2 * b - 2 * c,),
        -3300.0,
    ),
    37: Published(
        box,
        (10, 10, 10),
        (0, 0, 0),
        (42, 42, 42),
        lambda a, b, c: (72 - a - 2 * b - 2 * c, a + 2 * b + 2 * c),
        -3456.0,
    ),
    38: Published(
        lambda a, b, c, d: (
            rosenbrock(a, b)
            + 90 * (d - c**2) ** 2
            + (1 - c) ** 2
            + 10.1 * ((b - 1) ** 2 + (d - 1) ** 2)
            + 19.8 * (b - 1) * (d - 1)
        ),
        (-3, -1, -3, -1),
        (-10,) * 4,
        (10,) * 4,
        none,
        0.0,
    ),
    43: Published(
        lambda a, b, c, d: a**2 + b**2 + 2 * c**2 + d**2 - 5 * a - 5 * b - 21 * c + 7 * d,
        (0,) * 4,
        (N,) * 4,
        (N,) * 4,
        lambda a, b, c, d: (
            8 - a**2 - b**2 - c**2 - d**2 - a + b - c + d,
            10 - a**2 - 2 * b**2 - c**2 - 2 * d**2 + a + d,
            5 - 2 * a**2 - b**2 - c**2 - 2 * a + b + d,
        ),
        -44.0,
    ),
    65: Published(
        lambda a, b, c: (a - b) ** 2 + (a + b - 10) ** 2 / 9 + (c - 5) ** 2,
        (-4.5, 4.5, 0),
        (-4.5, -4.5, -5),
        (4.5, 4.5, 5),
        lambda a, b, c: (48 - a**2 - b**2 - c**2,),
        0.9535288567,
    ),
    66: Published(
        lambda a, b, c: 0.2 * c - 0.8 * a,
        (0, 1.05, 2.9),
        (0, 0, 0),
        (100, 100, 10),
        lambda a, b, c: (b - exp(a), c - exp(b)),
        0.5181632741,
    ),
    76: Published(
        lambda a, b, c, d: (
            a**2 + 0.5 * b**2 + c**2 + 0.5 * d**2 - a * c + c * d - a - 3 * b + c - d
        ),
        (0.5,) * 4,
        (0,) * 4,
        (N,) * 4,
        lambda a, b, c, d: (
            5 - a - 2 * b - c - d,
            4 - 3 * a - b - 2 * c + d,
            b + 4 * c - 1.5,
        ),
        -103 / 22,
    ),
}
