"""How much of the cores does a sweep of 1 000 variants use?

Strip entry of the reversing mill, 0.5 s, for 25 stiffnesses of the long shaft by 40 creep
coefficients. Perfect use is the time of all runs one after the other in one process, taken from
every tenth of them in the same script, over the number of processes. Read the ratio.

    python -m benchmarks.sweep
"""

import csv
import os
import time
from pathlib import Path

import numpy as np

import lumped as lp
from lumped.models.reversing_mill.stand import (
    C_SHAFT,
    CREEP,
    RATED,
    CreepingGap,
)
from lumped.support.text_table import table

OVER = {
    "upper.shaft.c": np.linspace(0.5, 1.5, 25) * C_SHAFT,
    "K_s": np.linspace(0.5, 1.5, 40) * CREEP,
}
END = 0.5


def peak(run: lp.Trajectory) -> float:
    """Greatest torque of the long shaft, N.m."""
    return float(np.abs(run["upper.shaft.tau"]).max())


def main() -> None:
    """Print the table and write it as CSV."""
    model = CreepingGap().with_({"upper_load.tau": -RATED, "lower_load.tau": -RATED})
    system, cores = lp.assemble(model), os.cpu_count() or 1
    grid = np.array(np.meshgrid(*OVER.values(), indexing="ij")).reshape(2, -1).T
    points = [dict(zip(OVER, row.tolist(), strict=True)) for row in grid]
    peak(lp.simulate(system, until=END))  # what is built once is not counted
    begin = time.perf_counter()
    alone = [peak(lp.simulate(system, until=END, parameters=point)) for point in points[::10]]
    perfect = (time.perf_counter() - begin) * 10 / cores
    rows = []
    for workers in sorted({1, cores}):
        found = lp.sweep(system, over=OVER, until=END, of={"peak": peak}, workers=workers)
        assert not found.failures
        assert (found["peak"][::10] == alone).all()
        use = perfect * cores / workers / found.seconds
        rows.append(
            (str(workers), f"{found.seconds:.2f}", f"{1000 / found.seconds:.0f}", f"{use:.2f}")
        )
    head = ("processes", "time, s", "runs per second", "share of perfect use")
    print(table(head, rows))
    path = Path(__file__).parent / "results" / "sweep.csv"
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


if __name__ == "__main__":
    main()
