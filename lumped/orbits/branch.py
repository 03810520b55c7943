"""Branches of periodic motions over a parameter."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.errors import OptionError, SolverError
from lumped.orbits.borders import border_at_end
from lumped.orbits.branch_equations import BranchProblem, MissedError, Station, correct_motion
from lumped.orbits.branch_result import Branch, BranchPoint
from lumped.orbits.continuation import Course, Passed, follow_branch
from lumped.orbits.orbit import PeriodicOrbit
from lumped.orbits.passed_points import find_passed
from lumped.orbits.periodic import GRID, result_of
from lumped.orbits.segment import Segment
from lumped.orbits.shooting import Guess, sizes
from lumped.support.arguments import checked

_OFF = 1e-4
"""Distance from a branch point from which motions tell the direction of the branch."""
_ALIKE = 0.02
"""Part of its distance from a point by which a motion of another branch is beside the first."""
_ASIDE = (1e-2, 3e-3, 3e-2, 1e-3)
"""Lengths to go aside to a branch that crosses, in turn."""


@checked
def branch(
    orbit: PeriodicOrbit,
    *,
    along: Mapping[Name, tuple[float, float]],
    turns: float | None = None,
    step: float = 0.05,
    most: int = 1000,
) -> Branch:
    """Follow a periodic motion while a parameter changes, around folds, stable or not.

    Pseudo-arclength continuation of the shooting equations (Keller 1977; Allgower and Georg,
    Introduction to Numerical Continuation Methods, 2003, ch. 6): unknown are the states at the
    start of a period, the period if nothing prescribes it, and the parameter. Derivatives are
    exact, also across events. The branch is followed to both sides of the motion.

    What is passed is located: folds, branch points, period doublings and Neimark-Sacker points by
    functions that are zero there; borders, at which an event appears or vanishes, where the lowest
    value of a margin touches zero. Where a hard stop is grazed, derivatives are unbounded on the
    side with impacts; the branch goes on there with low ones (Nordmark 1991). At some other
    borders branches end.

    Parameters
    ----------
    orbit : PeriodicOrbit
        From `periodic`; a motion at a parameter within the range.
    along : mapping of name to (float, float)
        The parameter, and its least and greatest value, SI.
    turns : float, optional
        The parameter is the speed of what functions of time prescribe, rad/s, and the period so
        many turns of it, ``2 pi turns / speed``. Of an `orbit` whose period is a parameter, that
        may be the one to change without this.
    step : float
        Longest step, as part of the range of the parameter and of the size of the states.
    most : int
        Motions to each side after which it ends.

    Returns
    -------
    Branch

    Raises
    ------
    OptionError
        If the motion lies outside the range, is no orbit over `turns`, determines the parameter, or
        options make no sense.
    UnknownNameError
        If the name in `along` is no parameter that can be changed.
    SolverError
        If the motion cannot be found again.
    """
    if len(along) != 1:
        raise OptionError(f"branch: along = {dict(along)}: one parameter and its range.")
    ((name, between),) = along.items()
    problem = _problem(orbit, name, between, turns)
    if not 0 < step <= 1:
        raise OptionError(f"branch: step = {step!r}: a part between 0 and 1 is needed.")
    if most < 1:
        raise OptionError(f"branch: most = {most!r}: at least one motion.")
    guess = orbit.found.guess
    size = sizes(orbit.problem, orbit.run.x)
    more = [problem.high - problem.low]
    if problem.orbits.free:
        more.insert(0, abs(problem.unknowns(guess)[-2]) or 1.0)
    scale = np.concatenate([np.sqrt(len(size)) * size, more])
    row = np.eye(len(scale))[-1]
    try:
        first = correct_motion(problem, guess, scale, row, None, row)
    except MissedError as fault:
        raise SolverError(
            f"{orbit.system.name}: the motion to begin with was not found again at rtol = "
            f"{orbit.problem.rtol:g}: {fault}. Let periodic find it with tighter rtol.",
            orbit.run,
        ) from None
    return both_ways(problem, first, along=orbit.system.key(name), step=step, most=most)


def both_ways(
    problem: BranchProblem, first: Station, *, along: str, step: float, most: int
) -> Branch:
    """The branch to both sides of a motion."""
    at_end = partial(border_at_end, problem)
    back, forth = (
        follow_branch(problem, first, way, step, most, partial(find_passed, problem), at_end)
        for way in (-1, 1)
    )
    if forth.ended.startswith("the branch is closed"):
        back = Course(back.stations[:1], {}, forth.ended)
    turned = [replace(s, tangent=-s.tangent) for s in back.stations[:0:-1]]
    stations = [*turned, *forth.stations]
    shift = len(back.stations) - 1
    passed = {shift - i: each for i, each in back.passed.items() if i <= shift}
    passed |= {shift + i: each for i, each in forth.passed.items()}
    points = [_point(passed[i], i) for i in sorted(passed)]

    motions = _Motions(problem, tuple(stations), along, step, most)
    return Branch(
        problem.orbits.system,
        along,
        np.array([s.value for s in stations]),
        np.array([s.guess.period for s in stations]),
        np.array([s.multipliers for s in stations]),
        tuple(points),
        (back.ended, forth.ended),
        tuple(s.run for s in stations),
        motions.orbit,
        motions.at,
        motions.turn_off,
    )


@dataclass(frozen=True, eq=False)
class _Motions:
    """What was followed, from which whole motions and other branches are made."""

    problem: BranchProblem
    stations: tuple[Station, ...]
    along: str
    step: float
    most: int

    def orbit(self, number: int) -> PeriodicOrbit:
        return self._make_orbit(self.stations[number])

    def at(self, value: float) -> list[PeriodicOrbit]:
        found = []
        for i, (a, b) in enumerate(itertools.pairwise(self.stations)):
            if (a.value - value) * (b.value - value) < 0:
                try:
                    between = Segment(self.problem, a, b).with_value(value)
                except MissedError as fault:
                    system = self.problem.orbits.system
                    raise SolverError(
                        f"{system.name}: the motion with {self.along} = {value:.9g} "
                        f"{system.parameter_unit(self.along)} between motions {i} and {i + 1} of "
                        f"the branch was not found ({fault}). Take a value a little further from "
                        "the border there."
                    ) from None
                found.append(self._make_orbit(between))
            elif a.value == value:
                found.append(self._make_orbit(a))
        last = self.stations[-1]
        return found + [self._make_orbit(last)] * (last.value == value)

    def _make_orbit(self, station: Station) -> PeriodicOrbit:
        problem = self.problem
        found = result_of(problem.orbits, station.orbit, GRID)
        if problem.follows is None:
            return found
        free = problem.orbits.system.structure.parameters.free_names[problem.follows]
        return replace(found, free={free: float(found.run.theta[problem.follows])})

    def turn_off(self, number: int, kind: str) -> Branch:
        station = self.stations[number]
        if kind == "period doubling":
            other, start = _double_period(self.problem, station)
        else:
            sides = self.stations[number - 1 :: -1], self.stations[number + 1 :]
            around = [next((s for s in side if _lies_off(station, s)), station) for side in sides]
            other = self.problem
            start = _cross_branch(other, station, Segment(other, *around))
        return both_ways(other, start, along=self.along, step=self.step, most=self.most)


def _is_other(first: Segment, found: Station, apart: float) -> bool:
    """Whether a motion so far from a branch point is not of the branch through it."""
    a = first.a
    place = float(a.tangent @ ((found.z - a.z) / a.scale))
    beside = (found.z - a.z) / a.scale - first.cubic(place)
    near = -first.length < place < 2 * first.length
    return near and bool(np.linalg.norm(beside) > _ALIKE * apart)


def _point(passed: Passed, number: int) -> BranchPoint:
    station, kind = passed.station, passed.kind
    values = station.multipliers
    target = {"fold": 1.0, "branch point": 1.0, "period doubling": -1.0}
    if kind in target:
        multiplier = values[np.argmin(np.abs(values - target[kind]))]
    elif kind == "Neimark-Sacker":
        multiplier = values[np.argmin(np.abs(np.abs(values) - 1))]
    else:
        multiplier = values[0] if len(values) else 0.0
    return BranchPoint(
        kind,
        station.value,
        station.guess.period,
        number,
        complex(multiplier),
        passed.component,
        passed.words,
    )


def _problem(
    orbit: PeriodicOrbit, parameter: Name, between: tuple[float, float], turns: float | None
) -> BranchProblem:
    system, name = orbit.system, orbit.system.key(parameter)
    if name in orbit.free:
        raise OptionError(
            f"branch: this motion determines {name}, so that its period stays; take one without "
            "free=, whose period then changes along the branch."
        )
    (place,) = system.places([name])
    low, high = (float(v) for v in between)
    value = float(orbit.found.guess.point.theta[place])
    unit = system.parameter_unit(name)
    if not (np.isfinite([low, high]).all() and low < high):
        raise OptionError(
            f"branch: along = {{'{name}': ({low:g}, {high:g})}} {unit}: least, then greatest."
        )
    slack = 1e-9 * (high - low)
    if not low - slack <= value <= high + slack:
        raise OptionError(
            f"branch: the motion to begin with has {name} = {value:.9g} {unit}, outside of "
            f"({low:g}, {high:g}); find one there first: periodic(parameters={{'{name}': ...}})."
        )
    follows = None
    if orbit.free:
        (follows,) = system.places(list(orbit.free))
    if turns is not None:
        wanted = 2 * np.pi * turns / value if value else np.inf
        if orbit.problem.free or not abs(wanted / orbit.period - 1) < 1e-9:
            raise OptionError(
                f"branch: turns = {turns:g} of {name} = {value:.9g} {unit} take {wanted:.9g} s, "
                f"but the period of the motion is {orbit.period:.9g} s"
                + (", which nothing prescribes" if orbit.problem.free else "")
                + "; that is no period of it."
            )
    law = (1.0, 1) if orbit.problem.clock == place else None
    if turns is not None:
        law = (2 * np.pi * turns, -1)
    problem = BranchProblem(orbit.problem, place, follows, law, low, high)
    if law is None and not orbit.problem.free:
        _refuse_other_period(problem, orbit.found.guess, name)
    return problem


def _refuse_other_period(problem: BranchProblem, guess: Guess, name: str) -> None:
    """The period must stay one of the functions of time while the parameter changes."""
    point, rhs = guess.point, problem.orbits.system.rhs

    def jump(theta: np.ndarray) -> np.ndarray:
        ends = [np.asarray(rhs(point.x, theta, t, point.settings)) for t in (0.0, guess.period)]
        found: np.ndarray = np.abs(ends[1] - ends[0]) / (1e-300 + np.abs(ends).max())
        return found

    theta = point.theta.copy()
    theta[problem.place] += 1e-3 * (problem.high - problem.low)
    if jump(point.theta).max() < 1e-9 and jump(theta).max() > 1e-7:
        raise OptionError(
            f"branch: {guess.period:.9g} s is a period of the functions of time for {name} as it "
            f"is, not while it changes. If it is their speed, give turns=; if their period, find "
            f"the motion by periodic(period='{name}')."
        )


def _double_period(problem: BranchProblem, station: Station) -> tuple[BranchProblem, Station]:
    """What repeats after two periods, and a motion on its branch.

    It leaves along the eigenvector of the multiplier -1 (Kuznetsov, Elements of Applied Bifurcation
    Theory, 2004, sec. 10.3).

    Raises
    ------
    SolverError
        If none is found.
    """
    values, vectors = np.linalg.eig(station.monodromy)
    aside = np.zeros(len(station.z))
    k = len(station.monodromy)
    aside[:k] = vectors[:, np.argmin(np.abs(values + 1))].real / station.scale[:k]
    orbits = replace(problem.orbits, advance=2 * problem.orbits.advance, clock=None)
    law = None if problem.law is None else (2 * problem.law[0], problem.law[1])
    other = replace(problem, orbits=orbits, law=law)
    theta, old = station.guess.point.theta, station.guess
    period = other.period(float(theta[problem.place]), 2 * old.period)
    return other, _aside(other, station, Guess(old.point, period, old.phase), aside)


def _lies_off(station: Station, other: Station) -> bool:
    """Whether a motion is so far from another that both tell a direction."""
    return bool(np.linalg.norm((other.z - station.z) / station.scale) > _OFF)


def _cross_branch(problem: BranchProblem, station: Station, first: Segment) -> Station:
    """A motion on the other branch through a branch point of a segment of the first.

    The Jacobian has two directions without change there, one of them along the branch.

    Raises
    ------
    SolverError
        If none is found.
    """
    aside = scipy.linalg.svd(np.vstack([station.matrix, station.tangent]))[2][-1]
    return _aside(problem, station, station.guess, aside, first)


def _aside(
    problem: BranchProblem,
    station: Station,
    old: Guess,
    aside: np.ndarray,
    first: Segment | None = None,
) -> Station:
    """A motion beside another, in a direction in unknowns over the scale, and not of `first`."""
    aside = aside / np.linalg.norm(aside)
    z, scale = problem.unknowns(old), station.scale.copy()
    if problem.orbits.free and problem.follows is None:
        scale[-2] *= old.period / station.guess.period
    fault = ""
    for length in _ASIDE:
        try:
            guess = problem.guess(z + length * scale * aside, old, old.point.settings)
            found = correct_motion(problem, guess, scale, aside, None, aside)
        except MissedError as error:
            fault = str(error)
            continue
        if first is None or _is_other(first, found, float(np.linalg.norm((found.z - z) / scale))):
            return found
        fault = "those found are of the branch itself"
    raise SolverError(
        f"{problem.orbits.system.name}: no motion was found on the branch that crosses there"
        f"{f' ({fault})' if fault else ''}.",
        station.run,
    )
