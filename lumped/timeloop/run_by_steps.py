"""Runs by steps: what surrounds the time loop."""

from __future__ import annotations

import itertools
import math
import time as clock

import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.kernel import engine
from lumped.kernel.methods.invariants import NEAR
from lumped.kernel.run import (
    ASKS,
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
    SET_TWICE,
    STORM,
    STORM_SIZE,
    STORM_WITHIN,
    TOO_MANY,
    UNFIT,
    Run,
)
from lumped.timeloop.guards import finite_fault, set_twice_fault, shrinking_fault
from lumped.timeloop.holds import hold_words
from lumped.timeloop.leading_states import free_states
from lumped.timeloop.levers import FAIR_LEVERAGE, MOST_LEVERAGE
from lumped.timeloop.nominal_sizes import nominals
from lumped.timeloop.plants.executable import executable, span
from lumped.timeloop.plants.kept_run import KeptRun, OutputRoom
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder
from lumped.timeloop.results.statistics import Used
from lumped.timeloop.run import Simulation
from lumped.timeloop.run_options import RunPlan
from lumped.timeloop.settings import closing_fault, no_fit

_PIECES, _CHANGES, _ROWS = 512, 4096, 2048
"""Room for pieces, changes of mode and rows between two visits to Python."""

_ROOM = 4_000_000
"""Numbers in the rows, and in the modes of the pieces, at most."""

_FOLLOWED = 16
"""Steps from one output time to the next where only implicit quantities move."""

_LONG = 50_000
"""Attempts by DOP853 that take about as long as compiling series; the rest of such a run is worth
that."""

_LOOKS = 4000
"""Steps in a run in which nothing but the time moves margins."""


