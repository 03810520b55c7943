"""What is passed between two motions of a branch."""

from __future__ import annotations

import numpy as np

from lumped.orbits.borders import border_between
from lumped.orbits.branch_equations import BranchProblem, MissedError, Station
from lumped.orbits.continuation import Passed
from lumped.orbits.orbit import ON_CIRCLE
from lumped.orbits.segment import TESTS, Segment

_ON_CIRCLE = 10 * ON_CIRCLE
"""Distance from one within which multipliers do not tell whether disturbances grow."""
_CLOSE = 1e-6
"""Length of a segment that is not halved any more."""


def find_passed(problem: BranchProblem, segment: Segment) -> list[Passed]:
    """What is passed between two motions, in order."""
    a, b = segment.a, segment.b
    if a.events != b.events:
        border, before, after = border_between(segment)
        found = [border]
        if before.events == a.events and _apart(a, before):
            found = [*find_passed(problem, Segment(problem, a, before)), *found]
        if _apart(after, b):
            rest = find_passed(problem, Segment(problem, after, b))
            found += [each for each in rest if not _is_same(each, border)]
        return found
    found = []
    for kind, test in TESTS.items():
        if test(segment.a) * test(segment.b) < 0:
            station = segment.root(test)
            if station is not None and (kind != "Neimark-Sacker" or _is_torus(station)):
                found.append(Passed(kind, station))
    counts = _count_growing(a), _count_growing(b)
    if counts[0] is not None and counts[1] is not None:
        more, real = counts[1] - counts[0], sum(each.kind != "Neimark-Sacker" for each in found)
        if (more - real) % 2 or (more and not found):
            return _find_between(problem, segment, found)
    return sorted(found, key=lambda each: float(a.tangent @ ((each.station.z - a.z) / a.scale)))


def _count_growing(station: Station) -> int | None:
    """How many disturbances grow; None if one of them neither grows nor fades."""
    sizes = np.abs(station.multipliers)
    return None if (np.abs(sizes - 1) <= _ON_CIRCLE).any() else int((sizes > 1).sum())


def _find_between(problem: BranchProblem, segment: Segment, found: list[Passed]) -> list[Passed]:
    """What is passed in both halves of a segment whose ends differ by more than what was found.

    On a smooth branch multipliers are continuous: where another number of them is larger than
    one, a point is passed. If none is located, the change is named.
    """
    a, b = segment.a, segment.b
    if segment.length > _CLOSE:
        try:
            middle = segment.at(0.5 * segment.length)
            halves = Segment(problem, a, middle), Segment(problem, middle, b)
            return [each for half in halves for each in find_passed(problem, half)]
        except MissedError:
            pass
    words = f"stability changes after {a.value:.9g}; the point was not located"
    return [*found, Passed("change of stability", b, "", words)]


def _apart(a: Station, b: Station) -> bool:
    """Whether one motion is ahead of another."""
    return bool(a.tangent @ ((b.z - a.z) / a.scale) > 1e-8)


def _is_same(one: Passed, other: Passed) -> bool:
    """Whether two borders are one, at which symmetric events appear."""
    apart = np.linalg.norm((one.station.z - other.station.z) / one.station.scale)
    return one.component == other.component and bool(apart < 1e-8)


def _is_torus(station: Station) -> bool:
    """Whether a pair of multipliers on the unit circle is not real."""
    values = station.multipliers
    nearest = values[np.argmin(np.abs(np.abs(values) - 1))]
    return bool(abs(nearest.imag) > 1e-6)
