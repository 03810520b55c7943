"""Simulation in time."""

from __future__ import annotations

import itertools
import time as clock
from collections.abc import Sequence
from typing import Literal

import casadi as ca
import numpy as np

from lumped.analysis.result import Event, OperatingPoint, Statistics, Trajectory
from lumped.analysis.start import modes_at, start_point
from lumped.analysis.stepper import ACCEPTED, CLOSED, HEAD, REJECTED, STIFF_AFTER, Method, Stepper
from lumped.analysis.watch import finite_fault, jump_fault, leverage_fault
from lumped.errors import OptionError, SolverError
from lumped.system import Changes, System

__all__ = ["simulate"]

_SUBSTEPS = 16
"""Steps between output times in which a system without states follows its implicit quantities."""


def simulate(
    system: System,
    *,
    until: float,
    parameters: Changes | None = None,
    start: Changes | None = None,
    grid: int | Sequence[float] | np.ndarray | None = 500,
    rtol: float = 1e-6,
    atol: float | None = None,
    method: Literal["auto", "explicit", "implicit"] = "auto",
    max_steps: int = 1_000_000,
) -> Trajectory:
    """Simulate from the time zero.

    Where a function of time jumps or has a kink, the method stops exactly there and starts anew.

    Parameters
    ----------
    system : System
        From `assemble`.
    until : float
        End, s.
    parameters : mapping of name to float, optional
        Parameters to change for this run.
    start : mapping of name to float, optional
        Start values to set or change.
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
    times = _times(grid, until)
    point = start_point(system, parameters, start)
    both_sides = grid is None or isinstance(grid, int)
    run = _Run(system, point, until, times, both_sides, rtol, atol, method, max_steps)
    run.go()
    return run.trajectory()


def _check(until: float, rtol: float, atol: float | None, method: str) -> None:
    if not (np.isfinite(until) and until > 0):
        raise OptionError(f"until = {until} s: the end must be a positive, finite time.")
    if not 1e-14 <= rtol < 1:
        raise OptionError(f"rtol = {rtol}: the relative tolerance must lie between 1e-14 and 1.")
    if atol is not None and not atol > 0:
        raise OptionError(f"atol = {atol}: the absolute tolerance must be positive.")
    if method not in ("auto", "explicit", "implicit"):
        raise OptionError(f"method = {method!r}: choose 'auto', 'explicit' or 'implicit'.")


def _times(grid: int | Sequence[float] | np.ndarray | None, until: float) -> np.ndarray | None:
    if grid is None:
        return None
    if isinstance(grid, int | np.integer):
        if grid < 1:
            raise OptionError(f"grid = {grid}: at least one output interval is needed.")
        return np.linspace(0.0, until, int(grid) + 1)
    times = np.asarray(grid, dtype=float)
    if times.ndim != 1 or not len(times) or (np.diff(times) < 0).any():
        raise OptionError("grid: the output times must be a list that does not decrease.")
    if times[0] < 0 or times[-1] > until:
        raise OptionError(
            f"grid: output times from {times[0]:g} to {times[-1]:g} s leave 0 to {until:g} s."
        )
    return times


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
        self.system, self.point, self.until, self.times = system, point, until, times
        self.both_sides, self.rtol = both_sides, rtol
        nominal = [_nominal(system, name) for name in system.state_names]
        # not below the rounding of what a state is integrated from
        self.atol = (max(rtol * 1e-3, 1e-12) if atol is None else atol) * np.array(nominal)
        self.auto = method == "auto"
        self.method: Method = "implicit" if method == "implicit" else "explicit"
        self.methods = [self.method]
        self.max_steps = max_steps
        self.t: list[np.ndarray] = []
        self.x: list[np.ndarray] = []
        self.segment: list[np.ndarray] = []
        self.modes: list[np.ndarray] = []
        self.guesses: list[np.ndarray] = []
        self.implicit = len(system._values.implicit)
        self.guess = point.modes[len(point.modes) - self.implicit :]
        self.events: list[Event] = []
        self.steps = self.rejected = self.evaluations = 0
        self.seconds = 0.0
        self.next_output = 0

    def go(self) -> None:
        edges = [0.0, *self._instants(), self.until]
        x = self.point.x
        for number, (begin, end) in enumerate(itertools.pairwise(edges)):
            modes = modes_at(self.system, self.point.theta, 0.5 * (begin + end))
            if number:
                before, after = (np.concatenate([m, self.guess]) for m in (self.modes[-1], modes))
                theta = self.point.theta
                self._refuse(jump_fault(self.system, theta, begin, x, before, after))
            self.modes.append(modes)
            self.guess = self._closed(begin, x, modes)
            if self.both_sides:
                self._record(np.array([begin]), x[None, :])
                self._skip_outputs(begin)
            x = self._advance(begin, end, x, modes)
            if self.both_sides and self.times is not None and end > begin:
                self._record(np.array([end]), x[None, :])
                self._skip_outputs(end)
        if self.times is not None:
            rest = self.times[self.next_output :]
            self._record(rest, np.repeat(x[None, :], len(rest), axis=0))

    def _skip_outputs(self, t: float) -> None:
        """Leave out grid points that coincide with the edge of a segment."""
        if self.times is not None:
            close = np.searchsorted(self.times, t + 1e-13 * self.until, "right")
            self.next_output = max(self.next_output, int(close))

    def _closed(self, t: float, x: np.ndarray, modes: np.ndarray) -> np.ndarray:
        """Implicit quantities at the start of a segment."""
        guess = self.guess
        for _ in range(2 if self.implicit else 0):
            settings = np.concatenate([modes, guess])
            found = self.system.closure(x, self.point.theta, t, settings)[0]
            guess = np.asarray(found).ravel()
        return guess

    def _record(self, t: np.ndarray, x: np.ndarray, guesses: np.ndarray | None = None) -> None:
        if guesses is None:
            guesses = np.repeat(self.guess[None, :], len(t), axis=0)
        self.t.append(t)
        self.x.append(x)
        self.guesses.append(guesses)
        self.segment.append(np.full(len(t), len(self.modes) - 1))

    def trajectory(self) -> Trajectory:
        """What was computed so far."""
        n = len(self.system.states)
        return Trajectory(
            self.system,
            np.concatenate([np.zeros(0), *self.t]),
            np.concatenate([np.zeros((0, n)), *self.x]),
            np.concatenate([np.zeros(0, dtype=int), *self.segment]),
            self.point.theta,
            np.array(self.modes).reshape(len(self.modes), -1),
            np.concatenate([np.zeros((0, self.implicit)), *self.guesses]),
            tuple(self.events),
            Statistics(
                " then ".join(self.methods),
                self.steps,
                self.rejected,
                self.evaluations,
                len(self.modes),
                self.seconds,
                self._small(),
            ),
        )

    def _small(self) -> tuple[str, ...]:
        """States that moved but stayed below ``atol / rtol``."""
        largest = np.max([np.abs(x).max(axis=0) for x in self.x if len(x)], axis=0, initial=0.0)
        # a millionth of that is rounding of something that stands still
        small = (largest * self.rtol < self.atol) & (largest * self.rtol > 1e-6 * self.atol)
        names = self.system.state_names
        return tuple(name for name, s in zip(names, np.atleast_1d(small), strict=False) if s)

    def _instants(self) -> list[float]:
        function, directions = self.system._thresholds
        if not len(directions):
            return []
        found = np.asarray(function(self.point.theta)).ravel()
        inside = (found > 0) & (found <= self.until)
        edges: list[float] = []
        for t in np.unique(found[inside]).tolist():
            if not edges or t - edges[-1] > 1e-13 * self.until:
                edges.append(self.until if self.until - t <= 1e-13 * self.until else t)
        for t in edges:
            names = []
            for group in self.system._flat.groups:
                n = len(group.template.modes)
                for i, name in enumerate(group.names):
                    place = group.first_mode + i * n
                    if (abs(found[place : place + n] - t) <= 1e-13 * self.until).any():
                        names.append(name)
            self.events.append(Event(t, ", ".join(names)))
        return edges

    def _advance(self, begin: float, end: float, x: np.ndarray, modes: np.ndarray) -> np.ndarray:
        system, theta = self.system, self.point.theta
        if end <= begin:
            return x
        if not len(x):
            self._static(begin, end, modes)
            return x
        settings = np.concatenate([modes, self.guess])
        f = np.asarray(system.rhs(x, theta, begin, settings)).ravel()
        self._refuse(finite_fault(system, begin, x, f))
        first = self._first_step(begin, end, x, f, settings)
        head = np.concatenate([[begin, first, 0, 0, 0, 0], self.guess])
        while head[0] < end:
            stepper = _stepper(system, self.method, self.times is not None)
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
            head, new_x, new_f = (np.asarray(found[i]).ravel() for i in range(3))
            self._collect(stepper, x, np.asarray(found[3]), np.asarray(found[4]).T, found[5])
            x, f, self.guess = new_x, new_f, head[HEAD:]
            settings = np.concatenate([modes, self.guess])
            self._refuse(leverage_fault(system, theta, head[0], x, settings))
            if head[5]:
                self._give_up(head[0], x, f)
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
        return x

    def _collect(
        self, stepper: Stepper, x: np.ndarray, log: np.ndarray, xs: np.ndarray, dense: ca.DM
    ) -> None:
        """Count and record the attempts of one chunk that started at x."""
        accepted = np.flatnonzero(log[2] == ACCEPTED)
        rejected = int((log[2] == REJECTED).sum())
        self.steps += len(accepted)
        self.rejected += rejected
        self.evaluations += (len(accepted) + rejected) * stepper.evaluations
        if not len(accepted):
            return
        ends, n = log[1][accepted], len(x)
        if self.times is None:
            self._record(ends, xs[accepted, :n], xs[accepted, n:])
            return
        stop = int(np.searchsorted(self.times, ends[-1], "left"))
        wanted = self.times[self.next_output : stop]
        if not len(wanted):
            return
        step = accepted[np.searchsorted(ends, wanted, "right").clip(max=len(ends) - 1)]
        before, after = np.vstack([x, xs[:-1, :n]])[step], xs[step, :n]
        attempts = log.shape[1]
        coefficients = np.asarray(dense).T.reshape(attempts, -1, n)[step]
        fraction = (wanted - log[0][step]) / (log[1][step] - log[0][step])
        values = stepper.interpolate(fraction, before, after, coefficients)
        self._record(wanted, values, xs[step, n:])
        self.next_output = stop

    def _static(self, begin: float, end: float, modes: np.ndarray) -> None:
        """A system without states: only its functions of time remain."""
        if self.times is None:
            wanted = np.array([end])
        else:
            stop = int(np.searchsorted(self.times, end, "left"))
            wanted = self.times[self.next_output : stop]
            self.next_output = max(stop, self.next_output)
        guesses = self._marched(np.append(wanted, end), begin, modes)
        self._record(wanted, np.zeros((len(wanted), 0)), guesses[:-1])
        self.guess = guesses[-1]

    def _marched(self, times: np.ndarray, begin: float, modes: np.ndarray) -> np.ndarray:
        """Implicit quantities of a system without states, each from those shortly before."""
        count = len(times)
        if not self.implicit:
            return np.zeros((count, 0))
        fine = np.interp(
            np.arange(1, count * _SUBSTEPS + 1) / _SUBSTEPS,
            np.arange(count + 1),
            np.concatenate([[begin], times]),
        )
        guess, t, m = ca.MX.sym("g", self.implicit), ca.MX.sym("t"), ca.MX.sym("m", len(modes))
        settings = ca.vertcat(m, guess)
        found, step = self.system.closure(ca.MX(0, 1), self.point.theta, t, settings)
        march = ca.Function("march", [guess, t, m], [found, step]).mapaccum(len(fine))
        columns = np.repeat(modes[:, None], len(fine), axis=1)
        guesses, steps = (np.asarray(v) for v in march(self.guess, fine[None, :], columns))
        if not np.abs(steps).max() <= CLOSED * (1 + np.abs(guesses).max()):
            raise SolverError(
                f"{self.system.name}: a linkage or implicit equation could not be followed up to "
                f"t = {times[-1]:g} s. Ask for more output points, or check its range.",
                self.trajectory(),
            )
        return guesses.T[_SUBSTEPS - 1 :: _SUBSTEPS]

    def _first_step(
        self, begin: float, end: float, x: np.ndarray, f: np.ndarray, settings: np.ndarray
    ) -> float:
        """Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4."""
        scale = self.atol + self.rtol * np.abs(x)
        d0, d1 = _rms(x / scale), _rms(f / scale)
        h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
        h0 = min(h0, end - begin)
        rate = self.system.rhs(x + h0 * f, self.point.theta, begin + h0, settings)
        d2 = _rms((np.asarray(rate).ravel() - f) / scale) / h0
        steepest = max(d1, d2)
        h1 = max(1e-6, h0 * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** (1 / 8)
        first = min(100 * h0, h1, end - begin)
        return first if np.isfinite(first) and first > 0 else 1e-6 * (end - begin)

    def _refuse(self, fault: str | None) -> None:
        """Stop with what was computed so far if something is wrong."""
        if fault:
            raise SolverError(f"{self.system.name}: {fault}", self.trajectory())

    def _give_up(self, t: float, x: np.ndarray, f: np.ndarray) -> None:
        self._refuse(finite_fault(self.system, t, x, f))
        scale = self.atol + self.rtol * np.abs(x)
        worst = int(np.argmax(np.abs(f) / scale))
        raise SolverError(
            f"{self.system.name}: the step size shrank to nothing at t = {t:.9g} s; the fastest "
            f"state there is {self.system.state_names[worst]} = {x[worst]:.6g} with derivative "
            f"{f[worst]:.6g}. A quantity runs to infinity or leaves the range of a function.",
            self.trajectory(),
        )


def _rms(values: np.ndarray) -> float:
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def _nominal(system: System, name: str) -> float:
    return system.quantity(name).nominal if "(" not in name else 1.0


def _stepper(system: System, method: Method, dense: bool) -> Stepper:
    key = (method, dense)
    if key not in system.made:
        system.made[key] = Stepper.build(system, method, dense)
    stepper: Stepper = system.made[key]
    return stepper
