"""How quick are ensembles in C by hand, on one thread?

Four tasks, solved by programs written by hand (`ensembles.c`): three masses on shafts, three
clutches, a crank drive, Lorenz. Each is compiled in three ways: plain, for this machine, and for
this machine with several variants side by side in a register. The limit of the tasks is the
quickest of them. Results are checked against published statistics (`tests/data/ensembles`).

    python -m benchmarks._ensembles_in_c
"""

from __future__ import annotations

import ctypes
import functools
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import yaml  # type: ignore[import-untyped]
from numpy.typing import NDArray

from lumped.support.text_table import table

Floats = NDArray[np.float64]
Build = Literal["scalar", "native", "lanes", "closed", "closed lanes"]

SOURCE = Path(__file__).with_name("ensembles.c")
REFERENCE = Path(__file__).parents[1] / "tests" / "data" / "ensembles" / "tasks.yaml"

PARAMETERS = {
    "a": (0.5, 1.2, 3.0, 40_000.0, 25_000.0),
    "b": (9.0, 7.0, 6.0),
    "c": (0.05, 600.0, 0.5, 0.12, 0.45, 8.0),
}
"""Nominal parameters, in the order of the columns."""
FACTORS = {"a": (0.9, 0.2), "b": (0.8, 0.4), "c": (0.95, 0.1)}
"""Smallest factor of a parameter, and how much larger the largest one is."""
TRAJECTORIES, LARGEST_RHO = 524_288, 21.0

QUANTITIES = {
    "a": ("peak_torque",),
    "b": ("t_lock_1", "t_lock_2", "t_lock_3", "heat"),
    "c": ("phi_end", "w_crank_end", "torque_rms"),
    "d": ("x", "y", "z"),
}

# Sums over neighbouring states are not to be turned into short vectors: they are stored one by one
# and read in pairs, for which the processor waits.
PLAIN = ("-fno-tree-slp-vectorize",)
NATIVE = ("-O3", "-march=native", *PLAIN)
GROUPS = 2
"""Registers full of variants that advance together: one leaves the processor waiting for results,
three no longer fit."""
COMPILED: Mapping[Build, Literal["scalar", "native", "lanes"]] = {
    "scalar": "scalar",
    "native": "native",
    "lanes": "lanes",
    "closed": "native",
    "closed lanes": "lanes",
}

REPEATS, ENOUGH = 3, 0.5
"""Least number of repeats, and the time in seconds after which there are no more of them."""
CHECKED = 2_000
"""Variants that are compared one by one with a run at a tight tolerance."""


@functools.cache
def reference() -> Mapping[str, Any]:
    """Published statistics of the tasks."""
    found: Mapping[str, Any] = yaml.safe_load(REFERENCE.read_text(encoding="utf-8"))
    return found


@functools.cache
def parameters(task: str) -> Floats:
    """Parameters of all variants of a task.

    Parameters
    ----------
    task
        "a" to "d".

    Returns
    -------
    Floats
        One row for each variant.
    """
    if task == "d":
        found = np.linspace(0.0, LARGEST_RHO, TRAJECTORIES)[:, np.newaxis]
    else:
        facts = reference()[task]
        u = np.random.default_rng(facts["seed"]).random((facts["n"], facts["k"]))
        least, span = FACTORS[task]
        found = np.array(PARAMETERS[task]) * (least + span * u)
    found.flags.writeable = False
    return found


@functools.cache
def _compiler() -> str:
    """Path of gcc."""
    found = shutil.which("gcc")
    if found is None:
        raise FileNotFoundError("the ensembles in C need gcc")
    return found


@functools.cache
def lanes() -> int:
    """Variants in one register of this machine: 8 with AVX-512, 4 with AVX2, otherwise 1."""
    arguments = [_compiler(), "-march=native", "-dM", "-E", "-x", "c", "/dev/null"]
    said = subprocess.run(arguments, check=True, capture_output=True, text=True).stdout.split()
    return 8 if "__AVX512F__" in said else 4 if "__AVX2__" in said else 1


