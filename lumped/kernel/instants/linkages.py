"""Closing of linkages: Newton's method for implicit quantities at one instant."""

from __future__ import annotations

import math

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.kernel.instants.conditions import set_by_sides
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run

_MOST = 20
"""Evaluations of Newton's method from one place."""
_CLOSED = 1e-12
"""Largest last step, relative."""
_FOLLOWED = 1e-9
"""The same in a step of a run; the error is then its square."""
_TURNS = 5
"""Times that conditions are set anew from one guess."""
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
    copy_numbers(n, m[plant.settings - n :], run.first_guess)
    for k in range(DIRECTIONS):
        _place_guess(run, m, k)
        if converge(run, x, t, m):
            return True
    return False


@kernel
def close_first(run: Run) -> int:
    """Close linkages at a start; conditions on which they depend follow from the guesses.

    Gives whether they close with conditions that hold there, or at least with those at the guess.
    """
    plant = run.plant
    if plant.has_opened != 0:
        guesses = run.m[plant.settings - plant.implicit :]
        copy_numbers(plant.implicit, guesses, run.first_guess)
        for k in range(DIRECTIONS):
            _place_guess(run, run.m, k)
            _open(run)
            for _ in range(_TURNS):
                if not converge(run, run.x, run.t, run.m):
                    break
                _open(run)
                if follow(run, run.x, run.t, run.m):
                    return True
        _place_guess(run, run.m, 0)
        _open(run)
    return close(run, run.x, run.t, run.m)


@kernel
def _open(run: Run) -> None:
    """Set conditions by their sides at the guesses."""
    seen = run.instant.seen
    for _ in range(3):
        evaluate(run.plant.opened, run, run.x, run.t, run.m, seen.greater)
        set_by_sides(run.plant, seen, run.m)


@kernel
def _place_guess(run: Run, m: Numbers, k: int) -> None:
    """Guesses of a try: the first ones, or away from them."""
    plant = run.plant
    n = plant.implicit
    now, direction = m[plant.settings - n :], plant.any_direction[k * n :]
    distance = 0.0 if k == 0 else _DISTANCE[(k - 1) // _ROUNDS]
    for i in range(n):
        now[i] = run.first_guess[i] + distance * direction[i]


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
