"""From motion to motion along a branch, and what is passed on the way."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy

from lumped.errors import ParameterError
from lumped.flattening.hold_modes import PARTED
from lumped.orbits.branch_equations import (
    BranchProblem,
    MissedError,
    Station,
    correct_motion,
    in_phase,
)
from lumped.orbits.shooting import sizes
from lumped.timeloop.plants.executable import evaluate_at

_FIRST, _LEAST = 0.2, 1e-7
"""First step over the longest; the shortest in lengths of the branch."""
_NEAR = 1e-2
"""Part of the longest step, below which the reason is looked for why there is no motion."""
_FURTHER = 2.0
"""Lengths of a segment up to which its cubic tells what is beyond."""
_ASIDE = 0.1
"""Part of the length of a segment by which its motions may be beside its cubic."""
_AT_BEGIN = 1e-2
"""Part of the period within which an event may pass its begin."""
_ANGLE = 0.25
"""By which the direction may change from motion to motion, rad."""
_FEW, _MANY = 3, 5
"""Newton steps up to which the next step is longer, and above which it is shorter."""


@dataclass(frozen=True, eq=False)
class Passed:
    """What is passed on a branch.

    Attributes
    ----------
    kind : str
        What it is.
    station : Station
        The motion there.
    component : str
        What changes, at a border.
    words : str
        More about it.
    """

    kind: str
    station: Station
    component: str = ""
    words: str = ""


@dataclass(frozen=True, eq=False)
class Course:
    """Motions in the order of a branch, and what is passed at which of them.

    Attributes
    ----------
    stations : list of Station
        Motions.
    passed : dict of int to Passed
        By the number of the motion.
    ended : str
        Why there is no more.
    """

    stations: list[Station]
    passed: dict[int, Passed]
    ended: str


class Segment:
    """The branch between two motions, by the length along the tangent at the first.

    Attributes
    ----------
    cubic : CubicHermiteSpline
        Through both ends, in unknowns over the scale of the first, from there.
    """

    def __init__(self, problem: BranchProblem, a: Station, b: Station) -> None:
        self.problem, self.a, self.b = problem, a, b
        apart = (b.z - a.z) / a.scale
        self.length = float(a.tangent @ apart)
        if not self.length > 0:
            raise MissedError("no motion is found ahead")
        end = b.tangent * b.scale / a.scale
        slopes = a.tangent, end / (a.tangent @ end)
        self.cubic = scipy.interpolate.CubicHermiteSpline(
            [0.0, self.length], [np.zeros(len(apart)), apart], slopes
        )

    def at(self, place: float) -> Station:
        """The motion at a place from 0 to `length`."""
        a = self.a
        z = in_phase(a, a.z + a.scale * self.cubic(place))
        guess = self.problem.guess(z, a.guess, a.guess.point.settings)
        along, matrix = self.cubic(place, 1), a.matrix
        if a.events == self.b.events:
            matrix = a.matrix + place / self.length * self.change(a.scale)
        return correct_motion(self.problem, guess, a.scale, a.tangent, matrix, along)

    def change(self, scale: np.ndarray) -> np.ndarray:
        """By how much the Jacobian changes from end to end, the row of the phase aside."""
        found: np.ndarray = self.b.in_scale(scale) - self.a.in_scale(scale)
        found[len(self.a.monodromy) :] = 0.0
        return found

    def with_value(self, value: float) -> Station:
        """The motion at a value of the parameter between those of both ends."""
        a = self.a

        def missing(place: float) -> float:
            return float(a.z[-1] + a.scale[-1] * self.cubic(place)[-1] - value)

        place = scipy.optimize.brentq(missing, 0.0, self.length)
        z = a.z + a.scale * self.cubic(place)
        z[-1] = value
        row = np.eye(len(z))[-1]
        guess = self.problem.guess(z, a.guess, a.guess.point.settings)
        matrix = a.matrix if a.events == self.b.events else None
        found = correct_motion(self.problem, guess, a.scale, row, matrix, self.cubic(place, 1))
        # at a border, motions between are those with more events
        fewer = len(found.events) < max(len(a.events), len(self.b.events))
        if fewer or np.linalg.norm((found.z - z) / a.scale) > _ASIDE * self.length:
            raise MissedError("the motion found there is of another branch")
        return found

    def root(self, test: Callable[[Station], float]) -> Station | None:
        """Where a test is zero that differs in sign at the ends; None if it jumps there."""
        known: dict[float, Station] = {0.0: self.a, self.length: self.b}

        def value(place: float) -> float:
            if place not in known:
                known[place] = self.at(place)
            return test(known[place])

        try:
            place = scipy.optimize.brentq(value, 0.0, self.length, xtol=1e-10, rtol=1e-13)
        except MissedError:
            return None
        found = known[place] if place in known else self.at(place)
        ends = min(abs(test(self.a)), abs(test(self.b)))
        return found if abs(test(found)) < 1e-3 * ends or ends == 0 else None


def _fold(station: Station) -> float:
    return float(station.tangent[-1])


def _doubling(station: Station) -> float:
    k = len(station.monodromy)
    return float(np.linalg.det(station.monodromy + np.eye(k)))


def _torus(station: Station) -> float:
    values = station.multipliers
    one, other = np.triu_indices(len(values), 1)
    return float(np.prod(values[one] * values[other] - 1).real)


def _crossing(station: Station) -> float:
    return float(np.linalg.det(np.vstack([station.matrix, station.tangent])))


Ahead = Callable[[Station, Segment | None, float], Station]
"""Gives the motion so far ahead of another, after the segment before it if that is known."""

TESTS = {
    "fold": _fold,
    "branch point": _crossing,
    "period doubling": _doubling,
    "Neimark-Sacker": _torus,
}
"""Functions of a motion that pass zero there."""


def follow_branch(
    problem: BranchProblem,
    first: Station,
    direction: int,
    longest: float,
    most: int,
    passed: Callable[[Segment], list[Passed]],
    at_end: Callable[[Ahead, Station, float], tuple[Passed, tuple[Station, ...]] | None],
) -> Course:
    """Motions from the first on, until the range of the parameter ends, or the branch.

    Parameters
    ----------
    direction : {1, -1}
        Along the tangent of the first or against it.
    longest : float
        Longest step, in lengths of the branch.
    most : int
        Number of motions after which it ends.
    passed : callable
        What is passed between two motions.
    at_end : callable
        The border near the last motion, by motions ahead of it up to where there is none, and
        motions from there on its other side.
    """
    last = replace(first, tangent=direction * first.tangent)
    course = Course([last], {}, "")
    step = _FIRST * longest
    before: Segment | None = None
    joined: Station | None = None
    while len(course.stations) <= most:
        bound = None
        try:
            segment = Segment(problem, last, _ahead(problem, last, before, step))
            turned = _measure_turn(segment)
            if turned > 2 * _ANGLE and segment.b.events == last.events and step > 100 * _LEAST:
                step = 0.5 * step
                continue
            bound = problem.find_bound(segment.b.value)
            if bound is not None:
                if abs(bound - last.value) < _LEAST * (problem.high - problem.low):
                    return replace(course, ended=problem.explain_end(bound))
                segment = Segment(problem, last, segment.with_value(bound))
            between = passed(segment)
        except MissedError as fault:
            failed, step = step, 0.5 * step
            if failed > _NEAR * longest:
                continue
            beyond = _past_begin(problem, last, failed)
            if beyond is not None:
                course.stations.append(beyond)
                last, before, step = beyond, None, _FIRST * longest
                continue
            found = at_end(partial(_ahead, problem), last, failed)
            if found is not None:
                border, others = found
                course.passed[len(course.stations)] = border
                course.stations.append(border.station)
                if others and last is not joined:
                    bound = problem.find_bound(others[-1].value)
                    if bound is not None:
                        return replace(course, ended=problem.explain_end(bound))
                    course.stations.extend(others)
                    last = joined = others[-1]
                    before, step = None, _FIRST * longest
                    continue
                text = f"{border.kind} of {border.component}; no motion near was found beyond"
                return replace(course, ended=f"{text} ({fault})")
            if step < _LEAST:
                return replace(course, ended=f"no motion near the last was found ({fault})")
            continue
        for each in between:
            course.passed[len(course.stations)] = each
            course.stations.append(each.station)
        now = segment.b
        course.stations.append(now)
        if bound is not None:
            return replace(course, ended=problem.explain_end(bound))
        if len(course.stations) > 5 and _is_back(first, segment):
            return replace(course, ended="the branch is closed")
        last, before = now, segment if now.events == last.events else None
        count = now.orbit.iterations
        change = 0.7 if count > _MANY else 1.4 if count <= _FEW else 1.0
        step = min(longest, step * min(change, max(0.5, _ANGLE / max(turned, 1e-9))))
    return replace(course, ended=f"{most} motions were found; more with most=")


def _ahead(problem: BranchProblem, last: Station, before: Segment | None, step: float) -> Station:
    """The motion so far ahead, guessed along the tangent or on the cubic of the segment before."""
    z, matrix = last.z + step * last.scale * last.tangent, last.matrix
    if before is not None and step < _FURTHER * before.length:
        a = before.a
        place = before.length + step * float(a.tangent @ (last.tangent * last.scale / a.scale))
        z = in_phase(last, a.z + a.scale * before.cubic(place))
        matrix = matrix + step / before.length * before.change(last.scale)
    try:
        guess = problem.guess(z, last.guess, last.guess.point.settings)
    except ParameterError as error:
        raise MissedError(str(error)) from None
    return correct_motion(problem, guess, last.scale, last.tangent, matrix, last.tangent)


def _past_begin(problem: BranchProblem, last: Station, step: float) -> Station | None:
    """The motion ahead if an event passes the begin of the period, where states jump with it."""
    active, period, pieces = problem.orbits.active, last.guess.period, last.run.pieces
    system, theta = last.run.system, last.run.theta
    begins = []  # states beside the event, on its other side, and into which direction of time
    if len(pieces) > 1 and pieces[0].t[-1] < _AT_BEGIN * period:
        begins.append((pieces[1], 0, 0.0, 1.0))
    if len(pieces) > 1 and pieces[-1].t[0] > (1 - _AT_BEGIN) * period:
        begins.append((pieces[-2], -1, 1.0, -1.0))
    row = np.eye(len(last.z))[-1]
    along = row * np.copysign(1.0, last.tangent[-1])
    if begins and problem.orbits.free and not problem.orbits.advance.any():
        found = _begin_elsewhere(problem, last, row, along)
        if found is not None:
            return found
    for (piece, i, turns, way), aside in itertools.product(begins, (1e-4, 1e-3, 1e-2)):
        modes = piece.settings[i].copy()
        modes[system.switching.first_modes + PARTED] = 0.0
        rate = np.asarray(system.rhs(piece.x[i], theta, piece.t[i], modes)).ravel()
        x = piece.x[i] - turns * problem.orbits.advance + way * aside * period * rate
        for times in (1, 8, 64, 512):
            z = last.z + times * step * last.scale * last.tangent
            z[: len(active)] = x[active]
            try:
                guess = problem.guess(z, last.guess, modes)
                found = correct_motion(problem, guess, last.scale, row, None, along)
            except (MissedError, ParameterError):
                continue
            if found.events == last.events:
                return found
    return None


def _begin_elsewhere(
    problem: BranchProblem, last: Station, row: np.ndarray, along: np.ndarray
) -> Station | None:
    """The same motion, begun in the middle of its longest smooth part, as nothing fixes that."""
    orbits, theta = problem.orbits, last.run.theta
    piece = max(last.run.pieces, key=lambda piece: float(piece.t[-1] - piece.t[0]))
    middle = int(np.searchsorted(piece.t, 0.5 * (piece.t[0] + piece.t[-1])))
    x, modes = piece.x[middle], piece.settings[middle].copy()
    modes[orbits.system.switching.first_modes + PARTED] = 0.0
    rate = evaluate_at(orbits.system, "rates", x, theta, 0.0, modes)[orbits.active]
    z = last.z.copy()
    z[: len(orbits.active)] = x[orbits.active]
    phase = rate / sizes(orbits, last.run.x) ** 2
    try:
        guess = replace(problem.guess(z, last.guess, modes), phase=phase)
        found = correct_motion(problem, guess, last.scale, row, None, along)
    except MissedError:
        return None
    return found if found.events == last.events else None


def _measure_turn(segment: Segment) -> float:
    """Angle between the directions at both ends."""
    a, b = segment.a, segment.b
    end = b.tangent * b.scale / a.scale
    return float(np.arccos(np.clip(a.tangent @ end / np.linalg.norm(end), -1, 1)))


def _is_back(first: Station, segment: Segment) -> bool:
    """Whether a segment passes the first motion again."""
    a, b = segment.a, segment.b
    from_a, from_b = ((first.z - s.z) / a.scale for s in (a, b))
    passes = (a.tangent @ from_a) * (a.tangent @ from_b) < 0
    near = np.linalg.norm(from_a - (a.tangent @ from_a) * a.tangent)
    return bool(passes and near < 0.1 * segment.length)
