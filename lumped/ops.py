"""Functions for equations: the only ones that keep an expression symbolic."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TypeVar

import numpy as np
import scipy

from lumped.errors import EquationError, shown
from lumped.language.arithmetic import Arithmetic
from lumped.language.expression import (
    Compare,
    Datum,
    Expr,
    Number,
    Piecewise,
    Ref,
    Smooth,
    Time,
    Where,
    as_expr,
    time,
    walk,
)
from lumped.language.pieces import Pieces
from lumped.language.value_types import Numbers
from lumped.support.arguments import checked

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
    "smooth",
    "sqrt",
    "table",
    "tan",
    "tanh",
    "where",
]

T = TypeVar("T")

pi = 3.141592653589793
"""Ratio of a circle's circumference to its diameter."""


def _call(op: str, *operands: Arithmetic[T] | float) -> T:
    """A function applied to operands, in the arithmetic to which they belong."""
    kinds = [type(each) for each in operands if isinstance(each, Arithmetic)]
    own = next((kind for kind in kinds if not issubclass(kind, Expr)), Expr)
    found: T = own.apply(op, operands)  # type: ignore[assignment]
    return found


def sin(x: Arithmetic[T] | float) -> T:
    """Sine; `x` in rad."""
    return _call("sin", x)


def cos(x: Arithmetic[T] | float) -> T:
    """Cosine; `x` in rad."""
    return _call("cos", x)


def tan(x: Arithmetic[T] | float) -> T:
    """Tangent; `x` in rad."""
    return _call("tan", x)


def asin(x: Arithmetic[T] | float) -> T:
    """Inverse sine in rad, between -pi/2 and pi/2."""
    return _call("asin", x)


def acos(x: Arithmetic[T] | float) -> T:
    """Inverse cosine in rad, between 0 and pi."""
    return _call("acos", x)


def atan(x: Arithmetic[T] | float) -> T:
    """Inverse tangent in rad, between -pi/2 and pi/2."""
    return _call("atan", x)


def atan2(y: Arithmetic[T] | float, x: Arithmetic[T] | float) -> T:
    """Angle of the point (x, y) in rad, between -pi and pi."""
    return _call("atan2", y, x)


def sinh(x: Arithmetic[T] | float) -> T:
    """Hyperbolic sine."""
    return _call("sinh", x)


def cosh(x: Arithmetic[T] | float) -> T:
    """Hyperbolic cosine."""
    return _call("cosh", x)


def tanh(x: Arithmetic[T] | float) -> T:
    """Hyperbolic tangent."""
    return _call("tanh", x)


def sqrt(x: Arithmetic[T] | float) -> T:
    """Square root."""
    return _call("sqrt", x)


def exp(x: Arithmetic[T] | float) -> T:
    """Exponential."""
    return _call("exp", x)


def log(x: Arithmetic[T] | float) -> T:
    """Natural logarithm."""
    return _call("log", x)


def sign(x: Arithmetic[T] | float) -> T:
    """Sign: -1, 0 or 1; a run stops where it changes."""
    return _call("sign", x)


def minimum(x: Arithmetic[T] | float, y: Arithmetic[T] | float) -> T:
    """The smaller of two; a run stops where the other one becomes it."""
    return _call("min", x, y)


def maximum(x: Arithmetic[T] | float, y: Arithmetic[T] | float) -> T:
    """The larger of two; a run stops where the other one becomes it."""
    return _call("max", x, y)


