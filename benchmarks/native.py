"""How near does a run in machine code come to a loop written by hand in C?

Three problems, each solved with the same tolerances by `lumped` with and without machine code, by
a C loop written by hand (`native_loops.c`, compiled with gcc -O2) and by SciPy on NumPy: a drive
of three masses with steps of the load, a chain of 300 masses, and four bodies with three clutches.
Errors are those at the end against SciPy at a tight tolerance. The other tables count what an event
costs among many friction elements, what machine code brings to published machines, and what comes
before the first result.
Times are the best of several runs in one process; read the ratios.

    python -m benchmarks.native
"""

import ctypes
import itertools
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853, solve_ivp

import lumped as lp
from benchmarks.hybrid import END, ByHand, Coupled, rubbing, timed, write
from lumped.components import Inertia, SpringDamper, Torque
from lumped.models.eccentric_shear.scenes import free_run
from lumped.models.pilger_mill.drive import start_up
from lumped.models.reversing_mill.scenes import skidding
from lumped.models.rotary_arm.control import controlled
from lumped.ops import sin, where
from lumped.support.text_table import table

SOURCE = Path(__file__).with_name("native_loops.c")
MASSES = 300


class Drive(lp.Component):
    """Three masses on damped shafts; the load steps twice."""

    body = [Inertia(J=j) for j in (2.0, 0.5, 1.0)]  # noqa: RUF012
    shaft = [SpringDamper(c=2e4, d=4.0), SpringDamper(c=1e4, d=3.0)]  # noqa: RUF012
    motor: Torque = Torque(tau=40 * sin(30 * lp.time))
    load: Torque = Torque(tau=where(lp.time < 0.5, 0, where(lp.time < 1.2, -100, -30)))

    def connections(self):
        """Join them in a row."""
        b, s = self.body, self.shaft
        yield from lp.chain(self.motor, b[0], s[0], b[1], s[1], b[2])
        yield lp.connect(b[2].flange_b, self.load.flange)


class Chain(lp.Component):
    """A row of equal masses on damped shafts, turned to and fro at one end."""

    body = [Inertia(J=1.0) for _ in range(MASSES)]  # noqa: RUF012
    shaft = [SpringDamper(c=1e4, d=0.5) for _ in range(MASSES - 1)]  # noqa: RUF012
    motor: Torque = Torque(tau=sin(20 * lp.time))

    def connections(self):
        """Join them in a row."""
        yield lp.connect(self.motor.flange, self.body[0].flange_a)
        for i, shaft in enumerate(self.shaft):
            yield from lp.chain(self.body[i], shaft, self.body[i + 1])


def three(t: float, x: np.ndarray) -> np.ndarray:
    """Right-hand side of the drive in NumPy: twists, speeds."""
    twisting = np.diff(x[2:])
    torque = np.array([2e4, 1e4]) * x[:2] + np.array([4.0, 3.0]) * twisting
    load = 0.0 if t < 0.5 else 100.0 if t < 1.2 else 30.0
    ends = np.array([40 * np.sin(30 * t), 0.0, -load])
    ends[:2] += torque
    ends[1:] -= torque
    return np.concatenate([twisting, ends / np.array([2.0, 0.5, 1.0])])


def chain(t: float, x: np.ndarray) -> np.ndarray:
    """Right-hand side of the row in NumPy."""
    twisting = np.diff(x[MASSES - 1 :])
    torque = 1e4 * x[: MASSES - 1] + 0.5 * twisting
    ends = np.zeros(MASSES)
    ends[0] = np.sin(20 * t)
    ends[:-1] += torque
    ends[1:] -= torque
    return np.concatenate([twisting, ends])


def stages() -> str:
    """DOP853's sums, written out in C with the coefficients that SciPy publishes."""

    def total(weights: np.ndarray) -> str:
        terms = [f"{float(w)!r} * (k)[{j} * (n) + i]" for j, w in enumerate(weights) if w]
        return " + ".join(terms)

    lines = []
    for j, (row, c) in enumerate(zip(DOP853.A[1:], DOP853.C[1:], strict=True)):
        lines.append(f"for (int i = 0; i < n; i++) a[i] = x[i] + h * ({total(row)});")
        lines.append(f"rate(t + {float(c)!r} * h, a, k + {j + 1} * n);")
    lines.append(f"for (int i = 0; i < n; i++) new[i] = x[i] + h * ({total(DOP853.B)});")
    body = " \\\n".join(lines)
    return (
        f"#define STAGES(rate, t, h, x, k, a, new, n) \\\n{body}\n"
        f"#define E5(k, n, i) {total(DOP853.E5)}\n#define E3(k, n, i) {total(DOP853.E3)}\n"
    )


