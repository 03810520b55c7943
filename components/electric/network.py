"""Networks of three wires: an infinite bus, lines, series capacitors, faults and breakers.

Their pins `a`, `b`, `c` join those of a `WoundFieldMachine`; parts between two places have `a_1`,
`b_1`, `c_1` and `a_2`, `b_2`, `c_2`. `wires` connects all three at once.

Contacts are ideal: closed there is no voltage, open no current. A contact that opens goes on
conducting, by an arc without voltage, until its current passes zero. The parts that it interrupts
must have inductances, as machines and lines have. Source: Greenwood, Electrical Transients in Power
Systems, 2nd ed.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from lumped import (
    Component,
    Connection,
    Equation,
    Expr,
    Input,
    Param,
    Pin,
    Var,
    connect,
    der,
    param,
    time,
    var,
)
from lumped.errors import ConnectError, EquationError
from lumped.language.expression import Compare, Datum
from lumped.language.switch import Hold, Item, hold
from lumped.ops import cos, pi, sin, where

__all__ = [
    "CircuitBreaker",
    "InfiniteBus",
    "SeriesCapacitor",
    "ShortCircuit",
    "ThreePhaseLine",
    "wires",
]

_WITHSTAND = Datum(1e15)
"""Voltage that an open contact withstands, V: beyond any voltage of a network."""
_FAULTS = {
    "abc": ("a", "b", "c"),
    "ab": ("a", "b", "c"),
    "bc": ("c", "b", "a"),
    "ca": ("c", "a", "b"),
}
"""Wires of a fault: the first contact from the first to the second, the other from the third."""


def _contact(v: Expr, i: Expr, open_: Compare) -> Hold:
    """Contact with voltage `v` and current `i`, which opens where its current passes zero."""
    return hold(v, i, forward=0.0, backward=0.0, upper=_WITHSTAND, lower=-_WITHSTAND, engaged=open_)


class InfiniteBus(Component):
    """Three voltages in star, whatever current they take: ``v_a = V cos(w_1 t + phase)``.

    ``w_1 = 2 pi f``; b and c follow a by a third and two thirds of a period. The star point is
    grounded.
    """

    symbol = "voltage"
    a = Pin()
    b = Pin()
    c = Pin()
    V: Param = param("V", "amplitude of the voltage of a phase")
    f: Param = param("Hz", "frequency", above=0)
    phase: Param = param("rad", "angle of the voltage of phase a at the time zero", 0.0)

    def equations(self) -> Iterator[Equation]:
        angle = 2 * pi * self.f * time + self.phase
        yield self.a.v == self.V * cos(angle)
        yield self.b.v == self.V * cos(angle - 2 * pi / 3)
        yield self.c.v == self.V * cos(angle + 2 * pi / 3)


def _across(part: _Series, name: str) -> Expr:
    """Voltage in a wire, from 1 to 2."""
    voltage: Expr = getattr(part, f"{name}_1").v - getattr(part, f"{name}_2").v
    return voltage


class _Series(Component):
    """Three wires from the place 1 to the place 2, with their currents."""

    a_1 = Pin()
    b_1 = Pin()
    c_1 = Pin()
    a_2 = Pin()
    b_2 = Pin()
    c_2 = Pin()
    i_a: Var = var("A", "current of wire a, from 1 to 2")
    i_b: Var = var("A", "current of wire b, from 1 to 2")
    i_c: Var = var("A", "current of wire c, from 1 to 2")

    def equations(self) -> Iterator[Item]:
        for name in "abc":
            yield getattr(self, f"{name}_1").i == getattr(self, f"i_{name}")
            yield getattr(self, f"{name}_2").i == -getattr(self, f"i_{name}")


class ThreePhaseLine(_Series):
    """Resistance and inductance in each of three wires: ``v_1 - v_2 = R i + L der(i)``.

    For lines, transformers and the inner impedance of a network, without coupling of the wires.
    """

    symbol = "inductor"
    R: Param = param("Ohm", "resistance of a wire", 0.0, min=0)
    L: Param = param("H", "inductance of a wire", above=0)

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        for name in "abc":
            i = getattr(self, f"i_{name}")
            yield _across(self, name) == self.R * i + self.L * der(i)

    def loss(self) -> Expr:
        """Heat, W."""
        return self.R * (self.i_a**2 + self.i_b**2 + self.i_c**2)


class SeriesCapacitor(_Series):
    """Capacitor in each of three wires: ``i = C der(v)`` with ``v = v_1 - v_2``.

    It takes ``1 / (w_1 C)`` away from the reactance of a line, and resonates with the inductance
    `L` of its circuit at ``w_e = 1 / sqrt(L C)``. Where ``w_1 - w_e`` meets a torsional frequency
    of a generator, its shaft may vibrate by itself (subsynchronous resonance; Kundur, ch. 15).

    States are the voltages in axes that turn with ``w_1 = 2 pi f``, d on the axis of wire a at the
    time zero: ``i_d = C (der(v_d) - w_1 v_q)``, ``i_q = C (der(v_q) + w_1 v_d)``. In steady state
    they are constant. A star point is isolated, as in `WoundFieldMachine`: the currents of the
    wires sum to zero, and so do the voltages.
    """

    symbol = "capacitor"
    C: Param = param("F", "capacitance of a wire; for none, leave the capacitor out", above=0)
    f: Param = param("Hz", "frequency of the network")
    v_d: Var = var("V", "voltage from 1 to 2, d axis", state="prefer")
    v_q: Var = var("V", "voltage from 1 to 2, q axis", state="prefer")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        w_1, root = 2 * pi * self.f, 3**0.5
        cosine, sine = cos(w_1 * time), sin(w_1 * time)
        v_alpha = self.v_d * cosine - self.v_q * sine
        v_beta = self.v_d * sine + self.v_q * cosine
        yield _across(self, "a") == v_alpha
        yield _across(self, "b") == (root * v_beta - v_alpha) / 2
        yield _across(self, "c") == -(root * v_beta + v_alpha) / 2
        i_alpha = (2 * self.i_a - self.i_b - self.i_c) / 3
        i_beta = (self.i_b - self.i_c) / root
        yield i_alpha * cosine + i_beta * sine == self.C * (der(self.v_d) - w_1 * self.v_q)
        yield i_beta * cosine - i_alpha * sine == self.C * (der(self.v_q) + w_1 * self.v_d)


class CircuitBreaker(_Series):
    """Contacts in the wires a and c: closed ``v_1 = v_2``, open ``i = 0``.

    Wire b has none: on one side of it stands a star point that is isolated, as in
    `WoundFieldMachine`, so no current is left in b. Closed while `closed` is above 1/2, such as
    ``closed=where(time < 0.2, 1, 0)``: for load rejection, reclosing, and the synchronisation of a
    machine that runs on its own. If it is open at the start, no current may flow then.
    """

    closed: Input = Input("1", "closed above 1/2, open below")
    v_a: Var = var("V", "voltage across the contact in wire a")
    v_c: Var = var("V", "voltage across the contact in wire c")

    def equations(self) -> Iterator[Item]:
        yield from super().equations()
        yield self.v_a == self.a_1.v - self.a_2.v
        yield self.b_1.v == self.b_2.v
        yield self.v_c == self.c_1.v - self.c_2.v
        yield _contact(self.v_a, self.i_a, self.closed < 0.5)
        yield _contact(self.v_c, self.i_c, self.closed < 0.5)


class ShortCircuit(Component):
    """Fault without resistance between three wires or two: ``v = 0`` from `begin` to `end`.

    `phases` is "abc", "ab", "bc" or "ca"; the ground takes no part. From `end` on each contact
    conducts until its current passes zero. Three phases are joined by contacts from a to b and from
    c to b. A run that begins in steady state begins before the fault.
    """

    a = Pin()
    b = Pin()
    c = Pin()
    phases: str = "abc"
    begin: Param = param("s", "instant at which it begins")
    end: Param = param("s", "instant from which on it is cleared", 1e9, above=begin)
    i_a: Var = var("A", "current of wire a into the fault", state="always")
    i_b: Var = var("A", "current of wire b into the fault")
    i_c: Var = var("A", "current of wire c into the fault", state="always")
    v_1: Var = var("V", "voltage across the first contact")
    v_2: Var = var("V", "voltage across the second contact, or of the sound wire")

    def equations(self) -> Iterator[Item]:
        first, common, other = _contacts(self.phases)
        current = {"a": self.i_a, "b": self.i_b, "c": self.i_c}
        pin = {"a": self.a, "b": self.b, "c": self.c}
        open_ = where(time < self.begin, 1.0, where(time < self.end, 0.0, 1.0)) > 0.5
        for name, i in current.items():
            yield pin[name].i == i
        yield self.i_a + self.i_b + self.i_c == 0
        yield self.v_1 == pin[first].v - pin[common].v
        yield self.v_2 == pin[other].v - pin[common].v
        yield _contact(self.v_1, current[first], open_)
        if len(self.phases) == 3:
            yield _contact(self.v_2, current[other], open_)
        else:
            yield current[other] == 0


def _contacts(phases: str) -> tuple[str, str, str]:
    """Wires of the first contact, and the other wire.

    Raises
    ------
    EquationError
        If there is no such fault.
    """
    if phases not in _FAULTS:
        raise EquationError(f"phases = {phases!r} must be one of {', '.join(map(repr, _FAULTS))}.")
    return _FAULTS[phases]


def wires(*parts: Component) -> Iterator[Connection]:
    """Connect the three wires of parts, one part after the other: ``a_2`` to ``a_1``, and so on.

    A part with single pins `a`, `b`, `c` may stand at either end, or between others as a branch:
    ``wires(bus, line, fault, machine)``.

    Parameters
    ----------
    *parts : Component
        In their order.

    Returns
    -------
    iterator of Connection
        Three for each two neighbours.

    Raises
    ------
    ConnectError
        If a part has no three wires.
    """
    for before, after in itertools.pairwise(parts):
        for name in "abc":
            yield connect(_pin(before, name, 2), _pin(after, name, 1))


def _pin(part: Component, name: str, side: int) -> Pin:
    for known in (f"{name}_{side}", name):
        if known in part._ports:
            found: Pin = getattr(part, known)
            return found
    raise ConnectError(
        f"wires: {part._label()} has no pin '{name}' or '{name}_{side}'; it has "
        f"{', '.join(part._ports) or 'no ports'}."
    )
