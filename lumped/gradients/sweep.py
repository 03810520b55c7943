"""A sweep backwards over the steps of a run: derivatives by all parameters at once.

The discrete adjoint: each accepted step is differentiated as it was made, its length held, which
is exact up to the error of the run (Hairer, Norsett, Wanner, vol. I, II.6). Instants at which the
run stopped are crossed by the transposed matrices of `Saltation`, in the same sweep.

The steps of a run are chosen for its states. An integrand may be faster, and derivatives may move
while the states rest; steps are divided until both are accurate.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lumped.errors import SolverError
from lumped.gradients.jumps import EventDerivatives
from lumped.gradients.legs import Leg, SmoothParts, Stretch
from lumped.gradients.readings.instant_terms import AdjointPoint
from lumped.gradients.spans import Back, Carried, Jump, Pulse, Span
from lumped.gradients.varied import TIGHTER

_MOST_ORDERS = 16
"""Orders of coinciding changes that are followed in one run."""
_ROUNDS = 40
_MOST_STEPS = 1_000_000
"""Steps of a run at most."""
_FINEST = 1000
"""Parts into which a step is divided at once."""
_ROUNDING = 1e-11
"""Accuracy of derivatives that rounding allows."""


class StepResults(NamedTuple):
    """What a sweep finds for each step of each leg.

    Attributes
    ----------
    errors : list of ndarray, shape (steps, k)
        Error of each result by each step, relative to its derivatives by the states there.
    parts, part_errors : list of ndarray, shape (steps, q)
        Integrals, and their errors.
    """

    errors: list[np.ndarray]
    parts: list[np.ndarray]
    part_errors: list[np.ndarray]

    @classmethod
    def of(cls, legs: list[Leg], results: int, integrals: int) -> StepResults:
        """Nothing found yet."""
        made = [
            [np.zeros((len(leg.t) - 1, k)) for leg in legs] for k in (results, integrals, integrals)
        ]
        return cls(*made)

    def take(self, part: Stretch, back: Back) -> None:
        """Note what a sweep over a part found."""
        for (number, begin, end), place in zip(part.legs, part.places, strict=True):
            there, here = slice(place, place + end - begin), slice(begin, end)
            own = self.errors[number][here]
            np.maximum(own, back.errors[there], out=own)
            self.parts[number][here] = back.parts[there]
            self.part_errors[number][here] = back.part_errors[there]


class Seeds(NamedTuple):
    """Derivatives of results by integrals.

    Attributes
    ----------
    chosen : ndarray, shape (integrals, k)
        Derivatives of the results by the integrals.
    spans : ndarray, shape (integrals, 2)
        Begin and end of each, which are ends of steps, s.
    """

    chosen: np.ndarray
    spans: np.ndarray

    def at(self, t: float) -> np.ndarray:
        """Those of integrals that extend over a time."""
        inside = (self.spans[:, 0] < t) & (t < self.spans[:, 1])
        return self.chosen * inside[:, None]

    def pulses(self, t: np.ndarray, states: int) -> list[Pulse]:
        """Where integrals end, or begin, inside a part of the run, at which states end at `t`."""
        found = []
        for i, (begin, end) in enumerate(self.spans.tolist()):
            for time, side, sign in ((end, "right", 1.0), (begin, "left", -1.0)):
                if not t[0] < time < t[-1]:
                    continue
                place = int(np.searchsorted(t, time, side)) - (side == "right")  # type: ignore[call-overload]
                for column in np.flatnonzero(self.chosen[i]).tolist():
                    slopes = np.zeros(states + len(self.spans))
                    slopes[states + i] = sign * self.chosen[i, column]
                    found.append(Pulse(place, column, slopes))
        return found


Lates = list[list[list[np.ndarray]]]
"""Derivatives of results by the instant of each jump, of each order of them, of each crossing."""


class _Sweep:
    """A sweep over a run; arguments as for `sweep`."""

    def __init__(self, course: SmoothParts, seeds: Seeds, points: list[AdjointPoint]) -> None:
        self.legs, self.crossings, self.steps = course.legs, course.crossings, course.steps
        self.theta, self.seeds, self.points = course.run.theta, seeds, points
        q, count = seeds.chosen.shape
        self.by_step = StepResults.of(course.legs, count, q)
        self.late = self._lates()

    def _lates(self) -> Lates:
        """Derivatives of results by the instants at which the run changes."""
        q = len(self.seeds.chosen)
        jumps = [(c.t, jump) for c in self.crossings for order in c.orders for jump in order]
        gains = np.zeros((len(jumps), q))
        if q and jumps:
            t = np.repeat([t for t, _ in jumps], 2)
            x, m = (
                np.array([side[v] for _, j in jumps for side in (j.before, j.after)])
                for v in (0, 1)
            )
            rates = self.steps.integrated_along(x, self.theta, t, m)
            gains = rates[::2] - rates[1::2]
        edges: dict[int, list[AdjointPoint]] = {}
        for point in self.points:
            if point.edge:
                edges.setdefault(point.edge, []).append(point)
        found, rows = [], iter(gains)
        for number, crossing in enumerate(self.crossings, 1):
            chosen = self.seeds.at(crossing.t)
            orders = [[next(rows) @ chosen for _ in order] for order in crossing.orders]
            for point in edges.get(number, ()):
                for order, own in zip(crossing.orders, orders, strict=True):
                    own[point.find_jump(order)][point.column] += point.late
            found.append(orders)
        return found

    def over(self, part: Stretch, span: Span, after: Carried) -> Carried:
        """Back over one part and its steps."""
        n = self.steps.states
        pulses = self.seeds.pulses(span.t, n)
        none = np.zeros(self.steps.integrals)
        for point in self.points:
            place = part.place(self.legs, point.leg, point.time)
            if place is not None:
                slopes = np.concatenate([point.by_states, none])
                pulses.append(Pulse(place, point.column, slopes))
        pulses.sort(key=lambda pulse: pulse.end)
        jumps = [
            Jump(place - 1, jump, late)
            for (number, _, _), place in list(zip(part.legs, part.places, strict=True))[1:]
            for order, lates in zip(
                self.crossings[number - 1].orders, self.late[number - 1], strict=True
            )
            for jump, late in zip(order, lates, strict=True)
        ]
        begin, end = self.seeds.spans.T
        chosen = self.seeds.chosen * ((begin < span.t[-1]) & (span.t[-1] <= end))[:, None]
        after = after._replace(adjoint=np.vstack([after.adjoint[:n], chosen]))
        back = self.steps.back(span, after, pulses, jumps)
        self.by_step.take(part, back)
        return back.carried

    def across(
        self,
        order: tuple[EventDerivatives, ...],
        lates: list[np.ndarray],
        after: Carried,
    ) -> Carried:
        """Back over the changes between two parts."""
        adjoint, by_parameters = after.adjoint[: self.steps.states], after.by_parameters
        for jump, late in zip(reversed(order), reversed(lates), strict=True):
            adjoint, by_p = jump.backward(adjoint, late)
            by_parameters = by_parameters + by_p
        return after._replace(adjoint=adjoint, by_parameters=by_parameters)


def sweep(
    course: SmoothParts, seeds: Seeds, points: list[AdjointPoint]
) -> tuple[list[Carried], StepResults]:
    """Derivatives of results by states at the time zero and by parameters.

    Where different changes coincide, there is one answer for each order in which they can come.

    Parameters
    ----------
    course : SmoothParts
        With the instants of the points and spans among the ends of steps.
    """
    q, count = seeds.chosen.shape
    run, crossings = course.run, course.crossings
    n = course.steps.states
    own = _Sweep(course, seeds, points)
    found = [Carried(*(np.zeros((rows, count)) for rows in (n, len(run.theta), n + q, n + q)))]
    for point in points:
        found[0].by_parameters[:, point.column] += point.by_parameters
    several = {k for k, crossing in enumerate(crossings, 1) if len(crossing.orders) > 1}
    for part, span in course.stretches(several, backwards=True):
        found = [own.over(part, span, swept) for swept in found]
        number, begin, _ = part.legs[0]
        if begin or number not in several:
            continue
        orders = list(zip(crossings[number - 1].orders, own.late[number - 1], strict=True))
        found = [own.across(*order, swept) for swept in found for order in orders]
        found = _different(found)
        if len(found) > _MOST_ORDERS:
            raise SolverError(
                f"{run.system.name}: up to t = {crossings[number - 1].t:.9g} s different changes "
                "coincide too often for all their orders to be followed. Change a parameter a "
                "little.",
                run,
            )
    return found, own.by_step


def _different(found: list[Carried]) -> list[Carried]:
    """Answers that are not the same."""
    kept: list[Carried] = []
    for one in found:
        both = np.vstack(one[:2])
        known = [np.vstack(other[:2]) for other in kept]
        if not any((np.abs(both - k) <= 1e-9 * np.abs(k).max(axis=0)).all() for k in known):
            kept.append(one)
    return kept


class Resolved(NamedTuple):
    """Derivatives of results by a sweep over steps that are short enough.

    Attributes
    ----------
    found : list of Carried
        For all orders of changes that coincide.
    errors : ndarray, shape (k,)
        Estimated errors, relative to the terms of which a derivative consists.
    sums, sizes : ndarray, shape (q,)
        Integrals, and those of the sizes.
    """

    found: list[Carried]
    errors: np.ndarray
    sums: np.ndarray
    sizes: np.ndarray


def refine_sweep(course: SmoothParts, seeds: Seeds, points: list[AdjointPoint]) -> Resolved:
    """Sweep back, and divide steps until integrals and derivatives are accurate.

    Raises
    ------
    SolverError
        If that needs too many steps.
    """
    for _ in range(_ROUNDS):
        found, by_step = sweep(course, seeds, points)
        sums, sizes = _totals(course.legs, by_step, seeds)
        each = [course.steps.relative(swept.largest, swept.lost) for swept in found]
        errors: np.ndarray = np.max(each, axis=0)
        if not _divide_steps(course, by_step, sizes, errors):
            return Resolved(found, errors, sums, sizes)
    raise _too_many(course)


def _divide_steps(
    course: SmoothParts, by_step: StepResults, sizes: np.ndarray, errors: np.ndarray
) -> bool:
    """Whether steps were divided, as integrals or derivatives are not accurate.

    Parameters
    ----------
    sizes : ndarray, shape (q,)
        Integrals of the sizes.
    errors : ndarray, shape (k,)
        Errors of the derivatives of the results by all steps.
    """
    legs, rtol = course.legs, max(course.rtol / TIGHTER, _ROUNDING)
    allowed = rtol * sizes
    rough = ~(np.sum([e.sum(axis=0) for e in by_step.part_errors], axis=0) <= allowed)
    over = ~(errors <= rtol)  # also where an adjoint has grown beyond all numbers
    if not rough.any() and not over.any():
        return False
    count = sum(len(leg.t) for leg in legs)
    span = course.until - float(legs[0].t[0])
    finer = False
    for leg, each, of_integrals in zip(legs, by_step.errors, by_step.part_errors, strict=True):
        length = np.diff(leg.t)
        implicit = course.run.statistics.is_implicit(leg.t[:-1])
        share = allowed * length[:, None] / span
        parts = np.maximum(
            _parts(of_integrals[:, rough], share[:, rough], implicit),
            _parts(each[:, over], np.full(1, rtol / count), implicit),
        )
        parts[length <= 1e-12 * (1.0 + np.abs(leg.t[1:]))] = 1
        if (parts > 1).any():
            finer = True
            if count + parts.sum() > _MOST_STEPS:
                raise _too_many(course)
            leg.divide(parts)
    return finer


def _too_many(course: SmoothParts) -> SolverError:
    return SolverError(
        f"{course.run.system.name}: an integral or a derivative needs more than {_MOST_STEPS} "
        f"steps at rtol = {course.rtol:g}. Loosen rtol, end the run earlier, or take "
        "method='implicit' for a stiff drive that rests.",
        course.run,
    )


def _parts(errors: np.ndarray, allowed: np.ndarray, implicit: np.ndarray) -> np.ndarray:
    """Into how many parts each step is divided, so that its errors are allowed, shape (steps,)."""
    if not errors.size:
        return np.ones(len(errors), dtype=int)
    with np.errstate(divide="ignore", invalid="ignore"):
        over = np.where(errors == 0, 0.0, errors / allowed)
    over = np.nan_to_num(over, nan=1e300, posinf=1e300).max(axis=1)
    # an error of order p in one step is one of order p - 1 in all its parts together
    many: np.ndarray = np.ceil(1.2 * over ** np.where(implicit, 1 / 4, 1 / 6))
    return np.where(over > 1.0, np.clip(many, 2, _FINEST), 1).astype(int)


def _totals(legs: list[Leg], by_step: StepResults, seeds: Seeds) -> tuple[np.ndarray, np.ndarray]:
    """Each integral over its span, and that of its size; spans end where steps do."""
    found, sizes = np.zeros(len(seeds.spans)), np.zeros(len(seeds.spans))
    if not len(found):
        return found, sizes
    for leg, parts in zip(legs, by_step.parts, strict=True):
        middle = 0.5 * (leg.t[1:] + leg.t[:-1])[:, None]
        inside = (seeds.spans[:, 0] < middle) & (middle < seeds.spans[:, 1])
        found += (parts * inside).sum(axis=0)
        sizes += np.abs(parts * inside).sum(axis=0)
    return found, sizes
