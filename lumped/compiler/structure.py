"""What a scene needs of a reduced model: its states, their symbols, and the names of nodes."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.formulas import of_formula
from lumped.compiler.switching import Switching
from lumped.flattening.flat_model import FlatModel
from lumped.flattening.flatten import flatten
from lumped.flattening.measures import measure, watching
from lumped.flattening.parameters import Parameters
from lumped.language.component import Component
from lumped.language.expression import Expr
from lumped.language.formula import Formula
from lumped.reduction.evaluation import Values
from lumped.reduction.locked_loops import find_locked_loops
from lumped.reduction.pruning import (
    LeftOut,
    find_needed_states,
    find_used_states,
    independent_of,
    uses,
)
from lumped.reduction.reduce import reduce
from lumped.support.made_once import Shared, made_once

Name = str | Expr


class Recipe(NamedTuple):
    """All from which a structure is made again, in another process too.

    Attributes
    ----------
    model, motions, freed, massless
        What is flattened (see `flatten`).
    watched : tuple of Formula
        Those at whose kinks runs stop.
    outputs, kept : list of str
        Names of what was asked for; outputs may be None, for all.
    ranks, foresee, redundant
        As in `Structure`.
    """

    model: Component
    motions: Mapping[str, Expr]
    freed: frozenset[str]
    massless: Mapping[str, bool]
    watched: tuple[Formula, ...]
    outputs: list[str] | None
    kept: list[str]
    ranks: Mapping[int, int]
    foresee: bool
    redundant: bool

    def make(self) -> Structure:
        """The structure."""
        flat = flatten(self.model, self.motions, self.freed, self.massless)
        flat = watching(flat, self.watched)
        options = {"foresee": self.foresee, "redundant": self.redundant}
        return Structure(flat, self.outputs, self.kept, self.ranks, **options)


class Structure(Shared):
    """A reduced model with the states that a scene needs.

    Attributes
    ----------
    flat : FlatModel
        Equations before the reduction.
    tree : Tree
        Components, and numbers and names of their unknowns.
    reduced : Reduced
        Nodes, their order of computation, and all states.
    values : Values
        Expressions of nodes by symbols of all states, parameters, time, modes and guesses.
    switching : Switching
        What decides modes that depend on more than the time.
    outputs, kept : list of int
        Unknowns that were asked for; outputs may be None, for all.
    ranks : dict of int to int
        Nodes wanted as states, or not, beside what the model says.
    foresee : bool
        Runs know the instants of all functions of time before.
    redundant : bool
        All coordinates that varying constraints tie are states.
    invariants : SX
        What is left of the constraints that hold if they hold at the start, by all states.
    states : list of int
        Nodes of the states in use.
    in_use : list of int
        Their places among all states.
    members : dict of int to int
        The unknown that gives a node its name.
    positions : set of int
        Places, among all states, of positions of flanges.
    all_rates : SX
        Derivatives of the states in use, by the symbols of all states.
    rate_uses : ndarray of int
        Places of all states that occur in them.
    inputs : list of SX
        Symbols x, p, t and m of all functions; m is modes, then guesses of implicit nodes.
    left_out : list of LeftOut
        What is not computed, and why.
    seconds : dict of str to float
        Time that each stage took.
    """

    def __init__(
        self,
        flat: FlatModel,
        outputs: Iterable[Name] | None,
        keep: Iterable[Name],
        ranks: Mapping[int, int] | None = None,
        *,
        foresee: bool = True,
        redundant: bool = False,
    ) -> None:
        super().__init__()
        self.flat, self.tree = flat, flat.tree
        self.ranks, self.foresee, self.redundant = dict(ranks or {}), foresee, redundant
        begin = clock.perf_counter()
        self.reduced = reduce(flat, ranks, redundant=redundant)
        locked = find_locked_loops(self.reduced)
        middle = clock.perf_counter()
        self.values = Values(self.reduced)
        self.switching = Switching(self.values, foresee=foresee)
        self.outputs = None if outputs is None else [self.tree.unknown(n) for n in outputs]
        self.kept = [self.tree.unknown(name) for name in keep]
        self.members = self._members_of_nodes()
        self.positions = self._positions()
        self.in_use = self._find_needed_states()
        self.states = [self.reduced.states[i] for i in self.in_use]
        self.all_rates = self.values.of([n + 1 for n in self.states])
        self.rate_uses = find_used_states(self.all_rates, self.values)
        self.inputs = self._inputs()
        self.left_out = self._list_left_out() + locked
        end = clock.perf_counter()
        self.seconds = {"reduce": middle - begin, "prune": end - middle}

    @property
    def recipe(self) -> Recipe:
        """All from which it is made again."""
        name, flat = self.tree.unknown_name, self.flat
        outputs = None if self.outputs is None else [name(u) for u in self.outputs]
        tree = self.tree
        of_flat = tree.model, flat.motions, tree.freed, tree.massless, tuple(flat.watched)
        kept = [name(u) for u in self.kept]
        return Recipe(*of_flat, outputs, kept, self.ranks, self.foresee, self.redundant)

    def with_changes(
        self,
        flat: FlatModel | None = None,
        *,
        keep: Iterable[Name] = (),
        ranks: Mapping[int, int] | None = None,
        foresee: bool | None = None,
        redundant: bool | None = None,
    ) -> Structure:
        """The same but for other equations, more kept, other states, or without foresight."""
        flat, kept = flat or self.flat, [*self.recipe.kept, *keep]
        ranks = self.ranks if ranks is None else ranks
        options = {
            "foresee": self.foresee if foresee is None else foresee,
            "redundant": self.redundant if redundant is None else redundant,
        }
        return Structure(flat, self.recipe.outputs, kept, ranks, **options)

    @property
    def parameters(self) -> Parameters:
        """All parameters, those that can be changed and those that follow."""
        return self.flat.parameters

    @property
    def mode_count(self) -> int:
        """Number of modes: settings of conditions, holds and jumps."""
        return self.flat.mode_count

    @property
    def implicit(self) -> list[int]:
        """Nodes that Newton's method finds."""
        return self.values.implicit

    def _members_of_nodes(self) -> dict[int, int]:
        """Unknown that gives each node its name, of its sign: a variable before a port quantity."""
        other = np.array([q.kind != "variable" for q in self.tree.quantities], dtype=bool)
        own = np.where(self.reduced.aliases.signs > 0, self.reduced.nodes, -1)
        best = np.lexsort((other, own))
        nodes, places = np.unique(own[best], return_index=True)
        named = zip(nodes.tolist(), best[places].tolist(), strict=True)
        return {node: unknown for node, unknown in named if node >= 0}

    def node_name(self, node: int) -> str:
        """Name of a node: of its unknown, or ``der(...)`` of one."""
        if node in self.members:
            return self.tree.unknown_name(self.members[node])
        order = self.reduced.class_and_order(node)[1]
        inner = self.node_name(node - order)
        return "der(" * order + inner + ")" * order

    def is_angle(self, node: int) -> bool:
        """Whether a node is an angle, by its unit."""
        member = self.members.get(node)
        return member is not None and self.tree.quantity(member).unit == "rad"

    def _positions(self) -> set[int]:
        """Places, among all states, of positions of flanges."""
        port = np.array([q.kind == "potential" for q in self.tree.quantities], dtype=bool)
        found = self.reduced.nodes[port & (self.reduced.aliases.shifts == 0)]
        return set(np.flatnonzero(np.isin(self.reduced.states, found)).tolist())

    def _find_needed_states(self) -> list[int]:
        """Places of the states that must be integrated."""
        outputs = None if self.outputs is None else self.raw(self.outputs)
        implicit = self.values.of(self.values.implicit)
        always = ca.vertcat(self.raw(self.kept), implicit, self.switching.collect_needed())
        found = find_needed_states(self.values, self.positions, outputs, always)
        invariants = self.values.residuals(self.reduced.invariants)
        rows, columns = uses(invariants, self.values)
        while True:
            # a constraint holds if all states in it are integrated
            touched = np.unique(rows[np.isin(columns, found)])
            self.invariants = invariants[touched.tolist()]
            if set(columns[np.isin(rows, touched)].tolist()) <= set(found):
                return found
            always = ca.vertcat(always, self.invariants)
            found = find_needed_states(self.values, self.positions, outputs, always)

    def raw(self, numbers: list[int]) -> ca.SX:
        """Unknowns as expressions of all states, left out or not."""
        nodes = [self.reduced.node(u) for u in numbers]
        found = iter(ca.vertsplit(self.values.of([n for n in nodes if n is not None])))
        signs = self.reduced.aliases.signs
        parts = [
            ca.SX(0) if n is None else float(signs[u]) * next(found)
            for u, n in zip(numbers, nodes, strict=True)
        ]
        return ca.vertcat(ca.SX(0, 1), *parts)

    def formula(self, formula: Formula) -> ca.SX:
        """A formula as an expression of all states, left out or not.

        Where it is not watched, its kinks are comparisons.
        """
        group = self.flat.watched.get(formula) or measure(self.tree, formula, plain=True)
        return of_formula(self.values, group, *group.template.measures)

    def without(self, expression: ca.SX, lost: np.ndarray) -> ca.SX:
        """The expression with states taken out on which it does not depend."""
        if not len(lost):
            return expression
        symbols = self.values.states[lost.tolist()]
        return ca.substitute(expression, symbols, ca.SX.zeros(len(lost)))

    def available(self, nodes: list[int], *, cyclic: bool) -> np.ndarray:
        """Which nodes depend only on states in use (on cyclic ones only if allowed)."""
        if not nodes:
            return np.zeros(0, dtype=bool)
        states = np.array(self.reduced.states, dtype=int)
        usable = np.isin(states, self.states)
        if not cyclic:
            usable &= ~np.isin(states, list(self.cyclic))
        lost = self.values.states[np.flatnonzero(~usable).tolist()]
        return ~np.array(ca.which_depends(self.values.of(nodes), lost, 1, True), dtype=bool)

    def _inputs(self) -> list[ca.SX]:
        v = self.values
        x = v.states[self.in_use] if self.in_use else ca.SX(0, 1)
        return [x, self.parameters.theta, v.time, ca.vertcat(v.modes, v.guesses)]

    def in_states(self, expression: ca.SX) -> ca.SX:
        """An expression of the states in use."""
        lost = np.setdiff1d(find_used_states(expression, self.values), self.in_use)
        return ca.cse(self.without(expression, lost))

    @property
    @made_once
    def lost_states(self) -> tuple[str, ...]:
        """Names of the states that were left out; none if one of them has no name of its own."""
        lost = sorted(set(range(len(self.reduced.states))) - set(self.in_use))
        nodes = [self.reduced.states[i] for i in lost]
        named = all(node in self.members for node in nodes)
        return tuple(map(self.node_name, nodes)) if named else ()

    @property
    @made_once
    def cyclic(self) -> frozenset[int]:
        """Nodes of states in use that are not speeds and on which no derivative depends."""
        values, reduced = self.values, self.reduced
        first = [
            i
            for i, n in zip(self.in_use, self.states, strict=True)
            if reduced.class_and_order(n)[1] == 0
        ]
        stated = set(self.rate_uses.tolist())
        doubtful = [i for i in first if i in stated and i in self.positions]
        idle = set(first) - stated
        if doubtful:
            cancels = independent_of(self.all_rates, doubtful, values)
            idle |= {i for i, c in zip(doubtful, cancels, strict=True) if c}
        return frozenset(reduced.states[i] for i in idle)

    def _list_left_out(self) -> list[LeftOut]:
        aliases = self.reduced.aliases
        equal = int((aliases.classes >= 0).sum()) - aliases.count
        zero = int((aliases.classes < 0).sum())
        found = []
        if equal:
            found.append(LeftOut(f"{equal} aliases", "equal to another quantity"))
        if zero:
            found.append(LeftOut(f"{zero} quantities", "always zero"))
        in_use = set(self.states)
        why = "cyclic coordinate: nothing depends on it"
        if self.outputs is not None:
            why = "not needed for the requested outputs"
        for node in self.reduced.states:
            if node not in in_use:
                found.append(LeftOut(self.node_name(node), why))
        return found
