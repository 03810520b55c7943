"""Motions with low impacts, next to one that grazes a stop.

Near a motion that grazes, a period leaves ``J dz + sqrt(-g dz) w`` where it should leave nothing:
J are derivatives without the impact, ``g dz`` is how the lowest gap changes, and what the impact
adds is proportional to its speed (Nordmark, Journal of Sound and Vibration 145, 1991, 279). With
the root q as the length along them, motions with impacts are ``dz = q d`` with ``J d = -w`` and
``g d = 0``, up to squares of q.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from lumped.errors import ParameterError, SolverError
from lumped.gradients.instant_values import looks_of
from lumped.orbits.branch_equations import BranchProblem, MissedError, Station, correct_motion
from lumped.orbits.shooting import Guess, Shot, forward_by
from lumped.orbits.smooth_curves import curves_by, find_crossings
from lumped.simulation.simulate import simulate_led

_LOW = 1e-6
"""Length by which a motion is moved to see what a low impact does."""
_ASIDE = (1e-3, 1e-2, 1e-4)
"""Lengths of the branch at which a motion with impacts is looked for, in turn."""
_ROUNDS, _NEAR = 8, 1e-3
"""Tries to hit at a speed, and the share to which its square is met."""
_BESIDE = 100.0
"""Lengths of the branch, over the change of the parameter, within which motions are next."""
_CHANGES = (1e-4, 1e-3, 1e-5, 1e-2)
"""Parts of the range of the parameter within which the stop is not reached, in turn."""


@dataclass(frozen=True, eq=False)
class _Grazing:
    """A motion that grazes.

    Attributes
    ----------
    problem : BranchProblem
        What must repeat.
    station : Station
        The motion.
    course : Function
        The gap with its rates.
    time : float
        When it is lowest, s.
    """

    problem: BranchProblem
    station: Station
    course: ca.Function
    time: float

    def shoot_beside(self, aside: np.ndarray) -> Shot:
        """The run of a motion beside it, by unknowns over the scale."""
        old = self.station.guess
        z = self.station.z + self.station.scale * aside
        guess = self.problem.guess(z, old, old.point.settings)
        return Shot(self.problem.orbits, guess)

    def square(self, shot: Shot) -> float:
        """Square of the speed at which the stop is hit then; zero if it is not."""
        hits = [hit for hit in find_crossings(curves_by(self.course, shot.run)) if hit[1] < 0]
        if not hits:
            return 0.0
        _, rate = min(hits, key=lambda hit: abs(hit[0] - self.time))
        return rate**2


def with_low_impacts(
    problem: BranchProblem, station: Station, course: ca.Function, row: int, time: float
) -> Station | None:
    """A motion with a low impact next to one that grazes; None if none is found.

    Parameters
    ----------
    course : Function
        The gap with its rates.
    row : int
        Its margin.
    time : float
        When it is lowest, s.
    """
    here = _Grazing(problem, station, course, time)
    k = len(problem.orbits.active)
    try:
        gap = _slopes_of_gap(problem, station, row, time)
        size = float(np.linalg.norm(gap))
        normal = gap / size
        beside, root = -_LOW * normal, np.sqrt(_LOW * size)
        shot = here.shoot_beside(beside)
        hardness = here.square(shot) / root**2
        if not hardness > 0:
            return None
        impact = -station.matrix @ beside
        impact[:k] += shot.residuals * shot.size / station.scale[:k] * np.sqrt(k)
        both = np.vstack([station.matrix, normal])
        along = np.linalg.solve(both, np.append(-impact / root, 0.0))
    except (SolverError, ParameterError, np.linalg.LinAlgError):
        return None
    length = float(np.linalg.norm(along))
    for wanted in _ASIDE:
        root = wanted / length
        try:
            guess = _hitting(here, root * along, gap / size**2, root**2, hardness)
            found = correct_motion(problem, guess, station.scale, normal, None, along / length)
        except (SolverError, ParameterError):
            continue
        if len(found.events) > len(station.events):
            return found
    return None


def without_impact(problem: BranchProblem, station: Station) -> Station | None:
    """A motion that does not reach the stop next to one with a low impact; None if none is found.

    Its tangent leads away from the other.
    """
    count = len(station.events)
    row, old = np.eye(len(station.z))[-1], station.guess
    for change in _CHANGES:
        for way in (1.0, -1.0):
            aside = way * change * station.scale * row
            try:
                guess = problem.guess(station.z + aside, old, old.point.settings)
                found = correct_motion(problem, guess, station.scale, row, None, way * row)
            except (SolverError, ParameterError):
                continue
            apart = np.linalg.norm((found.z - station.z) / station.scale)
            if len(found.events) < count and apart < _BESIDE * change:
                return found
    return None


def _slopes_of_gap(problem: BranchProblem, station: Station, row: int, time: float) -> np.ndarray:
    """Derivatives of the lowest gap by the unknowns over the scale."""
    orbits, point = problem.orbits, station.guess.point
    system, k = orbits.system, len(orbits.active)
    run = simulate_led(system, until=time, start=point, grid=None, rtol=orbits.rtol)
    places = problem.places
    forward = forward_by(orbits, places, point.theta)
    begin = np.zeros((len(point.x), forward.k))
    begin[orbits.active, np.arange(k)] = 1.0
    courses = forward.at_end(run, begin)
    last, looks = run.pieces[-1], looks_of(system)
    values = looks.at(last.x[-1], run.theta, time, last.settings[-1])
    by_states, by_parameters = np.split(looks.margin_slopes(values, row), [len(point.x)])
    slopes = by_states @ courses + by_parameters @ forward.seed
    slopes[k:] /= forward.seed[list(places), k + np.arange(len(places))]
    if problem.orbits.free and problem.follows is None:
        slopes = np.insert(slopes, k, 0.0)
    found: np.ndarray = slopes * station.scale
    return found


def _hitting(
    here: _Grazing, aside: np.ndarray, lower: np.ndarray, wanted: float, hardness: float
) -> Guess:
    """A motion beside one that grazes, moved until it hits the stop at a speed.

    Parameters
    ----------
    aside, lower : ndarray, shape (m,)
        Where to begin, and what lifts the lowest gap by one, in unknowns over the scale.
    wanted, hardness : float
        By how much the lowest gap would be below the stop, and the square of the speed over that.

    Raises
    ------
    MissedError
        If it is not hit at that speed.
    """
    aside = aside - wanted * lower
    for _ in range(_ROUNDS):
        shot = here.shoot_beside(aside)
        missed = wanted - here.square(shot) / hardness
        if abs(missed) <= _NEAR * wanted:
            return shot.guess
        aside = aside - missed * lower
    raise MissedError("the stop is not hit at a low speed")
