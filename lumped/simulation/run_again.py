"""A run from a point, and how it is made again with the states that were left out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lumped.compiler.system import System
from lumped.errors import Interrupted, SolverError, doubt
from lumped.timeloop.results.left_out_states import PointOfRun
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run import Simulation
from lumped.timeloop.run_by_steps import RunBySteps
from lumped.timeloop.run_in_closed_form import RunInClosedForm
from lumped.timeloop.run_options import RunPlan


def run_from(point: OperatingPoint, plan: RunPlan, output: Recorder) -> Trajectory:
    """The run from a point by the method of its plan, which a recorder takes."""
    kind = RunInClosedForm if plan.method == "exact" else RunBySteps
    with output.progress:
        run = kind(point, plan, output)
        try:
            run.go()
            return run.trajectory()
        except KeyboardInterrupt:
            raise _make_interrupted(run) from None
        except SolverError as error:
            if plan.method == "exact" or run.steps + run.rejected >= plan.max_steps:
                raise  # rounding and the number of steps are limits of ours, not of the drive
            raise SolverError(doubt(plan.rtol) + str(error), error.partial) from None


def _make_interrupted(run: Simulation) -> Interrupted:
    partial = run.partial()
    return Interrupted(
        f"{run.system.name}: interrupted at t = {partial.t[-1]:.6g} s; `partial` is the run.",
        partial,
    )


@dataclass(eq=False, slots=True)
class _BegunRun:
    """A run that began at a point.

    Attributes
    ----------
    point : OperatingPoint
        Where it starts; of a run that goes on from another, without that.
    plan : RunPlan
        Its options.
    left : float
        When it left the run from which it goes on, s.
    whole : OperatingPoint or None
        Where it starts, with the states that were left out, once these are known.
    """

    point: OperatingPoint
    plan: RunPlan
    left: float = math.nan
    whole: OperatingPoint | None = None

    def begin_with(self, again: Callable[[System], OperatingPoint] | None) -> None:
        """Take the states that were left out from the same point of the whole system."""
        self.whole = replace(self.point, again=again).whole

    def again(self, times: np.ndarray) -> Trajectory:
        """The same run of the whole system, at some times."""
        assert self.whole is not None
        until = float(times[-1])
        if until == self.whole.time:
            until = self.plan.until
        output = Recorder(self.whole, until, times, True)
        return run_from(self.whole, self.plan._replace(until=until), output)


@dataclass(frozen=True, eq=False, slots=True)
class _RepeatedRun:
    """Makes a run again, with the states that were left out.

    A run that goes on from another begins with what that one had, and so on in a row. Rows may be
    long, so nothing here calls itself along them.

    Attributes
    ----------
    run : _BegunRun
        The run.
    before : _RepeatedRun or None
        That from which it goes on.
    """

    run: _BegunRun
    before: _RepeatedRun | None

    def __call__(self, times: np.ndarray) -> Trajectory:
        row = self._row(known=True)
        if row[0].whole is None:
            row[0].begin_with(row[0].point.again)
        for before, run in itertools.pairwise(row):
            run.begin_with(PointOfRun(before.again, run.left))
        return self.run.again(times)

    def _row(self, *, known: bool) -> list[_BegunRun]:
        """Runs up to this one, from the first on, or from the last whose start is known."""
        found, link = [self.run], self.before
        while link is not None and not (known and found[-1].whole is not None):
            found.append(link.run)
            link = link.before
        return found[::-1]

    def __reduce__(self) -> tuple[Any, ...]:
        return _as_row, tuple(self._row(known=False))


def _as_row(*runs: _BegunRun) -> _RepeatedRun:
    """The last of runs that go on from each other."""
    found = None
    for run in runs:
        found = _RepeatedRun(run, found)
    assert found is not None
    return found


def again_from(point: OperatingPoint, plan: RunPlan) -> _RepeatedRun:
    """Makes the run from a point again."""
    run, came = _BegunRun(point, plan._replace(start=None)), point.again
    if not isinstance(came, PointOfRun):
        return _RepeatedRun(run, None)
    run.point, run.left = replace(point, again=None), came.time
    return _RepeatedRun(run, came.run)
