"""Which unknown occurs in which equation, at which derivative, with which coefficient."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from lumped.flattening.flat_model import FlatModel, Group
from lumped.flattening.residual import CONSTANT, Residual
from lumped.reduction.aliases import Aliases


@dataclass(frozen=True, eq=False)
class Entries:
    """Nonzero entries of the incidence, one array element each, sorted by row.

    Attributes
    ----------
    rows, classes, orders : ndarray of int
        Equation, class of unknowns, order of derivative.
    kinds : ndarray of int
        Kind of the coefficient (number, parametric, varying).
    values : ndarray
        The coefficient; nan if it is not a number and no point was given.
    """

    rows: np.ndarray
    classes: np.ndarray
    orders: np.ndarray
    kinds: np.ndarray
    values: np.ndarray


@dataclass(frozen=True, eq=False)
class Occurrence:
    """Where the symbols of one template equation occur, for some of its instances.

    Attributes
    ----------
    instances : ndarray of int, shape (m,)
        Instances of the group.
    classes, orders : ndarray of int, shape (m, symbols)
        Class (-1: zero) and order of derivative of each symbol.
    signs : ndarray, shape (m, symbols)
        Sign of the symbol relative to its class.
    """

    group: Group
    residual: Residual
    instances: np.ndarray
    classes: np.ndarray
    orders: np.ndarray
    signs: np.ndarray

    def pick(self, some: np.ndarray) -> Occurrence:
        """The same for some of these instances."""
        own = (self.instances, self.classes, self.orders, self.signs)
        return Occurrence(self.group, self.residual, *(held[some] for held in own))


class Incidence:
    """Equations left after alias elimination, numbered 0 .. count-1.

    Component equations come first (by group, template equation, instance), then flow sums.
    """

    def __init__(self, flat: FlatModel, aliases: Aliases) -> None:
        self.flat, self.aliases = flat, aliases
        self.blocks: list[tuple[Group, int, np.ndarray, int]] = []
        first = 0
        for group in flat.groups:
            n, m = group.template.count, len(group.nodes)
            kept = aliases.kept_equations[group.first_equation : group.first_equation + n * m]
            for e in range(n):
                instances = np.flatnonzero(kept[e::n])
                if len(instances):
                    self.blocks.append((group, e, instances, first))
                    first += len(instances)
        self.first_sum = first
        self._firsts = [block[3] for block in self.blocks]
        self.sums = np.flatnonzero(aliases.kept_sums)
        self.count = first + len(self.sums)
        sums = [flat.joints.sums[k] for k in self.sums.tolist()]
        self._flows = np.array([u for flows, _, _ in sums for u in flows], dtype=int)
        self._flow_signs = np.array([s for _, signs, _ in sums for s in signs])
        self._first_flow = np.cumsum([0, *(len(flows) for flows, _, _ in sums)])

    def origin(self, row: int) -> tuple[str, int]:
        """Kind and number of an equation: ``("equation", n)`` or ``("sum", k)``."""
        if row >= self.first_sum:
            return "sum", int(self.sums[row - self.first_sum])
        block, place = self.place(row)
        group, e, instances, _ = self.blocks[block]
        n = group.template.count
        return "equation", group.first_equation + int(instances[place]) * n + e

    def place(self, row: int) -> tuple[int, int]:
        """Block of a component equation, and its position in it."""
        block = bisect_right(self._firsts, row) - 1
        return block, row - self._firsts[block]

    def holds(self) -> dict[int, tuple[int, int]]:
        """Equations of constraints that hold or slide: the unknown reaction and speed of each."""
        found: dict[int, tuple[int, int]] = {}
        for group, e, instances, first in self.blocks:
            for stick in group.template.sticks:
                if stick.equation == e:
                    own = (group.unknowns[instances, k[0]] for k in (stick.reaction, stick.speed))
                    pairs = zip(*(unknowns.tolist() for unknowns in own), strict=True)
                    found.update(enumerate(pairs, first))
        return found

    def proportional(self, row: int, order: int = 0) -> bool:
        """Whether a component equation, differentiated, is one that `Residual.proportional` is."""
        if row >= self.first_sum:
            return False
        group, e, _, _ = self.blocks[self.place(row)[0]]
        return group.template.residual(e, order).proportional

    def occurrence(self, block: int, order: int, picked: np.ndarray) -> Occurrence:
        """Symbols of the equations `picked` (positions in the block), differentiated."""
        group, e, instances, _ = self.blocks[block]
        residual = group.template.residual(e, order)
        return self.locate(group, residual, instances[picked], residual.locals, residual.orders)

    def locate(
        self,
        group: Group,
        residual: Residual,
        instances: np.ndarray,
        locals_: np.ndarray,
        orders: np.ndarray,
    ) -> Occurrence:
        """Where local unknowns of a template at orders of derivative occur."""
        unknowns, a = group.unknowns[instances][:, locals_], self.aliases
        shifted = orders + a.shifts[unknowns]
        return Occurrence(
            group, residual, instances, a.classes[unknowns], shifted, a.signs[unknowns]
        )

    def alike(
        self, rows: np.ndarray, orders: np.ndarray
    ) -> Iterator[tuple[np.ndarray, Occurrence]]:
        """Component equations by template equation: their positions in `rows`, and occurrence."""
        positions = np.flatnonzero(rows < self.first_sum)
        blocks = np.searchsorted(self._firsts, rows[positions], side="right") - 1
        sort = np.lexsort((orders[positions], blocks))
        positions, blocks = positions[sort], blocks[sort]
        changes = (np.diff(blocks) != 0) | (np.diff(orders[positions]) != 0)
        ends = [*(np.flatnonzero(changes) + 1).tolist(), len(positions)]
        begin = 0
        for end in ends if len(positions) else ():
            block, some = int(blocks[begin]), positions[begin:end]
            yield (
                some,
                self.occurrence(block, int(orders[some[0]]), rows[some] - self._firsts[block]),
            )
            begin = end

    def sum_terms(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Positions in `rows`, classes, orders and coefficients in flow sums; zeros left out."""
        begin = self._first_flow[rows - self.first_sum]
        counts = self._first_flow[rows - self.first_sum + 1] - begin
        ends = np.cumsum(counts)
        places = np.repeat(np.arange(len(rows)), counts)
        index = np.arange(len(places)) + np.repeat(begin - ends + counts, counts)
        flows, signs, a = self._flows[index], self._flow_signs[index], self.aliases
        alive = a.classes[flows] >= 0
        places, flows, signs = places[alive], flows[alive], signs[alive]
        return places, a.classes[flows], a.shifts[flows], signs * a.signs[flows]

    def entries(
        self, orders: np.ndarray, at: GenericPoint | None = None, picked: np.ndarray | None = None
    ) -> Entries:
        """Entries of all equations, each differentiated `orders[row]` times.

        Parameters
        ----------
        orders : ndarray of int, shape (count,)
            Times to differentiate each equation.
        at : GenericPoint, optional
            Where to evaluate coefficients that are not numbers.
        picked : ndarray of bool, shape (count,), optional
            Restrict to these equations.
        """
        parts: list[tuple[np.ndarray, ...]] = []
        for block, (_, _, instances, first) in enumerate(self.blocks):
            span = slice(first, first + len(instances))
            wanted = np.ones(len(instances), dtype=bool) if picked is None else picked[span]
            for order in np.unique(orders[span][wanted]):
                places = np.flatnonzero(wanted & (orders[span] == order))
                parts.append(self._component_part(block, int(order), places, first, at))
        rows = np.arange(self.first_sum, self.count)
        if picked is not None:
            rows = rows[picked[self.first_sum :]]
        if len(rows):
            places, classes, shifts, values = self.sum_terms(rows)
            own = rows[places]
            parts.append((own, classes, shifts + orders[own], np.zeros_like(own), values))
        if not parts:
            none = np.zeros(0, dtype=int)
            return Entries(none, none, none, none, np.zeros(0))
        return _merge_entries(*(np.concatenate(p) for p in zip(*parts, strict=True)))

    def _component_part(
        self, block: int, order: int, places: np.ndarray, first: int, at: GenericPoint | None
    ) -> tuple[np.ndarray, ...]:
        seen = self.occurrence(block, order, places)
        m, n = seen.classes.shape
        values = np.broadcast_to(seen.residual.values, (m, n))
        if at is not None and n and (seen.residual.kinds != CONSTANT).any():
            values = at.coefficients(seen)
        alive = (seen.classes >= 0).ravel()
        columns = (
            np.repeat(first + places, n),
            seen.classes.ravel(),
            seen.orders.ravel(),
            np.tile(seen.residual.kinds, m),
            (values * seen.signs).ravel(),
        )
        return tuple(c[alive] for c in columns)


