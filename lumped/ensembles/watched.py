"""Functionals that the time loop collects while it runs."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.code.operations import Operations, operations_of
from lumped.compiler.system import System
from lumped.errors import OptionError, nearest
from lumped.kernel.watch import ALL, ANY, COUNT, IMPULSE, INSTANT, LOSS, TIMED, VALUE, Watch
from lumped.simulation.functional_kinds import (
    At,
    AtEvent,
    Count,
    Damage,
    Final,
    Impact,
    Instant,
    Integral,
    Peak,
    Swing,
    factors,
    product,
)
from lumped.timeloop.cycle_count import DamageLaw, count_record
from lumped.timeloop.executable import enclosed
from lumped.timeloop.holds import hold_words
from lumped.timeloop.step_bounds import heights, kinks
from lumped.timeloop.validity import Held, ranges

__all__ = ["POSITIONS", "Collected", "Reading", "Watched"]

Collected = Final | Peak | Swing | Integral | At | Instant | Count | AtEvent | Impact | Damage
"""What the loop can collect."""

_SIGNS = {"peak": 0, "highest": 1, "lowest": -1}
_DEPTH = 1 << 14
"""Turning points of a load that may wait for the end of their cycles."""
POSITIONS = (0, 1, 2, -1)
"""Positions of a hold, in the order of its words: stuck, forward, backward, free."""


class Reading(NamedTuple):
    """How a functional follows from what the loop gives.

    Attributes
    ----------
    kind : {"sum", "least", "integral", "mean", "rms", "event"}
        The sum of places; what is there with its sign changed; an integral, its mean, or the root
        of that; what is taken from an event, if it happened often enough.
    places : tuple of int
        Where.
    number : float
        Length of the part of the run, s; how often the event must happen.
    """

    kind: str
    places: tuple[int, ...]
    number: float = 1.0

    def value(self, found: np.ndarray) -> np.ndarray:
        """The functional in each run, shape (n,); nan where its event is missing."""
        first: np.ndarray = found[:, self.places[0]]
        if self.kind == "least":
            return -first
        if self.kind == "event":
            return np.where(found[:, self.places[1]] >= self.number, first, np.nan)
        if self.kind in ("mean", "rms"):
            mean: np.ndarray = first / self.number
            return mean if self.kind == "mean" else np.sqrt(np.maximum(mean, 0.0))
        total: np.ndarray = found[:, list(self.places)].sum(axis=1)
        return total


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
        self, system: System, of: Mapping[str, Collected], begin: float, until: float
    ) -> None:
        self.system, self.of, self.begin, self.until = system, dict(of), begin, until
        self._integrals, self._extremes, self._points = _Table(), _Table(), _Table()
        self._finals, self._event_points, self._events = _Table(), _Table(), _Table()
        self._loads, self._laws = _Table(), list[DamageLaw]()
        self._times: list[tuple[float, int]] = []
        self._matches: list[tuple[int, int, int, int]] = []
        self._timed: list[tuple[str, int]] = []
        self._places = {label: self._add(label, f) for label, f in self.of.items()}
        self._ranges = [(held, self._swing(held.formula)) for held in ranges(system)]
        functions = {
            "integrand": self._integrals,
            "extreme": self._extremes,
            "point": self._points,
            "final": self._finals,
            "event_point": self._event_points,
        }
        self.functions = {
            name: self._operations(t.quantities) for name, t in functions.items() if t.rows
        }
        if self._extremes.rows:
            signs = [int(row[2]) for row in self._extremes.rows]
            given = self._extremes.quantities, signs, len(system.state_names)
            self.functions["height"] = heights(system, *given)
        if self._loads.rows:
            self.functions["load"] = self._operations(self._loads.quantities)
        kinked = kinks(system, self._extremes.quantities + self._loads.quantities)
        if kinked is not None:
            self.functions["kink"] = operations_of(kinked)
        tables = (self._integrals, self._extremes, self._loads, self._points)
        counts = [len(t.rows) for t in tables]
        self._first = np.cumsum([0, *counts, len(self._finals.rows)]).tolist()
        self.width = self._first[-1] + 2 * len(self._events.rows)

    # -- what is asked of the loop -------------------------------------------------------------

    def _operations(self, quantities: list[ca.SX]) -> Operations:
        whole = ca.densify(ca.vertcat(*quantities))
        return operations_of(ca.Function("quantities", self.system.inputs, [whole]))

    def _add(self, label: str, wanted: Collected) -> int | tuple[int, int]:
        """Ask for a functional; gives its number among those of its kind."""
        if isinstance(wanted, Final):
            return self._finals.add(product(self.system, (wanted.name,)))
        if isinstance(wanted, Peak):
            sign, part = _SIGNS[wanted.kind], self._part(wanted)
            return self._extremes.add(product(self.system, (wanted.name,)), *part, sign)
        if isinstance(wanted, Swing):
            return self._swing(wanted.name)
        if isinstance(wanted, Damage):
            self._laws.append(wanted.law)
            return self._loads.add(product(self.system, (wanted.name,)))
        if isinstance(wanted, Integral):
            names = factors(self.system, wanted)
            return self._integrals.add(product(self.system, names), *self._part(wanted))
        if isinstance(wanted, At):
            return self._at(wanted)
        if isinstance(wanted, Instant | Count | AtEvent | Impact):
            return self._event(wanted)
        raise OptionError(
            f"{self.system.name}: of['{label}'] = {wanted!r:.60} is nothing that a run gives; take "
            "one of lumped.functionals, such as lumped.functionals.peak('shaft.tau')."
        )

    def _swing(self, name: str) -> tuple[int, int]:
        """Ask for the highest value and the lowest, the latter with its sign changed."""
        quantity, part = product(self.system, (name,)), (-math.inf, math.inf)
        return self._extremes.add(quantity, *part, 1), self._extremes.add(quantity, *part, -1)

    def _part(self, wanted: Peak | Integral) -> tuple[float, float]:
        if wanted.between is None:
            return -math.inf, math.inf
        self._refuse_outside(wanted, *wanted.between)
        return wanted.between

    def _refuse_outside(self, wanted: object, first: float, last: float) -> None:
        if not self.begin <= first <= last <= self.until:
            raise OptionError(
                f"{self.system.name}: {wanted}: the runs last from {self.begin:g} to "
                f"{self.until:g} s."
            )

    def _at(self, wanted: At) -> int:
        self._refuse_outside(wanted, min(wanted.times), max(wanted.times))
        number = self._points.add(product(self.system, wanted.names))
        self._times += [(time, number) for time in wanted.times]
        return number

    def _event(self, wanted: Instant | Count | AtEvent | Impact) -> int:
        after = getattr(wanted, "after", "")
        number = getattr(wanted, "number", None)
        kind, side, of = INSTANT, 0, 0
        if isinstance(wanted, Count):
            kind = COUNT
        elif isinstance(wanted, AtEvent):
            kind, side = VALUE, int(wanted.side == "after")
            of = self._event_points.add(product(self.system, wanted.names))
        elif isinstance(wanted, Impact):
            kind = LOSS if wanted.kind == "loss" else IMPULSE
        row = self._events.add(ca.SX(0), kind, ALL if number is None else number, side, of)
        self._match(wanted, wanted.component, after, row, timed=kind not in (LOSS, IMPULSE))
        return row

    def _match(self, wanted: object, component: str, after: str, row: int, timed: bool) -> None:
        """Which events of the loop are meant."""
        s, found = self.system.switching, list[tuple[int, int, int, int]]()
        for k, condition in enumerate(s.conditions):
            count = 2 if condition.pieces is None else condition.pieces.count
            for now in range(count if condition.name == component else 0):
                if after in ("", s.relation_text(k, now)[1]):
                    found.append((0, k, now, row))
        for h, name in enumerate(s.names):
            for position, word in zip(POSITIONS, hold_words(s, h), strict=True):
                if name == component and after in ("", word):
                    found.append((1, h, position, row))
        clocks = {condition.name for condition in s.timed}
        if timed and component in clocks and not after:
            self._timed.append((component, row))
        elif not found:
            known = {c.name for c in s.conditions} | set(s.names) | clocks
            if component in known:
                words = {s.relation_text(k, m)[1] for k, m in self._modes(component)}
                holds = [h for h, name in enumerate(s.names) if name == component]
                words |= {word for h in holds for word in hold_words(s, h)}
                listed = ", ".join(sorted(words)) or "none that are told apart"
                raise OptionError(
                    f"{self.system.name}: {wanted}: modes of {component} are: {listed}."
                )
            near = nearest(component, known) if known else "Nothing else has events either."
            raise OptionError(f"{self.system.name}: {wanted}: '{component}' has no events. {near}")
        self._matches += found

    def _modes(self, component: str) -> list[tuple[int, int]]:
        """Conditions of a component and their modes."""
        return [
            (k, mode)
            for k, c in enumerate(self.system.switching.conditions)
            if c.name == component
            for mode in range(2 if c.pieces is None else c.pieces.count)
        ]

    def record(
        self, columns: Mapping[str, Sequence[int]], needs: Sequence[tuple[int, int]]
    ) -> Watch:
        """The record that a run writes; its functions are set apart.

        Parameters
        ----------
        columns : mapping of str to sequence of int
            Places of the settings of each component among those of functions of time.
        needs : sequence of (int, int)
            Such places that change because others do.
        """
        sizes = {
            "states": len(self.system.state_names),
            "integrands": len(self._integrals.rows),
            "extremes": len(self._extremes.rows),
            "kinks": self.functions["kink"].results if "kink" in self.functions else 0,
            "loads": len(self._loads.rows),
            "points": len(self._points.rows),
            "finals": len(self._finals.rows),
            "event_points": len(self._event_points.rows),
            "wanted_events": len(self._events.rows),
        }
        watch = Watch(sizes)
        for name in sizes.keys() - {"states"}:
            setattr(watch, name, sizes[name])
        parts = [row[:2] for t in (self._integrals, self._extremes) for row in t.rows]
        ends = np.array(parts).reshape(-1, 2)
        watch.begin[:], watch.end[:] = ends[:, 0], ends[:, 1]
        watch.sign[:] = [int(row[2]) for row in self._extremes.rows]
        watch.enclosed_extremes = enclosed(self.functions.get("extreme"))
        watch.enclosed_loads = enclosed(self.functions.get("load"))
        watch.count = count_record(self._laws, _DEPTH)
        times = sorted(self._times)
        watch.times = len(times)
        watch.time = np.array([t for t, _ in times], dtype=float)
        watch.time_of = np.array([k for _, k in times], dtype=np.int64)
        rows = np.array(self._events.rows, dtype=np.int64).reshape(-1, 4)
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
        return np.column_stack([self.reading(label).value(found) for label in self.of])

    @property
    def swings(self) -> list[tuple[Held, tuple[int, int]]]:
        """Ranges of components; places of the highest and of the negative of the lowest value."""
        first = self._first[1]
        return [(held, (first + high, first + low)) for held, (high, low) in self._ranges]

    def outside(self, found: np.ndarray) -> np.ndarray:
        """Which runs took a component beyond where its equations hold, shape (n,)."""
        beyond = np.zeros(len(found), dtype=bool)
        for held, (high, low) in self.swings:
            beyond |= held.outside(found[:, high]) | held.outside(-found[:, low])
        return beyond

    def reading(self, label: str) -> Reading:
        """Where a functional is found in what the loop gives."""
        wanted, place = self.of[label], self._places[label]
        integrals, extremes, loads, points, finals, events = self._first
        if isinstance(wanted, Swing):
            assert isinstance(place, tuple)
            return Reading("sum", tuple(extremes + k for k in place))
        assert isinstance(place, int)
        if isinstance(wanted, Integral):
            begin, end = wanted.between or (self.begin, self.until)
            return Reading(wanted.kind, (integrals + place,), end - begin)
        if isinstance(wanted, Peak):
            return Reading("least" if wanted.kind == "lowest" else "sum", (extremes + place,))
        if isinstance(wanted, Damage):
            return Reading("sum", (loads + place,))
        if isinstance(wanted, At | Final):
            return Reading("sum", ((points if isinstance(wanted, At) else finals) + place,))
        taken = events + 2 * place
        if isinstance(wanted, Count):
            return Reading("sum", (taken + 1,))
        if wanted.number is None:
            return Reading("sum", (taken,))
        least = wanted.number + 1 if wanted.number >= 0 else -wanted.number
        return Reading("event", (taken, taken + 1), least)

    def missing(self, label: str) -> str:
        """Why a functional of a run that went to its end is no number."""
        wanted = self.of[label]
        component = getattr(wanted, "component", "")
        if component:
            return f"{label}: this event of {component} does not happen in this run"
        if isinstance(wanted, Damage):
            return (
                f"{label}: not a number, or more than {_DEPTH} turning points follow each other "
                "without closing a cycle, as where a free vibration hardly decays; end the run "
                "earlier"
            )
        return f"{label}: not a number"
