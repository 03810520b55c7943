"""The smooth parts of a run, how derivatives cross what lies between, and what results owe them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.instant_values import margin_sizes
from lumped.gradients.jumps import Crossing, Side
from lumped.gradients.saltation import saltation_of
from lumped.gradients.state_changes import exchange_fault
from lumped.gradients.step_code import Span, StepCode
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.point_function import PointFunction
from lumped.timeloop.result import Trajectory
from lumped.timeloop.run import nominals

__all__ = [
    "AdjointPoint",
    "Leg",
    "Steps",
    "crossings_of",
    "legs_of",
    "steps_of",
]

_AT_ONCE = 1e-10
"""Part of a run within which changes are at the same instant."""


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
    def _integrated(self) -> ca.Function:
        return ca.Function("integrated", self.system.inputs, [ca.densify(self.integrands)])

    @property
    @made_once
    def integrated(self) -> ArrayFunction:
        """What is integrated, at one point: (x, p, t, m)."""
        return ArrayFunction(self._integrated)

    @property
    @made_once
    def integrated_along(self) -> PointFunction:
        """What is integrated, at points of a run."""
        return PointFunction(self._integrated)


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
