"""How near does a run come to a loop written by hand in C?

Three problems, each solved with the same tolerances by `lumped`, by a C loop written by hand
(`time_loop.c`, compiled with gcc -O2) and by SciPy on NumPy: a drive of three masses with steps of
the load, a chain of 300 masses, and four bodies with three clutches. Errors are those at the end
against SciPy at a tight tolerance. The other tables count what an event costs among many friction
elements, and what a run of each published machine takes as a whole and inside the loop.
Times are the best of several runs in one process, with everything compiled; read the ratios.

    python -m benchmarks.time_loop
"""

import ctypes
import itertools
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from scipy.integrate import DOP853, solve_ivp

import lumped as lp
from benchmarks.hybrid import END, ByHand, Coupled, rubbing, timed, write
from lumped.components import Inertia, SpringDamper, Torque
from lumped.models import MACHINES, machine
from lumped.ops import sin, where
from lumped.support.text_table import table
from lumped.timeloop.executable import executable

SOURCE = Path(__file__).with_name("time_loop.c")
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


def own(action, rounds: int) -> tuple[float, float, lp.Trajectory]:
    """Best time of a run, the part of it inside the loop, and the run."""
    inner = np.inf

    def once() -> lp.Trajectory:
        nonlocal inner
        found = action()
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
        n, other = len(system.state_names), None
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
        executable(system).compile()
        options = {"until": until, "rtol": rtol, "grid": [until], "method": "steps"}
        best, inner, run = own(lambda s=system, o=options: lp.simulate(s, **o), rounds)
        x = np.array([run[each][-1] for each in wanted])
        ways += [("lumped, inside the loop", inner, x), ("lumped", best, x)]
        ways.append(("SciPy, NumPy", *timed(other, 10 if n < 100 else 3)))
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
        executable(system).compile()
        options = {"until": 10.0, "rtol": 1e-6, "grid": [10.0], "method": "steps"}
        best, inner, run = own(lambda s=system, o=options: lp.simulate(s, **o), 10)
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


def machines() -> list[tuple[object, ...]]:
    """Runs of published machines from the start points of their scenes."""
    rows: list[tuple[object, ...]] = []
    for name, text in MACHINES.items():
        scene = machine(name).scene(grid=1)
        system, until = scene.system, float(scene.t[-1])
        executable(system).compile()
        options = {"start": scene.point(0.0), "until": until, "rtol": 1e-6, "grid": [until]}
        options["method"] = "steps"
        best, inner, run = own(lambda s=system, o=options: lp.simulate(s, **o), 30)
        rows.append(
            (
                text,
                len(system.state_names),
                f"{until:.3g}",
                run.steps,
                len(run.events),
                f"{best * 1e3:.3f}",
                f"{inner * 1e3:.3f}",
                f"{best / inner:.2f}",
            )
        )
    return rows


def main() -> None:
    """Print the tables and write them beside this script."""
    head = ("problem", "way", "error", "ms", "ratio to the first")
    rows = compared(loops())
    print(table(head, rows))
    write("time_loop_by_hand.csv", head, rows)
    head = ("elements", "changes", "steps", "ms", "ms in the loop", "us per change", "and element")
    rows = elements()
    print("\nBodies that rub on the ground, 10 s, rtol 1e-6\n" + table(head, rows))
    write("time_loop_elements.csv", head, rows)
    head = ("machine", "states", "until, s", "steps", "events", "ms", "ms in the loop", "ratio")
    rows = machines()
    print("\nMachines, rtol 1e-6\n" + table(head, rows))
    write("time_loop_machines.csv", head, rows)


if __name__ == "__main__":
    main()
