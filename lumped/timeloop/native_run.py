"""A run in machine code: what is left to Python at an instant, and what comes back."""

from __future__ import annotations

import itertools
import math
import time as clock
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lumped.errors import SolverError
from lumped.kernel import layout as at
from lumped.timeloop.calls import called
from lumped.timeloop.guards import finite_fault, followers, singular_fault, unfit_states
from lumped.timeloop.holds import hold_words
from lumped.timeloop.machine import Machine
from lumped.timeloop.result import Event
from lumped.timeloop.stepper import GIVEN_UP

if TYPE_CHECKING:
    from lumped.timeloop.advance import Advance
    from lumped.timeloop.run import Run

__all__ = ["Flight", "Place"]

_PIECES, _CHANGES, _ROWS = 512, 4096, 2048
"""Room for pieces, changes of modes and rows between two visits to Python."""

_ROOM = 4_000_000
"""Numbers in the rows, and in the modes of the pieces, at most."""


class Place(NamedTuple):
    """Where a run stands.

    Attributes
    ----------
    segment : int
        Number of the segment between instants of functions of time.
    t : float
        Instant, s.
    x, modes : ndarray
        States and modes.
    settled : bool
        Whether the modes hold from here on already.
    """

    segment: int
    t: float
    x: np.ndarray
    modes: np.ndarray
    settled: bool


