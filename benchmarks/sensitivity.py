"""What does a gradient by 200 parameters cost, in runs of the model itself?

A chain of 100 inertias and 99 damped shafts under a torque step, 0.5 s; the parameters are all
inertias, all stiffnesses and the torque. A run; the gradient of one and of three functionals of it
by the sweep back, and the forward sensitivities by 1, 2 and 4 parameters. CPU times are the best
of several runs in one process, with everything built before; what the first call builds stands
beside it. The error is that of the final speed's derivatives, against a complex step through the
matrix exponential. Ratios are to a run of the accuracy asked for, and ("own runs") to one with the
steps that derivatives need.

Then gradients across events: a rolling mill whose roll gap skids, three clutches, and a play that
is driven to and fro, with one gradient, and those of 1 000 variants on one core and on two.

    python -m benchmarks.sensitivity
"""

import os
import time
from functools import partial

import numpy as np
from scipy.linalg import expm

import lumped as lp
from benchmarks.harness import in_turn, publish
from benchmarks.hybrid import Coupled
from lumped import functionals
from lumped.components import Backlash, Damper, Fixed, Inertia, SpringDamper, Torque
from lumped.gradients.varied import TIGHTER
from lumped.models.reversing_mill import scenes as mill
from lumped.ops import sin

COUNT, END, ROUNDS, RTOL = 100, 0.5, 40, 1e-8
RNG = np.random.default_rng(1)
J = RNG.uniform(0.5, 2.0, COUNT)
C = RNG.uniform(1e4, 5e4, COUNT - 1)
D = RNG.uniform(1.0, 5.0, COUNT - 1)
TORQUE = 100.0
CHECKED = ("body[7].J", "shaft[40].c", "load.tau")
VARIANTS = 1000


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


def derive_expected() -> np.ndarray:
    """Derivatives of the final speed by the checked parameters."""
    h, found = 1e-20, []
    for which, place in ((0, 7), (1, 40), (2, 0)):
        given = [J.astype(complex), C.astype(complex), np.array([TORQUE + 0j])]
        given[which][place] += 1j * h
        found.append(final_speed(given[0], given[1], given[2][0]).imag / h)
    return np.array(found)


def skidding_mill():
    """System, functionals, parameters, end and start values."""
    of = [functionals.peak("upper.spindle.tau"), functionals.rms("upper.shaft.tau")]
    of += [functionals.final("lower.motor.w"), functionals.instant("gap", "forward")]
    system = lp.assemble(mill.pull_apart())
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
    """How many times as fast two cores make many gradients as one; wall times."""
    value = system.parameters[names[0]]
    over = {names[0]: value * np.linspace(0.99, 1.01, VARIANTS)}
    given = {"over": over, "of": of, "by": names, "until": until, "start": start}
    own = sorted(os.sched_getaffinity(0))

    def on_cores(count):
        os.sched_setaffinity(0, own[:count])
        try:
            lp.gradients.gradient_ensemble(system, workers=count, **given)
        finally:
            os.sched_setaffinity(0, own)

    alone, both = in_turn(partial(on_cores, 1), partial(on_cores, 2), rounds=3)
    return alone.seconds / both.seconds


def across_events() -> None:
    """Gradients of runs with events."""
    head = (
        *("drive", "events", "functionals", "parameters", "first call, s", "run, ms"),
        *("gradient, ms", "own runs", "1 000 on two cores over one"),
    )
    rows = []
    for name, case in (
        ("rolling mill that skids", skidding_mill),
        ("three clutches", clutches),
        ("play with impacts", impacts),
    ):
        system, of, names, until, start = case()
        options = {"until": until, "start": start}
        own, slope = in_turn(
            partial(lp.simulate, system, **options, rtol=TIGHTER * 1e-6, grid=None),
            partial(lp.gradient, system, of=of, by=names, **options),
            rounds=ROUNDS,
            clock=time.process_time,
        )
        counts = (str(len(v)) for v in (own.result.events, of, names))
        times = (f"{own.seconds * 1e3:.2f}", f"{slope.seconds * 1e3:.2f}")
        numbers = (f"{slope.first:.2f}", *times, f"{slope.seconds / own.seconds:.1f}")
        rows.append((name, *counts, *numbers, f"{gain(system, of, names, until, start):.2f}"))
    publish("sensitivity_across_events", head, rows)


def main() -> None:
    """Print the tables and write them to the results."""
    system = chain()
    names = [f"body[{i}].J" for i in range(COUNT)] + [f"shaft[{i}].c" for i in range(COUNT - 1)]
    names.append("load.tau")
    speed = f"body[{COUNT - 1}].w"
    final = functionals.final(speed)
    rms, peak = functionals.rms("shaft[50].tau"), functionals.peak("shaft[50].tau")
    run = partial(lp.simulate, system, until=END, grid=None)
    back = partial(lp.gradient, system, by=names, until=END, rtol=RTOL)
    ahead = partial(lp.sensitivity, system, of=[speed], until=END, rtol=RTOL, grid=1)
    cases = [
        ("run", 0, partial(run, rtol=RTOL)),
        ("run with the steps of derivatives", 0, partial(run, rtol=TIGHTER * RTOL)),
        ("sweep back, final value", len(names), partial(back, of=[final])),
        ("sweep back, root mean square", len(names), partial(back, of=[rms])),
        ("sweep back, peak", len(names), partial(back, of=[peak])),
        ("sweep back, all three", len(names), partial(back, of=[final, rms, peak])),
    ]
    for count in (1, 2, 4):
        by = [*CHECKED[:1], *names[50 : 49 + count]]
        cases.append(("sensitivities forward", count, partial(ahead, by=by)))
    actions = [action for *_, action in cases]
    measured, right = in_turn(*actions, rounds=ROUNDS, clock=time.process_time), derive_expected()
    head = ("what", "parameters", "time, ms", "first call, ms", "runs", "own runs", "error", "told")
    text = []
    for (label, count, _), (spent, first, found) in zip(cases, measured, strict=True):
        error = told = ""
        if isinstance(found, lp.gradients.Gradient) and found.of[0].startswith("final"):
            received = np.array([found[found.of[0], name] for name in CHECKED])
            error = f"{np.abs(received / right - 1).max():.1e}"
            told = f"{found.errors[0]:.1e}"
        elif isinstance(found, lp.gradients.Sensitivity):
            error = f"{abs(found.derivatives[-1, 0, 0] / right[0] - 1):.1e}"
        ratios = (f"{spent / run.seconds:.2f}" for run in measured[:2])
        numbers = (f"{spent * 1e3:.1f}", f"{first * 1e3:.0f}", *ratios)
        text.append((label, str(count), *numbers, error, told))
    publish("sensitivity", head, text)
    across_events()


if __name__ == "__main__":
    main()
