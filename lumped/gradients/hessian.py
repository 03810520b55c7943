"""Second derivatives of numbers that sum up a run."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from lumped.compiler.system import Changes, Name, System
from lumped.errors import OptionError, SolverError
from lumped.gradients.adjoint import crossings_of
from lumped.gradients.functional_terms import AT_ONCE, SmoothParts
from lumped.gradients.functional_values import check
from lumped.gradients.legs import legs_of, recorded
from lumped.gradients.resolved_steps import divided, resolved
from lumped.gradients.second_jumps import SecondJumps
from lumped.gradients.second_order import Second
from lumped.gradients.steps import steps_of
from lumped.gradients.sweep import Seeds
from lumped.gradients.touches import refuse_touches
from lumped.gradients.varied import slopes_at_zero, sources, tightened, varied_values
from lumped.simulation.functional_kinds import (
    At,
    Final,
    Functional,
    Integral,
    factors,
    watching,
)
from lumped.support.arguments import checked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.support.units import in_seconds
from lumped.timeloop.result import Trajectory

__all__ = ["Hessian", "hessian", "hessian_product"]


@dataclass(frozen=True, eq=False)
class Hessian(RichHtml):
    """A functional of a run with its first and second derivatives.

    Attributes
    ----------
    run : Trajectory
        The run, at the steps of the solver, or at some of them (see `Gradient`).
    of : str
        The functional, as printed.
    to : tuple of str
        Parameters and start values.
    value : float
        What the functional is.
    gradient : ndarray, shape (k,)
        First derivatives.
    matrix : ndarray, shape (k, k)
        Second derivatives.
    seconds : float
        Wall time of everything after the run.
    rtol : float
        Accuracy asked for; the run is made at three thousandths of it.
    asymmetry : float
        Largest difference of mixed derivatives taken in either order, each for relative changes,
        over the largest of all: rounding. The matrix is their mean.
    """

    run: Trajectory
    of: str
    to: tuple[str, ...]
    value: float
    gradient: np.ndarray
    matrix: np.ndarray
    seconds: float
    rtol: float
    asymmetry: float

    def __repr__(self) -> str:
        rows = [
            (name, number(float(slope), 6), *(number(float(v), 6) for v in row[:8]))
            for name, slope, row in zip(self.to[:8], self.gradient, self.matrix, strict=False)
        ]
        head = (
            f"{self.run.system.name}: {self.of} = {number(self.value, 9)}; run of "
            f"{self.run.steps} steps, rtol {self.rtol:.0e}, in {self.run.statistics.seconds:.3g} "
            f"s, derivatives in {self.seconds:.3g} s more; asymmetry {self.asymmetry:.1e}"
        )
        return f"{head}\n" + table(("by", "first", *self.to[:8]), rows)


@checked
def hessian(
    system: System,
    *,
    of: Functional,
    to: Iterable[Name],
    until: float | str,
    parameters: Changes | None = None,
    start: Changes | None = None,
    rtol: float = 1e-6,
    method: Literal["auto", "explicit", "implicit"] = "auto",
) -> Hessian:
    """Simulate, and differentiate a functional of the run twice by a few parameters.

    Forward over adjoint: the sweep of `gradient`, differentiated along each parameter. The cost
    grows with the number of parameters. Where rates or states jump, at an impact or where friction
    changes its direction, second derivatives jump too: by the transposed saltation matrix of the
    states together with their derivatives. Values at given instants and integrals (means, root mean
    squares) have second derivatives here; peaks, and numbers at events, have none.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : functional
        From `lumped.functionals`: final, at, integral, mean or rms.
    to : iterable of names
        Parameters, and start values that are states.
    until, parameters, start, rtol, method
        As for `gradient`.

    Returns
    -------
    Hessian

    Raises
    ------
    OptionError
        If the functional is of another kind, there is nothing to vary, or start states depend on
        a parameter that varies.
    SolverError
        Where different changes coincide, a border is touched without being crossed, ever smaller
        bounces come to an end, redundant constraints let go, states change places, or something
        changes at an instant that is looked at.
    """
    until = in_seconds(until, "until")
    names = [system.key(name) for name in to]
    options: dict[str, Any] = {"until": until, "parameters": parameters, "start": start}
    options |= {"rtol": rtol, "method": method}
    found = _twice(system, of, names, np.eye(len(names)), "hessian", options)
    sizes = np.abs(varied_values(found.run, names))
    sizes[sizes == 0] = 1.0
    relative = found.second * np.outer(sizes, sizes)
    asymmetry = np.abs(relative - relative.T).max() / (np.abs(relative).max() or 1.0)
    second = 0.5 * (found.second + found.second.T)
    return Hessian(
        found.run,
        str(of),
        tuple(names),
        found.value,
        found.first,
        second,
        found.seconds,
        rtol,
        float(asymmetry),
    )


@checked
def hessian_product(
    system: System,
    *,
    of: Functional,
    to: Iterable[Name],
    along: Sequence[float] | np.ndarray,
    until: float | str,
    parameters: Changes | None = None,
    start: Changes | None = None,
    rtol: float = 1e-6,
    method: Literal["auto", "explicit", "implicit"] = "auto",
) -> np.ndarray:
    """The Hessian of a functional of a run times a direction.

    One sweep, however many parameters there are: what ``hessp`` of ``scipy.optimize.minimize``
    takes.

    Parameters
    ----------
    system : System
        From `assemble`.
    of, to, until, parameters, start, rtol, method
        As for `hessian`.
    along : array_like, shape (len(to),)
        The direction.

    Returns
    -------
    ndarray, shape (len(to),)

    Raises
    ------
    OptionError, SolverError
        As for `hessian`, or if the direction has another shape.
    """
    until = in_seconds(until, "until")
    names = [system.key(name) for name in to]
    direction = np.asarray(along, dtype=float)
    if direction.shape != (len(names),):
        raise OptionError(
            f"hessian_product: along has the shape {direction.shape}; {len(names)} numbers are "
            f"needed, one for each of {', '.join(names)}."
        )
    options: dict[str, Any] = {"until": until, "parameters": parameters, "start": start}
    options |= {"rtol": rtol, "method": method}
    found = _twice(system, of, names, direction[:, None], "hessian_product", options)
    product: np.ndarray = found.second[:, 0]
    return product


class _Twice(NamedTuple):
    """Value, derivatives by all names, and those of the derivatives along directions."""

    run: Trajectory
    value: float
    first: np.ndarray
    second: np.ndarray
    seconds: float


def _twice(
    system: System,
    of: Functional,
    names: list[str],
    along: np.ndarray,
    what: str,
    options: dict[str, Any],
) -> _Twice:
    """Simulate, and differentiate twice; directions are columns, shape (len(names), k)."""
    check(system, [of], names, what)
    system = watching(system, [of])
    if not isinstance(of, Final | At | Integral):
        raise OptionError(
            f"{what}: {of} has no second derivatives here; take final, at, integral, mean or rms."
        )
    if not system.structure.states:
        raise OptionError(f"{system.name}: a run without states has no steps to differentiate.")
    start, until = options["start"] or {}, options["until"]
    places, varied = sources(system, names, start)
    fine = tightened(options["rtol"])
    run = recorded(system, **{**options, "rtol": fine})
    begin = clock.perf_counter()
    legs = legs_of(run)
    products = (factors(system, of),) if isinstance(of, Integral) else ()
    steps = steps_of(system, products)
    course = SmoothParts(run, legs, crossings_of(run, legs, fine), steps, fine)
    _check_events(course, of)
    refuse_touches(run, legs, steps, fine, course.ends(of))
    course.cut(of)
    if isinstance(of, Integral):
        spans = np.array([of.between or (0.0, course.until)])
        resolved(run, legs, course.crossings, steps, Seeds(np.zeros((1, 0)), spans), [], fine)
    seed = np.zeros((len(run.theta), len(names)))
    for column, place in enumerate(places):
        if place >= 0:
            seed[place, column] = 1.0
    S = slopes_at_zero(run, start, seed, varied)
    _check_start(system, names, places, S)
    second_order = Second(course, seed @ along, S @ along, of)
    found = second_order.go()
    while divided(run, legs, found.each, found.errors, fine):
        found = second_order.go()
    by_all = np.vstack([S, seed])
    value, first, second = found.value, by_all.T @ found.first, by_all.T @ found.second
    if isinstance(of, Integral):
        value, slope, curvature = of.outcome(value, until)
        second = slope * second + curvature * np.outer(first, first @ along)
        first = slope * first
    return _Twice(run, value, first, second, clock.perf_counter() - begin)


def _check_events(course: SmoothParts, of: Final | At | Integral) -> None:
    """Refuse events that second derivatives do not pass.

    Raises
    ------
    SolverError
        With the instant and the components.
    """
    run, jumps = course.run, SecondJumps(course.run, course.steps)
    times: tuple[float, ...] = (course.until,)
    if isinstance(of, At):
        times = of.times
    elif isinstance(of, Integral):
        times = of.between or ()
    for crossing in course.crossings:
        jumps.check(crossing)
        moves = any(jump.instant.any() for order in crossing.orders for jump in order)
        near = any(abs(t - crossing.t) <= AT_ONCE * course.until for t in times)
        if near and moves:
            raise SolverError(
                f"{run.system.name}: {of}: at t = {crossing.t:.9g} s, which is looked at, "
                f"{', '.join(crossing.names)} changes; there is no second derivative. Take another "
                "instant.",
                run,
            )


def _check_start(system: System, names: list[str], places: list[int], S: np.ndarray) -> None:
    """Refuse start states that are not linear in what varies."""
    for name, place, column in zip(names, places, S.T, strict=True):
        plain = np.count_nonzero(column) == 1 and np.abs(column).max() == 1.0
        if not (plain if place < 0 else not column.any()):
            raise OptionError(
                f"{system.name}: states at the start depend on {name} through equations, whose "
                "second derivatives are not formed. Give start values of the states themselves: "
                f"{', '.join(system.state_names[:12])}."
            )
