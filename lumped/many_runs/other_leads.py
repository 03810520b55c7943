"""Runs of variants in which other states must lead on the way, as at dead centres."""

from __future__ import annotations

import math
from collections.abc import Callable

from lumped.compiler.system import System
from lumped.errors import LumpedError
from lumped.kernel import engine
from lumped.kernel.many_runs.variants import Queue, Variants
from lumped.kernel.run import ASKS, NEEDS_MATRIX, RESTART, UNFIT
from lumped.many_runs.run_records import RunRecords
from lumped.timeloop.leading_states import exchange_lead
from lumped.timeloop.programs import Answers

_SO_FAR = ("sums", "best", "totals", "happened", "last_time", "taken", "ring", "load_size")
_COUNTED = ("held", "held_at", "size", "fed", "last", "last_at", "direction", "damage")
"""What functionals have taken from a run, and what is counted of loads."""


class AloneRecords(RunRecords):
    """Records for runs that go one by one."""

    has_lanes = False


class OtherLeads:
    """Runs of one thread that go on with other states.

    Parameters
    ----------
    records : callable
        Gives the records for runs with a choice of states.
    """

    def __init__(self, records: Callable[[System], RunRecords]) -> None:
        self._records = records
        self._slots: dict[System, Variants] = {}

    @property
    def slots(self) -> list[Variants]:
        """The runs."""
        return list(self._slots.values())

    def finish(self, system: System, slot: Variants, answers: Answers) -> None:
        """Bring a variant to its end in which another state must lead now.

        It keeps the status `UNFIT` if no choice of states determines its position.
        """
        try:
            self._finish(system, slot, answers)
        except LumpedError:
            slot.status[slot.number] = UNFIT

    def _finish(self, system: System, slot: Variants, answers: Answers) -> None:
        run, theta = slot.run, slot.run.p[: slot.parameters].copy()
        edges, values = run.edges, run.timed_values
        if slot.clocks.count:
            edges, values = slot.clocks.edges, slot.clocks.values
        why, changed_at = UNFIT, math.nan
        while why == UNFIT:
            if run.t == changed_at:
                slot.status[slot.number] = UNFIT
                return
            changed_at = run.t
            lead = exchange_lead(system, theta, changed_at, run.x.copy(), run.m.copy())
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
                    answers.give(system, run)
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
