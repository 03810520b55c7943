"""The equations of periodic motions in which a parameter is unknown too, and their solution."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from lumped.errors import ParameterError, SolverError
from lumped.orbits.shooting import (
    Guess,
    Orbit,
    OrbitProblem,
    Shot,
    forward_by,
    in_modes,
    refuse_beyond,
    refuse_rest,
    slopes_of,
)
from lumped.simulation.simulate import simulate_led
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Trajectory

_ITERATIONS = 9
"""Newton steps after which a point is given up."""
_SLOW = 0.3
"""Part to which a step reduces what is missed with derivatives that are good enough."""
_ROUNDING = 1e-13
"""Relative size of steps that rounding leaves."""


_FINE, CLOSELY = 400, 1e-11
"""Output intervals and tolerance of a run in which the lowest points of margins are looked for."""


class MissedError(SolverError):
    """No motion was found near a guess."""


@dataclass(frozen=True, eq=False)
class BranchProblem:
    """What must repeat, and what is unknown beside the states.

    Attributes
    ----------
    orbits : OrbitProblem
        What must repeat.
    place : int
        Place of the parameter that changes along the branch.
    follows : int or None
        Place of the parameter that is found such that the period stays; None if there is none.
    law : (float, int) or None
        The period is a factor times a power of the parameter, 1 or -1; None if nothing prescribes
        it or it stays.
    low, high : float
        Range of the parameter.
    """

    orbits: OrbitProblem
    place: int
    follows: int | None
    law: tuple[float, int] | None
    low: float
    high: float

    @property
    def places(self) -> tuple[int, ...]:
        """Places of the parameters that are unknown."""
        return (self.place,) if self.follows is None else (self.follows, self.place)

    def period(self, value: float, before: float) -> float:
        """Period that the parameter prescribes, s; else that before."""
        return before if self.law is None else self.law[0] * value ** self.law[1]

    def stretch(self, value: float) -> float:
        """Derivative of the prescribed period by the parameter."""
        factor, power = self.law or (0.0, 1)
        return factor * power * value ** (power - 1)

    def find_bound(self, value: float) -> float | None:
        """The end of the range beyond which a value lies; None if it lies within."""
        if value > self.high:
            return self.high
        return self.low if value < self.low else None

    def explain_end(self, bound: float) -> str:
        """Why a branch ends there, in words."""
        which = "greatest" if bound == self.high else "least"
        return f"the {which} value that was asked for is reached"

    def unknowns(self, guess: Guess) -> np.ndarray:
        """Active states, the period or what follows if it is unknown, the parameter."""
        theta = guess.point.theta
        more = [theta[self.place]]
        if self.orbits.free:
            more.insert(0, guess.period if self.follows is None else theta[self.follows])
        return np.concatenate([guess.point.x[self.orbits.active], more])

    def guess(self, z: np.ndarray, old: Guess, modes: np.ndarray) -> Guess:
        """The same as a guess, in some modes.

        Raises
        ------
        ParameterError
            If a parameter leaves its range.
        """
        k = len(self.orbits.active)
        x, theta, value = old.point.x.copy(), old.point.theta.copy(), float(z[-1])
        x[self.orbits.active] = z[:k]
        theta[self.place] = value
        if self.follows is not None:
            theta[self.follows] = z[k]
        period = self.period(value, old.period)
        if self.orbits.free and self.follows is None:
            period = float(z[k])
        old.point.system.check_parameters(theta)
        settings = in_modes(old.point, modes)
        return Guess(OperatingPoint(old.point.system, 0.0, x, theta, settings), period, old.phase)


@dataclass(frozen=True, eq=False)
class Station:
    """A motion on a branch.

    Attributes
    ----------
    guess : Guess
        Where and how long it is.
    z : ndarray, shape (m,)
        Unknowns.
    scale : ndarray, shape (m,)
        By which lengths along the branch are measured: a state counts by its size.
    matrix : ndarray, shape (m - 1, m)
        Jacobian of what is missed, in unknowns over `scale`.
    tangent : ndarray, shape (m,)
        Direction of the branch, in unknowns over `scale`, of length one.
    multipliers : ndarray of complex
        Floquet multipliers without that of a shift in time.
    orbit : Orbit
        The motion as found.
    """

    guess: Guess
    z: np.ndarray
    scale: np.ndarray
    matrix: np.ndarray
    tangent: np.ndarray
    multipliers: np.ndarray
    orbit: Orbit

    @property
    def run(self) -> Trajectory:
        """One period, at the steps of the solver."""
        return self.orbit.run

    @cached_property
    def closely(self) -> Trajectory:
        """One period at many points, for what happens between steps."""
        guess = self.guess
        return simulate_led(
            self.run.system, until=guess.period, start=guess.point, grid=_FINE, rtol=CLOSELY
        )

    @property
    def monodromy(self) -> np.ndarray:
        """Derivatives of the active states after a period, shape (k, k)."""
        return self.orbit.monodromy

    @property
    def value(self) -> float:
        """The parameter."""
        return float(self.z[-1])

    def in_scale(self, scale: np.ndarray) -> np.ndarray:
        """The Jacobian in unknowns over another scale."""
        k = len(self.monodromy)
        found: np.ndarray = self.matrix * (scale / self.scale)
        found[:k] *= (self.scale / scale)[:k, None]
        return found

    @property
    def events(self) -> tuple[tuple[str, str, str], ...]:
        """What happens in a period, begun anywhere: component, mode before and after."""
        found = [(e.component, e.before, e.after) for e in self.run.events if e.after]
        turned = [tuple(found[i:] + found[:i]) for i in range(len(found))]
        return min(turned, default=())


def correct_motion(
    problem: BranchProblem,
    guess: Guess,
    scale: np.ndarray,
    row: np.ndarray,
    matrix: np.ndarray | None,
    along: np.ndarray,
) -> Station:
    """The motion near a guess in the hyperplane through it, by Newton's method.

    Allgower and Georg, Introduction to Numerical Continuation Methods, 2003, ch. 7: derivatives
    of a motion nearby, updated by Broyden's formula, do until steps shrink too slowly.

    Parameters
    ----------
    scale, row : ndarray, shape (m,)
        Scale of the unknowns, and what is normal to the hyperplane in these.
    matrix : ndarray, shape (m - 1, m), optional
        Jacobian of a motion nearby, in unknowns over `scale`.
    along : ndarray, shape (m,)
        About the direction of the branch, in unknowns over `scale`.

    Raises
    ------
    MissedError
        If there is none.
    """
    orbits = problem.orbits
    z = problem.unknowns(guess)
    k, right = len(orbits.active), np.zeros(len(z))
    try:
        shot = Shot(orbits, guess)
        fresh = matrix is None
        if matrix is None:
            matrix = _slopes(problem, shot, scale)[0]
        before = np.inf
        for iteration in range(_ITERATIONS + 1):
            size = scale[:k] / np.sqrt(k)
            right[:k] = -shot.residuals * shot.size / size
            missed = float(np.abs(shot.residuals).max())
            own = matrix[:k, :k] / np.sqrt(k) + np.eye(k)
            amplified = orbits.rtol * max(1.0, float(np.abs(own).max()))
            if missed <= orbits.rtol or (fresh and missed <= amplified):
                return _station(problem, shot, along, scale, iteration)
            if iteration == _ITERATIONS:
                break
            if not fresh and missed > _SLOW * before:
                matrix, fresh = _slopes(problem, shot, scale)[0], True
            before = missed
            step = np.linalg.solve(np.vstack([matrix, row]), right)
            if not np.isfinite(step).all() or np.abs(step).max() > 1.0:
                break
            z = z + step * scale
            shot = Shot(orbits, problem.guess(z, shot.guess, shot.settings))
            now = shot.residuals * shot.size / size
            matrix = matrix.copy()
            matrix[:k] += np.outer(now, step) / (step @ step)
            fresh = False
    except ParameterError as error:
        raise MissedError(str(error)) from None
    except np.linalg.LinAlgError:
        raise MissedError("the equations are singular") from None
    except SolverError as error:
        raise MissedError(str(error).partition(": ")[2] or str(error)) from None
    raise MissedError("Newton's method does not converge")


def take_motion(
    problem: BranchProblem, guess: Guess, scale: np.ndarray, along: np.ndarray
) -> Station:
    """A motion as it is, and a direction of the branch that does not come from its equations.

    Raises
    ------
    MissedError
        If there is none.
    """
    try:
        found = _station(problem, Shot(problem.orbits, guess), along, scale, 0)
    except (SolverError, ParameterError) as error:
        raise MissedError(str(error).partition(": ")[2] or str(error)) from None
    tangent = along * scale / found.scale
    return replace(found, tangent=tangent / np.linalg.norm(tangent))


def in_phase(station: Station, z: np.ndarray) -> np.ndarray:
    """Unknowns near those of a motion, with its phase."""
    k = len(station.monodromy)
    row, apart = station.guess.phase * station.scale[:k], (z - station.z)[:k] / station.scale[:k]
    if not row.any():
        return z
    found = z.copy()
    found[:k] -= station.scale[:k] * row * (row @ apart) / (row @ row)
    return found


def tangent_of(matrix: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Direction of the branch from the Jacobian there, of length one, not against another."""
    rows = np.linalg.svd(matrix)[2]
    found: np.ndarray = rows[-1] * (1 if rows[-1] @ along >= 0 else -1)
    return found


