"""Advance through a smooth part of a run, one chunk of steps after the other."""

from __future__ import annotations

import math
import time as clock
from typing import NamedTuple

import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.kernel.blocks import MOST_DENSE
from lumped.numerics.inside_step import Method
from lumped.timeloop.calls import called
from lumped.timeloop.crossing import CROWDED, Crossing, Step, first_crossing
from lumped.timeloop.guards import (
    Unfit,
    finite_fault,
    may_be_unfit,
    shrinking_fault,
    singular_fault,
    unfit_states,
)
from lumped.timeloop.machine import Machine, machine, patience
from lumped.timeloop.recorder import Recorder
from lumped.timeloop.stepper import (
    ACCEPTED,
    CROSSED,
    GIVEN_UP,
    HEAD,
    REJECTED,
    STIFF_AFTER,
    Stepper,
    first_step,
)
from lumped.timeloop.without_states import first_change, marched

__all__ = ["Advance", "Reached", "nominals"]


class Reached(NamedTuple):
    """Where a run stops, and why: modes change, or the leading states; None at the end.

    Attributes
    ----------
    t : float
        Instant, s.
    x, guess : ndarray
        States and implicit quantities there.
    stop : Crossing, Unfit or None
        What must change.
    """

    t: float
    x: np.ndarray
    guess: np.ndarray
    stop: Crossing | Unfit | None


class _Chunk(NamedTuple):
    """A chunk of attempts: rows of times before and after and outcomes, states, dense output."""

    log: np.ndarray
    xs: np.ndarray
    dense: np.ndarray

    def head(self, count: int) -> _Chunk:
        """The first of the attempts."""
        return _Chunk(self.log[:, :count], self.xs[:count], self.dense)


