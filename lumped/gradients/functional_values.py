"""Readings of one run: their values, and their derivatives from those of its states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.functionals import Functional
from lumped.functionals.functional import refuse_other
from lumped.functionals.readings import Integral, Reading
from lumped.gradients.adjoint import AdjointPoint, crossings_of
from lumped.gradients.forward import Followed
from lumped.gradients.legs import legs_of
from lumped.gradients.readings.chained import Chained
from lumped.gradients.readings.functional_terms import SmoothParts
from lumped.gradients.readings.ways import Owed, Way
from lumped.gradients.resolved_steps import Resolved, resolved
from lumped.gradients.steps import steps_of
from lumped.gradients.sweep import Seeds, Swept, placed
from lumped.gradients.touches import refuse_touches
from lumped.gradients.varied import END
from lumped.timeloop.results.trajectory import Piece, Trajectory

__all__ = ["END", "Summed", "check", "refuse"]


@dataclass(frozen=True, eq=False)
class Summed:
    """Readings of a run.

    Attributes
    ----------
    course : SmoothParts
        The run in its smooth parts, every instant that counts an end of a step.
    wanted : tuple of Reading
        What they are.
    owed : dict of int to Owed
        What each owes to single instants, by its number; those of integrals are known when they
        are resolved.
    integrals : tuple of int
        Which of them are integrals.
    seeds : Seeds
        Which integral each owes to, and over which part of the run.
    sizes : ndarray, shape (len(integrals),)
        Integrals of the sizes of what is integrated.
    """

    course: SmoothParts
    wanted: tuple[Reading, ...]
    owed: dict[int, Owed]
    integrals: tuple[int, ...]
    seeds: Seeds
    sizes: np.ndarray

    @classmethod
    def of(cls, run: Trajectory, wanted: Sequence[Reading], rtol: float) -> Summed:
        """Readings of a run that was recorded at the steps of the solver.

        Raises
        ------
        OptionError
            If one asks for what is not in the run.
        SolverError
            If the run, or one of them, has no derivative.
        """
        system, legs = run.system, legs_of(run)
        found = {k: f for k, f in enumerate(wanted) if isinstance(f, Integral)}
        integrals, keys = list(found), [tuple(map(system.key, f.factors)) for f in found.values()]
        steps = steps_of(system, tuple(keys))
        course = SmoothParts(run, legs, crossings_of(run, legs, rtol), steps, rtol)
        refuse_touches(run, legs, steps, rtol, any(course.ends(f) for f in wanted))
        for reading in wanted:
            course.cut(reading)
        until = course.until
        begin = float(legs[0].t[0])
        spans = np.array([f.between or (begin, until) for f in found.values()])
        spans = spans.reshape(-1, 2)
        owed = {k: course.owed(f) for k, f in enumerate(wanted) if k not in integrals}
        chosen = np.zeros((len(integrals), len(wanted)))
        chosen[np.arange(len(integrals)), integrals] = 1.0
        seeds, sizes = Seeds(chosen, spans), np.ones(len(integrals))
        return cls(course, tuple(wanted), owed, tuple(integrals), seeds, sizes)

    def integrated(self) -> Summed:
        """The same with its integrals."""
        seeds = Seeds(np.zeros((len(self.integrals), 0)), self.seeds.spans)
        return self._with(self._resolved(seeds, []))

    def _resolved(self, seeds: Seeds, points: list[AdjointPoint]) -> Resolved:
        c = self.course
        return resolved(c.run, c.legs, c.crossings, c.steps, seeds, points, c.rtol)

    def _with(self, found: Resolved) -> Summed:
        """The same with integrals that were found."""
        run, course, until = self.course.run, self.course, self.course.until
        owed = dict(self.owed)
        x, m = course.legs[-1].side(-1)
        rates = np.asarray(course.steps.integrated(x, run.theta, until, m)).ravel()
        for place, k in enumerate(self.integrals):
            reading = self.wanted[k]
            assert isinstance(reading, Integral)
            by_end = float(rates[place]) if reading.between is None else 0.0
            owed[k] = Owed((Way(float(found.sums[place]), (), by_end),))
        sizes = np.where(found.sizes > 0, found.sizes, 1.0)
        return replace(self, owed=owed, sizes=sizes)

    @property
    def values(self) -> np.ndarray:
        """What the readings are."""
        return np.array([self.owed[k].ways[0].value for k in range(len(self.wanted))])

    @property
    def shared(self) -> tuple[float, ...]:
        """Instants at which statically indeterminate constraints let go, s."""
        crossings = self.course.crossings
        return tuple(
            c.t for c in crossings if any(jump.shared for order in c.orders[:1] for jump in order)
        )

    @property
    def parted(self) -> bool:
        """Whether a reading can go several ways."""
        return any(len(owed.ways) > 1 for owed in self.owed.values())

    @property
    def by_end(self) -> np.ndarray:
        """Derivatives by the end of the run, one row for each way."""
        every = (self.owed[k] for k in range(len(self.wanted)))
        return np.array([way.by_end for owed in every for way in owed.ways])

    # -- backwards ---------------------------------------------------------------------------

    def swept(self) -> tuple[Summed, list[Swept], np.ndarray, list[slice], list[int | None]]:
        """Derivatives by states at the time zero and parameters, for all ways of all readings.

        Returns
        -------
        Summed
            The same with its integrals.
        list of Swept
            For all orders of changes that coincide.
        ndarray
            Errors of all ways, relative to the terms of which a derivative consists.
        list of slice
            Columns of the ways of each reading.
        list of int or None
            Column of the instant that decides between ways.
        """
        points: list[AdjointPoint] = []
        columns, guards, count = [], [], 0
        chosen = []
        for k in range(len(self.wanted)):
            owed = self.owed.get(k, Owed((Way(0.0),)))
            columns.append(slice(count, count + len(owed.ways)))
            for way in owed.ways:
                points += [replace(point, column=count) for point in way.points]
                chosen.append(self.seeds.chosen[:, k])
                count += 1
            guards.append(count if owed.guard else None)
            for point in owed.guard:
                points.append(replace(point, column=count))
                chosen.append(np.zeros(len(self.integrals)))
                count += 1
        whole = np.array(chosen).T.reshape(len(self.integrals), count)
        results = self._resolved(Seeds(whole, self.seeds.spans), points)
        return self._with(results), results.found, results.errors, columns, guards

    # -- forwards ----------------------------------------------------------------------------

    @property
    def pieces(self) -> list[Piece]:
        """The smooth parts, as a run has them."""
        system = self.course.run.system
        return [Piece(system, leg.t, leg.states(), leg.settings()) for leg in self.course.legs]

    def forward(self, found: Followed, seed: np.ndarray, side: int) -> np.ndarray:
        """Derivatives to one side from those of the states, shape (len(wanted), k)."""
        rows = []
        for k in range(len(self.wanted)):
            owed = self.owed[k]
            if k in self.integrals:
                rows.append(self._integral(found, self.integrals.index(k)))
                continue
            ways = np.array([self._points(found, seed, way.points) for way in owed.ways])
            rows.append(self._picked(owed, ways, found, seed, side))
        return np.array(rows)

    def _picked(
        self, owed: Owed, ways: np.ndarray, found: Followed, seed: np.ndarray, side: int
    ) -> np.ndarray:
        """The way that a reading goes to one side."""
        if owed.pick in ("greatest", "least"):
            upward = (owed.pick == "greatest") == (side > 0)
            chosen: np.ndarray = ways.max(axis=0) if upward else ways.min(axis=0)
            return chosen
        if owed.pick == "later":
            moved = side * self._points(found, seed, owed.guard)
            later = moved > 1e-12 * np.abs(moved).max(initial=0.0)
            picked: np.ndarray = np.where(later, ways[1], ways[0])
            return picked
        first: np.ndarray = ways[0]
        return first

    def _integral(self, found: Followed, place: int) -> np.ndarray:
        """Derivatives of one integral."""
        begin, end = self.seeds.spans[place]
        total = np.zeros(found.integrals[0].shape[2])
        for number, (leg, Q) in enumerate(zip(self.course.legs, found.integrals, strict=True)):
            if number and begin < leg.t[0] < end:
                total = total + found.jumps[number - 1][place]
            if leg.t[-1] <= begin or leg.t[0] >= end:
                continue
            ends = (
                int(np.searchsorted(leg.t, min(max(t, leg.t[0]), leg.t[-1]))) for t in (begin, end)
            )
            first, last = ends
            total = total + Q[last, place] - Q[first, place]
        return total

    def _points(
        self, found: Followed, seed: np.ndarray, points: Sequence[AdjointPoint]
    ) -> np.ndarray:
        """What a reading owes to several instants."""
        total = np.zeros(seed.shape[1])
        for point in points:
            total = total + self._point(found, seed, point)
        return total

    def _point(self, found: Followed, seed: np.ndarray, point: AdjointPoint) -> np.ndarray:
        """What a reading owes to one instant."""
        leg = self.course.legs[point.leg]
        S = found.states[point.leg][int(np.searchsorted(leg.t, point.time))]
        total: np.ndarray = point.by_states @ S + point.by_parameters @ seed
        if point.edge:
            order = self.course.crossings[point.edge - 1].orders[0]
            own = [i for i in found.instants if i.number == point.edge]
            total = total + point.late * own[placed(point, point.edge, order)].slopes
        return total


def check(system: System, wanted: Sequence[Functional], names: Sequence[str], what: str) -> None:
    """Refuse what makes no sense before a run.

    Raises
    ------
    OptionError
        If there is no functional, or nothing to vary.
    UnknownNameError
        If a quantity does not exist.
    """
    if not wanted:
        raise OptionError(
            f"{what}: name at least one functional in `of`, such as "
            "lumped.functionals.peak('shaft.tau')."
        )
    if not names:
        raise OptionError(
            f"{system.name}: nothing to vary; name parameters or start values in `by`."
        )
    for functional in wanted:
        refuse_other([functional], "run", what)
        for reading in functional.readings:
            if not reading.smooth:
                raise OptionError(f"{what}: {reading} jumps and has no derivative.")
        system.function(functional.names)


def refuse(summed: Summed, chained: Chained, names: Sequence[str], absent: np.ndarray) -> None:
    """Refuse derivatives that do not exist, by name.

    Parameters
    ----------
    absent : ndarray of bool, shape (functionals, len(names))
        Which do not.

    Raises
    ------
    SolverError
        If there is one.
    """
    if not absent.any():
        return
    lines = []
    for k, functional in enumerate(chained.functionals):
        by = [name for name, none in zip(names, absent[k], strict=True) if none]
        if by:
            counting = chained.counting(k)
            owed = [summed.owed[place] for place in counting]
            where = [each.where for each in owed if len(each.ways) > 1]
            if len(chained.branches[k]) > 1:
                read = (
                    f"{summed.wanted[i]} = {chained.read[i]:.6g} {summed.owed[i].where}".rstrip()
                    for i in counting
                )
                where.append(f"a kink at {', '.join(read)}")
            why = f" ({'; '.join(where)})" if where else ""
            lines.append(f"{functional} by {', '.join(by)}" + why)
    several = [c for c in summed.course.crossings if len(c.orders) > 1]
    text = "; ".join(f"t = {c.t:.9g} s ({', '.join(c.names)})" for c in several)
    why = f" Different changes coincide at {text}; which comes first depends on these." * bool(text)
    raise SolverError(
        f"{summed.course.run.system.name}: derivatives to both sides differ, so there is none: "
        f"{'; '.join(lines)}.{why} All others exist: leave these out of `by` or `of`, or ask "
        "lumped.sensitivity for one side.",
        summed.course.run,
    )
