"""What do the 20 lowest modes of a long drive cost?

Free chains of 1000 to 100 000 equal inertias and springs: seconds to assemble, seconds and peak of
memory for the modes once the Jacobian is there, and the largest relative error against the closed
form ``2 sqrt(c/J) sin(k pi / 2n) / 2 pi``. CPU times, of the modes the best of three. Each size
runs in a process of its own: its memory is what the modes add to the peak of the process.

    python -m benchmarks.modes
"""

import resource
import subprocess
import sys
import time
from functools import partial

import numpy as np

import lumped as lp
from benchmarks.harness import publish, time_action
from lumped.components import Inertia, Spring

SIZES = (1000, 3000, 10_000, 30_000, 100_000)
COUNT, ROUNDS = 20, 3
J, C = 0.3, 2e4
HEAD = ("inertias", "assemble, s", "modes, s", "us each", "memory, MB", "kB each", "error")


def peak() -> float:
    """Greatest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measure_modes(n: int) -> list[float]:
    """Seconds to assemble, seconds and MB for the modes, relative error."""
    begin = time.process_time()
    system = lp.assemble(
        lp.compose(
            body=[Inertia(J=J) for _ in range(n)],
            shaft=[Spring(c=C) for _ in range(n - 1)],
            connections=lambda m: [
                x for i in range(n - 1) for x in lp.chain(m.body[i], m.shaft[i], m.body[i + 1])
            ],
        )
    )
    point = lp.start_point(system)
    system.state_matrix((point.x, point.theta, point.time, point.settings))
    assembled, before = time.process_time() - begin, peak()
    lowest = partial(lp.modes, system, at=point, near=0.0, count=COUNT)
    found = time_action(lowest, ROUNDS, time.process_time)
    k = np.arange(1, COUNT + 1)
    exact = np.sqrt(C / J) * np.sin(k * np.pi / (2 * n)) / np.pi
    error = float(np.abs(found.result.hertz / exact - 1).max())
    return [assembled, found.seconds, peak() - before, error]


def main() -> None:
    """Print the table and write it to the results."""
    rows = []
    for n in SIZES:
        call = [sys.executable, "-m", "benchmarks.modes", str(n)]
        text = subprocess.run(call, check=True, capture_output=True, text=True).stdout
        assembled, seconds, memory, error = map(float, text.split())
        each = f"{seconds / n * 1e6:.1f}", f"{memory:.0f}", f"{memory / n * 1024:.1f}"
        rows.append((str(n), f"{assembled:.2f}", f"{seconds:.3f}", *each, f"{error:.0e}"))
    publish("modes", HEAD, rows)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(*measure_modes(int(sys.argv[1])))
    else:
        main()