def loops() -> ctypes.CDLL | None:
    """The C loops, compiled; None without a compiler."""
    compiler = shutil.which("gcc")
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "stages.h").write_text(stages())
        made = Path(folder) / "loops.so"
        arguments = ["-O2", "-std=c99", "-shared", "-fPIC", "-I", folder, str(SOURCE), "-lm"]
        subprocess.run([compiler, *arguments, "-o", made], check=True)
        return ctypes.CDLL(str(made))


def by_c(library: ctypes.CDLL, name: str, atol: np.ndarray, rtol: float):
    """A run of a C loop as a function without arguments."""
    x = np.zeros(len(atol))
    function = getattr(library, f"run_{name}")
    function.argtypes = [ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p]

    def run() -> np.ndarray:
        function(x.ctypes.data, rtol, atol.ctypes.data)
        return x.copy()

    return run


def by_scipy(rate, edges, n: int, rtol: float):
    """SciPy's DOP853 from edge to edge."""

    def run() -> np.ndarray:
        x = np.zeros(n)
        for begin, end in itertools.pairwise(edges):
            inside = (begin, np.nextafter(end, begin))
            x = solve_ivp(rate, inside, x, "DOP853", rtol=rtol, atol=rtol * 1e-3).y[:, -1]
        return x

    return run


def own(system: lp.System, until: float, rtol: float, choice: str, rounds: int):
    """Best time of a run, the part of it inside the loop, and the states at the end."""
    os.environ["LUMPED_NATIVE"] = choice
    inner, run = np.inf, None

    def once() -> lp.Trajectory:
        nonlocal inner
        found = lp.simulate(system, until=until, rtol=rtol, grid=[until], method="steps")
        inner = min(inner, found.statistics.seconds)
        return found

    best, run = timed(once, rounds)
    return best, inner, run


PROBLEMS = {
    "three masses, 2 s": (Drive, "three", 2.0, 1e-5, 300),
    "300 masses, 1 s": (Chain, "chain", 1.0, 4e-8, 60),
    "three clutches, 1.5 s": (Coupled, "clutches", END, 1e-7, 300),
}


def compared(library: ctypes.CDLL | None) -> list[tuple[object, ...]]:
    """Errors and times of all ways."""
    rows: list[tuple[object, ...]] = []
    for name, (model, c_name, until, rtol, rounds) in PROBLEMS.items():
        system = lp.assemble(model())
        n, other = len(system.states), None
        if c_name == "clutches":
            wanted = [f"body[{i}].w" for i in range(4)]
            reference = ByHand(1e-12).run()
            other = ByHand(rtol).run
        else:
            count = (n + 1) // 2
            wanted = [f"shaft[{i}].phi_rel" for i in range(count - 1)]
            wanted += [f"body[{i}].w" for i in range(count)]
            edges = (0, 0.5, 1.2, 2.0) if c_name == "three" else (0, 1.0)
            rate = three if c_name == "three" else chain
            reference = by_scipy(rate, edges, n, 1e-13)()
            other = by_scipy(rate, edges, n, rtol)
        scale = np.abs(reference).max()
        atol = rtol * 1e-3 * np.array([system.quantity(each).nominal for each in wanted])
        ways = []
        if library is not None:
            # the clutches' loop is of lower order: a tighter tolerance for the same error
            tight = rtol * (0.05 if c_name == "clutches" else 1.0)
            run = by_c(library, c_name, atol, tight)
            ways.append(("C loop", *timed(run, rounds)))
        for choice, label in (("1", "lumped, machine code"), ("0", "lumped, virtual machine")):
            own(system, until, rtol, choice, 2)
            best, inner, run = own(system, until, rtol, choice, rounds if choice == "1" else 5)
            x = np.array([run[each][-1] for each in wanted])
            if choice == "1":
                ways.append(("its loop alone", inner, x))
            ways.append((label, best, x))
        ways.append(("SciPy, NumPy", *timed(other, 3 if n < 100 else 1)))
        first = ways[0][1]
        rows += [
            (
                name,
                way,
                f"{np.abs(x - reference).max() / scale:.1e}",
                f"{seconds * 1e3:.3f}",
                f"{seconds / first:.2f}",
            )
            for way, seconds, x in ways
        ]
    return rows


