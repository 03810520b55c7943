"""Runs of variants in the time loop, many in one call and without Python between them."""

from __future__ import annotations

import pickle
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lumped.code.records import address
from lumped.compiler.system import System
from lumped.errors import LumpedError, OptionError, SolverError
from lumped.functionals import Functional
from lumped.kernel import engine
from lumped.kernel.many_runs.lane_records import WAITING
from lumped.kernel.many_runs.variants import Queue, Variants
from lumped.kernel.run import ASKS, DONE, FULL, NEEDS_MATRIX, RESTART, UNFIT
from lumped.many_runs.run_records import RunRecords
from lumped.points.start import run_start
from lumped.support.optional_packages import extra
from lumped.support.process_lock import process_lock
from lumped.timeloop.leading_states import free_states
from lumped.timeloop.plants.kept_run import place_of
from lumped.timeloop.programs import Answers
from lumped.timeloop.results.operating_point import OperatingPoint
from lumped.timeloop.run_options import RunPlan

OUTSIDE = -2
"""Status of a run that took a component beyond where its equations hold."""
_SO_FAR = ("sums", "best", "totals", "happened", "last_time", "taken", "ring", "load_size")
_COUNTED = ("held", "held_at", "size", "fed", "last", "last_at", "direction", "damage")
"""What functionals have taken from a run, and what is counted of loads."""


@dataclass(frozen=True, eq=False)
class Batch:
    """What runs gave.

    Attributes
    ----------
    values : ndarray, shape (n, len(of))
        Functionals; nan where a run failed, or where one is missing.
    status : ndarray of int, shape (n,)
        How each ended (see `lumped.kernel.run`).
    steps, rejected : ndarray of int, shape (n,)
        What each cost; empty if it is not known.
    """

    values: np.ndarray
    status: np.ndarray
    steps: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    rejected: np.ndarray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


class NativeRuns(RunRecords):
    """Runs that differ in their parameters; threads share it.

    Parameters
    ----------
    system, names, theta, of, options
        As for `RunRecords`.
    """

    def __init__(
        self,
        system: System,
        names: Sequence[str],
        theta: np.ndarray,
        of: Mapping[str, Functional],
        options: RunPlan,
    ) -> None:
        super().__init__(system, names, theta, of, options)
        self._idle: list[_Worker] = []
        self._workers: list[_Worker] = []
        self._free: dict[System, RunRecords] = {}
        self.is_stopped = False

    def run(self, values: np.ndarray) -> Batch:
        """Run variants in this thread.

        Parameters
        ----------
        values : ndarray, shape (n, len(names))
            Their parameters.
        """
        try:
            worker = self._idle.pop()
        except IndexError:
            worker = _Worker(self)
            self._workers.append(worker)
        batch = worker.run(np.ascontiguousarray(values, dtype=float))
        self._idle.append(worker)
        return batch

    def find_records(self, system: System) -> RunRecords:
        """Records for runs in redundant coordinates."""
        with process_lock:
            if system not in self._free:
                of = self.watched.of
                self._free[system] = AloneRecords(system, self.names, self.theta, of, self.options)
            return self._free[system]

    def __reduce__(self) -> tuple[Callable[..., NativeRuns], tuple[bytes]]:
        cloudpickle = extra("cloudpickle", "cluster", "An ensemble on a cluster")
        parts = (self.system, self.names, self.theta, self.watched.of, self.options)
        return _restore, (cloudpickle.dumps(parts),)

    def stop(self) -> None:
        """Let all threads return soon; what they were at is not done."""
        self.is_stopped = True
        for worker in self._workers:
            worker.stop()

    def go_on(self) -> None:
        """Let runs be made again, when all threads have returned."""
        self.is_stopped = False
        self._idle, self._workers = [], []


class _Worker:
    """The records of one thread: one run, or several side by side."""

    def __init__(self, runs: NativeRuns) -> None:
        self._runs = runs
        self._lanes = None
        count = engine.LANES if runs.has_lanes else 1
        self._slots = [runs.new_run() for _ in range(count)]
        self._queue = Queue()
        for slot in self._slots:
            slot.queue = self._queue
        if runs.has_lanes:
            self._lanes = runs.new_lanes(self._slots)
        self._free, self._answers = _FreeRuns(runs.find_records), Answers()

    def stop(self) -> None:
        """Let the loop return at its next step."""
        for slot in (*self._slots, *self._free.slots):
            place = place_of(slot.run, "pause")
            slot.run.memory_at_first[place] = slot.run.memory[place] = 0
        if self._lanes is not None:
            self._lanes.is_stopped = 1

    def run(self, values: np.ndarray) -> Batch:
        """Run variants; those that are left when it is stopped keep the status `FULL`."""
        runs, count = self._runs, len(values)
        found = np.full((count, runs.watched.width), np.nan)
        status = np.full(count, FULL, dtype=np.int64)
        steps, rejected = (np.zeros(count, dtype=np.int64) for _ in range(2))
        for slot in self._slots:
            slot.values, slot.found, slot.status = values.ravel(), found.ravel(), status
            slot.steps, slot.rejected = steps, rejected
            slot.is_begun = 0
        self._queue.next = 0
        with self._answers:
            self._go_through(values)
        runs.account(int((steps + rejected).sum()))
        functionals = runs.watched.values(found)
        beyond = (status == DONE) & runs.watched.outside(found)
        status[beyond], functionals[beyond] = OUTSIDE, np.nan
        return Batch(functionals, status, steps, rejected)

    def _go_through(self, values: np.ndarray) -> None:
        runs, count = self._runs, len(values)
        if not runs.is_start_direct:
            count = self._find_starts(values)
        if runs.are_instants_same:
            self._go(count)
            return
        for k in range(count):
            if runs.is_stopped:
                break
            for slot in self._slots:
                runs.set_instants(slot, values[k])
            self._go(k + 1)

    def _find_starts(self, values: np.ndarray) -> int:
        """Find the starts of variants; gives of how many, which are fewer when it is stopped."""
        found = []
        for row in values:
            if self._runs.is_stopped:
                break
            found.append(self._runs.find_start(row))
        table = np.array(found)
        for slot in self._slots:
            slot.starts, slot.start_width = table.ravel(), table.shape[-1]
        return len(found)

    def _go(self, end: int) -> None:
        """Run variants up to one."""
        self._queue.end = end
        lanes = self._lanes
        if lanes is not None:
            lanes.state[:] = WAITING
            lanes.entry[:] = lanes.until_steps_of
        while not self._runs.is_stopped:
            if lanes is None:
                slot, why = self._slots[0], engine.call("variants", self._slots[0])
            else:
                why = engine.lanes()(address(lanes))
                slot = self._slots[lanes.waiting]
            if why == DONE:
                return
            if why == NEEDS_MATRIX:
                self._runs.add_matrix(slot.run)
            elif why == UNFIT:
                self._free.finish(self._runs.system, slot, self._answers)
                slot.is_begun = 0
            elif why == ASKS and not self._answers.try_to_ask(self._runs.system, slot.run):
                slot.status[slot.number] = ASKS
                slot.is_begun = 0


