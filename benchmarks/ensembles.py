"""How near do ensembles come to C written by hand, with one thread and with all?

Four tasks (`_ensemble_tasks`): three masses, three clutches, a crank drive, Lorenz. In C each is
solved by DOP853 with its own formulas: plain, tuned for this machine, and with eight variants side
by side in registers and fused multiplications (`ensembles.c`). `lumped` makes the same runs from
the models, one by one and in lanes, with the bits of single runs. Times are processor times a run
of one thread, the best of many short slices; errors the greatest over the variants, relative to
the largest value (Lorenz: absolute), against runs at 1e-11. Read the ratios, and the errors beside
them.

    python -m benchmarks.ensembles
"""

import os
import time

import numpy as np

import lumped as lp
from benchmarks._ensemble_tasks import Task, tasks
from benchmarks._ensembles_in_c import limit, statistics_error
from benchmarks.hybrid import write
from lumped.many_runs.native_runs import NativeRuns
from lumped.support.text_table import table
from lumped.timeloop.run_options import RunOptions, run_plan

SLICES, PART = 40, 256
"""Slices of work, and the variants in each."""
CASES = (("a", 1e-6), ("a", 1e-8), ("b", 1e-8), ("c", 1e-6), ("c", 1e-8), ("d", 1e-6), ("d", 1e-8))
TIGHT = 1e-11


class Alone(NativeRuns):
    """Runs one by one."""

    has_lanes = False


def prepared(task: Task, rtol: float, kind: type[NativeRuns], letter: str) -> NativeRuns:
    """Runs of a task."""
    system = lp.assemble(task.model, keep=["wheel.phi"] if letter == "c" else ())
    options: RunOptions = {"atol": rtol if letter == "d" else None}
    plan = run_plan(task.until, rtol, options).by_steps("ensemble")
    return kind(system, task.names, system.theta(None), task.of, plan)


def shown(letter: str, values: np.ndarray) -> np.ndarray:
    """Functionals as the reference has them."""
    if letter == "a":
        return values.max(axis=1, keepdims=True)
    if letter == "b":
        return np.column_stack([values[:, :3], np.abs(values[:, 3:]).sum(axis=1)])
    return values


def timed(runs: NativeRuns, points: np.ndarray) -> float:
    """Processor time of a run."""
    runs.run(points[:8])
    best = np.inf
    for _ in range(SLICES):
        begin = time.thread_time()
        runs.run(points)
        best = min(best, time.thread_time() - begin)
    return best / len(points)


def greatest(letter: str, found: np.ndarray, reference: np.ndarray) -> float:
    """Greatest error."""
    size = 1.0 if letter == "d" else np.abs(reference).max(axis=0)
    return float((np.abs(found - reference) / size).max())


def against_c() -> list[tuple[str, ...]]:
    """Time of a run, and its error, beside C."""
    rows = []
    for letter, rtol in CASES:
        task = tasks()[letter]
        count = PART * (16 if letter == "d" else 1)
        points = task.points[:count]
        if letter == "d":
            points = task.points[np.linspace(0, len(task.points) - 1, count).round().astype(int)]
        reference = shown(letter, prepared(task, TIGHT, NativeRuns, letter).run(points).values)
        found = shown(letter, prepared(task, rtol, NativeRuns, letter).run(points).values)
        alone = timed(prepared(task, rtol, Alone, letter), points)
        lanes = timed(prepared(task, rtol, NativeRuns, letter), points)
        scalar, own = limit(letter, rtol, "scalar", count)
        native, _ = limit(letter, rtol, "native", count)
        side = np.nan if letter == "b" else limit(letter, rtol, "lanes", count)[0]
        times = [f"{1e6 * t:.2f}" for t in (alone, lanes, scalar, native, side)]
        best = native if letter == "b" else side
        ratios = [f"{lanes / scalar:.2f}", f"{lanes / best:.2f}"]
        errors = [f"{greatest(letter, v, reference):.1e}" for v in (found, own)]
        rows.append((letter, f"{rtol:g}", *times, *ratios, *errors))
    return rows


def whole() -> list[tuple[str, ...]]:
    """Whole ensembles on all threads, with their statistics against the published ones."""
    rows, cores = [], os.cpu_count() or 1
    for letter, rtol in (("a", 1e-6), ("b", 1e-8), ("c", 1e-6), ("d", 1e-8)):
        task = tasks()[letter]
        system = lp.assemble(task.model, keep=["wheel.phi"] if letter == "c" else ())
        over = lp.ensembles.paired(dict(zip(task.names, task.points.T, strict=True)))
        common = {"over": over, "until": task.until, "of": task.of, "rtol": rtol}
        if letter == "d":
            common["atol"] = rtol
        seconds = {}
        for workers in (1, cores):
            found = lp.ensemble(system, workers=workers, **common)
            assert not found.failures
            seconds[workers] = found.seconds
        values = shown(letter, found.values)
        error = "" if letter == "d" else f"{statistics_error(letter, values):.1e}"
        count, wall = len(values), seconds[cores]
        use = seconds[1] / (cores * wall)
        rows.append(
            (
                letter,
                f"{rtol:g}",
                str(count),
                f"{wall:.2f}",
                f"{count / wall:.0f}",
                f"{use:.2f}",
                error,
            )
        )
    return rows


def main() -> None:
    """Print the tables and write them beside this script."""
    head = (
        *("task", "rtol", "us one by one", "us in lanes", "us C", "us C tuned", "us C in lanes"),
        *("lanes over C", "lanes over fastest C", "error", "error of C"),
    )
    rows = against_c()
    print(table(head, rows))
    write("ensembles.csv", head, rows)
    head = (
        *("task", "rtol", "runs", "s on all threads", "runs per second"),
        *("share of perfect use", "error of statistics"),
    )
    rows = whole()
    print(table(head, rows))
    write("ensembles_whole.csv", head, rows)


if __name__ == "__main__":
    main()
