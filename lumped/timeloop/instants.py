"""Instants at which functions of time change their piece, all found before a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.numerics.interval_bounds import INFINITE
from lumped.support.made_once import Recent, made_once
from lumped.timeloop.clocks import Clock, clock_parameters, clocks, plain_clocks
from lumped.timeloop.results.event import Event

_MOST = 300_000
"""Parts of a run that are looked at together in the search for the changes of one condition."""

_NARROWEST = 1e-14
"""Relative width of a part of a run in which a change is not looked for any closer."""

_HALVINGS = 64

_INSIDE = (0.5, 0.31, 0.83)
"""Where a part without changes is looked at; two of three points do not touch a border."""


@dataclass(frozen=True, eq=False)
class Instants:
    """Instants in a span, and the modes between them.

    Attributes
    ----------
    times : ndarray, shape (k,)
        Instants after the begin of the span, up to its end.
    edges : ndarray, shape (k + 2,)
        Begin of the span, the instants, and its end.
    events : tuple of Event
        What changes at them: the components, and their pieces before and after in words; nothing
        where nobody needs to know.
    places : ndarray of int, shape (m,)
        Modes that depend on the time alone.
    modes : ndarray, shape (k + 1, m)
        Their values before the first instant, between two, and after the last.
    """

    times: np.ndarray
    edges: np.ndarray
    events: tuple[Event, ...]
    places: np.ndarray
    modes: np.ndarray


def instants(
    system: System,
    theta: np.ndarray,
    begin: float,
    end: float,
    without: frozenset[int] = frozenset(),
) -> Instants:
    """All instants between two times at which functions of time change their piece.

    Clocks whose numbers are in `without` never change, and their modes are zero.

    Raises
    ------
    SolverError
        If they follow each other without end.
    """
    if not clocks(system):
        edges = np.array([begin, end], dtype=float)
        return Instants(np.zeros(0), edges, (), np.zeros(0, dtype=int), np.zeros((1, 0)))
    key = theta[clock_parameters(system)].tobytes(), begin, end, without
    return _latest(system).of(
        key, lambda: _InstantSearch(system, theta, begin, end, without).find()
    )


@made_once
def _latest(system: System) -> Recent[Instants]:
    """Instants found last."""
    return Recent(1)


def _together(time: float, changes: list[tuple[str, str, str]]) -> Event:
    """Components that change at one instant, each once, and their pieces before and after."""
    names, before, after = (", ".join({change[i]: None for change in changes}) for i in range(3))
    return Event(time, names, "time", before, after)


@dataclass(frozen=True, eq=False)
class _Course:
    """Pieces of one clock over the span: where it changes, and its numbers between."""

    times: np.ndarray
    numbers: np.ndarray

    def at(self, times: np.ndarray) -> np.ndarray:
        return self.numbers[np.searchsorted(self.times, times, side="right")]


@dataclass(eq=False)
class _InstantSearch:
    """A search; arguments as for `instants`."""

    system: System
    theta: np.ndarray
    begin: float
    end: float
    without: frozenset[int]

    def find(self) -> Instants:
        """All instants, with those that rounding alone keeps apart in one."""
        self.clocks = clocks(self.system)
        courses: list[_Course] = []
        plain = self._plain()
        for k, clock in enumerate(self.clocks):
            if k in self.without:
                courses.append(_Course(np.zeros(0), np.zeros(1, dtype=int)))
                continue
            needs = [courses[i] for i in clock.needs]
            courses.append(plain[k] if k in plain else self._course(clock, needs))
        times = np.unique(np.concatenate([np.zeros(0), *(c.times for c in courses)]))
        apart = 1e-13 * max(abs(self.begin), abs(self.end))
        times = times[(times > self.begin) & (times <= self.end)]
        times = np.where(self.end - times <= apart, self.end, times)
        kept = np.append(True, np.diff(times) > apart) if len(times) else np.zeros(0, dtype=bool)
        times = times[kept]
        edges = np.concatenate([[self.begin], times, [self.end]])
        # the last part has no length if something changes at the end
        middles = 0.5 * (edges[:-1] + edges[1:])
        if len(times) and times[-1] == self.end:
            middles[-1] = self.end + apart
        words: list[list[tuple[str, str, str]]] = [[] for _ in times]
        columns = [np.zeros((len(middles), 0))]
        changes: list[np.ndarray] = []
        for clock, course in zip(self.clocks, courses, strict=True):
            numbers = course.at(middles)
            columns.append(clock.settings(numbers))
            changes.append(np.diff(numbers) != 0)
            # what changes because another does is not named
            first = changes[-1].copy()
            for need in clock.needs:
                first &= ~changes[need]
            where = np.flatnonzero(first & clock.condition.relation.told)
            if len(where):
                name, texts = clock.condition.name, clock.condition.texts
                pairs = zip(texts(numbers[where]), texts(numbers[where + 1]), strict=True)
                for k, (before, after) in zip(where.tolist(), pairs, strict=True):
                    words[k].append((name, before, after))
        places = [m for clock in self.clocks for m in clock.condition.modes]
        events = map(_together, times.tolist(), words)
        told = tuple(event for event in events if event.component)
        return Instants(times, edges, told, np.array(places, dtype=int), np.hstack(columns))

    def _plain(self) -> dict[int, _Course]:
        """Courses of relations that are linear in the time and need no others, all at once."""
        which, function = plain_clocks(self.system)
        if not which:
            return {}
        zero, slope = function(0.0, self.theta)
        found = {}
        for k, at_zero, rate in zip(which, zero.tolist(), slope.tolist(), strict=True):
            instant = -at_zero / rate if rate else np.inf
            if self.begin < instant <= self._beyond():
                found[k] = _Course(np.array([instant]), np.array([int(rate < 0), int(rate > 0)]))
            else:
                middle = np.array([at_zero + rate * 0.5 * (self.begin + self.end)])
                found[k] = _Course(np.zeros(0), self.clocks[k].number(middle))
        return found

    def _course(self, clock: Clock, needs: list[_Course]) -> _Course:
        """Where a clock changes; what it needs is known."""
        inner = np.unique(np.concatenate([np.zeros(0), *(c.times for c in needs)]))
        inner = inner[(inner > self.begin) & (inner < self.end)]
        # a little beyond the end, as the modes there may be asked for
        edges = np.concatenate([[self.begin], inner, [self._beyond()]])
        middles = 0.5 * (edges[:-1] + edges[1:])
        columns = [
            self.clocks[i].settings(c.at(middles)) for i, c in zip(clock.needs, needs, strict=True)
        ]
        given = np.hstack([np.zeros((len(middles), 0)), *columns])
        if clock.even:
            roots = self._even(clock, edges, given)
        elif clock.moves:
            roots = self._uneven(clock, edges, given)
        else:
            roots = np.zeros(0)
        times = np.unique(np.concatenate([inner, roots]))
        bounds_ = np.concatenate([[self.begin], times, [self._beyond()]])
        segment = np.searchsorted(inner, 0.5 * (bounds_[:-1] + bounds_[1:]), side="right")
        inside = bounds_[:-1] + np.outer(_INSIDE, np.diff(bounds_))
        place, _ = self._values(clock, inside.ravel(), np.tile(given[segment], (len(_INSIDE), 1)))
        numbers = np.sort(clock.number(place).reshape(inside.shape), axis=0)[1]
        changes = np.diff(numbers) != 0
        return _Course(times[changes], np.append(numbers[0], numbers[1:][changes]))

    def _beyond(self) -> float:
        return self.end + 1e-9 * max(self.end - self.begin, 1e-300)

    def _values(
        self, clock: Clock, times: np.ndarray, given: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Argument, below all if it is not a number, and slope at times, with the modes there."""
        found = clock.value(times[None, :], given.T, self.theta) if len(times) else [()] * 2
        place, slope = (np.asarray(v, dtype=float).ravel() for v in found)
        return np.where(np.isnan(place), -np.inf, place), slope

    def _even(self, clock: Clock, edges: np.ndarray, given: np.ndarray) -> np.ndarray:
        """Changes of an argument that is linear in the time."""
        zero, slope = self._values(clock, np.zeros(len(given)), given)
        found = []
        for k in np.flatnonzero(slope != 0).tolist():
            ends = zero[k] + slope[k] * edges[k : k + 2]
            first, last = np.sort(clock.number(ends))
            borders = clock.border(np.arange(first + 1, last + 1))
            found.append((borders - zero[k]) / slope[k])
        roots = np.concatenate([np.zeros(0), *found])
        if len(roots) > _MOST:
            raise self._endless(clock, float(roots.min()))
        return roots[(roots > self.begin) & (roots <= self._beyond())]

    def _uneven(self, clock: Clock, edges: np.ndarray, given: np.ndarray) -> np.ndarray:
        """Changes of any argument: intervals decide between none, one, and looking closer."""
        a, b, segment = edges[:-1], edges[1:], np.arange(len(given))
        found = [np.zeros(0)]
        size = max(abs(self.begin), abs(self.end))
        total = 0
        while len(a):
            total += len(a)
            if len(a) > _MOST or total > 20 * _MOST:
                raise self._endless(clock, float(a.min()))
            (low, high), monotone = self._range(clock, a, b, given[segment])
            count = self._borders(clock, low, high)
            narrow = b - a <= _NARROWEST * size
            one = (count > 0) & (monotone | narrow)
            if one.any():
                found.append(self._locate(clock, a[one], b[one], given[segment[one]]))
            more = (count > 0) & ~one
            a, b, segment = a[more], b[more], segment[more]
            middle = 0.5 * (a + b)
            a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
            segment = np.concatenate([segment, segment])
        return np.concatenate(found)

    def _range(
        self, clock: Clock, a: np.ndarray, b: np.ndarray, given: np.ndarray
    ) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
        """Bounds of the argument in intervals, and where it only rises or only falls."""
        ends = (
            np.asarray(end, dtype=float).ravel()
            for end in clock.bounds(a[None, :], b[None, :], given.T, self.theta)
        )
        low, high, falling, rising = (
            np.where(np.abs(end) < INFINITE, end, np.copysign(np.inf, end)) for end in ends
        )
        if clock.steps:
            return (low, high), np.zeros(len(a), dtype=bool)
        middle, _ = self._values(clock, 0.5 * (a + b), given)
        reach = 0.5 * (b - a) * np.fmax(np.abs(falling), np.abs(rising))
        known = np.isfinite(reach) & np.isfinite(middle)
        low = np.where(known, np.fmax(low, middle - reach), low)
        high = np.where(known, np.fmin(high, middle + reach), high)
        return (low, high), (falling >= 0) | (rising <= 0)

    @staticmethod
    def _borders(clock: Clock, low: np.ndarray, high: np.ndarray) -> np.ndarray:
        """How many borders lie inside bounds, at most two."""
        if clock.condition.pieces is None:
            return ((low < 0) & (high > 0)).astype(int)
        wide = ~(np.isfinite(low) & np.isfinite(high))
        first = clock.number(np.where(wide, 0.0, low))
        last = clock.number(np.where(wide, 0.0, high))
        return np.where(wide, 2, np.minimum(last - first, 2))

    def _locate(self, clock: Clock, a: np.ndarray, b: np.ndarray, given: np.ndarray) -> np.ndarray:
        """Changes in intervals in which the argument only rises or only falls."""
        first = clock.number(self._values(clock, a, given)[0])
        last = clock.number(self._values(clock, b, given)[0])
        low, count = np.minimum(first, last), np.abs(last - first)
        if count.sum() > _MOST:
            raise self._endless(clock, float(a.min()))
        owner = np.repeat(np.arange(len(a)), count)
        before = np.concatenate([[0], np.cumsum(count)])[:-1]
        wanted = low[owner] + 1 + np.arange(len(owner)) - before[owner]
        rising = (last > first)[owner]
        a, b, given = a[owner], b[owner], given[owner]
        for _ in range(_HALVINGS):
            middle = 0.5 * (a + b)
            reached = clock.number(self._values(clock, middle, given)[0]) >= wanted
            after = reached == rising
            a, b = np.where(after, a, middle), np.where(after, middle, b)
            if (b - a <= np.spacing(np.abs(b))).all():
                break
        return b

    def _endless(self, clock: Clock, near: float) -> SolverError:
        condition = clock.condition
        left, right = condition.relation.sides
        return SolverError(
            f"{self.system.name}: '{left}' passes {right} in {condition.name} more than {_MOST} "
            f"times between {self.begin:g} and {self.end:g} s, first near t = {near:.6g} s, so not "
            "all instants of its changes can be found before the run. Shorten the run, or write "
            "lumped.ops.smooth(...) around the expression if its kinks do not matter.",
            None,
        )
