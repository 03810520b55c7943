"""What does accuracy cost on each of the machines and on three clutches?

One scene of each, by all methods that it admits, over a ladder of tolerances; the error is the
largest over all states, relative to their ranges, against a reference whose own error stands
beside it. Times are the best of three in one process: read them against each other.

    python -m benchmarks.machines
"""

from collections.abc import Callable

from matplotlib.figure import Figure

import lumped as lp
from benchmarks.harness import RESULTS, publish
from benchmarks.hybrid import Coupled
from lumped.models import MACHINES, machine


def measure_clutches(**options) -> lp.simulation.WorkPrecision:
    """Four inertias and three clutches."""
    return lp.simulation.work_precision(lp.assemble(Coupled()), until=1.5, **options)


SCENES: dict[str, Callable[..., lp.simulation.WorkPrecision]] = {
    **{text: machine(name).accuracy for name, text in MACHINES.items()},
    "Three clutches": measure_clutches,
}
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9)


def main() -> None:
    """Print the table, write it to the results and draw it."""
    head = ("scene", "method", "rtol", "error", "ms", "steps", "rejected", "events", "outcome")
    rows = []
    lines = -(-len(SCENES) // 2)
    figure = Figure((10.0, 3.0 * lines), layout="constrained")
    axes = figure.subplots(lines, 2, sharey=True).ravel()
    for axis in axes[len(SCENES) :]:
        axis.set_axis_off()
    for axis, (name, scene) in zip(axes, SCENES.items(), strict=False):
        found = scene(tolerances=TOLERANCES)
        for method in dict.fromkeys(row.method for row in found.rows):
            good = [r for r in found.rows if r.method == method and r.error > 0]
            axis.loglog(
                [r.error for r in good], [1e3 * r.seconds for r in good], "o-", label=method
            )
        for r in found.rows:
            numbers = (f"{r.rtol:.0e}", f"{r.error:.1e}", f"{1e3 * r.seconds:.3g}")
            counts = (str(r.steps), str(r.rejected), str(r.events))
            rows.append((name, r.method, *numbers, *counts, r.outcome))
        axis.set_title(name.removeprefix("Reconstructed example: "), fontsize="small")
        axis.grid(alpha=0.3)
        axis.legend(frameon=False)
    figure.supxlabel("largest error of a state, relative to its range")
    figure.supylabel("run time, ms")
    figure.savefig(RESULTS / "machines.png", dpi=70)
    publish("machines", head, rows)


if __name__ == "__main__":
    main()