def _slopes(problem: BranchProblem, shot: Shot, scale: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Jacobian of what is missed, the phase included, and the monodromy matrix."""
    orbits, k = problem.orbits, len(problem.orbits.active)
    places = problem.places
    forward = forward_by(orbits, places, shot.guess.point.theta)
    slopes = slopes_of(orbits, shot, forward)
    by = slopes[:, k:] / forward.seed[list(places), k + np.arange(len(places))]
    value = float(shot.guess.point.theta[problem.place])
    by[:, -1] += shot.rate * problem.stretch(value)
    if orbits.free and problem.follows is None:
        by = np.column_stack([shot.rate, by])
    monodromy = slopes[:, :k]
    size = scale[:k] / np.sqrt(k)
    matrix = np.hstack([monodromy - np.eye(k), by]) * scale / size[:, None]
    if orbits.free:
        phase = np.concatenate([shot.guess.phase, np.zeros(2)]) * scale
        matrix = np.vstack([matrix, phase / np.linalg.norm(phase)])
    return matrix, monodromy


def _station(
    problem: BranchProblem, shot: Shot, along: np.ndarray, scale: np.ndarray, iterations: int
) -> Station:
    orbits, k = problem.orbits, len(problem.orbits.active)
    refuse_rest(orbits, shot.run)
    first = shot.run.pieces[0].x[0]
    if np.abs(first - shot.guess.point.x)[orbits.active].max() > 1e-9:
        raise MissedError("states jump at the very start of the period")
    refuse_beyond(shot)
    z = problem.unknowns(shot.guess)
    matrix, monodromy = _slopes(problem, shot, scale)
    more = [problem.high - problem.low]
    if orbits.free:
        more.insert(0, abs(z[k]) or 1.0)
    own = np.concatenate([np.sqrt(k) * shot.size, more])
    columns = own / scale
    rows = np.ones(len(matrix))
    rows[:k] = scale[:k] / own[:k]
    matrix = matrix * columns * rows[:, None]
    values = np.linalg.eigvals(monodromy)
    values = values[np.argsort(-np.abs(values))]
    guess = shot.guess
    if orbits.free:
        values = np.delete(values, int(np.argmin(np.abs(values - 1))))
        if not orbits.advance.any():
            guess = replace(guess, phase=shot.rate / shot.size**2)
            row = np.concatenate([guess.phase, np.zeros(2)]) * own
            matrix[-1] = row / np.linalg.norm(row)
    # modes at the end are those in which the next period begins
    point = replace(guess.point, settings=in_modes(guess.point, shot.settings))
    guess = replace(guess, point=point)
    tangent = tangent_of(matrix, along / columns)
    condition = float(np.linalg.cond(matrix[:, :-1]))
    used = shot.run.statistics.evaluations
    orbit = Orbit(guess, shot.run, monodromy, shot.residuals, condition, iterations, used)
    return Station(guess, z, own, matrix, tangent, values, orbit)
