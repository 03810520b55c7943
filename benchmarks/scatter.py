"""What does a scatter study of 100 000 variants cost, against the same variants one by one?

Quantiles of the peak torque of the reversing mill whose gap skids, by runs in the time loop on all
cores, against `simulate` called for one variant after the other, whose peak is that of its output
times; natural frequencies and their derivatives, side by side against `modes` and
`eigen_sensitivity` of each. Those one by one are some of the variants, their time that of all. Both
ways in turn in one process, the least of three; times of the processor, as other work disturbs
those of the clock. Read the ratios; the cores come on top of them.

Then the share of that time which is spent inside the compiled loop, forth and back, for the scatter
of the mill and for an optimum of the three masses of `time_loop` by gradients of whole runs.

    python -m benchmarks.scatter
"""

import os
import threading
import time
from collections.abc import Callable
from unittest import mock

import numpy as np

import lumped as lp
from benchmarks.harness import in_turn, publish
from benchmarks.time_loop import THREE
from lumped import functionals as fun
from lumped.ensembles import scaled, truncated
from lumped.kernel import engine
from lumped.models.reversing_mill.scenes import pull_apart
from lumped.models.reversing_mill.stand import RATED, SHAFTS, ClosedGap
from lumped.tolerances.scene import scene_of

RUNS, ALONE, TURNS = 100_000, 100, 3
SCENE = {"until": 0.4, "start": dict.fromkeys(SHAFTS, RATED)}
STIFFNESS = scaled(lp.normal(1.0, 0.03))
SHAFT_TOLERANCES = {
    "upper.shaft.c": STIFFNESS,
    "upper.spindle.c": STIFFNESS,
    "lower.spindle.c": STIFFNESS,
}
TOLERANCES = SHAFT_TOLERANCES | {
    "M_s": scaled(truncated(lp.normal(1.0, 0.1), 0.75, 1.3)),
    "upper.rolls.J": scaled(lp.uniform(0.9, 1.1)),
    "lower.rolls.J": scaled(lp.uniform(0.9, 1.1)),
}
Values = Callable[[], np.ndarray]


def row(what: str, together: Values, alone: Values) -> tuple[str, ...]:
    """Seconds of all variants together, and one by one; the latter are the first of the former."""
    ways = in_turn(together, alone, rounds=TURNS, clock=time.process_time)
    (seconds, _, found), (some, _, expected) = ways
    error = np.abs(found[:ALONE] / expected - 1).max()
    each = some / ALONE
    cells = (
        f"{seconds:.2f}",
        f"{each * RUNS:.0f}",
        f"{each * RUNS / seconds:.0f}",
        f"{error:.1e}",
    )
    return what, str(RUNS), str(os.cpu_count()), *cells


def mill() -> tuple[str, ...]:
    """The 0.1 %, 50 % and 99.9 % quantiles of the peak torque, with their intervals."""
    system = lp.assemble(pull_apart())
    peak = fun.peak("upper.spindle.tau")
    points = scene_of(system, over=TOLERANCES, of=[peak], **SCENE).draw(RUNS, 1)[:ALONE]

    def together() -> np.ndarray:
        found = lp.scatter(system, over=TOLERANCES, of=peak, runs=RUNS, seed=1, **SCENE)
        quantiles = [found[str(peak)].quantile(q) for q in (0.001, 0.5, 0.999)]
        assert all(q.low < q.value < q.high for q in quantiles)
        return found.values[:, 0]

    def alone() -> np.ndarray:
        found = []
        for values in points.tolist():
            parameters = dict(zip(TOLERANCES, values, strict=True))
            run = lp.simulate(system, parameters=parameters, method="steps", grid=2000, **SCENE)
            found.append(np.abs(run["upper.spindle.tau"]).max())
        return np.array(found)

    return row("quantiles of a peak torque", together, alone)


def frequencies() -> list[tuple[str, ...]]:
    """A natural frequency, and its derivatives."""
    modes = lp.modes(lp.assemble(ClosedGap()))
    scene = scene_of(modes, over=SHAFT_TOLERANCES, of=[fun.frequency(1)])
    points = scene.draw(RUNS, 1)

    def each() -> list[lp.Modes]:
        rows = points[:ALONE].tolist()
        names = [dict(zip(scene.names, values, strict=True)) for values in rows]
        return [lp.modes(modes.system, parameters=own) for own in names]

    def slope(own: lp.Modes) -> float:
        found = lp.vibration.eigen_sensitivity(own, by=scene.names).hertz[1, 0]
        return float(found)

    return [
        row(
            "quantiles of a natural frequency",
            lambda: scene.values(points)[:, 0],
            lambda: np.array([own.hertz[1] for own in each()]),
        ),
        row(
            "its derivatives by three stiffnesses",
            lambda: scene.slopes(points)[1][:, 0, 0],
            lambda: np.array([slope(own) for own in each()]),
        ),
    ]


def share(what: str, action: Callable[[], object]) -> tuple[str, ...]:
    """Time of the processor, and the part of it inside the compiled loop, of the quickest turn."""
    lock, inside = threading.Lock(), 0.0

    def timed(entry: Callable[..., int]) -> Callable[..., int]:
        def call(*given) -> int:
            nonlocal inside
            begin = time.thread_time()
            try:
                return entry(*given)
            finally:
                spent = time.thread_time() - begin
                with lock:
                    inside += spent

        return call

    action()
    turns = []
    with (
        mock.patch.object(engine, "call", timed(engine.call)),
        mock.patch.object(engine, "lanes", return_value=timed(engine.lanes())),
    ):
        for _ in range(10):
            inside, begin = 0.0, time.process_time()
            action()
            turns.append((time.process_time() - begin, inside))
    seconds, inner = min(turns)
    return what, f"{seconds * 1e3:.1f}", f"{inner * 1e3:.1f}", f"{inner / seconds:.2f}"


def shares() -> list[tuple[str, ...]]:
    """Shares of a scatter and of an optimum."""
    mill, three = lp.assemble(pull_apart()), lp.assemble(THREE.model())
    peak, runs = fun.peak("upper.spindle.tau"), RUNS // 10
    vary = {"shaft[0].c": (5e3, 1e5), "shaft[1].d": (0.5, 30.0), "body[1].J": (0.2, 2.0)}
    best = {"vary": vary, "minimise": fun.rms("shaft[1].tau"), "until": THREE.until}
    return [
        share(
            f"scatter, {runs} variants",
            lambda: lp.scatter(mill, over=TOLERANCES, of=peak, runs=runs, seed=1, **SCENE),
        ),
        share("optimise, gradients of runs", lambda: lp.optimise(three, **best)),
    ]


def main() -> None:
    """Print the tables, and write them to results."""
    head = ("what", "variants", "cores", "processor, s", "one by one, processor, s")
    head += ("ratio", "largest difference")
    publish("scatter", head, [mill(), *frequencies()])
    publish("scatter_share", ("what", "processor, ms", "in the loop, ms", "share"), shares())


if __name__ == "__main__":
    main()
