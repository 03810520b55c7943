"""From motion to motion along a branch, and what is passed on the way."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from lumped.errors import ParameterError
from lumped.flattening.hold_modes import PARTED
from lumped.orbits.branch_equations import (
    BranchProblem,
    MissedError,
    Station,
    correct_motion,
    in_phase,
)
from lumped.orbits.segment import Segment
from lumped.orbits.shooting import sizes
from lumped.timeloop.plants.executable import evaluate_at

_FIRST, _LEAST = 0.2, 1e-7
"""First step over the longest; the shortest in lengths of the branch."""
_NEAR = 1e-2
"""Part of the longest step, below which the reason is looked for why there is no motion."""
_FURTHER = 2.0
"""Lengths of a segment up to which its cubic tells what is beyond."""
_BESIDE = 0.02
"""Part of a step by which a motion may be beside where it was expected, or is of another branch."""
_PARALLEL = 0.95
"""Cosine of the angle of directions up to which a branch is said to come back."""
_AT_BEGIN = 1e-2
"""Part of the period within which an event may pass its begin."""
_ANGLE = 0.25
"""By which the direction may change from motion to motion, rad."""
_RECENT = 5
"""Motions at the end to which a branch does not come back."""
_FEW, _MANY = 3, 5
"""Newton steps up to which the next step is longer, and above which this one is shorter."""


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


Ahead = Callable[[Station, Segment | None, float], Station]
"""Gives the motion so far ahead of another, after the segment before it if that is known."""


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
            turned, now = _measure_turn(segment), segment.b
            beside = np.linalg.norm((now.z - _expect(last, before, step)[0]) / last.scale) / step
            far = turned > 2 * _ANGLE or beside > _BESIDE or now.orbit.iterations > _MANY
            if far and now.events == last.events and step > 100 * _LEAST:
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
        back = _find_back(course.stations[:-_RECENT], segment)
        if back is not None:
            again = "is closed" if back == 0 else "comes back to motions that it has passed"
            return replace(course, ended=f"the branch {again}")
        last, before = now, segment if now.events == last.events else None
        count = now.orbit.iterations
        change = 0.7 if count > _MANY else 1.4 if count <= _FEW else 1.0
        step = min(longest, step * min(change, max(0.5, _ANGLE / max(turned, 1e-9))))
    return replace(course, ended=f"{most} motions were found; more with most=")


def _expect(last: Station, before: Segment | None, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Unknowns so far ahead, on the tangent or the cubic of the segment before; the Jacobian."""
    z, matrix = last.z + step * last.scale * last.tangent, last.matrix
    if before is not None and step < _FURTHER * before.length:
        a = before.a
        place = before.length + step * float(a.tangent @ (last.tangent * last.scale / a.scale))
        z = in_phase(last, a.z + a.scale * before.cubic(place))
        matrix = matrix + step / before.length * before.change(last.scale)
    return z, matrix


def _ahead(problem: BranchProblem, last: Station, before: Segment | None, step: float) -> Station:
    """The motion so far ahead."""
    z, matrix = _expect(last, before, step)
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


def _find_back(stations: list[Station], segment: Segment) -> int | None:
    """Number of the motion that a segment passes again, in the same direction or against it."""
    a, slack = segment.a, 0.1 * segment.length
    for i, first in enumerate(stations):
        from_a, from_b = ((first.z - s.z) / a.scale for s in (a, segment.b))
        along = a.tangent @ from_a
        if along > -slack and a.tangent @ from_b < slack:
            way = first.tangent * first.scale / a.scale
            parallel = abs(a.tangent @ way) > _PARALLEL * np.linalg.norm(way)
            if parallel and np.linalg.norm(from_a - segment.cubic(along)) < slack:
                return i
    return None
