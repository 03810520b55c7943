"""Collect what a run computes: at the times asked for, in smooth pieces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError
from lumped.support.made_once import made_once
from lumped.support.progress import Progress
from lumped.support.units import read_time
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.trajectory import Piece

_MOST = 100_000_000
"""Output intervals that any use has."""
_KEPT = 10_000
"""Output intervals up to which equal output times are kept for the next run."""
_ROUNDING = 1e-14
"""What times may differ by that are meant to be the same, relative to them."""
_Rows = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Times (k,), states (k, n), settings (k, m)."""


def output_times(
    grid: int | Sequence[float | str] | np.ndarray | None, until: float, begin: float = 0.0
) -> np.ndarray | None:
    """Output times of a run: equal intervals, those given, or None for the solver's steps.

    Raises
    ------
    OptionError
        If they make no sense.
    """
    if grid is None:
        return None
    if isinstance(grid, (int, np.integer)) and not isinstance(grid, bool):
        if not 1 <= grid <= _MOST:
            raise OptionError(
                f"grid = {grid}: the number of output intervals must lie between 1 and {_MOST}."
            )
        make = _space_evenly if grid <= _KEPT else _space_evenly.__wrapped__
        return make(begin, until, int(grid))
    times = _numbers(grid)
    count = len(times) if times.ndim == 1 else 0
    if not count or (count > 1 and not (times[1:] >= times[:-1]).all()):
        raise OptionError(
            f"grid = {grid!r:.60}: give a number of output intervals, or a list of output times "
            "that does not decrease, or None for the steps of the solver."
        )
    first, last = float(times[0]), float(times[-1])
    if begin <= first and last <= until:
        return times
    near = _ROUNDING * max(abs(begin), abs(until))
    if not (first >= begin - near and last <= until + near):
        raise OptionError(
            "grid: output times from {} to {} s leave {} to {} s.".format(
                *(repr(float(t)).removesuffix(".0") for t in (first, last, begin, until))
            )
        )
    inside: np.ndarray = np.clip(times, begin, until)
    return inside


@lru_cache(8)
def _space_evenly(begin: float, until: float, intervals: int) -> np.ndarray:
    times = np.linspace(begin, until, intervals + 1)
    times.setflags(write=False)
    return times


def _numbers(grid: object) -> np.ndarray:
    """Output times in s as an array of its own; not yet checked."""
    try:
        return np.array(grid, dtype=float)
    except (TypeError, ValueError):
        listed = grid if isinstance(grid, Iterable) else [grid]
        return np.array([read_time(time, "grid: time") for time in listed])


def scale(begin: float, until: float) -> float:
    """Size of the times of a run, s; what tells instants apart is relative to it."""
    return max(abs(begin), abs(until))


class Recorder:
    """Output of one run.

    Parameters
    ----------
    point : OperatingPoint
        Where the run starts.
    until : float
        Its end, s.
    times : ndarray or None
        Output times; None for the steps of the solver.
    both_sides : bool
        Both ends of each segment are recorded, besides the output times between them.

    Attributes
    ----------
    progress : Progress
        Is given how far the run has come.
    taken : int
        Output times that were handed out.
    """

    def __init__(
        self, point: OperatingPoint, until: float, times: np.ndarray | None, both_sides: bool
    ) -> None:
        self._begin, self.times, self.both_sides = point.time, times, both_sides
        self._near = 1e-13 * scale(point.time, until)
        self.progress = Progress(point.system.name, until - point.time)
        self.taken = 0
        self._parts: list[tuple[System, list[_Rows]]] = []

    @property
    def on_grid(self) -> bool:
        """Whether output times were given."""
        return self.times is not None

    @property
    def size(self) -> int:
        """Number of output times that were given."""
        return 0 if self.times is None else len(self.times)

    def open(self, system: System) -> None:
        """Begin a new piece."""
        self._parts.append((system, []))

    def add(self, t: np.ndarray, x: np.ndarray, settings: np.ndarray) -> None:
        """Points of the present piece: times (k,), states (k, n), settings (k, m)."""
        self._parts[-1][1].append((t, x, settings))
        if self.progress.is_shown and len(t):
            self.progress.at(float(t[-1]) - self._begin)

    def edge(self, t: float, x: np.ndarray, settings: np.ndarray) -> None:
        """An end of a segment; grid points that coincide with it are left out."""
        if self.both_sides:
            self.add(np.array([t]), x[None, :], settings[None, :])
            if self.times is not None:
                close = np.searchsorted(self.times, t + self._near, "right")
                self.taken = max(self.taken, int(close))

    def due(self, end: float) -> np.ndarray:
        """Output times before `end` that were not handed out yet."""
        if self.times is None:
            return np.zeros(0)
        stop = max(int(np.searchsorted(self.times, end, "left")), self.taken)
        wanted = self.times[self.taken : stop]
        self.taken = stop
        return wanted

    def finish(self, x: np.ndarray, settings: np.ndarray) -> None:
        """Output times at the very end."""
        if self.times is None or self.taken == len(self.times):
            return
        rest, self.taken = self.times[self.taken :].copy(), len(self.times)
        count = len(rest)
        self.add(rest, x[None, :].repeat(count, axis=0), settings[None, :].repeat(count, axis=0))

    def pieces(self) -> tuple[Piece, ...]:
        """What was recorded so far."""
        return tuple(
            [
                Piece(system, *_join_rows(rows)) if rows else _nothing(system)
                for system, rows in self._parts
            ]
        )


