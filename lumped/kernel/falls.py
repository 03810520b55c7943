"""Where margins fall below zero in a step by series, from their own Taylor coefficients.

A polynomial in the Bernstein basis has at most as many roots in its interval as its coefficients
change their sign, and as many but for an even number (Descartes' rule). Halving the interval
isolates each root (Collins and Akritas, SYMSAC 1976; Lane and Riesenfeld, BIT 21 (1981) 112), so
none is missed, however short a margin is below zero. A zero counts as positive.
"""

from __future__ import annotations

from lumped.code.words import Numbers, kernel
from lumped.kernel.run import MOST_HALVINGS, Run

__all__ = ["LARGEST", "first_fall", "least", "rest"]

LARGEST = 1e300
"""Size of what is finite."""
_ROUNDING = 2.0**-48
"""Of the sum of all terms."""


@kernel
def rest(run: Run, k: int, h: float) -> float:
    """A margin at the begin of the step, less the sizes of all other terms in it: a lower bound."""
    order, row, c = run.order, run.row, run.coefficients[run.columns :]
    found, power = run.margin[k] + run.tolerance[k], h
    for j in range(1, order + 1):
        found = found - abs(c[(j + 1) * row + k]) * power * float(j + 1)
        power = power * h
    return found


@kernel
def _bernstein(run: Run, k: int, h: float) -> None:
    """Coefficients of a margin with its tolerance over the step in the Bernstein basis.

    What its terms may be off by rounding is added, lest a margin that rests at zero have roots.
    """
    order, row, c = run.order, run.row, run.coefficients[run.columns :]
    b = run.bernstein
    b[0] = run.margin[k] + run.tolerance[k]
    power, ways, size = h, float(order), abs(run.margin[k])
    for j in range(1, order + 1):
        term = c[(j + 1) * row + k] * power * float(j + 1)
        size = size + abs(term)
        b[j] = term / ways
        power = power * h
        ways = ways * float(order - j) / float(j + 1)
    b[0] = b[0] + _ROUNDING * size
    for r in range(1, order + 1):
        for i in range(order + 1 - r):
            b[order - i] += b[order - i - 1]


@kernel
def least(run: Run, k: int, h: float, bound: float) -> float:
    """The least of these coefficients, a better lower bound; `bound` if that is not finite."""
    _bernstein(run, k, h)
    b = run.bernstein
    found = b[0]
    for j in range(1, run.order + 1):
        found = min(found, b[j])
    return found if bound > -LARGEST else bound


@kernel
def _changes(b: Numbers, size: int) -> int:
    """Changes of sign."""
    found = 0
    for j in range(1, size):
        if (b[j] < 0.0) != (b[j - 1] < 0.0):
            found += 1
    return found


@kernel
def _halve(b: Numbers, left: Numbers, size: int) -> None:
    """Coefficients of both halves, by de Casteljau's algorithm; the right one takes the place."""
    left[0] = b[0]
    for r in range(1, size):
        for j in range(size - r):
            b[j] = 0.5 * (b[j] + b[j + 1])
        left[r] = b[0]


@kernel
def first_fall(run: Run, k: int, h: float) -> bool:
    """Whether a margin falls below zero in the step; leaves an interval with the first root.

    The interval is the first of `halves`. Each entry has its coefficients, begin and width.
    """
    size = run.order + 1
    _bernstein(run, k, h)
    run.bernstein[size], run.bernstein[size + 1] = 0.0, 1.0
    depth = 0
    while depth >= 0:
        b = run.bernstein[depth * (size + 2) :]
        begin, width = b[size], b[size + 1]
        changes = _changes(b, size)
        is_last = changes == 1 or depth == MOST_HALVINGS
        if is_last and b[0] >= 0.0 and b[size - 1] < 0.0:
            run.halves[0], run.halves[1] = begin, begin + width
            return True
        if changes == 0 or is_last:
            depth -= 1
        else:
            left = run.bernstein[(depth + 1) * (size + 2) :]
            _halve(b, left, size)
            left[size], left[size + 1] = begin, 0.5 * width
            b[size], b[size + 1] = begin + 0.5 * width, 0.5 * width
            depth += 1
    return False
