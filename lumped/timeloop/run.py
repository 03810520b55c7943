"""What all runs have: where they start, their events, what was computed so far."""

from __future__ import annotations

from collections.abc import Iterator
from operator import attrgetter

import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.timeloop.guards import jump_fault
from lumped.timeloop.instants import instants
from lumped.timeloop.programs import Answers
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.results.recorder import Recorder, scale
from lumped.timeloop.results.statistics import Statistics, Used
from lumped.timeloop.results.trajectory import Again, Piece, Read, Trajectory
from lumped.timeloop.run_options import RunPlan

_TIME = attrgetter("time")
_NONE = np.zeros(0)


class Simulation:
    """One simulation.

    Parameters
    ----------
    point : OperatingPoint
        Where it starts.
    plan : RunPlan
        Its options.
    output : Recorder
        Takes what is computed.

    Attributes
    ----------
    methods : list of Used
        Methods used, one after the other.
    steps, rejected, evaluations : int
        Accepted and rejected steps, evaluations of the right-hand side.
    seconds : float
        Wall time of the stepping.
    largest : ndarray
        Largest size that each state of the system had at a step; empty without steps.
    """

    def __init__(self, point: OperatingPoint, plan: RunPlan, output: Recorder) -> None:
        self.point, self.output = point, output
        self.until, self.rtol, self.max_steps = plan.until, plan.rtol, plan.max_steps
        self.begin, self.span = point.time, scale(point.time, plan.until)
        self.system: System = point.system
        self.methods: list[Used] = []
        self.steps = self.rejected = self.evaluations = 0
        self.seconds = 0.0
        self.atol = self.largest = _NONE
        self.answers = Answers(point.program_inputs)
        hits = point.collisions
        self.events = [
            Event(self.begin, c.component, "hold", c.before, c.after, c.loss) for c in hits
        ]

    def find_instants(self) -> np.ndarray:
        """Ends of the segments between instants of functions of time, s."""
        self.instants = instants(self.system, self.point.theta, self.begin, self.until)
        self.events += self.instants.events
        return self.instants.edges

    def refuse_jump(self, t: float, x: np.ndarray, before: np.ndarray, after: np.ndarray) -> None:
        """Stop where a prescribed motion jumps that bodies would have to follow."""
        self.refuse(jump_fault(self.system, self.point.theta, t, x, before, after))

    def trajectory(self, read: Read | None = None, again: Again | None = None) -> Trajectory:
        """The run up to its end, with what makes it again (see `Trajectory`)."""
        return self._up_to(self.until, read, again)

    def partial(self) -> Trajectory:
        """What was computed so far; at least the start."""
        ends = [float(piece.t[-1]) for piece in self.output.pieces() if len(piece.t)]
        return self._up_to(ends[-1] if ends else self.begin)

    def _up_to(
        self, end: float, read: Read | None = None, again: Again | None = None
    ) -> Trajectory:
        pieces = self.output.pieces()
        if not any(map(len, [piece.t for piece in pieces])):
            start = (np.array([self.begin]), self.point.x[None, :], self.point.settings[None, :])
            pieces = (Piece(self.point.system, *start),)
        return Trajectory(
            self.point.system,
            pieces,
            self.point.theta,
            tuple(sorted(self._cut_events(end), key=_TIME)) if self.events else (),
            Statistics(
                tuple(self.methods),
                self.steps,
                self.rejected,
                self.evaluations,
                len(pieces),
                self.seconds,
                self._small(),
            ),
            read=read,
            again=again,
            program_inputs=self.answers.program_inputs,
        )

    def _cut_events(self, end: float) -> Iterator[Event]:
        """Events up to a time; bounces that end later end there."""
        for event in self.events:
            if event.time <= end:
                yield event
            elif event.kind == "hold":
                yield event._replace(time=end)

    def _small(self) -> tuple[str, ...]:
        """States that moved but stayed below ``atol / rtol``."""
        if not len(self.largest):
            return ()
        tolerated = self.largest * self.rtol
        small = tolerated < self.atol
        if not small.any():
            return ()
        small &= tolerated > 1e-6 * self.atol  # less is rounding of something that stands still
        names = self.system.state_names
        return tuple(names[i] for i in np.flatnonzero(small).tolist())

    def refuse(self, fault: str | None) -> None:
        """Stop with what was computed so far if something is wrong."""
        if fault:
            raise SolverError(f"{self.system.name}: {fault}", self.partial())