class Advance:
    """Steps of a run, recorded and counted.

    Parameters
    ----------
    theta : ndarray
        Parameters.
    rtol, atol : float
        Tolerances; the absolute one relative to nominal values.
    method : {"auto", "steps", "explicit", "implicit"}
        As for `simulate`.
    max_steps : int
        Give up after so many attempts.
    output : Recorder
        Takes what is computed.

    Attributes
    ----------
    methods : list of str
        Methods used, in order.
    native : bool
        Whether steps were made in machine code.
    steps, rejected, evaluations : int
        Accepted and rejected steps, evaluations of the right-hand side.
    seconds : float
        Wall time of the stepping.
    atol : ndarray, shape (n,)
        Absolute tolerance of each state.
    implicit_from : float
        When the implicit method took over, s; infinite if it did not.
    """

    def __init__(
        self,
        theta: np.ndarray,
        rtol: float,
        atol: float,
        method: str,
        max_steps: int,
        output: Recorder,
    ) -> None:
        self._theta, self.rtol, self._relative_atol = theta, rtol, atol
        self.auto, self.max_steps, self._output = method in ("auto", "steps"), max_steps, output
        self.method: Method = "implicit" if method == "implicit" else "explicit"
        self.methods: list[str] = []
        self.native = False
        self.implicit_from = 0.0 if method == "implicit" else math.inf
        self.steps = self.rejected = self.evaluations = 0
        self.seconds = 0.0
        self._stops = [math.nan, math.nan]

    def take(self, system: System) -> None:
        """Integrate the states of this system from now on."""
        self._system = system
        # not below the rounding of what a state is integrated from
        self.atol = self._relative_atol * nominals(system)

    @property
    def description(self) -> str:
        """Methods used, in words."""
        return " then ".join(self.methods or [self.method])

    def code(self) -> Machine | None:
        """The system as machine code if that pays by now."""
        system, wait = self._system, self._patience()
        if self.seconds < wait or self.is_large:
            return None
        return machine(system)

    @property
    def is_large(self) -> bool:
        """Whether there are too many states for dense matrices, which the method needs."""
        return self.method == "implicit" and len(self._system.states) > MOST_DENSE

    def _patience(self) -> float:
        """Time of stepping in this run after which machine code is made, s."""
        return 0.0 if self.native else patience(self._system)

    def used(self, method: str) -> None:
        """Note a method for the statistics."""
        if method not in self.methods:
            self.methods.append(method)

    def change(self, t: float) -> None:
        """Go on with the implicit method."""
        self.method, self.implicit_from = "implicit", t
        self.used(self.method)

    def through(
        self, begin: float, end: float, x: np.ndarray, modes: np.ndarray, guess: np.ndarray
    ) -> Reached:
        """Advance as far as modes and leading states stay.

        Raises
        ------
        SolverError
            If that is not possible.
        """
        self.used(self.method)
        if end <= begin:
            return Reached(end, x, guess, None)
        if not len(x):
            return self._without_states(begin, end, modes, guess)
        system, theta = self._system, self._theta
        settings = np.concatenate([modes, guess])
        (f,) = called(system, "rhs")(x, theta, begin, settings)
        self._refuse(finite_fault(system, begin, x, f))
        scale = self.atol + self.rtol * np.abs(x)
        first = first_step(system, theta, (begin, end), x, f, settings, scale)
        head = np.concatenate([[begin, first, 0, 0, 0, 0], guess])
        fresh, wait = True, self._patience()
        while head[0] < end:
            before = x
            head, x, f, chunk, stepper = self._chunk(head, x, f, modes, end, fresh)
            fresh = False
            crossing, unfit, row = None, *self._unfit(chunk, modes)
            if head[5] == CROSSED:
                crossing = self._crossing(stepper, before, chunk, modes)
            if crossing is not None and crossing.row < row:
                row = crossing.row
                self._stops = [self._stops[1], crossing.time]
                self._record(stepper, before, chunk.head(row + 1), modes, crossing.time)
                return Reached(crossing.time, crossing.x, chunk.xs[row, len(x) :], crossing)
            self._record(stepper, before, chunk.head(row), modes)
            if unfit is not None:
                last = chunk.xs[row - 1]
                return Reached(chunk.log[1, row - 1], last[: len(x)], last[len(x) :], unfit)
            if head[5] == CROSSED:
                head[5] = 0.0
            self.give_up(head, x, f, modes, end)
            if self.auto and self.method == "explicit" and head[3] >= STIFF_AFTER:
                self.change(float(head[0]))
            if self.seconds >= wait and not self.is_large and head[0] < end:
                return Reached(float(head[0]), x, head[HEAD:], None)
        return Reached(end, x, head[HEAD:], None)

    def _chunk(
        self,
        head: np.ndarray,
        x: np.ndarray,
        f: np.ndarray,
        modes: np.ndarray,
        end: float,
        fresh: bool,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, _Chunk, Stepper]:
        """Make some steps."""
        system = self._system
        dense = self._output.on_grid or bool(system.switching)
        stepper = _stepper(system, self.method, dense)
        call = stepper.few if fresh else stepper.many
        started = clock.perf_counter()
        try:
            found = call(head, x, f, self._theta, modes, end, self.rtol, self.atol)
        except RuntimeError:
            raise SolverError(f"{system.name}: {singular_fault(head[0])}") from None
        self.seconds += clock.perf_counter() - started
        xs = found[4].reshape(-1, len(x) + len(head) - HEAD)
        log = found[3].reshape(-1, 3).T
        chunk = _Chunk(log, xs, found[5].reshape(len(xs), -1, len(x)))
        head, x, f = found[:3]
        return head, x, f, chunk, stepper

    def _crossing(
        self, stepper: Stepper, x: np.ndarray, chunk: _Chunk, modes: np.ndarray
    ) -> Crossing | None:
        """Where modes must change in the last step of a chunk that started at x, if they must."""
        n, xs = len(x), chunk.xs
        row = int(np.flatnonzero(chunk.log[2] == ACCEPTED)[-1])
        before = x if row == 0 else xs[row - 1, :n]
        settings = np.concatenate([modes, xs[row, n:]])
        begin, end = chunk.log[:2, row].tolist()
        step = Step(
            before, xs[row, :n], chunk.dense[row], begin, end - begin, self._theta, settings
        )
        crowded = abs(begin - self._stops[0]) <= CROWDED * (1.0 + abs(begin))
        return first_crossing(self._system, stepper.method, row, step, crowded)

    def _unfit(self, chunk: _Chunk, modes: np.ndarray) -> tuple[Unfit | None, int]:
        """State that should not lead any more, and how many attempts of a chunk still count."""
        if not may_be_unfit(self._system):
            return None, chunk.log.shape[1]
        n = len(self._system.states)
        accepted = np.flatnonzero(chunk.log[2] == ACCEPTED)
        xs = chunk.xs[accepted]
        unfit = unfit_states(
            self._system, self._theta, chunk.log[1, accepted], xs[:, :n], modes, xs[:, n:]
        )
        return unfit, chunk.log.shape[1] if unfit is None else int(accepted[unfit.point]) + 1

    def _record(
        self,
        stepper: Stepper,
        x: np.ndarray,
        chunk: _Chunk,
        modes: np.ndarray,
        until: float | None = None,
    ) -> None:
        """Count and record the attempts of a chunk that started at x, up to a time."""
        log, xs, dense = chunk
        accepted = np.flatnonzero(log[2] == ACCEPTED)
        rejected = int((log[2] == REJECTED).sum())
        self.steps += len(accepted)
        self.rejected += rejected
        self.evaluations += (len(accepted) + rejected) * stepper.evaluations
        if not len(accepted):
            return
        ends, n = log[1][accepted], len(x)
        if not self._output.on_grid:
            whole = accepted if until is None else accepted[ends < until]
            self._output.add(log[1][whole], xs[whole, :n], _rows(modes, xs[whole, n:]))
            return
        wanted = self._output.due(ends[-1] if until is None else until)
        if not len(wanted):
            return
        step = accepted[np.searchsorted(ends, wanted, "right").clip(max=len(ends) - 1)]
        before, after = np.vstack([x, xs[:-1, :n]])[step], xs[step, :n]
        fraction = (wanted - log[0][step]) / (log[1][step] - log[0][step])
        values = stepper.interpolate(fraction, before, after, dense[step])
        self._output.add(wanted, values, _rows(modes, xs[step, n:]))

    def _without_states(
        self, begin: float, end: float, modes: np.ndarray, guess: np.ndarray
    ) -> Reached:
        """A system without states: its functions of time and what they switch remain."""
        stop, x = None, np.zeros(0)
        if self._system.switching:
            change = first_change(self._system, self._theta, (begin, end), modes, guess)
            if change is not None:
                stop, end = Crossing(0, change[0], x, change[1]), change[0]
        wanted = self._output.due(end) if self._output.on_grid else np.array([end])
        times = np.append(wanted, end)
        guesses = marched(self._system, self._theta, begin, times, modes, guess)
        if guesses is None:
            raise SolverError(
                f"{self._system.name}: a linkage or implicit equation could not be followed up to "
                f"t = {end:g} s. Ask for more output points, or check its range."
            )
        self._output.add(wanted, np.zeros((len(wanted), 0)), _rows(modes, guesses[:-1]))
        return Reached(end, x, guesses[-1], stop)

    def give_up(
        self, head: np.ndarray, x: np.ndarray, f: np.ndarray, modes: np.ndarray, end: float
    ) -> None:
        """Stop if steps have become too small or too many."""
        system, t = self._system, float(head[0])
        if head[5] == GIVEN_UP:
            settings = np.concatenate([modes, head[HEAD:]])
            scale = self.atol + self.rtol * np.abs(x)
            self._refuse(shrinking_fault(system, self._theta, t, x, f, settings, scale))
        if self.steps + self.rejected > self.max_steps:
            other = "use method='implicit', " if self.method == "explicit" else ""
            self._refuse(
                f"more than max_steps = {self.max_steps} steps before t = {end:g} s; stopped at "
                f"t = {t:g} s with steps of {head[1]:.2g} s. Loosen rtol, {other}or raise "
                "max_steps."
            )

    def _refuse(self, fault: str | None) -> None:
        if fault:
            raise SolverError(f"{self._system.name}: {fault}")


def _rows(modes: np.ndarray, guesses: np.ndarray) -> np.ndarray:
    """Settings of several points."""
    return np.hstack([np.repeat(modes[None, :], len(guesses), axis=0), guesses])


def nominals(system: System) -> np.ndarray:
    """Nominal value of each state."""
    if "nominals" not in system.made:
        names = system.state_names
        found = [system.quantity(n).nominal if "(" not in n else 1.0 for n in names]
        system.made["nominals"] = np.array(found)
    sizes: np.ndarray = system.made["nominals"]
    return sizes


def _stepper(system: System, method: Method, dense: bool) -> Stepper:
    key = (method, dense)
    if key not in system.made:
        system.made[key] = Stepper.build(system, method, dense)
    stepper: Stepper = system.made[key]
    return stepper
