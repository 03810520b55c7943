"""Invariants of redundant coordinates: constraints that hold if they held before.

Beside them rates are infinite where they become dependent on each other, as with all links of a
parallelogram in line; so rates are taken where they hold. There the rates have a limit along the
motion, which goes through such a position on one of several branches. Near it rounding is larger
than that limit; it is interpolated from both sides of the position, along the present velocity.
"""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel, sqrt
from lumped.kernel.interpret import evaluate
from lumped.kernel.run import Run

_MOST_CHANGES = 8
_MET = 1e-3
"""Change, relative to the tolerance, that is nothing."""
NEAR, _FAR = 1e-7, 2e-5
"""Independence of invariants, squared, below which rounding counts in the rates, and where these
are taken instead."""
_DOUBLINGS = 60
_ROUNDING = 1e-13
"""Of rates, relative to the square of speeds, times the cube of the sine between invariants."""
_WEIGHTS = (56.0 / 70.0, -28.0 / 70.0, 8.0 / 70.0, -1.0 / 70.0)
"""Of values at one to four distances to each side, in the value between them, of order eight."""


@kernel
def meet_invariants(run: Run, x: Numbers, t: float) -> None:
    """Bring states back to the constraints that hold if they held before, by Newton's method.

    It converges as the square of a change, the slower the less independent constraints are. Where
    rounding would decide, states stay as they are.
    """
    n, change = run.plant.states, run.change
    copy_numbers(n, x, run.aside)
    run.independence = 1.0
    for _ in range(_MOST_CHANGES):
        evaluate(run.plant.projection, run, x, t, run.m, change)
        size = 0.0
        for i in range(n):
            x[i] += change[i]
            size = max(size, abs(change[i]) / (run.atol[i] + run.rtol * abs(x[i])))
        run.independence = min(run.independence, change[n])
        if run.independence < NEAR:
            copy_numbers(n, run.aside, x)
            return
        if size * size * run.rtol <= _MET * sqrt(change[n]):
            return


@kernel
def find_rates_on_invariants(run: Run, x: Numbers, t: float, out: Numbers) -> None:
    """Write the rates of the states where invariants hold, nearest to a point."""
    copy_numbers(run.plant.states, x, run.projected)
    meet_invariants(run, run.projected, t)
    if run.independence >= NEAR:
        evaluate(run.plant.rates, run, run.projected, t, run.m, out)
        return
    independence = max(run.independence, 1e-100)
    if _find_reach(run, x, t):
        _interpolate(run, x, t, independence, out)
    else:
        evaluate(run.plant.rates, run, x, t, run.m, out)


@kernel
def _move(run: Run, x: Numbers, h: float) -> None:
    """Go along the present velocity for a time."""
    for i in range(run.plant.states):
        run.projected[i] = x[i] + h * run.along[i]


@kernel
def _find_reach(run: Run, x: Numbers, t: float) -> bool:
    """Find the time in which invariants become independent; false if they do not, as at rest."""
    plant = run.plant
    evaluate(plant.rates, run, x, t, run.m, run.along)
    for i in range(plant.states):
        run.along[i] = run.along[i] if plant.is_moved[i] else 0.0
    reach = max(0.25 * run.reach, 1e-12 * run.span)
    for _ in range(_DOUBLINGS):
        _move(run, x, reach)
        evaluate(plant.projection, run, run.projected, t + reach, run.m, run.change)
        if run.change[plant.states] >= _FAR:
            run.reach = reach
            return True
        reach *= 2.0
    return False


@kernel
def _interpolate(run: Run, x: Numbers, t: float, independence: float, out: Numbers) -> None:
    """Write rates at a point from those at both sides.

    Where links nearly come into line they turn sharply instead, by more than rounding explains.
    """
    n, found = run.plant.states, run.aside
    for i in range(n):
        out[i] = 0.0
    for k in range(8):
        h = run.reach * float(k // 2 + 1) * (1.0 if k % 2 == 0 else -1.0)
        _move(run, x, h)
        meet_invariants(run, run.projected, t + h)
        evaluate(run.plant.rates, run, run.projected, t + h, run.m, found)
        for i in range(n):
            out[i] += _WEIGHTS[k // 2] * found[i]
    speed, apart = 0.0, 0.0
    evaluate(run.plant.rates, run, x, t, run.m, found)
    for i in range(n):
        speed = max(speed, abs(run.along[i]))
        apart = max(apart, abs(found[i] - out[i]))
    if apart > _ROUNDING * speed * speed / (independence * sqrt(independence)):
        copy_numbers(n, found, out)


@kernel
def tolerate_together(run: Run) -> None:
    """Tolerate errors relative to all states that share a constraint.

    So a length is relative to both its coordinates, whatever their directions.
    """
    plant = run.plant
    for i in range(plant.states):
        square = 0.0
        for k in range(plant.first_companion[i], plant.first_companion[i + 1]):
            square += run.x[plant.companion[k]] * run.x[plant.companion[k]]
        run.atol[i] = run.least_atol[i] + run.rtol * sqrt(square)
