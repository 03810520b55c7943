"""Dry friction beside springs without inertia: Prandtl's and Jenkin's element.

The reaction ``r`` follows from the twist of the springs. Where these are damped, it also follows
from the rate of the twist, so ``r`` and the sliding speed ``v`` are one problem at each instant, as
a reaction and its acceleration are. Without damping ``r`` cannot jump; while the friction slides,
``r`` stays at its limit, which determines ``v``:

    0 <= upper - r  _|_  forward >= 0
    0 <= r - lower  _|_  backward >= 0,    v = forward - backward

Each line is a constraint that holds like a freewheel: the room up to the limit does not become
negative, and the reaction that sees to this is the speed. A limit that jumps below ``r`` moves the
friction at once, like an impact: the springs relax. (W. D. Iwan, J. Appl. Mech. 33 (1966) 893;
J. J. Moreau, J. Differential Equations 26 (1977) 347.)
"""

from __future__ import annotations

import copy
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from lumped.language.expression import (
    Call,
    Compare,
    ConstantExpression,
    Expr,
    Ref,
    as_expr,
    text,
    walk,
)
from lumped.language.quantity import Param, Quantity, Var
from lumped.language.switch import Hold, Item, Single, hold
from lumped.language.validity import Range
from lumped.ops import where

_ALIKE = 1e-9
"""Share by which a limit at rest may differ from that of sliding."""
_SOME = 0.7
"""Value of what a law depends on beside parameters."""


@dataclass
class Massless:
    """The equations of a component whose friction slides beside springs only.

    Attributes
    ----------
    items : list
        Its equations.
    variables : dict of str to Var
        Unknowns beside its own.
    speeds : set of str
        Its sliding speeds, which are no states.
    rooms : list of str
        Those of them that tell what is left up to a limit.
    ranges : list of Range
        Where these equations hold beside its own ranges.
    """

    items: list[Single] = field(default_factory=list)
    variables: dict[str, Var] = field(default_factory=dict)
    speeds: set[str] = field(default_factory=set)
    rooms: list[str] = field(default_factory=list)
    ranges: list[Range] = field(default_factory=list)

    def declared(self, name: str, quantity: Quantity) -> Quantity:
        """How a quantity of the component is declared here."""
        if name not in self.speeds:
            return quantity
        found = copy.copy(quantity)
        found.wish = "avoid"
        return found


def without_inertia(items: Iterable[Item], *, damped: bool) -> Massless | None:
    """Equations of a component with springs beside its friction; None if they have no solution.

    Springs may be `damped`.

    Friction that depends on the sliding speed would jump, and contacts have no inertia to stop.
    """
    found = Massless()
    for item in (e for e in items for e in (e if isinstance(e, tuple) else (e,))):
        if not isinstance(item, Hold):
            found.items.append(item)
        elif _has_form(item, damped=damped):
            found.speeds.add(item.speed.name)
            found.items += [replace(item, direct=True)] if damped else _one_sided(item, found)
        else:
            return None
    return found


def _has_form(item: Hold, *, damped: bool) -> bool:
    """Whether it is friction that, beside springs without damping, does not depend on the speed."""
    laws = [law for law in (item.forward, item.backward) if law is not None]
    speeds = [n for law in laws for n in walk(law) if isinstance(n, Ref)]
    is_friction = item.gap is None and item.pressed
    return is_friction and (damped or all(n.name != item.speed.name for n in speeds))


def _one_sided(item: Hold, found: Massless) -> Iterator[Single]:
    """Equations of one constraint for each limit, and of one that holds what is not engaged."""
    reaction, speed, engaged = item.reaction, item.speed, item.engaged

    def new(what: str, unit: str, text: str) -> Ref:
        name = f"{reaction.name}_{what}"
        variable = found.variables[name] = Var(unit, text, None, 1.0, "avoid")
        variable.name = name
        return Ref(speed.owner, name, variable)

    unit, rate = reaction.quantity.unit, speed.quantity.unit
    sliding: Expr = speed
    position: Expr = as_expr(0.0)
    ways = (("forward", 1, item.forward, item.upper), ("backward", -1, item.backward, item.lower))
    has_two = item.forward is not None and item.backward is not None
    for way, sign, law, limit in ways:
        if law is None or limit is None:
            continue
        if text(limit) != text(law):
            found.ranges += _ratio(limit, law, f"{reaction.name}, {way}")
        room = new(f"room_{way}", unit, f"what {reaction.name} can change until it slides {way}")
        slip = new(f"slip_{way}", rate, f"minus the speed of sliding {way}")
        own = new(f"position_{way}", "1", f"0 while it slides {way}, 1 while it does not")
        found.rooms.append(room.name)
        yield room == sign * (law - reaction)
        one = hold(slip, room, forward=0.0, upper=0.0, engaged=engaged, position=own)
        yield replace(one.called(way, "stuck", "free"), leaps=True, opposite=sign * has_two)
        sliding = sliding + sign * slip
        position = position + sign * (1 - own)
    if engaged is not None:
        slip = new("slip_free", rate, "minus the speed while it is not engaged")
        free = Compare(engaged.less, engaged.greater, not engaged.strict)
        yield hold(slip, reaction, engaged=free).called("free", "engaged", "engaged")
        sliding = sliding + slip
        position = where(engaged, position, 2.0)
    yield sliding == 0
    if item.position is not None:
        yield item.position == position


def _ratio(static: Expr, kinetic: Expr, what: str) -> Iterator[Range]:
    """The range of static over kinetic friction, 1, if it depends on parameters."""
    ratio = _of_parameters(static) / _of_parameters(kinetic)
    if any(isinstance(node, Ref) for node in walk(ratio)):
        yield Range(
            ratio,
            1 - _ALIKE,
            1 + _ALIKE,
            "1",
            f"static over kinetic friction of {what}",
            "Beside a spring alone friction that jumps has no law. Put an Inertia or Mass on each "
            "side, or give both frictions one value",
        )


def _of_parameters(law: Expr) -> Expr:
    """A law as the parameters give it, with a number for all that changes in a run."""
    if isinstance(law, Call):
        return Call(law.op, tuple(_of_parameters(part) for part in law.args))
    is_parameter = isinstance(law, Ref) and isinstance(law.quantity, Param)
    return law if is_parameter or isinstance(law, ConstantExpression) else as_expr(_SOME)
