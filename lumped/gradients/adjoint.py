"""A sweep backwards over the steps of a run: derivatives by all parameters at once.

The discrete adjoint: each accepted step is differentiated as it was made, its length held, which
is exact up to the error of the run (Hairer, Norsett, Wanner, vol. I, II.6). Instants at which the
run stopped are crossed by the transposed matrices of `Saltation`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.instant_values import margin_sizes
from lumped.gradients.jumps import Crossing, EventDerivatives, Side
from lumped.gradients.saltation import saltation_of
from lumped.gradients.state_changes import exchange_fault
from lumped.gradients.step_code import Span, StepCode
from lumped.support.made_once import made_once
from lumped.timeloop.result import Trajectory
from lumped.timeloop.run import nominals

__all__ = [
    "AdjointPoint",
    "Leg",
    "OnTheWay",
    "Seeds",
    "Steps",
    "Swept",
    "crossings_of",
    "legs_of",
    "placed",
    "steps_of",
    "sweep",
]

_AT_ONCE = 1e-10
"""Part of a run within which changes are at the same instant."""

_MOST = 16
"""Orders of coinciding changes that are followed in one run."""


@dataclass
class Leg:
    """A smooth part of a run at the ends of its steps: times, states, settings."""

    t: np.ndarray
    x: np.ndarray
    settings: np.ndarray

    def span(self, run: Trajectory, begin: int = 0, end: int | None = None) -> Span:
        """Steps from one end of a step to another; all by default."""
        own = slice(begin, None if end is None else end + 1)
        t, x, m = self.t[own], self.x[own], self.settings[own]
        return Span(run.theta, t, x, m, run.statistics.implicit_from)

    def state(self, run: Trajectory, steps: Steps, t: float) -> Side:
        """States and settings at a time: those of a shorter step."""
        i = int(np.searchsorted(self.t, t, "right")) - 1
        if self.t[i] == t:
            return self.x[i], self.settings[i]
        return steps.replayed(self.shorter(run, i, t), np.array([1, 0]))[1], self.settings[i]

    def shorter(self, run: Trajectory, i: int, t: float) -> Span:
        """A step that ends earlier; the states there are not known."""
        x, m = self.x[i : i + 1].repeat(2, axis=0), self.settings[i : i + 1].repeat(2, axis=0)
        return Span(run.theta, np.array([self.t[i], t]), x, m, run.statistics.implicit_from)

    @property
    def course(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, states and settings."""
        return self.t, self.x, self.settings

    def cut(self, run: Trajectory, steps: Steps, t: float) -> None:
        """Make an instant inside the leg the end of a step."""
        if t in self.t:
            return
        x, settings = self.state(run, steps, t)
        place = int(np.searchsorted(self.t, t))
        self.t = np.insert(self.t, place, t)
        self.x = np.insert(self.x, place, x, axis=0)
        self.settings = np.insert(self.settings, place, settings, axis=0)

    def divide(self, run: Trajectory, steps: Steps, parts: np.ndarray) -> None:
        """Divide each step into so many equal ones; where steps ended, states stay as they are."""
        begins, counts = np.repeat(self.t[:-1], parts), np.append(parts, 1)
        inner = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
        lengths = np.repeat(np.diff(self.t) / parts, parts)
        is_given = np.append(inner == 0, True)
        self.t = np.append(begins + inner * lengths, self.t[-1])
        self.settings = np.repeat(self.settings, counts, axis=0)
        self.x = np.repeat(self.x, counts, axis=0)
        self.x = steps.replayed(self.span(run), is_given)


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


class Steps(StepCode):
    """Steps of one system with integrals of some products, and the same backwards.

    Parameters
    ----------
    system : System
        From `assemble`.
    products : tuple of tuple of str
        Factors of what is integrated.
    """

    def __init__(self, system: System, products: tuple[tuple[str, ...], ...]) -> None:
        factors = [ca.vertsplit(system.expressions(names)) for names in products]
        self.system = system
        self.integrands = ca.vertcat(ca.SX(0, 1), *(math.prod(f) for f in factors))
        rates, inputs = system.rates, system.inputs
        own = rates, self.integrands, nominals(system)
        super().__init__(system.name, system.building, inputs, *own)

    @property
    @made_once
    def integrated(self) -> ca.Function:
        """What is integrated: (x, p, t, m)."""
        return ca.Function("integrated", self.system.inputs, [ca.densify(self.integrands)])


@made_once
def steps_of(system: System, products: tuple[tuple[str, ...], ...]) -> Steps:
    """Steps of a system."""
    return Steps(system, products)


def legs_of(run: Trajectory) -> list[Leg]:
    """Smooth parts of a run that was recorded at the steps of the solver.

    Raises
    ------
    SolverError
        If states change places.
    """
    legs = []
    for piece in (p for p in run.pieces if len(p.t)):
        if piece.system is not run.system:
            raise SolverError(exchange_fault(run, float(piece.t[0])), run)
        new = np.append(True, np.diff(piece.t) > 0)
        legs.append(Leg(piece.t[new], piece.x[new], piece.settings[new]))
    return legs


def crossings_of(run: Trajectory, legs: list[Leg], rtol: float) -> list[Crossing]:
    """How derivatives jump where each leg but the first begins.

    Raises
    ------
    SolverError
        Where the run has no derivatives.
    """
    saltation = saltation_of(run.system)
    found = saltation.between(run, [leg.course for leg in legs], rtol)
    soon = _AT_ONCE * float(legs[-1].t[-1])
    for k in range(len(found) - 1):
        if found[k + 1].t - found[k].t <= soon and found[k].orders:
            (sizes,) = margin_sizes(run.system, run.theta, [legs[k].course])
            accuracy = max(rtol, _AT_ONCE) * sizes
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
        found = [_over(run, legs[number], number, steps, seeds, points, way, s) for s in found]
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
    run: Trajectory,
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
            back = steps.back(leg.span(run, stop, end), np.vstack([adjoint, chosen]), *sizes)
            adjoint, sizes = back.adjoint[:n], [back.largest, back.lost]
            by_parameters += back.by_parameters
            own = slice(stop, end)
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
