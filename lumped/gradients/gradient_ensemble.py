"""Gradients of the runs of many variants."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass
from typing import Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.ensembles.variants import Over, variants_of
from lumped.errors import LumpedError, OptionError, SolverError, UnknownNameError, nearest
from lumped.functionals import Functional
from lumped.gradients.gradient import Gradient, gradient_of
from lumped.gradients.varied import resolve_name
from lumped.support.arguments import checked
from lumped.support.progress import Progress
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.run_options import RunOptions, RunPlan, run_plan


@dataclass(frozen=True, eq=False)
class GradientEnsemble(RichHtml):
    """Functionals of many runs and their derivatives; nan where a run failed.

    ``found["peak(shaft.tau)", "a.J"]`` is one derivative in all runs.

    Attributes
    ----------
    names : tuple of str
        What varies.
    points : ndarray, shape (n, len(names))
        Its values.
    of, to : tuple of str
        Functionals, as printed; parameters and start values.
    values, errors : ndarray, shape (n, len(of))
        What the functionals are; errors that steps add to their derivatives (see `Gradient`).
    derivatives : ndarray, shape (n, len(of), len(by))
        Their derivatives.
    failures : dict of int to str
        Why runs failed, or have no derivative.
    """

    names: tuple[str, ...]
    points: np.ndarray
    of: tuple[str, ...]
    by: tuple[str, ...]
    values: np.ndarray
    errors: np.ndarray
    derivatives: np.ndarray
    failures: dict[int, str]

    def __getitem__(self, pair: tuple[str, str]) -> np.ndarray:
        for key, known in zip(pair, (self.of, self.by), strict=True):
            if key not in known:
                raise UnknownNameError(f"'{key}' was not differentiated. {nearest(key, known)}")
        found: np.ndarray = self.derivatives[:, self.of.index(pair[0]), self.by.index(pair[1])]
        return found

    def __repr__(self) -> str:
        rows = []
        for i, label in enumerate(self.of):
            for k, name in enumerate(self.by):
                own = self.derivatives[:, i, k]
                own = own[np.isfinite(own)]
                if len(own):
                    low, middle, high = np.quantile(own, (0.05, 0.5, 0.95)).tolist()
                    rows.append((label, name, number(middle), number(low), number(high)))
        head = (
            f"{len(self.points)} runs over {', '.join(self.names)} and their gradients, "
            f"{len(self.failures)} failed"
        )
        return f"{head}\n" + table(("functional", "by", "median", "5 %", "95 %"), rows[:20])


@checked
def gradient_ensemble(
    system: System,
    *,
    over: Over,
    of: Iterable[Functional],
    by: Iterable[Name] | None = None,
    until: float | str,
    runs: int | None = None,
    seed: int = 0,
    rtol: float = 1e-6,
    workers: int | None = None,
    **options: Unpack[RunOptions],
) -> GradientEnsemble:
    """Functionals of many runs and their derivatives, on all cores.

    Each is what `gradient` gives for the parameters of one run.

    Parameters
    ----------
    system : System
        From `assemble`.
    over, runs, seed
        What varies, as for `ensemble`.
    of : iterable of functionals
        From `lumped.functionals`.
    by : iterable of names, optional
        By what they are differentiated; default is what varies.
    until, rtol
        As for `gradient`.
    workers : int, optional
        Threads; default is one for each core.
    **options : RunOptions
        Of each run (see `RunOptions`).

    Returns
    -------
    GradientEnsemble

    Raises
    ------
    OptionError
        If an option makes no sense.
    UnknownNameError
        If a quantity or parameter does not exist.
    SolverError
        If no run comes to its end with a derivative; it says why.
    """
    if workers is not None and workers < 1:
        raise OptionError(f"gradient_ensemble: workers = {workers}: at least one is needed.")
    plan = run_plan(until, rtol, options)
    base = plan.changes(system)
    varied = variants_of(
        system, over, runs=runs, seed=seed, parameters=base, analysis="gradient_ensemble"
    )
    names = tuple(varied.names if by is None else (resolve_name(system, name) for name in by))
    return gradients_at(system, varied.names, varied.values, tuple(of), names, plan, workers)


def gradient_at(
    system: System,
    names: tuple[str, ...],
    values: np.ndarray,
    of: Sequence[Functional],
    by: tuple[str, ...],
    plan: RunPlan,
) -> Gradient:
    """The gradient at a point that was checked."""
    given = plan.changes(system) | dict(zip(names, values.tolist(), strict=True))
    return gradient_of(system, of, by, plan._replace(parameters=given))


def gradients_at(
    system: System,
    names: tuple[str, ...],
    points: np.ndarray,
    of: Sequence[Functional],
    by: tuple[str, ...],
    plan: RunPlan,
    workers: int | None = None,
) -> GradientEnsemble:
    """Gradients at points, shape (n, len(names)), that were checked."""

    def one(row: np.ndarray) -> Gradient | LumpedError:
        try:
            return gradient_at(system, names, row, of, by, plan)
        except LumpedError as error:
            return error

    shape = len(points), len(of)
    values, errors = np.full(shape, np.nan), np.full(shape, np.nan)
    derivatives = np.full((*shape, len(by)), np.nan)
    failures: dict[int, str] = {}
    first: LumpedError | None = None
    with (
        ThreadPoolExecutor(workers or os.cpu_count() or 1) as pool,
        Progress(f"{system.name}: gradients", len(points)) as progress,
    ):
        waiting = [pool.submit(copy_context().run, one, row) for row in points]
        try:
            for i, future in enumerate(waiting):
                found = future.result()
                if isinstance(found, LumpedError):
                    failures[i], first = str(found), first or found
                else:
                    values[i], errors[i] = found.values, found.errors
                    derivatives[i] = found.derivatives
                progress.at(i + 1)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)
    if first is not None and len(failures) == len(points):
        if isinstance(first, OptionError | UnknownNameError):
            raise first
        raise SolverError(f"all {len(points)} runs fail. Run 0: {failures[0]}", None)
    labels = tuple(str(functional) for functional in of)
    return GradientEnsemble(names, points, labels, by, values, errors, derivatives, failures)
