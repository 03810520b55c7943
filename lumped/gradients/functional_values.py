"""Readings of one run: their values, and their derivatives from those of its states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.functionals import Functional
from lumped.functionals.functional import Branch, readings_of, refuse_other
from lumped.functionals.readings import Integral, Reading
from lumped.gradients.forward import Followed
from lumped.gradients.joined_pieces import join_pieces
from lumped.gradients.legs import Leg, SmoothParts, pieces_of
from lumped.gradients.readings.functional_terms import ReadParts
from lumped.gradients.readings.instant_terms import AdjointPoint, InstantTerms, ReadingTerms
from lumped.gradients.saltation import crossings_of
from lumped.gradients.steps import steps_of
from lumped.gradients.sweep import Resolved, Seeds, refine_sweep
from lumped.gradients.touches import refuse_touches
from lumped.timeloop.results.trajectory import Piece, Trajectory

_AGREE = 1e-5
"""Relative difference up to which derivatives to both sides are the same."""


@dataclass(frozen=True)
class Chained:
    """Functionals of which the readings are known.

    Attributes
    ----------
    functionals : tuple of Functional
        All of them.
    read : ndarray, shape (n,)
        Values of their readings (see `readings_of`).
    rtol : float
        Relative accuracy of these.
    """

    functionals: tuple[Functional, ...]
    read: np.ndarray
    rtol: float

    @cached_property
    def places(self) -> list[list[int]]:
        """Places of the readings of each functional."""
        numbers = {reading: i for i, reading in enumerate(readings_of(self.functionals))}
        return [[numbers[reading] for reading in f.readings] for f in self.functionals]

    @cached_property
    def values(self) -> np.ndarray:
        """Values of the functionals."""
        pairs = zip(self.functionals, self.places, strict=True)
        return np.array([f.value(self.read[None, own])[0] for f, own in pairs])

    @cached_property
    def branches(self) -> list[list[Branch]]:
        """Derivatives of each by its readings, on all sides of its kinks."""
        pairs = zip(self.functionals, self.places, strict=True)
        return [f.branches(self.read[own], self.rtol) for f, own in pairs]

    @property
    def has_kinks(self) -> bool:
        """Whether one stands at a kink."""
        return any(len(branches) > 1 for branches in self.branches)

    def counting(self, k: int) -> list[int]:
        """Readings by which a functional changes."""
        slopes = np.abs([branch.slopes for branch in self.branches[k]]).max(axis=0)
        return [place for place, slope in zip(self.places[k], slopes, strict=True) if slope]

    def slopes(self, by: np.ndarray, side: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Derivatives of the functionals, and which are none, shapes (len(functionals), m).

        Parameters
        ----------
        by : ndarray, shape (n, m)
            Derivatives of the readings.
        side : {0, 1, -1}
            To which side; 0 for both, which may differ at kinks.
        """
        found = np.zeros((len(self.functionals), by.shape[1]))
        absent = np.zeros(found.shape, dtype=bool)
        for k, (branches, own) in enumerate(zip(self.branches, self.places, strict=True)):
            rates = by[own]
            sides = [_through(branch, rates) for branch in branches]
            found[k] = sides[0]
            for branch, other in zip(branches[1:], sides[1:], strict=True):
                if side:
                    found[k] = np.where(branch.lies(side * rates), other, found[k])
                else:
                    absent[k] |= differ(sides[0], other)
        return found, absent

    def find_lost(self, absent: np.ndarray) -> np.ndarray:
        """Which derivatives are none because those of readings are none, as `slopes`."""
        rows = [absent[self.counting(k)].any(axis=0) for k in range(len(self.functionals))]
        return np.array(rows, dtype=bool).reshape(len(rows), absent.shape[1])


def _through(branch: Branch, rates: np.ndarray) -> np.ndarray:
    """Derivatives on one side of kinks; readings without influence need have none."""
    counts = branch.slopes != 0
    found: np.ndarray = branch.slopes[counts] @ rates[counts]
    return found


