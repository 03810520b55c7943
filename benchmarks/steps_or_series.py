"""Over which drives are Taylor's series quicker than DOP853, and at which tolerance?

Runs with 200 output times of the drives of `_smooth_and_not`: published machines, models of other
benchmarks, small drives that each have one kind of formula, and random drives of the tests; those
without series are left out. Both methods turn to implicit steps where a trial shows that these are
longer. Times are those inside the loop, the least of several runs that alternate, with everything
compiled; errors are the largest of all states, relative to their ranges, against DOP853 at 1e-12,
without the time around events. Operations are those of the rates, sums those over orders.

    python -m benchmarks.steps_or_series
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

import lumped as lp
from benchmarks._smooth_and_not import Task, tasks
from benchmarks.hybrid import write
from lumped.code.operations import operations_of
from lumped.code.taylor import PRODUCT, series_of
from lumped.simulation.compare import compared, observed
from lumped.simulation.simulate import Method
from lumped.support.text_table import table
from lumped.timeloop.executable import executable

METHODS: tuple[Method, Method] = ("steps", "taylor")
TOLERANCES = (1e-4, 1e-6, 1e-9)
INTERVALS, LEAST, MOST, LONG = 200, 10, 60, 0.8
"""Output intervals; rounds of both methods, and seconds after which there are no more."""
HEAD = ("drive", "states", "operations", "sums", "events", "rtol")
HEAD += ("error, DOP853", "error, series", "us, DOP853", "us, series", "ratio", "methods")


class _Found(NamedTuple):
    """What a method does at a tolerance."""

    error: float
    seconds: float
    method: str
    events: int


def _both(task: Task, reference: lp.Trajectory, rtol: float, **options: Any) -> list[_Found]:
    """Both methods, one run of each after the other."""
    best = dict.fromkeys(METHODS, np.inf)
    begin = time.perf_counter()
    for k in range(MOST):
        turned = METHODS[:: 1 if k % 2 else -1]
        runs = {m: lp.simulate(task.system, rtol=rtol, method=m, **options) for m in turned}
        for method, run in runs.items():
            best[method] = min(best[method], run.statistics.seconds)
        if k >= LEAST and time.perf_counter() - begin > LONG:
            break
    names = observed(task.system, None)
    return [
        _Found(
            compared(run, reference, names).worst.relative,
            best[method],
            run.statistics.method,
            len(run.events),
        )
        for method, run in ((m, runs[m]) for m in METHODS)
    ]


def _rows(task: Task) -> Iterator[tuple[Any, ...]]:
    """A drive at all tolerances; nothing if it has no series."""
    code = executable(task.system)
    if not code.taylor.exist:
        return
    rates = operations_of(task.system.rhs)
    sums = sum(r.kind >= PRODUCT for r in series_of(rates).later)
    code.compile()
    begin = task.start.time if task.start is not None else 0.0
    grid = np.linspace(begin, task.until, INTERVALS + 1)
    options: dict[str, Any] = {"until": task.until, "start": task.start, "grid": grid}
    reference = lp.simulate(task.system, rtol=1e-12, method="steps", **options)
    for rtol in TOLERANCES:
        steps, series = _both(task, reference, rtol, **options)
        yield (
            task.name,
            len(task.system.state_names),
            len(rates.table),
            sums,
            steps.events,
            f"{rtol:.0e}",
            f"{steps.error:.1e}",
            f"{series.error:.1e}",
            f"{steps.seconds * 1e6:.0f}",
            f"{series.seconds * 1e6:.0f}",
            f"{series.seconds / steps.seconds:.2f}",
            f"{steps.method}; {series.method}",
        )


def main() -> None:
    """Print the table and write it as CSV."""
    rows = [row for task in tasks() for row in _rows(task)]
    print(table(HEAD, rows))
    write("steps_or_series.csv", HEAD, rows)
    for rtol in TOLERANCES:
        ratios = [float(row[-2]) for row in rows if row[5] == f"{rtol:.0e}"]
        mean = np.exp(np.mean(np.log(ratios)))
        print(f"rtol {rtol:.0e}: ratio {mean:.2f} on average, {max(ratios):.2f} at worst")


if __name__ == "__main__":
    main()
