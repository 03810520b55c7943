"""Quantities over the instants of a run as expressions of a design."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.timeloop.clocks import clocks
from lumped.timeloop.results.trajectory import Trajectory

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
    span : float
        How long it lasts at the start, s.
    """

    system: System
    t: ca.SX | np.ndarray
    weights: ca.SX | np.ndarray
    x: ca.SX
    theta: ca.SX
    settings: np.ndarray
    span: float

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


def refuse_moving_instants(system: System, varied: list[int]) -> None:
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
    span = float(run.t[-1] - run.t[0])
    return Discretisation(system, run.t, dt_of(run), none, theta, settings, span)


def dt_of(run: Trajectory) -> np.ndarray:
    """Weights of an integral by the trapezoid rule, s, shape (len(run.t),)."""
    weights = [np.zeros(0)]
    for piece in run.pieces:
        dt = np.diff(piece.t)
        weights.append(0.5 * (np.append(dt, 0.0) + np.insert(dt, 0, 0.0)))
    return np.concatenate(weights)


def run_at(run: Trajectory, theta: np.ndarray) -> Trajectory:
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
