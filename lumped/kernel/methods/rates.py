"""Rates of the states in a step, in which redundant constraints do not move.

Redundant constraints share what they carry as if each yielded a little
(`lumped.kernel.instants.yielding`). With what they then carry as their share, they yield some 1e-8
times less: a proximal step (Rockafellar, SIAM Journal on Control and Optimization 14 (1976) 877).
"""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.flattening.hold_modes import SHARE
from lumped.kernel.instants.holds import is_shared
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.invariants import (
    find_rates_on_invariants,
    meet_invariants,
    tolerate_together,
)
from lumped.kernel.run import Run


@kernel
def note_sharing(run: Run) -> None:
    """Note whether constraints share a load: states of any body may follow what these yield."""
    run.shares = 0
    for h in range(run.plant.holds):
        if is_shared(run.plant, run.m, h):
            run.shares = 1


@kernel
def _find_exact_rates(run: Run, x: Numbers, t: float, out: Numbers) -> None:
    plant, look, exact = run.plant, run.instant.pushed, run.instant.sole
    evaluate(plant.look, run, x, t, run.m, look.greater)
    copy_numbers(plant.settings, run.m, exact)
    for h in range(plant.holds):
        if is_shared(plant, exact, h):
            exact[plant.hold_setting[h] + SHARE] = look.reaction[h]
    evaluate(plant.rates, run, x, t, exact, out)


@kernel
def find_rates(run: Run, x: Numbers, t: float, out: Numbers) -> None:
    """Write the rates of the states at a point; those with invariants where these hold."""
    if run.shares:
        _find_exact_rates(run, x, t, out)
    elif run.plant.invariants > 0 and not run.is_implicit:
        find_rates_on_invariants(run, x, t, out)
    else:
        evaluate(run.plant.rates, run, x, t, run.m, out)


@kernel
def end_step(run: Run) -> None:
    """Complete the new states of a step, and write their rates."""
    if run.plant.invariants > 0:
        meet_invariants(run, run.new, run.t_new)
        tolerate_together(run)
    find_rates(run, run.new, run.t_new, run.stages[12 * run.plant.states :])


@kernel
def find_slopes(run: Run) -> None:
    """Write the Jacobian of the rates and their derivative by time at the present point.

    Where a table of it would be too large, its function takes a direction behind the states and
    is evaluated for each group of columns without common rows, then for the time (Curtis, Powell
    and Reid, IMA Journal of Applied Mathematics 13 (1974) 117).
    """
    matrix, pattern, n = run.matrix, run.matrix.pattern, run.plant.states
    if pattern.colours == 0:
        evaluate(run.plant.jacobian, run, run.x, run.t, run.m, matrix.slopes)
        return
    along, found = matrix.direction, matrix.drift
    copy_numbers(n, run.x, along)
    for c in range(pattern.colours + 1):
        for i in range(n):
            along[n + i] = 1.0 if pattern.colour[i] == c else 0.0
        along[2 * n] = 1.0 if c == pattern.colours else 0.0
        evaluate(run.plant.jacobian, run, along, run.t, run.m, found)
        if c < pattern.colours:
            for k in range(pattern.first_grouped[c], pattern.first_grouped[c + 1]):
                e = pattern.grouped[k]
                matrix.slopes[e] = found[pattern.row[e]]
