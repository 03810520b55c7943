"""Amplitudes at which laws hold that themselves decide how large they become."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

__all__ = ["SETTLED", "settled_amplitudes"]

Real = NDArray[np.float64]

SETTLED = 1e-10
"""Difference between an amplitude found and that of its law, over the larger one."""
_ROUNDING = 1e-13
"""The same over the largest amplitude of all cases."""
_STEP = 0.1
"""Largest step, over the amplitude."""
_SMALL = 1e-6
"""Relative change for slopes by differences."""
_MOST = 200


def settled_amplitudes(follows: Callable[[Real], Real], begin: Real) -> tuple[Real, Real]:
    """Solve ``follows(amplitudes) == amplitudes`` in many cases at once.

    From small amplitudes upwards in steps of a tenth at most, so that of several solutions the one
    is found that grows from rest. Steps are Newton's where they lead the same way as the difference
    itself, else that difference; where it changes its sign without becoming half as large, they
    are halved.

    Parameters
    ----------
    follows : callable
        Amplitudes that follow if laws hold at given ones, shapes (k, m) both; each case by itself.
    begin : ndarray, shape (k, m)
        First amplitudes.

    Returns
    -------
    ndarray, ndarray, shapes (k, m) and (k,)
        Amplitudes, and the difference that is left, over the larger amplitude; above `SETTLED`
        where none were found.
    """
    found, reach = begin.copy(), np.full(len(begin), _STEP)
    before = np.zeros_like(found)
    missed = np.full(len(begin), np.inf)
    for _ in range(_MOST):
        answer = follows(found)
        missing = answer - found
        size = np.maximum(np.abs(found), np.abs(answer))
        scale = np.maximum(size, _ROUNDING / SETTLED * size.max(initial=0.0))
        missed = (np.abs(missing) / np.where(scale > 0, scale, 1.0)).max(axis=1, initial=0.0)
        going = missed > SETTLED
        if not going.any():
            break
        turned = ((missing * before < 0) & (np.abs(missing) > 0.5 * np.abs(before))).any(axis=1)
        reach = np.where(turned, 0.5 * reach, reach)
        step = _newton(follows, found, answer, missing, scale)
        limit = reach[:, None] * scale
        step = np.where(going[:, None], np.clip(step, -limit, limit), 0.0)
        before, found = missing, np.maximum(found + step, 0.0)
    return found, missed


def _newton(
    follows: Callable[[Real], Real], found: Real, answer: Real, missing: Real, scale: Real
) -> Real:
    """Newton's steps, or what is missing where these lead another way."""
    count = found.shape[1]
    slopes = np.empty((len(found), count, count))
    for j in range(count):
        moved, width = found.copy(), _SMALL * scale[:, j]
        moved[:, j] += width
        changed = follows(moved) - answer
        slopes[:, :, j] = changed / np.where(width > 0, width, 1.0)[:, None]
    matrix = np.eye(count) - slopes
    values = np.linalg.eigvals(matrix)
    good = (values.real > 0).all(axis=1)
    step = missing.copy()
    step[good] = np.linalg.solve(matrix[good], missing[good][..., None])[..., 0]
    return step
