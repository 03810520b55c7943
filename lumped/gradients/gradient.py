"""Gradients of numbers that sum up a run, by many parameters at once."""

from __future__ import annotations

import itertools
import time as clock
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import SolverError
from lumped.functionals import Functional
from lumped.functionals.functional import readings_of
from lumped.gradients.functional_values import Chained, RunReadings, check, differ, refuse
from lumped.gradients.legs import record_run
from lumped.gradients.spans import Carried
from lumped.gradients.varied import (
    END,
    describe_shared,
    read_varied_values,
    resolve_name,
    slopes_at_start,
    sources,
    tighten,
)
from lumped.plots.draw import Canvas, draw
from lumped.plots.numbers import tornado
from lumped.support.arguments import checked
from lumped.support.by_name import ByName, find_place
from lumped.support.display_units import Units, choose_units
from lumped.support.ranking import list_largest, rank_by_size
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import amounts, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunOptions, RunPlan, run_plan

_COLUMNS = 500
"""Derivatives of start states that are computed at once."""


@dataclass(frozen=True, eq=False)
class Gradient(ByName, RichHtml):
    """Values of functionals and their derivatives; ``found["rms(shaft.tau)", "a.J"]`` is one.

    Attributes
    ----------
    run : Trajectory
        The run, at the steps of the solver; at every second, fourth and so on of them where its
        states would take more than 50 MB.
    of : tuple of str
        Functionals, as printed.
    by : tuple of str
        Parameters and start values.
    values : ndarray, shape (len(of),)
        What the functionals are.
    units : tuple of str
        Units of these.
    derivatives : ndarray, shape (len(of), len(by))
        Their derivatives.
    errors : ndarray, shape (len(of),)
        Errors that the steps add to these, estimated, relative to the terms of which a derivative
        consists. Where they would be above a tenth of `rtol`, steps are divided.
    shared : tuple of float
        Instants at which statically indeterminate constraints let go, s. Derivatives hold the
        shares of what each carries fixed there, and are not exact if these depend on what varies.
    seconds : float
        Wall time of everything after the run.
    rtol : float
        Accuracy asked for; the run is made at three thousandths of it.
    """

    run: Trajectory
    of: tuple[str, ...]
    by: tuple[str, ...]
    values: np.ndarray
    units: tuple[str, ...]
    derivatives: np.ndarray
    errors: np.ndarray
    shared: tuple[float, ...]
    seconds: float
    rtol: float

    @checked
    def __getitem__(self, pair: tuple[str, Name]) -> float:
        of, by = pair
        column = find_place(resolve_name(self.run.system, by), self.by, "was not varied")
        return float(self.derivatives[self._row(of), column])

    @property
    def relative(self) -> np.ndarray:
        """Relative change of each functional for each relative change, ``p/y dy/dp``."""
        varied = read_varied_values(self.run, self.by)
        with np.errstate(divide="ignore", invalid="ignore"):
            found: np.ndarray = self.derivatives * varied / self.values[:, None]
        return found

    @checked
    def ranked(self, of: str) -> list[tuple[str, float]]:
        """Names and relative sensitivities of a functional, the largest first.

        Raises
        ------
        OptionError
            If its value is zero, to which nothing is relative.
        UnknownNameError
            If it was not differentiated.
        """
        row = self._row(of)
        changes = self.derivatives[row] * read_varied_values(self.run, self.by)
        return rank_by_size(of, self.values[row], self.by, changes)

    @checked
    def plot(self, of: str | None = None, *, units: Units = None, **canvas: Unpack[Canvas]) -> Any:
        """Tornado of the parameters that matter most.

        Parameters
        ----------
        of : str, optional
            The functional; default is the first.
        units : mapping of str to str or str, optional
            Units to show, see `lumped.display_units`; default is what the session shows.
        backend, ax
            What draws, and where (see `lumped.Trajectory.plot`).

        Raises
        ------
        UnitError
            If a unit does not fit.
        UnknownNameError
            If a name does not exist.
        """
        row = 0 if of is None else self._row(of)
        label = self.of[row]
        shown = amounts(
            *(label, self.units[row], self.values[row]),
            digits=4,
            units=choose_units(units, self.of),
        )
        title = f"{self.run.system.name}: {label} = {' '.join(shown)}"
        return draw(tornado(self.ranked(label), title, label), **canvas)

    def _names(self) -> list[tuple[str, str]]:
        return [*itertools.product(self.of, self.by)]

    def _row(self, of: str) -> int:
        return find_place(of, self.of, "was not differentiated")

    def __repr__(self) -> str:
        rows = []
        for label, value, unit in zip(self.of, self.values, self.units, strict=True):
            text = "zero: nothing is relative to it"
            if value:
                text = list_largest((n, v) for n, v in self.ranked(label) if v)
            rows.append((label, *amounts(label, unit, value, digits=9), text))
        s = self.run.statistics
        head = (
            f"{self.run.system.name}: {len(self.of)} functionals by {len(self.by)} parameters and "
            f"start values, relative; run of {s.steps} steps ({s.method}), {s.evaluations} "
            f"evaluations, rtol {self.rtol:.0e}, in {s.seconds:.3g} s; its gradient in "
            f"{self.seconds:.3g} s more, error {self.errors.max(initial=0.0):.0e}"
        )
        head += describe_shared(self.shared)
        return f"{head}\n" + table(("functional", "value", "unit", "largest"), rows)


