"""How near do ensembles come to C written by hand, with one thread and with all?

Four tasks (`_ensemble_tasks`): three masses, three clutches, a crank drive, Lorenz. In C each is
solved by DOP853 with its own formulas: plain, tuned for this machine, and with eight variants side
by side in registers and fused multiplications (`ensembles.c`). `lumped` makes the same runs from
the models, one by one and in lanes, with the bits of single runs. Times are processor times a run
of one thread, the best of many short slices; set-up goes from the description to the end of the
first slice in lanes, less the time of a slice. Errors are the greatest over the variants, relative
to the largest value (Lorenz: absolute), against runs at 1e-11. Read the ratios, and the errors
beside them.

    python -m benchmarks.ensembles
"""

import functools
import os
import subprocess
import time
from collections.abc import Callable
from ctypes import CDLL, c_double, c_long, c_void_p

import numpy as np

import lumped as lp
from benchmarks._ensemble_tasks import Task, tasks
from benchmarks.harness import NATIVE, build_in_c, publish, time_action
from lumped.many_runs.native_runs import NativeRuns
from lumped.timeloop.run_options import RunOptions, run_plan

SLICES, PART = 40, 256
"""Slices of work, and the variants in each."""
CASES = (("a", 1e-6), ("a", 1e-8), ("b", 1e-8), ("c", 1e-6), ("c", 1e-8), ("d", 1e-6), ("d", 1e-8))
WHOLE = (("a", 1e-6), ("b", 1e-8), ("c", 1e-6), ("d", 1e-8))
TIGHT = 1e-11

PLAIN = ("-O2", "-fno-tree-slp-vectorize")
GROUPS = 2
"""Registers full of variants that advance together: one leaves the processor waiting for results,
three no longer fit."""


@functools.cache
def library(kind: str) -> CDLL | None:
    """The programs in C: "plain", "tuned", or with variants "side by side" in a register."""
    options = PLAIN if kind == "plain" else NATIVE
    if kind == "side by side":
        ask = ["gcc", "-march=native", "-dM", "-E", "-x", "c", "/dev/null"]
        said = subprocess.run(ask, check=True, capture_output=True, text=True).stdout.split()
        lanes = 8 if "__AVX512F__" in said else 4 if "__AVX2__" in said else 1
        options = (*options, f"-DLANES={lanes}", f"-DGROUPS={GROUPS}")
    return build_in_c("ensembles.c", *options)


def in_c(letter: str, rtol: float, kind: str, points: np.ndarray) -> tuple[float, np.ndarray]:
    """Processor time of a run in C, and the functionals of all variants."""
    made = library(kind)
    found = np.full((len(points), {"a": 1, "b": 4, "c": 3, "d": 3}[letter]), np.nan)
    if made is None or (letter, kind) == ("b", "side by side"):
        return np.nan, found
    function, steps = made[f"task_{letter}"], (c_long * 2)()
    function.restype, function.argtypes = None, (c_void_p, c_long, c_double, c_void_p, c_void_p)
    points = np.ascontiguousarray(points)
    given = (points.ctypes.data, len(points), rtol, found.ctypes.data, steps)
    return time_action(lambda: function(*given), SLICES, time.thread_time).seconds / len(
        points
    ), found


class Alone(NativeRuns):
    """Runs one by one."""

    has_lanes = False


def prepare(task: Task, rtol: float, kind: type[NativeRuns], letter: str) -> NativeRuns:
    """Runs of a task."""
    system = lp.assemble(task.model, keep=["wheel.phi"] if letter == "c" else ())
    options: RunOptions = {"atol": rtol if letter == "d" else None}
    plan = run_plan(task.until, rtol, options).by_steps("ensemble")
    return kind(system, task.names, system.theta(None), task.of, plan)


def match_reference(letter: str, values: np.ndarray) -> np.ndarray:
    """Functionals as the reference has them."""
    if letter == "a":
        return values.max(axis=1, keepdims=True)
    if letter == "b":
        return np.column_stack([values[:, :3], np.abs(values[:, 3:]).sum(axis=1)])
    return values


def time_slices(runs_of: Callable[[], NativeRuns], points: np.ndarray) -> tuple[float, float]:
    """Processor time of a run, and of all before it, s."""
    begin = time.process_time()
    runs = runs_of()
    made = time.process_time() - begin
    found = time_action(lambda: runs.run(points), SLICES, time.thread_time)
    return found.seconds / len(points), made + found.first - found.seconds


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
        reference = match_reference(
            letter, prepare(task, TIGHT, NativeRuns, letter).run(points).values
        )
        found = match_reference(letter, prepare(task, rtol, NativeRuns, letter).run(points).values)
        alone, _ = time_slices(functools.partial(prepare, task, rtol, Alone, letter), points)
        lanes, set_up = time_slices(
            functools.partial(prepare, task, rtol, NativeRuns, letter), points
        )
        plain, own = in_c(letter, rtol, "plain", points)
        tuned, _ = in_c(letter, rtol, "tuned", points)
        side, _ = in_c(letter, rtol, "side by side", points)
        times = [f"{1e6 * t:.2f}" for t in (alone, lanes, plain, tuned, side)]
        ratios = [f"{lanes / plain:.2f}", f"{lanes / np.nanmin([plain, tuned, side]):.2f}"]
        errors = [f"{greatest(letter, v, reference):.1e}" for v in (found, own)]
        rows.append((letter, f"{rtol:g}", f"{set_up:.2f}", *times, *ratios, *errors))
    return rows


def whole() -> list[tuple[str, ...]]:
    """Whole ensembles on all threads."""
    rows, cores = [], os.cpu_count() or 1
    for letter, rtol in WHOLE:
        task = tasks()[letter]
        system = lp.assemble(task.model)
        over = lp.ensembles.paired(dict(zip(task.names, task.points.T, strict=True)))
        common = {"over": over, "until": task.until, "of": task.of, "rtol": rtol}
        if letter == "d":
            common["atol"] = rtol
        seconds = {}
        for workers in (1, cores):
            found = lp.ensemble(system, workers=workers, **common)
            assert not found.failures
            seconds[workers] = found.seconds
        count, wall = len(found), seconds[cores]
        use = f"{seconds[1] / (cores * wall):.2f}"
        rows.append((letter, f"{rtol:g}", str(count), f"{wall:.2f}", f"{count / wall:.0f}", use))
    return rows


def main() -> None:
    """Print the tables and write them to the results."""
    head = ("task", "rtol", "set-up, s", "us one by one", "us in lanes")
    head += ("us C", "us C tuned", "us C in lanes", "lanes over C", "lanes over fastest C")
    publish("ensembles", (*head, "error", "error of C"), against_c())
    head = ("task", "rtol", "runs", "s on all threads", "runs per second", "share of perfect use")
    publish("ensembles_whole", head, whole())


if __name__ == "__main__":
    main()
