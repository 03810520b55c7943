"""Quantities over the instants of a run as expressions of a design, with states as unknowns."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.numerics.collocation import fractions, phase
from lumped.numerics.nlp import Programme
from lumped.orbits.guesses import drifting, needs_time
from lumped.orbits.orbit import PeriodicOrbit
from lumped.points.start_slopes import start_slopes
from lumped.timeloop.clocks import clocks
from lumped.timeloop.results.trajectory import Trajectory

_CLOSED = 1e-9
_SHORTEST = 0.2
"""Of an unknown period, over that at the start."""
_TURNS, _SAME_RATES = 1e-6, 1e-7
"""Gain of a state, over its size, from which it turns; change of rates that is none."""


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


def smooth(run: Trajectory) -> None:
    """Refuse a run with changes of modes or impacts, by name."""
    changes = [e for e in run.events if e.kind != "time"]
    if changes:
        first = changes[0]
        raise OptionError(
            f"{run.system.name}: optimise follows smooth runs only, but at t = {first.time:.6g} s "
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


@dataclass(frozen=True, eq=False)
class Repeating:
    """What repeats.

    Attributes
    ----------
    advance : ndarray, shape (n,)
        By what each state grows in a period.
    active : ndarray of int, shape (k,)
        States that must repeat; the others begin where they are.
    phase : ndarray, shape (k,)
        What fixes the phase of a motion of unknown period; empty if the period is known.
    clock : int or None
        Place of the parameter that is the period.
    """

    advance: np.ndarray
    active: np.ndarray
    phase: np.ndarray
    clock: int | None


def collocate(
    programme: Programme,
    run: Trajectory,
    theta: ca.SX,
    varied: list[int],
    intervals: int,
    repeats: Repeating | None,
) -> Discretisation:
    """States of a run as unknowns that follow their equations; None for a start that is held."""
    system = run.system
    pieces = [piece for piece in run.pieces if piece.t[-1] > piece.t[0]]
    for piece in pieces:
        if piece.system is not system:
            raise OptionError(
                f"{system.name}: states change places during the run (see run.events); this is "
                "not followed. Use single shooting: give optimise the system."
            )
    sizes = np.abs(run.x).max(axis=0, initial=0.0)
    sizes[sizes == 0] = 1.0
    first = pieces[0].x[0]
    held = np.ones(len(first), dtype=bool)
    if repeats is None:
        _refuse_varied_start(run, varied)
    else:
        held[repeats.active] = False
    end = ca.SX(float(run.t[-1]))
    if repeats is not None and repeats.clock is not None:
        end = theta[repeats.clock]
    elif repeats is not None and repeats.phase.any():
        T = float(run.t[-1])
        end = programme.unknown(T, T, _SHORTEST * T, T / _SHORTEST)
    low = np.where(held, first, -np.inf) / sizes
    high = np.where(held, first, np.inf) / sizes
    now = begin = programme.unknown(first / sizes, 1.0, low, high) * ca.DM(sizes)
    phases, settings = [], []
    for piece in pieces:
        first_t, last_t = float(piece.t[0]), float(piece.t[-1])
        times = first_t + (last_t - first_t) * fractions(intervals)
        guess = np.array([np.interp(times[1:], piece.t, column) for column in piece.x.T])
        inside = programme.unknown((guess / sizes[:, None]).T).reshape((len(first), -1))
        x = ca.horzcat(now, inside * ca.repmat(ca.DM(sizes), 1, len(times) - 1))
        own = np.array([np.interp(times, piece.t, column) for column in piece.settings.T])
        own = own.reshape(-1, len(times)).T
        columns = ca.repmat(theta, 1, len(times))
        span = ca.SX(first_t), (end if piece is pieces[-1] else ca.SX(last_t)) - first_t
        phases.append(phase(programme, system, x, columns, own, span, sizes))
        settings.append(own)
        now = x[:, -1]
    if repeats is not None:
        missed = (now - begin - ca.DM(repeats.advance)) / ca.DM(sizes)
        for i in repeats.active.tolist():
            text = f"{system.state_names[i]} after a period, less its turn and its start, scaled"
            programme.constrain(text, missed[i], 0.0, 0.0)
        if repeats.phase.any():
            away = ((begin - ca.DM(first)) / ca.DM(sizes))[repeats.active.tolist()]
            weights = repeats.phase * sizes[repeats.active]
            programme.constrain(
                "phase of the motion", ca.dot(ca.DM(weights / np.linalg.norm(weights)), away), 0, 0
            )
    t, weights = (
        ca.vertcat(*parts) for parts in zip(*((p.t, p.weights) for p in phases), strict=True)
    )
    fixed = not ca.symvar(t)
    return Discretisation(
        system,
        np.asarray(ca.DM(t)).ravel() if fixed else t,
        np.asarray(ca.DM(weights)).ravel() if fixed else weights,
        ca.horzcat(*(p.x for p in phases)),
        theta,
        np.concatenate(settings),
        float(run.t[-1] - run.t[0]),
    )


def repeating(run: Trajectory) -> Repeating:
    """What repeats in a run over one period: states that turn gain what leaves all rates the same.

    Raises
    ------
    OptionError
        If nothing prescribes the period.
    """
    system, first, last = run.system, run.pieces[0], run.pieces[-1]
    if not needs_time(system, run.theta):
        raise OptionError(
            f"optimise: no function of time acts on {system.name}, so nothing holds the period "
            "while the design changes. Give the motion that lumped.periodic returns, in place of "
            "its run."
        )
    gain = last.x[-1] - first.x[0]
    size = np.maximum(np.abs(run.x).max(axis=0, initial=0.0), 1e-300)
    turning = (np.abs(gain) > _TURNS * size) & ~np.isin(
        system.structure.states, list(system.structure.cyclic)
    )
    advance = np.zeros(len(gain))
    for i in np.flatnonzero(turning):
        shifted = np.array(first.x.T)
        shifted[i] += gain[i]
        rest = (run.theta, first.t[None, :], first.settings.T)
        before, after = (np.asarray(system.rhs(x, *rest)) for x in (first.x.T, shifted))
        if np.abs(after - before).max() <= _SAME_RATES * np.abs(before).max():
            advance[i] = gain[i]
    return Repeating(advance, np.flatnonzero(~drifting(system, advance)), np.zeros(0), None)


def of_orbit(orbit: PeriodicOrbit) -> Repeating:
    """What repeats in a periodic motion, of unknown period unless a parameter is free for it."""
    problem, phase = orbit.problem, orbit.found.guess.phase
    unknown = problem.free and not orbit.free
    return Repeating(
        problem.advance, problem.active, phase if unknown else phase[:0], problem.clock
    )


def _refuse_varied_start(run: Trajectory, varied: list[int]) -> None:
    """Refuse start values that depend on what is varied."""
    system = run.system
    seed = np.zeros((len(run.theta), len(varied)))
    seed[varied, np.arange(len(varied))] = 1.0
    slopes = start_slopes(system, run.theta, None, 0.0, seed, {})[1]
    moving = np.argwhere(slopes != 0)
    if len(moving):
        state, column = moving[0]
        name = next(n for n in system.parameters if system.places([n])[0] == varied[column])
        raise OptionError(
            f"{system.name}: the start value of {system.state_names[state]} depends on {name}. "
            "Give the states start values of their own, or ask for periodic=True."
        )
