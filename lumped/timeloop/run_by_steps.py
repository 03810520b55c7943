"""Runs by steps: what stands around the time loop."""

from __future__ import annotations

import itertools
import math
import time as clock

import numpy as np

from lumped.errors import SolverError
from lumped.kernel import engine
from lumped.kernel.run import (
    BEGIN_SEGMENT,
    DONE,
    FULL,
    GIVEN_UP,
    JUMPS,
    NEEDS_MATRIX,
    NO_FIT,
    NOT_CLOSED,
    NOT_FINITE,
    RESTART,
    STORM,
    STORM_SIZE,
    STORM_WITHIN,
    TOO_MANY,
    UNFIT,
)
from lumped.timeloop.event import Event
from lumped.timeloop.executable import executable, span
from lumped.timeloop.guards import finite_fault, shrinking_fault
from lumped.timeloop.holds import hold_words
from lumped.timeloop.leading_states import exchanged
from lumped.timeloop.positions import no_fit
from lumped.timeloop.recorder import Recorder
from lumped.timeloop.result import OperatingPoint
from lumped.timeloop.run import Simulation, nominals
from lumped.timeloop.settings import closing_fault

__all__ = ["RunBySteps"]

_PIECES, _CHANGES, _ROWS = 512, 4096, 2048
"""Room for pieces, changes of mode and rows between two visits to Python."""

_ROOM = 4_000_000
"""Numbers in the rows, and in the modes of the pieces, at most."""

_FOLLOWED = 16
"""Steps from one output time to the next where only implicit quantities move."""

_LOOKS = 4000
"""Steps in a run in which nothing but the time moves margins."""