class RunBySteps(Simulation):
    """One simulation by explicit or implicit steps.

    Parameters
    ----------
    point, plan, output
        As for `Simulation`; the method "auto" is "steps" but for long runs.
    """

    def __init__(self, point: OperatingPoint, plan: RunPlan, output: Recorder) -> None:
        super().__init__(point, plan, output)
        self._relative_atol, self._method = plan.relative_atol, plan.method
        self._changed_at = math.nan
        self._lenience = MOST_LEVERAGE / FAIR_LEVERAGE if plan.is_led else 0.0
        self._sizes: dict[System, np.ndarray] = {}
        self._is_implicit, self._has_series = plan.method == "implicit", plan.method == "taylor"
        self._series_after: float = _LONG if plan.method == "auto" else math.inf
        self._note_method(point.time)

    def _note_method(self, t: float) -> None:
        """A method is used from now on."""
        explicit = "taylor" if self._has_series else "explicit"
        self.methods.append(Used(float(t), "implicit" if self._is_implicit else explicit))

    def go(self) -> None:
        """Run to the end.

        Raises
        ------
        SolverError
            With what was computed so far.
        """
        self._begin()
        with self.answers:
            self._loop()
        self.output.finish(self._run.x, self._run.m)
        self._executable.take_back(self._kept)

    def _loop(self) -> None:
        while True:
            run = self._run
            begun = clock.perf_counter()
            why = engine.call("loop", run)
            self.seconds += clock.perf_counter() - begun
            if why == ASKS:
                self._ask()
                continue
            self._drain()
            self._executable.account(run)
            if run.steps + run.rejected >= self._series_after:
                self._take_series()
            if why == DONE:
                break
            if why == NEEDS_MATRIX:
                self._executable.add_matrix(run)
            elif why == UNFIT:
                self._change_states()
            elif why != FULL:
                self._fail(why)
            self._run.pause = self._pause()

    # -- into the loop -----------------------------------------------------------------------

    def _begin(self) -> None:
        """Begin at the start, in the records of a run that is over if it had the same options."""
        self._edges, times = self.find_instants(), self.output.times
        count = None if times is None else len(times)
        options = (
            self.rtol,
            self._relative_atol,
            self._method,
            self.max_steps,
            self._lenience,
            count,
        )
        self._executable = executable(self.system)
        kept = self._executable.reuse_run(options) or self._with_options(options)
        grid = None if times is None else times.tobytes()
        changing = self.instants if len(self.instants.places) else None
        when = self.begin, self.until, grid, self.output.both_sides, changing
        if kept.times != when:
            self._set_times(kept, 0, BEGIN_SEGMENT, self.begin)
            kept.note(when)
        self._stand(kept, self.point.x, self.point.settings)

    def _with_options(self, options: object) -> KeptRun:
        """Records of a run with options, at no point yet."""
        run = self._executable.blank_run()
        run.rtol, run.max_steps, run.lenience = self.rtol, self.max_steps, self._lenience
        run.atol[:] = run.least_atol[:] = self._relative_atol * nominals(self.system)
        run.chooses_method = self._method in ("auto", "steps", "taylor")
        self._take_method(run)
        room = self._new_room()
        run.output = room.output
        return KeptRun(options, run, room)

    def _set_times(self, kept: KeptRun, segment: int, phase: int, t: float) -> None:
        """Begin at an instant of this run, up to its end."""
        run, output, times = kept.run, self.output, self.output.times
        span(run, self.span)
        if not self._executable.plant.states:
            run.longest = self._longest()
        run.t, run.phase, run.segment, run.end = t, phase, segment, self._edges[segment + 1]
        run.steps, run.rejected, run.evaluations = self.steps, self.rejected, self.evaluations
        run.pause = self._pause()
        timed, values = self.instants.places, self.instants.modes
        run.segments, run.edges = len(self._edges) - 1, self._edges
        run.timed = len(timed)
        run.timed_setting = np.ascontiguousarray(timed, dtype=np.int64)
        run.timed_values = np.ascontiguousarray(values).ravel()
        grid = np.zeros(0) if times is None else np.ascontiguousarray(times)
        on_grid, both_sides = output.on_grid, output.both_sides
        kept.room.begin(grid, output.taken, on_grid=on_grid, both_sides=both_sides)

    def _stand(self, kept: KeptRun, x: np.ndarray, settings: np.ndarray) -> None:
        """Go to a point with the states of the present system."""
        self._kept, self._room, run = kept, kept.room, kept.run
        self._run, plant = run, self._executable.plant
        self.atol = run.least_atol
        self.largest = self._sizes.get(self.system, np.zeros(0))
        self._executable.place(run, self.point.theta, x, settings)
        if plant.holds:
            engine.call("watch_constraints", run)
        self._modes = settings[: len(settings) - plant.implicit]

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

    def _new_room(self) -> OutputRoom:
        """Room for what comes back."""
        plant, times = self._executable.plant, self.output.times
        n, ng = plant.states, plant.implicit
        nm, some = plant.settings - ng, plant.holds + plant.conditions
        rows = (0 if times is None else len(times)) + min(max(_ROOM // max(n, 1), 5), _ROWS)
        pieces = min(max(_ROOM // max(nm, 1), 1), _PIECES)
        changes = _CHANGES + some
        return self._executable.room((rows, pieces, changes, n, ng, nm))

    def _pause(self) -> int:
        """Attempts after which the loop comes back to Python."""
        found = self.steps + self.rejected + self._executable.attempts
        return int(min(found, self._series_after))

    def _take_method(self, run: Run) -> None:
        code = self._executable
        if self._is_implicit and code.plant.states:
            code.add_matrix(run)
        has_series = self._has_series and (self._method == "taylor" or code.taylor.exist)
        if has_series and code.plant.states:
            code.taylor.add_to(run, self.rtol)
        run.is_implicit = self._is_implicit

    def _take_series(self) -> None:
        """Go on by series if there are any; the model and the number of attempts decide.

        While implicit steps are made, that waits until there are twice as many attempts.
        """
        self._series_after = 2 * self._series_after if self._is_implicit else math.inf
        code = self._executable
        if not self._is_implicit and code.plant.states and code.taylor.exist:
            self._has_series = True
            self._take_method(self._run)
            self._note_method(self._run.t)

    # -- out of the loop ---------------------------------------------------------------------

    def _drain(self) -> None:
        """Take over what was recorded."""
        run, room, out = self._run, self._room, self._room.output
        self.steps, self.rejected, self.evaluations = run.steps, run.rejected, run.evaluations
        before = self._sizes.get(self.system, 0.0)
        self.largest = self._sizes[self.system] = np.maximum(run.largest, before)
        rows, count, changes = out.rows, out.pieces, out.changes
        bounds = [0, *out.piece_row[:count].tolist(), rows]
        if rows:
            t, x, implicit = room.t[:rows].copy(), room.x[:rows].copy(), room.implicit[:rows]
            modes = np.concatenate([self._modes[None, :], room.piece_settings[:count]])
            lengths = [end - begin for begin, end in itertools.pairwise(bounds)]
            settings = np.concatenate([modes.repeat(lengths, axis=0), implicit], axis=1)
        if count:
            self._modes = room.piece_settings[count - 1].copy()
        for k, (begin, end) in enumerate(itertools.pairwise(bounds)):
            if k:
                self.output.open(self.system)
            if end > begin:
                self.output.add(t[begin:end], x[begin:end], settings[begin:end])
        self.output.taken = out.grid_next
        out.rows = out.pieces = 0
        for t in room.turns[: out.turns].tolist():
            self._is_implicit = not self._is_implicit
            self._note_method(t)
        out.turns = 0
        if changes:
            pairs = zip(room.changes[:changes].tolist(), room.when[:changes].tolist(), strict=True)
            self.events += [self._event(*change, *when) for change, when in pairs]
            out.changes = 0

    def _event(
        self, kind: int, number: int, before: int, after: int, t: float, loss: float
    ) -> Event:
        s = self.system.switching
        if kind == 0:
            name, old = s.relation_text(number, before)
            return Event(t, name, "condition", old, s.relation_text(number, after)[1])
        words = hold_words(s, number)
        return Event(t, s.names[number], "hold", words[before], words[after], loss)

    def _change_states(self) -> None:
        """Go on in redundant coordinates."""
        run, t = self._run, float(self._run.t)
        lead = free_states(self.system, self.point.theta, t, run.x.copy(), run.m.copy())
        part, is_free = lead.follower.rpartition(".")[0], lead.system.structure.redundant
        if t == self._changed_at and not is_free:
            self.refuse(
                f"at t = {t:.9g} s no choice of states determines the position: {lead.follower} "
                f"leads instead of {lead.leader}. The linkage is singular there; check its lengths."
            )
        self._changed_at = t
        after = "redundant coordinates" if is_free else lead.follower
        self.events.append(Event(t, part, "states", lead.leader, after))
        self.system = lead.system
        self.output.open(lead.system)
        self.output.edge(t, lead.x, lead.settings)
        ring, changes = run.changed.copy(), run.changed_count
        self._executable = executable(lead.system)
        kept = self._with_options(None)
        self._set_times(kept, run.segment, RESTART, t)
        self._stand(kept, lead.x, lead.settings)
        self._run.changed[:], self._run.changed_count = ring, changes

    def _ask(self) -> None:
        """Let a program answer."""
        try:
            self.answers.ask_and_keep(self.system, self._run)
        except SolverError as error:
            self._drain()
            self.refuse(str(error))
        except KeyboardInterrupt:
            self._drain()
            raise

    def _fail(self, why: int) -> None:
        """Stop with what was computed so far."""
        run, system, theta = self._run, self.system, self.point.theta
        t, x, settings = float(run.t), run.x.copy(), run.m.copy()
        rates = self._executable.evaluate("rates", x, theta, t, settings)
        if why == JUMPS:
            self.refuse_jump(t, x, run.instant.before.copy(), settings)
        if why == NO_FIT:
            raise SolverError(str(no_fit(system, run)), self.partial())
        if why == SET_TWICE:
            self.refuse(set_twice_fault(system, run))
        if why == NOT_CLOSED:
            raise SolverError(closing_fault(system, t), self.partial())
        if why == STORM:
            self._refuse_storm(t)
        if why == NOT_FINITE:
            self.refuse(finite_fault(system, t, x, rates))
        if why == GIVEN_UP and not len(x):
            self.refuse(
                f"a linkage or implicit equation could not be followed beyond t = {t:.9g} s. Ask "
                "for more output points, or check its range."
            )
        if why != TOO_MANY and run.plant.invariants and run.independence < NEAR:
            self.refuse(
                f"at t = {t:.9g} s a linkage passes a position, or rests in one, in which its "
                f"constraints depend on each other; rounding there is more than "
                f"rtol = {self.rtol:g} allows. Loosen rtol, or change the lengths a little."
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
