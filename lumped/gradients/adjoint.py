"""A sweep backwards over the steps of a run: derivatives by all parameters at once.

The discrete adjoint: each accepted step is differentiated as it was made, its length held, which
is exact up to the error of the run (Hairer, Norsett, Wanner, vol. I, II.6). Instants at which the
run stopped are crossed by the transposed matrices of `Saltation`.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lumped.errors import SolverError
from lumped.gradients.jumps import Crossing, EventDerivatives
from lumped.gradients.legs import Leg
from lumped.gradients.saltation import saltation_of
from lumped.gradients.steps import Steps
from lumped.timeloop.result import Trajectory

__all__ = [
    "AdjointPoint",
    "OnTheWay",
    "Seeds",
    "Swept",
    "crossings_of",
    "placed",
    "sweep",
]

_AT_ONCE = 1e-10
"""Part of a run within which changes are at the same instant."""

_MOST = 16
"""Orders of coinciding changes that are followed in one run."""


@dataclass(frozen=True)
class AdjointPoint:
    """What a result owes to one instant of a run.

    Attributes
    ----------
    leg : int
        Number of the smooth part.
    time : float
        Where in it, s.
    column : int
        Number of the result.
    by_states, by_parameters : ndarray, shapes (n,) and (p,)
        Derivatives of the result at that instant.
    edge : int
        Number of the leg with whose begin the instant moves; 0 if it does not move.
    late : float
        Derivative of the result by that begin.
    name : str
        Component whose change this is about, if others may change at the same instant.
    """

    leg: int
    time: float
    column: int
    by_states: np.ndarray
    by_parameters: np.ndarray
    edge: int = 0
    late: float = 0.0
    name: str = ""


class Swept(NamedTuple):
    """What a sweep finds: derivatives of results by states at the time zero and by parameters.

    Attributes
    ----------
    by_states, by_parameters : ndarray, shapes (n, k) and (p, k)
        The derivatives, if coinciding changes come in one of their orders.
    largest, lost : ndarray, shape (n + q, k)
        Largest size of the derivatives by states, and integrals, at any time; the sizes of the
        errors that steps add to them, together.
    """

    by_states: np.ndarray
    by_parameters: np.ndarray
    largest: np.ndarray
    lost: np.ndarray


class OnTheWay(NamedTuple):
    """What a sweep finds on the way; of each leg, one row for each step.

    Attributes
    ----------
    errors : list of ndarray, shape (steps, k)
        Error of each result by each step, relative to what it owes to the states by then.
    parts, part_errors : list of ndarray, shape (steps, q)
        Integrals, and their errors.
    """

    errors: list[np.ndarray]
    parts: list[np.ndarray]
    part_errors: list[np.ndarray]

    @classmethod
    def of(cls, legs: list[Leg], results: int, integrals: int) -> OnTheWay:
        """Nothing found yet."""
        made = [
            [np.zeros((len(leg.t) - 1, k)) for leg in legs] for k in (results, integrals, integrals)
        ]
        return cls(*made)


def crossings_of(run: Trajectory, legs: list[Leg], rtol: float) -> list[Crossing]:
    """How derivatives jump where each leg but the first begins.

    Raises
    ------
    SolverError
        Where the run has no derivatives.
    """
    saltation, found = saltation_of(run.system), []
    for last, leg in itertools.pairwise(legs):
        at = float(leg.t[0])
        found.append(saltation.at(run, at, last.side(-1), leg.side(0), rtol, last.margins()))
    soon = _AT_ONCE * float(legs[-1].t[-1])
    for k in range(len(found) - 1):
        if found[k + 1].t - found[k].t <= soon and found[k].orders:
            accuracy = max(rtol, _AT_ONCE) * legs[k].margins()
            both = saltation.joined(run, found[k], found[k + 1], accuracy)
            if both is not None:
                found[k], found[k + 1] = Crossing(found[k].t, ()), both
    return found


class Seeds(NamedTuple):
    """What results owe to integrals.

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
        found: np.ndarray = self.chosen * inside[:, None]
        return found


