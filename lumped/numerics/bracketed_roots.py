"""Zeros of several functions at once, each between two points at which its signs differ."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

_MOST = 200
_CLOSE = 1e-9
"""Part of a bracket that the secant rule moves in its last step: the error is its square then,"""
_FAST = 0.01
"""if the value has become so many times smaller."""


def find_bracketed_roots(
    function: Callable[[np.ndarray, np.ndarray], np.ndarray],
    begin: np.ndarray,
    end: np.ndarray,
    at_begin: np.ndarray,
    at_end: np.ndarray,
    accuracy: np.ndarray,
) -> np.ndarray:
    """Where functions are zero, shape (k,).

    The secant rule with the weights of Anderson and Bjorck, BIT 13 (1973) 253; where it does not
    halve a bracket in three steps, that is bisected.

    Parameters
    ----------
    function : callable
        Numbers of functions, and where they are evaluated, shape (j,) each, to their values.
    begin, end, at_begin, at_end : ndarray, shape (k,)
        Brackets, and the values at their ends, of opposite signs.
    accuracy : ndarray, shape (k,)
        Width of a bracket that is narrow enough.
    """
    a, b, f_a, f_b = (np.array(v, dtype=float) for v in (begin, end, at_begin, at_end))
    is_nearer = np.abs(f_a) < np.abs(f_b)
    best: np.ndarray
    best, at_best = np.where(is_nearer, (a, f_a), (b, f_b))
    first, width, was_low = b - a, b - a, np.full(len(a), -1)
    for step in range(_MOST):
        open_ones = np.flatnonzero((b - a > 2 * accuracy) & (at_best != 0))
        if not len(open_ones):
            break
        low, high, f_low, f_high = (v[open_ones] for v in (a, b, f_a, f_b))
        inner = low - f_low * (high - low) / (f_high - f_low)
        slow = (step % 3 == 2) & (high - low > 0.5 * width[open_ones])
        inner[slow] = 0.5 * (low + high)[slow]
        if step % 3 == 2:
            width[open_ones] = high - low
        # near an end, the other side of the zero is sought
        inner = np.clip(inner, low + accuracy[open_ones], high - accuracy[open_ones])
        f = function(open_ones, inner)
        before = at_best[open_ones]
        with np.errstate(divide="ignore", invalid="ignore"):  # equal values tell nothing
            move = -f * (inner - best[open_ones]) / (f - before)
        last = (np.abs(move) <= _CLOSE * first[open_ones]) & (np.abs(f) <= _FAST * np.abs(before))
        last &= ~slow
        closer = last | (np.abs(f) < np.abs(before))
        own = open_ones[closer]
        best[own], at_best[own] = (inner + np.where(last, move, 0.0))[closer], f[closer]
        at_best[open_ones[last]] = 0.0
        is_low = np.sign(f) == np.sign(f_low)
        weight = 1 - f / np.where(is_low, f_low, f_high)
        weight = np.where(weight > 0, weight, 0.5)
        # an end that stays twice counts for less
        weight[is_low != was_low[open_ones]] = 1.0
        a[open_ones], f_a[open_ones] = np.where(is_low, (inner, f), (low, weight * f_low))
        b[open_ones], f_b[open_ones] = np.where(is_low, (high, weight * f_high), (inner, f))
        was_low[open_ones] = is_low
    # at a jump no value is smaller than those at the ends
    is_jump = (at_best != 0) & ((best < a) | (best > b))
    return np.where(is_jump, 0.5 * (a + b), best)