def where(condition: Compare, yes: Number, no: Number) -> Expr:
    """`yes` while the condition holds, else `no`.

    A run stops exactly where the condition changes, and starts anew with the other branch. So do
    ``abs(x)``, `sign`, `minimum`, `maximum`, `interpolate` and `table`, which mean the same as the
    `where` that says what they do; see `smooth`. ``condition.called("closed", "open")`` gives the
    words in which events tell the change.

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


def smooth(x: Number) -> Expr:
    """The same value, but a run does not stop where a part of it has a kink.

    For kinks too small to matter, or so many that stops would cost more than the short steps
    around them. Steps keep their tolerance; derivatives are those of the piece that a step is in,
    and what the run's derivatives lose where a step passes a kink is not told. Points of a table of
    time, which are known before a run, are met one by one all the same, but tell no events.
    """
    return Smooth(as_expr(x))


def interpolate(
    x: Number,
    xs: Numbers,
    ys: Sequence[Number] | np.ndarray,
    *,
    period: float | None = None,
) -> Expr:
    """Straight lines through points, the first and last extended; one point is a constant.

    With a period the lines repeat for ever. Where the last place is a period after the first, both
    values count, and a difference between them is a jump; else a line closes the period.

    A run stops where one line meets the next. Of many lines it watches only the one it is on.

    Parameters
    ----------
    x : expression
        Where.
    xs : sequence of float, shape (n,)
        Places, increasing.
    ys : sequence of float or expression, shape (n,)
        Values there; parameters may stand in them, but for a period.
    period : float, optional
        Of the lines, at least from the first place to the last.

    Raises
    ------
    EquationError
        If the lengths differ, there is no point, a number is not finite, `xs` does not increase, or
        it is longer than the period.
    """
    if any(isinstance(given, Expr) for given in (xs, ys)):
        raise EquationError(
            f"interpolate({shown(x)}, {shown(xs)}, {shown(ys)}): the expression comes first, then "
            "the places and the values, such as interpolate(w, [0, 100], [5, 2])."
        )
    places = _numbers("interpolate", "place", xs)
    if len(places) != len(ys) or not places:
        raise EquationError(
            f"interpolate: {len(places)} places and {len(ys)} values; as many of each, at "
            "least one."
        )
    for left, right in itertools.pairwise(places):
        if not right > left:
            raise EquationError(f"interpolate: the places must increase, but {left} -> {right}.")
    argument = as_expr(x)
    if period is not None:
        return _repeated(argument, places, _numbers("interpolate", "value", ys), period)
    if any(isinstance(y, Expr) for y in ys):
        return _with_heights(argument, places, [as_expr(y) for y in ys])
    heights = _numbers("interpolate", "value", ys)
    if len(places) == 1:
        return Datum(heights[0])
    slopes = (np.diff(heights) / np.diff(places)).tolist()
    new = [i == 0 or slopes[i] != slopes[i - 1] for i in range(len(slopes))]
    kept = [i for i in range(len(slopes)) if new[i]]
    rows = tuple((slopes[i], heights[i]) for i in kept)
    return Piecewise(argument, Pieces(tuple(places[i] for i in kept), rows))


def _repeated(argument: Expr, places: list[float], heights: list[float], period: float) -> Expr:
    length = places[-1] - places[0]
    if not 0 < period < float("inf") or length > period * (1 + 1e-9):
        raise EquationError(
            f"interpolate: the places cover {length:g}, which is longer than the period {period:g}."
        )
    if len(places) == 1:
        return Datum(heights[0])
    if length < period * (1 - 1e-9):
        places, heights = [*places, places[0] + period], [*heights, heights[0]]
    slopes = (np.diff(heights) / np.diff(places)).tolist()
    rows = tuple(zip(slopes, heights[:-1], strict=True))
    return Piecewise(argument, Pieces(tuple(places[:-1]), rows, period))


def _with_heights(argument: Expr, places: list[float], heights: list[Expr]) -> Expr:
    for height in heights:
        if any(isinstance(node, Time | Ref) and not _is_parameter(node) for node in walk(height)):
            raise EquationError(
                f"interpolate: the value '{height}' changes during a run; values are numbers or "
                "expressions of parameters."
            )
    if len(places) == 1:
        return heights[0]
    rows = tuple((1.0 / length,) for length in np.diff(places).tolist())
    return Piecewise(argument, Pieces(tuple(places[:-1]), rows), tuple(heights))


def _is_parameter(node: Expr) -> bool:
    return isinstance(node, Ref) and bool(node.quantity.kind == "parameter")


def _numbers(name: str, what: str, values: Sequence[Number] | np.ndarray) -> list[float]:
    """Finite numbers of a table."""
    try:
        found = [float(v) for v in values]
    except (TypeError, ValueError) as error:
        raise EquationError(f"{name}: each {what} must be a number. {error}") from None
    for i, value in enumerate(found):
        if not np.isfinite(value):
            raise EquationError(f"{name}: {what} {i} is {value}; finite numbers are needed.")
    return found


def periodic_spline(x: Number, xs: Numbers, ys: Numbers, *, degree: int = 3) -> Expr:
    """Smooth curve through points of one period, repeated for ever.

    A cubic between each two points, with continuous slope and curvature everywhere; derivatives
    are exact. Its error falls with the fourth power of the distance of the points, that of degree
    5 with the sixth, for points of a smooth function. Where the argument depends on states, a run
    does not stop where one piece ends; where it is a function of time and parameters, it does.

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
    begins = tuple(curve.x[:-1][inside].tolist())
    return Piecewise(as_expr(x), Pieces(begins, rows, float(places[-1] - places[0])))


@checked
def table(xs: Numbers, ys: Numbers) -> Expr:
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
        If the lengths differ, there is no point, a number is not finite, or the times decrease.
    """
    t, y = _numbers("table", "time", xs), _numbers("table", "value", ys)
    if len(t) != len(y) or not t:
        raise EquationError(
            f"table: {len(t)} times and {len(y)} values; as many of each, at least one."
        )
    for before, after in itertools.pairwise(t):
        if not after >= before:
            raise EquationError(f"table: the times must not decrease, but {before} -> {after} s.")
    pieces = [(t[0] - 1.0, 0.0, y[0])]
    for i in range(len(t) - 1):
        if t[i + 1] > t[i]:
            pieces.append((t[i], (y[i + 1] - y[i]) / (t[i + 1] - t[i]), y[i]))
    pieces.append((t[-1], 0.0, y[-1]))
    return Piecewise(time, Pieces(tuple(p[0] for p in pieces), tuple(p[1:] for p in pieces)))
