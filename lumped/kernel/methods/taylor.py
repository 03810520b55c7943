"""Steps by Taylor's series of the states about the begin of the step.

The coefficients follow from the operations of the rates (`lumped.code.taylor`); they give the step
before it is made (Jorba and Zou, Experimental Mathematics 14 (2005) 99), the states at its end, and
those inside it, all with the same accuracy.
"""

from __future__ import annotations

from typing import Any

from lumped.code.words import (
    Numbers,
    exp,
    greatest_of,
    kernel,
    least_of,
    log,
    make_kernel,
    sqrt,
)
from lumped.kernel.interpret import evaluate
from lumped.kernel.methods import rodas5p
from lumped.kernel.methods.dop853 import NODES
from lumped.kernel.methods.rates import end_step
from lumped.kernel.run import Run

_TOGETHER = 3
"""States whose series are summed at a time."""
_HELD = 1e5
"""Term of the order of an implicit step, relative to the tolerance, up to which one is worth a
trial."""


@kernel
def length(run: Run) -> float:
    """Coefficients; gives the step in which neither of the last two terms exceeds its tolerance.

    It is infinite where they vanish, and zero where they are no numbers.
    """
    n, order, row, c = run.plant.states, run.order, run.row, run.coefficients
    evaluate(run.series, run, run.x, run.t, run.m, c)
    last = before = bad = 0.0
    for i in range(n):
        weight = 1.0 / (run.atol[i] + run.rtol * abs(run.x[i]))
        a, b = abs(c[order * row + i]) * weight, abs(c[(order - 1) * row + i]) * weight
        bad += 0.0 if a + b < 1e300 else 1.0
        last = max(last, a)
        before = max(before, b)
    found = run.caution * exp(-max(log(last) / order, log(before) / (order - 1)))
    return found if bad == 0.0 else 0.0


def _sums(name: str, results: str, derivative: bool) -> Any:
    """Horner's rule for all states, some at a time: one alone would wait for each product."""
    lines = ["for i in range(0, n, _TOGETHER):"]
    for s in range(_TOGETHER):
        lines.append(f"    i{s} = min(i + {s}, n - 1)")  # the last one may come again
        lines.append(f"    v{s} = c[order * row + i{s}]")
        lines += [f"    d{s} = 0.0"] * derivative
    lines += ["    for j in range(1, order + 1):", "        at = (order - j) * row"]
    for s in range(_TOGETHER):
        if derivative:
            lines.append(f"        d{s} = d{s} * h + v{s}")
        lines.append(f"        v{s} = v{s} * h + c[at + i{s}]")
    for s in range(_TOGETHER):
        lines.append(f"    out[i{s}] = v{s}")
        if derivative:
            lines.append(f"    slope[i{s}] = d{s}")
    body = "\n".join(f"    {line}" for line in lines)
    head = f"c: Numbers, order: int, row: int, n: int, h: float, {results}"
    return make_kernel(name, f"def {name}({head}) -> None:\n{body}\n", globals())


_values = _sums("values", "out: Numbers", False)
_ends = _sums("ends", "out: Numbers, slope: Numbers", True)


@kernel
def expand(run: Run) -> None:
    """Coefficients of the states about the begin of the step; sets its length.

    After a step that was rejected, its length stays. Where there is no series, as of a root at
    zero, or constraints share a load, the step is made in the other way.
    """
    run.by_series = 0
    if run.shares:
        return
    run.evaluations += run.order
    found = length(run)
    run.by_series = found > 0.0
    if run.by_series and run.was_rejected == 0:
        run.h = found


@kernel
def step(run: Run, h: float) -> float:
    """Compute new states and their derivatives; gives the error relative to the tolerance.

    The series lacks the term of the next order, and so do its derivatives: by as many times more
    as the order of the term they miss the rates at the end of the step.

    Where the time acts by itself, rates inside the step are looked at, too, as a pulse ahead leaves
    no trace in the series at its begin.

    The motion itself would allow a longer implicit step if the term of the order of that method is
    small at its end; then what holds the step is stability: the step times the fastest eigenvalue
    is about the order.
    """
    n, order, row, c = run.plant.states, run.order, run.row, run.coefficients
    new, slope = run.new, run.argument
    f = run.stages[12 * n :]
    inner = h * 0.0
    if run.plant.forcings > 0:
        for j in range(2):
            part = NODES[j] * h
            _ends(c, order, row, n, part, new, slope)
            evaluate(run.plant.rates, run, new, run.t + part, run.m, f)
            total = h * 0.0
            for i in range(n):
                scale = run.atol[i] + run.rtol * max(abs(run.x[i]), abs(new[i]))
                miss = h * (slope[i] - f[i]) / scale
                total += miss * miss
            inner = max(inner, total)
        run.evaluations += 2
    _ends(c, order, row, n, h, new, slope)
    end_step(run)
    run.evaluations += 1
    total = bend = 0.0
    for i in range(n):
        scale = run.atol[i] + run.rtol * max(abs(run.x[i]), abs(new[i]))
        part = h * (slope[i] - f[i]) / scale
        total += part * part
        bend = max(bend, abs(c[rodas5p.ORDER * row + i]) / scale)
    far = rodas5p.LONGER * h
    is_held = bend * far * far * far * far * far <= _HELD
    run.stiffness = float(order) if is_held else 0.0
    return sqrt(max(total, inner) / n) / (order + 1)


@kernel
def interpolate(run: Run, part: float, out: Numbers) -> None:
    """States at a part of the step."""
    n, order, row, c = run.plant.states, run.order, run.row, run.coefficients
    _values(c, order, row, n, part * (run.t_new - run.t), out)


@kernel
def set_ranges(run: Run) -> None:
    """Ranges of the states in the step: the least and greatest Bernstein coefficients."""
    n, order, row, c = run.plant.states, run.order, run.row, run.coefficients
    h, b = run.t_new - run.t, run.bernstein
    for i in range(n):
        factor = h
        b[0] = run.x[i]
        for j in range(1, order + 1):
            b[j] = c[j * row + i] * factor
            factor = factor * h * (float(j + 1) / float(max(order - j, 1)))
        for j in range(order):
            b[j + 1] = b[j + 1] / float(order)
        for k in range(1, order + 1):
            for j in range(order, k - 1, -1):
                b[j] += b[j - 1]
        run.ranges[i], run.ranges[n + i] = least_of(b, order), greatest_of(b, order)


@kernel
def polynomial(run: Run, i: int) -> int:
    """Coefficients of a state by powers of the part of the step; gives the degree."""
    factor, h = 1.0, run.t_new - run.t
    for j in range(run.order + 1):
        run.powers[j] = run.coefficients[j * run.row + i] * factor
        factor = factor * h
    return run.order


@kernel
def integrals(run: Run, h: float) -> float:
    """Integrals over a step; gives the last term of the worst of them, relative to the tolerance.

    The tolerance is that of what has come together so far, as for a state.
    """
    watch, worst = run.watch, 0.0
    order, row, c = run.order, run.row, run.coefficients[run.plant.states :]
    for i in range(watch.integrands):
        value = c[order * row + i]
        last = value
        for j in range(1, order + 1):
            value = value * h + c[(order - j) * row + i]
            last = last * h
        watch.parts[i] = value
        size = max(max(h * abs(c[row + i]), abs(value)), abs(watch.sums[i]))
        worst = max(worst, abs(last) / max(run.rtol * size, 1e-300))
    return worst
