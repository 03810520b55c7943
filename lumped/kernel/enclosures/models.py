"""Polynomials of the part of a step with a bound of what they lack (Taylor models).

A model is ten numbers: eight coefficients of ``s``, which goes from -1 to 1 over the part; how far
the quantity may be from the polynomial; and the degree. What is constant has degree zero, sums are
exact, and what a product or a function has beyond degree seven goes into the bound (Makino and
Berz, Int. J. Pure Appl. Math. 4 (2003) 379). Rounding is left out: it is far below all tolerances.
"""

from __future__ import annotations

import math

from lumped.code.trigonometry import cosine, sine
from lumped.code.words import (
    Numbers,
    atan,
    atan2,
    exp,
    floor,
    hypot,
    kernel,
    log,
    power,
    sqrt,
    written,
)

__all__ = [
    "DEGREE",
    "REST",
    "SIZE",
    "TOP",
    "add",
    "atan2_of",
    "atan_of",
    "copy",
    "cosine_of",
    "exp_of",
    "high",
    "highest",
    "inverse_of",
    "is_fixed",
    "log_of",
    "low",
    "lowest",
    "power_of",
    "root_of",
    "scale",
    "set_between",
    "set_fixed",
    "shift",
    "sine_of",
    "times",
    "to_bernstein",
]

SIZE, TOP = 10, 7
"""Numbers of a model; its highest degree."""
REST, DEGREE = 8, 9
"""Places of the bound and of the degree."""
_NEAR = 0.6
"""Part of the middle value that a quantity may be off for a series of its inverse or logarithm."""
_FACTORIAL = 40320.0
_TURN = 2 * math.pi
_ODD = (1.0, -1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0)


@kernel
def set_fixed(out: Numbers, value: float) -> None:
    """What does not change."""
    out[0] = value
    out[REST] = out[DEGREE] = 0.0


@kernel
def set_between(out: Numbers, least: float, most: float) -> None:
    """Anything between two numbers."""
    middle = 0.5 * (least + most)
    if abs(middle) < math.inf:
        set_fixed(out, middle)
        out[REST] = 0.5 * (most - least)
    else:
        set_fixed(out, 0.0)
        out[REST] = math.inf


@kernel
def is_fixed(a: Numbers) -> bool:
    """Whether it does not change."""
    return a[DEGREE] == 0.0 and a[REST] == 0.0


@kernel
def copy(a: Numbers, out: Numbers) -> None:
    """The same."""
    for j in range(int(a[DEGREE]) + 1):
        out[j] = a[j]
    out[REST], out[DEGREE] = a[REST], a[DEGREE]


@kernel
def low(a: Numbers) -> float:
    """A lower bound."""
    found = a[0] - a[REST]
    for j in range(1, int(a[DEGREE]) + 1):
        if j % 2 == 1 or a[j] < 0.0:
            found -= abs(a[j])
    return found


@kernel
def high(a: Numbers) -> float:
    """An upper bound."""
    found = a[0] + a[REST]
    for j in range(1, int(a[DEGREE]) + 1):
        if j % 2 == 1 or a[j] > 0.0:
            found += abs(a[j])
    return found


@kernel
def to_bernstein(a: Numbers, b: Numbers) -> int:
    """Coefficients of the polynomial in the Bernstein basis; gives the degree."""
    top = int(a[DEGREE])
    for j in range(top + 1):
        b[j] = a[j]
    # about the begin of the part, then as long as the part
    for k in range(top):
        for j in range(top - 1, k - 1, -1):
            b[j] -= b[j + 1]
    size = 1.0
    for j in range(1, top + 1):
        size = size * 2.0 * float(j) / float(top - j + 1)
        b[j] *= size
    for k in range(1, top + 1):
        for j in range(top, k - 1, -1):
            b[j] += b[j - 1]
    return top


