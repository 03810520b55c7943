"""Closing of linkages: Newton's method for implicit quantities at one instant."""

from __future__ import annotations

import math

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run

_MOST = 20
"""Evaluations of Newton's method from one place."""
_CLOSED = 1e-12
"""Largest last step, relative."""
_FOLLOWED = 1e-9
"""The same in a step of a run; the error is then its square."""
_DISTANCE = (0.1, 0.3, 1.0, 3.0)
_ROUNDS = 5
DIRECTIONS = 1 + len(_DISTANCE) * _ROUNDS
"""Guesses with which the search begins: the given one, then five at each distance from it."""


@kernel
def converge(run: Run, x: Numbers, t: float, m: Numbers) -> bool:
    """Newton's method from the present implicit quantities; whether it converges."""
    plant, found, correction = run.plant, run.found, run.correction
    n = plant.implicit
    now = m[plant.settings - n :]
    for _ in range(_MOST):
        evaluate(plant.closure, run, x, t, m, found)
        size, last = 0.0, 0.0
        for i in range(n):
            now[i] = found[i]
            if not abs(found[i]) < math.inf:
                return False
            size, last = max(size, abs(found[i])), max(last, abs(correction[i]))
        if last <= _CLOSED * (1.0 + size):
            return True
    return False


@kernel
def close(run: Run, x: Numbers, t: float, m: Numbers) -> bool:
    """Solve for the implicit quantities among the settings; whether they meet their equations."""
    plant = run.plant
    n = plant.implicit
    if n == 0:
        return True
    now, given = m[plant.settings - n :], run.first_guess
    copy_numbers(n, now, given)
    if converge(run, x, t, m):
        return True
    for k in range(DIRECTIONS - 1):
        direction = plant.any_direction[(1 + k) * n :]
        for i in range(n):
            now[i] = given[i] + _DISTANCE[k // _ROUNDS] * direction[i]
        if converge(run, x, t, m):
            return True
    return False


@kernel
def follow(run: Run, x: Numbers, t: float, m: Numbers) -> bool:
    """Whether one evaluation solves for the implicit quantities from those just before.

    Leaves them in `found`.
    """
    plant, found, correction, missed = run.plant, run.found, run.correction, 0.0
    evaluate(plant.closure, run, x, t, m, found)
    for i in range(plant.implicit):
        missed += 0.0 if abs(correction[i] / (1.0 + abs(found[i]))) <= _FOLLOWED else 1.0
    return missed == 0.0
