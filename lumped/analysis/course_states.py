"""The run of a system with states as a course of unknowns."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.analysis.collocation import fractions, phase
from lumped.analysis.course import Course, measured
from lumped.analysis.functionals import Designed
from lumped.analysis.nlp import Programme
from lumped.analysis.result import OperatingPoint, Trajectory
from lumped.analysis.simulate import simulate
from lumped.analysis.start import start_slopes
from lumped.errors import OptionError

__all__ = ["collocated", "measured_well", "simulated"]

_RTOL = 1e-10
_DOUBLINGS, _SAME = 8, 1e-9


def collocated(
    programme: Programme,
    run: Trajectory,
    theta: ca.SX,
    varied: list[int],
    intervals: int,
    periodic: bool,
) -> Course:
    """States of a run as unknowns that follow their equations."""
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
    if periodic:
        held = np.isin(system.states, list(system.cyclic))
    else:
        held = np.ones(len(first), dtype=bool)
        _fixed_start(run, varied)
    low = np.where(held, first, -np.inf) / sizes
    high = np.where(held, first, np.inf) / sizes
    now = begin = programme.unknown(first / sizes, 1.0, low, high) * ca.DM(sizes)
    phases, settings = [], []
    for piece in pieces:
        span = float(piece.t[0]), float(piece.t[-1] - piece.t[0])
        times = span[0] + span[1] * fractions(intervals)
        guess = np.array([np.interp(times[1:], piece.t, column) for column in piece.x.T])
        inside = programme.unknown((guess / sizes[:, None]).T).reshape((len(first), -1))
        x = ca.horzcat(now, inside * ca.repmat(ca.DM(sizes), 1, len(times) - 1))
        own = np.array([np.interp(times, piece.t, column) for column in piece.settings.T])
        own = own.reshape(-1, len(times)).T
        columns = ca.repmat(theta, 1, len(times))
        both = (ca.SX(span[0]), ca.SX(span[1]))
        phases.append(phase(programme, system, x, columns, own, both, sizes))
        settings.append(own)
        now = x[:, -1]
    if periodic:
        free = np.flatnonzero(~held).tolist()
        programme.constrain("periodic states", ((now - begin) / ca.DM(sizes))[free], 0.0, 0.0)
    return Course(
        system,
        np.concatenate([np.asarray(ca.DM(p.t)).ravel() for p in phases]),
        np.concatenate([np.asarray(ca.DM(p.weights)).ravel() for p in phases]),
        ca.horzcat(*(p.x for p in phases)),
        theta,
        np.concatenate(settings),
    )


def _fixed_start(run: Trajectory, varied: list[int]) -> None:
    """Refuse start values that depend on what is varied."""
    system = run.system
    seed = np.zeros((len(run.theta), len(varied)))
    seed[varied, np.arange(len(varied))] = 1.0
    slopes = start_slopes(system, run.theta, {}, seed, {})[1]
    moving = np.argwhere(slopes != 0)
    if len(moving):
        state, column = moving[0]
        name = next(n for n in system.parameters if system.places([n])[0] == varied[column])
        raise OptionError(
            f"{system.name}: the start value of {system.state_names[state]} depends on {name}. "
            "Give the states start values of their own, or ask for periodic=True."
        )


def simulated(
    run: Trajectory, theta: np.ndarray, t: np.ndarray, x: np.ndarray, settings: np.ndarray
) -> Trajectory:
    """An ordinary run from the states found, with as many output times as there are nodes."""
    point = OperatingPoint(run.system, 0.0, x[:, 0], theta, settings[0])
    return simulate(run.system, until=float(t[-1]), start=point, grid=len(t) - 1, rtol=_RTOL)


def measured_well(run: Trajectory, functionals: list[Designed]) -> list[float]:
    """Functionals of a run, its output times doubled until they stay the same."""
    found = [measured(functional, run) for functional in functionals]
    point, count, until = run.point(run.t[0]), len(run.t), float(run.t[-1])
    for _ in range(_DOUBLINGS if functionals else 0):
        count, before = 2 * count, found
        finer = simulate(run.system, until=until, start=point, grid=count, rtol=_RTOL)
        found = [measured(functional, finer) for functional in functionals]
        if np.allclose(found, before, rtol=_SAME, atol=0.0):
            break
    return found
