"""Amplitudes at which laws hold that themselves decide how large they become."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from lumped.support.arrays import Integer, Real

Follows: TypeAlias = Callable[[Real, Integer], Real]

SETTLED = 1e-10
"""Difference between an amplitude found and that of its law, over the larger one."""
_ROUNDING = 1e-13
"""The same over the largest amplitude of all cases."""
_STEP = 0.1
"""Largest step, over the amplitude."""
_SMALL = 1e-6
"""Relative change for slopes by differences."""
_MOST = 200


def solve_amplitudes(follows: Follows, begin: Real) -> tuple[Real, Real]:
    """Solve ``follows(amplitudes) == amplitudes`` in many cases at once.

    From small amplitudes upwards in steps of a tenth at most, so that of several solutions the one
    is found that grows from rest. Steps are Newton's where they lead the same way as the difference
    itself, else that difference; where it changes its sign without becoming half as large, they
    are halved.

    Parameters
    ----------
    follows : callable
        Amplitudes that follow in some of the cases, given the amplitudes at which laws hold there,
        shapes (some, m) both, and the numbers of these cases, (some,).
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
    going, least = np.arange(len(begin)), 0.0
    for _ in range(_MOST):
        answer = follows(found[going], going)
        missing = answer - found[going]
        size = np.maximum(np.abs(found[going]), np.abs(answer))
        least = max(least, _ROUNDING / SETTLED * size.max(initial=0.0))
        scale = np.maximum(size, least)
        missed[going] = (np.abs(missing) / np.where(scale > 0, scale, 1.0)).max(axis=1, initial=0.0)
        last = before[going]
        turned = ((missing * last < 0) & (np.abs(missing) > 0.5 * np.abs(last))).any(axis=1)
        reach[going] = np.where(turned, 0.5, 1.0) * reach[going]
        before[going] = missing
        on = missed[going] > SETTLED
        going, answer, missing, scale = going[on], answer[on], missing[on], scale[on]
        if not len(going):
            break
        step = _newton(follows, going, found[going], answer, missing, scale)
        limit = reach[going, None] * scale
        found[going] = np.maximum(found[going] + np.clip(step, -limit, limit), 0.0)
    return found, missed


def _newton(
    follows: Follows, cases: Integer, found: Real, answer: Real, missing: Real, scale: Real
) -> Real:
    """Newton's steps, or what is missing where these lead another way."""
    count = found.shape[1]
    slopes = np.empty((len(found), count, count))
    for j in range(count):
        moved, width = found.copy(), _SMALL * scale[:, j]
        moved[:, j] += width
        slopes[:, :, j] = (follows(moved, cases) - answer) / width[:, None]
    matrix = np.eye(count) - slopes
    good = (np.linalg.eigvals(matrix).real > 0).all(axis=1)
    step = missing.copy()
    step[good] = np.linalg.solve(matrix[good], missing[good][..., None])[..., 0]
    return step
