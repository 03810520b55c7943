"""What many runs gave, and why some failed."""

from __future__ import annotations

import base64
import hashlib
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lumped.compiler.system import System
from lumped.ensembles.line_file import LineFile
from lumped.ensembles.parallel_runs import DIED, on_cluster, run_in_threads
from lumped.ensembles.variants import ParameterSets, fill_parameters
from lumped.errors import LumpedError, OptionError
from lumped.functionals import Functional
from lumped.kernel.run import DONE, FULL
from lumped.many_runs.native_runs import Batch, NativeRuns
from lumped.points.start import run_start
from lumped.simulation.simulate import run_on
from lumped.support.progress import Progress
from lumped.timeloop.results.fingerprint import fingerprint
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.run_options import RunPlan

_EXPLAINED = 20
"""Failed runs that are made again, each alone, to say why."""
STOPPED = {
    FULL: "interrupted before it was run",
    DIED: "the process of a worker died in this run, or in one of its chunk, again and again",
}
"""Status of runs that did not come to their end for a reason outside of them."""


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
        return values, failures_of(self._made, points, values, status)


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


def failures_of(
    made: NativeRuns, points: np.ndarray, values: np.ndarray, status: np.ndarray
) -> dict[int, str]:
    """Why runs failed, or which results are not numbers, by the number of the run."""
    found: dict[int, str] = {}
    first_of: dict[int, tuple[int, str]] = {}
    for i in np.flatnonzero(status != DONE).tolist():
        why = int(status[i])
        if why in STOPPED:
            found[i] = STOPPED[why]
        elif len(found) < _EXPLAINED or why not in first_of:
            found[i] = _fault(made, points[i], why)
            first_of.setdefault(why, (i, found[i]))
        else:
            first, text = first_of[why]
            found[i] = f"as run {first}: {text}"
    labels = tuple(made.watched.of)
    for i in np.flatnonzero((status == DONE) & np.isnan(values).any(axis=1)).tolist():
        missing = [label for label, v in zip(labels, values[i], strict=True) if np.isnan(v)]
        found[i] = "; ".join(made.watched.missing(label) for label in missing)
    return found


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


def heading(
    system: System, variants: ParameterSets, of: Mapping[str, Functional], plan: RunPlan
) -> dict[str, Any]:
    """All on which the results of an ensemble depend, for the first line of its file."""
    values = np.ascontiguousarray(variants.values)
    options = {name: str(value) for name, value in plan._asdict().items() if name != "until"}
    if isinstance(start := plan.start, OperatingPoint):
        options["start"] = fingerprint((start.time, start.x, start.theta, start.settings))
    return {
        "lumped": "ensemble",
        "model": fingerprint(system),
        "parameters": system.parameters,
        "until": plan.until,
        "points": [*variants.names, hashlib.sha256(values.tobytes()).hexdigest()[:16]],
        "runs": len(values),
        "of": {label: f"{f}: {f.readings!r}" for label, f in of.items()},
        "options": options,
    }


class EnsembleFile(LineFile):
    """Results in a file, one line for each chunk of runs (see `LineFile`).

    Attributes
    ----------
    known : list of (int, Batch)
        Results that were found: first run, and those from it on.
    """

    def __init__(self, path: str | Path | None, head: dict[str, Any]) -> None:
        self.known: list[tuple[int, Batch]] = []
        super().__init__(path, head)

    def add(self, which: np.ndarray, batch: Batch) -> None:
        """Keep results of some runs, ascending, at once; without those that were interrupted."""
        done = np.flatnonzero(batch.status != FULL)
        for part in np.split(done, np.flatnonzero(np.diff(which[done]) != 1) + 1):
            if self._file is not None and len(part):
                values, status = batch.values[part], batch.status[part]
                self.write(
                    {
                        "first": int(which[part[0]]),
                        "values": _pack(values.astype("<f8")),
                        "status": _pack(status.astype("<i8")),
                    }
                )

    def read(self, entry: Any) -> None:
        """Take over a chunk that was written before."""
        status = np.frombuffer(base64.b64decode(entry["status"]), "<i8").astype(np.int64)
        values = np.frombuffer(base64.b64decode(entry["values"]), "<f8").astype(float)
        first = int(entry["first"])
        if not 0 <= first <= first + len(status) <= self._head["runs"]:
            raise ValueError(f"there are no runs {first} to {first + len(status) - 1}")
        batch = Batch(values.reshape(len(status), len(self._head["of"])), status)
        self.known.append((first, batch))


def _pack(numbers: np.ndarray) -> str:
    return base64.b64encode(np.ascontiguousarray(numbers).tobytes()).decode()
