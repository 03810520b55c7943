"""Many runs of one model."""

from __future__ import annotations

import inspect
import itertools
import os
import pickle
import time as clock
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lumped.compiler.system import Name, System
from lumped.errors import LumpedError, OptionError, nearest, shown
from lumped.numerics.process_pool import outcomes
from lumped.simulation.simulate import simulate
from lumped.simulation.sweep_file import SweepFile, heading
from lumped.support.arguments import checked
from lumped.support.optional_packages import extra
from lumped.support.progress import Progress
from lumped.support.text_table import number, table
from lumped.support.units import in_seconds
from lumped.timeloop.executable import executable
from lumped.timeloop.result import Trajectory

__all__ = ["Sweep", "sweep"]

_MANY = 20
"""Runs from which machine code of the system pays."""

Measure = Callable[[Trajectory], float]
Point = dict[str, float]


@dataclass(frozen=True, eq=False)
class Sweep:
    """Results of many runs; ``found[label]`` gives one of them for all points.

    Attributes
    ----------
    names : tuple of str
        What was varied.
    points : ndarray, shape (n, len(names))
        Its values in each run.
    labels : tuple of str
        What was taken from each run.
    values : ndarray, shape (n, len(labels))
        Results; nan where a run failed.
    failures : dict of int to str
        Why runs failed, or which results are not numbers, by the number of the point.
    shape : tuple of int
        That of the grid over which was swept, such as ``found["peak"].reshape(found.shape)``.
    workers : int
        Processes that worked.
    seconds, busy : float
        Wall time, and the time that the processes spent in runs.
    """

    names: tuple[str, ...]
    points: NDArray[np.float64]
    labels: tuple[str, ...]
    values: NDArray[np.float64]
    failures: dict[int, str]
    shape: tuple[int, ...]
    workers: int
    seconds: float
    busy: float

    def __getitem__(self, label: str) -> NDArray[np.float64]:
        if label in self.labels:
            return self.values[:, self.labels.index(label)]
        if label in self.names:
            return self.points[:, self.names.index(label)]
        known = ", ".join((*self.names, *self.labels))
        raise OptionError(f"sweep: there is no '{label}', only {known}.")

    def to_pandas(self) -> Any:
        """A DataFrame, one row for each run, with an empty ``failure`` where there is none.

        Raises
        ------
        OptionError
            If pandas is not installed.
        """
        pandas = extra("pandas", "data", "to_pandas")
        columns = {name: self[name] for name in (*self.names, *self.labels)}
        reasons = [self.failures.get(i, "") for i in range(len(self.points))]
        return pandas.DataFrame(columns | {"failure": reasons})

    def __repr__(self) -> str:
        head = (
            f"{len(self.points)} runs, {len(self.failures)} failed; {self.seconds:.3g} s on "
            f"{self.workers} processes, {self.busy:.3g} s of work"
        )
        rows = []
        for label in self.labels:
            good = self[label][np.isfinite(self[label])]
            low, high = (good.min(), good.max()) if len(good) else (np.nan, np.nan)
            rows.append((label, number(low), number(high)))
        reasons = [f"point {i}: {reason}" for i, reason in list(self.failures.items())[:3]]
        return "\n".join([head, table(("result", "least", "greatest"), rows), *reasons])


@checked
def sweep(
    system: System,
    *,
    over: Mapping[Name, ArrayLike] | Iterable[Mapping[Name, float]],
    until: float | str,
    of: Mapping[str, Measure],
    workers: int | None = None,
    store: str | Path | None = None,
    client: Any = None,
    **options: Any,
) -> Sweep:
    """Run a system for many values of its parameters, on all cores.

    Results do not depend on the number of processes. A run that fails, or whose process dies, is
    set apart with its reason and stops no other. After an interrupt (Ctrl-C) what was done is
    returned; what is missing counts as failed.

    Parameters
    ----------
    system : System
        From `assemble`.
    over : mapping or iterable of mappings
        Values for each parameter, which make a grid (the last varies fastest); or parameters of
        each run. Numbers in SI units, or texts such as ``"2 deg"``.
    until : float or str
        End of each run, s.
    of : mapping of str to callable
        What to take from each run: functions of a `Trajectory` that give a number.
    workers : int, optional
        Processes; default is one for each core.
    store : str or Path, optional
        File in which each result is written as it comes, one line of JSON each. If it exists, what
        it holds is not run again. It belongs to a model, its parameters, options and the functions
        in `of` with all that these use (see `lumped.timeloop.fingerprint`).
    client : dask.distributed.Client, optional
        Run on its cluster instead; functions and model classes travel by cloudpickle.
    **options
        As for `simulate`; its `parameters` hold in all runs, unless varied.

    Returns
    -------
    Sweep

    Raises
    ------
    OptionError
        If there is nothing to vary or to take, or `store` belongs to another sweep or is damaged.
    UnknownNameError
        If a parameter does not exist.
    UnitError
        If a value has a unit of another dimension.
    ParameterError
        If a value is no number.
    """
    points, shape = _points(system, over)
    _check_options(options)
    if not of:
        raise OptionError('sweep: name what to take from each run, of={"peak": function}.')
    if workers is not None and workers < 1:
        raise OptionError(f"sweep: workers = {workers}: at least one process is needed.")
    if client is not None and not hasattr(client, "scatter"):
        raise OptionError(
            f"sweep: client = {shown(client)}: a client from dask.distributed is needed."
        )
    until = in_seconds(until, "until")
    head = {} if store is None else heading(system, until, of, options)
    done = SweepFile(store, head)
    job = Job(system, until, dict(of), options)
    if len(points) >= _MANY:
        executable(system).compile()
    begin, busy = clock.perf_counter(), 0.0
    count = workers or os.cpu_count() or 1
    known = {i: done[point] for i, point in enumerate(points)}
    found = {i: outcome for i, outcome in known.items() if outcome is not None}
    waiting = [(i, points[i]) for i, outcome in known.items() if outcome is None]
    try:
        with Progress(f"{system.name}: runs", len(points)) as progress:
            for i, outcome, spent in outcomes(job, waiting, count, client, system.building):
                found[i] = outcome
                busy += spent
                done.add(points[i], outcome)
                progress.at(len(found))
    finally:
        done.close()
    names = tuple(points[0])
    values = np.full((len(points), len(of)), np.nan)
    failures = {}
    for i in range(len(points)):
        outcome = found.get(i, "interrupted before it was run")
        if isinstance(outcome, str):
            failures[i] = outcome
            continue
        values[i] = outcome
        missing = [label for label, v in zip(of, outcome, strict=True) if np.isnan(v)]
        if missing:
            failures[i] = f"{', '.join(missing)}: not a number"
    table_ = np.array([[point[name] for name in names] for point in points])
    wall = clock.perf_counter() - begin
    return Sweep(names, table_, tuple(of), values, failures, shape, count, wall, busy)


