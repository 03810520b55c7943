"""A run: from one change of modes or leading states to the next."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import casadi as ca
import numpy as np

from lumped.analysis.advance import Advance
from lumped.analysis.changeover import Settler
from lumped.analysis.crossing import Crossing
from lumped.analysis.exact import Exact
from lumped.analysis.record import Recorder
from lumped.analysis.result import Event, OperatingPoint, Piece, Statistics, Trajectory
from lumped.analysis.settings import closed_with, instants, modes_at
from lumped.analysis.watch import Unfit, jump_fault, unfit_states
from lumped.errors import SolverError, StartError
from lumped.system import System

__all__ = ["Run"]

_STORM = 200
"""Changes of mode that may follow each other at practically the same instant."""


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
        self.advance, self.output = advance, output
        self._take(point.system)
        self.guess = point.modes[len(point.modes) - self.implicit :]
        self.crossings: list[float] = []
        hits = point.collisions
        self.events = [Event(0.0, c.component, c.before, c.after, c.loss) for c in hits]

    def _take(self, system: System) -> None:
        """Integrate the states of this system from now on."""
        self.system = system
        self.implicit = len(system._values.implicit)
        self.settler = Settler(system, self.point.theta, self.until)
        self.advance.take(system)

    def go(self) -> None:
        """Run to the end.

        Raises
        ------
        SolverError
            With what was computed so far.
        """
        edges = [0.0, *self._instants(), self.until]
        x, modes = self.point.x, self.point.modes[: len(self.point.modes) - self.implicit]
        timed = np.isfinite(instants(self.system, self.point.theta))
        for number, (begin, end) in enumerate(itertools.pairwise(edges)):
            before, modes = modes, modes.copy()
            now = modes_at(self.system, self.point.theta, 0.5 * (begin + end))
            modes[timed] = now[timed]
            if number:
                sides = (np.concatenate([m, self.guess]) for m in (before, modes))
                self._refuse(jump_fault(self.system, self.point.theta, begin, x, *sides))
            x, modes = self._settled(begin, x, modes, before)
            self.guess = self._closed(begin, x, modes)
            self.output.open(self.system)
            self.output.edge(begin, x, self._settings(modes))
            x, modes = self._through(begin, end, x, modes)
            if self.output.on_grid and end > begin:
                self.output.edge(end, x, self._settings(modes))
        self.output.finish(x, self._settings(modes))

    def _settled(
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
    ) -> tuple[np.ndarray, np.ndarray]:
        """Advance to the end of a segment, from one change of modes or states to the next."""
        t, changed_at = begin, -1.0
        point = (np.array([t]), x[None, :], modes, self.guess[None, :])
        stop: Crossing | Unfit | None = unfit_states(self.system, self.point.theta, *point)
        while True:
            if isinstance(stop, Crossing):
                x, modes = self._cross(t, x, modes, stop)
            elif stop is not None:
                if t == changed_at:
                    self._refuse(
                        f"at t = {t:.9g} s no choice of states determines the position: "
                        f"{' leads instead of '.join(self._leading(stop))}. The linkage is "
                        "singular there; check its lengths."
                    )
                x, changed_at = self._change(t, x, modes, stop), t
            if t >= end:
                return x, modes
            try:
                t, x, self.guess, stop = self.advance.through(t, end, x, modes, self.guess)
            except SolverError as error:
                raise SolverError(str(error), self.trajectory()) from None

    def _cross(
        self, t: float, x: np.ndarray, modes: np.ndarray, crossing: Crossing
    ) -> tuple[np.ndarray, np.ndarray]:
        """Change modes where margins are used up."""
        self.output.edge(t, x, self._settings(modes))
        self.guess = self._closed(t, x, modes)
        x, modes = self._settled(t, x, modes, modes, crossing.fired)
        self.guess = self._closed(t, x, modes)
        self.output.open(self.system)
        self.output.edge(t, x, self._settings(modes))
        self.crossings.append(t)
        if len(self.crossings) > _STORM and t - self.crossings[-_STORM] <= 1e-9 * self.until:
            recent = sorted({event.component for event in self.events[-_STORM:]})
            self._refuse(
                f"{_STORM} changes of mode within {t - self.crossings[-_STORM]:.2g} s before "
                f"t = {t:.9g} s, in {', '.join(recent[:6])}. Conditions that switch each other: "
                "dry friction and contacts that can rest need lumped.hold, which finds a "
                "standstill; a condition on a speed cannot."
            )
        return x, modes

    def _leading(self, unfit: Unfit) -> tuple[str, str]:
        """Names of the states that lead after and before a change."""
        reduced = self.system._reduced
        names = []
        for node in (unfit.follower, unfit.leader):
            number, _ = reduced.class_and_order(node)
            names.append(self.system._node_name(int(reduced.first[number])))
        return names[0], names[1]

    def _change(self, t: float, x: np.ndarray, modes: np.ndarray, unfit: Unfit) -> np.ndarray:
        """Let another motion lead, and give back the new states."""
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

    def _closed(self, t: float, x: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Implicit quantities at the start of a segment."""
        try:
            settings = closed_with(self.system, x, self.point.theta, t, modes, self.guess)
        except StartError as error:
            raise SolverError(str(error), self.trajectory()) from None
        return settings[len(modes) :]

    def trajectory(self) -> Trajectory:
        """What was computed so far."""
        pieces, cost = self.output.pieces(), self.advance
        return Trajectory(
            self.point.system,
            pieces,
            self.point.theta,
            tuple(sorted(self.events, key=lambda event: event.time)),
            Statistics(
                " then ".join(cost.methods),
                cost.steps,
                cost.rejected,
                cost.evaluations,
                len(pieces),
                cost.seconds,
                self._small(pieces),
                cost.implicit_from,
            ),
        )

    def _small(self, pieces: tuple[Piece, ...]) -> tuple[str, ...]:
        """States that moved but stayed below ``atol / rtol``."""
        own = [p.x for p in pieces if p.system is self.system]
        largest = np.abs(np.concatenate(own)).max(axis=0, initial=0.0) if own else np.zeros(0)
        atol = self.advance.atol
        # a millionth of that is rounding of something that stands still
        small = (largest * self.rtol < atol) & (largest * self.rtol > 1e-6 * atol)
        names = self.system.state_names
        return tuple(name for name, s in zip(names, small, strict=True) if s)

    def _instants(self) -> list[float]:
        found = instants(self.system, self.point.theta)
        inside = (found > 0) & (found <= self.until)
        edges: list[float] = []
        for t in np.unique(found[inside]).tolist():
            if not edges or t - edges[-1] > 1e-13 * self.until:
                edges.append(self.until if self.until - t <= 1e-13 * self.until else t)
        owners: list[list[str]] = [[] for _ in edges]
        for group in self.system._flat.groups:
            n = len(group.template.modes)
            for i, name in enumerate(group.names if n else ()):
                own = found[group.first_mode + i * n : group.first_mode + (i + 1) * n]
                near = np.abs(own[:, None] - edges) <= 1e-13 * self.until
                for k in np.flatnonzero(near.any(axis=0)):
                    owners[k].append(name)
        self.events += [Event(t, ", ".join(names)) for t, names in zip(edges, owners, strict=True)]
        return edges

    def _refuse(self, fault: str | None) -> None:
        """Stop with what was computed so far if something is wrong."""
        if fault:
            raise SolverError(f"{self.system.name}: {fault}", self.trajectory())
