"""A reduced model with its CasADi functions, built when first asked for."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.graph import connection_graph
from lumped.compiler.report import Report, report_on, shorten
from lumped.compiler.structure import Name, Recipe, Structure
from lumped.errors import UnknownNameError
from lumped.flattening.hold_modes import DEMAND, STUCK
from lumped.flattening.measures import watching
from lumped.flattening.tree import key_of
from lumped.language.component import Component
from lumped.language.formula import Formula, unit_of
from lumped.language.quantity import Quantity
from lumped.reduction.pruning import independent_of, samples, uses
from lumped.support.made_once import Recent, Shared, made_once
from lumped.support.process_lock import process_lock
from lumped.support.rich_html import RichHtml

if TYPE_CHECKING:
    import networkx as nx

Changes = Mapping[str, float] | Mapping[Name, float]
_FUNCTIONS = 64
"""Functions of quantities that a system keeps."""
_WATCHING = 8
"""Systems that watch the kinks of formulas, which a system keeps."""


class System(Shared, RichHtml):
    """A model as ``der(x) == f(x, p, t, m)``, made by `lumped.assemble`.

    Attributes
    ----------
    model : Component
        What was assembled.
    structure : Structure
        What the reduction found: nodes, states in use, numbers of unknowns, parameters.
    inputs : list of SX
        Symbols x, p, t and m of all functions; m is modes, then guesses of implicit nodes.
    state_names : list of str
        Names of the states, in their order in x.
    switching : Switching
        What decides modes that depend on more than the time.
    left_out : list of LeftOut
        What is not computed, and why.
    seconds : dict of str to float
        Time that each stage of assembling took.
    bound : System
        The same led by states, of redundant coordinates; itself otherwise.
    by_ranks : dict
        The same led by other states (see `lumped.compiler.leads`).
    """

    def __init__(self, structure: Structure) -> None:
        super().__init__()
        self.structure, self.model = structure, structure.tree.model
        self.switching = self.structure.switching
        self.inputs = self.structure.inputs
        self.state_names = [self.structure.node_name(n) for n in self.structure.states]
        self.left_out = self.structure.left_out
        self.seconds = dict(self.structure.seconds)
        self._functions: Recent[ca.Function] = Recent(_FUNCTIONS)
        self.by_ranks: dict[object, System] = {}
        self._watching: Recent[System] = Recent(_WATCHING)
        self.bound = self

    # -- copies ------------------------------------------------------------------------------

    def __reduce__(self) -> tuple[Any, ...]:
        return _to_be_made, (vars(self).get("_recipe") or self.structure.recipe,)

    if not TYPE_CHECKING:  # type checkers shall go on finding misspelt names

        def __getattr__(self, name: str) -> Any:
            """Assemble a copy when it is first used."""
            if not name.startswith("__") and "_recipe" in vars(self):
                with process_lock:
                    if "made" not in vars(self):
                        vars(self).update(vars(System(vars(self)["_recipe"].make())))
                if name in vars(self):
                    return vars(self)[name]
            raise AttributeError(f"{type(self).__name__} has no '{name}'.")

    # -- structure ---------------------------------------------------------------------------

    @property
    def name(self) -> str:
        """Name of the model's class."""
        return self.structure.flat.name

    def __repr__(self) -> str:
        counts = self.report()
        return (
            f"{self.name}: {counts['equations']} equations -> {counts['states']} states "
            f"(index {counts['index']} -> 1, {counts['after alias elimination']} equations after "
            f"alias elimination)\nstates:   {shorten(self.state_names)}\nleft out: "
            + (shorten([repr(x) for x in self.left_out], "; ") or "nothing")
        )

    def report(self) -> Report:
        """What the reduction did: counts, states and why they are, blocks, times."""
        return report_on(self.structure, self.state_names, self.seconds)

    def graph(self, *, depth: int | None = None, reduced: bool = False) -> nx.Graph:
        """Parts and joints of the model as a graph of networkx, made anew each time.

        An edge has the ``ports`` of a part in a joint, each with its role: "line", "support", "in"
        or "out". A part has ``kind``, ``parameters``, ``quantities``, ``states``, and ``left_out``,
        states that are not computed, with the reasons; it is named by its path. A joint is what is
        connected, or a port left open, and has ``kind``, ``quantities``, ``ports``, ``states``,
        ``equal``, the quantity that its potential is up to the sign, or None, and ``still``: its
        potential is zero, or a position that never changes, so that no power passes.

        Parameters
        ----------
        depth : int, optional
            Composites at this depth are parts; default is to see through all of them.
        reduced : bool
            Ports whose potential is the same up to its sign are in one joint, and what is still.

        Returns
        -------
        networkx.Graph
        """
        return connection_graph(self.structure, depth, reduced=reduced)

    # -- symbols and functions -----------------------------------------------------------------

    @property
    @made_once
    def rates(self) -> ca.SX:
        """Derivatives of the states as an expression; common parts are shared."""
        structure, holds = self.structure, self.switching
        rates = ca.SX(structure.all_rates)
        modes, place = structure.values.modes, {n: i for i, n in enumerate(structure.states)}
        for h, node in enumerate(holds.speeds):
            if node in place:
                # a speed that is held stays exactly what it is
                first, i = int(holds.first_modes[h]), place[node]
                demand = holds.speed_signs[h] * modes[first + DEMAND]
                rates[i] = ca.if_else(modes[first + STUCK], demand, rates[i])
        return ca.cse(structure.without(rates, np.setdiff1d(structure.rate_uses, structure.in_use)))

    @property
    @made_once
    def margins(self) -> ca.Function:
        """Distances to the next change of modes, and their tolerances: (x, p, t, m)."""
        found, tolerances = self.switching.margins
        k = found.numel()
        both = self.structure.in_states(ca.vertcat(found, tolerances))
        return ca.Function("margins", self.inputs, ca.vertsplit(both, [0, k, 2 * k]))

    @property
    @made_once
    def margin_rates(self) -> ca.Function:
        """Time derivatives of the margins: (x, p, t, m)."""
        found = self.structure.in_states(self.switching.margins[0])
        x, _, t, _ = self.inputs
        along = ca.jtimes(found, ca.vertcat(x, t), ca.vertcat(self.rates, 1))
        return ca.Function("margin_rates", self.inputs, [ca.densify(ca.cse(along))])

    @property
    @made_once
    def look(self) -> ca.Function:
        """All that decides modes, then the derivatives of the states: (x, p, t, m) -> (k,)."""
        parts = self.structure.in_states(self.switching.collect_needed())
        return ca.Function("look", self.inputs, [ca.densify(ca.vertcat(parts, self.rates))])

    @property
    @made_once
    def speed_uses(self) -> tuple[np.ndarray, np.ndarray]:
        """Which states the speed of each hold depends on: numbers of the holds and states."""
        speeds = self.structure.in_states(self.switching.speed)
        rows, columns = ca.jacobian_sparsity(speeds, self.inputs[0]).get_triplet()
        return np.array(rows, dtype=int), np.array(columns, dtype=int)

    @property
    @made_once
    def rhs(self) -> ca.Function:
        """Right-hand side: (x, p, t, m) -> der(x); m is modes, then guesses of implicit nodes."""
        return ca.Function("rhs", self.inputs, [self.rates])

    @property
    @made_once
    def jacobian(self) -> ca.Function:
        """Sparse Jacobian and time derivative of the right-hand side: (x, p, t, m)."""
        x, _, t, _ = self.inputs
        slopes = [ca.jacobian(self.rates, x), ca.densify(ca.jacobian(self.rates, t))]
        return ca.Function("jacobian", self.inputs, slopes)

    @property
    @made_once
    def closure(self) -> ca.Function:
        """Implicit quantities and the last Newton step of each: (x, p, t, m)."""
        v = self.structure.values
        return ca.Function("closure", self.inputs, [v.of(v.implicit), v.corrections()])

    def expressions(self, names: Iterable[Name]) -> ca.SX:
        """Quantities and formulas as CasADi expressions of states, parameters, time and modes.

        Raises
        ------
        UnknownNameError
            If a name is unknown, or needs a state that was left out.
        EquationError, UnitError
            If a formula has no meaning (see `measure`).
        """
        structure, keys = self.structure, [self.structure.tree.computable(name) for name in names]
        plain = [k for k in keys if not isinstance(k, Formula)]
        quantities = iter(ca.vertsplit(structure.raw([structure.tree.unknown(k) for k in plain])))
        parts = [structure.formula(k) if isinstance(k, Formula) else next(quantities) for k in keys]
        expression = ca.vertcat(ca.SX(0, 1), *parts)
        rows, columns = uses(expression, structure.values)
        lost = np.setdiff1d(columns, structure.in_use)
        if len(lost) and not independent_of(expression, lost.tolist(), structure.values).all():
            needed = [structure.node_name(structure.reduced.states[i]) for i in lost]
            name = keys[rows[np.isin(columns, lost)][0]]
            wanted = needed if isinstance(name, Formula) else [name]
            raise UnknownNameError(
                f"'{name}' was left out of the system: it needs {shorten(needed)}. "
                f"Ask for it: assemble(model, keep={wanted})."
            )
        return structure.without(expression, lost)

    def product(self, factors: Iterable[Name]) -> ca.SX:
        """Product of quantities as a CasADi expression (see `expressions`)."""
        return ca.SX(math.prod(ca.vertsplit(self.expressions(factors))))

    def function(self, names: Iterable[Name]) -> ca.Function:
        """Function of named quantities: (x, p, t, m) -> (n,)."""
        keys = tuple(self.key(name) for name in names)
        return self._functions.of(
            keys, lambda: ca.Function("outputs", self.inputs, [self.expressions(keys)])
        )

    def watching(self, names: Iterable[str]) -> System:
        """The same system with runs that stop at the kinks of formulas; itself if there are none.

        Raises
        ------
        UnknownNameError, EquationError, UnitError
            As `expressions`.
        """
        formulas = tuple(dict.fromkeys(name for name in names if isinstance(name, Formula)))
        if not formulas:
            return self
        with process_lock:
            flat = watching(self.structure.flat, formulas)
            if flat is self.structure.flat:
                return self
            self.expressions(formulas)  # refuses what was left out
            return self._watching.of(
                tuple(flat.watched), lambda: System(self.structure.with_changes(flat))
            )

    def state_matrix(self, point_inputs: Sequence[np.ndarray | float]) -> scipy.sparse.csc_array:
        """Jacobian of the right-hand side by the states; what cancels is exactly zero."""
        matrix = scipy.sparse.csc_array(self.jacobian(*point_inputs)[0].sparse())
        matrix.data[self.cancelling] = 0.0
        return matrix

    @property
    @made_once
    def cancelling(self) -> np.ndarray:
        """Nonzeros of the Jacobian that are nothing but rounding.

        Only rates of positions by speeds are looked at, which are ratios of lengths and angles:
        elsewhere a small number may be a soft spring beside a stiff one.
        """
        structure = self.structure
        rows, columns, largest = samples(structure.all_rates, structure.values)
        orders = [structure.reduced.class_and_order(n)[1] for n in structure.states]
        rounding = (largest <= 1e-13) & (np.array(orders, dtype=int)[rows] == 0)
        width = len(structure.reduced.states)
        own_rows, own = self.jacobian.sparsity_out(0).get_triplet()
        places = np.array(own_rows, dtype=int) * width + np.array(structure.in_use, dtype=int)[own]
        return np.isin(places, (rows * width + columns)[rounding])

    def without_foresight(self) -> System:
        """The same system for a run that does not know all instants of functions of time before.

        Functions that are not linear in the time are watched as it goes, like those of states.
        """
        return System(self.structure.with_changes(foresee=False))

    @property
    @made_once
    def whole(self) -> System:
        """The same system with the states that were left out; itself if none."""
        lost = self.structure.lost_states
        return System(self.structure.with_changes(keep=lost)) if lost else self

    def has_equations_of(self, other: System) -> bool:
        """Whether this is the other system, or the same led by other states or with more kinks."""
        own, its = self.structure, other.structure
        asked = (own.outputs, own.kept) == (its.outputs, its.kept)
        return self is other or (own.flat.tree is its.flat.tree and asked)

    # -- names and values ----------------------------------------------------------------------

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters that can be changed, and their values in the model."""
        p = self.structure.parameters
        return dict(zip(p.free_names, p.defaults.tolist(), strict=True))

    def names(self) -> list[str]:
        """Names of all quantities."""
        return list(self.structure.tree.unknown_names())

    @property
    def origin(self) -> tuple[Component, list[str] | None, list[str]]:
        """Model, outputs and kept quantities from which the system was assembled."""
        recipe = self.structure.recipe
        return self.structure.tree.instances[0].component, recipe.outputs, recipe.kept

    def key(self, name: Name) -> str:
        """Dotted name of what is meant by a name or a reference; the formula of an expression."""
        return key_of(name)

    def quantity(self, name: Name) -> Quantity:
        """Declaration of a quantity: unit and text."""
        tree = self.structure.tree
        key = tree.computable(name)
        if isinstance(key, Formula):
            return Quantity(unit_of(key.expression(tree.reference)), str(key))
        return tree.quantity(tree.unknown(key))

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
            return self.structure.parameters.defaults.copy()
        values = dict(zip(self.places(changes), changes.values(), strict=True))
        return self.structure.parameters.change_values(values, self.name)

    def parameter_values(self, changes: Changes | None = None) -> dict[str, float]:
        """All parameters, those that follow from others too, with some changed.

        Raises
        ------
        UnknownNameError, ParameterError
            As `theta`.
        """
        p = self.structure.parameters
        return dict(zip(p.names, map(float, p.all(self.theta(changes))), strict=True))

    def places(self, names: Iterable[Name]) -> list[int]:
        """Places of parameters in the parameter vector."""
        parameter = self.structure.tree.parameter
        return self.structure.parameters.places([parameter(name) for name in names])

    def parameter_unit(self, name: Name) -> str:
        """Unit of a parameter."""
        parameters = self.structure.parameters
        return parameters.declared[parameters.free[self.places([name])[0]]].unit

    def check_parameters(self, theta: np.ndarray) -> None:
        """Refuse parameters out of range."""
        self.structure.parameters.check(theta, self.name)


def _to_be_made(recipe: Recipe) -> System:
    """A copy of a system, which is assembled when it is first used."""
    system = object.__new__(System)
    vars(system)["_recipe"] = recipe
    return system
