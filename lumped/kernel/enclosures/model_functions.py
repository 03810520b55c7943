"""Functions of models: sine, inverse, powers, roots, exponentials and angles."""

from __future__ import annotations

import math

from lumped.code.trigonometry import cosine, sine
from lumped.code.words import Numbers, atan, atan2, exp, floor, hypot, kernel, log, power, sqrt
from lumped.kernel.enclosures.models import (
    DEGREE,
    REST,
    SIZE,
    TOP,
    add,
    copy,
    high,
    low,
    scale,
    set_between,
    set_fixed,
    times,
)

_NEAR = 0.6
"""Part of the middle value that a quantity may be off for a series of its inverse or logarithm."""
_FACTORIAL = 40320.0
_TURN = 2 * math.pi
_ODD = (1.0, -1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0)


@kernel
def _reach(a: Numbers) -> float:
    """How far it may be from its middle value."""
    found = a[REST]
    for j in range(1, int(a[DEGREE]) + 1):
        found += abs(a[j])
    return found


@kernel
def _compose(a: Numbers, f: Numbers, rest: float, out: Numbers, room: Numbers) -> None:
    """A function of a from its Taylor coefficients at the middle and a bound of what they lack."""
    middle = a[0]
    a[0] = 0.0
    set_fixed(out, f[TOP])
    for j in range(TOP - 1, -1, -1):
        times(out, a, room)
        copy(room, out)
        out[0] += f[j]
    a[0] = middle
    out[REST] += rest


@kernel
def _eighth(q: float) -> float:
    fourth = (q * q) * (q * q)
    return fourth * fourth


@kernel
def _wave(a: Numbers, s: float, c: float, out: Numbers, room: Numbers) -> bool:
    """A sine from its value and slope at the middle; whether a series is good enough."""
    rest = _eighth(_reach(a)) / _FACTORIAL
    if not rest < 0.5:
        return False
    f, factor = room[SIZE:], 1.0
    for j in range(TOP + 1):
        value = s if j % 2 == 0 else c
        f[j] = value * factor if j % 4 < 2 else -(value * factor)
        factor = factor / float(j + 1)
    _compose(a, f, rest, out, room)
    return True


@kernel
def _wave_between(a: Numbers, first: float, last: float, top: float, out: Numbers) -> None:
    """A sine over a range from its values at both ends, with maxima at `top` and each turn on."""
    begin, end = (low(a) - top) / _TURN, (high(a) - top) / _TURN
    least, most = min(first, last), max(first, last)
    if not end - begin < 1.0 or floor(end) > floor(begin):
        most = 1.0
    if not end - begin < 1.0 or floor(end - 0.5) > floor(begin - 0.5):
        least = -1.0
    set_between(out, least, most)


@kernel
def sine_of(a: Numbers, out: Numbers, room: Numbers) -> None:
    """Sine."""
    if not _wave(a, sine(a[0]), cosine(a[0]), out, room):
        _wave_between(a, sine(low(a)), sine(high(a)), 0.25 * _TURN, out)


@kernel
def cosine_of(a: Numbers, out: Numbers, room: Numbers) -> None:
    """Cosine."""
    if not _wave(a, cosine(a[0]), -sine(a[0]), out, room):
        _wave_between(a, cosine(low(a)), cosine(high(a)), 0.0, out)


@kernel
def inverse_of(a: Numbers, out: Numbers, room: Numbers) -> None:
    """One over it."""
    middle, q = a[0], _reach(a)
    if q < _NEAR * abs(middle):
        f, value = room[SIZE:], 1.0 / middle
        share = q * abs(value)
        rest = abs(value) * _eighth(share) / (1.0 - share)
        for j in range(TOP + 1):
            f[j] = value
            value = -(value / middle)
        _compose(a, f, rest, out, room)
    elif low(a) > 0.0 or high(a) < 0.0:
        set_between(out, 1.0 / high(a), 1.0 / low(a))
    else:
        set_between(out, -math.inf, math.inf)


