"""The equations of one component class as CasADi expressions, shared by all its instances.

A class is lowered once; ten thousand instances cost one vectorised call, and so does the next
model with equal equations. The structure that the compiler needs (which unknown, at which
derivative, with which coefficient) is read off here.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from functools import partial

import casadi as ca
import numpy as np

from lumped.errors import EquationError
from lumped.flattening import hold_modes
from lumped.flattening.lowered_switches import Jump, Relation, Stick
from lumped.flattening.residual import CONSTANT, PARAMETRIC, VARYING, Residual
from lumped.language.component import Component
from lumped.language.connection import label
from lumped.language.declared import fields_of, has_parts, quantities_of
from lumped.language.derivatives import along, partials
from lumped.language.expression import Call, Compare, Expr, Piecewise, Ref, text, walk
from lumped.language.lowering import Branches, Kinks, Plain, has_range, has_steps, is_even, lower
from lumped.language.quantity import Param
from lumped.language.switch import Hold, Single, When

ENCLOSING = ".."
"""Path, in a template, of the component in which the one with the equations is a part."""


def template_key(component: Component) -> Hashable:
    """What two instances must share to have the same equations."""
    cls = type(component)
    choices = tuple((type(v), v) for v in (getattr(component, name) for name in fields_of(cls)))
    try:
        hash(choices)
    except TypeError:
        return id(component)
    return id(component) if has_parts(cls) else (cls, choices)


@dataclass(frozen=True, eq=False)
class Measure:
    """An expression whose value is wanted, and which is no part of the equations."""

    expression: Expr


Place = Callable[[Component], str | None]
"""Path of a component below the one that has the equations; None if it is no part of it."""

Lowered = Callable[[Expr], ca.SX]
"""CasADi form of an expression."""


def _may_overflow(law: Expr) -> bool:
    """Whether a law may have no finite value at a speed against its way; tables go on there."""
    nodes = list(walk(law))
    return not any(isinstance(node, Piecewise) for node in nodes) and any(
        has_range(node) or (isinstance(node, Call) and node.op in ("/", "exp", "sinh", "cosh"))
        for node in nodes
    )


class Template:
    """Equations of a component class (with fixed structural choices).

    It knows no instance, as it serves several models.

    Attributes
    ----------
    count : int
        Number of equations.
    unknowns : dict of (str, str) to int
        Path of the owner below the component ("" for itself) and name of each local unknown, in
        order, and its number.
    parameters : dict of (str, str) to SX
        The same for the parameters, and their symbols; `ENCLOSING` is the path of the component
        around it, whose parameters may occur in structural choices.
    relations, sticks, jumps : list
        What changes modes or states.
    measures : list of SX
        Values that are wanted beside the equations.
    branches : dict of int to tuple of (int, bool)
        Modes that only matter while all these other modes hold or do not.
    content : hashable
        All that it was made from.
    """

    content: Hashable

    def __init__(
        self,
        component: Component,
        place: Place,
        items: Iterable[Single | Measure],
        *,
        enclosed: bool = False,
        plain: bool = False,
    ) -> None:
        self.count = 0
        self._enclosed = enclosed
        self.unknowns: dict[tuple[str, str], int] = {}
        self.parameters: dict[tuple[str, str], ca.SX] = {}
        self.modes: list[ca.SX] = []
        self.relations: list[Relation] = []
        self.sticks: list[Stick] = []
        self.jumps: list[Jump] = []
        self.measures: list[ca.SX] = []
        self.time = ca.SX.sym("time")
        self._symbols: dict[tuple[int, int], ca.SX] = {}
        self._key_of: dict[int, tuple[int, int]] = {}
        self._residuals: dict[tuple[int, int], Residual] = {}
        self.branches: dict[int, tuple[tuple[int, bool], ...]] = {}
        self._numbers: dict[int, int] = {}
        self._alike: dict[tuple[bool, str, str], list[Relation]] = {}
        lowered = partial(self._lower, component, place, plain)
        for item in items:
            if isinstance(item, Hold):
                self._stick(item, lowered)
            elif isinstance(item, When):
                self._jump(item, lowered)
            elif isinstance(item, Measure):
                self.measures.append(lowered(item.expression))
            else:
                self._add(lowered(item.left - item.right))

    def _add(self, residual: ca.SX) -> None:
        self._residuals[self.count, 0] = self._analyse(residual)
        self.count += 1

    def inputs(self, keys: list[tuple[int, int]]) -> list[ca.SX]:
        """Inputs of functions of this template: symbols of keys, parameters, time, modes."""
        none = ca.SX(0, 1)
        symbols = ca.vertcat(none, *(self._symbols[k] for k in keys))
        parameters = ca.vertcat(none, *self.parameters.values())
        return [symbols, parameters, self.time, ca.vertcat(none, *self.modes)]

    def residual(self, number: int, order: int = 0) -> Residual:
        """Equation `number`, differentiated `order` times by the time."""
        found = self._residuals.get((number, order))
        if found is None:
            below = self.residual(number, order - 1)
            found = self._analyse(self._time_derivative(below.expression))
            self._residuals[number, order] = found
        return found

    def _lower(self, component: Component, place: Place, plain: bool, expression: Expr) -> ca.SX:
        return lower(
            expression,
            lambda node: self._leaf(node, component, place),
            time=self.time,
            derivative=self._time_derivative,
            kinks=None if plain else self,
        )

    def _stick(self, item: Hold, lowered: Lowered) -> None:
        """``r == law + share``, or ``a == demand + compliance (r - share)`` if it sticks."""
        first = len(self.modes)
        self.modes += [ca.SX.sym("mode") for _ in range(hold_modes.COUNT)]
        stuck, forward, backward, compliance, demand, share, _, _ = self.modes[first:]
        speed, reaction = lowered(item.speed), lowered(item.reaction)
        acceleration = speed if item.direct else self._time_derivative(speed)
        law = ca.SX(0)
        for way, sliding, given in ((1, forward, item.forward), (-1, backward, item.backward)):
            if given is not None:
                slid = lowered(given)
                if _may_overflow(given):  # where it does not slide this way, a speed of its range
                    within = sliding * speed + way * (1 - sliding)
                    slid = ca.substitute(slid, speed, within)
                law += sliding * slid
        engaged = None
        if item.engaged is not None:
            engaged = self._condition(item.engaged, lowered)
        number = self.count
        held = demand - acceleration + compliance * (reaction - share)
        self._add(stuck * held + (1 - stuck) * (reaction - law - share))
        if item.position is not None:
            code = 1 - stuck if item.gap is not None else forward - backward
            free = 0 if item.gap is not None else 2 * (1 - stuck - forward - backward)
            self._add(lowered(item.position) - code - free)

        def lower_or_nan(given: Expr | None) -> ca.SX:
            return ca.SX.nan() if given is None else lowered(given)

        limits = (item.upper, item.lower, item.forward, item.backward, item.gap)
        self.sticks.append(
            Stick(
                number,
                first,
                engaged,
                self._key_of[speed.element_hash()],
                self._key_of[acceleration.element_hash()],
                self._key_of[reaction.element_hash()],
                lower_or_nan(item.upper),
                lower_or_nan(item.lower),
                lower_or_nan(item.gap),
                lowered(item.restitution),
                (*(limit is not None for limit in limits), item.pressed, item.leaps, item.direct),
                item.opposite,
                item.words,
            )
        )

    def _jump(self, item: When, lowered: Lowered) -> None:
        mode = self._condition(item.condition, lowered)
        asked = item.question
        inputs, answers = ((), ()) if asked is None else (asked.values, asked.answers)
        program = None if asked is None else asked.program
        values = [lowered(value) for value in (*(value for _, value in item.changes), *inputs)]
        targets, taken = (
            [self._key_of[lowered(ref).element_hash()][0] for ref in refs]
            for refs in ((ref for ref, _ in item.changes), answers)
        )
        self.jumps.append(Jump(mode, targets, values, repr(item.condition), program, taken))

    def _condition(self, condition: Compare, lowered: Lowered) -> int:
        mode = self.mode(condition, lowered(condition.greater), lowered(condition.less))
        self.note_branches(mode, ())
        return [m.element_hash() for m in self.modes].index(mode.element_hash())

    def _leaf(self, node: Expr, component: Component, place: Place) -> ca.SX:
        if isinstance(node, Param):
            own = quantities_of(component).get(node.name) is node or not self._enclosed
            return self._parameter(("" if own else ENCLOSING, node.name))
        if not isinstance(node, Ref):
            raise EquationError(f"'{node!r}' is not a quantity of an instance.")
        below = place(node.owner)
        if below is None:
            raise EquationError(
                f"an equation uses {label(node)} of a component {type(node.owner).__name__} that "
                "is not one of its parts."
            )
        key = (below, node.name)
        if isinstance(node.quantity, Param):
            return self._parameter(key)
        if key not in self.unknowns:
            self.unknowns[key] = len(self.unknowns)
            self._add_symbol((self.unknowns[key], 0), node.name)
        return self.symbol(self.unknowns[key], 0)

    def _parameter(self, key: tuple[str, str]) -> ca.SX:
        if key not in self.parameters:
            self.parameters[key] = ca.SX.sym(key[1])
        return self.parameters[key]

    def _add_symbol(self, key: tuple[int, int], name: str) -> None:
        symbol = self._symbols[key] = ca.SX.sym(name)
        self._key_of[symbol.element_hash()] = key

    def symbol(self, unknown: int, order: int) -> ca.SX:
        """Symbol of a local unknown at an order of derivative."""
        key = (unknown, order)
        if key not in self._symbols:
            self._add_symbol(key, self._symbols[unknown, 0].name() + "'" * order)
        return self._symbols[key]

    def present(self, expression: ca.SX) -> list[tuple[int, int]]:
        """Local unknowns and orders of derivative that occur in an expression."""
        hashes = [s.element_hash() for s in ca.symvar(expression)]
        return sorted(self._key_of[h] for h in hashes if h in self._key_of)

    def _time_derivative(self, expression: ca.SX) -> ca.SX:
        keys = self.present(expression)
        symbols = ca.vertcat(self.time, *(self._symbols[k] for k in keys))
        rates = ca.vertcat(1, *(self.symbol(u, order + 1) for u, order in keys))
        return along(expression, symbols, rates)

    def mode(self, condition: Compare, greater: ca.SX, less: ca.SX) -> ca.SX:
        """1 while a relation holds, else 0; its lowered sides are given."""
        sides = text(condition.greater), text(condition.less)
        for known in self._alike.setdefault((condition.strict, *sides), []):
            if ca.is_equal(known.greater - known.less, greater - less, 100):
                return self.modes[known.mode]
        relation = Relation(
            len(self.modes), greater, less, condition.strict, sides, condition.words
        )
        self._alike[condition.strict, *sides].append(relation)
        self.relations.append(relation)
        self.modes.append(ca.SX.sym("mode"))
        return self.modes[-1]

    def note_branches(self, mode: ca.SX, branches: Branches) -> None:
        """Note that a mode matters only in some branches: all these other modes must be 1 or 0."""
        for i in range(len(self._numbers), len(self.modes)):
            self._numbers[self.modes[i].element_hash()] = i
        number = self._numbers[mode.element_hash()]
        found = tuple((self._numbers[m.element_hash()], holds) for m, holds in branches)
        known = self.branches.setdefault(number, found)
        pairs = zip(known, found, strict=False)
        self.branches[number] = tuple(
            a for a, _ in itertools.takewhile(lambda p: p[0] == p[1], pairs)
        )

    def inside_smooth(self) -> Kinks:
        """Kinks inside `smooth`."""
        return _Smooth(self)

    def piece(self, node: Piecewise, place: ca.SX, told: bool = True) -> ca.SX:
        """Settings of the piece that a place is in.

        The knots of a spline are watched only where they are known before the run: its slope and
        curvature are continuous there, and steps keep their tolerance without a stop.
        """
        if node.pieces.period is not None and self.present(place):
            return Plain().piece(node, place)
        width = node.pieces.width
        what = node.pieces, told
        for known in self.relations:
            if (known.pieces, known.told) == what and ca.is_equal(known.greater, place, 100):
                return ca.vertcat(*self.modes[known.mode : known.mode + width])
        first = len(self.modes)
        self.modes += [ca.SX.sym("piece") for _ in range(width)]
        sides = text(node.of), "a point of a table"
        begin = self.modes[first + 1]
        self.relations.append(Relation(first, place, begin, False, sides, None, node.pieces, told))
        return ca.vertcat(*self.modes[first:])

    def _analyse(self, expression: ca.SX) -> Residual:
        keys = self.present(expression)
        symbols = ca.vertcat(*(self._symbols[k] for k in keys)) if keys else ca.SX(0, 1)
        gradient = partials(expression, symbols)
        n = len(keys)
        kinds, values = np.full(n, VARYING), np.full(n, np.nan)
        affine = np.ones((n, n), dtype=bool)
        varying = ca.vertcat(symbols, self.time, *self.modes)
        for i in range(n):
            entry = gradient[i]
            if entry.is_zero() and has_steps(expression, symbols[i]):
                affine[i] = False  # its slope is zero, but it occurs there
            elif entry.is_constant():
                kinds[i], values[i] = CONSTANT, float(entry)
            elif not any(ca.which_depends(entry, varying)):
                kinds[i] = PARAMETRIC
            else:
                affine[i] = ~np.array(ca.which_depends(entry, symbols), dtype=bool)
        return Residual(
            inputs=partial(self.inputs, keys),
            expression=expression,
            locals=np.array([k[0] for k in keys], dtype=int),
            orders=np.array([k[1] for k in keys], dtype=int),
            symbols=symbols,
            partials=gradient,
            kinds=kinds,
            values=values,
            affine=affine,
        )


class _Smooth(Plain):
    """Kinks inside `smooth`: the points of a table of time are passed one by one, without events.

    They are known before a run and none comes twice, so that no evaluation looks at all rows.
    """

    def __init__(self, template: Template) -> None:
        self._template = template

    def piece(self, node: Piecewise, place: ca.SX) -> ca.SX:
        """Settings of the piece that a place is in."""
        template = self._template
        is_of_time = ca.depends_on(place, template.time) and not template.present(place)
        if node.pieces.period is None and is_of_time and is_even(place, template.time):
            return template.piece(node, place, told=False)
        return super().piece(node, place)

    def inside_smooth(self) -> Kinks:
        """The same."""
        return self
