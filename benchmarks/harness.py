"""How a case is timed, how a baseline in C is built, and where the rows of a table go."""

import csv
import os
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from ctypes import CDLL
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import lumped as lp
from lumped.support.text_table import table
from lumped.timeloop.plants.executable import executable

RESULTS = Path(__file__).parent / "results"


class Timed(NamedTuple):
    """Best time of an action, time of its first call, s, and its last result."""

    seconds: float
    first: float
    result: Any


def in_turn(
    *actions: Callable[[], Any], rounds: int, clock: Callable[[], float] = time.perf_counter
) -> list[Timed]:
    """Time actions; they take turns, so that a slow moment of the machine meets all of them."""
    seconds, results = np.full((rounds, len(actions)), np.inf), [None] * len(actions)
    for k in range(rounds):
        for i, action in enumerate(actions):
            begin = clock()
            results[i] = action()
            seconds[k, i] = clock() - begin
    return [Timed(*row) for row in zip(seconds.min(axis=0), seconds[0], results, strict=True)]


def time_action(
    action: Callable[[], Any], rounds: int, clock: Callable[[], float] = time.perf_counter
) -> Timed:
    """Time one action."""
    return in_turn(action, rounds=rounds, clock=clock)[0]


def build(model: lp.Component) -> tuple[lp.System, float]:
    """A model assembled and compiled, and the time of it, s."""
    begin = time.perf_counter()
    system = lp.assemble(model)
    executable(system).compile()
    executable(system).written_step(1).compile()
    return system, time.perf_counter() - begin


def run_timed(system: lp.System, rounds: int, **options: Any) -> tuple[Timed, float]:
    """Time a run; beside it the best time inside the time loop, s."""
    inner = np.inf

    def run() -> lp.Trajectory:
        nonlocal inner
        found = lp.simulate(system, **options)
        inner = min(inner, found.statistics.seconds)
        return found

    return time_action(run, rounds), inner


NATIVE = ("-O3", "-march=native", "-fno-tree-slp-vectorize")
"""Options for C that is tuned for this machine. Sums over neighbouring states are not turned into
short vectors: they are stored one by one and read in pairs, for which the processor waits."""


def build_in_c(source: str, *options: str, headers: dict[str, str] | None = None) -> CDLL | None:
    """A file of this folder as a library, built by gcc; None without a compiler."""
    compiler = os.environ.get("CC") or shutil.which("gcc")
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (headers or {}).items():
            (Path(folder) / name).write_text(text)
        path, made = Path(__file__).with_name(source), Path(folder) / "baseline.so"
        given = ["-std=gnu11", "-shared", "-fPIC", f"-I{folder}", *options]
        subprocess.run([*compiler.split(), *given, path, "-lm", "-ldl", "-o", made], check=True)
        return CDLL(str(made))


def publish(name: str, head: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Print a table, and write it to the results as CSV."""
    text = [[str(cell) for cell in row] for row in rows]
    print(f"\n{name}\n{table(head, text)}")
    RESULTS.mkdir(exist_ok=True)
    with (RESULTS / f"{name}.csv").open("w", newline="") as file:
        csv.writer(file).writerows([head, *text])
