"""What decides modes: functions of time, conditions on states, holds, changes of states."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import TypeVar

import casadi as ca
import numpy as np

from lumped.compiler.condition import Condition, sort_conditions
from lumped.compiler.formulas import of_formula
from lumped.errors import SingularModelError
from lumped.flattening import hold_modes
from lumped.flattening.flat_model import Group
from lumped.flattening.lowered_switches import Jump, Relation
from lumped.flattening.template import Template
from lumped.language.pieces import Pieces
from lumped.language.program import Program
from lumped.reduction.evaluation import Values
from lumped.support.made_once import Shared, made_once

_T = TypeVar("_T")

_SHARP, _COARSE = 4e-13, 1e-10
"""Relative tolerances of conditions and of limits of reactions, far above rounding."""


@dataclass(frozen=True, eq=False)
class _Jumps:
    """State changes of one `when`.

    Attributes
    ----------
    name, condition : str
        Its component, and its condition in words.
    mode : int
        Mode of its condition.
    nodes, signs : list of int, list of float
        Nodes that change.
    first, width : int
        Their new values among those of all, and with what a program is given.
    program : Program or None
        What is asked.
    answers, answer_signs : list of int, list of float
        Nodes that take what it answers.
    """

    name: str
    condition: str
    mode: int
    nodes: list[int]
    signs: list[float]
    first: int
    width: int
    program: Program | None
    answers: list[int]
    answer_signs: list[float]

    @property
    def question(self) -> slice:
        """Where that with which a program is asked is, among the values of all."""
        return slice(self.first + len(self.nodes), self.first + self.width)

    def fill(self, held: list[_T], other: _T) -> list[_T]:
        """What belongs to the nodes, for all of its values."""
        return held + [other] * (self.width - len(held))


class Switching(Shared):
    """Relations, holds and jumps of all instances as expressions, in order of declaration.

    Attributes
    ----------
    timed : list of Condition
        Those that depend on the time and on parameters only, each after those that it needs.
    needs : list of list of int
        Numbers of those that each of them needs.
    conditions : list of Condition
        All others.
    relation_modes : ndarray of int, shape (r,)
        Mode of each of these, or first setting of its piece.
    strict : ndarray of bool, shape (r,)
        Conditions that are false where both sides are equal.
    greater, less : SX, shape (r, 1)
        Their sides, far apart and in favour of the mode as it is where the condition does not
        matter; or the argument of a table, and the begin of the piece it is in.
    first_modes : ndarray of int, shape (h,)
        First mode of each hold (see `hold_modes`).
    engaged : ndarray of int, shape (h,)
        Mode of the condition under which a hold acts, -1 for always.
    has_upper, has_lower, has_forward, has_backward, has_gap : ndarray of bool, shape (h,)
        What limits and laws there are.
    is_pressed : ndarray of bool, shape (h,)
        Friction that impulses may press.
    may_leap, is_direct : ndarray of bool, shape (h,)
        Holds whose speed may jump with conditions; those whose reaction gives it, not its rate.
    opposite : ndarray of int, shape (h,)
        Hold of the opposite limit of the same friction, -1 if there is none.
    names : list of str
        Components of the holds.
    gap_units : list of str
        Units of their gaps.
    words : list of (str, str, str) or None
        What holds are called while they stick, slide forward, are free; None for usual words.
    speeds : list of int
        Node of the speed of each hold, -1 if it is always zero.
    speed_signs : list of float
        Sign of the speed relative to its node.
    speed, acceleration, reaction, upper, lower, gap, restitution : SX, shape (h, 1)
        Their quantities.
    jumps : list
        Changes of states.
    values : SX
        New values of all jumps.
    rows : list of (str, int)
        What each margin is: "relation", "upper", "lower" or "slide", and number of the relation
        or hold.
    """

    def __init__(self, values: Values, *, foresee: bool = True) -> None:
        super().__init__()
        self._values, self.flat = values, values.flat
        self.rows: list[tuple[str, int]] = []
        found_conditions: list[Condition] = []
        first_modes: list[int] = []
        engaged: list[int] = []
        quantities: list[ca.SX] = []
        limits: list[tuple[bool, ...]] = []
        opposite: list[int] = []
        self._texts: dict[tuple[int, int], tuple[str, str]] = {}
        self.names: list[str] = []
        self.gap_units: list[str] = []
        self.words: list[tuple[str, str, str] | None] = []
        self.speeds: list[int] = []
        self.speed_signs: list[float] = []
        self.jumps: list[_Jumps] = []
        new_values: list[ca.SX] = []
        for group in self.flat.groups:
            template = group.template
            if not (template.relations or template.sticks or template.jumps):
                continue
            wanted = _collect_expressions(template)
            count, width = len(group.nodes), len(template.modes)
            if template.measures:
                found = of_formula(values, group, ca.vertcat(*wanted))
            else:
                found = self._instances(group, ca.vertcat(*wanted))
            for i in range(count):
                own, mode = iter(ca.vertsplit(found[:, i])), group.first_mode + i * width
                name = group.names[i] or self.flat.name
                for relation in template.relations:
                    place, sides = mode + relation.mode, (next(own), next(own))
                    active = self._active(template, relation, mode)
                    found_conditions.append(Condition(name, place, *sides, relation, active))
                for stick in template.sticks:
                    quantities.append(ca.horzcat(*islice(own, 7)))
                    first_modes.append(mode + stick.first)
                    engaged.append(-1 if stick.engaged is None else mode + stick.engaged)
                    limits.append(stick.given)
                    opposite.append(len(opposite) + stick.opposite if stick.opposite else -1)
                    self.names.append(name)
                    self.words.append(stick.words)
                    unknown = int(group.unknowns[i, stick.speed[0]])
                    unit = self.flat.tree.quantity(unknown).unit
                    self.gap_units.append(unit.removesuffix("/s"))
                    node = values.reduced.node(unknown)
                    self.speeds.append(-1 if node is None else node + stick.speed[1])
                    self.speed_signs.append(float(values.reduced.aliases.signs[unknown]))
                for jump in template.jumps:
                    self.jumps.append(self._jump(group, i, jump, name, mode, len(new_values)))
                    new_values += islice(own, len(jump.values))
        self.timed, self.needs, self.conditions = sort_conditions(
            found_conditions, values, foresee=foresee
        )
        self.relation_modes = np.array([c.mode for c in self.conditions], dtype=int)
        self.strict = np.array([c.relation.strict for c in self.conditions], dtype=bool)
        guarded = [self._guard(c) for c in self.conditions]
        self.greater = ca.vertcat(ca.SX(0, 1), *(greater for greater, _ in guarded))
        self.less = ca.vertcat(ca.SX(0, 1), *(less for _, less in guarded))
        self.first_modes = np.array(first_modes, dtype=int)
        self.engaged = np.array(engaged, dtype=int)
        *flags, pressed, self.may_leap, self.is_direct = np.reshape(limits, (-1, 8)).T.astype(bool)
        self.has_upper, self.has_lower, self.has_forward, self.has_backward, self.has_gap = flags
        self.opposite = np.array(opposite, dtype=int)
        self.is_pressed = pressed & self.has_upper & self.has_lower
        table = ca.vertcat(ca.SX(0, 7), *quantities)
        self.speed, self.acceleration, self.reaction, *rest = ca.horzsplit(table)
        self.upper, self.lower, self.gap, self.restitution = rest
        self.values = ca.vertcat(ca.SX(0, 1), *new_values)

    def __bool__(self) -> bool:
        return bool(len(self.relation_modes) or len(self.first_modes) or self.jumps)

    def _active(self, template: Template, relation: Relation, first: int) -> ca.SX | None:
        """1 while a relation of an instance matters; None if it always does."""
        branches = template.branches.get(relation.mode, ())
        if not branches or relation.pieces is not None:
            return None
        parts = [self._values.modes[first + k] for k, _ in branches]
        factors = [m if holds else 1 - m for m, (_, holds) in zip(parts, branches, strict=True)]
        product = factors[0]
        for factor in factors[1:]:
            product = product * factor
        return product

    def _guard(self, condition: Condition) -> tuple[ca.SX, ca.SX]:
        greater, less, active = condition.greater, condition.less, condition.active
        if active is None:
            return greater, less
        as_is = 2 * self._values.modes[condition.mode] - 1
        return ca.if_else(active, greater, as_is), ca.if_else(active, less, 0)

    def _instances(self, group: Group, expressions: ca.SX) -> ca.SX:
        """Expressions of a template for all its instances, one column each."""
        template, values = group.template, self._values
        keys = template.present(expressions)
        locals_ = np.array([k[0] for k in keys], dtype=int)
        orders = np.array([k[1] for k in keys], dtype=int)
        count, reduced = len(group.nodes), values.reduced
        every = np.arange(count)
        seen = reduced.incidence.locate(group, template.residual(0), every, locals_, orders)
        high = (seen.classes >= 0) & (seen.orders > reduced.highest[seen.classes])
        if high.any():
            i, k = np.argwhere(high)[0]
            used = template.symbol(locals_[k], 0).name()
            raise SingularModelError(
                f"{self.flat.name}: a condition or hold of {group.names[i]} uses derivative "
                f"{orders[k]} of {used}, which no equation determines."
            )
        function = ca.Function("switching", template.inputs(keys), [expressions])
        result: ca.SX = function(*values.arguments(seen))
        return result if result.columns() == count else ca.repmat(result, 1, count)

    def _jump(self, group: Group, i: int, jump: Jump, name: str, mode: int, first: int) -> _Jumps:
        nodes, signs = self._find_changed(group, i, jump, name, jump.targets)
        answers = self._find_changed(group, i, jump, name, jump.answers)
        place = mode + jump.mode
        given = nodes, signs, first, len(jump.values), jump.program
        return _Jumps(name, jump.condition, place, *given, *answers)

    def _find_changed(
        self, group: Group, i: int, jump: Jump, name: str, unknowns: list[int]
    ) -> tuple[list[int], list[float]]:
        """Nodes of states that a jump changes, and their signs."""
        reduced = self._values.reduced
        nodes, signs = [], []
        for local in unknowns:
            unknown = int(group.unknowns[i, local])
            node = reduced.node(unknown)
            if node is None or node not in reduced.states:
                shown = self.flat.tree.unknown_name(unknown)
                raise SingularModelError(
                    f"{self.flat.name}: {name} changes {shown} when {jump.condition}, but it "
                    "is not a state: other quantities determine it. Declare it with "
                    "state='always', or change the states that it follows from."
                )
            nodes.append(node)
            signs.append(float(reduced.aliases.signs[unknown]))
        return nodes, signs

    def relation_text(self, number: int, mode: float) -> tuple[str, str]:
        """Component of a condition, and what its mode or the number of its piece says in words."""
        place = number, int(mode)
        if place not in self._texts:
            condition = self.conditions[number]
            self._texts[place] = condition.name, condition.texts(np.array([int(mode)]))[0]
        return self._texts[place]

    @cached_property
    def is_table(self) -> np.ndarray:
        """Whether each condition chooses a piece of a table, shape (r,)."""
        return np.array([c.pieces is not None for c in self.conditions], dtype=bool)

    @cached_property
    def tables(self) -> list[tuple[int, Pieces]]:
        """Numbers of the conditions that choose a piece of a table, and the pieces."""
        return [(k, c.pieces) for k, c in enumerate(self.conditions) if c.pieces is not None]

    def begin(self, modes: np.ndarray, greater: np.ndarray, less: np.ndarray) -> None:
        """Set the modes of all conditions by their sides; where equal, ``>=`` holds, not ``>``.

        Shapes (..., modes) and (..., r), for one point or for many.
        """
        slack = _SHARP * (np.abs(greater) + np.abs(less)) + 1e-13
        least = np.where(self.strict, slack, -slack)
        modes[..., self.relation_modes] = greater - less > least
        for k, pieces in self.tables:
            chosen = pieces.settings(pieces.number(greater[..., k]))
            modes[..., self.conditions[k].modes] = chosen

    def wrong(self, modes: np.ndarray, run: np.ndarray, slack: np.ndarray) -> np.ndarray:
        """Which conditions do not say what their sides say, with the differences of these."""
        on = modes[self.relation_modes] > 0.5
        found: np.ndarray = np.where(on, run < -slack, run > slack)
        for k, _ in self.tables:
            k0, k1, k2 = modes[self.relation_modes[k] + 2 :][:3]
            found[k] = k0 + run[k] * (k1 + k2 * run[k]) < -slack[k]
        return found

    def positions(self, modes: np.ndarray) -> np.ndarray:
        """What tells the positions of conditions and holds apart: modes without their rounding."""
        found = np.asarray(modes != 0, dtype=float)
        for first in self.first_modes.tolist():
            found[first + hold_modes.DEMAND : first + hold_modes.COUNT] = 0.0
        for k, _ in self.tables:
            own = self.conditions[k].modes
            found[own] = 0.0
            found[own[0]] = modes[own[0]]
        return found

    def turn(self, modes: np.ndarray, number: int, run: float) -> None:
        """Change a condition: to its contrary, or to the next piece."""
        condition = self.conditions[number]
        pieces, mode = condition.pieces, condition.mode
        if pieces is None:
            modes[mode] = 1.0 - modes[mode]
            return
        _, k1, k2 = modes[mode + 2 : mode + 5]
        onward = k1 < 0 or k2 * run < -0.5
        piece = int(modes[mode]) + (1 if onward else -1)
        modes[condition.modes] = pieces.settings(np.array(min(max(piece, 0), pieces.count - 1)))

    def find_held(self, modes: np.ndarray) -> list[int]:
        """Nodes of the speeds that are held at zero in these modes."""
        stuck = modes[self.first_modes] > 0.5
        return [node for node, holds in zip(self.speeds, stuck, strict=True) if holds]

    @cached_property
    def _needed(self) -> dict[str, ca.SX]:
        """What decides modes, by its names."""
        motion = ("greater", "less", "speed", "acceleration", "reaction")
        limits = ("upper", "lower", "gap", "restitution", "values")
        return {name: getattr(self, name) for name in motion + limits}

    def collect_needed(self) -> ca.SX:
        """All that must be computable to decide on modes."""
        return ca.vertcat(*self._needed.values())

    @cached_property
    def places_needed(self) -> dict[str, slice]:
        """Where the parts of `collect_needed` are, by their names."""
        ends = np.cumsum([part.numel() for part in self._needed.values()]).tolist()
        begins = [0, *ends[:-1]]
        return dict(zip(self._needed, map(slice, begins, ends), strict=True))

    @property
    @made_once
    def margins(self) -> tuple[ca.SX, ca.SX]:
        """What is negative as soon as a mode must change, and how far it may be; (k, 1) each."""
        modes = self._values.modes
        found: list[ca.SX] = []
        tolerances: list[ca.SX] = []
        rows: list[tuple[str, int]] = []

        def add(margin: ca.SX, tolerance: ca.SX, kind: str, number: int) -> None:
            found.append(margin)
            tolerances.append(tolerance)
            rows.append((kind, number))

        for k, condition in enumerate(self.conditions):
            greater, less, mode = self.greater[k], self.less[k], condition.mode
            size = ca.fabs(greater) + ca.fabs(less)
            if condition.pieces is None:
                margin = (2 * modes[mode] - 1) * (greater - less)
            else:
                run, (k0, k1, k2) = greater - less, ca.vertsplit(modes[mode + 2 : mode + 5])
                margin = k0 + run * (k1 + k2 * run)
            add(margin, _SHARP * size + 1e-13, "relation", k)
        for h, first in enumerate(self.first_modes.tolist()):
            own = modes[first : first + hold_modes.COUNT]
            stuck, forward, backward, compliance, _, _, slack, parted = ca.vertsplit(own)
            reaction = self.reaction[h]
            for kind, given, limit, sign in (
                ("upper", self.has_upper[h], self.upper[h], 1),
                ("lower", self.has_lower[h], self.lower[h], -1),
            ):
                if given:
                    size = ca.fabs(limit) + ca.fabs(reaction)
                    room = sign * (limit - reaction) + slack
                    tolerance = _COARSE * size + 1e-13 + slack
                    add(ca.if_else(stuck, room, 1), tolerance, kind, h)
            if self.has_gap[h]:
                add(ca.if_else(forward, self.gap[h] - parted, 1), ca.SX(1e-13), "slide", h)
            elif self.has_forward[h] or self.has_backward[h]:
                sliding = (forward - backward) * self.speed[h]
                free = 1 - forward - backward
                if self.opposite[h] >= 0:  # both limits are met only where they come to zero
                    opposed = modes[self.first_modes[self.opposite[h]] + hold_modes.STUCK]
                    sliding, free = (1 - opposed) * sliding, (1 - opposed) * free + opposed
                add(sliding + free, ca.if_else(compliance > 0, 1e-9, 1e-13), "slide", h)
        empty, self.rows = ca.SX(0, 1), rows
        return ca.vertcat(empty, *found), ca.vertcat(empty, *tolerances)


def _collect_expressions(template: Template) -> list[ca.SX]:
    """Sides of relations, quantities of holds, new values of jumps, in one column."""
    found: list[ca.SX] = []
    for relation in template.relations:
        found += [relation.greater, relation.less]
    for stick in template.sticks:
        found += [template.symbol(*k) for k in (stick.speed, stick.acceleration, stick.reaction)]
        found += [stick.upper, stick.lower, stick.gap, stick.restitution]
    for jump in template.jumps:
        found += jump.values
    return found