def elements() -> list[tuple[object, ...]]:
    """What an event costs among many bodies that rub on the ground."""
    rows: list[tuple[object, ...]] = []
    for n in (1, 3, 10, 30, 100):
        system = lp.assemble(rubbing(n))
        own(system, 10.0, 1e-6, "1", 1)
        best, inner, run = own(system, 10.0, 1e-6, "1", 10)
        changes = sum(event.after != "" for event in run.events)
        rows.append(
            (
                n,
                changes,
                run.steps,
                f"{best * 1e3:.2f}",
                f"{inner * 1e3:.2f}",
                f"{inner / changes * 1e6:.1f}",
                f"{inner / changes / n * 1e6:.2f}",
            )
        )
    return rows


SCENES = {
    "shear, two turns": lambda **o: free_run(eps=0.1, **o),
    "rotary arm, one cycle": lambda **o: controlled(**o),
    "pilger mill, start-up": lambda **o: start_up(**o),
    "reversing mill, skidding": lambda **o: skidding(**o),
}


def machines() -> list[tuple[object, ...]]:
    """Runs of published machines with and without machine code: time of the stepping alone."""
    rows: list[tuple[object, ...]] = []
    for name, scene in SCENES.items():
        found = []
        for choice in ("0", "1"):
            os.environ["LUMPED_NATIVE"] = choice
            runs = [scene(rtol=1e-8, grid=[0.0], method="steps") for _ in range(3)]
            found.append(min(run.statistics.seconds for run in runs))
        run = runs[-1]
        slow, fast = found
        rows.append(
            (
                name,
                len(run.system.states),
                run.steps,
                len(run.events),
                f"{slow * 1e3:.1f}",
                f"{fast * 1e3:.2f}",
                f"{slow / fast:.0f}",
            )
        )
    return rows


SETUP = """
import time
begin = time.perf_counter()
import lumped as lp
from benchmarks.native import Drive
loaded = time.perf_counter()
system = lp.assemble(Drive())
run = lp.simulate(system, until=2.0, method="steps")
run["body[2].w"]
print(loaded - begin, time.perf_counter() - loaded, run.statistics.native)
"""


def setup() -> list[tuple[object, ...]]:
    """What comes before the first result, in a new process."""
    rows: list[tuple[object, ...]] = []
    with tempfile.TemporaryDirectory() as folder:
        ways = (("virtual machine", "0"), ("machine code, first ever", "1"), ("again", "1"))
        for label, choice in ways:
            environment = {**os.environ, "LUMPED_NATIVE": choice, "LUMPED_CACHE": folder}
            command = [sys.executable, "-c", SETUP]
            told = subprocess.run(command, env=environment, capture_output=True, text=True)
            imports, rest, method = told.stdout.split(maxsplit=2)
            rows.append((label, f"{float(imports):.2f}", f"{float(rest):.3f}", method.strip()))
    return rows


def main() -> None:
    """Print the tables and write them beside this script."""
    begin = time.perf_counter()
    library = loops()
    head = ("problem", "way", "error", "ms", "ratio to the first")
    rows = compared(library)
    print(table(head, rows))
    write("native_loops.csv", head, rows)
    head = ("elements", "changes", "steps", "ms", "ms in the loop", "us per change", "and element")
    rows = elements()
    print("\nBodies that rub on the ground, 10 s, rtol 1e-6\n" + table(head, rows))
    write("native_elements.csv", head, rows)
    head = ("machine", "states", "steps", "events", "ms in the virtual machine", "ms", "ratio")
    rows = machines()
    print("\nMachines, rtol 1e-8, stepping alone\n" + table(head, rows))
    write("native_machines.csv", head, rows)
    head = ("three masses, new process", "imports, s", "to the first result, s", "native")
    rows = setup()
    print("\n" + table(head, rows))
    write("native_setup.csv", head, rows)
    print(f"\n{time.perf_counter() - begin:.0f} s")


if __name__ == "__main__":
    main()