@functools.cache
def _library(compiled: Literal["scalar", "native", "lanes"]) -> ctypes.CDLL:
    """The programs, compiled in one of three ways."""
    options: tuple[str, ...] = ("-O2", *PLAIN) if compiled == "scalar" else NATIVE
    if compiled == "lanes":
        options += (f"-DLANES={lanes()}", f"-DGROUPS={GROUPS}")
    with tempfile.TemporaryDirectory() as folder:
        made = str(Path(folder) / "ensembles.so")
        arguments = [*options, "-std=gnu11", "-shared", "-fPIC", str(SOURCE), "-lm", "-o", made]
        subprocess.run([_compiler(), *arguments], check=True)
        return ctypes.CDLL(made)


@dataclass(frozen=True)
class Timed:
    """Runs of a task.

    Parameters
    ----------
    seconds
        CPU time of a run, the best of all repeats.
    found
        Quantities, one row for each variant.
    steps
        Mean number of accepted steps.
    rejected
        Mean number of steps that were tried in vain.
    """

    seconds: float
    found: Floats
    steps: float
    rejected: float


def timed(
    task: str,
    rtol: float,
    build: Build,
    variants: int | None = None,
    repeats: int = REPEATS,
    enough: float = ENOUGH,
) -> Timed:
    """Run a task on one thread.

    Parameters
    ----------
    task
        "a" to "d".
    rtol
        Relative tolerance; the closed form has none.
    build
        "scalar", "native", "lanes", or, for task b, "closed" and "closed lanes".
    variants
        How many: the first ones, and of task d, where they are in order, as many evenly spread
        over all. None: all.
    repeats
        How often at least; the best counts.
    enough
        Short runs are repeated more often, for so many seconds.

    Returns
    -------
    Timed
        Times, quantities and numbers of steps.
    """
    if (build == "lanes" and task == "b") or (build.startswith("closed") and task != "b"):
        raise ValueError(f"task {task} has no build {build!r}")
    rows = parameters(task)
    if variants is not None:
        chosen = np.arange(min(variants, len(rows)))
        if task == "d":
            chosen = np.round(np.linspace(0, len(rows) - 1, len(chosen))).astype(np.intp)
        rows = rows[chosen]
    rows = np.ascontiguousarray(rows)
    found = np.empty((len(rows), len(QUANTITIES[task])))
    steps = (ctypes.c_long * 2)()
    name = f"task_{task}_closed" if build.startswith("closed") else f"task_{task}"
    function = _library(COMPILED[build])[name]
    function.restype = None
    function.argtypes = [
        ctypes.c_void_p,
        ctypes.c_long,
        ctypes.c_double,
        ctypes.c_void_p,
        ctypes.c_void_p,
    ]
    best, spent, done = np.inf, 0.0, 0
    while done < repeats or spent < enough:
        begin = time.thread_time()
        function(rows.ctypes.data, len(rows), rtol, found.ctypes.data, ctypes.addressof(steps))
        seconds = time.thread_time() - begin
        best, spent, done = min(best, seconds), spent + seconds, done + 1
    n = len(rows)
    return Timed(best / n, found, steps[0] / n, steps[1] / n)


def limit(
    task: str, rtol: float, build: Build, variants: int | None = None
) -> tuple[float, Floats]:
    """Time of a run in C on one thread, and what it finds.

    Parameters
    ----------
    task
        "a" to "d".
    rtol
        Relative tolerance; the closed form has none.
    build
        "scalar", "native", "lanes", or, for task b, "closed" and "closed lanes".
    variants
        How many: the first ones, and of task d, where they are in order, as many evenly spread
        over all. None: all.

    Returns
    -------
    seconds : float
        CPU time of a run, best of three or more.
    found : Floats
        Quantities, one row for each variant, in the order of `QUANTITIES`.
    """
    runs = timed(task, rtol, build, variants)
    return runs.seconds, runs.found