@made_once
def _nothing(system: System) -> Piece:
    n, m = len(system.state_names), system.inputs[3].numel()
    return Piece(system, np.zeros(0), np.zeros((0, n)), np.zeros((0, m)))


class SparingRecorder(Recorder):
    """All times of the steps of a run, and states at so many of them as there is room for.

    States are kept at the ends of each piece and at every `stride`-th step between. When they
    become too large, every second one is dropped and the stride doubles. Settings must not change
    inside of a piece.

    Parameters
    ----------
    point, until
        As for `Recorder`.
    most : int
        Size of states and settings, bytes; those at the ends of pieces may take more.
    """

    def __init__(self, point: OperatingPoint, until: float, most: int) -> None:
        super().__init__(point, until, None, True)
        self._most, self._size, self._stride = most, 0, 1
        self._ends: list[list[np.ndarray]] = []
        self._places: list[list[np.ndarray]] = []
        self._counts: list[int] = []

    def open(self, system: System) -> None:
        """Begin a new piece."""
        super().open(system)
        self._ends.append([])
        self._places.append([])
        self._counts.append(0)

    def add(self, t: np.ndarray, x: np.ndarray, settings: np.ndarray) -> None:
        """Points of the present piece; the same time does not occur twice in it."""
        ends = self._ends[-1]
        new = np.append(not ends or t[0] > ends[-1][-1], t[1:] > t[:-1])
        if not new.any():
            return
        if not new.all():
            t, x, settings = t[new], x[new], settings[new]
        places = self._counts[-1] + np.arange(len(t))
        ends.append(t)
        self._counts[-1] += len(t)
        if self._stride > 1:
            kept = _mark_multiples(places, self._stride)
            places, t, x, settings = places[kept], t[kept], x[kept], settings[kept]
        self._places[-1].append(places)
        super().add(t, x, settings)
        self._size += (x.shape[1] + settings.shape[1]) * 8 * len(t)
        if self._size > self._most:
            self._thin()

    def _thin(self) -> None:
        """Keep every second state, and so on, until there is room."""
        while self._size > self._most / 2 and self._stride < max(self._counts):
            self._stride *= 2
            self._size = 0
            for number, (system, rows) in enumerate(self._parts):
                if rows:
                    places = np.concatenate(self._places[number])
                    kept = _mark_multiples(places, self._stride)
                    whole = tuple(v[kept] for v in _join_rows(rows))
                    self._parts[number] = system, [whole]
                    self._places[number] = [places[kept]]
                    self._size += whole[1].nbytes + whole[2].nbytes
        self._most = max(self._most, 2 * self._size)

    def pieces(self) -> tuple[Piece, ...]:
        """What was recorded so far."""
        found = super().pieces()
        if self._stride == 1:
            return found
        ends = [np.concatenate([np.zeros(0), *own]) for own in self._ends]
        return tuple(replace(p, ends=own) for p, own in zip(found, ends, strict=True))


def _mark_multiples(places: np.ndarray, stride: int) -> np.ndarray:
    """Which of some places are multiples of a stride, or the last."""
    kept: np.ndarray = places % stride == 0
    kept[-1] = True
    return kept


def _join_rows(rows: list[_Rows]) -> _Rows:
    """Points of a piece in one."""
    if len(rows) == 1:
        return rows[0]
    t, x, settings = (np.concatenate(columns) for columns in zip(*rows, strict=True))
    return t, x, settings
