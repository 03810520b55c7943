"""How much error does a run have for its time, and how does that compare with SciPy?

Strip entry of the reversing mill with closed gap, 2 s: undamped, two motors, loads stepping at the
start. The exact answer is a matrix exponential; the baseline is SciPy's DOP853 on a right-hand
side written by hand in NumPy. Times are the best of several runs in one process; read the ratios.

    python -m benchmarks.simulate_mill
"""

import csv
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import lumped as lp
from lumped.components import Inertia, Spring, Torque
from lumped.support.text_table import table

KGF = 9.80665
J = np.array([3.01, 2.45, 0.32, 5.46]) * KGF
C = np.array([2.62e4, 0.918e4, 0.918e4]) * KGF
PAIRS = ((0, 1), (1, 2), (3, 2))
LOAD = np.array([1.0, 0.0, -2.0, 1.0]) * 365 * KGF
END, ROUNDS = 2.0, 7


class Mill(lp.Component):
    """Four inertias, three shafts, constant torques: J a = T, tau = c phi_rel."""

    body = [Inertia(J=j) for j in J]  # noqa: RUF012
    shaft = [Spring(c=c) for c in C]  # noqa: RUF012
    load = [Torque(tau=t) for t in LOAD]  # noqa: RUF012

    def connections(self):
        """Join the shafts and loads to the bodies."""
        for (i, j), shaft in zip(PAIRS, self.shaft, strict=True):
            yield lp.connect(self.body[i].flange_b, shaft.flange_a)
            yield lp.connect(self.body[j].flange_b, shaft.flange_b)
        for body, load in zip(self.body, self.load, strict=True):
            yield lp.connect(load.flange, body.flange_a)


def incidence() -> np.ndarray:
    """Twist of each shaft by the angles of the bodies."""
    b = np.zeros((3, 4))
    for row, (i, j) in enumerate(PAIRS):
        b[row, i], b[row, j] = -1, 1
    return b


def hand_written(_: float, x: np.ndarray) -> np.ndarray:
    """Right-hand side in NumPy: three twists, four speeds."""
    return np.concatenate([B @ x[3:], (LOAD - B.T @ (C * x[:3])) / J])


B = incidence()


def exact() -> np.ndarray:
    """Twists at the end, by the matrix exponential."""
    a = np.zeros((8, 8))
    a[:3, 3:7] = B
    a[3:7, :3] = -(B.T * C) / J[:, None]
    a[3:7, 7] = LOAD / J
    return expm(a * END)[:3, 7]


def timed(action) -> tuple[float, object]:
    """Best time of several runs, and the last result."""
    best = np.inf
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        result = action()
        best = min(best, time.perf_counter() - begin)
    return best, result


def main() -> None:
    """Print the table and write it as CSV."""
    system = lp.assemble(Mill())
    expected = exact()
    names = [f"shaft[{i}].phi_rel" for i in range(3)]
    rows = []
    for rtol in (1e-4, 1e-6, 1e-8, 1e-10):
        base, found = timed(
            lambda rtol=rtol: solve_ivp(
                hand_written, (0, END), np.zeros(7), "DOP853", rtol=rtol, atol=rtol * 1e-3
            )
        )
        scale = np.abs(expected).max()
        error = np.abs(found.y[:3, -1] - expected).max() / scale
        steps = len(found.t) - 1
        rows.append(("SciPy DOP853, NumPy", rtol, error, base, steps, 1.0))
        for method in ("explicit", "implicit"):
            spent, run = timed(
                lambda rtol=rtol, method=method: lp.simulate(
                    system, until=END, rtol=rtol, method=method, grid=[END]
                )
            )
            error = np.abs([run[n][-1] for n in names] - expected).max() / scale
            rows.append((f"lumped {method}", rtol, error, spent, run.steps, base / spent))
    head = ("method", "rtol", "error", "time, ms", "steps", "times faster")
    text = [
        (m, f"{r:.0e}", f"{e:.1e}", f"{s * 1e3:.2f}", str(n), f"{f:.1f}")
        for m, r, e, s, n, f in rows
    ]
    print(table(head, text))
    path = Path(__file__).parent / "results" / "simulate_mill.csv"
    path.parent.mkdir(exist_ok=True)
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *text])


if __name__ == "__main__":
    main()
