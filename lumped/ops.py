"""Functions for equations: the only ones that keep an expression symbolic."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import scipy

from lumped.errors import EquationError
from lumped.expression import (
    Call,
    Compare,
    Datum,
    Expr,
    Number,
    Periodic,
    Where,
    as_expr,
    time,
)

__all__ = [
    "acos",
    "asin",
    "atan",
    "atan2",
    "cos",
    "cosh",
    "exp",
    "interpolate",
    "log",
    "maximum",
    "minimum",
    "periodic_spline",
    "pi",
    "sign",
    "sin",
    "sinh",
    "sqrt",
    "table",
    "tan",
    "tanh",
    "where",
]

pi = 3.141592653589793
"""Ratio of a circle's circumference to its diameter."""


def sin(x: Number) -> Expr:
    """Sine; `x` in rad."""
    return Call("sin", (as_expr(x),))


def cos(x: Number) -> Expr:
    """Cosine; `x` in rad."""
    return Call("cos", (as_expr(x),))


def tan(x: Number) -> Expr:
    """Tangent; `x` in rad."""
    return Call("tan", (as_expr(x),))


def asin(x: Number) -> Expr:
    """Inverse sine in rad, between -pi/2 and pi/2."""
    return Call("asin", (as_expr(x),))


def acos(x: Number) -> Expr:
    """Inverse cosine in rad, between 0 and pi."""
    return Call("acos", (as_expr(x),))


def atan(x: Number) -> Expr:
    """Inverse tangent in rad, between -pi/2 and pi/2."""
    return Call("atan", (as_expr(x),))


def atan2(y: Number, x: Number) -> Expr:
    """Angle of the point (x, y) in rad, between -pi and pi."""
    return Call("atan2", (as_expr(y), as_expr(x)))


def sinh(x: Number) -> Expr:
    """Hyperbolic sine."""
    return Call("sinh", (as_expr(x),))


def cosh(x: Number) -> Expr:
    """Hyperbolic cosine."""
    return Call("cosh", (as_expr(x),))


def tanh(x: Number) -> Expr:
    """Hyperbolic tangent."""
    return Call("tanh", (as_expr(x),))


def sqrt(x: Number) -> Expr:
    """Square root."""
    return Call("sqrt", (as_expr(x),))


def exp(x: Number) -> Expr:
    """Exponential."""
    return Call("exp", (as_expr(x),))


def log(x: Number) -> Expr:
    """Natural logarithm."""
    return Call("log", (as_expr(x),))


def sign(x: Number) -> Expr:
    """Sign: -1, 0 or 1. The jump is not located; only for expressions that do not cross zero."""
    return Call("sign", (as_expr(x),))


def minimum(x: Number, y: Number) -> Expr:
    """The smaller of two."""
    return Call("min", (as_expr(x), as_expr(y)))


def maximum(x: Number, y: Number) -> Expr:
    """The larger of two."""
    return Call("max", (as_expr(x), as_expr(y)))


def where(condition: Compare, yes: Number, no: Number) -> Expr:
    """`yes` while the condition holds, else `no`.

    A run stops exactly where the condition changes, and starts anew with the other branch. Where
    both branches meet without a jump, `minimum`, `maximum` and `interpolate` do without a stop.

    Raises
    ------
    EquationError
        If `condition` is not a relation.
    """
    if not isinstance(condition, Compare):
        raise EquationError(
            f"where({condition!r}, ...): the condition must be a relation such as time >= 0.5."
        )
    return Where(condition, as_expr(yes), as_expr(no))


def interpolate(x: Number, xs: Sequence[float], ys: Sequence[float]) -> Expr:
    """Straight lines through points, the first and last extended; one point is a constant.

    Parameters
    ----------
    x : expression
        Where.
    xs, ys : sequence of float, shape (n,)
        Points; `xs` increasing.

    Raises
    ------
    EquationError
        If the lengths differ, there is no point, or `xs` does not increase.
    """
    places, heights = [float(v) for v in xs], [float(v) for v in ys]
    if len(places) != len(heights) or not places:
        raise EquationError(
            f"interpolate: {len(places)} places and {len(heights)} values; as many of each, at "
            "least one."
        )
    for left, right in itertools.pairwise(places):
        if not right > left:
            raise EquationError(f"interpolate: the places must increase, but {left} -> {right}.")
    argument: Expr = as_expr(x)
    total: Expr = Datum(heights[0])
    before = 0.0
    for i, (left, right) in enumerate(itertools.pairwise(places)):
        slope = (heights[i + 1] - heights[i]) / (right - left)
        run = argument - Datum(left)
        total = total + Datum(slope - before) * (maximum(0.0, run) if i else run)
        before = slope
    return total


