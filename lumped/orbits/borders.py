"""Borders of a branch: where what happens in a period changes, as a margin touches zero."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.orbits.branch_equations import CLOSELY, BranchProblem, MissedError, Station
from lumped.orbits.continuation import Ahead, Passed
from lumped.orbits.low_impacts import with_low_impacts, without_impact
from lumped.orbits.segment import Segment
from lumped.orbits.smooth_curves import (
    Curve,
    Extreme,
    course,
    curves_by,
    find_crossings,
    inner_lows,
)
from lumped.simulation.simulate import simulate_led
from lumped.support.made_once import made_once

_AHEAD = 0.8
"""Part of the way to the border that is gone at once."""
_NEAR, _TOUCHES, _CLOSE = 1e-10, 1e-6, 0.1
"""Of its range: a margin at the border; one that touches it; one that may, where a branch ends."""
_FALLS = 0.9
"""Part of its size before to which a probe nearer to the border brings a margin that touches."""
_LEVEL = 1e-9
"""Rate of a margin, over its range, that is as good as zero, 1/s."""
_BESIDE = (1e-6, 1e-4, 1e-2)
"""Parts of the way at which the other side of a border is looked for."""
_APART = 0.1
"""Part of the way between two motions which those at a border between them may be apart."""
_KINDS = {
    (True, True): ("grazing", "the gap closes for an instant"),
    (True, False): ("sticking", "the slip is zero for an instant"),
    (False, True): ("opening", "the reaction reaches its limit for an instant"),
    (False, False): ("slipping", "the reaction reaches its limit for an instant"),
}
"""Kind and words of a margin of a hold: whether it slides, and has a gap."""
_PROBES = 60
"""Motions after which the search for a border ends."""


@dataclass(frozen=True)
class _Margin:
    """A margin: its row, component and kind, and what it says in words.

    It touches zero, or crosses it at a rate that becomes zero.
    """

    row: int
    component: str
    kind: str
    words: str
    crosses: bool = False


def border_between(segment: Segment) -> tuple[Passed, Station, Station]:
    """The border between two motions with different events, and the motions next to it.

    It is approached from the side with fewer events, where the extreme of the margin is a smooth
    function of the length along the branch.

    Raises
    ------
    MissedError
        If the motions are of different branches.
    """
    a, b = segment.a, segment.b
    forth = len(a.events) <= len(b.events)
    clear, other = (a, b) if forth else (b, a)
    ends = (0.0, segment.length) if forth else (segment.length, 0.0)
    fewer, more = Counter(clear.events), Counter(other.events)
    names = {event[0] for event in (more - fewer) | (fewer - more)}
    margin = _touching(clear, names)
    near, beyond = _approach(segment.at, clear, ends, other, margin)
    if np.linalg.norm((beyond.z - near.z) / a.scale) > _APART * segment.length:
        raise MissedError("the motions found there are of another branch")
    if margin is None or _low(near, margin) > _TOUCHES:
        passed = Passed(_name_border(more - fewer), near, ", ".join(sorted(names)))
    else:
        passed = Passed(margin.kind, near, margin.component, margin.words)
    return (passed, near, beyond) if forth else (passed, beyond, near)


def _name_border(more: Counter[tuple[str, str, str]]) -> str:
    """What a border is beyond which more happens."""
    if any(after == "stuck" for _, _, after in more):
        return "sticking"
    return "slipping" if any(before == "stuck" for _, before, _ in more) else "switching"


def border_at_end(
    problem: BranchProblem, ahead: Ahead, last: Station, step: float
) -> tuple[Passed, tuple[Station, ...]] | None:
    """The border near the last of some motions, and motions from there on its other side.

    None if there is no border. Known are the other sides of the grazing of a stop.
    """
    for crosses in (False, True):
        margin = _touching(last, None, crosses)
        if margin is None or _low(last, margin) > _CLOSE:
            continue
        near, _ = _approach(partial(ahead, last, None), last, (0.0, step), None, margin)
        if _low(near, margin) > _TOUCHES:
            continue
        if margin.kind == "grazing":
            joined = (
                _impacts_end(problem, ahead, near, margin)
                if crosses
                else _impacts_begin(problem, near, margin)
            )
            if joined is not None:
                return joined
        return Passed(margin.kind, near, margin.component, margin.words), ()
    return None


def _impacts_begin(
    problem: BranchProblem, near: Station, margin: _Margin
) -> tuple[Passed, tuple[Station, ...]] | None:
    """From a motion that grazes on with low impacts; None if there are none."""
    function = _course(near.run.system, margin.row)
    lowest = min(_lows(curves_by(function, near.closely)))
    if not lowest.time:
        return None
    found = with_low_impacts(problem, near, function, margin.row, lowest.time)
    if found is None:
        return None
    passed = Passed(margin.kind, near, margin.component, margin.words)
    return passed, (_towards(near, near, found), found)


def _impacts_end(
    problem: BranchProblem, ahead: Ahead, near: Station, margin: _Margin
) -> tuple[Passed, tuple[Station, ...]] | None:
    """From a motion with low impacts on without them; None if there are none."""
    calm = without_impact(problem, near)
    if calm is None:
        return None
    back = replace(calm, tangent=-calm.tangent)
    length = 2 * float(np.linalg.norm((calm.z - near.z) / calm.scale))
    clear = replace(margin, crosses=False)
    grazing, _ = _approach(partial(ahead, back, None), back, (0.0, length), None, clear)
    if _low(grazing, clear) > _TOUCHES:
        return None
    passed = Passed(margin.kind, _towards(grazing, near, grazing), margin.component, margin.words)
    return passed, (replace(grazing, tangent=-grazing.tangent), calm)


def _towards(station: Station, a: Station, b: Station) -> Station:
    """A motion at which the branch has the direction from one to another."""
    apart = (b.z - a.z) / station.scale
    return replace(station, tangent=apart / np.linalg.norm(apart))


def _approach(
    at: Callable[[float], Station],
    clear: Station,
    ends: tuple[float, float],
    other: Station | None,
    margin: _Margin | None,
) -> tuple[Station, Station]:
    """Motions to both sides of a border, the first of them as near to it as possible."""
    near, far = ends
    width = far - near
    known: list[tuple[float, float]] = []
    if margin is not None:
        known.append((near, _low(clear, margin)))
    expected, ahead = far, _AHEAD
    for _ in range(_PROBES):
        if abs(far - near) <= 1e-11 * abs(width) or (known and known[-1][1] < _NEAR):
            break
        place = 0.5 * (near + far)
        if len(known) > 1:
            (s, h), (t, g) = known[-2:]
            root = t - g * (t - s) / (g - h) if g != h else far
            if (root - near) * (far - root) > 0:
                wrong, expected = abs(root - expected) / abs(root - near), root
                ahead = max(_AHEAD, 1 - max(1e-3, 2 * wrong))
                place = near + ahead * (root - near)
        try:
            tried = at(place)
        except MissedError:
            far = place
            continue
        if tried.events != clear.events:
            far, other = place, tried
            continue
        clear, near = tried, place
        if margin is not None:
            known.append((place, _low(tried, margin)))
            if known[-1][1] > _FALLS * known[-2][1]:
                margin, known = None, []  # this one does not touch zero there
    return clear, _beyond(at, clear, near, far, width) or other or clear


def _beyond(
    at: Callable[[float], Station], clear: Station, near: float, far: float, width: float
) -> Station | None:
    """The motion next to a border on its other side; None if none is found nearer than before."""
    for part in _BESIDE:
        place = near + part * width
        if abs(place - near) >= abs(far - near):
            return None
        try:
            tried = at(place)
        except MissedError:
            continue
        if tried.events != clear.events:
            return tried
    return None


def _touching(station: Station, names: set[str] | None, crosses: bool = False) -> _Margin | None:
    """The margin that is nearest to touching zero, or to crossing it at no rate."""
    margins = [m for m in _margins(station.run.system) if names is None or m.component in names]
    found = [replace(margin, crosses=crosses) for margin in margins]
    lows = [_low(station, margin) for margin in found]
    best = int(np.argmin(np.nan_to_num(lows, nan=np.inf))) if found else 0
    return found[best] if found and np.isfinite(lows[best]) else None


def _low(station: Station, margin: _Margin) -> float:
    """What is zero at a border, linear in the parameter near it; infinite if there is nothing.

    The lowest point of a margin inside the smooth parts, over its range, or the square of its rate
    where it crosses zero, over that range and the period.
    """
    system, guess = station.run.system, station.guess
    function = _course(system, margin.row)
    pieces = curves_by(function, station.closely)
    span = max((float(np.ptp(piece.y)) for piece in pieces), default=0.0)
    if not span:
        return np.inf
    if margin.crosses:
        squares = [(rate * guess.period / span) ** 2 for _, rate in find_crossings(pieces)]
        return min(squares, default=np.inf)
    lows = _lows(pieces)
    if not lows:
        return np.inf
    lowest = min(lows)
    if not lowest.time:
        return lowest.value / span
    run = simulate_led(system, until=lowest.time, start=guess.point, grid=None, rtol=CLOSELY)
    last = run.pieces[-1]
    exact = function(last.x[-1], run.theta, lowest.time, last.settings[-1])
    return float(exact[0]) / span


def _lows(pieces: list[Curve]) -> list[Extreme]:
    """The lowest points inside smooth parts, and at the begin of the period."""
    lows, span = inner_lows(pieces), max(float(np.ptp(piece.y)) for piece in pieces)
    if pieces[0].rate[0] >= -_LEVEL * span and pieces[-1].rate[-1] <= _LEVEL * span:
        lows.append(Extreme(float(pieces[0].y[0]), 0.0))
    return lows


@made_once
def _course(system: System, row: int) -> ca.Function:
    margins = system.structure.in_states(system.switching.margins[0])
    return course(system, margins[row])


@made_once
def _margins(system: System) -> tuple[_Margin, ...]:
    """All margins of a system."""
    switching, found = system.switching, []
    if not switching:
        return ()
    _ = switching.margins
    for row, (kind, number) in enumerate(switching.rows):
        if kind == "relation":
            name, text = switching.relation_text(number, 1.0)
            found.append(_Margin(row, name, "switching", text))
            continue
        name, has_gap = switching.names[number], bool(switching.has_gap[number])
        found.append(_Margin(row, name, *_KINDS[kind == "slide", has_gap]))
    return tuple(found)
