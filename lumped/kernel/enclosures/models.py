"""Polynomials of the part of a step with a bound of what they lack (Taylor models).

A model is ten numbers: eight coefficients of ``s``, which goes from -1 to 1 over the part; how far
the quantity may be from the polynomial; and the degree. What is constant has degree zero, sums are
exact, and what a product or a function has beyond degree seven goes into the bound (Makino and
Berz, Int. J. Pure Appl. Math. 4 (2003) 379). Rounding is left out: it is far below all tolerances.
"""

from __future__ import annotations

import math

from lumped.code.words import Numbers, copy_numbers, greatest_of, kernel, least_of, make_kernel

SIZE, TOP = 10, 7
"""Numbers of a model; its highest degree."""
REST, DEGREE = 8, 9
"""Places of the bound and of the degree."""


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
    copy_numbers(int(a[DEGREE]) + 1, a, out)
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
    copy_numbers(top + 1, a, b)
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
    return least_of(room, to_bernstein(a, room)) - a[REST]


@kernel
def highest(a: Numbers, room: Numbers) -> float:
    """An upper bound that is exact where the polynomial is greatest at an end of the part."""
    return greatest_of(room, to_bernstein(a, room)) + a[REST]


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


_times_full = make_kernel("full_product", _full_product(), globals())


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