class GenericPoint:
    """A generic point near the start: a value for every class at every order.

    Where an expression is not finite there (a root or logarithm outside its range), another
    point is tried. Parameters have their defaults. `load` is the share of their values that flows
    (forces, torques, currents) have.
    """

    def __init__(
        self,
        flat: FlatModel,
        aliases: Aliases,
        orders: np.ndarray,
        load: float = 1.0,
    ) -> None:
        rng = np.random.default_rng(0)
        self.flat = flat
        shape = (len(orders), int(orders.max(initial=0)) + 3)
        begin = np.zeros(shape)
        for unknown, value in flat.start_numbers.items():
            number = aliases.classes[unknown]
            if number >= 0:
                begin[number, aliases.shifts[unknown]] = value * aliases.signs[unknown]
        share = np.ones(shape)
        flows = np.array([q.kind == "flow" for q in flat.tree.quantities], dtype=bool)
        flows &= aliases.classes >= 0
        share[aliases.classes[flows], aliases.shifts[flows]] = load
        self.choices = [
            share * (begin + rng.uniform(low, 3 * low, shape)) for low in (0.01, 0.3, 1e-5)
        ]
        self.parameters = flat.parameters.numbers
        self.time = 0.7

    def coefficients(self, seen: Occurrence) -> np.ndarray:
        """Coefficients of all symbols of an occurrence, shape (m, symbols)."""
        group, template = seen.group, seen.group.template
        m = len(seen.instances)
        evaluate = seen.residual.coefficients.map(m)
        parameters = self.parameters[group.parameters[seen.instances]].T
        result = np.full(seen.classes.shape, np.nan)
        for choice in self.choices:
            values = np.where(seen.classes >= 0, choice[seen.classes, seen.orders], 0.0)
            found = evaluate(
                (values * seen.signs).T,
                parameters,
                np.full((1, m), self.time),
                np.ones((len(template.modes), m)),
            )
            result = np.where(np.isfinite(result), result, np.asarray(found).T)
            if np.isfinite(result).all():
                break
        return result


def _merge_entries(
    rows: np.ndarray,
    classes: np.ndarray,
    orders: np.ndarray,
    kinds: np.ndarray,
    values: np.ndarray,
) -> Entries:
    """Add up what a row holds of the same unknown; drop what cancels exactly."""
    order = np.lexsort((orders, classes, rows))
    rows, classes, orders = rows[order], classes[order], orders[order]
    kinds, values = kinds[order], values[order]
    new = np.ones(len(rows), dtype=bool)
    new[1:] = (rows[1:] != rows[:-1]) | (classes[1:] != classes[:-1]) | (orders[1:] != orders[:-1])
    starts = np.flatnonzero(new)
    if len(starts):
        kinds = np.maximum.reduceat(kinds, starts)
        values = np.add.reduceat(values, starts)
    rows, classes, orders = rows[starts], classes[starts], orders[starts]
    keep = ~((kinds == CONSTANT) & (np.abs(values) < 1e-14))
    return Entries(rows[keep], classes[keep], orders[keep], kinds[keep], values[keep])