class AloneRecords(RunRecords):
    """Records for runs that go one by one."""

    has_lanes = False


class _FreeRuns:
    """Runs of one thread that go on in redundant coordinates.

    Parameters
    ----------
    records : callable
        Gives the records for runs in them.
    """

    def __init__(self, records: Callable[[System], RunRecords]) -> None:
        self._records = records
        self._slots: dict[System, Variants] = {}

    @property
    def slots(self) -> list[Variants]:
        """The runs."""
        return list(self._slots.values())

    def finish(self, system: System, slot: Variants, answers: Answers) -> None:
        """Bring a variant to its end in which a state does not lead now.

        It keeps the status `UNFIT` if that fails.
        """
        try:
            self._finish(system, slot, answers)
        except LumpedError:
            slot.status[slot.number] = UNFIT

    def _finish(self, system: System, slot: Variants, answers: Answers) -> None:
        run, theta, why = slot.run, slot.run.p[: slot.parameters].copy(), UNFIT
        edges, values = run.edges, run.timed_values
        if slot.clocks.count:
            edges, values = slot.clocks.edges, slot.clocks.values
        while why == UNFIT:
            lead = free_states(system, theta, run.t, run.x.copy(), run.m.copy())
            system, records = lead.system, self._records(lead.system)
            if system not in self._slots:
                self._slots[system] = records.new_run()
            own = self._slots[system]
            _take_over(own, slot)
            own.run.edges, own.run.timed_values = edges, values
            own.run.p[: len(theta)], own.run.x[:], own.run.m[:] = theta, lead.x, lead.settings
            engine.call("prepare_parameters", own.run)
            engine.call("watch_constraints", own.run)
            if run.is_implicit:
                records.add_matrix(own.run)
                own.run.is_implicit = 1
            slot, run = own, own.run
            why = engine.call("variants", slot)
            while why in (NEEDS_MATRIX, ASKS):
                if why == NEEDS_MATRIX:
                    records.add_matrix(run)
                else:
                    answers.ask(system, run)
                why = engine.call("variants", slot)


def _take_over(own: Variants, other: Variants) -> None:
    """Let a variant go on in another record, where its functionals have what was taken so far."""
    own.queue = Queue()
    own.number, own.is_begun = other.number, 1
    own.found, own.status = other.found, other.status
    own.steps, own.rejected = other.steps, other.rejected
    new, old = own.run, other.run
    new.memory[:] = new.memory_at_first
    new.t, new.end, new.segment, new.segments = old.t, old.end, old.segment, old.segments
    new.phase = RESTART
    new.steps, new.rejected = old.steps, old.rejected
    new.changed[:], new.changed_count = old.changed, old.changed_count
    new.watch.next_time = old.watch.next_time
    for name in _SO_FAR:
        getattr(new.watch, name)[:] = getattr(old.watch, name)
    for name in _COUNTED:
        getattr(new.watch.count, name)[:] = getattr(old.watch.count, name)


def _restore(payload: bytes) -> NativeRuns:
    return NativeRuns(*pickle.loads(payload))


def read_run(plan: RunPlan, point: OperatingPoint, of: Sequence[Functional]) -> np.ndarray:
    """Functionals of the run from a point, shape (len(of),).

    Parameters
    ----------
    plan : RunPlan
        Options of the run. A closed form is read by steps.
    of : sequence of functionals

    Raises
    ------
    OptionError
        If an event that is asked for does not happen in the run.
    SolverError
        If the run cannot be made again.
    """
    system = plan.watching(point.system, of)
    if system is not point.system:
        point = run_start(system, plan)
    wanted = {str(functional): functional for functional in of}
    method = "steps" if plan.method in ("auto", "exact") else plan.method
    own = plan._replace(start=point, parameters=None, free=(), method=method)
    runs = NativeRuns(system, (), point.theta, wanted, own)
    batch = runs.run(np.zeros((1, 0)))
    if batch.status[0] != DONE:
        raise SolverError(
            f"{system.name}: the run ends early where it is made again to be read "
            f"(status {batch.status[0]}). Make it with method='steps' to see why."
        )
    for label, value in zip(wanted, batch.values[0].tolist(), strict=True):
        if np.isnan(value):
            raise OptionError(f"{system.name}: {runs.watched.missing(label)}.")
    found: np.ndarray = batch.values[0]
    return found
