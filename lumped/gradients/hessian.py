"""Second derivatives of numbers that sum up a run in which no rate jumps."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from lumped.compiler.system import Changes, Name, System
from lumped.errors import OptionError, SolverError
from lumped.gradients.adjoint import Seeds, crossings_of, legs_of, steps_of
from lumped.gradients.functional_terms import SmoothParts
from lumped.gradients.functional_values import check
from lumped.gradients.resolved_steps import divided, resolved
from lumped.gradients.second_order import Second
from lumped.gradients.varied import slopes_at_zero, sources, tightened, varied_values
from lumped.simulation.functional_kinds import At, Final, Functional, Integral, factors
from lumped.simulation.simulate import simulate
from lumped.support.arguments import checked
from lumped.support.text_table import number, table
from lumped.support.units import in_seconds
from lumped.timeloop.result import Trajectory

__all__ = ["Hessian", "hessian"]


@dataclass(frozen=True, eq=False)
class Hessian:
    """A functional of a run with its first and second derivatives.

    Attributes
    ----------
    run : Trajectory
        The run, at the steps of the solver.
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
    grows with the number of parameters. Only for runs in which no rate jumps, and for values at
    given instants and integrals (means, root mean squares): where rates or states jump, they do so
    by derivatives whose own are not formed, and peaks move. Where a rate has a kink, as that of
    ``w * abs(w)``, its derivatives jump; that is followed.

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
        If rates or states jump in the run.
    """
    until = in_seconds(until, "until")
    names = [system.key(name) for name in to]
    check(system, [of], names, "hessian")
    label = str(of)
    if not isinstance(of, Final | At | Integral):
        raise OptionError(
            f"hessian: {label} has no second derivatives here; take final, at, integral, mean or "
            "rms."
        )
    if not system.structure.states:
        raise OptionError(f"{system.name}: a run without states has no steps to differentiate.")
    places, varied = sources(system, names, start or {})
    fine = tightened(rtol)
    run = simulate(
        system,
        until=until,
        parameters=parameters,
        start=start,
        grid=None,
        rtol=fine,
        method=method,
    )
    begin = clock.perf_counter()
    legs = legs_of(run)
    products = (factors(system, of),) if isinstance(of, Integral) else ()
    steps = steps_of(system, products)
    course = SmoothParts(run, legs, crossings_of(run, legs, fine), steps, fine)
    _refuse_events(course)
    course.cut(of)
    if isinstance(of, Integral):
        spans = np.array([of.between or (0.0, course.until)])
        resolved(run, legs, course.crossings, steps, Seeds(np.zeros((1, 0)), spans), [], fine)
    seed = np.zeros((len(run.theta), len(names)))
    for column, place in enumerate(places):
        if place >= 0:
            seed[place, column] = 1.0
    S = slopes_at_zero(run, start or {}, seed, varied)
    _check_start(system, names, places, S)
    second_order = Second(course, seed, S, of)
    found = second_order.go()
    while divided(run, legs, steps, found.each, found.errors, fine):
        found = second_order.go()
    value, first, second = found[:3]
    if isinstance(of, Integral):
        value, slope, curvature = of.outcome(value, until)
        second = slope * second + curvature * np.outer(first, first)
        first = slope * first
    sizes = np.abs(varied_values(run, names))
    sizes[sizes == 0] = 1.0
    relative = second * np.outer(sizes, sizes)
    asymmetry = np.abs(relative - relative.T).max() / (np.abs(relative).max() or 1.0)
    second = 0.5 * (second + second.T)
    seconds = clock.perf_counter() - begin
    return Hessian(run, label, tuple(names), value, first, second, seconds, rtol, float(asymmetry))


def _refuse_events(course: SmoothParts) -> None:
    """Refuse changes at which rates jump; where they only have a kink, all is known."""
    run, steps = course.run, course.steps
    for crossing in course.crossings:
        for jump in (j for order in crossing.orders[:1] for j in order):
            n = len(jump.drift)
            off = np.abs(jump.states.toarray() - np.eye(n)).max(initial=0.0)
            off = max(off, np.abs(jump.parameters.toarray()).max(initial=0.0))
            for function in (run.system.rhs, steps.integrated):
                rates = [
                    np.asarray(function(x, run.theta, crossing.t, m)).ravel()
                    for x, m in (jump.before, jump.after)
                ]
                size = 1.0 + np.abs(rates[0]).max(initial=0.0)
                off = max(off, np.abs(rates[0] - rates[1]).max(initial=0.0) / size)
            if off > 1e-9:
                raise SolverError(
                    f"{run.system.name}: at t = {crossing.t:.9g} s {', '.join(jump.names)} changes "
                    "(see run.events), and rates jump; second derivatives are only formed for runs "
                    "without such events. End the run before, or take differences of "
                    "lumped.gradient.",
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