class RunBySteps(Simulation):
    """One simulation by explicit or implicit steps.

    Parameters
    ----------
    point, until, rtol, output
        As for `Simulation`.
    atol : float
        Absolute tolerance relative to nominal values.
    method : {"steps", "explicit", "implicit", "taylor"}
        As for `simulate`.
    max_steps : int
        Give up after so many attempts.
    """

    def __init__(
        self,
        point: OperatingPoint,
        until: float,
        rtol: float,
        output: Recorder,
        atol: float,
        method: str,
        max_steps: int,
    ) -> None:
        super().__init__(point, until, rtol, output)
        self._relative_atol, self._method, self.max_steps = atol, method, max_steps
        self._changed_at = math.nan
        self._is_implicit = method == "implicit"
        self._note_method(point.time)

    def _note_method(self, t: float) -> None:
        """A method is used from now on."""
        explicit = "taylor" if self._method == "taylor" else "explicit"
        self.methods.append("implicit" if self._is_implicit else explicit)
        if self._is_implicit:
            self.implicit_from = float(t) if len(self.methods) > 1 else 0.0

    def go(self) -> None:
        """Run to the end.

        Raises
        ------
        SolverError
            With what was computed so far.
        """
        self._edges = self.find_instants()
        self._enter(0, BEGIN_SEGMENT, self.begin, self.point.x, self.point.settings)
        while True:
            run = self._run
            run.pause = run.steps + run.rejected + self._executable.attempts
            begun = clock.perf_counter()
            why = engine.call("loop", run)
            self.seconds += clock.perf_counter() - begun
            self._drain()
            self._executable.account(run)
            if run.is_implicit and not self._is_implicit:
                self._is_implicit = True
                self._note_method(run.implicit_from)
            if why == DONE:
                break
            if why == NEEDS_MATRIX:
                self._executable.add_matrix(run)
            elif why == UNFIT:
                self._change_states()
            elif why != FULL:
                self._fail(why)
        self.output.finish(run.x.copy(), run.m.copy())
        self._executable.take_back(run, self._room)

    # -- into the loop -----------------------------------------------------------------------

    def _enter(
        self, segment: int, phase: int, t: float, x: np.ndarray, settings: np.ndarray
    ) -> None:
        """Stand somewhere with the states of the present system."""
        system, theta = self.system, self.point.theta
        self._executable = executable(system)
        self.atol = self._relative_atol * nominals(system)
        run = self._run = self._executable.new_run(theta, t, x, settings)
        span(run, self.span)
        run.rtol, run.max_steps = self.rtol, self.max_steps
        run.atol[:] = self.atol
        run.phase, run.segment, run.end = phase, segment, self._edges[segment + 1]
        run.chooses_method = self._method == "steps"
        run.steps, run.rejected, run.evaluations = self.steps, self.rejected, self.evaluations
        run.sampled_to = math.inf
        timed, values = self.instants.places, self.instants.modes
        run.segments, run.edges = len(self._edges) - 1, self._edges
        run.timed = len(timed)
        run.timed_setting = np.ascontiguousarray(timed, dtype=np.int64)
        run.timed_values = np.ascontiguousarray(values).ravel()
        if not len(x):
            run.longest = self._longest()
        engine.call("watched", run)
        self._modes = settings[: len(settings) - self._executable.plant.implicit].copy()
        self._make_room()
        self._take_method()

    def _longest(self) -> float:
        """Step by which implicit quantities and margins are followed where there are no states."""
        plant, times = self._executable.plant, self.output.times
        found = math.inf
        if plant.implicit:
            between = self.until - self.begin
            if times is not None and len(times) > 1:
                between = float(np.diff(times).max()) or between
            found = between / _FOLLOWED
        if plant.margins:
            found = min(found, (self.until - self.begin) / _LOOKS)
        return found

    def _make_room(self) -> None:
        """Room for what comes back."""
        plant, times = self._executable.plant, self.output.times
        n, ng = plant.states, plant.implicit
        nm, some = plant.settings - ng, plant.holds + plant.conditions
        grid = np.zeros(0) if times is None else np.ascontiguousarray(times)
        rows = len(grid) + min(max(_ROOM // max(n, 1), 5), _ROWS)
        pieces = min(max(_ROOM // max(nm, 1), 1), _PIECES)
        changes = _CHANGES + some
        sizes = (rows, pieces, changes, n, ng, nm)
        self._room = self._executable.room(sizes)
        on_grid, both_sides = self.output.on_grid, self.output.both_sides
        self._room.begin(grid, self.output.taken, on_grid=on_grid, both_sides=both_sides)
        self._run.output = self._room.output

    def _take_method(self) -> None:
        if self._is_implicit and self._executable.plant.states:
            self._executable.add_matrix(self._run)
        if self._method == "taylor" and self._executable.plant.states:
            self._executable.taylor.add_to(self._run, self.rtol)
        self._run.is_implicit = self._is_implicit

    # -- out of the loop ---------------------------------------------------------------------

    def _drain(self) -> None:
        """Take over what was recorded."""
        run, room, out = self._run, self._room, self._room.output
        self.steps, self.rejected, self.evaluations = run.steps, run.rejected, run.evaluations
        rows, count = out.rows, out.pieces
        t, x, implicit = room.t[:rows].copy(), room.x[:rows].copy(), room.implicit[:rows]
        bounds = [0, *out.piece_row[:count].tolist(), rows]
        modes = np.vstack([self._modes, room.piece_settings[:count]])
        self._modes = modes[-1]
        settings = np.hstack([np.repeat(modes, np.diff(bounds), axis=0), implicit])
        for k, (begin, end) in enumerate(itertools.pairwise(bounds)):
            if k:
                self.output.open(self.system)
            if end > begin:
                self.output.add(t[begin:end], x[begin:end], settings[begin:end])
        self.output.taken = out.grid_next
        out.rows = out.pieces = 0
        if out.changes:
            told = zip(
                room.changes[: out.changes].tolist(),
                room.when[: out.changes].tolist(),
                strict=True,
            )
            self.events += [self._event(*change) for change in told]
            out.changes = 0

    def _event(self, change: list[int], when: list[float]) -> Event:
        kind, number, before, after = change
        t, loss = when
        s = self.system.switching
        if kind == 0:
            name, old = s.relation_text(number, before)
            return Event(t, name, old, s.relation_text(number, after)[1])
        words = hold_words(s, number)
        return Event(t, s.names[number], words[before], words[after], loss)

    def _change_states(self) -> None:
        """Let another motion lead."""
        run, t = self._run, float(self._run.t)
        lead = exchanged(self.system, self.point.theta, t, run.x.copy(), run.m.copy())
        if t == self._changed_at:
            self.refuse(
                f"at t = {t:.9g} s no choice of states determines the position: "
                f"{lead.after} leads instead of {lead.before}. The linkage is singular there; "
                "check its lengths."
            )
        self._changed_at = t
        self.events.append(Event(t, lead.after.rpartition(".")[0], lead.before, lead.after))
        self.system = lead.system
        self.output.open(lead.system)
        ring, changes = run.changed.copy(), run.changed_count
        self._enter(run.segment, RESTART, t, lead.x, lead.settings)
        self._run.changed[:], self._run.changed_count = ring, changes

    def _fail(self, why: int) -> None:
        """Stop with what was computed so far."""
        run, system, theta = self._run, self.system, self.point.theta
        t, x, settings = float(run.t), run.x.copy(), run.m.copy()
        rates = self._executable.evaluate("rates", x, theta, t, settings)
        if why == JUMPS:
            self.refuse_jump(t, x, run.instant.before.copy(), settings)
        if why == NO_FIT:
            raise SolverError(str(no_fit(system, run)), self.trajectory())
        if why == NOT_CLOSED:
            raise SolverError(closing_fault(system, t), self.trajectory())
        if why == STORM:
            self._refuse_storm(t)
        if why == NOT_FINITE:
            self.refuse(finite_fault(system, t, x, rates))
        if why == GIVEN_UP and not len(x):
            self.refuse(
                f"a linkage or implicit equation could not be followed beyond t = {t:.9g} s. Ask "
                "for more output points, or check its range."
            )
        if why == GIVEN_UP:
            tolerated = self.atol + self.rtol * np.abs(x)
            self.refuse(shrinking_fault(system, theta, t, x, rates, settings, tolerated))
        assert why == TOO_MANY
        end = float(self._edges[run.segment + 1])
        other = "" if self._is_implicit else "use method='implicit', "
        self.refuse(
            f"more than max_steps = {self.max_steps} steps before t = {end:g} s; stopped at "
            f"t = {t:g} s with steps of {run.h:.2g} s. Loosen rtol, {other}or raise max_steps."
        )

    def _refuse_storm(self, t: float) -> None:
        """Stop where changes of modes follow each other without end."""
        recent = sorted({event.component for event in self.events[-STORM_SIZE:]})
        self.refuse(
            f"{STORM_SIZE} changes of mode within {STORM_WITHIN * self.span:.2g} s before "
            f"t = {t:.9g} s, in {', '.join(recent[:6])}. Conditions that switch each other: "
            "dry friction and contacts that can rest need lumped.hold, which finds a "
            "standstill; a condition on a speed cannot."
        )
