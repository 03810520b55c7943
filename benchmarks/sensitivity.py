"""What does a gradient by 200 parameters cost, in runs of the model itself?

A chain of 100 inertias and 99 damped shafts under a torque step, 0.5 s; the parameters are all
inertias, all stiffnesses and the torque. A run; the gradient of one and of three functionals of it
by the sweep back, and the forward sensitivities by 1, 2 and 4 parameters. CPU times are the best
of several runs in one process, with everything built before; what the first call builds stands
beside it. The error is that of the final speed's derivatives, against a complex step through the
matrix exponential. Ratios are to a run of the accuracy asked for, and ("own runs") to one with the
steps that derivatives need.

Then gradients across events: a rolling mill whose roll gap skids, three clutches, and a play that
is driven to and fro, with one gradient and with those of many variants in threads.

    python -m benchmarks.sensitivity
"""

import csv
import time
from pathlib import Path

import numpy as np
from scipy.linalg import expm

import lumped as lp
from benchmarks.hybrid import Coupled
from lumped import functionals
from lumped.components import Backlash, Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.gradients.varied import TIGHTER
from lumped.models.reversing_mill import scenes as mill
from lumped.ops import sin
from lumped.support.text_table import table

COUNT, END, ROUNDS, RTOL = 100, 0.5, 40, 1e-8
RNG = np.random.default_rng(1)
J = RNG.uniform(0.5, 2.0, COUNT)
C = RNG.uniform(1e4, 5e4, COUNT - 1)
D = RNG.uniform(1.0, 5.0, COUNT - 1)
TORQUE = 100.0
CHECKED = ("body[7].J", "shaft[40].c", "load.tau")
VARIANTS = 200
RESULTS = Path(__file__).parent / "results"


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


def skidding_mill():
    """System, functionals, parameters, end and start values."""
    of = [functionals.peak("upper.spindle.tau"), functionals.rms("upper.shaft.tau")]
    of += [functionals.final("lower.motor.w"), functionals.instant("gap", "forward")]
    system = lp.assemble(mill.pulled_apart())
    return system, of, list(system.parameters)[:20], 0.2, dict.fromkeys(mill.SHAFTS, mill.RATED)


def clutches():
    """The same of four inertias and three clutches."""
    of = [functionals.final("body[0].w"), functionals.rms("body[2].w")]
    of += [functionals.instant("clutch[1]", "stuck"), functionals.peak("body[1].w")]
    names = [*(f"body[{i}].J" for i in range(4)), *(f"clutch[{i}].f_max" for i in range(3))]
    return lp.assemble(Coupled()), of, names, 1.5, {}


def impacts():
    """The same of two inertias with a rigid play between them."""
    model = lp.compose(
        push=Torque(tau=2.0 * sin(9.0 * lp.time)),
        a=Inertia(J=0.2, phi=0.0),
        play=Backlash(b=0.06, restitution=0.4),
        b=Inertia(J=0.5, phi=0.0),
        oil=Damper(d=0.4),
        wall=Fixed(),
        connections=lambda m: lp.chain(m.push, m.a, m.play, m.b, m.oil, m.wall),
    )
    of = [functionals.final("b.phi"), functionals.loss("play"), functionals.instant("play", "")]
    names = ["a.J", "b.J", "play.b", "play.restitution", "oil.d"]
    return lp.assemble(model, keep=["b.phi"]), of, names, 0.7, {}


def gain(system, of, names, until, start) -> float:
    """How many times as fast two threads make many gradients as one; wall times."""
    value = system.parameters[names[0]]
    over = {names[0]: value * np.linspace(0.99, 1.01, VARIANTS)}
    best = [np.inf, np.inf]
    for _ in range(4):
        for i, workers in enumerate((1, 2)):
            begin = time.perf_counter()
            lp.gradients.gradient_ensemble(
                system, over=over, of=of, to=names, until=until, start=start, workers=workers
            )
            best[i] = min(best[i], time.perf_counter() - begin)
    return best[0] / best[1]


def across_events() -> None:
    """Gradients of runs with events, as a table and as CSV."""
    head = (
        *("drive", "events", "functionals", "parameters", "run, ms", "gradient, ms", "own runs"),
        "two threads over one",
    )
    rows = []
    for name, case in (
        ("rolling mill that skids", skidding_mill),
        ("three clutches", clutches),
        ("play with impacts", impacts),
    ):
        system, of, names, until, start = case()
        options = {"until": until, "start": start}
        (_, own, run), (_, spent, _) = timed(
            [
                lambda s=system, o=options: lp.simulate(s, **o, rtol=TIGHTER * 1e-6, grid=None),
                lambda s=system, o=options, of=of, to=names: lp.gradient(s, of=of, to=to, **o),
            ]
        )
        counts = (str(len(v)) for v in (run.events, of, names))
        numbers = (f"{own * 1e3:.2f}", f"{spent * 1e3:.2f}", f"{spent / own:.1f}")
        rows.append((name, *counts, *numbers, f"{gain(system, of, names, until, start):.2f}"))
    print(table(head, rows))
    _write("sensitivity_across_events", head, rows)


def _write(name, head, rows) -> None:
    with (RESULTS / f"{name}.csv").open("w", newline="") as file:
        csv.writer(file).writerows([head, *rows])


def main() -> None:
    """Print the tables and write them as CSV."""
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
    _write("sensitivity", head, text)
    across_events()


if __name__ == "__main__":
    main()
