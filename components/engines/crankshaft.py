"""Crankshaft of a reciprocating engine with its cylinders.

Source: Nestorides, A Handbook on Torsional Vibration (1958) (mass-elastic system of an
engine, phases of the cylinders from the firing order).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal

from lumped import Component, Connection, Flange, Param, chain, connect, param
from lumped.components.compliance import Damper, SpringDamper
from lumped.components.each import one_for_each
from lumped.components.engines.engine import Cylinder, Misfire
from lumped.components.inertia import Inertia
from lumped.components.sources import Fixed
from lumped.errors import DeclarationError, shown
from lumped.language.component import Made
from lumped.language.value_types import Numbers, Rows
from lumped.ops import pi

__all__ = ["Engine"]

_SHARED = ("bore", "r", "L", "m", "load", "compression", "n")
_ALIKE = ("pressure", "loads", "over_speed", "tangential", "strokes", "shape", "masses", "series")


def _throws(engine: Engine) -> list[Inertia]:
    return [Inertia(J=J) for J in one_for_each(engine, "J", engine._throws())]


def _shafts(engine: Engine) -> list[SpringDamper]:
    count = engine._throws() - 1
    both = zip(
        one_for_each(engine, "c", count), one_for_each(engine, "d_shaft", count), strict=True
    )
    return [SpringDamper(c=c, d=d) for c, d in both]


def _oil(engine: Engine) -> list[Damper]:
    return [Damper(d=d) for d in one_for_each(engine, "d", engine._throws())]


def _cylinders(engine: Engine) -> list[Cylinder]:
    shared = {name: getattr(Engine, name) for name in _SHARED}
    alike = {name: getattr(engine, name) for name in _ALIKE}
    missing = engine._missing()
    return [
        Cylinder(phase=phase, misfire=missing.get(k, "none"), **shared, **alike)
        for k, phase in enumerate(engine.phases, start=1)
    ]


class Engine(Component):
    """Crankshaft with n cylinders, which fire in turn: ``phase = i strokes pi / n``.

    The cylinders count from 1 at the flange `front`. `firing_order` names them in the order in
    which they fire, at equal angles: the i-th, counted from 0, begins its cycle at the angle
    `phase` of the crankshaft. Two- and four-stroke engines differ in `strokes`.

    In a vee engine each throw carries two cylinders: with n cylinders, throw k those numbered k and
    ``k + n/2``, the second in the bank that passes top dead centre `bank_angle` later. The first
    bank fires at equal angles, the other follows from the bank angle.

    `J` are the inertias of the throws, `c` and `d_shaft` stiffness and damping of the shafts
    between them, `d` the damping of each throw against the housing; each is one number for all or
    one for each. Bore, stroke (twice `r`), rod and the masses hold for all cylinders, and so do the
    fields of `Cylinder`. `misfire` says what cylinders miss, such as ``{3: "no gas"}``.

    Its parts are `throw`, `shaft`, `oil` and `cylinder`, counted from 0 as all parts are.
    """

    symbol = "crank"
    front = Flange(free=True)
    rear = Flange()
    cylinders: int = 1
    firing_order: Sequence[int] = (1,)
    strokes: Literal[2, 4] = 4
    bank_angle: float | None = None
    J: float | Numbers = 1.0
    c: float | Numbers = ()
    d: float | Numbers = 0.0
    d_shaft: float | Numbers = 0.0
    misfire: Mapping[int, Misfire] | Sequence[Any] = ()
    pressure: Rows | Sequence[Any] = ()
    loads: Numbers = ()
    over_speed: Rows = ()
    tangential: Rows = ()
    shape: Literal["lines", "smooth"] = "lines"
    masses: Literal["exact", "excitation", "series"] = "exact"
    series: Rows = ()
    bore: Param = param("m", "diameter of the pistons", above=0)
    r: Param = param("m", "crank radius, half of the stroke", above=0)
    L: Param = param("m", "length of the rods", above=r)
    m: Param = param("kg", "mass that moves with each piston", 0.0, min=0)
    load: Param = param("1", "load, or factor of the pressure", 1.0, min=0)
    compression: Param = param("1", "compression ratio", 17.0, above=1)
    n: Param = param("1", "exponent of compression without firing", 1.33, above=0)
    throw: Any = Made(_throws)
    shaft: Any = Made(_shafts)
    oil: Any = Made(_oil)
    cylinder: Any = Made(_cylinders)
    housing = Fixed()

    @property
    def phases(self) -> tuple[float, ...]:
        """Angle of the crankshaft at which the cycle of each cylinder begins, rad.

        Raises
        ------
        DeclarationError
            If the firing order is none, or does not fit the bank angle.
        """
        order, count, cycle = self._order(), self.cylinders, self.strokes * pi
        even = {number: i * cycle / count for i, number in enumerate(order)}
        if self.bank_angle is None:
            return tuple(even[k] for k in range(1, count + 1))
        found = dict(even)
        for k in range(1, count // 2 + 1):
            partner = k + count // 2
            near = (even[partner] - even[k] - self.bank_angle) / (2 * pi)
            found[partner] = even[k] + self.bank_angle + 2 * pi * round(near)
        fired = sorted(found, key=lambda number: found[number] % cycle)
        first = fired.index(order[0])
        if tuple(fired[first:] + fired[:first]) != order:
            raise DeclarationError(
                f"{self._label()}: firing_order = {shown(self.firing_order)} does not fit "
                f"bank_angle = {self.bank_angle:g} rad, with which the cylinders fire in the order "
                f"{tuple(fired[first:] + fired[:first])}; throw k carries the cylinders k and "
                f"k + {count // 2}."
            )
        return tuple(found[k] % cycle for k in range(1, count + 1))

    def connections(self) -> Iterator[Connection]:
        throws = self._throws()
        for name, count in (
            ("throw", throws),
            ("oil", throws),
            ("shaft", throws - 1),
            ("cylinder", self.cylinders),
        ):
            if len(getattr(self, name)) != count:
                raise DeclarationError(
                    f"{self._label()}: {len(getattr(self, name))} parts in {name}, but "
                    f"{self.cylinders} cylinders need {count}."
                )
        yield connect(self.front, self.throw[0].flange_a)
        yield connect(self.rear, self.throw[-1].flange_b)
        for i, shaft in enumerate(self.shaft):
            yield from chain(self.throw[i], shaft, self.throw[i + 1])
        for throw, oil in zip(self.throw, self.oil, strict=True):
            yield from chain(self.housing, oil, throw)
        for i, cylinder in enumerate(self.cylinder):
            yield connect(cylinder.flange, self.throw[i % throws].flange_a)

    def _throws(self) -> int:
        count = self.cylinders
        if isinstance(count, bool) or not isinstance(count, int) or count < 1:
            raise DeclarationError(f"{self._label()}: cylinders = {shown(count)}: at least 1.")
        if self.bank_angle is None:
            return count
        if count % 2:
            raise DeclarationError(
                f"{self._label()}: cylinders = {count} with bank_angle = {self.bank_angle:g} rad: "
                "an even number is needed, two on each throw; leave bank_angle out in line."
            )
        return count // 2

    def _order(self) -> tuple[int, ...]:
        order, wanted = tuple(self.firing_order), list(range(1, self.cylinders + 1))
        if sorted(order, key=str) != sorted(wanted, key=str):
            twice = sorted({k for k in order if order.count(k) > 1}, key=str)
            missed = [k for k in wanted if k not in order]
            strange = sorted({k for k in order if k not in wanted}, key=str)
            texts = [("twice", twice), ("missing", missed), ("unknown", strange)]
            what = "; ".join(f"{text}: {', '.join(map(str, ks))}" for text, ks in texts if ks)
            raise DeclarationError(
                f"{self._label()}: firing_order = {shown(self.firing_order)} must name each of the "
                f"cylinders 1 to {self.cylinders} once; {what}."
            )
        return order

    def _missing(self) -> dict[int, Misfire]:
        """What cylinders miss, by their numbers."""
        found: dict[int, Misfire] = dict(self.misfire)
        for number in found:
            if number not in range(1, self.cylinders + 1):
                raise DeclarationError(
                    f"{self._label()}: misfire names cylinder {shown(number)}; cylinders count "
                    f"from 1 to {self.cylinders}."
                )
        return found
