"""Functionals of a finished run, which is made again while the time loop collects them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.functionals import Functional
from lumped.kernel.run import DONE
from lumped.many_runs.native_runs import NativeRuns
from lumped.points.start import run_start
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_options import RunPlan


def read_run(plan: RunPlan, point: OperatingPoint, of: Sequence[Functional]) -> np.ndarray:
    """Functionals of the run from a point, shape (len(of),).

    Parameters
    ----------
    plan : RunPlan
        Options of the run. A closed form is read by steps.
    of : sequence of functionals

    Raises
    ------
    OptionError
        If an event that is asked for does not happen in the run, or a formula has kinks and the
        run began at a given point.
    SolverError
        If the run cannot be made again.
    """
    system = plan.watching(point.system, of)
    if system is not point.system:
        point = run_start(system, plan)
    wanted = {str(functional): functional for functional in of}
    method = "steps" if plan.method in ("auto", "exact") else plan.method
    own = plan._replace(start=point, parameters=None, free=(), method=method)
    runs = NativeRuns(system, (), point.theta, wanted, own)
    batch = runs.run(np.zeros((1, 0)))
    if batch.status[0] != DONE:
        raise SolverError(
            f"{system.name}: the run ends early where it is made again to be read "
            f"(status {batch.status[0]}). Make it with method='steps' to see why."
        )
    for label, value in zip(wanted, batch.values[0].tolist(), strict=True):
        if np.isnan(value):
            raise OptionError(f"{system.name}: {runs.watched.missing(label)}.")
    found: np.ndarray = batch.values[0]
    return found
