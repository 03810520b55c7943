"""A sweep backwards over the steps of a run: derivatives by all parameters at once.

The discrete adjoint: each accepted step is differentiated as it was made, its length held, which
is exact up to the error of the run (Hairer, Norsett, Wanner, vol. I, II.6). Instants at which the
run stopped are crossed by the transposed matrices of `Saltation`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.analysis.calls import Call
from lumped.analysis.dense import Method
from lumped.analysis.result import Trajectory
from lumped.analysis.reverse import CHUNKS, backwards, chained, step_function
from lumped.analysis.saltation import Saltation, coincide
from lumped.analysis.watch import exchange_fault
from lumped.errors import SolverError
from lumped.system import System

__all__ = ["Leg", "Point", "Steps", "legs_of", "sweep"]


@dataclass
class Leg:
    """A smooth part of a run at the ends of its steps: times, states, settings."""

    t: np.ndarray
    x: np.ndarray
    settings: np.ndarray

    def insert(self, step: int, t: float, x: np.ndarray) -> None:
        """Part a step in two."""
        self.t = np.insert(self.t, step + 1, t)
        self.x = np.insert(self.x, step + 1, x, axis=0)
        self.settings = np.insert(self.settings, step + 1, self.settings[step], axis=0)


@dataclass(frozen=True)
class Point:
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
    """

    leg: int
    time: float
    column: int
    by_states: np.ndarray
    by_parameters: np.ndarray
    edge: int = 0
    late: float = 0.0


class Swept(NamedTuple):
    """What a sweep finds.

    Attributes
    ----------
    by_states, by_parameters : ndarray, shapes (n, k) and (p, k)
        Derivatives of the results by states at the time zero and by parameters.
    integrals : ndarray
        Values of the integrals.
    shared : tuple of float
        Instants at which statically indeterminate constraints let go, s.
    """

    by_states: np.ndarray
    by_parameters: np.ndarray
    integrals: np.ndarray
    shared: tuple[float, ...]


class Steps:
    """Steps of one system with integrals of some products, and the same backwards.

    Parameters
    ----------
    system : System
        From `assemble`.
    products : tuple of tuple of str
        Factors of what is integrated.
    columns : tuple of int
        Which result each integral is.
    count : int
        Number of results.
    """

    def __init__(
        self,
        system: System,
        products: tuple[tuple[str, ...], ...],
        columns: tuple[int, ...],
        count: int,
    ) -> None:
        self.system, self.chosen = system, np.zeros((len(products), count))
        self.chosen[np.arange(len(products)), list(columns)] = 1.0
        factors = [ca.vertsplit(system.expressions(names)) for names in products]
        self.integrands = ca.vertcat(ca.SX(0, 1), *(math.prod(f) for f in factors))
        self._steps: dict[Method, ca.Function] = {}
        self._backs: dict[Method, ca.Function] = {}
        self._calls: dict[tuple[Method, int], Call] = {}

    @classmethod
    def of(
        cls,
        system: System,
        products: tuple[tuple[str, ...], ...],
        columns: tuple[int, ...],
        count: int,
    ) -> Steps:
        """Those of a system, made once."""
        key = ("steps", products, columns, count)
        if key not in system.made:
            system.made[key] = cls(system, products, columns, count)
        made: Steps = system.made[key]
        return made

    def step(self, method: Method) -> ca.Function:
        """One step (see `step_function`)."""
        if method not in self._steps:
            self._steps[method] = step_function(self.system, method, self.integrands)
        return self._steps[method]

    def back(self, method: Method, count: int) -> Call:
        """Several steps backwards (see `chained`)."""
        if (method, count) not in self._calls:
            parameters = self.system._inputs[1].numel()
            self._calls[method, count] = chained(self.single(method), parameters, count)
        return self._calls[method, count]

    def single(self, method: Method) -> ca.Function:
        """One step backwards (see `backwards`)."""
        if method not in self._backs:
            self._backs[method] = backwards(self.step(method), self.chosen)
        return self._backs[method]

    @cached_property
    def integrated(self) -> ca.Function:
        """What is integrated: (x, p, t, m)."""
        return ca.Function("integrated", self.system._inputs, [ca.densify(self.integrands)])


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


