"""A reduced model with its CasADi functions, built when first asked for."""

from __future__ import annotations

import time as clock
from collections.abc import Iterable, Mapping, Sequence
from threading import RLock
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.evaluation import Values
from lumped.compiler.flatten import FlatModel, flatten
from lumped.compiler.hold_modes import DEMAND, STUCK
from lumped.compiler.locked_loops import locked_loops
from lumped.compiler.pruning import independent_of, needed_states, samples, used, uses
from lumped.compiler.reduce import reduce
from lumped.compiler.report import LeftOut, Report
from lumped.compiler.state_selection import RANK
from lumped.compiler.switching import Switching
from lumped.errors import UnknownNameError
from lumped.language.component import Component
from lumped.language.expression import Expr
from lumped.language.quantity import Quantity
from lumped.support.made_once import Recent, Shared, made_once

__all__ = ["Changes", "Name", "System"]

Name = str | Expr
Changes = Mapping[str, float] | Mapping[Name, float]
_FUNCTIONS = 64
"""Functions of quantities that a system keeps."""


class System(Shared):
    """A model as ``der(x) == f(x, p, t, m)``, made by `lumped.assemble`.

    Attributes
    ----------
    model : Component
        What was assembled.
    state_names : list of str
        Names of the states, in their order in x.
    switching : Switching
        What decides modes that depend on more than the time.
    left_out : list of LeftOut
        What is not computed, and why.
    seconds : dict of str to float
        Time that each stage of assembling took.
    """

    def __init__(
        self,
        flat: FlatModel,
        outputs: Iterable[Name] | None,
        keep: Iterable[Name],
        ranks: Mapping[int, int] | None = None,
        *,
        foresee: bool = True,
    ) -> None:
        super().__init__(flat.building)
        self.model = flat.tree.model
        self._flat = flat
        self._tree = flat.tree
        self._ranks = dict(ranks or {})
        begin = clock.perf_counter()
        self._reduced = reduce(flat, ranks)
        self._locked = locked_loops(self._reduced)
        middle = clock.perf_counter()
        self._values = Values(self._reduced)
        self.switching = Switching(self._values, foresee=foresee)
        self._outputs = None if outputs is None else [self._tree.unknown(n) for n in outputs]
        self._kept = [self._tree.unknown(name) for name in keep]
        self._members = self._members_of_nodes()
        self._in_use = self._needed_states(self._kept)
        self.states = [self._reduced.states[i] for i in self._in_use]
        self._rates = self._values.of([n + 1 for n in self.states])
        self._rate_uses = used(self._rates, self._values)
        self.state_names = [self._node_name(n) for n in self.states]
        self.left_out = self._left_out()
        self._functions: Recent[ca.Function] = Recent(_FUNCTIONS)
        self._charts: dict[object, System] = {}
        end = clock.perf_counter()
        self.seconds = {"reduce": middle - begin, "prune": end - middle}

    # -- copies ------------------------------------------------------------------------------

    def __reduce__(self) -> tuple[Any, ...]:
        if "_origin" not in vars(self):
            _, outputs, kept = self.origin
            flat = self._flat.motions, self._tree.freed
            return _to_be_made, (self.model, *flat, outputs, kept, self._ranks)
        return _to_be_made, vars(self)["_origin"][1]

    if not TYPE_CHECKING:  # type checkers shall go on finding misspelt names

        def __getattr__(self, name: str) -> Any:
            """Assemble a copy when it is first used."""
            if not name.startswith("__") and "_origin" in vars(self):
                assembling, (model, motions, freed, *rest) = vars(self)["_origin"]
                with assembling:
                    if "made" not in vars(self):
                        vars(self).update(vars(System(flatten(model, motions, freed), *rest)))
                if name in vars(self):
                    return vars(self)[name]
            raise AttributeError(f"{type(self).__name__} has no '{name}'.")

    # -- structure ---------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the model's class."""
        return self._flat.name

    def _members_of_nodes(self) -> dict[int, int]:
        """Unknown that gives each node its name: a variable before a port quantity."""
        aliases, first = self._reduced.aliases, self._reduced.first
        alive = np.flatnonzero(aliases.classes >= 0)
        nodes = first[aliases.classes[alive]] + aliases.shifts[alive]
        variable = np.zeros(len(aliases.classes), dtype=bool)
        for node in self._tree.nodes:
            for i, quantity in enumerate(node.layout.quantities):
                variable[node.first_unknown + i] = quantity.kind == "variable"
        best: dict[int, int] = {}
        for unknown, node_number in zip(alive.tolist(), nodes.tolist(), strict=True):
            held = best.get(node_number)
            if held is None or (variable[unknown] and not variable[held]):
                best[node_number] = unknown
        return best

    def _node_name(self, node: int) -> str:
        if node in self._members:
            return self._tree.unknown_name(self._members[node])
        order = self._reduced.class_and_order(node)[1]
        inner = self._node_name(node - order)
        return "der(" * order + inner + ")" * order

    def _needed_states(self, kept: list[int]) -> list[int]:
        """Numbers of the states that must be integrated."""
        reduced, aliases = self._reduced, self._reduced.aliases
        place = {node: i for i, node in enumerate(reduced.states)}
        positions = set()
        for node in self._tree.nodes:
            for i, quantity in enumerate(node.layout.quantities):
                u = node.first_unknown + i
                if quantity.kind == "potential" and aliases.shifts[u] == 0:
                    number = reduced.node(u)
                    if number in place:
                        positions.add(place[number])
        outputs = None if self._outputs is None else self._raw(self._outputs)
        implicit = self._values.of(self._values.implicit)
        always = ca.vertcat(self._raw(kept), implicit, self.switching.needed())
        self._positions = positions
        return needed_states(self._values, positions, outputs, always)

    def _raw(self, numbers: list[int]) -> ca.SX:
        """Unknowns as expressions of all states, left out or not."""
        nodes = [self._reduced.node(u) for u in numbers]
        found = iter(ca.vertsplit(self._values.of([n for n in nodes if n is not None])))
        signs = self._reduced.aliases.signs
        parts = [
            ca.SX(0) if n is None else float(signs[u]) * next(found)
            for u, n in zip(numbers, nodes, strict=True)
        ]
        return ca.vertcat(ca.SX(0, 1), *parts)

    def _without(self, expression: ca.SX, lost: np.ndarray) -> ca.SX:
        """The expression with states taken out on which it does not depend."""
        if not len(lost):
            return expression
        symbols = self._values.states[lost.tolist()]
        return ca.substitute(expression, symbols, ca.SX.zeros(len(lost)))

    def available(self, nodes: list[int], *, cyclic: bool) -> np.ndarray:
        """Which nodes depend only on states in use (on cyclic ones only if allowed)."""
        if not nodes:
            return np.zeros(0, dtype=bool)
        states = np.array(self._reduced.states, dtype=int)
        usable = np.isin(states, self.states)
        if not cyclic:
            usable &= ~np.isin(states, list(self.cyclic))
        lost = self._values.states[np.flatnonzero(~usable).tolist()]
        return ~np.array(ca.which_depends(self._values.of(nodes), lost, 1, True), dtype=bool)

    def _left_out(self) -> list[LeftOut]:
        aliases = self._reduced.aliases
        equal = int((aliases.classes >= 0).sum()) - aliases.count
        zero = int((aliases.classes < 0).sum())
        found = []
        if equal:
            found.append(LeftOut(f"{equal} aliases", "equal to another quantity"))
        if zero:
            found.append(LeftOut(f"{zero} quantities", "always zero"))
        in_use = set(self.states)
        why = "cyclic coordinate: nothing depends on it"
        if self._outputs is not None:
            why = "not needed for the requested outputs"
        for node in self._reduced.states:
            if node not in in_use:
                found.append(LeftOut(self._node_name(node), why))
        return found + self._locked

    def report(self) -> Report:
        """What the reduction did: counts, states and why they are, blocks, times."""
        flat, reduced = self._flat, self._reduced
        connection = len(flat.joints.equal) + len(flat.joints.sums) + len(flat.joints.grounded)
        coupled = [block for block in reduced.blocks if len(block.nodes) > 1]
        counts = {
            "components": len(self._tree.nodes),
            "unknowns": self._tree.unknown_count,
            "equations": flat.equation_count + connection,
            "after alias elimination": reduced.incidence.count,
            "differentiated": int((reduced.times > 0).sum()),
            "index": int(reduced.times.max(initial=0)) + 1,
            "coupled blocks": len(coupled),
            "largest block": max((len(b.nodes) for b in reduced.blocks), default=0),
            "states": len(self.states),
        }
        return Report(
            counts,
            {name: self._reason(n) for name, n in zip(self.state_names, self.states, strict=True)},
            tuple(_shortened([self._node_name(n) for n in block.nodes]) for block in coupled),
            tuple(self._node_name(n) for n in self._values.implicit),
            tuple(self.left_out),
            tuple(name for _, name in flat.joints.grounded),
            dict(self.seconds),
        )

    def _reason(self, node: int) -> str:
        """Why a node is a state."""
        if node not in self._reduced.tied:
            return "its derivative stands in the equations"
        unknown = self._members.get(node)
        wish = "avoid" if unknown is None else self._tree.quantity(unknown).wish
        if wish in ("prefer", "always"):
            return f"declared state='{wish}'; constraints determine others"
        return "leads what constraints tie to it; declared before them or wanted more"

    def __repr__(self) -> str:
        counts = self.report()
        lines = [
            f"{self.name}: {counts['equations']} equations -> {counts['states']} states"
            f" (index {counts['index']} -> 1, {counts['after alias elimination']} equations after "
            f"alias elimination)",
            "states:   " + _shortened(self.state_names),
            "left out: " + (_shortened([repr(x) for x in self.left_out], "; ") or "nothing"),
        ]
        return "\n".join(lines)

    # -- symbols and functions -----------------------------------------------------------------

    @property
    @made_once
    def _inputs(self) -> list[ca.SX]:
        v = self._values
        x = v.states[self._in_use] if self._in_use else ca.SX(0, 1)
        return [x, self._flat.parameters.theta, v.time, ca.vertcat(v.modes, v.guesses)]

    @property
    @made_once
    def rates(self) -> ca.SX:
        """Derivatives of the states as an expression; common parts are shared."""
        rates = ca.SX(self._rates)
        place = {node: i for i, node in enumerate(self.states)}
        holds = self.switching
        for h, node in enumerate(holds.speeds):
            if node in place:
                # a speed that is held stays exactly what it is
                first = int(holds.first_modes[h])
                stuck, demand = (self._values.modes[first + i] for i in (STUCK, DEMAND))
                i = place[node]
                rates[i] = ca.if_else(stuck, holds.speed_signs[h] * demand, rates[i])
        lost = np.setdiff1d(self._rate_uses, self._in_use)
        return ca.cse(self._without(rates, lost))

    def _in_states(self, expression: ca.SX) -> ca.SX:
        """An expression of the states in use."""
        lost = np.setdiff1d(used(expression, self._values), self._in_use)
        return ca.cse(self._without(expression, lost))

    @property
    @made_once
    def margins(self) -> ca.Function:
        """Distances to the next change of modes, and their tolerances: (x, p, t, m)."""
        found, tolerances = self.switching.margins
        k = found.numel()
        both = self._in_states(ca.vertcat(found, tolerances))
        return ca.Function("margins", self._inputs, ca.vertsplit(both, [0, k, 2 * k]))

    @property
    @made_once
    def margin_rates(self) -> ca.Function:
        """Time derivatives of the margins: (x, p, t, m)."""
        found = self._in_states(self.switching.margins[0])
        x, _, t, _ = self._inputs
        along = ca.jtimes(found, ca.vertcat(x, t), ca.vertcat(self.rates, 1))
        return ca.Function("margin_rates", self._inputs, [ca.densify(ca.cse(along))])

    @property
    @made_once
    def look(self) -> ca.Function:
        """All that decides modes, then the derivatives of the states: (x, p, t, m) -> (k,)."""
        parts = self._in_states(self.switching.needed())
        return ca.Function("look", self._inputs, [ca.densify(ca.vertcat(parts, self.rates))])

    @property
    @made_once
    def speed_uses(self) -> tuple[np.ndarray, np.ndarray]:
        """Which states the speed of each hold depends on: numbers of the holds and states."""
        s = self.switching
        first = 2 * len(s.relation_modes)
        speeds = s.needed()[first : first + len(s.speeds)]
        rows, columns = ca.jacobian_sparsity(self._in_states(speeds), self._inputs[0]).get_triplet()
        return np.array(rows, dtype=int), np.array(columns, dtype=int)

    @property
    @made_once
    def rhs(self) -> ca.Function:
        """Right-hand side: (x, p, t, m) -> der(x); m is modes, then guesses of implicit nodes."""
        return ca.Function("rhs", self._inputs, [self.rates])

    @property
    @made_once
    def jacobian(self) -> ca.Function:
        """Sparse Jacobian and time derivative of the right-hand side: (x, p, t, m)."""
        x, _, t, _ = self._inputs
        return ca.Function(
            "jacobian",
            self._inputs,
            [ca.jacobian(self.rates, x), ca.densify(ca.jacobian(self.rates, t))],
        )

    @property
    @made_once
    def closure(self) -> ca.Function:
        """Implicit quantities and the last Newton step of each: (x, p, t, m)."""
        v = self._values
        return ca.Function("closure", self._inputs, [v.of(v.implicit), v.corrections()])

    def expressions(self, names: Iterable[Name]) -> ca.SX:
        """Quantities as CasADi expressions of states, parameters, time and modes.

        Raises
        ------
        UnknownNameError
            If a name is unknown, or needs a state that was left out.
        """
        numbers = [self._tree.unknown(name) for name in names]
        expression = self._raw(numbers)
        found = uses(expression, self._values).tocoo()
        lost = np.setdiff1d(found.col, self._in_use)
        if len(lost) and not independent_of(expression, lost.tolist(), self._values).all():
            needed = [self._node_name(self._reduced.states[i]) for i in lost]
            name = self._tree.unknown_name(numbers[found.row[np.isin(found.col, lost)][0]])
            raise UnknownNameError(
                f"'{name}' was left out of the system: it needs {_shortened(needed)}. "
                f"Ask for it: assemble(model, keep=[{name!r}])."
            )
        return self._without(expression, lost)

    def function(self, names: Iterable[Name]) -> ca.Function:
        """Function of named quantities: (x, p, t, m) -> (n,)."""
        keys = tuple(self.key(name) for name in names)
        return self._functions.of(
            keys, lambda: ca.Function("outputs", self._inputs, [self.expressions(keys)])
        )

    @property
    @made_once
    def cyclic(self) -> frozenset[int]:
        """Nodes of states in use that are not speeds and on which no derivative depends."""
        values, reduced = self._values, self._reduced
        first = [
            i
            for i, n in zip(self._in_use, self.states, strict=True)
            if reduced.class_and_order(n)[1] == 0
        ]
        stated = set(self._rate_uses.tolist())
        doubtful = [i for i in first if i in stated and i in self._positions]
        idle = set(first) - stated
        if doubtful:
            cancels = independent_of(self._rates, doubtful, values)
            idle |= {i for i, c in zip(doubtful, cancels, strict=True) if c}
        return frozenset(reduced.states[i] for i in idle)

    def state_matrix(self, point_inputs: Sequence[np.ndarray | float]) -> scipy.sparse.csc_array:
        """Jacobian of the right-hand side by the states; what cancels is exactly zero."""
        matrix = scipy.sparse.csc_array(self.jacobian(*point_inputs)[0].sparse())
        matrix.data[self._cancelling] = 0.0
        return matrix

    @property
    @made_once
    def _cancelling(self) -> np.ndarray:
        """Nonzeros of the Jacobian that are nothing but rounding.

        Only rates of positions by speeds are looked at, which are ratios of lengths and angles:
        elsewhere a small number may be a soft spring beside a stiff one.
        """
        rows, columns, largest = samples(self._rates, self._values)
        order = np.array([self._reduced.class_and_order(n)[1] for n in self.states], dtype=int)
        rounding = (largest <= 1e-13) & (order[rows] == 0)
        width = len(self._reduced.states)
        own_rows, own = self.jacobian.sparsity_out(0).get_triplet()
        places = np.array(own_rows, dtype=int) * width + np.array(self._in_use, dtype=int)[own]
        found: np.ndarray = np.isin(places, (rows * width + columns)[rounding])
        return found

    def without_foresight(self) -> System:
        """The same system for a run that does not know all instants of functions of time before.

        Functions that are not linear in the time are watched as it goes, like those of states.
        """
        _, outputs, kept = self.origin
        return System(self._flat, outputs, kept, self._ranks, foresee=False)

    def led_by(self, follower: int, leader: int) -> System:
        """The same system with the motion of one node as state instead of that of another.

        Positions and speeds change places together.
        """
        ranks = dict(self._ranks)
        for node, rank in ((follower, RANK["always"]), (leader, RANK["never"])):
            number, _ = self._reduced.class_and_order(node)
            first, highest = int(self._reduced.first[number]), int(self._reduced.highest[number])
            ranks.update(dict.fromkeys(range(first, first + highest), rank))
        own, key = (tuple(sorted(r.items())) for r in (self._ranks, ranks))
        with self.building:
            self._charts[own] = self
            if key not in self._charts:
                _, outputs, kept = self.origin
                self._charts[key] = chart = System(self._flat, outputs, kept, ranks)
                chart._charts = self._charts
            return self._charts[key]

    def is_chart_of(self, other: System) -> bool:
        """Whether this is the other system, or the same with other motions as states."""
        return self is other or (
            self._flat is other._flat
            and (self._outputs, self._kept) == (other._outputs, other._kept)
        )

    # -- names and values ----------------------------------------------------------------------

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters that can be changed, and their values in the model."""
        p = self._flat.parameters
        return {p.names[i]: float(v) for i, v in zip(p.free, p.defaults, strict=True)}

    def names(self) -> list[str]:
        """Names of all quantities."""
        return list(self._tree.unknown_names())

    @property
    def origin(self) -> tuple[Component, list[str] | None, list[str]]:
        """Model, outputs and kept quantities from which the system was assembled."""
        name = self._tree.unknown_name
        outputs = None if self._outputs is None else [name(u) for u in self._outputs]
        return self._tree.nodes[0].component, outputs, [name(u) for u in self._kept]

    def key(self, name: Name) -> str:
        """Dotted name of what is meant by a name or a reference."""
        return self._tree.key(name)

    def quantity(self, name: Name) -> Quantity:
        """Declaration of a quantity: unit and text."""
        return self._tree.quantity(self._tree.unknown(name))

    def theta(self, changes: Changes | None) -> np.ndarray:
        """Parameter vector with changes applied and checked.

        Raises
        ------
        UnknownNameError
            If a parameter does not exist or is bound to others.
        ParameterError
            If a value is out of range.
        """
        if not changes:
            return self._flat.parameters.defaults.copy()
        values = dict(zip(self.places(changes), changes.values(), strict=True))
        return self._flat.parameters.changed(values, self.name)

    def parameter_values(self, changes: Changes | None = None) -> dict[str, float]:
        """All parameters, those that follow from others too, with some changed.

        Parameters
        ----------
        changes : mapping of name to float, optional
            Parameters to change.

        Raises
        ------
        UnknownNameError
            If a parameter does not exist or is bound to others.
        ParameterError
            If a value is out of range.
        """
        p = self._flat.parameters
        return dict(zip(p.names, map(float, p.all(self.theta(changes))), strict=True))

    def places(self, names: Iterable[Name]) -> list[int]:
        """Places of parameters in the parameter vector."""
        return self._flat.parameters.places([self._tree.parameter(name) for name in names])

    def check_parameters(self, theta: np.ndarray) -> None:
        """Refuse parameters out of range."""
        self._flat.parameters.check(theta, self.name)


def _to_be_made(*origin: Any) -> System:
    """A copy of a system, by what it was made from; it is assembled when it is first used."""
    system = object.__new__(System)
    vars(system)["_origin"] = RLock(), origin
    return system


def _shortened(items: list[str], separator: str = ", ", most: int = 12) -> str:
    more = f"{separator}... {len(items) - most} more" if len(items) > most else ""
    return separator.join(items[:most]) + more
