"""What accuracy costs: the methods over a ladder of tolerances on one's own model."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import LumpedError, OptionError
from lumped.plots import numbers
from lumped.plots.draw import Canvas, draw
from lumped.points.start import run_start
from lumped.simulation.certify import choose_names, compare_runs
from lumped.simulation.simulate import simulate
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.closed_form_choice import closed_form_holds
from lumped.timeloop.plants.executable import executable
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_in_closed_form import has_linear_form
from lumped.timeloop.run_options import Method, RunOptions, run_plan

_INTERVALS = 997
"""A prime, so that output times do not fall on the zeros of a vibration."""
_MOST_STEPS = 200_000
_TIGHTEST = 1e-13
_LONG = 1.0
"""Seconds beyond which a run is not repeated for its time."""


@dataclass(frozen=True)
class WorkRow:
    """One method at one tolerance.

    Attributes
    ----------
    method : str
        As given to `simulate`.
    rtol : float
        Relative tolerance.
    error : float
        Largest difference from the reference over the quantities, relative to their ranges; nan
        for a run that failed.
    worst : str
        Quantity with that error.
    seconds : float
        Wall time of a run, the best of three (of one, if it takes more than a second); the
        functions are compiled before. nan for a run that failed.
    steps, rejected, evaluations, events : int
        Counts of the run.
    outcome : str
        "ok", which events are not those of the reference, or why the run failed.
    """

    method: str
    rtol: float
    error: float
    worst: str
    seconds: float
    steps: int
    rejected: int
    evaluations: int
    events: int
    outcome: str


@dataclass(frozen=True, eq=False)
class WorkPrecision(RichHtml):
    """Error against run time.

    Attributes
    ----------
    system : System
        What was simulated.
    rows : tuple of WorkRow
        Methods and tolerances.
    names : tuple of str
        Quantities whose errors count.
    reference : str
        Method and tolerance of the reference.
    reference_error : float
        Its own error: the largest difference from a second run, of another method or of ten times
        its tolerance. Smaller errors of rows mean nothing.
    window : float
        Longest time around an event that was not compared, s.
    """

    system: System
    rows: tuple[WorkRow, ...]
    names: tuple[str, ...]
    reference: str
    reference_error: float
    window: float

    @checked
    def fastest(self, error: float = 1e-6) -> WorkRow:
        """The fastest run with an error of at most this.

        Raises
        ------
        OptionError
            If there is none, or the reference is not that accurate.
        """
        if not error > self.reference_error:
            raise OptionError(
                f"{self.system.name}: error = {error:g} is not above {self.reference_error:.1g}, "
                "the error of the reference itself. Give tighter tolerances."
            )
        good = [row for row in self.rows if row.outcome == "ok" and row.error <= error]
        if not good:
            reached = min((r.error for r in self.rows if r.outcome == "ok"), default=np.nan)
            raise OptionError(
                f"{self.system.name}: no run has an error of {error:g} or less; the best has "
                f"{reached:.1g}. Give tighter tolerances."
            )
        return min(good, key=lambda row: row.seconds)

    @checked
    def plot(self, **canvas: Unpack[Canvas]) -> Any:
        """Run time over error, one line for each method; failed runs are left out.

        There is no choice of units: errors are relative, and the computer's time is none of the
        drive.

        Parameters
        ----------
        backend, ax
            As in `lumped.Trajectory.plot`.
        """
        methods: dict[str, list[tuple[float, float]]] = {row.method: [] for row in self.rows}
        for row in self.rows:
            if np.isfinite(row.error):
                methods[row.method].append((row.error, row.seconds))
        picture = numbers.work_precision(self.system.name, methods, self.reference_error)
        return draw(picture, **canvas)

    def __repr__(self) -> str:
        head = ("method", "rtol", "error", "ms", "steps", "rejected", "evaluations", "events")
        lines = [
            f"{self.system.name}: errors of {len(self.names)} quantities relative to their ranges",
            f"reference: {self.reference}, own error {self.reference_error:.1g}; "
            f"up to {self.window:.1g} s around events not compared",
        ]
        rows = []
        for r in self.rows:
            below = "< " if r.error <= self.reference_error else ""
            error = f"{below}{number(max(r.error, self.reference_error), 2)}"
            rows.append(
                (
                    r.method,
                    number(r.rtol),
                    "-" if np.isnan(r.error) else error,
                    "-" if np.isnan(r.seconds) else number(1e3 * r.seconds, 3),
                    *(str(n) for n in (r.steps, r.rejected, r.evaluations, r.events)),
                    r.outcome if len(r.outcome) <= 60 else r.outcome[:57] + "...",
                )
            )
        return "\n".join(lines) + "\n" + table((*head, "outcome"), rows)


@checked
def work_precision(
    system: System,
    *,
    until: float | str,
    of: Iterable[Name] | None = None,
    methods: Sequence[Method] | None = None,
    tolerances: Sequence[float] = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10),
    **options: Unpack[RunOptions],
) -> WorkPrecision:
    """Run the methods over a ladder of tolerances against a much more accurate reference.

    The reference is the closed form, checked by steps at a hundredth of the tightest tolerance,
    if the system is linear and rounding allows it. Else it is that run by steps, checked by one
    at ten times its tolerance. Errors are taken at 998 equidistant times, without the time
    between the instants at which an event is in both runs.

    Parameters
    ----------
    system : System
        From `assemble`.
    until : float
        End, s.
    of : iterable of names, optional
        Quantities whose errors count; default is all states.
    methods : sequence of str, optional
        As for `simulate`; default is all but "steps", "exact" only for linear systems.
    tolerances : sequence of float
        Relative tolerances.
    **options : RunOptions
        Of the runs (see `RunOptions`); `methods` stands for `method`, `atol` is that at the
        tightest tolerance, and others have theirs in proportion.

    Returns
    -------
    WorkPrecision

    Raises
    ------
    OptionError
        If there is nothing to compare or to run.
    SolverError
        If the reference cannot be computed; single runs that fail are rows.
    """
    names, ladder = choose_names(system, of), [float(r) for r in tolerances]
    chosen = _methods(system) if methods is None else list(methods)
    if not chosen or not all(1e-14 <= rtol < 1 for rtol in ladder):
        raise OptionError(
            "work_precision: at least one method is needed, and tolerances between 1e-14 and 1."
        )
    if not ladder:
        raise OptionError("work_precision: give at least one tolerance.")
    if options.get("method", "auto") != "auto":
        raise OptionError("work_precision: give methods=[...] in place of method=.")
    plan = run_plan(until, min(ladder), options)
    point = run_start(system, plan)
    grid = np.linspace(plan.begin, plan.until, _INTERVALS + 1)

    def run(method: Method, rtol: float, most: int | None = None) -> Trajectory:
        own = plan.at(rtol)
        return simulate(
            point.system,
            until=plan.until,
            start=point,
            grid=grid,
            rtol=rtol,
            atol=own.atol,
            method=method,
            max_steps=min(plan.max_steps, most or plan.max_steps),
        )

    tight = max(1e-2 * min(ladder), _TIGHTEST)
    if closed_form_holds(point, plan.until, 1e-9):
        reference, text = run("exact", 1e-9), f"exact, checked by steps at rtol {tight:.1g}"
        check = run("steps", tight)
    else:
        reference = run("steps", tight)
        text = f"steps at rtol {tight:.1g}, checked at {10 * tight:.1g}"
        check = run("steps", 10 * tight)
    own = compare_runs(check, reference, tight, names)
    rows, window = [], own.window
    for method in chosen:
        for rtol in ladder:
            row, excluded = _row(reference, tight, names, run, method, rtol)
            rows.append(row)
            window = max(window, excluded)
    return WorkPrecision(system, tuple(rows), tuple(names), text, own.worst.relative, window)


def _methods(system: System) -> list[Method]:
    exact: list[Method] = ["exact"] if has_linear_form(system) else []
    return ["explicit", "implicit", *exact, "auto"]


def _row(
    reference: Trajectory,
    tight: float,
    names: list[str],
    run: Callable[[Method, float, int], Trajectory],
    method: Method,
    rtol: float,
) -> tuple[WorkRow, float]:
    """A method at a tolerance, and the longest time that was not compared."""
    nan = float("nan")
    try:
        found = run(method, rtol, _MOST_STEPS)
        executable(found.system).compile()
        comparison = compare_runs(found, reference, tight, names)
    except LumpedError as error:
        counts, reason = _counts(getattr(error, "partial", None)), str(error).splitlines()[0]
        return WorkRow(method, rtol, nan, "", nan, *counts, 0, reason), 0.0
    seconds = []
    for _ in range(3):
        begin = clock.perf_counter()
        run(method, rtol, _MOST_STEPS)
        seconds.append(clock.perf_counter() - begin)
        if seconds[-1] > _LONG:
            break
    worst, outcome = comparison.worst, comparison.missed or "ok"
    own, counts = (worst.relative, worst.name, min(seconds)), _counts(found)
    return WorkRow(method, rtol, *own, *counts, len(found.events), outcome), comparison.window


def _counts(run: Trajectory | None) -> tuple[int, int, int]:
    """Accepted and rejected steps and evaluations of a run, as far as there is one."""
    if run is None:
        return 0, 0, 0
    s = run.statistics
    return s.steps, s.rejected, s.evaluations
