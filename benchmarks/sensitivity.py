"""What does a gradient by 200 parameters cost, in runs of the model itself?

A chain of 100 inertias and 99 damped shafts under a torque step, 0.5 s; the parameters are all
inertias, all stiffnesses and the torque. A run; the gradient of one and of three functionals of it
by the sweep back, and the forward sensitivities by 1, 2 and 4 parameters. CPU times are the best
of several runs in one process, with everything built before; what the first call builds stands
beside it. The error is that of the final speed's derivatives, against a complex step through the
matrix exponential. Ratios are to a run of the accuracy asked for, and ("own runs") to one with the
steps that derivatives need.

    python -m benchmarks.sensitivity
"""

import csv
import time
from pathlib import Path

import numpy as np
from scipy.linalg import expm

import lumped as lp
from lumped import functionals
from lumped.components import Inertia, SpringDamper, Torque
from lumped.gradients.varied import TIGHTER
from lumped.support.text_table import table

COUNT, END, ROUNDS, RTOL = 100, 0.5, 40, 1e-8
RNG = np.random.default_rng(1)
J = RNG.uniform(0.5, 2.0, COUNT)
C = RNG.uniform(1e4, 5e4, COUNT - 1)
D = RNG.uniform(1.0, 5.0, COUNT - 1)
TORQUE = 100.0
CHECKED = ("body[7].J", "shaft[40].c", "load.tau")


def chain() -> lp.System:
    """The drive."""

    def joints(m):
        yield from lp.chain(m.load, m.body[0])
        for i in range(COUNT - 1):
            yield from lp.chain(m.body[i], m.shaft[i], m.body[i + 1])

    return lp.assemble(
        lp.compose(
            load=Torque(tau=TORQUE),
            body=[Inertia(J=float(j)) for j in J],
            shaft=[SpringDamper(c=float(c), d=float(d)) for c, d in zip(C, D, strict=True)],
            connections=joints,
        )
    )


def final_speed(inertia: np.ndarray, stiffness: np.ndarray, torque: complex) -> complex:
    """Speed of the last body at the end."""
    twist = np.zeros((COUNT - 1, COUNT))
    twist[np.arange(COUNT - 1), np.arange(COUNT - 1)] = -1.0
    twist[np.arange(COUNT - 1), np.arange(1, COUNT)] = 1.0
    n = 2 * COUNT - 1
    a = np.zeros((n + 1, n + 1), dtype=complex)
    a[: COUNT - 1, COUNT - 1 : n] = twist
    a[COUNT - 1 : n, : COUNT - 1] = -(twist.T * stiffness) / inertia[:, None]
    a[COUNT - 1 : n, COUNT - 1 : n] = -(twist.T * D) @ twist / inertia[:, None]
    a[COUNT - 1, n] = torque / inertia[0]
    return expm(a * END)[n - 1, n]


def expected() -> np.ndarray:
    """Derivatives of the final speed by the checked parameters."""
    h, found = 1e-20, []
    for which, place in ((0, 7), (1, 40), (2, 0)):
        given = [J.astype(complex), C.astype(complex), np.array([TORQUE + 0j])]
        given[which][place] += 1j * h
        found.append(final_speed(given[0], given[1], given[2][0]).imag / h)
    return np.array(found)


def timed(actions) -> list[tuple[float, float, object]]:
    """Of each action: time of the first call, best time of several more, and the last result.

    They take turns, so that a slow moment of the machine meets all of them.
    """
    first, best, results = [], [np.inf] * len(actions), [None] * len(actions)
    for action in actions:
        begin = time.process_time()
        action()
        first.append(time.process_time() - begin)
    for _ in range(ROUNDS):
        for i, action in enumerate(actions):
            begin = time.process_time()
            results[i] = action()
            best[i] = min(best[i], time.process_time() - begin)
    return list(zip(first, best, results, strict=True))


def main() -> None:
    """Print the table and write it as CSV."""
    system = chain()
    names = [f"body[{i}].J" for i in range(COUNT)] + [f"shaft[{i}].c" for i in range(COUNT - 1)]
    names.append("load.tau")
    final = functionals.final(f"body[{COUNT - 1}].w")
    rms, peak = functionals.rms("shaft[50].tau"), functionals.peak("shaft[50].tau")
    rows: list = [("run", 0), ("run with the steps of derivatives", 0)]
    actions: list = [
        lambda rtol=rtol: lp.simulate(system, until=END, rtol=rtol, grid=None)
        for rtol in (RTOL, TIGHTER * RTOL)
    ]
    for label, of in (
        ("sweep back, final value", [final]),
        ("sweep back, root mean square", [rms]),
        ("sweep back, peak", [peak]),
        ("sweep back, all three", [final, rms, peak]),
    ):
        rows.append((label, len(names)))
        actions.append(lambda of=of: lp.gradient(system, of=of, to=names, until=END, rtol=RTOL))
    for count in (1, 2, 4):
        to = [*CHECKED[:1], *names[50 : 49 + count]]
        rows.append(("sensitivities forward", count))
        actions.append(
            lambda to=to: lp.sensitivity(
                system, of=[final.name], to=to, until=END, rtol=RTOL, grid=1
            )
        )
    measured, right = timed(actions), expected()
    head = ("what", "parameters", "time, ms", "first call, ms", "runs", "own runs", "error", "told")
    text = []
    for (label, count), (first, spent, found) in zip(rows, measured, strict=True):
        error = told = ""
        if isinstance(found, lp.gradients.Gradient) and found.of[0].startswith("final"):
            received = np.array([found[found.of[0], name] for name in CHECKED])
            error = f"{np.abs(received / right - 1).max():.1e}"
            told = f"{found.errors[0]:.1e}"
        elif isinstance(found, lp.gradients.Sensitivity):
            error = f"{abs(found.values[-1, 0, 0] / right[0] - 1):.1e}"
        ratios = (f"{spent / run[1]:.2f}" for run in measured[:2])
        numbers = (f"{spent * 1e3:.1f}", f"{first * 1e3:.0f}", *ratios)
        text.append((label, str(count), *numbers, error, told))
    print(table(head, text))
    path = Path(__file__).parent / "results" / "sensitivity.csv"
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([head, *text])


if __name__ == "__main__":
    main()
