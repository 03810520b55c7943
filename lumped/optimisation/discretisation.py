"""Quantities over the instants of a run as expressions of a design, and their functionals."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.numerics.nlp import Programme
from lumped.orbits.smooth_curves import curves, extreme, integral
from lumped.simulation.functionals import Designed, Final, Integral, Peak, Swing
from lumped.timeloop.instants import clocks
from lumped.timeloop.result import Trajectory

__all__ = [
    "Discretisation",
    "FunctionalTerm",
    "along",
    "dt_of",
    "followed_by",
    "held_instants",
    "measured",
    "number_of",
    "smooth",
    "term",
]

_CLOSED = 1e-9


@dataclass(frozen=True, eq=False)
class Discretisation:
    """States and parameters at instants, numbers or expressions of unknowns.

    Attributes
    ----------
    system : System
        Whose quantities are meant.
    t : SX or ndarray, shape (n,)
        Instants, s.
    weights : SX or ndarray, shape (n,)
        Weights of an integral over time, s.
    x : SX, shape (states, n)
        States.
    theta : SX, shape (parameters, 1) or (parameters, n)
        Parameters.
    settings : ndarray, shape (n, m)
        Modes and guesses.
    """

    system: System
    t: ca.SX | np.ndarray
    weights: ca.SX | np.ndarray
    x: ca.SX
    theta: ca.SX
    settings: np.ndarray

    def quantities(self, names: Iterable[str]) -> ca.SX:
        """Named quantities as rows, shape (k, n).

        What depends on numbers only is a number, so the cost of what follows is that of what
        depends on the unknowns.
        """
        function = self.system.function(names)
        count = len(self.settings)
        times = ca.SX(ca.DM(self.t)) if isinstance(self.t, np.ndarray) else self.t
        columns = ca.repmat(self.theta, 1, count) if self.theta.shape[1] == 1 else self.theta
        return function.map(count)(self.x, columns, times.T, ca.DM(self.settings.T))


def smooth(run: Trajectory, why: str) -> None:
    """Refuse a run with changes of modes or impacts, by name."""
    changes = [e for e in run.events if e.kind != "time"]
    if changes:
        first = changes[0]
        raise OptionError(
            f"{run.system.name}: {why} follows smooth runs only, but at t = {first.time:.6g} s "
            f"{first.component} changes ({first.before} -> {first.after}). Runs with events have "
            "exact derivatives by single shooting: give optimise the system, or take "
            "lumped.sensitivity."
        )


def held_instants(system: System, varied: list[int]) -> None:
    """Refuse parameters that move an instant at which a function of time changes its piece."""
    theta = system.inputs[1]
    clocked = ca.vertcat(ca.SX(0, 1), *(c.condition.argument for c in clocks(system) if c.moves))
    moving = ca.jacobian_sparsity(clocked, theta).get_triplet()[1]
    held = [n for i, n in enumerate(system.parameters) if i in moving and i in varied]
    if held:
        raise OptionError(
            f"{system.name}: {held[0]} moves an instant at which a function of time changes its "
            "piece, and the instants of the run are held. Leave it out of `vary`."
        )


def along(run: Trajectory, theta: ca.SX) -> Discretisation:
    """The instants of a run of a system without states, at other parameters."""
    system = run.system
    settings = np.concatenate([piece.settings for piece in run.pieces])
    none = ca.SX(0, len(run.t))
    return Discretisation(system, run.t, dt_of(run), none, theta, settings)


def dt_of(run: Trajectory) -> np.ndarray:
    """Weights of an integral by the trapezoid rule, s, shape (len(run.t),)."""
    weights = [np.zeros(0)]
    for piece in run.pieces:
        dt = np.diff(piece.t)
        weights.append(0.5 * (np.append(dt, 0.0) + np.insert(dt, 0, 0.0)))
    return np.concatenate(weights)


def followed_by(run: Trajectory, theta: np.ndarray) -> Trajectory:
    """The run of a system without states at other parameters, its linkages closed anew."""
    pieces = []
    for piece in run.pieces:
        settings = piece.settings
        implicit = len(run.system.structure.implicit)
        if implicit:
            inputs = (np.zeros((0, len(piece.t))), theta, piece.t[None, :], settings.T)
            found, step = (np.asarray(v) for v in run.system.closure(*inputs))
            if not np.abs(step).max() <= _CLOSED * (1 + np.abs(found).max()):
                raise SolverError(
                    f"{run.system.name}: a linkage moves too far from where it was at the start "
                    "of the search. Begin with a run nearer to the optimum, or narrow `vary`."
                )
            settings = np.hstack([settings[:, :-implicit], found.T])
        pieces.append(replace(piece, settings=settings))
    return Trajectory(run.system, tuple(pieces), theta, run.events, run.statistics)


@dataclass(frozen=True, eq=False)
class FunctionalTerm:
    """A functional as an expression of the unknowns.

    Attributes
    ----------
    value : SX
        In the unit of the quantity.
    scale : float
        Its size at the start.
    bounded : bool
        The expression is an upper bound of the functional, so it can be made small, not large.
    """

    value: ca.SX
    scale: float
    bounded: bool


def term(
    programme: Programme, course: Discretisation, functional: Designed, y: ca.SX, start: np.ndarray
) -> FunctionalTerm:
    """A functional of a quantity.

    Parameters
    ----------
    y : SX, shape (1, n)
        The quantity along the course.
    start : ndarray, shape (n,)
        Its values at the start.
    """
    size = float(np.abs(start).max()) or 1.0
    unit = course.system.quantity(functional.name).unit
    times = course.t if isinstance(course.t, np.ndarray) else None
    weights = (
        ca.SX(ca.DM(course.weights)) if isinstance(course.weights, np.ndarray) else course.weights
    )
    weights = weights / ca.sum1(weights)

    def limit(sign: float, level: float) -> ca.SX:
        e = programme.unknown(level, size)
        programme.constrain(
            f"{functional}: {functional.name}",
            sign * (e - y.T),
            0.0,
            np.inf,
            scale=size,
            unit=unit,
            times=times,
        )
        return e

    if isinstance(functional, Peak) and functional.kind == "peak":
        e = programme.unknown(size, size)
        for sign in (1.0, -1.0):
            label = f"{functional}: bound less {'' if sign > 0 else '-'}{functional.name}"
            programme.constrain(
                label, e - sign * y.T, 0.0, np.inf, scale=size, unit=unit, times=times
            )
        return FunctionalTerm(e, size, True)
    if isinstance(functional, Peak) and functional.kind == "highest":
        return FunctionalTerm(limit(1.0, float(start.max())), size, True)
    if isinstance(functional, Swing):
        top, bottom = limit(1.0, float(start.max())), limit(-1.0, float(start.min()))
        return FunctionalTerm(top - bottom, float(np.ptp(start)) or size, True)
    if isinstance(functional, Integral) and functional.kind == "rms":
        # an unknown of its own: the root of a sum would couple all instants with each other
        e = programme.unknown(size, size, low=0.0)
        square = ca.mtimes(y**2, weights)
        label = f"{functional}: square less mean square"
        programme.constrain(label, e**2 - square, 0.0, 0.0, scale=size**2, unit=f"({unit})2")
        return FunctionalTerm(e, size, False)
    if isinstance(functional, Integral) and functional.kind == "mean":
        return FunctionalTerm(ca.mtimes(y, weights), size, False)
    if isinstance(functional, Final):
        return FunctionalTerm(y[-1], size, False)
    raise OptionError(
        f"optimise: {functional}; choose peak, highest, swing, rms, mean or final of a quantity, "
        "from lumped.functionals."
    )


def measured(functional: Designed, run: Trajectory) -> float:
    """A functional of a run, between its output times too: by quintics through its points."""
    y = run.system.expressions([functional.name])
    if isinstance(functional, Integral):
        square = functional.kind == "rms"
        pieces = curves(run, y**2 if square else y)
        mean = integral(pieces).real / sum(float(piece.t[-1] - piece.t[0]) for piece in pieces)
        return float(np.sqrt(max(mean, 0.0))) if square else mean
    if isinstance(functional, Final):
        return float(run[functional.name][-1])
    pieces = curves(run, y)
    top, bottom = (extreme(pieces, sign).value for sign in (1, -1))
    if isinstance(functional, Swing):
        return top - bottom
    return max(top, -bottom) if functional.kind == "peak" else top


def number_of(functional: Designed, y: np.ndarray, weights: np.ndarray) -> float:
    """A functional of numbers, with the weights of an integral over time."""
    if isinstance(functional, Peak):
        return float(np.abs(y).max() if functional.kind == "peak" else y.max())
    if isinstance(functional, Swing):
        return float(np.ptp(y))
    if isinstance(functional, Integral):
        square = functional.kind == "rms"
        mean = float(weights @ (y**2 if square else y) / weights.sum())
        return mean**0.5 if square else mean
    return float(y[-1])