@checked
def gradient(
    system: System,
    *,
    of: Iterable[Functional],
    by: Iterable[Name] | None = None,
    until: float | str,
    rtol: float = 1e-6,
    **options: Unpack[RunOptions],
) -> Gradient:
    """Simulate, and differentiate functionals of the run by parameters and start values.

    The cost hardly depends on the number of parameters: one run, and one sweep backwards over its
    steps for all functionals together (the discrete adjoint), across events by the transposed
    saltation matrix. `sensitivity` gives derivatives over time, at a cost for each parameter.

    States take at most 200 MB, however long the run is: of long runs some are kept, and the steps
    between are made again, with the same bits, part after part of the sweep. Of each step remain
    its time and its errors. Where a linkage is closed by iteration, all states are kept.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : iterable of functionals
        From `lumped.functionals`.
    by : iterable of names, optional
        Parameters, given start values, and states, which stand for their start values; default
        is all parameters that can be changed.
    until : float or str
        End of the run, s.
    rtol : float
        Accuracy asked for, relative to the terms of which a derivative consists. The run is made
        at three thousandths of it.
    **options : RunOptions
        Of the run (see `RunOptions`).

    Returns
    -------
    Gradient

    Raises
    ------
    OptionError
        If there is no functional or nothing to vary, a functional asks for an event that does not
        happen, or none of what is varied changes it.
    UnknownNameError
        If a quantity or parameter does not exist.
    SolverError
        Where the run has no derivative (see `sensitivity`), or one is not finite.
    """
    return gradient_of(system, of, by, run_plan(until, rtol, options))


def gradient_of(
    system: System, of: Iterable[Functional], by: Iterable[Name] | None, plan: RunPlan
) -> Gradient:
    """The gradient of a run with options that were checked (see `gradient`)."""
    wanted, rtol = tuple(of), plan.rtol
    plan = plan.by_steps("gradient", are_followed=True).at(tighten(rtol))
    free = system.structure.parameters.free_names
    names = [*free] if by is None else [resolve_name(system, name) for name in by]
    check(system, wanted, names, "gradient")
    system = plan.watching(system, wanted)
    own = [name for name in names if name != END]
    places, varied = sources(system, own, plan.start)
    run = record_run(system, plan)
    begin = clock.perf_counter()
    read = readings_of(wanted)
    summed = RunReadings(run, read, tighten(rtol), joins=True)
    swept, columns, guards = summed.sweep_back()
    found = [_chain_derivatives(run, plan.start, places, varied, order) for order in swept.found]
    errors = np.array([swept.errors[column].max(initial=0.0) for column in columns])
    slopes = np.zeros((len(read), len(names)))
    absent = np.zeros(slopes.shape, dtype=bool)
    is_end = np.array(names) == END
    for k, (column, guard) in enumerate(zip(columns, guards, strict=True)):
        ends = np.array([each.by_end for each in summed.terms[k].alternatives])
        slopes[k, is_end], absent[k, is_end] = ends[0], differ(ends[:1], ends).any()
        if column.start == column.stop:
            continue
        alternatives = np.concatenate([each[column] for each in found])
        apart = np.any([differ(alternatives[0], other) for other in alternatives], axis=0)
        if guard is not None:
            moves = np.array([np.abs(each[guard]) for each in found]).max(axis=0)
            apart &= moves > 1e-12 * moves.max(initial=0.0)
        slopes[k, ~is_end], absent[k, ~is_end] = alternatives[0], apart
    chained = Chained(wanted, summed.values, tighten(rtol))
    derivatives, kinked = chained.slopes(slopes)
    labels = tuple(str(functional) for functional in wanted)
    _check_found(system, labels, names, derivatives)
    refuse(summed, chained, names, chained.find_lost(absent) | kinked)
    seconds = clock.perf_counter() - begin
    units = tuple(functional.unit(system) for functional in wanted)
    return Gradient(
        run,
        labels,
        tuple(names),
        chained.values,
        units,
        derivatives,
        np.array([errors[chained.counting(k)].max(initial=0.0) for k in range(len(wanted))]),
        summed.shared,
        seconds,
        rtol,
    )


def _chain_derivatives(
    run: Trajectory,
    start: Changes | OperatingPoint | None,
    places: list[int],
    varied: dict[int, np.ndarray],
    carried: Carried,
) -> np.ndarray:
    """Derivatives by what is varied, through states at the time zero and directly."""
    by_states, by_parameters = carried.adjoint, carried.by_parameters
    found, which = np.zeros((by_states.shape[1], len(places))), np.array(places, dtype=int)
    for begin in range(0, len(places), _COLUMNS):
        own = slice(begin, begin + _COLUMNS)
        seed = np.zeros((len(by_parameters), len(which[own])))
        columns = np.flatnonzero(which[own] >= 0)
        seed[which[own][columns], columns] = 1.0
        units = {unknown: unit[own] for unknown, unit in varied.items()}
        S = slopes_at_start(run, start, seed, units)
        found[:, own] = by_states[: len(S)].T @ S
    # no product: what has no derivative by one parameter may have one by others
    columns = np.flatnonzero(which >= 0)
    found[:, columns] += by_parameters[which[columns]].T
    return found


def _check_found(
    system: System, labels: Sequence[str], names: Sequence[str], found: np.ndarray
) -> None:
    if not np.isfinite(found).all():
        row, column = np.argwhere(~np.isfinite(found))[0]
        raise SolverError(
            f"{system.name}: the derivative of {labels[row]} by {names[column]} is not finite. "
            "Change this value, or leave it out of `by`."
        )
