"""How near does a run come to a loop written by hand in C?

Three problems, each solved with the same tolerances by `lumped`, by a C loop written by hand
(`time_loop.c`, inlined and tuned for this machine) and by SciPy on NumPy: a drive of three masses
with steps of the load, a chain of 300 masses, and four bodies with three clutches. Errors are those
at the end against SciPy at a tight tolerance. Set-up goes from the description to the end of the
first run, less the best time of a run, with the machine code of lumped's time loop in the cache; of
C it is the compiler's time. Times are the best of several runs in one process; read the ratios.

    python -m benchmarks.time_loop
"""

import itertools
import time
from collections.abc import Callable
from ctypes import CDLL, c_double, c_void_p
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853, solve_ivp

import lumped as lp
from benchmarks.harness import NATIVE, build, build_in_c, publish, run_timed, time_action
from benchmarks.hybrid import END, ByHand, Coupled
from lumped.components import Inertia, SpringDamper, Torque
from lumped.ops import sin, where

Run = Callable[[], np.ndarray]


@dataclass(frozen=True, eq=False)
class Masses:
    """Masses in a row on damped shafts: a sine turns the first, steps of torque the last."""

    J: np.ndarray
    c: np.ndarray
    d: np.ndarray
    amplitude: float
    frequency: float
    edges: tuple[float, ...]
    loads: tuple[float, ...]

    @property
    def names(self) -> list[str]:
        """Twists and speeds."""
        n = len(self.J)
        return [f"shaft[{i}].phi_rel" for i in range(n - 1)] + [f"body[{i}].w" for i in range(n)]

    @property
    def until(self) -> float:
        """End, s."""
        return self.edges[-1]

    def model(self) -> lp.Component:
        """The drive."""
        load = self.loads[-1]
        for edge, value in reversed(list(zip(self.edges[1:-1], self.loads, strict=False))):
            load = where(lp.time < edge, value, load)

        def joints(m):
            for i, shaft in enumerate(m.shaft):
                yield from lp.chain(m.body[i], shaft, m.body[i + 1])
            yield lp.connect(m.motor.flange, m.body[0].flange_a)
            yield lp.connect(m.load.flange, m.body[-1].flange_b)

        return lp.compose(
            body=[Inertia(J=float(J)) for J in self.J],
            shaft=[
                SpringDamper(c=float(c), d=float(d)) for c, d in zip(self.c, self.d, strict=True)
            ],
            motor=Torque(tau=self.amplitude * sin(self.frequency * lp.time)),
            load=Torque(tau=load),
            connections=joints,
        )

    def rate(self, t: float, x: np.ndarray) -> np.ndarray:
        """Right-hand side in NumPy."""
        n = len(self.J)
        twisting = np.diff(x[n - 1 :])
        torque = self.c * x[: n - 1] + self.d * twisting
        ends = np.zeros(n)
        ends[0] = self.amplitude * np.sin(self.frequency * t)
        ends[-1] = self.loads[sum(t >= edge for edge in self.edges[1:-1])]
        ends[:-1] += torque
        ends[1:] -= torque
        return np.concatenate([twisting, ends / self.J])

    def by_scipy(self, rtol: float) -> Run:
        """SciPy's DOP853 from edge to edge."""

        def run() -> np.ndarray:
            x = np.zeros(len(self.names))
            for begin, end in itertools.pairwise(self.edges):
                inside = (begin, np.nextafter(end, begin))
                x = solve_ivp(self.rate, inside, x, "DOP853", rtol=rtol, atol=rtol * 1e-3).y[:, -1]
            return x

        return run


class Clutches:
    """Four bodies and three clutches; SciPy's DOP853 in a loop written by hand."""

    names, until, model = [f"body[{i}].w" for i in range(4)], END, Coupled

    def by_scipy(self, rtol: float) -> Run:
        """A run of the loop."""
        return ByHand(rtol).run


THREE = Masses(
    *(np.array([2.0, 0.5, 1.0]), np.array([2e4, 1e4]), np.array([4.0, 3.0]), 40.0, 30.0),
    edges=(0.0, 0.5, 1.2, 2.0),
    loads=(0.0, -100.0, -30.0),
)
ROW = Masses(np.ones(300), np.full(299, 1e4), np.full(299, 0.5), 1.0, 20.0, (0.0, 1.0), (0.0,))
CASES = {  # problem, its name in C, tolerance, that in C, rounds; C's clutches are of lower order
    "three masses, 2 s": (THREE, "three", 1e-5, 1e-5, 300),
    "300 masses, 1 s": (ROW, "chain", 4e-8, 4e-8, 60),
    "three clutches, 1.5 s": (Clutches(), "clutches", 1e-7, 5e-9, 300),
}


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


def by_c(library: CDLL, name: str, atol: np.ndarray, rtol: float) -> Run:
    """A run of a C loop as a function without arguments."""
    x = np.zeros(len(atol))
    function = getattr(library, f"run_{name}")
    function.argtypes = [c_void_p, c_double, c_void_p]

    def run() -> np.ndarray:
        function(x.ctypes.data, rtol, atol.ctypes.data)
        return x.copy()

    return run


def ways(case, c_name: str, rtol: float, tight: float, rounds: int, library, compiled: float):
    """Label, set-up and time in s, and result of each way."""
    system, made = build(case.model())
    if library is not None:
        atol = rtol * 1e-3 * np.array([system.quantity(name).nominal for name in case.names])
        found = time_action(by_c(library, c_name, atol, tight), rounds)
        yield "C loop", compiled, found.seconds, found.result
    options = {"until": case.until, "rtol": rtol, "grid": [case.until], "method": "steps"}
    found, inner = run_timed(system, rounds, **options)
    made, x = made + found.first - found.seconds, [found.result[name][-1] for name in case.names]
    yield "lumped, inside the loop", made, inner, x
    yield "lumped", made, found.seconds, x
    found = time_action(case.by_scipy(rtol), 10 if len(case.names) < 100 else 3)
    yield "SciPy, NumPy", 0.0, found.seconds, found.result


def main() -> None:
    """Print the table and write it to the results."""
    begin = time.perf_counter()
    library = build_in_c("time_loop.c", *NATIVE, headers={"stages.h": stages()})
    compiled, rows = time.perf_counter() - begin, []
    for problem, (case, *options) in CASES.items():
        reference = case.by_scipy(1e-13 if isinstance(case, Masses) else 1e-12)()
        found = list(ways(case, *options, library, compiled))
        for way, set_up, seconds, x in found:
            error = np.abs(x - reference).max() / np.abs(reference).max()
            cells = (f"{error:.1e}", f"{set_up:.3f}", f"{seconds * 1e3:.3f}")
            rows.append((problem, way, *cells, f"{seconds / found[0][2]:.2f}"))
    head = ("problem", "way", "error", "set-up, s", "ms", "ratio to the first")
    publish("time_loop_by_hand", head, rows)


if __name__ == "__main__":
    main()