def periodic_spline(x: Number, xs: Sequence[float], ys: Sequence[float], degree: int = 3) -> Expr:
    """Smooth curve through points of one period, repeated for ever.

    A cubic between each two points, with continuous slope and curvature everywhere; derivatives
    are exact. Its error falls with the fourth power of the distance of the points, that of degree
    5 with the sixth, for points of a smooth function. Unlike for `where`, a run does not stop where
    one piece ends.

    Source: de Boor, A Practical Guide to Splines, 1978, ch. IV.

    Parameters
    ----------
    x : expression
        Where.
    xs, ys : sequence of float, shape (n,), n > degree
        Points over one period; `xs` increasing, and the last value equal to the first.
    degree : {3, 5}
        Of the polynomials.

    Raises
    ------
    EquationError
        If the lengths differ, there are too few points, a number is not finite, `xs` does not
        increase, the last value is not the first, or the degree is another.
    """
    if degree not in (3, 5):
        raise EquationError(f"periodic_spline: degree = {degree}: 3 or 5 is needed.")
    places, heights = np.array(xs, dtype=float), np.array(ys, dtype=float)
    if places.shape != heights.shape or places.ndim != 1 or len(places) <= degree:
        raise EquationError(
            f"periodic_spline: {places.size} places and {heights.size} values; as many of each, at "
            f"least {degree + 1}."
        )
    if not (np.isfinite(places).all() and np.isfinite(heights).all()):
        raise EquationError("periodic_spline: the points must be finite numbers.")
    steps = np.diff(places)
    if not (steps > 0).all():
        i = int(np.argmin(steps))
        raise EquationError(
            f"periodic_spline: the places must increase, but {places[i]:g} -> {places[i + 1]:g}."
        )
    if abs(heights[-1] - heights[0]) > 1e-9 * max(np.ptp(heights), 1e-300):
        raise EquationError(
            f"periodic_spline: the last value {heights[-1]:g} must be the first, {heights[0]:g}; "
            "the points cover one whole period."
        )
    heights[-1] = heights[0]
    spline = scipy.interpolate.make_interp_spline(places, heights, degree, bc_type="periodic")
    curve = scipy.interpolate.PPoly.from_spline(spline)
    inside = (curve.x[:-1] >= places[0]) & (curve.x[:-1] < places[-1]) & (np.diff(curve.x) > 0)
    rows = tuple(map(tuple, curve.c.T[inside].tolist()))
    return Periodic(
        as_expr(x),
        float(places[-1] - places[0]),
        tuple(curve.x[:-1][inside].tolist()),
        rows,
    )


def table(xs: Sequence[float], ys: Sequence[float]) -> Expr:
    """Piecewise linear function of the time through points, constant outside them.

    Two points at the same time make a jump. A run stops and restarts at every point.

    Parameters
    ----------
    xs : sequence of float, shape (n,)
        Times in s, not decreasing.
    ys : sequence of float, shape (n,)
        Values at these times.

    Raises
    ------
    EquationError
        If the lengths differ, there is no point, or the times decrease.
    """
    t, y = [float(x) for x in xs], [float(v) for v in ys]
    if len(t) != len(y) or not t:
        raise EquationError(
            f"table: {len(t)} times and {len(y)} values; as many of each, at least one."
        )
    for before, after in itertools.pairwise(t):
        if not after >= before:
            raise EquationError(f"table: the times must not decrease, but {before} -> {after} s.")
    pieces: list[tuple[float, Expr]] = []
    for i in range(len(t) - 1):
        if t[i + 1] > t[i]:
            slope = (y[i + 1] - y[i]) / (t[i + 1] - t[i])
            pieces.append((t[i], Datum(y[i]) + Datum(slope) * (time - Datum(t[i]))))
    pieces.append((t[-1], Datum(y[-1])))

    def choose(low: int, high: int) -> Expr:
        """Balanced choice among pieces[low:high], the one before `low` being -1."""
        if high - low == 1:
            return Datum(y[0]) if low < 0 else pieces[low][1]
        middle = (low + high) // 2
        return Where(time >= Datum(pieces[middle][0]), choose(middle, high), choose(low, middle))

    return choose(-1, len(pieces))
