"""Functionals that the time loop collects while it runs."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.code.operations import Operations, operations_of
from lumped.compiler.system import System
from lumped.errors import OptionError, nearest
from lumped.functionals.damage_law import DamageLaw
from lumped.functionals.functional import Functional, refuse_other
from lumped.functionals.readings import (
    AtEvent,
    Between,
    Cycles,
    Extreme,
    Integral,
    Occurrence,
    OfQuantities,
    Reading,
    Span,
    Value,
)
from lumped.kernel.watch import ALL, ANY, COUNT, IMPULSE, INSTANT, LOSS, TIMED, VALUE, Watch
from lumped.timeloop.clocks import clocks
from lumped.timeloop.cycle_count import count_record
from lumped.timeloop.holds import hold_words
from lumped.timeloop.plants.parts import make_enclosed
from lumped.timeloop.results.validity import HeldRange, ranges
from lumped.timeloop.step_bounds import heights, kinks

_DEPTH = 1 << 14
"""Turning points of a load that may wait for the end of their cycles."""
POSITIONS = (0, 1, 2, -1)
"""Positions of a hold, in the order of its words: stuck, forward, backward, free."""
_WHATS = {"instant": INSTANT, "count": COUNT, "loss": LOSS, "impulse": IMPULSE}
_WHOLE = -math.inf, math.inf
KINDS = ("integrand", "extreme", "load", "point", "final", "event_point")
"""Kinds of quantities that are taken from a run, by the fields of a `Watch`."""
_GIVEN = (*KINDS[:5], "wanted_event")
"""Kinds of what the loop gives for a run, in this order."""


class Place(NamedTuple):
    """Where a reading is found in what the loop gives.

    Attributes
    ----------
    column : int
        Where; -1 for what is known beforehand.
    factor : float
        By which it is multiplied; the value of what is known beforehand.
    happened : int
        Where it says how often its event happened; -1 if that does not matter.
    least : int
        How often it must have.
    is_positive : bool
        Whether it is zero where rounding makes it negative.
    """

    column: int
    factor: float = 1.0
    happened: int = -1
    least: int = 0
    is_positive: bool = False

    def value(self, found: np.ndarray) -> np.ndarray:
        """The reading in each run, shape (n,); nan where its event is missing."""
        if self.column < 0:
            return np.full(len(found), self.factor)
        values: np.ndarray = self.factor * found[:, self.column]
        if self.is_positive:
            values = np.maximum(values, 0.0)
        if self.happened >= 0:
            values = np.where(found[:, self.happened] >= self.least, values, np.nan)
        return values


@dataclass
class _Table:
    """Quantities of one kind, and what belongs to each."""

    quantities: list[ca.SX] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)

    def add(self, quantity: ca.SX, *row: float) -> int:
        """Add one; gives its number."""
        self.quantities.append(quantity)
        self.rows.append(row)
        return len(self.rows) - 1


class Watched:
    """Functionals of the runs of a system.

    Parameters
    ----------
    system : System
    of : mapping of str to functional
        What is wanted.
    begin, until : float
        Begin and end of the runs, s.

    Attributes
    ----------
    functions : dict of str to Function
        Quantities of each kind, by the fields of a `Watch`.
    width : int
        How many numbers the loop gives for a run.

    Raises
    ------
    OptionError
        If the loop cannot collect one of them, or it lies outside the run.
    UnknownNameError
        If a quantity does not exist.
    """

    def __init__(
        self, system: System, of: Mapping[str, Functional], begin: float, until: float
    ) -> None:
        self.system, self.of, self.begin, self.until = system, dict(of), begin, until
        self._tables = {kind: _Table() for kind in (*KINDS, "wanted_event")}
        self._laws: list[DamageLaw] = []
        self._times: list[tuple[float, int]] = []
        self._matches: list[tuple[int, int, int, int]] = []
        self._timed: list[tuple[str, int]] = []
        self._numbers: dict[Reading, tuple[str, int]] = {}
        for label, functional in self.of.items():
            refuse_other([functional], "run", f"{system.name}: of['{label}']")
            for reading in functional.readings:
                self._number(reading)
        self._ranges = [
            (held, [self._number(Extreme((held.formula,), side)) for side in ("highest", "lowest")])
            for held in ranges(system)
        ]
        self.functions = {
            kind: self._operations(self._tables[kind].quantities)
            for kind in KINDS
            if self._tables[kind].rows
        }
        extremes, loads = self._tables["extreme"], self._tables["load"]
        if extremes.rows:
            signs = [int(row[2]) for row in extremes.rows]
            given = extremes.quantities, signs, len(system.state_names)
            self.functions["height"] = heights(system, *given)
        kinked = kinks(system, extremes.quantities + loads.quantities)
        if kinked is not None:
            self.functions["kink"] = operations_of(kinked)
        counts = [len(self._tables[kind].rows) for kind in _GIVEN]
        columns = np.cumsum([0, *counts]).tolist()
        self._first = dict(zip(_GIVEN, columns, strict=False))
        self.width = columns[-1] + counts[-1]  # two numbers of each event

    # -- what is asked of the loop -------------------------------------------------------------

    def _operations(self, quantities: list[ca.SX]) -> Operations:
        whole = ca.densify(ca.vertcat(*quantities))
        return operations_of(ca.Function("quantities", self.system.inputs, [whole]))

    def _number(self, reading: Reading) -> int:
        """Number of a reading among those of its kind, for which it is asked once."""
        if reading not in self._numbers:
            self._numbers[reading] = self._add(reading)
        return self._numbers[reading][1]

    def _add(self, reading: Reading) -> tuple[str, int]:
        """Ask for a reading; gives its kind, and its number among these."""
        if isinstance(reading, Span):
            begin, end = reading.between or (self.begin, self.until)
            self._refuse_outside(reading, begin, end)
            return "span", -1
        if isinstance(reading, Occurrence):
            return "wanted_event", self._event(reading, reading, _WHATS[reading.what])
        assert isinstance(reading, OfQuantities)
        quantity = self.system.product(reading.factors)
        if isinstance(reading, Extreme):
            part = self._part(reading)
            return "extreme", self._tables["extreme"].add(quantity, *part, reading.sign)
        if isinstance(reading, Integral):
            return "integrand", self._tables["integrand"].add(quantity, *self._part(reading))
        if isinstance(reading, Cycles):
            self._laws.append(reading.law)
            return "load", self._tables["load"].add(quantity)
        assert isinstance(reading, Value)
        if isinstance(reading.at, AtEvent):
            of = self._tables["event_point"].add(quantity)
            side = int(reading.at.side == "after")
            return "wanted_event", self._event(reading, reading.at, VALUE, side, of)
        if reading.at is None:
            return "final", self._tables["final"].add(quantity)
        self._refuse_outside(reading, min(reading.at), max(reading.at))
        number = self._tables["point"].add(quantity)
        self._times += [(time, number) for time in reading.at]
        return "point", number

    @property
    def integrands(self) -> int:
        """How many integrals are taken."""
        return len(self._tables["integrand"].rows)

    def _part(self, reading: Extreme | Integral) -> Between:
        if reading.between is None:
            return _WHOLE
        self._refuse_outside(reading, *reading.between)
        return reading.between

    def _refuse_outside(self, wanted: object, first: float, last: float) -> None:
        if not self.begin <= first <= last <= self.until:
            raise OptionError(
                f"{self.system.name}: {wanted}: the runs last from {self.begin:g} to "
                f"{self.until:g} s."
            )

    def _event(
        self, wanted: Reading, event: AtEvent | Occurrence, kind: int, side: int = 0, of: int = 0
    ) -> int:
        """Number of an event that is wanted, and which events of the loop are meant."""
        number = ALL if event.number is None else event.number
        row = self._tables["wanted_event"].add(ca.SX(0), kind, number, side, of)
        component, after = event.component, event.after
        every = list(self._list_events())
        found = [
            (*numbers, row)
            for name, word, numbers in every
            if name == component and after in ("", word)
        ]
        clocks = {condition.name for condition in self.system.switching.timed}
        if kind not in (LOSS, IMPULSE) and component in clocks and not after:
            self._timed.append((component, row))
        elif not found:
            known = {name for name, *_ in every} | clocks
            if component in known:
                words = {word for name, word, _ in every if name == component}
                listed = ", ".join(sorted(words)) or "none that are told apart"
                raise OptionError(
                    f"{self.system.name}: {wanted}: modes of {component} are: {listed}."
                )
            near = nearest(component, known) if known else "Nothing else has events either."
            raise OptionError(f"{self.system.name}: {wanted}: '{component}' has no events. {near}")
        self._matches += found
        return row

    def _list_events(self) -> Iterator[tuple[str, str, tuple[int, int, int]]]:
        """Component, mode after it in words, and numbers of each event that the loop finds."""
        s = self.system.switching
        for k, condition in enumerate(s.conditions):
            for now in range(2 if condition.pieces is None else condition.pieces.count):
                yield condition.name, s.relation_text(k, now)[1], (0, k, now)
        for h, name in enumerate(s.names):
            for position, word in zip(POSITIONS, hold_words(s, h), strict=True):
                yield name, word, (1, h, position)

    def record(self) -> Watch:
        """The record that a run writes; its functions are set apart."""
        columns: dict[str, list[int]] = {}
        every = clocks(self.system)
        first = np.cumsum([0, *(len(clock.condition.modes) for clock in every)]).tolist()
        needs = []
        for clock, place in zip(every, first, strict=False):
            columns.setdefault(clock.condition.name, []).append(place)
            needs += [(place, first[need]) for need in clock.needs]
        sizes = {f"{kind}s": len(table.rows) for kind, table in self._tables.items()}
        sizes["kinks"] = self.functions["kink"].results if "kink" in self.functions else 0
        sizes["states"] = len(self.system.state_names)
        watch = Watch(sizes)
        for name in sizes.keys() - {"states"}:
            setattr(watch, name, sizes[name])
        integrands, extremes = self._tables["integrand"].rows, self._tables["extreme"].rows
        parts = [row[:2] for row in (*integrands, *extremes)]
        ends = np.array(parts).reshape(-1, 2)
        watch.begin[:], watch.end[:] = ends[:, 0], ends[:, 1]
        watch.sign[:] = [int(row[2]) for row in extremes]
        watch.enclosed_extremes = make_enclosed(self.functions.get("extreme"))
        watch.enclosed_loads = make_enclosed(self.functions.get("load"))
        watch.count = count_record(self._laws, _DEPTH)
        times = sorted(self._times)
        watch.times = len(times)
        watch.time = np.array([t for t, _ in times], dtype=float)
        watch.time_of = np.array([k for _, k in times], dtype=np.int64)
        rows = np.array(self._tables["wanted_event"].rows, dtype=np.int64).reshape(-1, 4)
        fields = (watch.event_kind, watch.event_number, watch.event_side, watch.event_of)
        for place, column in zip(fields, rows.T, strict=True):
            place[:] = column
        lengths = np.where(rows[:, 1] < 0, -rows[:, 1], 0)
        watch.latest[:] = np.cumsum(lengths) - lengths
        watch.ring = np.zeros(int(lengths.sum()))
        timed = [(TIMED, k, ANY, row) for name, row in self._timed for k in columns[name]]
        match = np.array(self._matches + timed, dtype=np.int64)
        watch.match, watch.matches = match.ravel(), len(match)
        watch.need, watch.needs = np.array(needs, dtype=np.int64).ravel(), len(needs)
        return watch

    # -- what the loop gives -------------------------------------------------------------------

    def values(self, found: np.ndarray) -> np.ndarray:
        """Functionals of runs from what the loop gives, shape (n, len(of)); nan where missing."""
        read = {reading: self.place(reading).value(found) for reading in self._numbers}
        columns = []
        for functional in self.of.values():
            own = [read[reading] for reading in functional.readings]
            columns.append(functional.value(np.column_stack(own)))
        return np.column_stack(columns)

    @property
    def extremes(self) -> list[tuple[HeldRange, tuple[int, int]]]:
        """Ranges of components; places of the highest and of the negative of the lowest value."""
        first = self._first["extreme"]
        return [(held, (first + high, first + low)) for held, (high, low) in self._ranges]

    def outside(self, found: np.ndarray) -> np.ndarray:
        """Which runs took a component beyond where its equations hold, shape (n,)."""
        beyond = np.zeros(len(found), dtype=bool)
        for held, (high, low) in self.extremes:
            beyond |= held.outside(found[:, [high, low]] * [1, -1]).any(axis=1)
        return beyond

    def place(self, reading: Reading) -> Place:
        """Where a reading is found in what the loop gives."""
        kind, number = self._numbers[reading]
        column = self._first.get(kind, 0) + number
        if isinstance(reading, Span):
            begin, end = reading.between or (self.begin, self.until)
            return Place(-1, end - begin)
        if isinstance(reading, Integral):
            return Place(column, is_positive=reading.is_of_square)
        if isinstance(reading, Extreme):
            return Place(column, reading.sign or 1)
        event = reading.at if isinstance(reading, Value) else reading
        if not isinstance(event, AtEvent | Occurrence):
            return Place(column)
        taken = column + number  # with how often it happened after it
        if isinstance(event, Occurrence) and event.what == "count":
            return Place(taken + 1)
        if event.number is None:
            return Place(taken)
        least = event.number + 1 if event.number >= 0 else -event.number
        return Place(taken, 1.0, taken + 1, least)

    def missing(self, label: str) -> str:
        """Why a functional of a run that went to its end is no number."""
        for reading in self.of[label].readings:
            event = reading.at if isinstance(reading, Value) else reading
            if isinstance(event, AtEvent | Occurrence):
                return f"{label}: this event of {event.component} does not happen in this run"
            if isinstance(reading, Cycles):
                return (
                    f"{label}: not a number, or more than {_DEPTH} turning points follow each "
                    "other without closing a cycle, as where a free vibration hardly decays; end "
                    "the run earlier"
                )
        return f"{label}: not a number"
