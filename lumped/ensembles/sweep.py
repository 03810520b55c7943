"""Many runs of one model."""

from __future__ import annotations

import json
import math
import os
import pickle
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from lumped.compiler.system import System
from lumped.ensembles.distributions import paired
from lumped.ensembles.ensemble import ensemble
from lumped.ensembles.line_file import LineFile
from lumped.ensembles.outcome import Ensemble
from lumped.ensembles.variants import Over, Sampling, variants_of
from lumped.errors import LumpedError, OptionError, shown
from lumped.functionals import Functional
from lumped.numerics.process_pool import outcomes
from lumped.simulation.simulate import simulate
from lumped.support.arguments import checked
from lumped.support.optional_packages import extra
from lumped.support.progress import Progress
from lumped.timeloop.plants.executable import executable
from lumped.timeloop.results.fingerprint import fingerprint
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import Grid, RunOptions, run_plan

_MANY = 20
"""Runs from which machine code of the system pays."""

Measure = Callable[[Trajectory], float]
Point = dict[str, float]
Outcome = list[float] | str


@checked
def sweep(
    system: System,
    *,
    over: Over,
    until: float | str,
    of: Mapping[str, Measure | Functional],
    runs: int | None = None,
    seed: int = 0,
    sampling: Sampling = "random",
    grid: Grid = 500,
    rtol: float = 1e-6,
    workers: int | None = None,
    store: str | Path | None = None,
    client: Any = None,
    **options: Unpack[RunOptions],
) -> Ensemble:
    """Run a system for many values of its parameters, on all cores.

    Results do not depend on the number of processes. A run that fails, or whose process dies, is
    set apart with its reason and stops no other. After an interrupt (Ctrl-C) what was done is
    returned; what is missing counts as failed.

    Parameters
    ----------
    system : System
        From `assemble`.
    over : mapping, iterable of mappings, or what `paired` gives
        Values for each parameter, which make a grid (the last varies fastest); or parameters of
        each run. Numbers in SI units, or texts such as ``"2 deg"``.
    until : float or str
        End of each run, s.
    of : mapping of str to callable or functional
        What to take from each run: functions of a `Trajectory` that give a number; functionals
        are left to `ensemble`, which is much faster.
    runs, seed, sampling
        Where runs are drawn, as for `ensemble`.
    grid, rtol
        Of the runs that functions take, as for `simulate`.
    workers : int, optional
        Processes; default is one for each core.
    store : str or Path, optional
        File in which each result is written as it comes, one line of JSON each. If it exists, what
        it holds is not run again. It belongs to a model, its parameters, options and the functions
        in `of` with all that these use (see `lumped.timeloop.results.fingerprint`).
    client : dask.distributed.Client, optional
        Run on its cluster instead; functions and model classes travel by cloudpickle.
    **options : RunOptions
        Of each run (see `RunOptions`).

    Returns
    -------
    Ensemble

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
    functionals = {label: f for label, f in of.items() if isinstance(f, Functional)}
    measures = {label: f for label, f in of.items() if not isinstance(f, Functional)}
    plan = run_plan(until, rtol, options)
    fixed, until = plan.changes(system), plan.until
    varied = variants_of(
        system,
        over,
        runs=runs,
        seed=seed,
        sampling=sampling,
        parameters=fixed,
        analysis="sweep",
    )
    if not of:
        raise OptionError('sweep: name what to take from each run, of={"peak": function}.')
    summed: Ensemble | None = None
    if functionals:
        if measures and store is not None:
            raise OptionError(
                "sweep: a file holds results of functions or of functionals; sweep for the "
                "functions and call lumped.ensemble for the functionals."
            )
        together = paired(dict(zip(varied.names, varied.values.T, strict=True)))
        given: dict[str, Any] = {"rtol": rtol, "workers": workers, "client": client, **options}
        summed = ensemble(system, over=together, until=until, of=functionals, store=store, **given)
        summed = replace(summed, shape=varied.shape)
        if not measures:
            return summed
    names = varied.names
    points = [dict(zip(names, row, strict=True)) for row in varied.values.tolist()]
    if workers is not None and workers < 1:
        raise OptionError(f"sweep: workers = {workers}: at least one process is needed.")
    if client is not None and not hasattr(client, "scatter"):
        raise OptionError(
            f"sweep: client = {shown(client)}: a client from dask.distributed is needed."
        )
    given = {"grid": grid, "rtol": rtol, **options}
    head = {} if store is None else _heading(system, until, measures, given)
    done = SweepFile(store, head)
    job = Job(system, until, measures, given)
    if len(points) >= _MANY:
        executable(system).compile()
    begin, busy = clock.perf_counter(), 0.0
    count = workers or os.cpu_count() or 1
    known = {i: done[point] for i, point in enumerate(points)}
    found = {i: outcome for i, outcome in known.items() if outcome is not None}
    waiting = [(i, points[i]) for i, outcome in known.items() if outcome is None]
    try:
        with Progress(f"{system.name}: runs", len(points)) as progress:
            for i, outcome, spent in outcomes(job, waiting, count, client):
                found[i] = outcome
                busy += spent
                done.add(points[i], outcome)
                progress.at(len(found))
    finally:
        done.close()
    values = np.full((len(points), len(measures)), np.nan)
    failures = {}
    for i in range(len(points)):
        outcome = found.get(i, "interrupted before it was run")
        if isinstance(outcome, str):
            failures[i] = outcome
            continue
        values[i] = outcome
        missing = [label for label, v in zip(measures, outcome, strict=True) if np.isnan(v)]
        if missing:
            failures[i] = f"{', '.join(missing)}: not a number"
    wall = clock.perf_counter() - begin
    swept = Ensemble(
        names,
        varied.values,
        tuple(measures),
        values,
        failures,
        varied.shape,
        count,
        wall,
        busy,
        system.name,
    )
    return swept if summed is None else _join(summed, swept, tuple(of))


def _join(summed: Ensemble, swept: Ensemble, labels: tuple[str, ...]) -> Ensemble:
    """Results of functionals and of functions for the same runs."""
    both = summed.failures, swept.failures
    units = dict(zip(summed.labels, summed.units, strict=True))
    return replace(
        summed,
        labels=labels,
        values=np.column_stack([(summed if k in units else swept)[k] for k in labels]),
        failures={i: "; ".join(f[i] for f in both if i in f) for i in sorted({*both[0], *both[1]})},
        seconds=summed.seconds + swept.seconds,
        busy=summed.busy + swept.busy,
        units=tuple(units.get(k, "") for k in labels),
    )


@dataclass(frozen=True)
class Job:
    """What each run of a sweep does; travels to other processes as its model.

    Attributes
    ----------
    system : System
    until : float
    of : dict of str to callable
    options : dict
        As for `sweep`.
    """

    system: System
    until: float
    of: dict[str, Measure]
    options: dict[str, Any]

    def __call__(self, point: Point) -> Outcome:
        """Numbers of one run, or why there are none."""
        base = self.options.get("parameters") or {}
        given = {self.system.key(name): value for name, value in base.items()} | point
        try:
            options = {**self.options, "parameters": given}
            run = simulate(self.system, until=self.until, **options)
            return [_check_number(label, measure(run)) for label, measure in self.of.items()]
        except LumpedError as fault:
            return str(fault)
        except Exception as fault:  # a fault of what is taken from a run stops no other run
            return f"{type(fault).__name__}: {fault}"

    def __reduce__(self) -> tuple[Callable[..., Job], tuple[bytes]]:
        cloudpickle = extra("cloudpickle", "cluster", "A sweep in processes that are not forked")
        parts = (self.system, self.until, self.of, self.options)
        return _restore, (cloudpickle.dumps(parts),)


def _check_number(label: str, value: object) -> float:
    if np.ndim(value) == 0 and np.asarray(value).dtype.kind in "biuf":  # type: ignore[arg-type]
        return float(value)  # type: ignore[arg-type]
    raise OptionError(f"sweep: of['{label}'] gave {shown(value)}; a number is needed.")


def _restore(payload: bytes) -> Job:
    return Job(*pickle.loads(payload))


def _heading(
    system: System, until: float, of: Mapping[str, object], options: Mapping[str, object]
) -> dict[str, Any]:
    """All on which the results of a sweep depend but the point, for the first line of its file."""
    return {
        "lumped": "sweep",
        "model": fingerprint(system),
        "parameters": system.parameters,
        "until": until,
        "of": {label: fingerprint(measure) for label, measure in of.items()},
        "options": {name: fingerprint(value) for name, value in options.items()},
    }


class SweepFile(LineFile):
    """Results in a file, one line for each run (see `LineFile`).

    Attributes
    ----------
    known : dict of str to list of float or str
        Results that were found, or why there are none, by their point.
    """

    def __init__(self, path: str | Path | None, head: dict[str, Any]) -> None:
        self.known: dict[str, Outcome] = {}
        super().__init__(path, head)

    def __getitem__(self, point: Point) -> Outcome | None:
        """What is known of a point."""
        return self.known.get(_key(point))

    def add(self, point: Point, outcome: Outcome) -> None:
        """Keep a result, at once."""
        if isinstance(outcome, str):
            self.write({"point": point, "failure": outcome})
        else:  # JSON has no number that is not finite
            values = [value if math.isfinite(value) else repr(value) for value in outcome]
            self.write({"point": point, "values": values})

    def read(self, entry: Any) -> None:
        """Take over a run that was written before."""
        point = {str(name): float(value) for name, value in entry["point"].items()}
        if isinstance(failure := entry.get("failure"), str):
            self.known[_key(point)] = failure
            return
        values = [float(value) for value in entry["values"]]
        if len(values) != len(self._head["of"]):
            raise ValueError(f"{len(values)} results")
        self.known[_key(point)] = values


def _key(point: Point) -> str:
    return json.dumps(point, sort_keys=True)