class Job:
    """What each run of a sweep does; travels to other processes as its model.

    Parameters
    ----------
    system : System
    until : float or str
    of : dict of str to callable
    options : dict
        As for `sweep`.
    """

    def __init__(
        self,
        system: System,
        until: float,
        of: dict[str, Measure],
        options: dict[str, Any],
    ) -> None:
        self.system, self.until, self.of, self.options = system, until, of, options
        base = options.get("parameters") or {}
        self._base = {system.key(name): value for name, value in base.items()}

    def __call__(self, point: Point) -> list[float] | str:
        """Numbers of one run, or why there are none."""
        try:
            options = {**self.options, "parameters": {**self._base, **point}}
            run = simulate(self.system, until=self.until, **options)
            return [_measured(label, measure(run)) for label, measure in self.of.items()]
        except LumpedError as fault:
            return str(fault)
        except Exception as fault:  # a fault of what is taken from a run stops no other run
            return f"{type(fault).__name__}: {fault}"

    def __reduce__(self) -> tuple[Callable[..., Job], tuple[bytes]]:
        cloudpickle = extra("cloudpickle", "cluster", "A sweep in processes that are not forked")
        parts = (self.system, self.until, self.of, self.options)
        return _restored, (cloudpickle.dumps(parts),)


def _measured(label: str, value: object) -> float:
    if np.ndim(value) == 0 and np.asarray(value).dtype.kind in "biuf":  # type: ignore[arg-type]
        return float(value)  # type: ignore[arg-type]
    raise OptionError(f"sweep: of['{label}'] gave {shown(value)}; a number is needed.")


def _check_options(options: Mapping[str, Any]) -> None:
    """Refuse what no run takes, before the first one."""
    known = inspect.signature(simulate).parameters
    for name, value in options.items():
        if name not in known:
            raise OptionError(f"sweep: no option '{name}'. {nearest(name, known)}")
        if name == "parameters" and not isinstance(value, Mapping | None):
            raise OptionError(
                f"sweep: parameters = {shown(value)}: a dictionary with names as keys is needed."
            )


def _restored(payload: bytes) -> Job:
    return Job(*pickle.loads(payload))


def _points(
    system: System, over: Mapping[Name, ArrayLike] | Iterable[Mapping[Name, float]]
) -> tuple[list[Point], tuple[int, ...]]:
    """Parameters of each run by their full names, and the shape of the grid."""
    if isinstance(over, Mapping):
        axes = [_numbers(system, name, values) for name, values in over.items()]
        shape: tuple[int, ...] = tuple(len(axis) for axis in axes)
        names = [system.key(name) for name in over]
        rows = [dict(zip(names, row, strict=True)) for row in itertools.product(*axes)]
    else:
        rows = [{system.key(n): _numbers(system, n, v)[0] for n, v in p.items()} for p in over]
        shape = (len(rows),)
    if not rows or not rows[0]:
        raise OptionError("sweep: there is nothing to vary; give values of at least one parameter.")
    if any(row.keys() != rows[0].keys() for row in rows):
        raise OptionError("sweep: each point must name the same parameters.")
    system.places(rows[0])
    return rows, shape


def _numbers(system: System, name: Name, values: object) -> list[float]:
    """Values of a parameter, with units or without; their range is checked by each run."""
    p, (place,) = system.structure.parameters, system.places([name])
    number = p.free[place]
    given = np.ravel(np.asarray(values, dtype=object)) if not isinstance(values, str) else [values]
    return [p.number(number, value) for value in given]
