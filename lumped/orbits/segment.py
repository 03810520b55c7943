"""The branch of periodic motions between two motions, and tests of what is passed there."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from functools import partial

import numpy as np
import scipy

from lumped.orbits.branch_equations import (
    BranchProblem,
    MissedError,
    Station,
    correct_motion,
    in_phase,
    take_motion,
)

_ASIDE = 0.1
"""Part of the length of a segment by which its motions may be beside its cubic."""
_LEAST_ROUNDS, _ROUNDS, _NARROWER = 2, 7, 0.1
"""Rounds in which a segment around a point becomes shorter, and its new ends beside that."""


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

    def near(self, place: float) -> Station:
        """The motion that the cubic tells, as it is, with its direction."""
        a = self.a
        guess = self.problem.guess(
            in_phase(a, a.z + a.scale * self.cubic(place)), a.guess, a.guess.point.settings
        )
        return take_motion(self.problem, guess, a.scale, self.cubic(place, 1))

    def root(self, test: Callable[[Station], float]) -> Station | None:
        """Where a test is zero that differs in sign at the ends; None if it jumps there.

        At a branch point nothing determines a motion beside the branch. It is taken from the cubic
        through motions to both sides, which come so near that it misses no more than they do.
        """
        try:
            segment = self
            for number in range(_ROUNDS):
                place = scipy.optimize.brentq(
                    partial(_test_at, segment, test), 0.0, segment.length, xtol=1e-12, rtol=1e-13
                )
                found = segment.near(place)
                missed = np.abs(found.orbit.residuals).max()
                if number >= _LEAST_ROUNDS and missed <= self.problem.orbits.rtol:
                    break
                segment = segment.narrow(place, test)
        except MissedError:
            return None
        ends = min(abs(test(self.a)), abs(test(self.b)))
        return found if abs(test(found)) < 1e-3 * ends or ends == 0 else None

    def narrow(self, place: float, test: Callable[[Station], float]) -> Segment:
        """The part of it around a place in which a test changes its sign."""
        aside = _NARROWER * self.length
        inner = [p for p in (place - aside, place + aside) if 0 < p < self.length]
        stations = [self.a, *map(self.at, inner), self.b]
        for one, other in itertools.pairwise(stations):
            if test(one) * test(other) <= 0:
                return Segment(self.problem, one, other)
        raise MissedError("a test does not change its sign")


def _test_at(segment: Segment, test: Callable[[Station], float], place: float) -> float:
    if place in (0.0, segment.length):
        return test(segment.b if place else segment.a)
    return test(segment.near(place))


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


TESTS = {
    "fold": _fold,
    "branch point": _crossing,
    "period doubling": _doubling,
    "Neimark-Sacker": _torus,
}
"""Functions of a motion that pass zero there."""