def differ(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Where derivatives to both sides are different; never where they are not finite."""
    finite = np.isfinite(one) & np.isfinite(other)
    one, other = np.where(finite, one, 0.0), np.where(finite, other, 0.0)
    size = np.maximum(np.abs(one), np.abs(other))
    least = 1e-9 * size.max(initial=0.0)
    found: np.ndarray = np.abs(one - other) > _AGREE * size + least
    return found


class RunReadings:
    """Readings of a run.

    Parameters
    ----------
    run : Trajectory
        Recorded at the steps of the solver.
    wanted : sequence of Reading
        What they are.
    rtol : float
        Accuracy of the run.
    joins : bool
        Smooth parts go on over points of tables; only for derivatives backwards.

    Attributes
    ----------
    course : ReadParts
        The run in its smooth parts, every instant that counts an end of a step.
    terms : dict of int to ReadingTerms
        Values and terms at single instants, by the number of the reading; those of integrals are
        known when they are resolved.
    integrals : list of int
        Which of them are integrals.
    spans : ndarray, shape (len(integrals), 2)
        Begin and end of these, s.
    sizes : ndarray, shape (len(integrals),)
        Integrals of the sizes of what is integrated.

    Raises
    ------
    OptionError
        If one asks for what is not in the run.
    SolverError
        If the run, or one of them, has no derivative.
    """

    def __init__(
        self, run: Trajectory, wanted: Sequence[Reading], rtol: float, *, joins: bool = False
    ) -> None:
        system, pieces = run.system, pieces_of(run)
        legs = [Leg(run, p) for p in (join_pieces(run, pieces, wanted) if joins else pieces)]
        integrals = {k: f for k, f in enumerate(wanted) if isinstance(f, Integral)}
        products = tuple(tuple(map(system.key, f.factors)) for f in integrals.values())
        parts = SmoothParts(run, legs, steps_of(system, products), rtol)
        crossings = crossings_of(parts)
        course = ReadParts(run, legs, parts.steps, rtol, crossings, parts.whole)
        refuse_touches(course, any(course.ends(f) for f in wanted))
        for reading in wanted:
            course.cut(reading)
        self.course, self.wanted, self.integrals = course, tuple(wanted), list(integrals)
        whole = float(legs[0].t[0]), course.until
        spans = np.array([f.between or whole for f in integrals.values()])
        self.spans, self.sizes = spans.reshape(-1, 2), np.ones(len(integrals))
        self.terms = {k: course.find_terms(f) for k, f in enumerate(wanted) if k not in integrals}

    def integrate(self) -> None:
        """Find the integrals."""
        self._resolve(np.zeros((len(self.integrals), 0)), [])

    def _resolve(self, chosen: np.ndarray, points: list[AdjointPoint]) -> Resolved:
        """Derivatives of results by integrals and at points, and with them the integrals."""
        course = self.course
        found = refine_sweep(course, Seeds(chosen, self.spans), points)
        x, m = course.legs[-1].side(-1)
        rates = np.asarray(course.steps.integrated(x, course.run.theta, course.until, m)).ravel()
        for place, k in enumerate(self.integrals):
            reading = self.wanted[k]
            assert isinstance(reading, Integral)
            by_end = float(rates[place]) if reading.between is None else 0.0
            self.terms[k] = ReadingTerms((InstantTerms(float(found.sums[place]), (), by_end),))
        self.sizes = np.where(found.sizes > 0, found.sizes, 1.0)
        return found

    @property
    def values(self) -> np.ndarray:
        """What the readings are."""
        return np.array([self.terms[k].alternatives[0].value for k in range(len(self.wanted))])

    @property
    def shared(self) -> tuple[float, ...]:
        """Instants at which statically indeterminate constraints let go, s."""
        crossings = self.course.crossings
        return tuple(
            c.t for c in crossings if any(jump.shared for order in c.orders[:1] for jump in order)
        )

    @property
    def parted(self) -> bool:
        """Whether the derivative of a reading has alternatives."""
        return any(len(terms.alternatives) > 1 for terms in self.terms.values())

    # -- backwards ---------------------------------------------------------------------------

    def sweep_back(self) -> tuple[Resolved, list[slice], list[int | None]]:
        """Derivatives by states at the time zero and parameters, for all alternatives.

        Returns
        -------
        Resolved
            With a column for each alternative.
        list of slice
            Columns of the alternatives of each reading; none of what states do not change.
        list of int or None
            Column of the instant that decides between alternatives.
        """
        points: list[AdjointPoint] = []
        chosen: list[np.ndarray] = []
        columns, guards = [], []
        for k in range(len(self.wanted)):
            terms = self.terms.get(k, ReadingTerms((InstantTerms(0.0),)))
            is_fixed = k not in self.integrals and not any(o.points for o in terms.alternatives)
            alternatives = () if is_fixed else terms.alternatives
            columns.append(slice(len(chosen), len(chosen) + len(alternatives)))
            for own in alternatives:
                points += [replace(point, column=len(chosen)) for point in own.points]
                chosen.append(np.array(self.integrals) == k)
            guards.append(len(chosen) if terms.guard else None)
            for point in terms.guard:
                points.append(replace(point, column=len(chosen)))
                chosen.append(np.zeros(len(self.integrals)))
        whole = np.array(chosen, dtype=float).T.reshape(len(self.integrals), len(chosen))
        return self._resolve(whole, points), columns, guards

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
            terms = self.terms[k]
            if k in self.integrals:
                rows.append(self._integral(found, self.integrals.index(k)))
                continue
            alternatives = np.array(
                [self._points(found, seed, own.points) for own in terms.alternatives]
            )
            rows.append(self._pick(terms, alternatives, found, seed, side))
        return np.array(rows)

    def _pick(
        self,
        terms: ReadingTerms,
        alternatives: np.ndarray,
        found: Followed,
        seed: np.ndarray,
        side: int,
    ) -> np.ndarray:
        """The alternative of a reading that holds to one side."""
        if terms.pick in ("greatest", "least"):
            upward = (terms.pick == "greatest") == (side > 0)
            chosen: np.ndarray = alternatives.max(axis=0) if upward else alternatives.min(axis=0)
            return chosen
        if terms.pick == "later":
            moved = side * self._points(found, seed, terms.guard)
            later = moved > 1e-12 * np.abs(moved).max(initial=0.0)
            picked: np.ndarray = np.where(later, alternatives[1], alternatives[0])
            return picked
        first: np.ndarray = alternatives[0]
        return first

    def _integral(self, found: Followed, place: int) -> np.ndarray:
        """Derivatives of one integral."""
        begin, end = self.spans[place]
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
        """Derivative of a reading through several instants."""
        total = np.zeros(seed.shape[1])
        for point in points:
            total = total + self._point(found, seed, point)
        return total

    def _point(self, found: Followed, seed: np.ndarray, point: AdjointPoint) -> np.ndarray:
        """Derivative of a reading through one instant."""
        leg = self.course.legs[point.leg]
        S = found.states[point.leg][int(np.searchsorted(leg.t, point.time))]
        total: np.ndarray = point.by_states @ S + point.by_parameters @ seed
        if point.edge:
            order = self.course.crossings[point.edge - 1].orders[0]
            own = [i for i in found.instants if i.number == point.edge]
            total = total + point.late * own[point.find_jump(order)].slopes
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


def refuse(summed: RunReadings, chained: Chained, names: Sequence[str], absent: np.ndarray) -> None:
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
            terms = [summed.terms[place] for place in counting]
            where = [each.where for each in terms if len(each.alternatives) > 1]
            if len(chained.branches[k]) > 1:
                read = (
                    f"{summed.wanted[i]} = {chained.read[i]:.6g} {summed.terms[i].where}".rstrip()
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
