"""One attempt of Rodas5P (Steinebach, BIT Numerical Mathematics 63 (2023) 27).

A stiffly accurate L-stable Rosenbrock method with the exact sparse Jacobian. The increments of its
eight stages lie between the derivatives at both ends of the step.
"""

from __future__ import annotations

import numpy as np

from lumped.code.words import Numbers, copy_numbers, kernel, sqrt
from lumped.kernel.methods.rates import end_step, find_rates, find_slopes
from lumped.kernel.methods.sparse_lu import factorise, is_solved, solve
from lumped.kernel.run import Run
from lumped.numerics import rodas5p as tableau

ORDER = 5
LONGER = 3.0
"""How many times longer than an explicit step the trial of an implicit one is."""
UNSOLVED = 1e3
"""Error of a step whose linear equations could not be solved accurately: try a shorter one."""

_GAMMA = tableau.GAMMA
NODES = (*tableau.NODES, 1.0, 1.0, 1.0)
PARTS = (*tableau.D, 0.0, 0.0, 0.0)
"""Of each stage: when its rates are taken, and the weight of their derivative by time."""


def _square(rows: tuple[tuple[float, ...], ...]) -> tuple[float, ...]:
    """Rows of different lengths as eight of eight, one after the other."""
    filled = np.zeros((8, 8))
    for i, row in enumerate(rows):
        filled[i, : len(row)] = row
    return tuple(filled.ravel().tolist())


WEIGHTS, INCREMENTS = _square(tableau.A), _square(tableau.C)
"""Weights of earlier increments in the states of each stage, and in its right-hand side."""
_H = tuple(np.array(tableau.H).ravel().tolist())


@kernel
def _factorise(run: Run, h: float) -> bool:
    """Whether the matrix of the step, ``I - h gamma J``, has factors."""
    matrix, n = run.matrix, run.plant.states
    pattern = matrix.pattern
    find_slopes(run)
    for e in range(pattern.entries):
        matrix.factors[e] = 0.0
    for i in range(n):
        matrix.factors[pattern.diagonal[i]] = 1.0
    for e in range(pattern.nonzeros):
        matrix.factors[pattern.place[e]] -= h * _GAMMA * matrix.slopes[e]
    return factorise(pattern, matrix, n)


@kernel
def step(run: Run, h: float) -> float:
    """Compute new states and their derivatives; gives the error relative to the tolerance."""
    n, t, matrix = run.plant.states, run.t, run.matrix
    pattern, drift, right = matrix.pattern, matrix.drift, matrix.right
    x, k, new = run.x, run.stages, run.new
    if not _factorise(run, h):
        return UNSOLVED
    for s in range(8):
        rate = k[(1 + s) * n :]
        for i in range(n):
            total = x[i]
            if s < 6:
                for j in range(s):
                    total += WEIGHTS[8 * s + j] * k[(1 + j) * n + i]
            else:
                total = new[i] + k[s * n + i]
            new[i] = total
        if s == 0:
            copy_numbers(n, k, rate)
        else:
            find_rates(run, new, t + NODES[s] * h, rate)
        for i in range(n):
            total = 0.0
            for j in range(s):
                total += INCREMENTS[8 * s + j] * k[(1 + j) * n + i]
            right[i] = h * _GAMMA * (rate[i] + h * PARTS[s] * drift[i] + total / h)
            rate[i] = right[i]
        solve(pattern, matrix, n, rate)
        if s == 0 and not is_solved(run, h * _GAMMA, right, rate):
            return UNSOLVED
    for i in range(n):
        new[i] = new[i] + k[8 * n + i]
    end_step(run)
    run.evaluations += 8
    error = 0.0
    for i in range(n):
        part = k[8 * n + i] / (run.atol[i] + run.rtol * max(abs(x[i]), abs(new[i])))
        error += part * part
    return sqrt(error) / sqrt(float(n))


@kernel
def dense_output(run: Run) -> None:
    """Coefficients of the interpolation in a step that was accepted."""
    n, k = run.plant.states, run.stages
    for c in range(3):
        for i in range(n):
            total = 0.0
            for j in range(8):
                total += _H[8 * c + j] * k[(1 + j) * n + i]
            run.dense[c * n + i] = total


@kernel
def dense_error(run: Run, h: float) -> float:
    """Error of the interpolation, relative to the tolerance, by its defect at one point.

    The matrix of the step removes the stiff part of the defect. The rest at 0.3 is nine times the
    largest error; an error of two thirds of the tolerance is allowed.
    """
    n, x, new, c, u = run.plant.states, run.x, run.new, run.dense, run.argument
    defect = run.stages[9 * n :]
    for i in range(n):
        inner = 0.21 * c[i] + 0.063 * c[n + i] + 0.0189 * c[2 * n + i]
        u[i] = 0.7 * x[i] + 0.3 * new[i] + inner
    find_rates(run, u, run.t + 0.3 * h, defect)
    run.evaluations += 1
    for i in range(n):
        slope = new[i] - x[i] + 0.4 * c[i] + 0.33 * c[n + i] + 0.162 * c[2 * n + i]
        defect[i] = slope - h * defect[i]
    solve(run.matrix.pattern, run.matrix, n, defect)
    total = 0.0
    for i in range(n):
        part = defect[i] / (run.atol[i] + run.rtol * max(abs(x[i]), abs(new[i])))
        total += part * part
    return sqrt(total / n) / 6.0


@kernel
def interpolate(run: Run, part: float, out: Numbers) -> None:
    """States at a part of the step; those that do not move keep their bits."""
    n, x, new, c = run.plant.states, run.x, run.new, run.dense
    rest = 1.0 - part
    for i in range(n):
        inner = c[i] + part * (c[n + i] + part * c[2 * n + i])
        out[i] = x[i] + part * (new[i] - x[i] + rest * inner)


@kernel
def set_ranges(run: Run) -> None:
    """Ranges of the states in the step: the least and greatest Bernstein coefficients."""
    n, x, new, c = run.plant.states, run.x, run.new, run.dense
    for i in range(n):
        first, last = x[i], new[i]
        a, b, d = c[i], c[n + i], c[2 * n + i]
        one = (3.0 * first + last + a) / 4.0
        two = (3.0 * (first + last) + 2.0 * a + b) / 6.0
        three = (first + 3.0 * last + a + b + d) / 4.0
        run.ranges[i] = min(min(min(first, last), min(one, two)), three)
        run.ranges[n + i] = max(max(max(first, last), max(one, two)), three)


@kernel
def polynomial(run: Run, i: int) -> int:
    """Coefficients of a state by powers of the part of the step; gives the degree."""
    n, q, c = run.plant.states, run.powers, run.dense
    x, new = run.x[i], run.new[i]
    q[0], q[1], q[2] = x, new - x + c[i], c[n + i] - c[i]
    q[3], q[4] = c[2 * n + i] - c[n + i], -c[2 * n + i]
    return 4
