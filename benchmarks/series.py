"""Does a Taylor series pay, and is it as quick as that of heyoka?

Three masses under a torque step, 2 s, of `ensembles`: a whole call of `simulate`, one with another
torque than the call before, the loop in it, and a run among 20 000 in lanes that takes the final
speeds; by DOP853, by Taylor's series, and by heyoka.py, one run and four side by side, if it is
installed. The tolerance of each is the loosest of 1e-5, 1e-6, ... that leaves an error of 1e-8 at
the end, relative to the largest speed, against the matrix exponential. Times are the least of
many, and of the processor alone where a call takes long; the ratio is to heyoka of the same kind.

    python -m benchmarks.series
"""

from __future__ import annotations

import csv
import itertools
import time
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import expm

import lumped as lp
from benchmarks._ensemble_tasks import DELAY, ThreeMasses
from lumped import functionals
from lumped.compiler.system import Changes
from lumped.support.text_table import table

END, ALLOWED, RUNS, REPEATED = 2.0, 1e-8, 20_000, 2000
J, C, TORQUE = (0.5, 1.2, 3.0), (4e4, 2.5e4), 100.0
SPEEDS = tuple(f"mass[{i}].w" for i in range(3))
TOLERANCES = tuple(10.0**-k for k in range(5, 13))

Timed = tuple[float, float]
"""Seconds and error."""


def exact() -> np.ndarray:
    """Speeds at the end."""
    twist = np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0]])
    rates = np.zeros((6, 6))
    rates[:2, 2:5] = twist
    rates[2:5, :2] = -(twist.T * np.array(C)) / np.array(J)[:, None]
    rates[2:5, 2:5] = DELAY * rates[2:5, :2] @ twist
    rates[2, 5] = TORQUE / J[0]
    found: np.ndarray = (expm(rates * END) @ np.eye(6)[5])[2:5]
    return found


def least(
    action: Callable[[], Any],
    repeated: int = REPEATED,
    clock: Callable[[], float] = time.perf_counter,
) -> float:
    """Least time of several calls, s."""
    best = np.inf
    for _ in range(repeated):
        begin = clock()
        action()
        best = min(best, clock() - begin)
    return float(best)


def loosest(timed: Callable[[float], Timed]) -> tuple[float, float, float]:
    """Loosest tolerance that is accurate enough; seconds and error with it."""
    for rtol in TOLERANCES:
        seconds, error = timed(rtol)
        if error <= ALLOWED:
            return rtol, seconds, error
    raise RuntimeError("no tolerance is tight enough")


def of_lumped(system: lp.System, right: np.ndarray) -> dict[str, Callable[[float], Timed]]:
    """What is measured of lumped."""
    size = np.abs(right).max()

    def call(method: Any, rtol: float, parameters: Iterable[Changes | None] = (None,)) -> Timed:
        each = itertools.cycle(parameters)

        def run() -> lp.Trajectory:
            options: dict[str, Any] = {"until": END, "rtol": rtol, "method": method}
            return lp.simulate(system, parameters=next(each), grid=[END], **options)

        for _ in range(20):
            found = run()
        error = max(abs(found[n][-1] - r) for n, r in zip(SPEEDS, right, strict=True)) / size
        return least(run), error

    def changing(method: Any, rtol: float) -> Timed:
        return call(method, rtol, [{"motor.tau": 1.5 * TORQUE}, {"motor.tau": TORQUE}])

    def loop(method: Any, rtol: float) -> Timed:
        _, error = call(method, rtol)
        runs = [
            lp.simulate(system, until=END, rtol=rtol, method=method, grid=[END])
            for _ in range(REPEATED)
        ]
        return min(run.statistics.seconds for run in runs), error

    def many(method: Any, rtol: float) -> Timed:
        over = {"motor.tau": np.full(RUNS, TORQUE)}
        of = {name: functionals.final(name) for name in SPEEDS}
        options: dict[str, Any] = {"until": END, "rtol": rtol, "method": method, "workers": 1}
        found = lp.ensemble(system, over=over, of=of, **options)
        error = np.abs(found.values[0] - right).max() / size
        all_runs = partial(lp.ensemble, system, over=over, of=of, **options)
        seconds = least(all_runs, 5, time.process_time)
        return seconds / RUNS, float(error)

    made: dict[str, Callable[[float], Timed]] = {}
    for method, name in (("explicit", "DOP853"), ("taylor", "series")):
        ways = {"call": call, "another torque": changing, "loop": loop, "in lanes": many}
        for what, timed in ways.items():
            made[f"{name}, {what}"] = lambda rtol, timed=timed, method=method: timed(method, rtol)
    return made


def of_heyoka(right: np.ndarray) -> dict[str, Callable[[float], Timed]]:
    """What is measured of heyoka; nothing if it is not installed."""
    try:
        import heyoka
    except ImportError:
        return {}
    size = np.abs(right).max()
    a, b, u, v, w = heyoka.make_vars("a", "b", "u", "v", "w")
    first, second = C[0] * (a + DELAY * (u - v)), C[1] * (b + DELAY * (v - w))
    equations = [
        (a, u - v),
        (b, v - w),
        (u, (TORQUE - first) / J[0]),
        (v, (first - second) / J[1]),
        (w, second / J[2]),
    ]

    def single(rtol: float) -> Timed:
        stepper = heyoka.taylor_adaptive(equations, [0.0] * 5, tol=rtol)

        def run() -> None:
            stepper.state[:] = 0.0
            stepper.time = 0.0
            stepper.propagate_until(END)

        seconds = least(run)
        return seconds, float(np.abs(stepper.state[2:] - right).max() / size)

    def four(rtol: float) -> Timed:
        stepper = heyoka.taylor_adaptive_batch(equations, np.zeros((5, 4)), tol=rtol)

        def run() -> None:
            stepper.state[:] = 0.0
            stepper.set_time(0.0)
            stepper.propagate_until(END)

        seconds = least(run)
        return seconds / 4, float(np.abs(stepper.state[2:, 0] - right).max() / size)

    return {"heyoka, call": single, "heyoka, in lanes": four}


def main() -> None:
    """Print the table and write it as CSV."""
    right, system = exact(), lp.assemble(ThreeMasses())
    found = {
        name: loosest(timed)
        for name, timed in {**of_lumped(system, right), **of_heyoka(right)}.items()
    }
    head = ("what", "rtol", "error", "time, us", "over heyoka")
    rows = []
    for name, (rtol, seconds, error) in found.items():
        peer = found.get("heyoka, in lanes" if "lanes" in name else "heyoka, call")
        ratio = f"{seconds / peer[1]:.2f}" if peer else ""
        rows.append((name, f"{rtol:.0e}", f"{error:.1e}", f"{seconds * 1e6:.1f}", ratio))
    print(table(head, rows))
    path = Path(__file__).parent / "results" / "series.csv"
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


if __name__ == "__main__":
    main()