def sweep(run: Trajectory, legs: list[Leg], steps: Steps, points: list[Point]) -> Swept:
    """Derivatives of results by states at the time zero and by parameters, and the integrals.

    Parameters
    ----------
    legs : list of Leg
        From `legs_of`, with the instants of the points among their times.

    Raises
    ------
    SolverError
        Where the run has no derivatives.
    """
    system, theta, count = run.system, run.theta, steps.chosen.shape[1]
    adjoint = np.zeros((len(system.states), count))
    by_parameters = np.zeros((len(theta), count))
    integrals = np.zeros(len(steps.chosen))
    shared: list[float] = []
    for number in reversed(range(len(legs))):
        leg = legs[number]
        here = [(int(np.searchsorted(leg.t, p.time)), p) for p in points if p.leg == number]
        end = len(leg.t) - 1
        for stop in sorted({place for place, _ in here} | {0, end}, reverse=True):
            adjoint, by_p, part = _through(run, leg, steps, (stop, end), adjoint)
            by_parameters += by_p
            integrals += part
            end = stop
            for place, point in here:
                if place == stop:
                    adjoint[:, point.column] += point.by_states
                    by_parameters[:, point.column] += point.by_parameters
        if number:
            adjoint, by_p, shares = _across(run, legs, number, steps, points, adjoint)
            by_parameters += by_p
            shared += [float(leg.t[0])] * shares
    return Swept(adjoint, by_parameters, integrals, tuple(reversed(shared)))


def _through(
    run: Trajectory, leg: Leg, steps: Steps, span: tuple[int, int], adjoint: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Back over steps of one leg: adjoints, derivatives by parameters, integrals."""
    begin, end = span
    n, k = adjoint.shape
    by_parameters, integrals = np.zeros((len(run.theta), k)), np.zeros(len(steps.chosen))
    change = int(np.searchsorted(leg.t[:end], run.statistics.implicit_from))
    parts: list[tuple[Method, int]] = [("implicit", max(begin, change)), ("explicit", begin)]
    flat = adjoint.ravel(order="F")
    for method, first in parts:
        while end > first:
            count = next(c for c in CHUNKS if c <= end - first)
            t, x, m = (v[end - count : end] for v in (leg.t, leg.x, leg.settings))
            lengths = np.diff(leg.t[end - count : end + 1])
            back = steps.back(method, count)
            flat, by_p, part = back(flat, x.ravel(), run.theta, t, lengths, m.ravel())
            by_parameters += by_p.reshape(k, -1).T
            integrals += part
            end -= count
    return flat.reshape(k, n).T.copy(), by_parameters, integrals


def _across(
    run: Trajectory,
    legs: list[Leg],
    number: int,
    steps: Steps,
    points: list[Point],
    adjoint: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, bool]:
    """Back over the instant at which a leg begins: adjoints, derivatives by parameters, sharing."""
    system, theta = run.system, run.theta
    last, leg = legs[number - 1], legs[number]
    t = float(leg.t[0])
    old, new = (last.x[-1], last.settings[-1]), (leg.x[0], leg.settings[0])
    late = np.zeros(adjoint.shape[1])
    for point in points:
        if point.edge == number:
            late[point.column] += point.late
    if len(steps.chosen):
        before, after = (
            np.asarray(steps.integrated(x, theta, t, m)).ravel() for x, m in (old, new)
        )
        late += (before - after) @ steps.chosen
    size = np.concatenate([1.0 + np.abs(old[0]), np.abs(theta)])
    jump = Saltation.of(system).at(run, t, old, new)
    crossed = jump.backward(adjoint, late, size)
    if crossed is None:
        raise coincide(run, t)
    return (*crossed, jump.shared)