class Flight:
    """The rest of a run in machine code.

    Parameters
    ----------
    run : Run
        The run.
    cost : Advance
        Its settings and costs.
    machine : Machine
        Of the system whose states it has now.
    edges : ndarray
        Ends of all segments, s.
    place : Place
        Where it stands.
    """

    def __init__(
        self, run: Run, cost: Advance, machine: Machine, edges: np.ndarray, place: Place
    ) -> None:
        self._run, self._cost, self._machine, self._edges = run, cost, machine, edges
        timed, values = run.instants.places, run.instants.modes
        settings = np.concatenate([place.modes, run.guess])
        more = len(edges) + values.size + 1
        i, d = machine.blocks(run.point.theta, place.x, settings, run.scale, more)
        self._integers, self._numbers, self._now = i, d, place.modes
        i[at.EDGES], i[at.TIMED_VALUES] = machine.count, machine.count + len(edges)
        self._fill(at.EDGES, edges)
        self._fill(at.TIMED_VALUES, values.ravel())
        i[at.SEGMENTS], i[at.TIMED] = len(edges) - 1, len(timed)
        i[i[at.TIMED_MODE] : i[at.TIMED_MODE] + len(timed)] = timed
        self._fill(at.ATOL, cost.atol)
        d[at.RTOL], d[at.KNOWN] = run.rtol, math.inf
        d[at.T], d[at.END] = place.t, edges[place.segment + 1]
        machine.ask(i, d)
        i[at.ASK] = 3 if run.implicit else 1 if followers(run.system)[0] else 0
        i[at.SEGMENT] = place.segment
        i[at.PHASE] = at.RESTART if place.settled else at.BEGIN_SEGMENT
        self._outputs()
        self._settings()

    def _fill(self, vector: int, values: np.ndarray) -> None:
        first = self._integers[vector]
        self._numbers[first : first + len(values)] = values

    def _vector(self, vector: int, count: int) -> np.ndarray:
        first = int(self._integers[vector])
        return self._numbers[first : first + count]

    def _outputs(self) -> None:
        """Room for what comes back."""
        i, times = self._integers, self._run.output.times
        n, ng = int(i[at.N]), int(i[at.NG])
        nm, nh, nr = int(i[at.NM]) - ng, int(i[at.NH]), int(i[at.NR])
        grid = np.zeros(0) if times is None else np.ascontiguousarray(times)
        rows = len(grid) + min(max(_ROOM // n, 5), _ROWS)
        pieces = min(max(_ROOM // max(nm, 1), 1), _PIECES)
        changes = _CHANGES + nh + nr
        self._t, self._x, self._g = np.empty(rows), np.empty((rows, n)), np.empty((rows, ng))
        self._piece_rows = np.empty(pieces, dtype=np.int64)
        self._piece_modes = np.empty((pieces, nm))
        self._changes, self._when = np.empty((changes, 4), dtype=np.int64), np.empty((changes, 2))
        self._grid = grid
        for place, held in (
            (at.OUT_T, self._t),
            (at.OUT_X, self._x),
            (at.OUT_G, self._g),
            (at.PIECE_ROW, self._piece_rows),
            (at.PIECE_MODES, self._piece_modes),
            (at.CHANGE_I, self._changes),
            (at.CHANGE_D, self._when),
            (at.GRID, grid),
        ):
            i[place] = held.ctypes.data
        i[at.MOST_ROWS], i[at.MOST_PIECES], i[at.MOST_CHANGES] = rows, pieces, changes
        i[at.GRID_SIZE], i[at.GRID_NEXT] = len(grid), self._run.output.taken

    def _settings(self) -> None:
        i, run, cost = self._integers, self._run, self._cost
        i[at.AUTO], i[at.IMPLICIT] = cost.auto, cost.method == "implicit"
        i[at.MAX_STEPS] = cost.max_steps
        i[at.BOTH_SIDES], i[at.ON_GRID] = run.output.both_sides, run.output.on_grid
        i[at.STEPS], i[at.REFUSED], i[at.EVALUATIONS] = cost.steps, cost.rejected, cost.evaluations
        recent = run.crossings[-at.STORM_SIZE :]
        self._fill(at.RING, np.array(recent))
        i[at.CROSSINGS] = len(recent)

    def go(self) -> Place:
        """Go on as far as possible; to the end of the run, or to where Python must step.

        Raises
        ------
        SolverError
            If the run cannot go on.
        """
        i = self._integers
        if i[at.IMPLICIT] and not self._machine.with_jacobian(i):
            return self._place()
        self._cost.native = True
        self._cost.used(self._cost.method)
        while True:
            i[at.PAUSE] = i[at.STEPS] + i[at.REFUSED] + self._machine.attempts
            begun = clock.perf_counter()
            why = self._machine("loop", i, self._numbers)
            self._cost.seconds += clock.perf_counter() - begun
            self._drain()
            if why == at.DONE:
                return self._place()
            if why == at.TOO_STIFF:
                self._cost.change(float(self._numbers[at.T]))
                if not self._machine.with_jacobian(i):
                    return self._place()
                i[at.IMPLICIT] = 1
            elif why == at.UNFIT:
                return self._changed()
            elif why in (at.AT_INSTANT, at.AT_CROSSING):
                self._settle(why)
            elif why != at.FULL:
                self._fail(why)

    def _place(self) -> Place:
        i = self._integers
        n, nm, ng = (int(i[k]) for k in (at.N, at.NM, at.NG))
        settings = self._vector(at.M, nm).copy()
        self._run.guess = settings[nm - ng :]
        settled = bool(i[at.PHASE] not in (at.BEGIN_SEGMENT,))
        t = float(self._numbers[at.T])
        x = self._vector(at.X, n).copy()
        return Place(int(i[at.SEGMENT]), t, x, settings[: nm - ng], settled)

    def _drain(self) -> None:
        """Take over what was recorded."""
        i, run = self._integers, self._run
        output, cost = run.output, self._cost
        cost.steps, cost.rejected = int(i[at.STEPS]), int(i[at.REFUSED])
        cost.evaluations = int(i[at.EVALUATIONS])
        if i[at.IMPLICIT] and cost.method == "explicit":
            cost.change(float(self._numbers[at.CHANGED_AT]))
        rows, count = int(i[at.ROWS]), int(i[at.PIECES])
        t, x, g = self._t[:rows].copy(), self._x[:rows].copy(), self._g[:rows]
        bounds = [0, *self._piece_rows[:count].tolist(), rows]
        modes = np.vstack([self._now, self._piece_modes[:count]])
        self._now = modes[-1]
        settings = np.hstack([np.repeat(modes, np.diff(bounds), axis=0), g])
        for k, (begin, end) in enumerate(itertools.pairwise(bounds)):
            if k:
                output.open(run.system)
            if end > begin:
                output.add(t[begin:end], x[begin:end], settings[begin:end])
        output.taken = int(i[at.GRID_NEXT])
        i[at.ROWS] = i[at.PIECES] = 0
        changes = int(i[at.CHANGES])
        if changes:
            told = self._changes[:changes].tolist(), self._when[:changes].tolist()
            run.events += [self._event(*change) for change in zip(*told, strict=True)]
            i[at.CHANGES] = 0

    def _event(self, change: list[int], when: list[float]) -> Event:
        kind, number, before, after = change
        t, loss = when
        s = self._machine.system.switching
        if kind == 0:
            name, old = s.relation_text(number, before)
            return Event(t, name, old, s.relation_text(number, after)[1])
        words = hold_words(s, number)
        return Event(t, s.names[number], words[before], words[after], loss)

    def _settle(self, why: int) -> None:
        """Settle an instant that machine code leaves alone."""
        i, run = self._integers, self._run
        n, nm, ng = (int(i[k]) for k in (at.N, at.NM, at.NG))
        x, settings = self._vector(at.X, n), self._vector(at.M, nm)
        before = self._vector(at.BEFORE, nm).copy()
        t, modes = float(self._numbers[at.T]), settings[: nm - ng].copy()
        run.guess = settings[nm - ng :].copy()
        if why == at.AT_INSTANT:
            if i[at.SEGMENT]:
                run.refuse_jump(t, x.copy(), before[: nm - ng], modes)
            fired = []
        else:
            first = int(i[at.FIRED_ROWS])
            rows = i[first : first + int(i[at.FIRED])].tolist()
            fired = [run.system.switching.rows[k] for k in rows]
            run.guess = run.closed(t, x.copy(), modes)
        x[:], modes = run.settled(t, x.copy(), modes, before[: nm - ng], fired)
        run.guess = run.closed(t, x.copy(), modes)
        settings[:] = np.concatenate([modes, run.guess])

    def _changed(self) -> Place:
        """Let another state lead."""
        run, place = self._run, self._place()
        point = (np.array([place.t]), place.x[None, :], place.modes, run.guess[None, :])
        unfit = unfit_states(run.system, run.point.theta, *point)
        if unfit is None:
            return place
        return place._replace(x=run.change_states(place.t, place.x, place.modes, unfit))

    def _fail(self, why: int) -> None:
        """Stop with what was computed so far."""
        run, place = self._run, self._place()
        system, theta, cost = run.system, run.point.theta, self._cost
        settings = np.concatenate([place.modes, run.guess])
        (f,) = called(system, "rhs")(place.x, theta, place.t, settings)
        if why == at.STORM:
            run.storm(place.t)
        if why == at.NOT_FINITE:
            run.refuse(finite_fault(system, place.t, place.x, f))
        if why == at.SINGULAR:
            run.refuse(singular_fault(place.t))
        end = float(self._edges[place.segment + 1])
        flag = GIVEN_UP if why == at.GIVEN_UP else 0
        head = np.array([place.t, self._numbers[at.H], 0, 0, 0, flag, *run.guess])
        try:
            cost.give_up(head, place.x, f, place.modes, end)
        except SolverError as error:
            raise SolverError(str(error), run.trajectory()) from None