@kernel
def lowest(a: Numbers, room: Numbers) -> float:
    """A lower bound that is exact where the polynomial is least at an end of the part."""
    top = to_bernstein(a, room)
    found = room[0]
    for j in range(1, top + 1):
        found = min(found, room[j])
    return found - a[REST]


@kernel
def highest(a: Numbers, room: Numbers) -> float:
    """An upper bound that is exact where the polynomial is greatest at an end of the part."""
    top = to_bernstein(a, room)
    found = room[0]
    for j in range(1, top + 1):
        found = max(found, room[j])
    return found + a[REST]


@kernel
def _reach(a: Numbers) -> float:
    """How far it may be from its middle value."""
    found = a[REST]
    for j in range(1, int(a[DEGREE]) + 1):
        found += abs(a[j])
    return found


@kernel
def add(a: Numbers, b: Numbers, sign: float, out: Numbers) -> None:
    """The sum of a and a multiple of b."""
    n, m = int(a[DEGREE]), int(b[DEGREE])
    for j in range(max(n, m) + 1):
        found = a[j] if j <= n else 0.0
        out[j] = found + sign * b[j] if j <= m else found
    out[REST] = a[REST] + abs(sign) * b[REST]
    out[DEGREE] = float(max(n, m))


@kernel
def scale(a: Numbers, factor: float, out: Numbers) -> None:
    """A multiple of a."""
    for j in range(int(a[DEGREE]) + 1):
        out[j] = factor * a[j]
    out[REST] = abs(factor) * a[REST] if factor != 0.0 else 0.0
    out[DEGREE] = a[DEGREE] if factor != 0.0 else 0.0


@kernel
def shift(a: Numbers, by: float) -> None:
    """Add a number."""
    a[0] += by


def _full_product() -> str:
    """Two polynomials of the highest degree, multiplied, and how much is beyond that degree."""
    lines = ["def full_product(a: Numbers, b: Numbers, out: Numbers) -> float:"]
    for j in range(TOP + 1):
        terms = " + ".join(f"a[{i}] * b[{j - i}]" for i in range(j + 1))
        lines.append(f"    out[{j}] = {terms}")
    lines.append("    tail = rest = 0.0")
    for i in range(1, TOP + 1):
        lines += [f"    tail += abs(b[{TOP + 1 - i}])", f"    rest += abs(a[{i}]) * tail"]
    return "\n".join([*lines, "    return rest"]) + "\n"


_times_full = written("full_product", _full_product(), globals())


@kernel
def times(a: Numbers, b: Numbers, out: Numbers) -> None:
    """The product, in a place of its own."""
    n, m = int(a[DEGREE]), int(b[DEGREE])
    last, rest, tail = min(n + m, TOP), 0.0, 0.0
    if n == TOP and m == TOP:
        rest = _times_full(a, b, out)
    else:
        for j in range(last + 1):
            total = 0.0
            for i in range(max(0, j - m), min(j, n) + 1):
                total += a[i] * b[j - i]
            out[j] = total
        for i in range(max(TOP + 1 - m, 1), n + 1):
            tail += abs(b[TOP + 1 - i])
            rest += abs(a[i]) * tail
    if a[REST] + b[REST] > 0.0:
        size, other = abs(a[0]), abs(b[0])
        for j in range(1, n + 1):
            size += abs(a[j])
        for j in range(1, m + 1):
            other += abs(b[j])
        rest += a[REST] * (other + b[REST]) + size * b[REST]
    out[REST] = rest if rest >= 0.0 else math.inf
    out[DEGREE] = float(last)


@kernel
def _composed(a: Numbers, f: Numbers, rest: float, out: Numbers, room: Numbers) -> None:
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
    _composed(a, f, rest, out, room)
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
        _composed(a, f, rest, out, room)
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
        _composed(a, f, rest, out, room)
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
        _composed(a, f, f[0] * _eighth(share) / (1.0 - share), out, room)
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
        _composed(a, f, rest, out, room)
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
        _composed(a, f, rest, out, room)
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
