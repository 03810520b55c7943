"""One step of Rodas5P backwards: derivatives of results by the states before it.

The matrix of the step depends on the states too, so second derivatives of the rates occur; they
come from the function `bent` of a `Sweep`.
"""

from __future__ import annotations

from lumped.code.words import Numbers, copy_numbers, kernel
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.rodas5p import INCREMENTS, NODES, PARTS, UNSOLVED, WEIGHTS, step
from lumped.kernel.methods.sparse_lu import solve_transposed
from lumped.kernel.recorded_steps.course import Sweep, of_columns
from lumped.kernel.run import Run
from lumped.numerics import rodas5p as tableau

_GAMMA = tableau.GAMMA


@kernel
def _argument(run: Run, s: int, out: Numbers) -> None:
    """States at which the rates of a stage are taken."""
    n, k = run.plant.states, run.stages
    row = min(s, 5)
    for i in range(n):
        total = run.x[i]
        for j in range(row):
            total += WEIGHTS[8 * row + j] * k[(1 + j) * n + i]
        for j in range(row, s):
            total += k[(1 + j) * n + i]
        out[i] = total


@kernel
def _bend(run: Run, sweep: Sweep, s: int, h: float) -> None:
    """Add what the matrix of the step contributes through a stage."""
    n, columns, point, g = run.plant.states, sweep.columns, sweep.point, sweep.pulled
    for i in range(n):
        point[i], point[n + i] = run.x[i], run.stages[(1 + s) * n + i]
    point[2 * n] = h * PARTS[s]
    for r in range(n * columns):
        point[2 * n + 1 + r] = h * _GAMMA * sweep.solved[r]
    of_columns(sweep.bent, run, sweep, point, 2 * n + 1, run.t, g)
    for r in range(n * columns):
        sweep.before[r] += g[r]
    for r in range(sweep.parameters * sweep.results):
        sweep.by_parameters[r] += g[n * columns + r]


@kernel
def back(run: Run, sweep: Sweep, h: float) -> bool:
    """Carry the adjoint back over a step, which ends in `before`; add derivatives by parameters.

    False if the equations of the step could not be solved.
    """
    n, columns, point, g = run.plant.states, sweep.columns, sweep.point, sweep.pulled
    flat, increments, carried, before = n * columns, sweep.increments, sweep.carried, sweep.before
    evaluate(run.plant.rates, run, run.x, run.t, run.m, run.stages)
    if step(run, h) == UNSOLVED:
        return False
    for r in range(flat):
        carried[r], before[r] = sweep.adjoint[r], 0.0
        for s in range(7):
            increments[s * flat + r] = 0.0
        increments[7 * flat + r] = sweep.adjoint[r] + sweep.judged[r]
    for s in range(7, -1, -1):
        copy_numbers(flat, increments[s * flat :], sweep.solved)
        for c in range(columns):
            solve_transposed(run.matrix.pattern, run.matrix, n, sweep.solved[c:], columns)
        _argument(run, s, point)
        for r in range(flat):
            point[n + r] = h * _GAMMA * sweep.solved[r]
        of_columns(sweep.pullback, run, sweep, point, n, run.t + NODES[s] * h, g)
        for r in range(sweep.parameters * sweep.results):
            sweep.by_parameters[r] += g[flat + r]
        for r in range(flat):
            if s >= 5:
                carried[r] += g[r]
            else:
                carried[r] = g[r]
            if s >= 6:
                increments[(s - 1) * flat + r] += carried[r]
            else:
                before[r] += carried[r]
                for j in range(s):
                    increments[j * flat + r] += WEIGHTS[8 * s + j] * carried[r]
            for j in range(s):
                increments[j * flat + r] += _GAMMA * INCREMENTS[8 * s + j] * sweep.solved[r]
        _bend(run, sweep, s, h)
    return True
