"""A run: from one change of modes or leading states to the next."""

from __future__ import annotations

import math
from collections.abc import Sequence

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError, StartError
from lumped.kernel.layout import STORM_SIZE
from lumped.timeloop.advance import Advance
from lumped.timeloop.changeover import Settler
from lumped.timeloop.crossing import Crossing
from lumped.timeloop.exact import Exact
from lumped.timeloop.guards import Unfit, jump_fault, unfit_states
from lumped.timeloop.instants import instants
from lumped.timeloop.native_run import Flight, Place
from lumped.timeloop.recorder import Recorder, scale
from lumped.timeloop.result import Event, OperatingPoint, Piece, Statistics, Trajectory
from lumped.timeloop.settings import closed_with

__all__ = ["Run"]


class Run:
    """One simulation.

    Parameters
    ----------
    point : OperatingPoint
        Where it starts.
    until : float
        End, s.
    rtol : float
        Relative tolerance.
    advance : Advance or Exact
        Makes the steps.
    output : Recorder
        Takes what is computed.
    """

    def __init__(
        self,
        point: OperatingPoint,
        until: float,
        rtol: float,
        advance: Advance | Exact,
        output: Recorder,
    ) -> None:
        self.point, self.until, self.rtol = point, until, rtol
        self.begin, self.scale = point.time, scale(point.time, until)
        self.advance, self.output = advance, output
        self._take(point.system)
        self.guess = point.modes[len(point.modes) - self.implicit :]
        self.crossings: list[float] = []
        self._changed_at = math.nan
        hits = point.collisions
        self.events = [Event(self.begin, c.component, c.before, c.after, c.loss) for c in hits]

    def _take(self, system: System) -> None:
        """Integrate the states of this system from now on."""
        self.system = system
        self.implicit = len(system._values.implicit)
        self._settler: Settler | None = None
        self.advance.take(system)

    @property
    def settler(self) -> Settler:
        """Finds modes."""
        if self._settler is None:
            self._settler = Settler(self.system, self.point.theta, self.scale)
        return self._settler

    def go(self) -> None:
        """Run to the end.

        Raises
        ------
        SolverError
            With what was computed so far.
        """
        self.instants = instants(self.system, self.point.theta, self.begin, self.until)
        times, names = self.instants.times.tolist(), self.instants.names
        self.events += [Event(t, name) for t, name in zip(times, names, strict=True)]
        edges = np.array([self.begin, *times, self.until])
        modes = self.point.modes[: len(self.point.modes) - self.implicit]
        place = Place(0, self.begin, self.point.x, modes, settled=False)
        while place.segment < len(edges) - 1:
            steps = self.advance if isinstance(self.advance, Advance) else None
            code = steps.code() if steps is not None else None
            if steps is not None and code is not None:
                place = Flight(self, steps, code, edges, place).go()
            else:
                place = self._segment(edges, place)
        self.output.finish(place.x, self._settings(place.modes))

    def _segment(self, edges: np.ndarray, place: Place) -> Place:
        """Go to the end of a segment, or to where machine code takes over."""
        number, t, x, modes, settled = place
        begin, end = edges[number : number + 2].tolist()
        if not settled:
            before, modes = modes, modes.copy()
            modes[self.instants.places] = self.instants.modes[number]
            if number:
                self.refuse_jump(begin, x, before, modes)
            x, modes = self.settled(begin, x, modes, before)
            self.guess = self.closed(begin, x, modes)
            self.output.open(self.system)
            self.output.edge(begin, x, self._settings(modes))
        t, x, modes = self._through(t, end, x, modes)
        if t < end:
            return Place(number, t, x, modes, settled=True)
        if self.output.on_grid and end > begin:
            self.output.edge(end, x, self._settings(modes))
        return Place(number + 1, end, x, modes, settled=False)

    def refuse_jump(self, t: float, x: np.ndarray, before: np.ndarray, modes: np.ndarray) -> None:
        """Stop where a prescribed motion jumps that bodies would have to follow."""
        sides = (np.concatenate([m, self.guess]) for m in (before, modes))
        self.refuse(jump_fault(self.system, self.point.theta, t, x, *sides))

    def settled(
        self,
        t: float,
        x: np.ndarray,
        modes: np.ndarray,
        before: np.ndarray,
        fired: Sequence[tuple[str, int]] = (),
    ) -> tuple[np.ndarray, np.ndarray]:
        """States and modes just after an instant, with what changed noted as events."""
        if not self.system.switching:
            return x, modes
        try:
            x, modes, changes = self.settler.settle(t, x, modes, self.guess, before, fired)
        except SolverError as error:
            raise SolverError(str(error), self.trajectory()) from None
        self.events += [Event(t, c.component, c.before, c.after, c.loss) for c in changes]
        return x, modes

    def _settings(self, modes: np.ndarray) -> np.ndarray:
        return np.concatenate([modes, self.guess])

    def _through(
        self, begin: float, end: float, x: np.ndarray, modes: np.ndarray
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Advance from one change of modes or states to the next; gives where and with what."""
        t = begin
        point = (np.array([t]), x[None, :], modes, self.guess[None, :])
        stop: Crossing | Unfit | None = unfit_states(self.system, self.point.theta, *point)
        while True:
            if isinstance(stop, Crossing):
                x, modes = self._cross(t, x, modes, stop)
            elif stop is not None:
                x = self.change_states(t, x, modes, stop)
            elif begin < t < end:
                return t, x, modes
            if t >= end:
                return end, x, modes
            try:
                t, x, self.guess, stop = self.advance.through(t, end, x, modes, self.guess)
            except SolverError as error:
                raise SolverError(str(error), self.trajectory()) from None

    def _cross(
        self, t: float, x: np.ndarray, modes: np.ndarray, crossing: Crossing
    ) -> tuple[np.ndarray, np.ndarray]:
        """Change modes where margins are used up."""
        self.output.edge(t, x, self._settings(modes))
        self.guess = self.closed(t, x, modes)
        x, modes = self.settled(t, x, modes, modes, crossing.fired)
        self.guess = self.closed(t, x, modes)
        self.output.open(self.system)
        self.output.edge(t, x, self._settings(modes))
        self.crossings.append(t)
        if len(self.crossings) > STORM_SIZE:
            first = self.crossings[-STORM_SIZE]
            if t - first <= 1e-9 * self.scale:
                self.storm(t)
        return x, modes

    def storm(self, t: float) -> None:
        """Stop where changes of modes follow each other without end."""
        recent = sorted({event.component for event in self.events[-STORM_SIZE:]})
        self.refuse(
            f"{STORM_SIZE} changes of mode within {1e-9 * self.scale:.2g} s before "
            f"t = {t:.9g} s, in {', '.join(recent[:6])}. Conditions that switch each other: "
            "dry friction and contacts that can rest need lumped.hold, which finds a "
            "standstill; a condition on a speed cannot."
        )

    def _leading(self, unfit: Unfit) -> tuple[str, str]:
        """Names of the states that lead after and before a change."""
        reduced = self.system._reduced
        names = []
        for node in (unfit.follower, unfit.leader):
            number, _ = reduced.class_and_order(node)
            names.append(self.system._node_name(int(reduced.first[number])))
        return names[0], names[1]

    def change_states(self, t: float, x: np.ndarray, modes: np.ndarray, unfit: Unfit) -> np.ndarray:
        """Let another motion lead, and give back the new states."""
        if t == self._changed_at:
            self.refuse(
                f"at t = {t:.9g} s no choice of states determines the position: "
                f"{' leads instead of '.join(self._leading(unfit))}. The linkage is "
                "singular there; check its lengths."
            )
        self._changed_at = t
        old, settings = self.system, self._settings(modes)
        after, before = self._leading(unfit)
        self.events.append(Event(t, after.rpartition(".")[0], before, after))
        new = old.led_by(unfit.follower, unfit.leader)
        wanted = [*new.states, *new._values.implicit]
        function = ca.Function("change", old._inputs, [old._values.of(wanted)])
        found = np.asarray(function(x, self.point.theta, t, settings)).ravel()
        self._take(new)
        self.guess = found[len(new.states) :]
        self.output.open(new)
        return found[: len(new.states)]

    def closed(self, t: float, x: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Implicit quantities at the start of a segment."""
        try:
            settings = closed_with(self.system, x, self.point.theta, t, modes, self.guess)
        except StartError as error:
            raise SolverError(str(error), self.trajectory()) from None
        return settings[len(modes) :]

    def trajectory(self) -> Trajectory:
        """What was computed so far; at least the start."""
        pieces, cost = self.output.pieces(), self.advance
        if not any(len(piece.t) for piece in pieces):
            start = (np.array([self.begin]), self.point.x[None, :], self.point.modes[None, :])
            pieces = (Piece(self.point.system, *start),)
        return Trajectory(
            self.point.system,
            pieces,
            self.point.theta,
            tuple(sorted(self.events, key=lambda event: event.time)),
            Statistics(
                cost.description,
                cost.steps,
                cost.rejected,
                cost.evaluations,
                len(pieces),
                cost.seconds,
                self._small(pieces),
                cost.implicit_from,
                cost.native,
            ),
        )

    def _small(self, pieces: tuple[Piece, ...]) -> tuple[str, ...]:
        """States that moved but stayed below ``atol / rtol``."""
        none = np.zeros((0, len(self.system.states)))
        own = [none, *(p.x for p in pieces if p.system is self.system)]
        largest = np.abs(np.concatenate(own)).max(axis=0, initial=0.0)
        atol = self.advance.atol
        # a millionth of that is rounding of something that stands still
        small = (largest * self.rtol < atol) & (largest * self.rtol > 1e-6 * atol)
        names = self.system.state_names
        return tuple(name for name, s in zip(names, small, strict=True) if s)

    def refuse(self, fault: str | None) -> None:
        """Stop with what was computed so far if something is wrong."""
        if fault:
            raise SolverError(f"{self.system.name}: {fault}", self.trajectory())
