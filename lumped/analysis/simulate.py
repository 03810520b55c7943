"""Simulation in time."""

from __future__ import annotations

import itertools
import time as clock
from collections.abc import Iterable, Sequence
from typing import Literal

import casadi as ca
import numpy as np

from lumped.analysis.calls import called
from lumped.analysis.changeover import Settler
from lumped.analysis.crossing import Crossing, Step, first_crossing
from lumped.analysis.dense import Method
from lumped.analysis.march import first_change, marched
from lumped.analysis.record import Recorder, output_times
from lumped.analysis.result import Event, OperatingPoint, Piece, Statistics, Trajectory
from lumped.analysis.settings import closed_with, modes_at
from lumped.analysis.start import start_point
from lumped.analysis.stepper import (
    ACCEPTED,
    CROSSED,
    GIVEN_UP,
    HEAD,
    REJECTED,
    STIFF_AFTER,
    Stepper,
    first_step,
)
from lumped.analysis.watch import finite_fault, jump_fault, unfit_states
from lumped.errors import OptionError, SolverError, StartError
from lumped.system import Changes, Name, System

__all__ = ["nominal_size", "simulate"]


def simulate(
    system: System,
    *,
    until: float,
    parameters: Changes | None = None,
    start: Changes | OperatingPoint | None = None,
    free: Iterable[Name] = (),
    grid: int | Sequence[float] | np.ndarray | None = 500,
    rtol: float = 1e-6,
    atol: float | None = None,
    method: Literal["auto", "explicit", "implicit"] = "auto",
    max_steps: int = 1_000_000,
) -> Trajectory:
    """Simulate from the time zero.

    Where a function of time jumps or has a kink, and where a condition, contact or friction element
    changes its mode, the method stops exactly there and starts anew.

    Parameters
    ----------
    system : System
        From `assemble`.
    until : float
        End, s.
    parameters : mapping of name to float, optional
        Parameters to change for this run.
    start : mapping of name to float, or OperatingPoint, optional
        Start values to set or change; or states and parameters to start from, as found by
        `equilibrium` or `start_point`.
    free : iterable of names
        Parameters that the start values determine (see `start_point`).
    grid : int, sequence of float, or None
        Number of equal output intervals (both sides of a jump are added), or the output times
        themselves (a value at a jump is that after it), or None for the steps of the solver.
    rtol : float
        Relative tolerance.
    atol : float, optional
        Absolute tolerance, relative to the nominal value of each state; default is
        ``rtol / 1000``, at least 1e-12. It governs a state that stays smaller than
        ``atol / rtol`` throughout; `Trajectory` names such states when printed.
    method : {"auto", "explicit", "implicit"}
        DOP853, Rodas5P, or the first until the problem turns out stiff and then the second.
    max_steps : int
        Give up after so many attempted steps.

    Returns
    -------
    Trajectory

    Raises
    ------
    OptionError
        If `until`, `grid`, `rtol`, `atol` or `method` make no sense.
    StartError
        If the start values contradict each other.
    SolverError
        If the run cannot be completed; its `partial` holds the run up to there.
    """
    _check(until, rtol, atol, method)
    times = output_times(grid, until)
    if isinstance(start, OperatingPoint):
        if start.system is not system or parameters or tuple(free):
            raise OptionError(
                "simulate: a start point brings its own parameters and belongs to the system that "
                "it was made for; give no parameters or free parameters beside it."
            )
        point = start
    else:
        point = start_point(system, parameters, start, free)
    both_sides = grid is None or isinstance(grid, int)
    run = _Run(system, point, until, times, both_sides, rtol, atol, method, max_steps)
    run.go()
    return run.trajectory()


def _check(until: float, rtol: float, atol: float | None, method: str) -> None:
    if not (isinstance(until, int | float | np.number) and np.isfinite(until) and until > 0):
        raise OptionError(f"until = {until!r} s: the end must be a positive, finite time.")
    if not 1e-14 <= rtol < 1:
        raise OptionError(f"rtol = {rtol}: the relative tolerance must lie between 1e-14 and 1.")
    if atol is not None and not atol > 0:
        raise OptionError(f"atol = {atol}: the absolute tolerance must be positive.")
    if method not in ("auto", "explicit", "implicit"):
        raise OptionError(f"method = {method!r}: choose 'auto', 'explicit' or 'implicit'.")


