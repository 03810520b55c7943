"""Newton steps shortened until they help."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


def damp_step(trial: Callable[[float], tuple[T, float]], limit: float, shortest: float) -> T | None:
    """The result of the longest part of a step, by halves, that misses less.

    Deuflhard, Newton Methods for Nonlinear Problems, Springer 2011, section 3.1.

    Parameters
    ----------
    trial : callable
        Gives, for a part of the step, a result and how far it misses; infinite if there is none.
    limit : float
        How far it may miss.
    shortest : float
        Part of the step at which to end.

    Returns
    -------
    result or None
        None if no part misses less than the limit.
    """
    part = 1.0
    while part >= shortest:
        result, missed = trial(part)
        if missed < limit:
            return result
        part /= 2
    return None
