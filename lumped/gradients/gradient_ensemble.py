"""Gradients of many runs, and runs as functions for optimisers and learners made elsewhere."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.ensembles.variants import Over, variants_of
from lumped.errors import LumpedError, OptionError, SolverError, UnknownNameError
from lumped.functionals import Functional
from lumped.gradients.functional_values import check
from lumped.gradients.gradient import Gradient, gradient_of
from lumped.gradients.varied import resolve_name
from lumped.numerics.process_pool import Outcome, may_fork, outcomes
from lumped.support.arguments import checked
from lumped.support.by_name import find_place
from lumped.support.optional_packages import extra
from lumped.support.progress import Progress
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.run_options import RunOptions, RunPlan, run_plan

_ALONE = 0.1
"""Time after the first gradient in which no other process helps: it would take that to begin, s."""


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
        row, column = (
            find_place(key, known, "was not differentiated")
            for key, known in zip(pair, (self.of, self.by), strict=True)
        )
        return self.derivatives[:, row, column]

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

    Each is what `gradient` gives for the parameters of one run. Most is done by forked processes,
    as Python, which one thread at a time runs, is much of a gradient; where there are no forks,
    one is done after the other.

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
        Processes; default is one for each core.
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


@dataclass
class _Gradients:
    """Gradients at points that were checked; arguments as for `gradient_of`.

    Attributes
    ----------
    first : LumpedError or None
        The first failure in this process.
    """

    system: System
    of: Sequence[Functional]
    by: tuple[str, ...]
    plan: RunPlan
    first: LumpedError | None = field(default=None, init=False)

    def at(self, point: dict[str, float]) -> Gradient:
        """The gradient at a point."""
        plan = self.plan._replace(parameters=self.plan.changes(self.system) | point)
        return gradient_of(self.system, self.of, self.by, plan)

    def __call__(self, point: dict[str, float]) -> Outcome:
        """Values, their errors and derivatives, one after the other, or why there are none."""
        try:
            found = self.at(point)
        except LumpedError as error:
            self.first = self.first or error
            return str(error)
        return [*found.values.tolist(), *found.errors.tolist(), *found.derivatives.ravel().tolist()]

    def at_all(self, points: list[dict[str, float]], workers: int) -> Iterator[tuple[int, Outcome]]:
        """Numbers at all points; those at the first are found here, which makes what all need."""
        done, end = 0, np.inf
        while done < len(points) and clock.perf_counter() < end:
            yield done, self(points[done])
            if not done:
                end = clock.perf_counter() + _ALONE
            done += 1
        rest = list(enumerate(points))[done:]
        for i, outcome, _ in outcomes(self, rest, workers if may_fork() else 1, None):
            yield i, outcome


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
    job, count = _Gradients(system, of, by, plan), len(of)
    given = [dict(zip(names, row, strict=True)) for row in points.tolist()]
    whole = np.full((len(points), count * (2 + len(by))), np.nan)
    failures = dict.fromkeys(range(len(points)), "interrupted before it was run")
    with Progress(f"{system.name}: gradients", len(points)) as progress:
        found = job.at_all(given, workers or os.cpu_count() or 1)
        for done, (i, outcome) in enumerate(found, 1):
            if isinstance(outcome, str):
                failures[i] = outcome
            else:
                del failures[i]
                whole[i] = outcome
            progress.at(done)
    if job.first is not None and len(failures) == len(points):
        if isinstance(job.first, OptionError | UnknownNameError):
            raise job.first
        raise SolverError(f"all {len(points)} runs fail. Run 0: {failures[0]}", None)
    values, errors, derivatives = np.split(whole, (count, 2 * count), axis=1)
    derivatives = derivatives.reshape(len(points), count, len(by))
    labels = tuple(str(functional) for functional in of)
    return GradientEnsemble(names, points, labels, by, values, errors, derivatives, failures)


@checked
def value_and_gradient(
    system: System,
    *,
    of: Functional | Mapping[Functional, float],
    by: Iterable[Name],
    until: float | str,
    rtol: float = 1e-6,
    **options: Unpack[RunOptions],
) -> Callable[[np.ndarray], tuple[float, np.ndarray]]:
    """A functional of a run and its gradient, as a function of parameters.

    It is what ``scipy.optimize.minimize(..., jac=True)`` takes.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : functional, or mapping of functional to float
        From `lumped.functionals`; of several the sum with these weights.
    by : iterable of names
        Parameters, whose values the function takes in this order, in SI units.
    until, rtol
        As for `gradient`.
    **options : RunOptions
        Of the run (see `RunOptions`).

    Returns
    -------
    callable
        ``function(values) -> (value, gradient)``, with arrays of shape (len(by),).

    Raises
    ------
    OptionError
        If `by` holds nothing that can be changed, or there is no functional.
    UnknownNameError
        If a quantity or parameter does not exist.

    Examples
    --------
    >>> fun = value_and_gradient(system, of=peak("shaft.tau"), over=["shaft.c"], until=2.0)
    >>> scipy.optimize.minimize(fun, [1e4], jac=True)  # doctest: +SKIP
    """
    weights = dict(of) if isinstance(of, Mapping) else {of: 1.0}
    plan = run_plan(until, rtol, options)
    names = _names("value_and_gradient", system, weights, by)
    factors = np.array(list(weights.values()), dtype=float)
    gradients = _Gradients(system, tuple(weights), names, plan)

    def function(values: np.ndarray) -> tuple[float, np.ndarray]:
        point = np.asarray(values, dtype=float)
        _check_shape(system, names, point.shape)
        found = gradients.at(dict(zip(names, point.tolist(), strict=True)))
        return float(factors @ found.values), factors @ found.derivatives

    return function


@checked
def to_jax(
    system: System,
    *,
    of: Iterable[Functional],
    by: Iterable[Name],
    until: float | str,
    rtol: float = 1e-6,
    workers: int | None = None,
    **options: Unpack[RunOptions],
) -> Callable[[Any], Any]:
    """Functionals of a run as a function for JAX.

    The function goes through ``jax.grad``, ``jax.jit`` and ``jax.vmap``; a batch is computed on
    all cores. Derivatives are those of `gradient`. There are no second derivatives.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : iterable of functionals
        From `lumped.functionals`.
    by : iterable of names
        Parameters, whose values the function takes in this order, in SI units.
    until, rtol
        As for `gradient`.
    workers : int, optional
        Processes for a batch; default is one for each core.
    **options : RunOptions
        Of each run (see `RunOptions`).

    Returns
    -------
    callable
        ``function(values)``: from an array of shape (len(by),) to one of shape (len(of),).

    Raises
    ------
    OptionError
        If JAX is missing or computes with single precision, `by` holds nothing that can be
        changed, or there is no functional.
    UnknownNameError
        If a quantity or parameter does not exist.
    """
    jax = extra("jax", "jax", "to_jax")
    if not jax.config.jax_enable_x64:
        raise OptionError(
            "to_jax: JAX computes with single precision, which loses what runs are good for; call "
            'jax.config.update("jax_enable_x64", True) first.'
        )
    wanted = tuple(of)
    plan, names = run_plan(until, rtol, options), _names("to_jax", system, wanted, by)
    sizes, gradients = (len(wanted), len(names)), _Gradients(system, wanted, names, plan)

    def compute(values: Any) -> tuple[np.ndarray, np.ndarray]:
        points = np.asarray(values, dtype=float)
        if points.ndim == 1:
            found = gradients.at(dict(zip(names, points.tolist(), strict=True)))
            return found.values, found.derivatives
        rows = points.reshape(-1, sizes[1])
        many = gradients_at(system, names, rows, wanted, names, plan, workers)
        if many.failures:
            first, text = next(iter(many.failures.items()))
            raise SolverError(f"to_jax: {len(many.failures)} runs fail. Run {first}: {text}", None)
        outer = points.shape[:-1]
        return many.values.reshape(*outer, -1), many.derivatives.reshape(*outer, *sizes)

    def call_back(values: Any) -> Any:
        _check_shape(system, names, values.shape)
        shapes = tuple(
            jax.ShapeDtypeStruct((*values.shape[:-1], *own), np.float64)
            for own in (sizes[:1], sizes)
        )
        return jax.pure_callback(compute, shapes, values, vmap_method="broadcast_all")

    @jax.custom_vjp  # type: ignore[untyped-decorator]
    def function(values: Any) -> Any:
        return call_back(values)[0]

    def forward(values: Any) -> tuple[Any, Any]:
        found: tuple[Any, Any] = call_back(values)
        return found

    def backward(slopes: Any, seeds: Any) -> tuple[Any]:
        return (seeds @ slopes,)

    function.defvjp(forward, backward)
    made: Callable[[Any], Any] = function
    return made


def _names(
    what: str, system: System, of: Iterable[Functional], by: Iterable[Name]
) -> tuple[str, ...]:
    """What varies."""
    names = tuple(system.key(name) for name in by)
    check(system, list(of), names, what)
    system.places(names)
    return names


def _check_shape(system: System, names: tuple[str, ...], shape: tuple[int, ...]) -> None:
    if shape != (len(names),):
        raise OptionError(
            f"{system.name}: values of the shape {shape}; {len(names)} are needed, those of "
            f"{', '.join(names)}."
        )
