"""What functionals of a run are, and their derivatives through its instants."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from lumped.errors import OptionError, SolverError
from lumped.functionals.readings import (
    AtEvent,
    Cycles,
    Extreme,
    Integral,
    Occurrence,
    Reading,
    Span,
    Value,
)
from lumped.gradients.jumps import Crossing, EventDerivatives
from lumped.gradients.legs import SmoothParts
from lumped.gradients.readings.extremes import extremes
from lumped.gradients.readings.instant_terms import (
    AdjointPoint,
    InstantTerms,
    ReadingTerms,
    add_terms,
    find_last_bounces,
    find_limit_of_flights,
    scale_terms,
)
from lumped.gradients.readings.product_curve import (
    Turn,
    differentiate_at_many,
    differentiate_at_one,
    values_at,
)
from lumped.gradients.readings.turning_points import damage_slopes, turning_points
from lumped.gradients.saltation import saltation_of

_AT_ONCE = 1e-10
"""Part of a run within which a change counts as happening at a given instant."""


@dataclass(frozen=True, eq=False)
class ReadParts(SmoothParts):
    """The smooth parts of a run, which readings look at.

    Attributes
    ----------
    turns : dict of tuple of str to list
        Where quantities turn, as far as this was asked for.
    """

    turns: dict[tuple[str, ...], list[Turn]] = field(default_factory=dict)

    def find_terms(self, reading: Reading) -> ReadingTerms:
        """What a reading is, if it is no integral.

        Raises
        ------
        OptionError
            If it asks for what is not in the run.
        SolverError
            If it has no derivative.
        """
        if isinstance(reading, Span):
            begin, end = reading.between or (float(self.legs[0].t[0]), self.until)
            return ReadingTerms(
                (InstantTerms(end - begin, (), 1.0 if reading.between is None else 0.0),)
            )
        if isinstance(reading, Extreme):
            return self._extreme(reading)
        if isinstance(reading, Cycles):
            return self._damage(reading)
        if isinstance(reading, Value) and isinstance(reading.at, AtEvent):
            return ReadingTerms((add_terms(list(self._at_events(reading, reading.at))),))
        if isinstance(reading, Value):
            return self._at(reading)
        assert isinstance(reading, Occurrence)
        if reading.what == "instant":
            return self._instant(reading)
        return ReadingTerms((add_terms(list(self._impacts(reading))),))

    def ends(self, reading: Reading) -> bool:
        """Whether a reading looks at the very end of the run."""
        if isinstance(reading, Value):
            times = (self.until,) if reading.at is None else reading.at
            return isinstance(times, tuple) and self.until - max(times) <= _AT_ONCE * self.until
        return isinstance(reading, Cycles) or (
            isinstance(reading, Extreme) and reading.between is None
        )

    def cut(self, reading: Reading) -> None:
        """Make instants that a reading names ends of steps."""
        times: tuple[float, ...] = ()
        if isinstance(reading, Value) and isinstance(reading.at, tuple):
            times = reading.at
        elif isinstance(reading, Extreme | Integral | Span):
            times = reading.between or ()
        for t in times:
            if not t <= self.until * (1 + _AT_ONCE):
                raise OptionError(
                    f"{self.run.system.name}: {reading}: the run ends at {self.until:g} s."
                )
            for leg in self.legs:
                if leg.t[0] < t < leg.t[-1]:
                    leg.cut(t)

    # -- at given instants -------------------------------------------------------------------

    def _at(self, reading: Value) -> ReadingTerms:
        """Sum of a product over instants; at the end, which may move, with the slope there."""
        names = reading.factors
        times = reading.at if isinstance(reading.at, tuple) else (self.until,)
        alternatives: list[list[InstantTerms]] = []
        guards: list[AdjointPoint] = []
        where = ""
        for t in times:
            number, near = self._leg(t)
            own = [self._find_terms_at(number, t, names)]
            if near and any(
                j.instant.any() for order in self.crossings[number - 1].orders for j in order
            ):
                own.append(self._find_terms_at(number - 1, t, names))
                guards.append(self._moving(number))
                where = (
                    f"t = {t:.9g} s, where {', '.join(self.crossings[number - 1].names)} changes"
                )
            alternatives.append(own)
        if guards and len(times) > 1:
            raise SolverError(
                f"{self.run.system.name}: {reading}: a change coincides with {where}; there is no "
                "derivative. Take other instants.",
                self.run,
            )
        if reading.at is None:
            alternatives[0] = [
                replace(one, by_end=self._look(one.points[0].leg, one.points[0].time, names)[1])
                for one in alternatives[0]
            ]
        if guards:
            return ReadingTerms(tuple(alternatives[0]), "later", tuple(guards), where)
        return ReadingTerms((add_terms([own[0] for own in alternatives]),))

    def _leg(self, t: float) -> tuple[int, bool]:
        """Leg in which an instant lies, the later one on a border; whether one is so near."""
        soon = _AT_ONCE * self.until
        number = max((k for k, leg in enumerate(self.legs) if leg.t[0] <= t + soon), default=0)
        near = number > 0 and abs(float(self.legs[number].t[0]) - t) <= soon
        return number, near

    def _find_terms_at(self, number: int, t: float, names: tuple[str, ...]) -> InstantTerms:
        leg = self.legs[number]
        t = min(max(t, float(leg.t[0])), float(leg.t[-1]))
        return self._look(number, t, names)[0]

    def _look(
        self, number: int, t: float, names: tuple[str, ...], edge: int = 0
    ) -> tuple[InstantTerms, float]:
        """A product at an instant, which moves with the begin of a leg, and its slope."""
        x, m = self.legs[number].state(t)
        keys = tuple(self.run.system.key(name) for name in names)
        y, by_x, by_p, rate = differentiate_at_one(self.run.system, keys)(x, self.run.theta, t, m)
        late = float(rate[0])
        point = AdjointPoint(number, t, 0, by_x, by_p, edge, late if edge else 0.0)
        return InstantTerms(float(y[0]), (point,)), late

    def _moving(self, number: int, name: str = "") -> AdjointPoint:
        """The instant at which a leg begins."""
        none = np.zeros(len(self.run.system.structure.states)), np.zeros(len(self.run.theta))
        return AdjointPoint(number, float(self.legs[number].t[0]), 0, *none, number, 1.0, name)

    # -- extremes ----------------------------------------------------------------------------

    def _extreme(self, reading: Extreme) -> ReadingTerms:
        tops = extremes(self, reading)
        terms = self._find_turn_terms(tops, self._keys(reading), reading.between is None)
        if reading.sign == 0:
            terms = [scale_terms(one, top.sign) for top, one in zip(tops, terms, strict=True)]
        times = ", ".join(f"{top.time:.9g}" for top in tops)
        pick: Literal["greatest", "least"] = "least" if reading.sign < 0 else "greatest"
        alike = ", all equally high" if len(tops) > 1 else ""
        return ReadingTerms(tuple(terms), pick, (), f"t = {times} s{alike}")

    def _keys(self, reading: Extreme | Cycles) -> tuple[str, ...]:
        return tuple(self.run.system.key(name) for name in reading.factors)

    def _find_turn_terms(
        self, tops: Sequence[Turn], factors: tuple[str, ...], ends: bool
    ) -> list[InstantTerms]:
        """Values at which a quantity turns, one of which may be that at the end of the run."""
        system, n = self.run.system, len(self.run.system.structure.states)
        legs, times = np.array([top.leg for top in tops]), np.array([top.time for top in tops])
        found = values_at(self, differentiate_at_many(system, factors), legs, times)
        alternatives = []
        for top, row in zip(tops, found, strict=True):
            value, rate = float(row[0]), float(row[1])
            point = AdjointPoint(top.leg, top.time, 0, row[2 : 2 + n], row[2 + n :])
            if top.edge:
                point = replace(point, edge=self._find_joint_leg(top.edge), late=rate)
            by_end = rate if ends and top.time == self.until else 0.0
            alternatives.append(InstantTerms(value, (point,), by_end))
        for number in np.unique(legs).tolist():
            self.legs[number].cut(times[legs == number])
        return alternatives

    def _damage(self, reading: Cycles) -> ReadingTerms:
        factors = self._keys(reading)
        if factors not in self.turns:
            self.turns[factors] = turning_points(self, factors)
        turns = self.turns[factors]
        values = np.array([turn.value for turn in turns])
        slack = 10 * self.rtol * float(np.abs(values).max())
        damage, slopes = damage_slopes(values, reading.law, slack)
        if np.isinf(damage):
            raise SolverError(
                f"{self.run.system.name}: {reading} is infinite: the mean of a cycle reaches "
                "the ultimate strength, and the part breaks at once. Lower the load, or the scale.",
                self.run,
            )
        places = np.flatnonzero(slopes.any(axis=0)).tolist()
        terms = self._find_turn_terms([turns[k] for k in places], factors, ends=True)
        alternatives = []
        for by in slopes[:, places].tolist():
            parts = [scale_terms(one, k) for one, k in zip(terms, by, strict=True) if k]
            alternatives.append(replace(add_terms(parts), value=damage))
        where = "cycles of the same range, or an amplitude at the end of a law of the curve"
        return ReadingTerms(tuple(alternatives), "greatest", (), where)

    # -- at events ---------------------------------------------------------------------------

    def _events(self, label: str, component: str, after: str, number: int | None) -> list[int]:
        """Legs that begin at the events meant."""
        run = self.run
        times = [
            event.time
            for event in run.events
            if component in (event.component, *event.component.split(", "))
            and after in ("", event.after)
        ]
        if not times or (number is not None and not -len(times) <= number < len(times)):
            known = sorted(
                {
                    e.component if e.kind == "time" else f"{e.component}, {e.after}"
                    for e in run.events
                }
            )
            raise OptionError(
                f"{run.system.name}: {label}: there are {len(times)} such events in this run. "
                f"Events are: {'; '.join(known[:8]) or 'none'}."
            )
        begins: dict[float, list[int]] = {}
        for k, leg in enumerate(self.legs):
            if k:
                begins.setdefault(float(leg.t[0]), []).append(k)
        found = []
        for i in range(len(times)) if number is None else [number % len(times)]:
            time = max((t for t in begins if t <= times[i] < run.t[-1]), default=None)
            if time is None:
                raise OptionError(
                    f"{run.system.name}: {label} is at t = {times[i]:g} s, where the run begins or "
                    "ends; this instant does not move."
                )
            # several changes one after the other at the same instant
            legs = begins[time]
            found.append(self._find_joint_leg(legs[min(times[:i].count(times[i]), len(legs) - 1)]))
        return found

    def _find_joint_leg(self, number: int) -> int:
        """The leg at whose begin the changes are that happen where a leg begins."""
        while not self.crossings[number - 1].orders:
            number += 1
        return number

    def _instant(self, reading: Occurrence) -> ReadingTerms:
        label, component = str(reading), reading.component
        (number,) = self._events(label, component, reading.after, reading.number)
        crossing = self.crossings[number - 1]
        if len(crossing.orders) > 1 and component not in crossing.names:
            raise self._coincident(label, crossing)
        if any(jump.settles and component in jump.names for jump in crossing.orders[0]):
            bounces = find_last_bounces(self.crossings[: number - 1], component, self.until)
            if len(bounces) == 3:
                return ReadingTerms((self._accumulation(bounces, component),))
        return ReadingTerms((InstantTerms(crossing.t, (self._moving(number, component),)),))

    def _accumulation(self, bounces: list[int], component: str) -> InstantTerms:
        """Where impacts accumulate."""
        value, weights = find_limit_of_flights([self.crossings[k - 1].t for k in bounces])
        parts = zip(bounces, weights, strict=True)
        points = [replace(self._moving(k, component), late=weight) for k, weight in parts]
        return InstantTerms(value, tuple(points))

    def _at_events(self, reading: Value, at: AtEvent) -> Iterator[InstantTerms]:
        label = str(reading)
        for number in self._events(label, at.component, at.after, at.number):
            if len(self.crossings[number - 1].orders) > 1:
                raise self._coincident(label, self.crossings[number - 1])
            leg = number - (at.side == "before")
            t = float(self.legs[leg].t[-1 if at.side == "before" else 0])
            yield self._look(leg, t, reading.factors, number)[0]

    def _impacts(self, reading: Occurrence) -> Iterator[InstantTerms]:
        label, run = str(reading), self.run
        names = run.system.switching.names
        found: list[tuple[int, EventDerivatives, list[int]]] = []
        for number, crossing in enumerate(self.crossings, 1):
            for jump in (j for order in crossing.orders[:1] for j in order):
                blow = jump.act[1]
                holds = [h for h in (blow.members if blow else ()) if names[h] == reading.component]
                struck = [h for h in holds if self._impact("impulse", number, jump, h).value != 0]
                if struck:
                    found.append((number, jump, struck))
        chosen = found
        if reading.number is not None:
            if not -len(found) <= reading.number < len(found):
                raise OptionError(
                    f"{run.system.name}: {label}: there are {len(found)} impacts of "
                    f"{reading.component} in this run."
                )
            chosen = [found[reading.number]]
        elif not found:
            raise OptionError(
                f"{run.system.name}: {label}: there are no impacts of {reading.component} in "
                "this run."
            )
        for number, jump, holds in chosen:
            if len(self.crossings[number - 1].orders) > 1:
                raise self._coincident(label, self.crossings[number - 1])
            for h in holds:
                yield self._impact(reading.what, number, jump, h)

    def _impact(self, kind: str, number: int, jump: EventDerivatives, hold: int) -> InstantTerms:
        """Loss or impulse of a hold where a leg begins."""
        jumps, blow = jump.act
        assert blow is not None
        changes = saltation_of(self.run.system).changes
        function = changes.impact(kind, hold, jumps, blow, jump.after[1])
        x, m = jump.before
        y, by_x, by_p, along = function.at(x, self.run.theta, self.crossings[number - 1].t, m)
        t, slopes = float(self.legs[number - 1].t[-1]), (by_x.only_row, by_p.only_row)
        point = AdjointPoint(number - 1, t, 0, *slopes, number, float(along[0]))
        return InstantTerms(float(y[0]), (point,))

    def _coincident(self, label: str, crossing: Crossing) -> SolverError:
        return SolverError(
            f"{self.run.system.name}: {label}: at t = {crossing.t:.9g} s changes of "
            f"{', '.join(crossing.names)} coincide; there is no derivative. Change a parameter a "
            "little, or leave it out of `of`.",
            self.run,
        )
