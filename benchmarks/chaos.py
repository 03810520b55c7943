"""How many runs does polynomial chaos need for what 100 000 random runs tell?

Peaks of both shaft torques of three masses whose inertias and stiffnesses scatter by 10 %
(`_ensemble_tasks`, task a), and the larger of both. Errors are differences from 131 072 runs at
Sobol points, over half the width of the 95 % interval that the random runs have: below 1 a result
lies inside, as those of the random runs themselves do in 95 % of cases (first rows). Those of chaos
are medians over three seeds. Times are wall times beside that of the random runs in the same
process. Read the ratios.

    python -m benchmarks.chaos
"""

import time

import numpy as np
import scipy
from scipy.stats import qmc

import lumped as lp
from benchmarks._ensemble_tasks import tasks
from benchmarks.harness import publish
from lumped.tolerances.intervals import quantile_of

NOMINAL = (0.5, 1.2, 3.0, 4e4, 2.5e4)
CASES = ((100, True), (300, True), (300, False), (1000, False))
SEEDS = 3
LEVELS = (0.01, 0.99)
WIDTH = 1.96


def statistics(values: np.ndarray) -> np.ndarray:
    """Mean, deviation and quantiles."""
    return np.array([values.mean(), values.std(), *np.quantile(values, LEVELS)])


def half_widths(values: np.ndarray) -> np.ndarray:
    """Half the widths of their intervals, from the sample itself."""
    n, off = len(values), values - values.mean()
    variance_error = np.sqrt((np.mean(off**4) - np.mean(off**2) ** 2) / n)
    found = [values.std() / np.sqrt(n), 0.5 * variance_error / values.std()]
    widths = [WIDTH * one for one in found]
    ascending = np.sort(values)
    for q in LEVELS:
        _, low, high = quantile_of(ascending, q)
        widths.append(0.5 * (high - low))
    return np.array(widths)


def against_samples() -> list[tuple[str, ...]]:
    """Errors and times of chaos."""
    task = tasks()["a"]
    system = lp.assemble(task.model)
    options = {"until": task.until, "of": task.of}
    pairs = lp.ensembles.paired(dict(zip(task.names, task.points.T, strict=True)))
    many = lp.ensemble(system, over=pairs, **options)
    over = {
        name: lp.uniform(0.9 * value, 1.1 * value)
        for name, value in zip(task.names, NOMINAL, strict=True)
    }
    even = lp.ensemble(system, over=over, runs=2**17, sampling="sobol", **options)
    known = {label: (many[label], even[label]) for label in task.of}
    known["larger"] = tuple(np.max(pair, axis=0) for pair in zip(*known.values(), strict=True))
    rows = []
    for label, (values, exact) in known.items():
        off = np.abs(statistics(values) - statistics(exact)) / half_widths(values)
        told = [f"{e:.2f}" for e in off]
        rows.append((label, str(len(many)), "(random)", *told, f"{many.seconds:.2f}", "1"))
    u = scipy.special.ndtri(qmc.Sobol(len(over), seed=0).random(2**16))
    for runs, gradients in CASES:
        errors: dict[str, list[np.ndarray]] = {label: [] for label in known}
        seconds = []
        for seed in range(SEEDS):
            begin = time.perf_counter()
            found = lp.scatter(
                system,
                over=over,
                **options,
                search="chaos",
                runs=runs,
                seed=seed,
                gradients=gradients,
            )
            seconds.append(time.perf_counter() - begin)
            samples = {label: found[label].sample() for label in task.of}
            random = np.random.default_rng(0)
            own = [
                found[label].expansion.add_residuals(found[label].at(u), random)
                for label in task.of
            ]
            samples["larger"] = np.max(own, axis=0)
            for label, (values, exact) in known.items():
                off = statistics(samples[label]) - statistics(exact)
                errors[label].append(np.abs(off) / half_widths(values))
        for label in known:
            told = [f"{e:.2f}" for e in np.median(errors[label], axis=0)]
            ratio = f"{min(seconds) / many.seconds:.2f}"
            what = "values and gradients" if gradients else "values"
            rows.append((label, str(runs), what, *told, f"{min(seconds):.2f}", ratio))
    return rows


def main() -> None:
    """Print the table and write it to the results."""
    head = ("peak of", "runs", "fitted to", "mean", "deviation", "1 %", "99 %", "s", "over 100 000")
    publish("chaos", head, against_samples())


if __name__ == "__main__":
    main()
