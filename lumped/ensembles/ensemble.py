"""Many runs of one system in the time loop, on all cores."""

from __future__ import annotations

import base64
import hashlib
import os
import time as clock
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from lumped.compiler.system import System
from lumped.ensembles.line_file import LineFile
from lumped.ensembles.outcome import Ensemble
from lumped.ensembles.parallel_runs import DIED, on_cluster, run_in_threads
from lumped.ensembles.variants import Over, ParameterSets, Sampling, fill_parameters, variants_of
from lumped.errors import Interrupted, LumpedError, OptionError, SolverError, shown
from lumped.functionals import Functional
from lumped.kernel.run import DONE, FULL
from lumped.many_runs.native_runs import Batch, NativeRuns
from lumped.points.start import run_start
from lumped.simulation.simulate import run_on
from lumped.support.arguments import checked
from lumped.support.progress import Progress
from lumped.timeloop.results.fingerprint import fingerprint
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.run_options import RunOptions, RunPlan, run_plan


@checked
def ensemble(
    system: System,
    *,
    over: Over,
    until: float | str,
    of: Mapping[str, Functional] | Iterable[Functional],
    runs: int | None = None,
    seed: int = 0,
    sampling: Sampling = "random",
    rtol: float = 1e-6,
    workers: int | None = None,
    store: str | Path | None = None,
    client: Any = None,
    **options: Unpack[RunOptions],
) -> Ensemble:
    """Run a system for many values of its parameters, in machine code and on all cores.

    Functionals are collected in the time loop while it runs; nothing else is kept. Each run is the
    one that `simulate` makes with ``method="steps"``, or by the method that is named, whatever the
    number of threads.

    Parameters
    ----------
    system : System
        From `assemble`.
    over : mapping, iterable of mappings, or what `paired` and `correlated` give
        What varies: sequences of values, which make a grid; distributions, from which runs are
        drawn; or the parameters of each run (see `variants_of`).
    until : float or str
        End of each run, s.
    of : mapping of str to functional, or iterable of functionals
        What to take from each run (see `lumped.functionals`).
    runs : int, optional
        Number of runs that are drawn.
    seed : int
        Of the numbers that are drawn; the same seed gives the same runs.
    sampling : {"random", "latin", "sobol", "halton"}
        How they are drawn.
    rtol : float
        Relative tolerance.
    workers : int, optional
        Threads; default is one for each core.
    store : str or Path, optional
        File in which results are written as they come. If it exists, what it holds is not run
        again. It belongs to a model, its parameters, what varies, options and functionals.
    client : dask.distributed.Client, optional
        Run on its cluster instead; the results are the same to the last bit.
    **options : RunOptions
        Of each run (see `RunOptions`).

    Returns
    -------
    Ensemble

    Raises
    ------
    OptionError
        If there is nothing to vary or to take, an option makes no sense, or `store` belongs to
        another ensemble or is damaged.
    UnknownNameError
        If a parameter or quantity does not exist.
    SolverError
        If no run comes to its end; it says why.
    """
    plan = run_plan(until, rtol, options).by_steps("ensemble")
    if workers is not None and workers < 1:
        raise OptionError(f"ensemble: workers = {workers}: at least one thread is needed.")
    if client is not None and not hasattr(client, "scatter"):
        raise OptionError(
            f"ensemble: client = {shown(client)}: a client from dask.distributed is needed."
        )
    wanted = label_functionals(of, "ensemble")
    system = plan.watching(system, wanted.values())
    changes = plan.changes(system)
    varied = variants_of(system, over, runs=runs, seed=seed, sampling=sampling, parameters=changes)
    made = NativeRuns(system, varied.names, fill_parameters(system, changes), wanted, plan)
    head = {} if store is None else heading(system, varied, wanted, plan)
    file = EnsembleFile(store, head)
    count = workers or os.cpu_count() or 1
    if client is not None:
        count = sum(client.nthreads().values())
    begun = clock.perf_counter()
    values, status, busy = collect_runs(made, varied.values, count, file, client)
    failures = failures_of(made, varied.values, values, status)
    own = np.flatnonzero((status != DONE) & ~np.isin(status, [*STOPPED]))
    if len(own) and (status != DONE).all():
        first = int(own[0])
        text = f"all {len(status)} runs fail. Run {first}: {failures[first]}"
        raise SolverError(f"ensemble: {text}", None)
    wall = clock.perf_counter() - begun
    return Ensemble(
        varied.names,
        varied.values,
        tuple(wanted),
        values,
        failures,
        varied.shape,
        count,
        wall,
        busy,
        system.name,
        tuple(functional.unit(system) for functional in wanted.values()),
    )


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

        Raises
        ------
        Interrupted
            With the same of the first runs, up to the one that was not done.
        """
        if not len(points):
            return np.full((0, len(self._made.watched.of)), np.nan), {}
        made = self._made
        values, status, _ = collect_runs(made, points, min(self._workers, len(points)))
        if not made.is_stopped:
            return values, failures_of(made, points, values, status)
        made.go_on()
        n = int(np.argmax([*(status == FULL), True]))
        known = values[:n], failures_of(made, points[:n], values[:n], status[:n])
        raise Interrupted(f"{made.system.name}: interrupted after {n} of {len(points)} runs", known)


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
        if point.system is not system:
            led = ", ".join(point.system.state_names[:6])
            return (
                f"{system.name}: runs of an ensemble keep the states of the system, but this one "
                f"starts led by {led}. Declare these with state='prefer'."
            )
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
