"""Many runs of one system in the time loop, on all cores."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from lumped.compiler.system import System
from lumped.ensembles.collected_runs import (
    STOPPED,
    EnsembleFile,
    collect_runs,
    failures_of,
    heading,
    label_functionals,
)
from lumped.ensembles.outcome import Ensemble
from lumped.ensembles.variants import Over, Sampling, fill_parameters, variants_of
from lumped.errors import OptionError, SolverError, shown
from lumped.functionals import Functional
from lumped.kernel.run import DONE
from lumped.many_runs.native_runs import NativeRuns
from lumped.support.arguments import checked
from lumped.timeloop.run_options import RunOptions, run_plan


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
