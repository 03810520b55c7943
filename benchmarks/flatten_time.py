"""Does the cost of assembling grow linearly with the number of components?

A free chain of N inertias and N - 1 springs, from objects to a callable right-hand side.
Every size is timed several times in turn and the best time of each is kept; figures of different
runs differ with the machine's load, so read the ratios.

    python -m benchmarks.flatten_time
"""

import csv
import gc
import time
from pathlib import Path

import lumped as lp
from lumped.components import Inertia, Spring
from lumped.table import table

SIZES = (30, 100, 300, 1000, 3000, 10_000)
ROUNDS = 5


def chain(n: int) -> lp.Component:
    """Free chain of n inertias."""
    return lp.compose(
        body=[Inertia(J=1.0) for _ in range(n)],
        shaft=[Spring(c=1e3) for _ in range(n - 1)],
        connections=lambda m: (
            joint for i in range(n - 1) for joint in lp.chain(m.body[i], m.shaft[i], m.body[i + 1])
        ),
    )


def timed(n: int) -> tuple[float, float]:
    """Seconds to assemble, and to build the right-hand side."""
    gc.collect()
    begin = time.perf_counter()
    system = lp.assemble(chain(n))
    middle = time.perf_counter()
    function = system.rhs
    end = time.perf_counter()
    assert function.size1_out(0) == 2 * n - 1
    return middle - begin, end - middle


def main() -> None:
    """Print the table and write it as CSV."""
    timed(10)  # imports and first calls
    best: dict[int, tuple[float, float]] = {}
    for _ in range(ROUNDS):
        for n in SIZES:
            found = timed(n)
            best[n] = min(best.get(n, found), found, key=sum)
    reference = sum(best[300]) / 599
    rows = []
    for n in SIZES:
        assemble, build = best[n]
        each = (assemble + build) / (2 * n - 1)
        rows.append(
            (
                str(2 * n - 1),
                f"{assemble:.4f}",
                f"{build:.4f}",
                f"{each * 1e6:.1f}",
                f"{each / reference:.2f}",
            )
        )
    head = ("components", "assemble, s", "build rhs, s", "us/component", "ratio to 599")
    print(table(head, rows))
    path = Path(__file__).parent / "results" / "flatten_time.csv"
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


if __name__ == "__main__":
    main()
