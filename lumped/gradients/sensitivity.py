"""Derivatives of a run by parameters and start values, exact across events."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Any, Literal, NamedTuple, Unpack

import numpy as np

from lumped.compiler.system import Changes, Name, System
from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.functionals import Functional
from lumped.functionals.functional import readings_of
from lumped.gradients.forward import Followed, Forward, coincide
from lumped.gradients.functional_values import Summed, check, refuse
from lumped.gradients.legs import legs_of
from lumped.gradients.readings.chained import Chained, differ
from lumped.gradients.steps import steps_of
from lumped.gradients.touches import refuse_touches
from lumped.gradients.varied import (
    END,
    slopes_at_start,
    sources,
    tightened,
    varied_name,
    varied_values,
)
from lumped.plots.draw import Backend, draw
from lumped.plots.numbers import tornado
from lumped.points.start import run_start
from lumped.simulation.simulate import recorder, run_on
from lumped.support.arguments import checked
from lumped.support.display_units import display
from lumped.support.ranking import ranked
from lumped.support.rich_html import RichHtml
from lumped.support.text_table import number, table
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunOptions, run_plan

__all__ = ["MovedInstant", "Sensitivity", "Varied", "sensitivity"]

_GRID = 1000
"""Intervals of a run without states, which has no steps."""

Side = Literal["both", "right", "left"]


class MovedInstant(NamedTuple):
    """An instant at which the run stopped, s, its derivatives, shape (len(by),), what changes."""

    time: float
    slopes: np.ndarray
    components: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Sensitivity(RichHtml):
    """Derivatives over the times of a run; ``found["b.w", "shaft.c"]`` gives one of them.

    Attributes
    ----------
    run : Trajectory
        The run itself.
    of, to : tuple of str
        What is differentiated, and by what.
    derivatives : ndarray, shape (len(run.t), len(of), len(by))
        The derivatives.
    instants : tuple of MovedInstant
        Each instant at which the run stopped, its derivatives, and the components that change.
    shared : tuple of float
        Instants at which statically indeterminate constraints let go, s. Derivatives hold the
        shares of what each carries fixed there, and are not exact if these depend on what varies.
    evaluations : int
        Evaluations of the right-hand side with its derivatives, after the run.
    rtol : float
        Accuracy asked for.
    functionals : tuple of str
        Functionals, as printed.
    values : ndarray, shape (len(functionals),)
        What they are.
    slopes : ndarray, shape (len(functionals), len(by))
        Their derivatives.
    units : tuple of str
        Units of the functionals.
    """

    run: Trajectory
    of: tuple[str, ...]
    by: tuple[str, ...]
    derivatives: np.ndarray
    instants: tuple[MovedInstant, ...]
    shared: tuple[float, ...]
    evaluations: int
    rtol: float
    functionals: tuple[str, ...] = ()
    values: np.ndarray = field(default_factory=lambda: np.zeros(0))
    slopes: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    units: tuple[str, ...] = ()

    @checked
    def __getitem__(self, pair: tuple[Name | Functional, Name]) -> np.ndarray | float:
        by, functional = varied_name(self.run.system, pair[1]), str(pair[0])
        if functional in self.functionals and by in self.by:
            row = self.functionals.index(functional)
            return float(self.slopes[row, self.by.index(by)])
        of = self.run.system.key(pair[0])  # type: ignore[arg-type]
        places = [self._place(key, known) for key, known in ((of, self.of), (by, self.by))]
        found: np.ndarray = self.derivatives[:, places[0], places[1]]
        return found

    def _place(self, key: str, known: tuple[str, ...]) -> int:
        if key not in known:
            raise UnknownNameError(f"'{key}' is not in this sensitivity. {nearest(key, known)}")
        return known.index(key)

    @checked
    def ranked(self, of: Name, *, at: float | None = None) -> list[tuple[str, float]]:
        """Names and relative sensitivities ``p/y dy/dp`` of a quantity, the largest first.

        Parameters
        ----------
        of : name
            The quantity.
        at : float, optional
            Instant, s; the output time next to it is taken. Default is the end.

        Raises
        ------
        OptionError
            If the quantity is zero there, to which nothing is relative, or the instant is not
            within the run.
        UnknownNameError
            If the quantity was not differentiated.
        """
        name, t = self.run.system.key(of), self.run.t
        place = self._place(name, self.of)
        if at is not None:
            self.run.check_instant(at)
        k = len(t) - 1 if at is None else int(np.abs(t - at).argmin())
        value = float(self.run[name][k])
        slopes = self.derivatives[k, place]
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = slopes * varied_values(self.run, self.by) / value
        return ranked(f"{name} at t = {self.run.t[k]:g} s", value, self.by, relative)

    @checked
    def plot(
        self,
        of: Name | None = None,
        *,
        at: float | None = None,
        backend: Backend = "matplotlib",
        ax: Any = None,
    ) -> Any:
        """Tornado of what matters most to a quantity.

        Parameters
        ----------
        of : name, optional
            The quantity; default is the first.
        at : float, optional
            Instant, s; default is the end.
        backend, ax
            As in `lumped.Trajectory.plot`.
        """
        name = self.of[0] if of is None else self.run.system.key(of)
        time = self.run.t[-1] if at is None else at
        title = f"{self.run.system.name}: {name} at t = {time:g} s"
        return draw(tornado(self.ranked(name, at=at), title, name), backend, ax)

    def __repr__(self) -> str:
        s, rows = self.run.statistics, []
        for i, name in enumerate(self.of[:12]):
            last = float(self.run[name][-1])
            text = "zero: nothing is relative to it"
            if last:
                text = "; ".join(f"{n} {v:+.4f}" for n, v in self.ranked(name)[:4] if v)
            to_show = display(name, self.run.system.quantity(name).unit)
            largest = to_show.factor * float(np.abs(self.derivatives[:, i]).max(initial=0.0))
            told = number(to_show.value(last), 9), to_show.unit, number(largest), text
            rows.append((name, *told))
        head = (
            f"{self.run.system.name}: derivatives of {len(self.of)} quantities by {len(self.by)} "
            f"parameters and start values over {self.run.t[-1]:g} s; run of {s.steps} steps "
            f"({s.method}), {s.evaluations} evaluations, derivatives {self.evaluations} more, "
            f"rtol {self.rtol:.0e}, {len(self.instants)} instants of change crossed"
        )
        if self.shared:
            head += "\nshares of indeterminate constraints held fixed where they let go, t = "
            head += ", ".join(f"{t:.6g} s" for t in self.shared[:6])
        columns = ("quantity", "at the end", "unit", "largest derivative", "relative at the end")
        text = f"{head}\n" + (table(columns, rows) if rows else "")
        if self.functionals:
            sums = []
            for label, unit, value, slopes in zip(
                self.functionals, self.units, self.values, self.slopes, strict=True
            ):
                to_show = display(label, unit)
                shares = (number(to_show.factor * float(v)) for v in slopes[:6])
                total = number(to_show.value(float(value)), 9)
                sums.append((label, total, to_show.unit, *shares))
            text += "\n" * bool(rows) + table(("functional", "value", "unit", *self.by[:6]), sums)
        return text


@checked
def sensitivity(
    system: System,
    *,
    of: Iterable[Name | Functional],
    by: Iterable[Name],
    until: float | str,
    grid: int | None = 500,
    rtol: float = 1e-6,
    side: Side = "both",
    **options: Unpack[RunOptions],
) -> Sensitivity:
    """Derivatives of quantities and functionals by parameters and start values along a run.

    The forward sensitivity equations ``der(S) == f_x S + f_p`` are integrated beside the states,
    under the same error control. Where the run stops at an instant ``t(p)``, ``S`` jumps by
    ``g_x S + g_p + (g_x f_before + g_t - f_after) t_p`` less ``S`` (the saltation matrix; Leine and
    Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7), with ``g``
    the change of the states there, if a `when` makes one.

    Parameters
    ----------
    system : System
        From `assemble`.
    of : iterable of names and functionals
        Quantities, and numbers from `lumped.functionals`.
    by : iterable of names
        Parameters, given start values (of instances, or in `start`), and states, which stand for
        their start values; ``"until"`` is the end of the run, which moves functionals.
    until, grid
        As for `simulate`; `grid` is a number of intervals, or None. Derivatives are given at the
        times of the run.
    rtol : float
        Accuracy asked for, relative to the terms of which a derivative consists. Run and
        derivatives are integrated at three thousandths of it.
    side : {"both", "right", "left"}
        Derivatives for parameters that grow (right) or shrink (left), where these differ: where
        different changes coincide, extremes are equally high, or a change falls on the very
        instant that is looked at. By default both must agree.
    **options : RunOptions
        Of the run (see `RunOptions`).

    Returns
    -------
    Sensitivity

    Raises
    ------
    OptionError
        If `of` or `by` is empty, a name in `by` is nothing that can be varied, or `grid` is no
        number.
    SolverError
        If derivatives to both sides differ, a border is touched without being crossed, several
        changes follow each other at one instant, or states change places: where the run has no
        derivative, or none that is followed.
    """
    if not (grid is None or isinstance(grid, int)):
        raise OptionError(
            f"sensitivity: grid = {grid!r}: a number of intervals is needed, or None for the steps "
            "of the solver."
        )
    if side not in ("both", "right", "left"):
        raise OptionError(f"sensitivity: side = {side!r}: choose 'both', 'right' or 'left'.")
    wanted = tuple(of)
    functionals = [f for f in wanted if isinstance(f, Functional)]
    names = tuple(name for name in wanted if not isinstance(name, Functional))
    fine = tightened(rtol)
    plan = run_plan(until, rtol, options).by_steps("sensitivity", are_followed=True).at(fine)
    system = plan.watching(system, functionals)
    varied = Varied(system, names, tuple(by), plan.start, fine, bool(functionals))
    if functionals:
        check(system, functionals, varied.by, "sensitivity")

    def run(grid: int | None) -> Trajectory:
        point = run_start(system, plan)
        return run_on(point, plan, recorder(point, plan, grid))

    every = None if system.structure.states else _GRID
    steps = run(every) if functionals or system.switching else None
    found = None
    if names:
        if steps is not None and not functionals:
            refuse_touches(steps, legs_of(steps), steps_of(system, ()), fine, True)
        found = varied.go(steps if steps is not None and grid == every else run(grid), side)
    if not functionals:
        assert found is not None
        return replace(found, rtol=rtol)
    assert steps is not None
    return replace(varied.sum_up(steps, functionals, side, found), rtol=rtol)


class Varied:
    """Derivatives of runs that differ in their parameters only; arguments as for `sensitivity`."""

    def __init__(
        self,
        system: System,
        of: tuple[Name, ...],
        by: tuple[Name, ...],
        start: Changes | OperatingPoint | None,
        rtol: float,
        functionals: bool = False,
    ) -> None:
        if not (of or functionals) or not by:
            raise OptionError("sensitivity: name at least one quantity in `of` and one in `by`.")
        self.system, self.rtol = system, rtol
        self.of = tuple(system.key(name) for name in of)
        self.by = tuple(varied_name(system, name) for name in by)
        own = [name for name in self.by if name != END]
        self.inner = [i for i, name in enumerate(self.by) if name != END]
        self.n, self.k = len(system.state_names), len(own)
        self.given = start
        self.places, self.varied = sources(system, own, start)
        # each column is scaled by the size of what it is differentiated by
        defaults = system.structure.parameters.defaults
        self.scale = np.array([abs(defaults[i]) if i >= 0 else 1.0 for i in self.places])
        self.scale[self.scale == 0] = 1.0
        self.seed = np.zeros((len(defaults), self.k))
        for column, place in enumerate(self.places):
            if place >= 0:
                self.seed[place, column] = self.scale[column]
        self.forward = Forward(steps_of(system, ()), self.seed, rtol)

    def go(self, run: Trajectory, side: Side = "both") -> Sensitivity:
        """Follow the derivatives along the pieces of a run."""
        forward = copy(self.forward)  # with a count of evaluations of its own
        begin = slopes_at_start(run, self.given, self.seed, self.varied)
        pieces = forward.pieces(run)
        crossings = forward.crossings(run, pieces)
        several = any(len(crossing.orders) > 1 for crossing in crossings)
        values: np.ndarray | None = None
        for sign in _signs(side, several):
            found = forward.follow(run, pieces, crossings, begin, sign)
            own = forward.along(run, found.states, self.of) / self.scale
            if values is not None and any(
                differ(a, b).any() for a, b in zip(values.T, own.T, strict=True)
            ):
                raise coincide(run, crossings)
            values = own
        assert values is not None
        shared = tuple(i.t for i in found.instants if i.shared)
        whole, instants, cost = self._whole(values), self._instants(found), forward.evaluations
        return Sensitivity(run, self.of, self.by, whole, instants, shared, cost, self.rtol)

    def sum_up(
        self,
        run: Trajectory,
        functionals: Sequence[Functional],
        side: Side,
        curves: Sensitivity | None,
    ) -> Sensitivity:
        """Derivatives of functionals, besides those over time."""
        summed = Summed.of(run, readings_of(functionals), self.rtol).integrated()
        chained = Chained(tuple(functionals), summed.values, self.rtol)
        steps, course = summed.course.steps, summed.course
        sizes = summed.sizes
        forward = Forward(steps, self.seed, self.rtol, sizes)
        begin = slopes_at_start(run, self.given, self.seed, self.varied)
        several = any(len(crossing.orders) > 1 for crossing in course.crossings)
        sides: list[np.ndarray] = []
        parted = several or summed.parted or chained.has_kinks
        for sign in _signs(side, parted):
            if not sides or several:
                found = forward.follow(run, summed.pieces, course.crossings, begin, sign)
            own_side = summed.forward(found, self.seed, sign) / self.scale
            sides.append(chained.slopes(own_side, sign)[0])
        absent = np.array([differ(a, b) for a, b in zip(sides[0], sides[-1], strict=True)])
        own = tuple(self.by[i] for i in self.inner)
        refuse(summed, chained, own, absent)
        slopes = self._whole(sides[0])
        ends = np.array([summed.owed[k].ways[0].by_end for k in range(len(summed.wanted))])
        for i in set(range(len(self.by))) - set(self.inner):
            slopes[:, i] = chained.slopes(ends[:, None])[0][:, 0]
        if curves is None:
            none = np.zeros((len(run.t), 0, len(self.by)))
            instants, shared = self._instants(found), summed.shared
            curves = Sensitivity(run, (), self.by, none, instants, shared, 0, self.rtol)
        cost = curves.evaluations + forward.evaluations
        return replace(
            curves,
            functionals=tuple(str(functional) for functional in functionals),
            values=chained.values,
            slopes=slopes,
            units=tuple(functional.unit(self.system) for functional in functionals),
            evaluations=cost,
        )

    def _instants(self, found: Followed) -> tuple[MovedInstant, ...]:
        return tuple(
            MovedInstant(i.t, self._whole(i.slopes / self.scale), i.components)
            for i in found.instants
        )

    def _whole(self, derivatives: np.ndarray) -> np.ndarray:
        """With a column for the end of the run, which moves nothing before it."""
        found = np.zeros((*derivatives.shape[:-1], len(self.by)))
        found[..., self.inner] = derivatives
        return found


def _signs(side: Side, several: bool) -> tuple[int, ...]:
    """Sides to which derivatives are followed."""
    if side == "both":
        return (1, -1) if several else (1,)
    return (1,) if side == "right" else (-1,)
