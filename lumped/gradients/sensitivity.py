"""Derivatives of a run by parameters and start values, exact across events."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import replace
from typing import Literal, Unpack

import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.functionals import Functional
from lumped.functionals.functional import readings_of
from lumped.gradients.forward import AGREE, Followed, Forward, coincide
from lumped.gradients.functional_values import Chained, RunReadings, check, differ, refuse
from lumped.gradients.legs import GRID, SmoothParts, legs_of, pieces_of, run_in_one
from lumped.gradients.sensitivity_result import MovedInstant, Sensitivity
from lumped.gradients.steps import steps_of
from lumped.gradients.touches import refuse_touches
from lumped.gradients.varied import (
    END,
    resolve_name,
    slopes_at_start,
    sources,
    tighten,
)
from lumped.points.start import run_start
from lumped.simulation.simulate import recorder
from lumped.support.arguments import checked
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory
from lumped.timeloop.run_options import RunOptions, run_plan

Side = Literal["both", "right", "left"]
_STILL = 1e-12
"""Derivative of an instant by the relative change of a parameter that is rounding."""


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
        instant that is looked at. By default both must agree; instants of change have both.
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
        changes follow each other at one instant: where the run has no derivative, or none that is
        followed.
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
    fine = tighten(rtol)
    plan = run_plan(until, rtol, options).by_steps("sensitivity", are_followed=True).at(fine)
    system = plan.watching(system, functionals)
    varied = Varied(system, names, tuple(by), plan.start, fine, bool(functionals))
    if functionals:
        check(system, functionals, varied.by, "sensitivity")

    def run(grid: int | None) -> Trajectory:
        point = run_start(system, plan)
        return run_in_one(point, plan, lambda begin: recorder(begin, plan, grid))

    every = None if system.structure.states else GRID
    steps = run(every) if functionals or system.switching else None
    found = None
    if names:
        if steps is not None and not functionals:
            own = steps_of(steps.system, ())
            refuse_touches(SmoothParts(steps, legs_of(steps), own, fine), True)
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
        self.by = tuple(resolve_name(system, name) for name in by)
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
        self._forwards: dict[System, Forward] = {}

    def _forward(self, system: System) -> Forward:
        """The equations of the derivatives; runs may be led by other states than was asked for."""
        if system not in self._forwards:
            self._forwards[system] = Forward(steps_of(system, ()), self.seed, self.rtol)
        return self._forwards[system]

    def go(self, run: Trajectory, side: Side = "both") -> Sensitivity:
        """Follow the derivatives along the pieces of a run."""
        forward = copy(self._forward(run.system))  # with a count of evaluations of its own
        begin = slopes_at_start(run, self.given, self.seed, self.varied)
        pieces, crossings = pieces_of(run), forward.crossings(run)
        several = any(len(crossing.orders) > 1 for crossing in crossings)
        values: np.ndarray | None = None
        sides = []
        for sign in _signs(side, several):
            found = forward.follow(run, pieces, crossings, begin, sign)
            sides.append(found)
            own = forward.along(run, found.states, self.of) / self.scale
            if values is not None and any(
                differ(a, b).any() for a, b in zip(values.T, own.T, strict=True)
            ):
                raise coincide(run, crossings)
            values = own
        assert values is not None
        shared = tuple(i.t for i in found.instants if i.shared)
        whole, instants, cost = self._whole(values), self._instants(sides), forward.evaluations
        return Sensitivity(run, self.of, self.by, whole, instants, shared, cost, self.rtol)

    def sum_up(
        self,
        run: Trajectory,
        functionals: Sequence[Functional],
        side: Side,
        curves: Sensitivity | None,
    ) -> Sensitivity:
        """Derivatives of functionals, besides those over time."""
        summed = RunReadings(run, readings_of(functionals), self.rtol)
        summed.integrate()
        chained = Chained(tuple(functionals), summed.values, self.rtol)
        crossings = summed.course.crossings
        forward = Forward(summed.course.steps, self.seed, self.rtol, summed.sizes)
        begin = slopes_at_start(run, self.given, self.seed, self.varied)
        several = any(len(crossing.orders) > 1 for crossing in crossings)
        sides: list[np.ndarray] = []
        followed = []
        parted = several or summed.parted or chained.has_kinks
        for sign in _signs(side, parted):
            if not sides or several:
                found = forward.follow(run, summed.pieces, crossings, begin, sign)
                followed.append(found)
            own_side = summed.forward(found, self.seed, sign) / self.scale
            sides.append(chained.slopes(own_side, sign)[0])
        absent = np.array([differ(a, b) for a, b in zip(sides[0], sides[-1], strict=True)])
        own = tuple(self.by[i] for i in self.inner)
        refuse(summed, chained, own, absent)
        slopes = self._whole(sides[0])
        ends = np.array([summed.terms[k].alternatives[0].by_end for k in range(len(summed.wanted))])
        for i in set(range(len(self.by))) - set(self.inner):
            slopes[:, i] = chained.slopes(ends[:, None])[0][:, 0]
        if curves is None:
            none = np.zeros((len(run.t), 0, len(self.by)))
            instants, shared = self._instants(followed), summed.shared
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

    def _instants(self, sides: list[Followed]) -> tuple[MovedInstant, ...]:
        found = []
        for one, other in zip(sides[0].instants, sides[-1].instants, strict=True):
            least = _STILL * max(1.0, abs(one.t)) + AGREE * np.abs(one.slopes).max(initial=0.0)
            differs = (np.abs(one.slopes - other.slopes) > least).any()
            whole, left = (self._whole(i.slopes / self.scale) for i in (one, other))
            found.append(MovedInstant(one.t, whole, one.components, left if differs else None))
        return tuple(found)

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
