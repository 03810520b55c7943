"""Smooth parts of a run: ends of its steps, and states there, made again where they are not kept.

Steps made again have the lengths of those of the run, and so their bits. Those of a long run are
dealt with in stretches, over the changes between its smooth parts.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Container, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lumped.compiler.system import System
from lumped.gradients.jumps import Crossing, Side
from lumped.gradients.spans import Span
from lumped.gradients.steps import Steps, steps_of
from lumped.points.start import run_start
from lumped.simulation.simulate import interruptible, recorder, run_on
from lumped.timeloop.leading_states import states_of
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder, SparingRecorder
from lumped.timeloop.results.trajectory import Piece, Trajectory
from lumped.timeloop.run_options import RunPlan

GRID = 1000
"""Intervals of a run without states, which has no steps."""

_KEPT_BYTES = 50_000_000
"""Size of the states that a run keeps for its derivatives, bytes, besides those at events."""

_MADE_BYTES = 25_000_000
"""Size of the states that are made again at once, bytes."""


class Leg:
    """A smooth part of a run.

    Attributes
    ----------
    t : ndarray
        Ends of its steps, s: those of the run, and those of the parts into which they are divided.
    """

    def __init__(self, run: Trajectory, piece: Piece) -> None:
        t, x, m = piece.t, piece.x, piece.settings
        new = t[1:] > t[:-1]
        if not new.all():
            t, x, m = (v[np.append(True, new)] for v in (t, x, m))
        self._run = run
        self.t = t if piece.ends is None else piece.ends
        self._of_run = np.arange(len(self.t))
        """Places of the ends of steps of the run."""
        self._kept = self._of_run if piece.ends is None else np.searchsorted(self.t, t)
        """Those of them at which states are known."""
        self._x = x
        self._m = m[:1] if (m == m[0]).all() else m

    def side(self, place: int) -> Side:
        """States and settings at an end of a step."""
        place %= len(self.t)
        return self.states(place, place)[0].copy(), self.settings(place, place)[0]

    def sides(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """States and settings at ends of steps, shapes (places, n) and (places, settings)."""
        if self._has_all:
            return self._x[places], self._settings_at(places)
        of_run = np.searchsorted(self._of_run, places)
        row = np.searchsorted(self._kept, of_run)
        is_kept = (self._of_run[of_run] == places) & (self._kept[row] == of_run)
        x = self._x[row]
        for k in np.flatnonzero(~is_kept).tolist():
            x[k] = self.states(places[k], places[k])[0]
        return x, self._settings_at(places)

    def states(self, begin: int = 0, end: int | None = None) -> np.ndarray:
        """States from one end of a step to another, all by default, shape (end - begin + 1, n)."""
        end = len(self.t) - 1 if end is None else end
        if self._has_all:
            return self._x[begin : end + 1]
        first = int(np.searchsorted(self._of_run, begin, "right")) - 1
        last = int(np.searchsorted(self._of_run, end))
        before = int(np.searchsorted(self._kept, first, "right")) - 1
        after = int(np.searchsorted(self._kept, last, "right"))
        kept = self._kept[before:after]
        x = self._again(self._of_run[kept[0] : last + 1], kept - kept[0], self._x[before:after])
        places = self._of_run[first : last + 1]
        every = np.arange(places[0], places[-1] + 1)
        x = self._again(every, places - places[0], x[first - kept[0] :])
        return x[begin - places[0] : end - places[0] + 1]

    def _again(self, places: np.ndarray, given: np.ndarray, x: np.ndarray) -> np.ndarray:
        """States at ends of steps from those that are given, the first among them."""
        if len(given) == len(places):
            return x
        whole, is_given = np.zeros((len(places), x.shape[1])), np.zeros(len(places), dtype=bool)
        whole[given], is_given[given] = x, True
        m = self._settings_at(places)
        span = self._span(self.t[places], whole, m)
        return steps_of(self._run.system, ()).replay(span, is_given)

    def settings(self, begin: int = 0, end: int | None = None) -> np.ndarray:
        """Settings from one end of a step to another, shape (end - begin + 1, settings)."""
        end = len(self.t) - 1 if end is None else end
        if len(self._m) == 1:
            return self._m.repeat(end - begin + 1, axis=0)
        return self._settings_at(np.arange(begin, end + 1))

    def _settings_at(self, places: np.ndarray) -> np.ndarray:
        if len(self._m) == 1:
            return self._m.repeat(len(places), axis=0)
        return self._m[np.searchsorted(self._of_run[self._kept], places, "right") - 1]

    @property
    def _has_all(self) -> bool:
        """Whether states are known at all ends of steps."""
        return len(self._x) == len(self.t)

    def span(self, begin: int = 0, end: int | None = None) -> Span:
        """Steps from one end of a step to another; all by default."""
        end = len(self.t) - 1 if end is None else end
        x, m = self.states(begin, end), self.settings(begin, end)
        return self._span(self.t[begin : end + 1], x, m)

    def _span(self, t: np.ndarray, x: np.ndarray, m: np.ndarray) -> Span:
        """Steps between ends with these states and settings."""
        return Span(self._run.theta, t, x, m, self._run.statistics.is_implicit(t[:-1]))

    @property
    def rows(self) -> int:
        """Steps whose states are made again at once."""
        numbers: int = self._x.shape[1] + self._m.shape[1] + 1
        return max(_MADE_BYTES // (8 * numbers), 1)

    def chunks(self) -> list[tuple[int, int]]:
        """Parts, from one end of a step to another, whose states are kept at once, in order."""
        end, rows = len(self.t) - 1, self.rows
        if end <= rows:
            return [(0, end)] if end else []
        is_divided = len(self._of_run) < len(self.t)
        inner = self._of_run if is_divided else self._kept
        inner = inner[(inner > 0) & (inner < end)]
        numbers, firsts = np.unique(inner // rows, return_index=True)
        return list(itertools.pairwise([0, *inner[firsts[numbers > 0]].tolist(), end]))

    def state(self, t: float) -> Side:
        """States and settings at a time: those of a shorter step."""
        i = int(np.searchsorted(self.t, t, "right")) - 1
        if self.t[i] == t:
            return self.side(i)
        x, m = (v[None, :].repeat(2, axis=0) for v in self.side(i))
        shorter = self._span(np.array([self.t[i], t]), x, m)
        found = steps_of(self._run.system, ()).replay(shorter, np.array([1, 0]))
        return found[1], m[0]

    def cut(self, times: float | np.ndarray) -> None:
        """Make instants inside the leg ends of steps."""
        new = np.setdiff1d(times, self.t)
        places = np.searchsorted(self.t, new)
        self.t = np.insert(self.t, places, new)
        self._of_run = self._of_run + np.searchsorted(places, self._of_run, "right")

    def divide(self, parts: np.ndarray) -> None:
        """Divide each step into so many equal ones; where steps ended, states stay as they are."""
        places = np.append(0, np.cumsum(parts))
        inner = np.arange(places[-1]) - np.repeat(places[:-1], parts)
        lengths = np.repeat(np.diff(self.t) / parts, parts)
        self.t = np.append(np.repeat(self.t[:-1], parts) + inner * lengths, self.t[-1])
        self._of_run = places[self._of_run]


@interruptible
def record_run(system: System, plan: RunPlan) -> Trajectory:
    """A run whose steps can be differentiated.

    States are kept at some steps only where all take too much room. The pieces then know the ends
    of all steps, so that these can be made again. Where implicit quantities are followed by
    iteration, whose guesses belong to each step, all are kept.
    """
    point = run_start(system, plan)
    if not system.structure.states:
        return run_on(point, plan, recorder(point, plan, GRID))

    def output(begin: OperatingPoint) -> Recorder:
        if begin.system.structure.implicit or begin.system.structure.redundant:
            return Recorder(begin, plan.until, None, True)
        return SparingRecorder(begin, plan.until, _KEPT_BYTES)

    return run_in_one(point, plan, output)


def run_in_one(
    point: OperatingPoint, plan: RunPlan, output: Callable[[OperatingPoint], Recorder]
) -> Trajectory:
    """A run in the same coordinates from its begin to its end, redundant ones if it ends in these.

    Parameters
    ----------
    output : callable
        Gives what takes the output of a run from a point.
    """
    run = run_on(point, plan, output(point))
    if run.pieces[-1].system is run.system:
        return run
    point = _free(point, run.pieces[-1].system)
    return run_on(point, plan, output(point))


def _free(point: OperatingPoint, system: System) -> OperatingPoint:
    """A point in the redundant coordinates of another system."""
    x, implicit = states_of(point.system, system)(*point.inputs)
    settings = np.concatenate([point.settings[: system.structure.mode_count], implicit])
    return replace(point, system=system, x=x, settings=settings, again=None)


@dataclass(frozen=True, eq=False)
class SmoothParts:
    """A run in its smooth parts.

    Attributes
    ----------
    run : Trajectory
        The run.
    legs : list of Leg
        Its smooth parts.
    steps : Steps
        How it was made, with what is integrated.
    rtol : float
        Its accuracy.
    crossings : sequence of Crossing
        How derivatives jump where each part but the first begins.
    whole : dict
        All steps, if they make one stretch, by the numbers of ends of steps.
    """

    run: Trajectory
    legs: list[Leg]
    steps: Steps
    rtol: float
    crossings: Sequence[Crossing] = ()
    whole: dict[tuple[int, ...], tuple[Stretch, Span]] = field(default_factory=dict)

    def stretches(
        self, apart: Collection[int] = (), *, backwards: bool = False
    ) -> Iterator[tuple[Stretch, Span]]:
        """Stretches and their steps (see `stretches`)."""
        ends = tuple(len(leg.t) for leg in self.legs)
        if not apart and ends in self.whole:
            yield self.whole[ends]
            return
        parts = stretches(self.legs, apart)
        for part in reversed(parts) if backwards else parts:
            pair = part, part.span(self.legs)
            if len(parts) == 1:
                self.whole.clear()
                self.whole[ends] = pair
            yield pair

    @property
    def until(self) -> float:
        """End of the run, s."""
        return float(self.legs[-1].t[-1])


def pieces_of(run: Trajectory) -> list[Piece]:
    """Smooth parts of a run as they were recorded."""
    return [piece for piece in run.pieces if len(piece.t)]


def legs_of(run: Trajectory) -> list[Leg]:
    """The same of a run that was recorded at the steps of the solver."""
    return [Leg(run, piece) for piece in pieces_of(run)]


@dataclass(frozen=True)
class Stretch:
    """Steps one after the other, and changes between them.

    Attributes
    ----------
    legs : list of (int, int, int)
        Number of each smooth part, and from which to which end of its steps.
    places : list of int
        Where each begins among all ends of steps.
    """

    legs: list[tuple[int, int, int]]
    places: list[int]

    @property
    def ends(self) -> int:
        """Ends of steps, both sides of a change counted."""
        _, begin, end = self.legs[-1]
        return self.places[-1] + end - begin + 1

    def add(self, number: int, begin: int, end: int) -> None:
        """Add steps of a smooth part."""
        self.places.append(self.ends if self.legs else 0)
        self.legs.append((number, begin, end))

    def span(self, legs: Sequence[Leg]) -> Span:
        """The steps."""
        return Span.join([legs[k].span(begin, end) for k, begin, end in self.legs])

    def place(self, legs: Sequence[Leg], leg: int, time: float) -> int | None:
        """Where a step of a smooth part ends at a time; None if that is not in here.

        Where a part is cut in two, this end belongs to the later one.
        """
        for (number, begin, end), first in zip(self.legs, self.places, strict=True):
            if number == leg:
                place = int(np.searchsorted(legs[number].t, time))
                is_last = end == len(legs[number].t) - 1
                if begin <= place < end + is_last:
                    return first + place - begin
        return None


def stretches(legs: Sequence[Leg], apart: Container[int] = ()) -> list[Stretch]:
    """All steps of a run, in the order of time; states of each are kept at once.

    A change is part of the stretch before it, which then ends with no step of the next part.

    Parameters
    ----------
    apart : container of int
        Smooth parts before which a new stretch begins; this change is in none.
    """
    found: list[Stretch] = []
    for number, leg in enumerate(legs):
        for begin, end in leg.chunks() or [(0, 0)]:
            is_apart = not found or (number in apart and not begin)
            if is_apart or begin or (end and found[-1].ends + end > leg.rows):
                if not is_apart and not begin:
                    found[-1].add(number, 0, 0)
                found.append(Stretch([], []))
            found[-1].add(number, begin, end)
    return found
