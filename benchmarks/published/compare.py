"""Errors and times of the published problems, their tables and their picture."""

import time
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure
from scipy.integrate import solve_ivp

import lumped as lp
from benchmarks.harness import RESULTS, build, publish, time_action
from benchmarks.published.cases import MECHANISMS, STIFF
from benchmarks.published.friction import OSCILLATORS
from benchmarks.published.problem import ByHand, Problem
from benchmarks.published.torsional import (
    PLANETS,
    TRAINS,
    hertz_of,
    list_planetary,
    planetary,
)
from lumped.timeloop.plants.executable import executable

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
LIMIT = 60.0  # s, of a run
ROUNDS = 5
RADAU, CVODE = "SciPy Radau, NumPy", "CVODE BDF, NumPy"

Row = tuple[str, ...]
Way = Callable[[ByHand, float, float], Sequence[float]]


def within(seconds: float, rate: Callable) -> Callable:
    """Rates that end a run which takes too long."""
    end = time.perf_counter() + seconds

    def limited(t: float, z: np.ndarray) -> np.ndarray:
        if time.perf_counter() > end:
            raise TimeoutError
        return rate(t, z)

    return limited


def by_radau(hand: ByHand, until: float, rtol: float) -> Sequence[float]:
    """End of a run by SciPy."""
    rate, start = within(LIMIT, hand.rate), np.array(hand.start, float)
    found = solve_ivp(rate, (0.0, until), start, "Radau", rtol=rtol, atol=rtol * 1e-3)
    if not found.success:
        raise RuntimeError(found.message)
    return hand.read(found.y[:, -1])


def by_cvode(hand: ByHand, until: float, rtol: float) -> Sequence[float]:
    """End of a run by CVODE."""
    from sksundae.cvode import CVODE

    limited = within(LIMIT, hand.rate)

    def rate(t: float, z: np.ndarray, zp: np.ndarray) -> None:
        zp[:] = limited(t, z)

    solver = CVODE(rate, method="BDF", rtol=rtol, atol=rtol * 1e-3, max_num_steps=10_000_000)
    found = solver.solve(np.array([0.0, until]), np.array(hand.start, float))
    if not found.success:
        raise RuntimeError(found.message)
    return hand.read(found.y[-1])


def size_of(system: lp.System) -> str:
    """Equations of a model, and states that are left."""
    counts = system.report()
    return f"{counts['equations']} -> {counts['states']}"


def row(name: str, source: str, size: str, way: str, rtol: float, error: float, s: float) -> Row:
    """A row of the table."""
    return name, source, size, way, f"{rtol:.0e}", f"{error:.1e}", f"{1e3 * s:.3g}"


def other(problem: Problem, way: str, run: Way, rtol: float) -> Row:
    """A run by another solver."""
    head = problem.name, problem.source, str(len(problem.by_hand.start)), way

    def action() -> Sequence[float]:
        return run(problem.by_hand, problem.until, rtol)

    try:
        found = time_action(action, 1)
        if found.seconds < 1.0:
            found = time_action(action, 2)
    except ImportError:
        return (*head, f"{rtol:.0e}", "not installed", "")
    except TimeoutError:
        return (*head, f"{rtol:.0e}", f"more than {LIMIT:g} s", "")
    except Exception as fault:  # a row for each run, also for what fails
        return (*head, f"{rtol:.0e}", str(fault).splitlines()[0][:60] or "fails", "")
    return row(*head, rtol, problem.error(found.result), found.seconds)


def time_own(problem: Problem) -> list[Row]:
    """Rows of lumped, with each choice of states compiled that a run needs."""
    system, _ = build(problem.model())
    head, rows = (problem.name, problem.source, size_of(system), "lumped"), []
    for rtol in TOLERANCES:
        for piece in problem.simulate(system, rtol).pieces:
            executable(piece.system).compile()
        found = time_action(lambda rtol=rtol: problem.simulate(system, rtol), ROUNDS)
        rows.append(row(*head, rtol, problem.error_of(found.result), found.seconds))
    return rows


def compare(problem: Problem) -> list[Row]:
    """Rows of a problem."""
    rows = time_own(problem)
    ways = ((RADAU, by_radau), (CVODE, by_cvode)) if problem.by_hand else ()
    for way, run in ways:
        rows += [other(problem, way, run, rtol) for rtol in TOLERANCES]
    return rows


def rub() -> list[Row]:
    """Rows of the friction oscillators."""
    rows = []
    for case in OSCILLATORS:
        system, _ = build(case.model())
        head = case.name, case.source, size_of(system)
        for rtol in TOLERANCES:
            found = time_action(lambda rtol=rtol: case.simulate(system, rtol), ROUNDS)  # noqa: B023
            rows.append(row(*head, "lumped", rtol, case.error(found.result), found.seconds))
        if case.theirs:
            rows.append((*head, "its own reference", "", f"{case.theirs:.1e}", ""))
    return rows


def vibrate() -> list[Row]:
    """Rows of the natural frequencies."""
    rows = []
    for case in TRAINS:
        found = hertz_of(case.model())
        far = np.abs(found / case.recomputed - 1.0).max()
        printed = " ".join(map(str, case.printed)) or "by SciPy from the data"
        shown = " ".join(f"{hertz:.4f}" for hertz in found)
        rows.append((case.name, case.source, printed, shown, f"{far:.0e}"))
    for n in PLANETS:
        found = hertz_of(planetary(n))
        printed = np.sort(list_planetary(n))
        far = np.abs(found / printed - 1.0).max()
        source = "Lin, Parker, J. Vib. Acoust. 121 (1999) 316"
        texts = (
            " ".join(f"{hertz:.1f}" for hertz in np.unique(values.round(1)))
            for values in (printed, found)
        )
        rows.append((f"{n} planets", source, *texts, f"{far:.0e}"))
    return rows


def draw(rows: list[Row]) -> None:
    """Time over error, an axis for each problem."""
    names = list(dict.fromkeys(row[0] for row in rows if row[3] == RADAU))
    figure = Figure((11.0, 2.5 * -(-len(names) // 4)), layout="constrained")
    axes = figure.subplots(-(-len(names) // 4), 4).ravel()
    for axis in axes[len(names) :]:
        axis.set_axis_off()
    for axis, name in zip(axes, names, strict=False):
        for way, marker in (("lumped", "o-"), (RADAU, "s--"), (CVODE, "^:")):
            good = [r for r in rows if r[0] == name and r[3] == way and r[6]]
            axis.loglog([float(r[5]) for r in good], [float(r[6]) for r in good], marker, label=way)
        axis.set_title(name, fontsize="small")
        axis.grid(alpha=0.3)
    axes[0].legend(frameon=False, fontsize="x-small")
    figure.supxlabel("relative error at the end")
    figure.supylabel("run time, ms")
    figure.savefig(RESULTS / "published.png", dpi=70)


def main() -> None:
    """Measure, print, write and draw."""
    rows = []
    for problem in (*MECHANISMS, *STIFF):
        rows += compare(problem)
        print(*rows[-12:], sep="\n", flush=True)
    head = ("problem", "source", "equations -> states", "way", "rtol", "error", "ms")
    draw(rows)
    publish("published", head, [*rows, *rub()])
    head = ("system", "source", "published, Hz", "lumped, Hz", "largest relative difference")
    publish("published_modes", head, vibrate())
