"""One step of DOP853 backwards: derivatives of results by the states before it."""

from __future__ import annotations

from typing import Any

from lumped.code.words import copy_numbers, kernel, make_kernel
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods.dop853 import STAGES, stages
from lumped.kernel.recorded_steps.course import Sweep, of_columns
from lumped.kernel.run import Run
from lumped.numerics import dop853 as tableau

_C = tuple(float(c) for c in tableau.C)
(_1, _2, _3, _4, _5, _6, _7, _8, _9, _10, _11) = STAGES


def _weights(number: int) -> Any:
    """Derivatives of results by the rates at a stage, from those at later stages."""
    terms = [
        f"{float(row[number])!r} * g[{j} * w + r]"
        for j, row in enumerate(tableau.A)
        if number < len(row) and row[number]
    ]
    for name, weights in (("after", tableau.B), ("judged", tableau.E6)):
        if weights[number]:
            terms.append(f"{float(weights[number])!r} * {name}[r]")
    source = f"""def weights_{number}(
    after: Numbers, judged: Numbers, out: Numbers, g: Numbers, n: int, w: int, h: float
) -> None:
    for r in range(n):
        out[r] = h * ({" + ".join(terms)})
"""
    return make_kernel(f"weights_{number}", source, globals())


(_W0, _W1, _W2, _W3, _W4, _W5, _W6, _W7, _W8, _W9, _W10, _W11) = map(_weights, range(12))


_SUM = " + ".join(f"g[{j} * w + r]" for j in range(12))
_add_stages = make_kernel(
    "add_stages",
    f"""def add_stages(g: Numbers, out: Numbers, n: int, w: int) -> None:
    for r in range(n):
        out[r] += {_SUM}
""",
    globals(),
)
"""Add what was found at all stages."""

_STAGES_BACK = "\n".join(
    f"""    _W{i}(sweep.adjoint, sweep.judged, point[n:], g, flat, w, h)
    _{i}(x, point, k, n, h)
    of_columns(sweep.pullback, run, sweep, point, n, t + _C[{i}] * h, g[{i} * w :])"""
    for i in range(11, 0, -1)
)
_stages_back = make_kernel(
    "stages_back",
    f"""def stages_back(run: Run, sweep: Sweep, h: float) -> None:
    t, x, k, n = run.t, run.x, run.stages, run.plant.states
    point, g, columns = sweep.point, sweep.pulled, sweep.columns
    flat = n * columns
    w = flat + sweep.parameters * sweep.results
{_STAGES_BACK}
""",
    globals(),
)
"""Derivatives of results by the rates at the twelfth to the second stage."""


@kernel
def back(run: Run, sweep: Sweep, h: float) -> None:
    """Carry the adjoint back over a step, which ends in `before`; add derivatives by parameters."""
    n, columns, g, point = run.plant.states, sweep.columns, sweep.pulled, sweep.point
    flat = n * columns
    w = flat + sweep.parameters * sweep.results
    evaluate(run.plant.rates, run, run.x, run.t, run.m, run.stages)
    stages(run, h)
    _stages_back(run, sweep, h)
    _W0(sweep.adjoint, sweep.judged, point[n:], g, flat, w, h)
    copy_numbers(n, run.x, point)
    of_columns(sweep.pullback, run, sweep, point, n, run.t, g)
    copy_numbers(flat, sweep.adjoint, sweep.before)
    _add_stages(g, sweep.before, flat, w)
    _add_stages(g[flat:], sweep.by_parameters, w - flat, w)
