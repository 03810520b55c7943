"""Derivatives of a periodic motion by parameters."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.linalg import solve

from lumped.analysis.forward import Forward
from lumped.analysis.result import Trajectory
from lumped.analysis.shooting import Orbit, Problem, bordered
from lumped.errors import OptionError, UnknownNameError, nearest
from lumped.system import Name

__all__ = ["OrbitSensitivity", "orbit_sensitivity"]


@dataclass(frozen=True, eq=False)
class OrbitSensitivity:
    """Derivatives of an orbit; ``found["motor.w", "motor.J"]`` gives one over the times of its run.

    Times are understood as fractions of the period: ``t / period`` is kept while both change.

    Attributes
    ----------
    run : Trajectory
        One period.
    of, to : tuple of str
        What is differentiated, and by what.
    period : dict of str to float
        Derivatives of the period by each parameter; zero if it is prescribed.
    start : ndarray, shape (n, len(to))
        Derivatives of the states at the start of the period.
    values : ndarray, shape (len(run.t), len(of), len(to))
        Derivatives of the quantities.
    evaluations : int
        Evaluations of the right-hand side with its derivatives.
    """

    run: Trajectory
    of: tuple[str, ...]
    to: tuple[str, ...]
    period: dict[str, float]
    start: np.ndarray
    values: np.ndarray
    evaluations: int

    def __getitem__(self, pair: tuple[Name, Name]) -> np.ndarray:
        places = []
        for name, known in zip(pair, (self.of, self.to), strict=True):
            key = self.run.system.key(name)
            if key not in known:
                raise UnknownNameError(f"'{key}' is not in this sensitivity. {nearest(key, known)}")
            places.append(known.index(key))
        found: np.ndarray = self.values[:, places[0], places[1]]
        return found

    def __repr__(self) -> str:
        by = ", ".join(f"{name}: {value:.6g}" for name, value in self.period.items())
        return (
            f"{self.run.system.name}: derivatives of {', '.join(self.of)} by {', '.join(self.to)} "
            f"along a periodic motion, {self.evaluations} evaluations; of the period by {by}"
        )


def orbit_sensitivity(
    problem: Problem,
    orbit: Orbit,
    run: Trajectory,
    of: tuple[Name, ...],
    to: tuple[Name, ...],
) -> OrbitSensitivity:
    """Implicit function theorem on what must vanish after a period.

    Raises
    ------
    OptionError
        If `of` or `to` is empty.
    UnknownNameError
        If a name in `to` is no parameter that can be changed.
    """
    if not of or not to:
        raise OptionError("sensitivity: name at least one quantity in `of` and parameter in `to`.")
    system, active, T = problem.system, problem.active, orbit.guess.period
    names = tuple(system.key(name) for name in of)
    places = system.places(to)
    k, n = len(active), len(system.states)
    scale = np.abs(run.theta[places])
    scale[scale == 0] = 1.0
    seed = np.zeros((len(run.theta), k + len(places)))
    seed[places, k + np.arange(len(places))] = scale
    forward = Forward(system, seed, problem.rtol)
    begin = np.hstack([np.eye(n)[:, active], np.zeros((n, len(places)))])
    courses, _ = forward.courses(run, begin)
    last = run.pieces[-1]
    point = (last.x[-1], run.theta, T, last.settings[-1])
    rate = np.asarray(system.rhs(*point)).ravel()[active]
    right = -courses[-1][-1][active][:, k:]
    if problem.free:
        right = np.vstack([right, np.zeros(len(places))])
    found = solve(bordered(problem, orbit, rate), right)
    moved, stretch = found[:k], found[k] if problem.free else np.zeros(len(places))
    columns = forward.along(run, courses, names)
    values = columns[:, :, :k] @ moved + columns[:, :, k:]
    values += _rates(run, names)[:, :, None] * (run.t / T)[:, None, None] * stretch
    start = np.zeros((n, len(places)))
    start[active] = moved / scale
    keys = tuple(system.key(name) for name in to)
    by = dict(zip(keys, (stretch / scale).tolist(), strict=True))
    return OrbitSensitivity(run, names, keys, by, start, values / scale, forward.evaluations)


def _rates(run: Trajectory, names: tuple[str, ...]) -> np.ndarray:
    """Time derivatives of quantities, shape (len(run.t), len(names))."""
    system = run.system
    x, _, t, _ = system._inputs
    along = ca.vertcat(system.rates, 1)
    rate = ca.jtimes(system.expressions(names), ca.vertcat(x, t), along)
    function = ca.Function("rates", system._inputs, [ca.densify(rate)])
    found = [
        np.asarray(function(piece.x.T, run.theta, piece.t[None, :], piece.settings.T)).T
        for piece in run.pieces
        if len(piece.t)
    ]
    return np.concatenate(found)
