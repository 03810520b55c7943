"""States at the start where start values determine them linearly: one function of parameters.

Most drives start so. Everything else, and every fault, is left to the search (`start_search`).
"""

from __future__ import annotations

from collections.abc import Collection, Container, Mapping
from functools import cached_property

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.constraints import declared_followers
from lumped.compiler.system import System
from lumped.kernel.instants.holds import STANDSTILL
from lumped.language.quantity import within
from lumped.points.start_search import ROUNDING
from lumped.points.target_values import target_values
from lumped.points.targets import TOLERANCE, find_determined
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once

_MOST = 60
"""Start values of what is no state, up to which their equations are solved in one function."""
_FEW = 3
"""The same where these equations depend on parameters."""


class DirectStart:
    """States at the start as a function of parameters, time and start values that are set.

    Attributes
    ----------
    function : Function
        (p, t, start values) -> states in use, all start values, how far the worst that is no
        state is missed, relative to its value if that is above one.
    varies : bool
        Whether they depend on anything; otherwise they are computed once.
    searches : bool
        Whether there are start values or equations of what is no state.
    """

    def __init__(self, function: ca.Function, *, varies: bool, searches: bool) -> None:
        self.function, self.varies, self.searches = function, varies, searches
        self._call = ArrayFunction(function)

    def states(
        self, theta: np.ndarray, time: float, values: list[float]
    ) -> tuple[np.ndarray, float] | None:
        """States in use, and how far the worst is missed; None if a search must tell more."""
        if self.varies:
            return self._states(theta, time, values)
        found = self._constant
        return None if found is None else (found[0].copy(), found[1])

    @cached_property
    def _constant(self) -> tuple[np.ndarray, float] | None:
        return self._states(np.zeros(self.function.numel_in(0)), 0.0, [])

    def _states(
        self, theta: np.ndarray, time: float, values: list[float]
    ) -> tuple[np.ndarray, float] | None:
        x, given, missed = self._call(theta, time, values)
        is_met = np.isfinite(x).all() and missed[0] <= TOLERANCE and within(given)
        return (x, float(missed[0])) if is_met else None


class StartSlopes:
    """Derivatives of the states at the start by parameters and by start values.

    Attributes
    ----------
    function : Function
        (p, t, start values) -> derivatives of the states in use by parameters, then by the start
        values that vary.
    """

    def __init__(self, function: ca.Function) -> None:
        self._call, self._shape = ArrayFunction(function), function.size_out(0)
        self._pattern = [np.array(v) for v in function.sparsity_out(0).get_triplet()]

    def along(
        self, theta: np.ndarray, time: float, values: list[float], directions: np.ndarray
    ) -> np.ndarray:
        """Derivatives along directions of parameters and start values, which are columns."""
        if not len(self._pattern[0]):
            return np.zeros((self._shape[0], directions.shape[1]))
        matrix = scipy.sparse.coo_array(
            (self._call(theta, time, values)[0], self._pattern), self._shape
        )
        found: np.ndarray = matrix @ directions
        return found


@made_once
def direct_start(system: System, changed: tuple[int, ...]) -> DirectStart | None:
    """How states follow from start values and from those unknowns that are set; None if not so."""
    structure, values = system.structure, ca.SX.sym("start", len(changed))
    found = _find_direct_states(system, {u: values[i] for i, u in enumerate(changed)}, {})
    if found is None:
        return None
    x, given, missed, fixed = found
    place = {node: i for i, node in enumerate(structure.reduced.states)}
    for node in structure.switching.speeds:
        if node in place and place[node] not in fixed:
            i = place[node]
            least = ROUNDING * STANDSTILL * (1 + ca.fabs(x[i]))
            x[i] = ca.if_else(ca.fabs(x[i]) <= least, 0, x[i])
    inputs = [structure.parameters.theta, structure.values.time, values]
    results = [_select_used(system, x), given, missed]
    function = ca.Function("start", inputs, [ca.densify(result) for result in results])
    varies = ca.depends_on(ca.vertcat(*results), ca.vertcat(*inputs))
    targets = given.numel() > len(fixed)
    searches = bool(targets or structure.flat.initial)
    return DirectStart(function, varies=varies, searches=searches)