_STORM = 200
"""Changes of mode that may follow each other at practically the same instant."""


_Stop = Crossing | tuple[int, int, int]
"""Why a run stops for a moment: a change of modes, or of the leading states."""


class _Run:
    """One simulation: segments between instants of change, chunks of steps in them."""

    def __init__(
        self,
        system: System,
        point: OperatingPoint,
        until: float,
        times: np.ndarray | None,
        both_sides: bool,
        rtol: float,
        atol: float | None,
        method: str,
        max_steps: int,
    ) -> None:
        self.point, self.until, self.rtol = point, until, rtol
        self.relative_atol = max(rtol * 1e-3, 1e-12) if atol is None else atol
        self.output = Recorder(until, times, both_sides)
        self.auto = method == "auto"
        self.method: Method = "implicit" if method == "implicit" else "explicit"
        self.methods = [self.method]
        self.max_steps = max_steps
        self._take(system)
        self.guess = point.modes[len(point.modes) - self.implicit :]
        self.crossings: list[float] = []
        hits = point.collisions
        self.events = [Event(0.0, c.component, c.before, c.after, c.loss) for c in hits]
        self.steps = self.rejected = self.evaluations = 0
        self.seconds = 0.0

    def _take(self, system: System) -> None:
        """Integrate the states of this system from now on."""
        self.system = system
        self.implicit = len(system._values.implicit)
        self.settler = Settler(system, self.point.theta, self.until)
        nominal = [nominal_size(system, name) for name in system.state_names]
        # not below the rounding of what a state is integrated from
        self.atol = self.relative_atol * np.array(nominal)

    def go(self) -> None:
        edges = [0.0, *self._instants(), self.until]
        x, modes = self.point.x, self.point.modes[: len(self.point.modes) - self.implicit]
        timed = np.isfinite(self._thresholds())
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
        point = (np.array([t]), x[None, :], self._settings(modes)[None, :])
        stop: _Stop | None = unfit_states(self.system, self.point.theta, *point)
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
            t, x, stop = self._advance(t, end, x, modes)

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

    def _leading(self, unfit: tuple[int, int, int]) -> tuple[str, str]:
        """Names of the states that lead after and before a change."""
        reduced = self.system._reduced
        names = []
        for node in unfit[1:]:
            number, _ = reduced.class_and_order(node)
            names.append(self.system._node_name(int(reduced.first[number])))
        return names[0], names[1]

    def _change(
        self, t: float, x: np.ndarray, modes: np.ndarray, unfit: tuple[int, int, int]
    ) -> np.ndarray:
        """Let another motion lead, and give back the new states."""
        old, settings = self.system, self._settings(modes)
        after, before = self._leading(unfit)
        self.events.append(Event(t, after.rpartition(".")[0], before, after))
        new = old.led_by(*unfit[1:])
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
        pieces = self.output.pieces()
        return Trajectory(
            self.point.system,
            pieces,
            self.point.theta,
            tuple(sorted(self.events, key=lambda event: event.time)),
            Statistics(
                " then ".join(self.methods),
                self.steps,
                self.rejected,
                self.evaluations,
                len(pieces),
                self.seconds,
                self._small(pieces),
            ),
        )

    def _small(self, pieces: tuple[Piece, ...]) -> tuple[str, ...]:
        """States that moved but stayed below ``atol / rtol``."""
        own = [p.x for p in pieces if p.system is self.system and len(p.t)]
        largest = np.max([np.abs(x).max(axis=0) for x in own], axis=0, initial=0.0)
        # a millionth of that is rounding of something that stands still
        small = (largest * self.rtol < self.atol) & (largest * self.rtol > 1e-6 * self.atol)
        names = self.system.state_names
        return tuple(name for name, s in zip(names, np.atleast_1d(small), strict=False) if s)

    def _thresholds(self) -> np.ndarray:
        """Instants at which modes change with the time alone; infinite for others."""
        function, _ = self.system._flat.thresholds
        return np.asarray(function(self.point.theta)).ravel()

    def _instants(self) -> list[float]:
        found = self._thresholds()
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

    def _advance(
        self, begin: float, end: float, x: np.ndarray, modes: np.ndarray
    ) -> tuple[float, np.ndarray, _Stop | None]:
        """Time and state reached, and why before the end."""
        system, theta = self.system, self.point.theta
        if end <= begin:
            return end, x, None
        if not len(x):
            return self._static(begin, end, x, modes)
        settings = self._settings(modes)
        (f,) = called(system, "rhs")(x, theta, begin, settings)
        self._refuse(finite_fault(system, begin, x, f))
        scale = self.atol + self.rtol * np.abs(x)
        first = first_step(system, theta, (begin, end), x, f, settings, scale)
        head = np.concatenate([[begin, first, 0, 0, 0, 0], self.guess])
        while head[0] < end:
            stepper = _stepper(system, self.method, self.output.on_grid or bool(system.switching))
            started = clock.perf_counter()
            try:
                found = stepper.many(head, x, f, theta, modes, end, self.rtol, self.atol)
            except RuntimeError:
                raise SolverError(
                    f"{system.name}: the linear equations of a step cannot be solved near "
                    f"t = {head[0]:.9g} s. Use method='explicit', or check the parameters.",
                    self.trajectory(),
                ) from None
            self.seconds += clock.perf_counter() - started
            n, width = len(x), len(x) + len(self.guess)
            log, xs = found[3].reshape(-1, 3).T, found[4].reshape(-1, width)
            dense = found[5].reshape(stepper.chunk, -1, n)
            crossing = None
            if found[0][5] == CROSSED:
                row = int(np.flatnonzero(log[2] == ACCEPTED)[-1])
                before = x if row == 0 else xs[row - 1, :n]
                settings = np.concatenate([modes, xs[row, n:]])
                t = float(log[0, row])
                span = (t, float(log[1, row]) - t)
                step = Step(before, xs[row, :n], dense[row], *span, theta, settings)
                crossing = first_crossing(system, stepper.method, row, step)
            unfit, row = self._unfit(log, xs, modes)
            if crossing is not None and crossing.row < row:
                row, t = crossing.row, crossing.time
                self._collect(stepper, x, log[:, : row + 1], xs[: row + 1], dense, modes, t)
                self.guess = xs[row, len(x) :]
                return t, crossing.x, crossing
            self._collect(stepper, x, log[:, :row], xs[:row], dense, modes)
            if unfit is not None:
                self.guess = xs[row - 1, len(x) :]
                return float(log[1, row - 1]), xs[row - 1, : len(x)], unfit
            head, x, f = found[:3]
            if head[5] == CROSSED:
                head[5] = 0.0
            self.guess = head[HEAD:]
            if head[5] == GIVEN_UP:
                self._give_up(head[0], x, f, self._settings(modes))
            if self.steps + self.rejected > self.max_steps:
                raise SolverError(
                    f"{system.name}: more than max_steps = {self.max_steps} steps before "
                    f"t = {end:g} s; stopped at t = {head[0]:g} s with steps of {head[1]:.2g} s. "
                    "Loosen rtol, use method='implicit', or raise max_steps.",
                    self.trajectory(),
                )
            if self.auto and self.method == "explicit" and head[3] >= STIFF_AFTER:
                self.method = "implicit"
                self.methods.append(self.method)
        return end, x, None

    def _unfit(
        self, log: np.ndarray, xs: np.ndarray, modes: np.ndarray
    ) -> tuple[tuple[int, int, int] | None, int]:
        """State that should not lead any more, and how many attempts of a chunk still count."""
        n = len(self.system.states)
        accepted = np.flatnonzero(log[2] == ACCEPTED)
        point = (log[1, accepted], xs[accepted, :n], self._rows(modes, xs[accepted, n:]))
        unfit = unfit_states(self.system, self.point.theta, *point)
        return unfit, log.shape[1] if unfit is None else int(accepted[unfit[0]]) + 1

    def _collect(
        self,
        stepper: Stepper,
        x: np.ndarray,
        log: np.ndarray,
        xs: np.ndarray,
        dense: np.ndarray,
        modes: np.ndarray,
        until: float | None = None,
    ) -> None:
        """Count and record the attempts of one chunk that started at x, up to a time."""
        accepted = np.flatnonzero(log[2] == ACCEPTED)
        rejected = int((log[2] == REJECTED).sum())
        self.steps += len(accepted)
        self.rejected += rejected
        self.evaluations += (len(accepted) + rejected) * stepper.evaluations
        if not len(accepted):
            return
        ends, n = log[1][accepted], len(x)
        if not self.output.on_grid:
            whole = accepted if until is None else accepted[ends < until]
            self.output.add(log[1][whole], xs[whole, :n], self._rows(modes, xs[whole, n:]))
            return
        wanted = self.output.due(ends[-1] if until is None else until)
        if not len(wanted):
            return
        step = accepted[np.searchsorted(ends, wanted, "right").clip(max=len(ends) - 1)]
        before, after = np.vstack([x, xs[:-1, :n]])[step], xs[step, :n]
        fraction = (wanted - log[0][step]) / (log[1][step] - log[0][step])
        values = stepper.interpolate(fraction, before, after, dense[step])
        self.output.add(wanted, values, self._rows(modes, xs[step, n:]))

    def _rows(self, modes: np.ndarray, guesses: np.ndarray) -> np.ndarray:
        """Settings of several points."""
        return np.hstack([np.repeat(modes[None, :], len(guesses), axis=0), guesses])

    def _static(
        self, begin: float, end: float, x: np.ndarray, modes: np.ndarray
    ) -> tuple[float, np.ndarray, _Stop | None]:
        """A system without states: its functions of time and what they switch remain."""
        stop, span = None, (begin, end)
        if self.system.switching:
            change = first_change(self.system, self.point.theta, span, modes, self.guess)
            if change is not None:
                stop, end = Crossing(0, change[0], x, change[1]), change[0]
        wanted = self.output.due(end) if self.output.on_grid else np.array([end])
        times = np.append(wanted, end)
        guesses = marched(self.system, self.point.theta, begin, times, modes, self.guess)
        if guesses is None:
            self._refuse(
                f"a linkage or implicit equation could not be followed up to t = {end:g} s. Ask "
                "for more output points, or check its range."
            )
            return end, x, None
        self.output.add(wanted, np.zeros((len(wanted), 0)), self._rows(modes, guesses[:-1]))
        self.guess = guesses[-1]
        return end, x, stop

    def _refuse(self, fault: str | None) -> None:
        """Stop with what was computed so far if something is wrong."""
        if fault:
            raise SolverError(f"{self.system.name}: {fault}", self.trajectory())

    def _give_up(self, t: float, x: np.ndarray, f: np.ndarray, settings: np.ndarray) -> None:
        """Say why steps became too small: look at the present point, and at one just ahead."""
        ahead = 1e-9 * max(1.0, abs(t))
        beyond = self.system.rhs(x + ahead * f, self.point.theta, t + ahead, settings)
        for rates in (f, np.asarray(beyond).ravel()):
            self._refuse(finite_fault(self.system, t, x, rates))
        scale = self.atol + self.rtol * np.abs(x)
        worst = int(np.argmax(np.abs(f) / scale))
        raise SolverError(
            f"{self.system.name}: the step size shrank to nothing at t = {t:.9g} s; the fastest "
            f"state there is {self.system.state_names[worst]} = {x[worst]:.6g} with derivative "
            f"{f[worst]:.6g}. A quantity runs to infinity or leaves the range of a function.",
            self.trajectory(),
        )


def nominal_size(system: System, name: str) -> float:
    """Usual size of a state, to which the absolute tolerance is relative."""
    return system.quantity(name).nominal if "(" not in name else 1.0


def _stepper(system: System, method: Method, dense: bool) -> Stepper:
    key = (method, dense)
    if key not in system.made:
        system.made[key] = Stepper.build(system, method, dense)
    stepper: Stepper = system.made[key]
    return stepper
