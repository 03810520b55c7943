"""What do the 20 lowest modes of a long drive cost, and all modes of a shorter one?

Free chains of 1000 to 100 000 equal inertias and springs: seconds to assemble, seconds and peak of
memory for the modes once the Jacobian is there, and the largest relative error against the closed
form ``2 sqrt(c/J) sin(k pi / 2n) / 2 pi``. CPU times, of the modes the best of three. Each size
runs in a process of its own: its memory is what the modes add to the peak of the process.

The second table is all modes of 2000 inertias: the modes themselves, then their text with the
accuracy of each, and the shares of all components in their energies. With dampers in proportion to
the springs the damping ratio has a closed form too; where every damper is another, the eigenvalues
are those of a dense matrix of 3999 rows, and the error is the largest residual.

    python -m benchmarks.modes
"""

import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from functools import partial

import numpy as np

import lumped as lp
from benchmarks.harness import publish, time_action
from lumped.components import Inertia, Spring, SpringDamper

SIZES = (1000, 3000, 10_000, 30_000, 100_000)
COUNT, ROUNDS = 20, 3
J, C = 0.3, 2e4
ALL, BETA = 2000, 1e-4
DRIVES = ("undamped", "damped in proportion", "any damping")
ALL_HEAD = ("drive of 2000 inertias", "modes, s", "text, s", "energies, s", "in all, s", "error")
HEAD = ("inertias", "assemble, s", "modes, s", "us each", "memory, MB", "kB each", "error")


def peak() -> float:
    """Greatest memory of this process so far, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def chain(shafts: Sequence[lp.Component]) -> lp.System:
    """A free row of equal inertias."""
    n = len(shafts)
    return lp.assemble(
        lp.compose(
            body=[Inertia(J=J) for _ in range(n + 1)],
            shaft=shafts,
            connections=lambda m: [
                x for i in range(n) for x in lp.chain(m.body[i], m.shaft[i], m.body[i + 1])
            ],
        )
    )


def find_frequencies(n: int, count: int) -> np.ndarray:
    """The lowest natural frequencies above zero, rad/s."""
    return 2 * np.sqrt(C / J) * np.sin(np.arange(1, count + 1) * np.pi / (2 * n))


def measure_modes(n: int) -> list[float]:
    """Seconds to assemble, seconds and MB for the modes, relative error."""
    begin = time.process_time()
    system = chain([Spring(c=C) for _ in range(n - 1)])
    point = lp.start_point(system)
    system.state_matrix((point.x, point.theta, point.time, point.settings))
    assembled, before = time.process_time() - begin, peak()
    lowest = partial(lp.modes, system, at=point, near=0.0, count=COUNT)
    found = time_action(lowest, ROUNDS, time.process_time)
    exact = find_frequencies(n, COUNT) / (2 * np.pi)
    error = float(np.abs(found.result.hertz / exact - 1).max())
    return [assembled, found.seconds, peak() - before, error]


def measure_all_modes(drive: str) -> list[float]:
    """Seconds for all modes, their text and their energies; relative error of eigenvalues."""
    spread = np.random.default_rng(0).uniform(0.5, 2.0, ALL - 1)
    damping = {
        "undamped": np.zeros(ALL - 1),
        "damped in proportion": np.full(ALL - 1, BETA * C),
        "any damping": BETA * C * spread,
    }[drive]
    shafts = [SpringDamper(c=C, d=float(d)) if d else Spring(c=C) for d in damping]
    system = chain(shafts)
    point = lp.start_point(system)
    system.state_matrix((point.x, point.theta, point.time, point.settings))
    seconds = [time.process_time()]
    modes = lp.modes(system, at=point)
    seconds.append(time.process_time())
    repr(modes)
    seconds.append(time.process_time())
    lp.vibration.modal_energies(modes)
    seconds.append(time.process_time())
    w = find_frequencies(ALL, ALL - 1)
    half = 0.5 * damping[0] / C * w**2
    exact = -half + 1j * np.sqrt(w**2 - half**2)
    error = (
        np.abs(modes.eigenvalues / exact - 1) if drive in DRIVES[:2] else modes.accuracy.residuals
    )
    return [*np.diff(seconds), seconds[-1] - seconds[0], float(error.max())]


def measure_apart(what: object) -> list[float]:
    """What a process of its own measures."""
    call = [sys.executable, "-m", "benchmarks.modes", str(what)]
    text = subprocess.run(call, check=True, capture_output=True, text=True).stdout
    return [float(number) for number in text.split()]


def main() -> None:
    """Print the tables and write them to the results."""
    rows = []
    for n in SIZES:
        assembled, seconds, memory, error = measure_apart(n)
        each = f"{seconds / n * 1e6:.1f}", f"{memory:.0f}", f"{memory / n * 1024:.1f}"
        rows.append((str(n), f"{assembled:.2f}", f"{seconds:.3f}", *each, f"{error:.0e}"))
    publish("modes", HEAD, rows)
    rows = []
    for drive in DRIVES:
        *seconds, error = measure_apart(drive)
        rows.append((drive, *(f"{s:.1f}" for s in seconds), f"{error:.0e}"))
    publish("modes_all", ALL_HEAD, rows)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        what = sys.argv[1]
        print(*(measure_all_modes(what) if what in DRIVES else measure_modes(int(what))))
    else:
        main()
