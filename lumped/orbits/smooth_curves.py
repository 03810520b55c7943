"""Extremes and integrals of quantities over a run, from values and exact derivatives."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.polynomial import Polynomial

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.timeloop.results.trajectory import Trajectory

_ZERO = 1e-7
"""Of its range: a quantity that is zero at the end of a smooth piece."""

_QUINTIC = np.linalg.inv(
    [[Polynomial.basis(j).deriv(d)(x) for j in range(6)] for d in range(3) for x in (0.0, 1.0)]
)
"""Coefficients of a polynomial on 0 to 1 from its values and two derivatives at both ends."""
_INSIDE = np.linspace(0, 1, 9)
_POWERS = _INSIDE ** np.arange(6)[:, None]


class Curve(NamedTuple):
    """A quantity and its time derivatives over the points of one smooth piece, each shape (k,)."""

    t: np.ndarray
    y: np.ndarray
    rate: np.ndarray
    bend: np.ndarray


class Extreme(NamedTuple):
    """A greatest or least value and when it is reached, s."""

    value: float
    time: float


def curves(run: Trajectory, expression: ca.SX) -> list[Curve]:
    """A scalar expression of the states of a run, piece by piece."""
    return curves_by(course(run.system, expression), run)


def course(system: System, expression: ca.SX) -> ca.Function:
    """A scalar expression of the states with its two time derivatives: (x, p, t, m)."""
    x, _, t, _ = system.inputs

    def rate(y: ca.SX) -> ca.SX:
        return ca.jtimes(y, ca.vertcat(x, t), ca.vertcat(system.rates, 1))

    first = rate(expression)
    every = ca.densify(ca.vertcat(expression, first, rate(first)))
    return ca.Function("curves", system.inputs, [every])


def curves_by(function: ca.Function, run: Trajectory) -> list[Curve]:
    """The same, by a function that `course` made."""
    every = zip(run.pieces, values_along(function, run), strict=True)
    return [Curve(piece.t, *values) for piece, values in every if len(piece.t) > 1]


def values_along(function: ca.Function, run: Trajectory) -> list[np.ndarray]:
    """Results of a function of (x, p, t, m) over each piece of a run, shape (results, points)."""
    found = []
    for piece in run.pieces:
        rows = function(piece.x.T, run.theta, piece.t[None, :], piece.settings.T)
        found.append(np.asarray(rows)[:, : len(piece.t)])  # for no point one is given
    return found


def extreme(pieces: list[Curve], sign: int) -> Extreme:
    """The greatest value (sign 1) or the least (-1)."""
    best = Extreme(-np.inf, 0.0)
    for piece in pieces:
        shapes = sign * _shapes(piece)
        middle = int(np.argmax((shapes @ _POWERS).max(axis=1)))
        near = range(max(middle - 1, 0), min(middle + 2, len(shapes)))
        best = max(best, *(_find_top(piece, shapes, k) for k in near), key=lambda top: top.value)
    return Extreme(sign * best.value, best.time)


def inner_lows(pieces: list[Curve]) -> list[Extreme]:
    """The lowest points between falling and rising parts of smooth pieces."""
    found = []
    for piece in pieces:
        turns = np.flatnonzero((piece.rate[:-1] < 0) & (piece.rate[1:] >= 0)).tolist()
        tops = [_find_top(piece, -_shapes(piece), k) for k in turns]
        found += [Extreme(-top.value, top.time) for top in tops]
    return found


def find_crossings(pieces: list[Curve]) -> list[tuple[float, float]]:
    """Where smooth pieces but the last end at zero: time, s, and rate there."""
    span = max((float(np.ptp(piece.y)) for piece in pieces), default=0.0)
    ends = [piece for piece in pieces[:-1] if abs(piece.y[-1]) < _ZERO * span]
    return [(float(piece.t[-1]), float(piece.rate[-1])) for piece in ends]


def _find_top(piece: Curve, shapes: np.ndarray, k: int) -> Extreme:
    """The greatest value of the polynomial of an interval, by Newton's method."""
    law = Polynomial(shapes[k])
    slope, bend = law.deriv(), law.deriv(2)
    place = near = float(_INSIDE[np.argmax(law(_INSIDE))])
    for _ in range(4):
        if bend(place) >= 0:
            break
        place = float(np.clip(place - slope(place) / bend(place), 0, 1))
    top = max(near, place, key=law)
    return Extreme(float(law(top)), float(piece.t[k] + top * (piece.t[k + 1] - piece.t[k])))


def integral(pieces: list[Curve], frequency: float = 0.0) -> complex:
    """Integral over the time of a quantity times ``exp(-j frequency t)``, frequency in rad/s.

    Euler and Maclaurin's rule on each interval, exact for polynomials of degree five.
    """
    total = 0j
    for t, y, rate, bend in pieces:
        wave, s = np.exp(-1j * frequency * t), -1j * frequency
        y2 = (bend + 2 * s * rate + s**2 * y) * wave
        y1, y0, h = (rate + s * y) * wave, y * wave, np.diff(t)
        total += np.sum(h / 2 * (y0[:-1] + y0[1:]) + h**2 / 10 * (y1[:-1] - y1[1:]))
        total += np.sum(h**3 / 120 * (y2[:-1] + y2[1:]))
    return complex(total)


def find_harmonics(pieces: list[Curve], period: float, count: int) -> np.ndarray:
    """Complex Fourier coefficients ``c_0`` to ``c_count`` of a quantity, shape (count + 1,).

    Raises
    ------
    OptionError
        If the count is less than one.
    """
    if count < 1:
        raise OptionError(f"harmonics: count = {count}: at least one.")
    w = 2 * np.pi / period
    found = np.array([integral(pieces, k * w) for k in range(count + 1)]) / period
    found[1:] *= 2
    return found


def _shapes(piece: Curve) -> np.ndarray:
    """Coefficients of the polynomial of each interval, shape (k - 1, 6)."""
    t, y, rate, bend = piece
    h = np.diff(t)
    ends = [y[:-1], y[1:], h * rate[:-1], h * rate[1:], h**2 * bend[:-1], h**2 * bend[1:]]
    return np.array(ends).T @ _QUINTIC.T