def statistics_error(task: str, found: Floats) -> float:
    """Greatest deviation of statistics and of the first variants from the published ones.

    Parameters
    ----------
    task
        "a", "b" or "c".
    found
        Quantities of all variants.

    Returns
    -------
    float
        Relative to the mean of the quantity.
    """
    facts = reference()[task]
    first: Mapping[str, Any]
    if task == "a":
        first = {"peak_torque": facts["peak_torque"]["first"]}
    elif task == "b":
        first = dict(zip(QUANTITIES["b"], np.transpose(facts["first"]), strict=False))
    else:
        first = facts["first"]
    worst = 0.0
    for name, values in zip(QUANTITIES[task], found.T, strict=True):
        groups = {"": values}
        if task == "c":
            groups = {"all_10000": values, "subset_200": values[:200]}
        for group, chosen in groups.items():
            published = (facts[group] if group else facts)[name]
            own = {
                "mean": chosen.mean(),
                "std": chosen.std(ddof=1),
                "q001": np.quantile(chosen, 0.001),
                "q500": np.quantile(chosen, 0.5),
                "q999": np.quantile(chosen, 0.999),
                "min": chosen.min(),
                "max": chosen.max(),
            }
            off = max(abs(value - published[key]) for key, value in own.items())
            if name in first:
                off = max(off, float(np.abs(chosen[:3] - first[name]).max()))
            worst = max(worst, float(off / published["mean"]))
    return worst


ROWS: tuple[tuple[str, tuple[float, ...], tuple[Build, ...]], ...] = (
    ("a", (1e-5, 1e-6, 1e-8), ("scalar", "native", "lanes")),
    ("b", (1e-8,), ("scalar", "native", "closed", "closed lanes")),
    ("c", (1e-5, 1e-6, 1e-8), ("scalar", "native", "lanes")),
    ("d", (1e-6, 1e-8), ("scalar", "native", "lanes")),
)
TIGHT: Mapping[str, tuple[float, Build]] = {
    "a": (1e-11, "scalar"),
    "b": (0.0, "closed"),
    "c": (1e-12, "scalar"),
    "d": (1e-12, "scalar"),
}
"""Tolerance and build of the runs that the others are compared with."""
UNITS = {"a": "relative", "b": "relative", "c": "relative", "d": "absolute"}


def compared() -> list[tuple[str, ...]]:
    """Times and errors of all tasks, tolerances and builds."""
    rows: list[tuple[str, ...]] = []
    for task, tolerances, builds in ROWS:
        tight = timed(task, *TIGHT[task], variants=CHECKED, repeats=1, enough=0.0).found
        for rtol in tolerances:
            for build in builds:
                runs = timed(task, rtol, build, CHECKED)
                off = np.abs(runs.found - tight)
                if UNITS[task] == "relative":
                    off /= np.abs(tight)
                statistics = "-"
                if task != "d" and (build.endswith("lanes") or (task, build) == ("b", "native")):
                    everything = timed(task, rtol, build, repeats=1, enough=0.0).found
                    statistics = f"{statistics_error(task, everything):.1e}"
                rows.append(
                    (
                        task,
                        "-" if build.startswith("closed") else f"{rtol:.0e}",
                        build,
                        f"{runs.seconds * 1e6:.3g}",
                        "-"
                        if build == TIGHT[task][1] == "closed"
                        else f"{off.max():.1e} {UNITS[task]}",
                        statistics,
                        f"{runs.steps:.1f}",
                        f"{runs.rejected:.1f}",
                    )
                )
    return rows


def _main() -> None:
    """Print the table."""
    print(f"{CHECKED} variants of each task on one thread, {lanes()} lanes, {GROUPS} groups")
    head = (
        "task",
        "rtol",
        "build",
        "us per run",
        "greatest error",
        "statistics",
        "steps",
        "in vain",
    )
    print(table(head, compared()))


if __name__ == "__main__":
    _main()
