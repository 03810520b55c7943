"""Does the cost of assembling grow linearly with the number of components, whatever the topology?

From objects to a callable right-hand side. Every size is timed several times in turn and the best
time of each is kept; figures of different runs differ with the machine's load, so read the ratios.
The second table says what comes out: states against the least possible number, operations of the
right-hand side against those of one written by hand, and memory.

    python -m benchmarks.flatten_time [--large]

`--large` adds a chain of 100 000 components.
"""

import csv
import gc
import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import casadi as ca
import numpy as np
from matplotlib.figure import Figure

import lumped as lp
from lumped.components import IdealGear, Inertia, Spring, SpringDamper
from lumped.table import table

SIZES = (10, 30, 100, 300, 600, 1000, 3000, 10_000, 30_000)
REFERENCE, COUNTED, MEASURED, LARGE = 600, 3000, 10_000, 100_000
ROUNDS, LONG = 3, 2.0  # what takes longer than so many seconds is timed once
RESULTS = Path(__file__).parent / "results"

Made = tuple[lp.Component, int]
"""A model and the least number of states."""


def shafts(pairs: list[tuple[int, int]], n: int) -> Made:
    """Free inertias joined by springs, as a tree."""
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        shaft=[Spring(c=1e3) for _ in pairs],
        connections=lambda m: (
            joint
            for (i, j), shaft in zip(pairs, m.shaft, strict=True)
            for joint in lp.chain(m.body[i], shaft, m.body[j])
        ),
    )
    return model, 2 * n - 1


def chain(size: int) -> Made:
    """Inertias and springs in a row."""
    n = (size + 1) // 2
    return shafts([(i, i + 1) for i in range(n - 1)], n)


