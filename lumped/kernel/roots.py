"""The root of a function between two points at which its signs differ.

Chandrupatla's method, Advances in Engineering Software 28 (1997) 145: the inverse parabola where it
is sure to gain, else bisection, always with a bracket. The secant is tried first.
"""

from __future__ import annotations

from lumped.code.records import Record
from lumped.code.words import kernel

_ITERATIONS, _BISECTIONS = 100, 70
"""Most points, and most after these by bisection alone."""
_ROUNDING = 2.0**-53


class Bracket(Record):
    """The last point, the other end of the bracket, the point before, and values at the three.

    The next point is a share of the way from the last one to the other end.
    """

    last: float
    at_last: float
    other: float
    at_other: float
    before: float
    at_before: float
    share: float
    points: int


@kernel
def begin_bracket(b: Bracket, last: float, at_last: float, other: float, at_other: float) -> None:
    """Begin with two points at which the signs differ."""
    b.last, b.at_last, b.other, b.at_other = last, at_last, other, at_other
    b.before, b.at_before = last, at_last
    b.share, b.points = at_last / (at_last - at_other), 0


@kernel
def next_point(b: Bracket) -> float:
    """Where the function is evaluated next."""
    return b.last + b.share * (b.other - b.last)


@kernel
def narrow(b: Bracket, x: float, value: float, near: float) -> bool:
    """Take over the value at a point; false if the root is known, but for `near` or rounding."""
    if (value < 0.0) == (b.at_last < 0.0):
        b.before, b.at_before = b.last, b.at_last
    else:
        b.before, b.at_before = b.other, b.at_other
        b.other, b.at_other = b.last, b.at_last
    b.last, b.at_last = x, value
    b.points += 1
    least = (near + 2.0 * _ROUNDING * abs(x)) / abs(b.other - x)
    if value == 0.0 or least > 0.5 or b.points >= _ITERATIONS + _BISECTIONS:
        return False
    xi = (x - b.other) / (b.before - b.other)
    phi = (value - b.at_other) / (b.at_before - b.at_other)
    share = 0.5
    is_sure = phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi
    if is_sure and b.points <= _ITERATIONS:
        share = value / (b.at_other - value) * (b.at_before / (b.at_other - b.at_before))
        way = (b.before - x) / (b.other - x)
        share += way * (value / (b.at_before - value)) * (b.at_other / (b.at_before - b.at_other))
    b.share = min(max(share, least), 1.0 - least)
    return True