@made_once
def direct_slopes(
    system: System, changed: tuple[int, ...], varied: tuple[int, ...]
) -> StartSlopes | None:
    """Derivatives of `direct_start`, also by the start values of unknowns that vary."""
    structure, values = system.structure, ca.SX.sym("start", len(changed))
    more, theta = ca.SX.sym("more", len(varied)), structure.parameters.theta
    every = {u: values[i] for i, u in enumerate(changed)}
    found = _find_direct_states(system, every, {u: more[i] for i, u in enumerate(varied)})
    if found is None:
        return None
    slopes = ca.jacobian(_select_used(system, found[0]), ca.vertcat(theta, more))
    slopes = ca.substitute(slopes, more, ca.SX.zeros(len(varied)))
    inputs = [theta, structure.values.time, values]
    return StartSlopes(ca.Function("start_slopes", inputs, [slopes]))


def _select_used(system: System, x: ca.SX) -> ca.SX:
    """Those of all states that are in use."""
    return x[system.structure.in_use] if system.structure.in_use else ca.SX(0, 1)


def _find_direct_states(
    system: System, changed: Mapping[int, ca.SX], more: Mapping[int, ca.SX]
) -> tuple[ca.SX, ca.SX, ca.SX, Collection[int]] | None:
    """States, start values, how far the worst is missed, and which states are given.

    `changed` are start values that are set; `more` is added to those of any unknowns.
    """
    structure = system.structure
    flat, reduced = structure.flat, structure.reduced
    if structure.implicit or declared_followers(system):
        return None
    place = {node: i for i, node in enumerate(reduced.states)}
    signs = reduced.aliases.signs
    every = {u: value + more.get(u, 0) for u, value in {**flat.given, **changed}.items()}
    given, unknowns = ca.vertcat(ca.SX(0, 1), *every.values()), list(every)
    nodes = [reduced.node(u) for u in unknowns]
    if None in nodes or len(set(nodes)) < len(nodes):
        return None
    source, sign = np.zeros(len(place), dtype=int), np.ones(len(place))
    for k, unknown in enumerate(flat.starts, start=1):
        start = reduced.node(unknown)
        if start is not None and start in place:
            source[place[start]], sign[place[start]] = k, signs[unknown]
    x = ca.vertcat(ca.SX(0), *flat.starts.values())[source.tolist(), 0] * ca.DM(sign)
    for unknown, change in more.items():
        node = reduced.node(unknown)
        if unknown not in every and node in place:
            x[place[node]] += float(signs[unknown]) * change
    wanted = given * ca.DM(signs[np.array(unknowns, dtype=int)].astype(float))
    own = {place[node]: k for k, node in enumerate(nodes) if node in place}
    if own:
        x[list(own)] = wanted[list(own.values())]
    targets = {
        node: wanted[k] for k, node in enumerate(nodes) if node is not None and node not in place
    }
    fixed = own.keys()
    missed = ca.SX(0)
    if targets or flat.initial:
        found = _meet_targets(system, x, targets, fixed)
        if found is None:
            return None
        x, missed = found
    return x, given, missed, fixed


def _meet_targets(
    system: System, x: ca.SX, targets: Mapping[int, ca.SX], fixed: Container[int]
) -> tuple[ca.SX, ca.SX] | None:
    """States that meet targets, and how far the worst is missed; None if that takes a search."""
    known = target_values(system, tuple(targets), ())
    states = system.structure.values.states
    theta, slopes = system.structure.parameters.theta, ca.jacobian(known.expression, states)
    moving = ca.vertcat(states, system.structure.values.time)
    if known.has_positions or ca.depends_on(slopes, moving):
        return None
    at = ca.Function("slopes", [theta], [slopes])
    matrix = at(system.structure.parameters.defaults).full()
    columns, rows = find_determined(system, matrix, fixed)
    if not 0 < len(rows) <= (_MOST if slopes.is_constant() else _FEW):
        return None
    wanted = ca.vertcat(ca.SX(0, 1), *targets.values(), ca.SX.zeros(len(known.places)))
    miss = ca.substitute(known.expression, states, x) - wanted
    x, own = ca.SX(x), miss[rows.tolist()]
    if slopes.is_constant():
        x[columns] -= ca.mtimes(ca.DM(np.linalg.inv(matrix[rows][:, columns])), own)
    else:
        x[columns] -= ca.solve(ca.densify(slopes[rows.tolist(), columns]), own)
    left = ca.substitute(known.expression, states, x) - wanted
    return x, ca.mmax(ca.fabs(left) / ca.fmax(1, ca.fabs(wanted)))
