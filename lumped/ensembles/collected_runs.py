"""What many runs gave, and why some failed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from lumped.compiler.system import Changes, System
from lumped.ensembles.ensemble_file import EnsembleFile
from lumped.ensembles.parallel_runs import DIED, on_cluster, run_in_threads
from lumped.errors import LumpedError, OptionError
from lumped.functionals import Functional
from lumped.kernel.run import DONE, FULL
from lumped.many_runs.native_runs import NativeRuns
from lumped.points.start import run_start
from lumped.simulation.simulate import run_on
from lumped.support.progress import Progress
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.run_options import RunPlan

_EXPLAINED = 20
"""Failed runs that are made again, each alone, to say why."""
_WORDS = {
    FULL: "interrupted before it was run",
    DIED: "the process of a worker died in this run, or in one of its chunk, again and again",
}


class RunsAt:
    """Functionals of runs at any parameters, with records that are made once.

    Parameters
    ----------
    system : System
    names : sequence of str
        What varies.
    of : mapping of str to functional
        What is wanted.
    plan : RunPlan
        Options of all runs.
    workers : int, optional
        Threads; default is one for each core.
    """

    def __init__(
        self,
        system: System,
        names: tuple[str, ...],
        of: Mapping[str, Functional],
        plan: RunPlan,
        workers: int | None,
    ) -> None:
        watched = plan.watching(system, of.values())
        theta = fill_parameters(watched, plan.changes(watched))
        self._made = NativeRuns(watched, names, theta, of, plan.by_steps(system.name))
        self._workers = workers or os.cpu_count() or 1

    def __call__(self, points: np.ndarray) -> tuple[np.ndarray, dict[int, str]]:
        """Functionals, shape (n, len(of)), nan where one is missing, and why.

        Parameters
        ----------
        points : ndarray, shape (n, len(names))
            Within the ranges of the parameters.
        """
        if not len(points):
            return np.full((0, len(self._made.watched.of)), np.nan), {}
        values, status, _ = collect_runs(self._made, points, min(self._workers, len(points)))
        return values, failures_of(self._made, points, values, status).texts


def collect_runs(
    made: NativeRuns,
    points: np.ndarray,
    count: int,
    file: EnsembleFile | None = None,
    client: Any = None,
) -> tuple[np.ndarray, np.ndarray, float]:
    """Functionals of runs, how each ended, and the seconds of work.

    Parameters
    ----------
    points : ndarray, shape (n, k)
        Parameters of the runs.
    count : int
        Number of threads.
    file : EnsembleFile, optional
        Has results of some of them, and takes those of the others.
    client : dask.distributed.Client, optional
        Makes the runs on its cluster.
    """
    busy = 0.0
    values = np.full((len(points), len(made.watched.of)), np.nan)
    status = np.full(len(points), FULL, dtype=np.int64)
    for first, batch in () if file is None else file.known:
        last = first + len(batch.values)
        values[first:last], status[first:last] = batch.values, batch.status
    waiting = np.flatnonzero(status == FULL)
    left = points[waiting]
    work = run_in_threads(made, left, count) if client is None else on_cluster(made, left, client)
    try:
        with Progress(f"{made.system.name}: runs", len(values)) as progress:
            done = len(values) - len(waiting)
            for first, batch, spent in work:
                which = waiting[first : first + len(batch.values)]
                values[which], status[which] = batch.values, batch.status
                if file is not None:
                    file.add(which, batch)
                busy += spent
                done += len(which)
                progress.at(done)
    except KeyboardInterrupt:
        made.stop()
    finally:
        work.close()
        if file is not None:
            file.close()
    return values, status, busy


def fill_parameters(system: System, parameters: Changes | None) -> np.ndarray:
    """All parameters as they are unless varied; the runs are checked one by one."""
    theta, p = system.structure.parameters.defaults.copy(), system.structure.parameters
    for place, value in zip(
        system.places(parameters or {}), (parameters or {}).values(), strict=True
    ):
        theta[place] = p.number(p.free[place], value)
    return theta


def label_functionals(of: Mapping[str, Any] | Iterable[Any], analysis: str) -> dict[str, Any]:
    """Functionals by their labels.

    Raises
    ------
    OptionError
        If there is none.
    """
    wanted: dict[str, Any] = dict(of) if isinstance(of, Mapping) else {}
    for functional in () if isinstance(of, Mapping) else dict.fromkeys(of):
        label, number = str(functional), 2
        while label in wanted:  # a text may leave out instants
            label, number = f"{functional} ({number})", number + 1
        wanted[label] = functional
    if not wanted:
        raise OptionError(
            f"{analysis}: name what to take from each run, such as "
            "of=[lumped.functionals.peak('shaft.tau')]."
        )
    return wanted


class Failures(NamedTuple):
    """Why runs failed, or which results are not numbers, by the number of the run.

    `every` is the first of them where none came to its end.
    """

    texts: dict[int, str]
    every: tuple[int, str] | None


def failures_of(
    made: NativeRuns, points: np.ndarray, values: np.ndarray, status: np.ndarray
) -> Failures:
    """Why runs failed."""
    found: dict[int, str] = {}
    first_of: dict[int, tuple[int, str]] = {}
    for i in np.flatnonzero(status != DONE).tolist():
        why = int(status[i])
        if why in _WORDS:
            found[i] = _WORDS[why]
        elif len(found) < _EXPLAINED or why not in first_of:
            found[i] = _fault(made, points[i], why)
            first_of.setdefault(why, (i, found[i]))
        else:
            first, text = first_of[why]
            found[i] = f"as run {first}: {text}"
    every = next(iter(first_of.values())) if first_of and len(found) == len(status) else None
    labels = tuple(made.watched.of)
    for i in np.flatnonzero((status == DONE) & np.isnan(values).any(axis=1)).tolist():
        missing = [label for label, v in zip(labels, values[i], strict=True) if np.isnan(v)]
        found[i] = "; ".join(made.watched.missing(label) for label in missing)
    return Failures(found, every)


def _fault(made: NativeRuns, values: np.ndarray, status: int) -> str:
    """Why a variant failed, found by running it alone."""
    plan, system, theta = made.options, made.system, made.theta.copy()
    theta[made.places] = values
    changes = dict(zip(system.parameters, theta.tolist(), strict=True))
    try:
        point = run_start(system, plan._replace(parameters=changes))
        run_on(point, plan, Recorder(point, plan.until, np.array([plan.until]), False))
    except LumpedError as error:
        return str(error)
    return f"{system.name}: this run failed (status {status})."