def tree(size: int) -> Made:
    """Two springs on each inertia."""
    n = (size + 1) // 2
    return shafts([((i - 1) // 2, i) for i in range(1, n)], n)


def star(size: int) -> Made:
    """All springs on one inertia."""
    n = (size + 1) // 2
    return shafts([(0, i) for i in range(1, n)], n)


def gear_ladder(size: int) -> Made:
    """Inertias and rigid gears in a row."""
    n = (size + 1) // 2
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        gear=[IdealGear(ratio=1.1 if i % 2 else -0.9) for i in range(n - 1)],
        connections=lambda m: (
            joint for i in range(n - 1) for joint in lp.chain(m.body[i], m.gear[i], m.body[i + 1])
        ),
    )
    return model, 1


def geared_chain(size: int) -> Made:
    """Inertias in a row, with a spring and a gear between them."""
    n = max((size + 2) // 3, 2)
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        shaft=[Spring(c=1e3) for _ in range(n - 1)],
        gear=[IdealGear(ratio=1.1 if i % 2 else -0.9) for i in range(n - 1)],
        connections=lambda m: (
            joint
            for i in range(n - 1)
            for joint in lp.chain(m.body[i], m.shaft[i], m.gear[i], m.body[i + 1])
        ),
    )
    return model, 2 * n - 1


def rigid(size: int) -> Made:
    """Inertias in a row, joined directly."""
    model = lp.compose(
        body=[Inertia(J=1.0) for _ in range(size)],
        connections=lambda m: lp.chain(*m.body),
    )
    return model, 1


def random_drive(size: int) -> Made:
    """Each inertia on one of the eight before it by a spring or gear; a tenth more in loops."""
    rng = np.random.default_rng(size)
    n = max(round(size / 2.1), 2)
    pairs = [(int(rng.integers(max(0, i - 8), i)), i) for i in range(1, n)]
    geared = rng.random(n - 1) < 0.2
    speed = np.ones(n)  # of each inertia in a rigid motion
    for (i, j), gear in zip(pairs, geared, strict=True):
        speed[j] = speed[i] / 2 if gear else speed[i]
    ends = rng.integers(8, n, n // 10) if n > 8 else np.zeros(0, dtype=int)
    loops = [(int(j - rng.integers(1, 9)), int(j)) for j in ends]
    elastic = [p for p, gear in zip(pairs, geared, strict=True) if not gear] + loops
    rigid_pairs = [p for p, gear in zip(pairs, geared, strict=True) if gear]
    parts = {"body": [Inertia(J=j) for j in rng.uniform(0.5, 2, n)]}
    parts["shaft"] = [SpringDamper(c=c, d=0.1) for c in rng.uniform(100, 1000, len(elastic))]
    if rigid_pairs:
        parts["gear"] = [IdealGear(ratio=2.0) for _ in rigid_pairs]
    model = lp.compose(
        **parts,
        connections=lambda m: (
            joint
            for (i, j), part in zip(
                elastic + rigid_pairs, [*m.shaft, *(m.gear if rigid_pairs else ())], strict=True
            )
            for joint in lp.chain(m.body[i], part, m.body[j])
        ),
    )
    turns = all(speed[i] == speed[j] for i, j in loops)
    return model, 2 * (n - len(rigid_pairs)) - turns


TOPOLOGIES: dict[str, Callable[[int], Made]] = {
    "chain": chain,
    "tree": tree,
    "star": star,
    "gear ladder": gear_ladder,
    "geared chain": geared_chain,
    "rigid couplings": rigid,
    "random drive": random_drive,
}


def by_hand(n: int, geared: bool) -> ca.Function:
    """Right-hand side of the chains as one would write it, ``tau = c (twist - rest)``."""
    twist, w = ca.SX.sym("twist", n - 1), ca.SX.sym("w", n)
    J, ratio = ca.SX.sym("J", n), ca.SX.sym("ratio", n - 1 if geared else 0)
    c, rest = ca.SX.sym("c", n - 1), ca.SX.sym("rest", n - 1)
    tau = c * (twist - rest)
    reflected = ratio * w[1:] if geared else w[1:]
    passed = ratio * tau if geared else tau
    torque = ca.vertcat(tau, 0) - ca.vertcat(0, passed)
    return ca.Function(
        "rhs",
        [ca.vertcat(twist, w), ca.vertcat(J, c, rest, ratio)],
        [ca.vertcat(reflected - w[:-1], torque / J)],
    )


def timed(name: str, size: int) -> tuple[float, float, int]:
    """Seconds to assemble and to build the right-hand side; number of components."""
    gc.collect()
    begin = time.perf_counter()
    system = lp.assemble(TOPOLOGIES[name](size)[0])
    middle = time.perf_counter()
    function = system.rhs
    end = time.perf_counter()
    assert function.size1_out(0) == len(system.states)
    return middle - begin, end - middle, system.report()["components"] - 1


def memory(name: str, size: int) -> float:
    """Peak memory of assembling and building the right-hand side in kB for each component.

    To be called in a process of its own.
    """
    assert lp.assemble(TOPOLOGIES[name](10)[0]).rhs
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    system = lp.assemble(TOPOLOGIES[name](size)[0])
    assert system.rhs
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return (peak - before) / (system.report()["components"] - 1)


def times(large: bool) -> dict[str, list[tuple[int, float, float]]]:
    """Components and best times of each topology."""
    best: dict[tuple[str, int], tuple[float, float, int]] = {}
    plan = [(name, size) for name in TOPOLOGIES for size in SIZES]
    if large:
        plan.append(("chain", LARGE))
    for _ in range(ROUNDS):
        for key in plan:
            if key not in best or sum(best[key][:2]) < LONG:
                found = timed(*key)
                best[key] = min(best.get(key, found), found, key=lambda f: f[0] + f[1])
    return {
        name: [(c, a, b) for (own, _), (a, b, c) in sorted(best.items()) if own == name]
        for name in TOPOLOGIES
    }


def time_rows(found: dict[str, list[tuple[int, float, float]]]) -> list[tuple[str, ...]]:
    """The table of times."""
    rows = []
    for name, own in found.items():
        each = {count: (a + b) / count for count, a, b in own}
        reference = each[min(each, key=lambda count: abs(count - REFERENCE))]
        for count, a, b in own:
            cells = (f"{a:.4f}", f"{b:.4f}", f"{each[count] * 1e6:.1f}")
            rows.append((name, str(count), *cells, f"{each[count] / reference:.2f}"))
    return rows


def outcome_rows() -> list[tuple[str, ...]]:
    """The table of states, operations and memory.

    A child's peak begins with the size of its parent, so this comes before all large models.
    """
    rows, kilobytes = [], {}
    for name in TOPOLOGIES:
        with ProcessPoolExecutor(1, get_context("spawn")) as alone:
            kilobytes[name] = alone.submit(memory, name, MEASURED).result()
    for name, make in TOPOLOGIES.items():
        model, least = make(COUNTED)
        system = lp.assemble(model)
        operations, hand = system.rhs.n_instructions(), ""
        if name in ("chain", "geared chain"):
            n = (least + 1) // 2
            hand = str(by_hand(n, name != "chain").n_instructions())
        count = system.report()["components"] - 1
        cells = (str(count), str(len(system.states)), str(least), str(operations), hand)
        rows.append((name, *cells, f"{kilobytes[name]:.1f}"))
    return rows


def picture(found: dict[str, list[tuple[int, float, float]]]) -> Figure:
    """Cost per component over the size, one line for each topology."""
    figure = Figure((8, 4.8), layout="constrained")
    axis = figure.subplots()
    for (name, own), marker in zip(found.items(), "osD^v<>", strict=True):
        counts = [count for count, _, _ in own]
        axis.loglog(
            *(counts, [(a + b) / count * 1e6 for count, a, b in own]),
            f"{marker}-",
            markersize=4,
            label=name,
        )
    axis.set_xlabel("components")
    axis.set_ylabel("assemble and build the right-hand side,\nmicroseconds per component")
    axis.grid(which="both", alpha=0.3)
    axis.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False)
    return figure


def write(name: str, rows: list[tuple[str, ...]]) -> None:
    """Print a table and write it as CSV."""
    print(table(rows[0], rows[1:]), end="\n\n")
    with (RESULTS / name).open("w", newline="") as file:
        csv.writer(file).writerows(rows)


def main() -> None:
    """Print the tables, write them as CSV, and draw the times."""
    RESULTS.mkdir(exist_ok=True)
    outcome = outcome_rows()
    found = times("--large" in sys.argv)
    heads = ("topology", "components", "assemble, s", "build rhs, s", "us/component")
    write("flatten_time.csv", [(*heads, f"ratio to {REFERENCE}"), *time_rows(found)])
    heads = ("topology", "components", "states", "least", "operations", "by hand", "kB/component")
    write("flatten_outcome.csv", [heads, *outcome])
    picture(found).savefig(RESULTS / "flatten_time.png", dpi=150)


if __name__ == "__main__":
    main()