@kernel
def power_of(a: Numbers, p: float, out: Numbers, room: Numbers) -> None:
    """A fixed power."""
    middle, q = a[0], _reach(a)
    is_whole = p == floor(p) and p >= 0.0
    f, ways = room[SIZE:], 1.0
    if (is_whole and p <= float(TOP)) or q < _NEAR * middle:
        for j in range(TOP + 1):
            # binomial coefficients of whole powers end
            f[j] = ways * power(middle, p - float(j)) if ways != 0.0 else 0.0
            ways = ways * (p - float(j)) / float(j + 1)
        rest = 0.0
        if ways != 0.0:
            least = power(middle - q, p - float(TOP + 1))
            rest = abs(ways) * max(least, power(middle + q, p - float(TOP + 1))) * _eighth(q)
        _compose(a, f, rest, out, room)
    elif is_whole:
        first, last = power(low(a), p), power(high(a), p)
        crosses = low(a) < 0.0 and high(a) > 0.0
        least = min(first, last)
        is_even = floor(0.5 * p) == 0.5 * p
        set_between(out, 0.0 if crosses and is_even else least, max(first, last))
    elif low(a) > 0.0 or (low(a) >= 0.0 and p > 0.0):
        first, last = power(low(a), p), power(high(a), p)
        set_between(out, min(first, last), max(first, last))
    else:
        set_between(out, -math.inf, math.inf)


@kernel
def root_of(a: Numbers, out: Numbers, room: Numbers) -> None:
    """Square root."""
    middle, q = a[0], _reach(a)
    if q < _NEAR * middle:
        f, share = room[SIZE:], q / middle
        f[0] = sqrt(middle)
        for j in range(1, TOP + 1):
            f[j] = f[j - 1] * (1.5 - float(j)) / (float(j) * middle)
        _compose(a, f, f[0] * _eighth(share) / (1.0 - share), out, room)
    else:
        set_between(out, sqrt(max(low(a), 0.0)), sqrt(max(high(a), 0.0)))


@kernel
def exp_of(a: Numbers, out: Numbers, room: Numbers) -> None:
    """Exponential."""
    q = _reach(a)
    rest = _eighth(q) / _FACTORIAL * exp(q)
    if rest < 1.0:
        f, value = room[SIZE:], exp(a[0])
        rest = rest * value
        for j in range(TOP + 1):
            f[j] = value
            value = value / float(j + 1)
        _compose(a, f, rest, out, room)
    else:
        set_between(out, exp(low(a)), exp(high(a)))


@kernel
def log_of(a: Numbers, out: Numbers, room: Numbers) -> None:
    """Natural logarithm."""
    middle, q = a[0], _reach(a)
    if q < _NEAR * middle:
        f, value, share = room[SIZE:], -1.0, q / middle
        f[0] = log(middle)
        for j in range(1, TOP + 1):
            value = -(value / middle)
            f[j] = value / float(j)
        rest = _eighth(share) / (float(TOP + 1) * (1.0 - share))
        _compose(a, f, rest, out, room)
    elif low(a) > 0.0:
        set_between(out, log(low(a)), log(high(a)))
    else:
        set_between(out, -math.inf, math.inf)


@kernel
def atan_of(a: Numbers, out: Numbers, room: Numbers) -> None:
    """Inverse tangent, from that of the middle and ``(x - c) / (1 + c x)``."""
    c = a[0]
    below, w, square = room[2 * SIZE :], room[3 * SIZE :], room[4 * SIZE :]
    scale(a, c, below)
    below[0] += 1.0
    inverse_of(below, out, room)
    a[0] = 0.0
    times(a, out, w)
    a[0] = c
    q = _reach(w) + abs(w[0])
    if q < 0.5:
        times(w, w, square)
        set_fixed(out, _ODD[3])
        for j in range(2, -1, -1):
            times(out, square, room)
            copy(room, out)
            out[0] += _ODD[j]
        times(out, w, room)
        copy(room, out)
        out[0] += atan(c)
        out[REST] += _eighth(q) * q / 9.0
    else:
        set_between(out, atan(low(a)), atan(high(a)))


@kernel
def atan2_of(y: Numbers, x: Numbers, out: Numbers, room: Numbers) -> None:
    """Angle of a point, turned so that its middle lies on the axis; it jumps on the axis behind."""
    size = hypot(x[0], y[0])
    c, s = x[0] / size, y[0] / size
    ahead, beside = room[5 * SIZE :], room[6 * SIZE :]
    scale(x, c, room)
    add(room, y, s, ahead)
    scale(y, c, room)
    add(room, x, -s, beside)
    is_ahead = low(ahead) > 0.0
    if is_ahead:
        inverse_of(ahead, out, room)
        times(beside, out, ahead)
        atan_of(ahead, out, room)
        out[0] += atan2(s, c)
    if not (is_ahead and high(out) <= 0.5 * _TURN and low(out) >= -0.5 * _TURN):
        set_between(out, -0.5 * _TURN, 0.5 * _TURN)
