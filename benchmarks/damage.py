"""What does the damage of a load cost while runs go on, and how true are its derivatives?

Damage of the upper spindle of the reversing mill whose gap skids, by an S-N curve of slope 5: for
many runs beside their peaks alone, and against rainflow counts of recorded runs; its derivatives
backwards against central differences of streamed counts. Wall times of one thread, the least of
three, in turn in one process. Read the ratios.

    python -m benchmarks.damage
"""

from functools import partial

import numpy as np

import lumped as lp
from benchmarks.harness import in_turn, publish
from lumped import functionals as fun
from lumped.models.reversing_mill.scenes import pull_apart
from lumped.models.reversing_mill.stand import RATED, SHAFTS

LOAD = "upper.spindle.tau"
CURVE = lp.life.SNCurve(knee=2e3, cycles=2e6, slope=5.0, unit="N.m")
SCENE = {"until": 0.4, "start": dict.fromkeys(SHAFTS, RATED)}
VARIED = ("upper.shaft.c", "upper.spindle.c", "upper.rolls.J", "M_s")
RUNS, RECORDED, TURNS, AWAY = 2000, 20, 3, 1e-5


def measure_streams(system: lp.System) -> list[str]:
    """Many runs with damage and with a peak alone; the damage against that of recorded runs."""
    over = {name: lp.ensembles.scaled(lp.uniform(0.95, 1.05)) for name in VARIED[:3]}
    options = {"over": over, "runs": RUNS, "workers": 1, **SCENE}
    damage, peak = fun.damage(LOAD, CURVE), fun.peak(LOAD)
    found = lp.ensemble(system, of=[damage], **options)
    worst = 0.0
    for k in range(RECORDED):
        parameters = {name: float(found.points[k, i]) for i, name in enumerate(found.names)}
        run = lp.simulate(system, parameters=parameters, method="steps", **SCENE)
        cycles = lp.life.rainflow(lp.life.turning_points(run, LOAD))
        alone = float(cycles.counts @ CURVE.damage(cycles.ranges / 2))
        worst = max(worst, abs(found[str(damage)][k] / alone - 1))
    ways = (partial(lp.ensemble, system, of=[one], **options) for one in (damage, peak))
    with_damage, with_peak = (way.seconds for way in in_turn(*ways, rounds=TURNS))
    times = f"{with_damage:.3f}", f"{with_peak:.3f}", f"{with_damage / with_peak:.2f}"
    return [f"{RUNS} runs, against their peaks", *times, f"{worst:.1e}"]


def measure_gradients(system: lp.System) -> list[str]:
    """One gradient by four parameters against the differences of eight runs."""
    damage = fun.damage(LOAD, CURVE)
    own = np.array([system.parameters[name] for name in VARIED])
    away = np.concatenate([np.identity(4), -np.identity(4)]) * AWAY
    points = own * (1 + away)
    over = lp.ensembles.paired(dict(zip(VARIED, points.T, strict=True)))
    options = {"rtol": 1e-10, **SCENE}

    def differences() -> np.ndarray:
        values = lp.ensemble(system, over=over, of=[damage], workers=1, **options)[str(damage)]
        return (values[:4] - values[4:]) / (2 * AWAY * own)

    def gradient() -> np.ndarray:
        return lp.gradient(system, of=[damage], by=VARIED, **options).derivatives[0]

    (one, _, exact), (eight, _, apart) = in_turn(gradient, differences, rounds=TURNS)
    error = np.abs((exact - apart) * own).max() / np.abs(exact * own).max()
    return ["gradient, against differences", f"{one:.3f}", f"{eight:.3f}", f"{one / eight:.2f}",
            f"{error:.1e}"]  # fmt: skip


def main() -> None:
    """Print the table, and write it to results."""
    system = lp.assemble(pull_apart())
    head = ("damage of a spindle", "s", "against, s", "ratio", "deviation")
    publish("damage", head, [measure_streams(system), measure_gradients(system)])


if __name__ == "__main__":
    main()
