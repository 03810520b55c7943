"""Functionals of a finished run, which is made again while the time loop collects them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.functionals import Functional
from lumped.functionals.functional import watching
from lumped.kernel.run import DONE
from lumped.many_runs.native_runs import NativeRuns
from lumped.many_runs.run_records import RunOptions
from lumped.timeloop.result import OperatingPoint

__all__ = ["read_run"]


def read_run(
    point: OperatingPoint,
    begun: Callable[[System], OperatingPoint] | None,
    until: float,
    rtol: float,
    atol: float,
    method: str,
    max_steps: int,
    of: Sequence[Functional],
) -> np.ndarray:
    """Functionals of the run from a point, shape (len(of),).

    Parameters
    ----------
    begun : callable or None
        Gives the same start for a system that stops at the kinks of formulas.
    until, rtol, atol, method, max_steps
        Of the run, `atol` relative to nominal values. A closed form is read by steps.
    of : sequence of functionals

    Raises
    ------
    OptionError
        If an event that is asked for does not happen in the run, or a formula has kinks and the
        run began at a given point.
    SolverError
        If the run cannot be made again.
    """
    system = watching(point.system, of)
    if system is not point.system:
        if begun is None:
            raise OptionError(
                f"{system.name}: {', '.join(map(str, of))}: a formula has kinks, at which a run "
                "from an operating point does not stop. Write lumped.ops.smooth around what has "
                "them."
            )
        point = begun(system)
    by = "steps" if method in ("auto", "exact") else method
    options = RunOptions(until, point.time, point, rtol, atol, by, max_steps)
    wanted = {str(functional): functional for functional in of}
    runs = NativeRuns(system, (), point.theta, wanted, options)
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