def sweep(
    run: Trajectory,
    legs: list[Leg],
    crossings: list[Crossing],
    steps: Steps,
    seeds: Seeds,
    points: list[AdjointPoint],
) -> tuple[list[Swept], OnTheWay]:
    """Derivatives of results by states at the time zero and by parameters.

    Where different changes coincide, there is one answer for each order in which they can come.

    Parameters
    ----------
    legs : list of Leg
        From `legs_of`, with the instants of the points and spans among their times.
    """
    q, count = seeds.chosen.shape
    n = len(run.system.structure.states)
    way = OnTheWay.of(legs, count, q)
    found = [Swept(*(np.zeros((rows, count)) for rows in (n, len(run.theta), n + q, n + q)))]
    for number in reversed(range(len(legs))):
        found = [_over(legs[number], number, steps, seeds, points, way, s) for s in found]
        if number:
            crossing = crossings[number - 1]
            if not crossing.orders:
                continue
            found = [
                _across(run, steps, seeds, points, number, crossing, order, s)
                for s in found
                for order in crossing.orders
            ]
            found = _different(found)
            if len(found) > _MOST:
                raise SolverError(
                    f"{run.system.name}: up to t = {crossing.t:.9g} s different changes coincide "
                    "too often for all their orders to be followed. Change a parameter a little.",
                    run,
                )
    return found, way


def _different(found: list[Swept]) -> list[Swept]:
    """Answers that are not the same."""
    kept: list[Swept] = []
    for one in found:
        both = np.vstack(one[:2])
        known = [np.vstack(other[:2]) for other in kept]
        if not any((np.abs(both - k) <= 1e-9 * np.abs(k).max(axis=0)).all() for k in known):
            kept.append(one)
    return kept


def _over(
    leg: Leg,
    number: int,
    steps: Steps,
    seeds: Seeds,
    points: list[AdjointPoint],
    way: OnTheWay,
    after: Swept,
) -> Swept:
    """Back over one leg."""
    adjoint, by_parameters, *sizes = (v.copy() for v in after)
    n = len(adjoint)
    here = [(int(np.searchsorted(leg.t, p.time)), p) for p in points if p.leg == number]
    end = len(leg.t) - 1
    borders = [int(i) for t in seeds.spans.ravel() for i in np.flatnonzero(leg.t == t)]
    for stop in sorted({place for place, _ in here} | {0, end, *borders}, reverse=True):
        if stop < end:
            chosen = seeds.at(0.5 * (leg.t[stop] + leg.t[end]))
            for begin, stop_of_chunk in reversed(leg.chunks(stop, end)):
                found = np.vstack([adjoint, chosen]), by_parameters, *sizes
                back = steps.back(leg.span(begin, stop_of_chunk), *found)
                adjoint, by_parameters = back.adjoint[:n], back.by_parameters
                sizes, own = [back.largest, back.lost], slice(begin, stop_of_chunk)
                np.maximum(way.errors[number][own], back.errors, out=way.errors[number][own])
                way.parts[number][own] = back.parts
                way.part_errors[number][own] = back.part_errors
        end = stop
        for place, point in here:
            if place == stop:
                adjoint[:, point.column] += point.by_states
                by_parameters[:, point.column] += point.by_parameters
    return Swept(adjoint, by_parameters, *sizes)


def _across(
    run: Trajectory,
    steps: Steps,
    seeds: Seeds,
    points: list[AdjointPoint],
    number: int,
    crossing: Crossing,
    order: tuple[EventDerivatives, ...],
    after: Swept,
) -> Swept:
    """Back over the changes at which a leg begins."""
    adjoint, by_parameters, *sizes = after
    for place, jump in reversed(list(enumerate(order))):
        late = np.zeros(adjoint.shape[1])
        for point in points:
            if point.edge == number and place == placed(point, number, order):
                late[point.column] += point.late
        if len(seeds.chosen):
            rates = [
                np.asarray(steps.integrated(x, run.theta, crossing.t, m)).ravel()
                for x, m in (jump.before, jump.after)
            ]
            late += (rates[0] - rates[1]) @ seeds.at(crossing.t)
        adjoint, by_p = jump.backward(adjoint, late)
        by_parameters = by_parameters + by_p
    return Swept(adjoint, by_parameters, *sizes)


def placed(point: AdjointPoint, number: int, order: tuple[EventDerivatives, ...]) -> int:
    """Which of the jumps at the begin of a leg a result hangs on."""
    if point.name:
        return next((i for i, jump in enumerate(order) if point.name in jump.names), 0)
    return len(order) - 1 if point.leg == number else 0
