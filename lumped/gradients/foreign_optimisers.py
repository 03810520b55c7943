"""Runs as functions of their parameters for optimisers and learners made elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.functionals import Functional
from lumped.gradients.functional_values import check
from lumped.gradients.gradient_ensemble import gradient_at, gradients_at
from lumped.support.arguments import checked
from lumped.support.optional_packages import extra
from lumped.timeloop.run_options import RunOptions, run_plan


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

    def function(values: np.ndarray) -> tuple[float, np.ndarray]:
        point = np.asarray(values, dtype=float)
        _check_shape(system, names, point.shape)
        found = gradient_at(system, names, point, tuple(weights), names, plan)
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
        Threads for a batch; default is one for each core.
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
    sizes = len(wanted), len(names)

    def compute(values: Any) -> tuple[np.ndarray, np.ndarray]:
        points = np.asarray(values, dtype=float)
        if points.ndim == 1:
            found = gradient_at(system, names, points, wanted, names, plan)
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
