"""Damage of a load, and its derivatives by the values at which the load turns."""

from __future__ import annotations

import itertools

import numpy as np

from lumped.functionals.damage_law import DamageLaw
from lumped.timeloop.cycle_count import count_cycles, damage_of_cycles

_KEPT = 1e-13
"""Derivatives that are smaller than this part of the largest are left out."""


def damage_slopes(values: np.ndarray, law: DamageLaw, slack: float) -> tuple[float, np.ndarray]:
    """Damage, and its derivatives by turning points, shape (alternatives, n).

    There are several alternatives where less than the slack decides between them: which of two
    extremes of the same height belongs to the larger cycle, or which row of the curve holds. The
    first one is that of the values as they are.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Turning points one after the other.
    slack : float
        Accuracy of the values.
    """
    damage, nominal = _slopes(values, law)
    size = np.abs(nominal).max(initial=0.0)
    range_ = np.ptp(values) if len(values) else 0.0
    if not (size > 0 and np.isfinite(size)):
        return damage, nominal[None]
    steepest = max(slope for _, _, slope in law.rows)
    same = size * min(20 * steepest * slack / range_, 0.1)
    alternatives = [nominal]
    for moved in _move_extremes(values, slack):
        slopes = _slopes(moved, law)[1]
        if all(np.abs(slopes - known).max() > same for known in alternatives):
            alternatives.append(slopes)
    found = np.array(alternatives)
    found[np.abs(found) <= _KEPT * size] = 0.0
    return damage, found


def _slopes(values: np.ndarray, law: DamageLaw) -> tuple[float, np.ndarray]:
    """Damage, and its derivatives by turning points."""
    counted = count_cycles(values, law)
    begin, end = counted.cycles.T
    swings = values[end] - values[begin]
    means = 0.5 * (values[begin] + values[end])
    _, found = damage_of_cycles(np.abs(swings), means, counted.weights, law)
    by_swing, by_mean = np.sign(swings) * found[:, 1], 0.5 * found[:, 2]
    slopes = np.bincount(end, by_mean + by_swing, len(values))
    slopes += np.bincount(begin, by_mean - by_swing, len(values))
    return counted.damage, slopes


def _move_extremes(values: np.ndarray, slack: float) -> list[np.ndarray]:
    """The values with all crests, or all troughs, further out or in, earlier or later ones more."""
    is_crest = np.append(values[:-1] > values[1:], values[-1:] > values[-2:-1])
    rising = np.linspace(0.5, 1.0, len(values))
    shares = (rising, rising[::-1], -rising, -rising[::-1])
    return [
        values + slack * np.where(is_crest, high, -low)
        for high, low in itertools.product(shares, repeat=2)
    ]
