"""How long does the first result of a new process take?

The three masses of `time_loop`, 2 s, no options, one quantity read: from a checkout with nothing
cached, which compiles the time loop; from an installed wheel, which brings its machine code along,
with nothing cached either; and from the checkout with its machine code cached. Beside it the same
with SciPy's DOP853 on NumPy. CPU times with modules in bytecode, the best of several new processes;
the parts are those of the best.

    python -m benchmarks.first_result
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from benchmarks.harness import publish

ROOT = Path(__file__).parent.parent
PARTS = ("import", "assemble", "machine code of the loop", "run and read")
LUMPED = """
from time import process_time as now
times = [now()]
import lumped as lp
from lumped.components import Inertia, SpringDamper, Torque
from lumped.ops import sin, where
lp.assemble, lp.simulate
times.append(now())
class Drive(lp.Component):
    body = [Inertia(J=j) for j in (2.0, 0.5, 1.0)]
    shaft = [SpringDamper(c=2e4, d=4.0), SpringDamper(c=1e4, d=3.0)]
    motor: Torque = Torque(tau=40 * sin(30 * lp.time))
    load: Torque = Torque(tau=where(lp.time < 0.5, 0, where(lp.time < 1.2, -100, -30)))
    def connections(self):
        b, s = self.body, self.shaft
        yield from lp.chain(self.motor, b[0], s[0], b[1], s[1], b[2])
        yield lp.connect(b[2].flange_b, self.load.flange)
system = lp.assemble(Drive())
times.append(now())
from lumped.kernel.engine import time_loop
time_loop()
times.append(now())
lp.simulate(system, until=2.0)["shaft[0].tau"]
times.append(now())
print(*[b - a for a, b in zip(times, times[1:])])
"""
SCIPY = """
from time import process_time as now
times = [now()]
import numpy as np
from scipy.integrate import solve_ivp
times.append(now())
def rate(t, x):
    twisting = np.diff(x[2:])
    torque = np.array([2e4, 1e4]) * x[:2] + np.array([4.0, 3.0]) * twisting
    load = 0.0 if t < 0.5 else 100.0 if t < 1.2 else 30.0
    ends = np.array([40 * np.sin(30 * t), 0.0, -load])
    ends[:2] += torque
    ends[1:] -= torque
    return np.concatenate([twisting, ends / np.array([2.0, 0.5, 1.0])])
x = np.zeros(5)
for a, b in ((0, 0.5), (0.5, 1.2), (1.2, 2.0)):
    x = solve_ivp(rate, (a, b), x, "DOP853", rtol=1e-6, atol=1e-9).y[:, -1]
times.append(now())
print(times[1] - times[0], 0.0, 0.0, times[2] - times[1])
"""


def install(place: Path) -> Path:
    """Folder into which the checkout was installed from its wheel."""
    left = shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__", "docs", "tests")
    source = shutil.copytree(ROOT, place / "source", symlinks=True, ignore=left)
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--target", str(place / "installed")]
    subprocess.run([sys.executable, "-m", "pip", "install", *options, str(source)], check=True)
    return place / "installed"


def measure_program(program: str, cache: str | None, place: Path = ROOT) -> list[float]:
    """Parts of the time of a new process, s; with nothing cached unless a folder is given."""
    with tempfile.TemporaryDirectory() as empty:
        given = {"LUMPED_CACHE": cache or empty, "OMP_NUM_THREADS": "1", "PYTHONPATH": str(place)}
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
        told = subprocess.run(
            [sys.executable, "-c", program],
            env=environment | given,
            cwd=place,
            capture_output=True,
            text=True,
            check=True,
        )
    return [float(part) for part in told.stdout.split()]


def main() -> None:
    """Print the table and write it to the results."""
    with tempfile.TemporaryDirectory() as folder:
        wheel = install(Path(folder))
        measure_program(LUMPED, folder)
        ways = {
            "lumped, nothing cached": [measure_program(LUMPED, None) for _ in range(3)],
            "lumped from a wheel, nothing cached": [
                measure_program(LUMPED, None, wheel) for _ in range(6)
            ],
            "lumped, cached": [measure_program(LUMPED, folder) for _ in range(6)],
            "SciPy DOP853, NumPy": [measure_program(SCIPY, folder) for _ in range(5)],
        }
    best = {way: min(runs, key=sum) for way, runs in ways.items()}
    last = sum(best["SciPy DOP853, NumPy"])
    rows = [
        (way, *(f"{part:.3f}" for part in parts), f"{sum(parts):.3f}", f"{sum(parts) / last:.2f}")
        for way, parts in best.items()
    ]
    head = ("new process", *(f"{part}, s" for part in PARTS), "all, s", "over SciPy")
    publish("first_result", head, rows)


if __name__ == "__main__":
    main()
