"""State matrices of a linear drive and its equations of motion, as formulas."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.energies import sum_stored
from lumped.compiler.structure import Name
from lumped.compiler.system import Changes, System
from lumped.errors import OptionError
from lumped.vibration.formulas.determinant import is_forest
from lumped.vibration.formulas.to_sympy import convert, exact, load_sympy, shortest
from lumped.vibration.rotating.masses import mechanical_states

_BRANCHED = 4
"""Twists up to which frequencies have closed formulas, for which rigid motions are left out."""


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """``q'' + H q' + G q = 0`` of a part of a drive: ``t' = B v``, ``v' = F t + V v``.

    q are the twists t, if ``V = X B``, else (X is None) the angles of the speeds v.
    """

    H: Any
    G: Any
    t: list[int]
    v: list[int]
    B: Any
    F: Any
    X: Any

    @property
    def is_forest(self) -> bool:
        """Whether its couplings close no circle."""
        n = self.G.rows
        both = {(i, j): 1 for i, j in np.ndindex(n, n) if self.G[i, j] != 0 or self.H[i, j] != 0}
        return is_forest(both, n)

    def act(self, b: Any) -> Any:
        """What an input adds to the right, by its column of the states."""
        return b.extract(self.v, [0]) if self.X is None else self.B * b.extract(self.v, [0])

    def read(self, b: Any, c: Any, s: Any) -> tuple[Any, Any]:
        """An output by q and by the input itself, by its row of the states."""
        by_t, by_v = c.extract([0], self.t), c.extract([0], self.v)
        if self.X is None:
            return s * by_v + by_t * self.B, 0
        relative = _by_twists(self.B, by_v)
        if relative is not None:
            return by_t + s * relative, 0
        whole = by_t + by_v * (self.F / s + self.X)
        return whole, (by_v * b.extract(self.v, [0]))[0, 0] / s


@dataclass(frozen=True, eq=False)
class Matrices:
    """A linear drive: ``der(x) = A x + B u``, ``y = C x + D u``, all of SymPy.

    Attributes
    ----------
    system : System
        What they belong to.
    states : list of str
        Those that are not cyclic.
    A : sympy matrix
        State matrix.
    given : dict
        Numbers that take the place of symbols.
    numbers : mapping of str to float
        Values of all parameters.
    kept : list of int
        Places of `states` among those of the system.
    """

    system: System
    states: list[str]
    A: Any
    given: dict[Any, Any]
    numbers: Mapping[str, float]
    kept: list[int]

    def of(self, found: ca.SX) -> Any:
        """Expressions that depend on parameters alone."""
        return convert_named(self.system, found).subs(self.given)

    def inputs_outputs(self, inputs: Iterable[Name], outputs: Iterable[Name]) -> tuple[Any, ...]:
        """B, C and D."""
        system = self.system
        x, theta, _, _ = system.inputs
        u = theta[system.places([system.key(name) for name in inputs])]
        y = system.expressions(outputs)
        found = [ca.jacobian(system.rates, u), ca.jacobian(y, x), ca.jacobian(y, u)]
        refuse_not_linear(system, ca.vertcat(*(ca.vec(m) for m in found)))
        B, C, D = map(self.of, found)
        return B.extract(self.kept, list(range(B.cols))), C.extract([0], self.kept), D

    @cached_property
    def parts(self) -> list[list[int]]:
        """States that depend on each other, those of each part of the drive."""
        links = [(i, j) for i, j in np.ndindex(*self.A.shape) if self.A[i, j] != 0]
        n = len(self.states)
        pattern = scipy.sparse.coo_array(
            (np.ones(len(links)), np.array(links, dtype=int).reshape(-1, 2).T), (n, n)
        )
        count, label = scipy.sparse.csgraph.connected_components(pattern, directed=False)
        return [np.flatnonzero(label == part).tolist() for part in range(count)]

    @cached_property
    def speeds(self) -> list[int]:
        """Places of speeds among `states`."""
        every = set(mechanical_states(self.system)[1].tolist())
        return [i for i, place in enumerate(self.kept) if place in every]

    @cached_property
    def twists(self) -> list[int]:
        """Places of angles and twists among `states`."""
        every = set(mechanical_states(self.system)[0].tolist())
        return [i for i, place in enumerate(self.kept) if place in every]

    def second_order(self, own: list[int]) -> SecondOrder | None:
        """Equations of second order of a part of the drive, by the smaller of two ways.

        None if twists do not say all and there are more speeds, or if there are other states.
        """
        t, v = ([i for i in own if i in each] for each in (self.twists, self.speeds))
        if len(t) + len(v) != len(own) or not t or not v:
            return None
        # rates of twists by speeds, those of speeds by twists and speeds
        B, F, V = self.A.extract(t, v), self.A.extract(v, t), self.A.extract(v, v)
        if not self.A.extract(t, t).is_zero_matrix:
            return None
        X = _by_twists(B, V) if len(t) <= len(v) else None
        by_speeds = SecondOrder(-V, -F * B, t, v, B, F, None)
        if X is None:
            return by_speeds if len(v) <= len(t) else None
        by_twists = SecondOrder(-B * X, -B * F, t, v, B, F, X)
        # three shafts that meet are a circle of twists, but none of angles
        is_branched = len(t) > _BRANCHED and by_speeds.is_forest and not by_twists.is_forest
        return by_speeds if is_branched else by_twists

    @cached_property
    def motion(self) -> tuple[Any, Any, Any]:
        """M, C and K of ``M q'' + C q' + K q = 0`` for the angles of the speeds.

        Raises
        ------
        OptionError
            If there are other states, or speeds without kinetic energy.
        """
        system, name = self.system, self.system.name
        t, v = self.twists, self.speeds
        other = [s for i, s in enumerate(self.states) if i not in {*t, *v}]
        if other:
            raise OptionError(
                f"{name}: {other[0]} is no angle, position or speed, so M, C and K do not say all. "
                "Take A."
            )
        if not self.A.extract(t, t).is_zero_matrix:
            raise OptionError(
                f"{name}: a twist relaxes, so M, C and K of the speeds do not say all. Take A."
            )
        x = system.inputs[0]
        own = [self.kept[i] for i in v]
        energy = system.structure.in_states(sum_stored(system))
        M = self.of(ca.hessian(energy, x)[0][own, own]).applyfunc(shortest)
        if any(not any(M.row(i)) for i in range(M.rows)):
            bare = next(i for i in range(M.rows) if not any(M.row(i)))
            raise OptionError(
                f"{name}: no component says by its method `stored` what energy "
                f"{self.states[v[bare]]} has, so its mass is not known. Take A."
            )
        F, V, B = self.A.extract(v, t), self.A.extract(v, v), self.A.extract(t, v)
        cancel = load_sympy().cancel
        C, K = ((-M * each).applyfunc(cancel).applyfunc(shortest) for each in (V, F * B))
        return M, C, K


def _by_twists(B: Any, V: Any) -> Any:
    """X with ``V = X B`` for twists ``t' = B v``; None if damping does not follow from them."""
    sympy = load_sympy()
    if V.is_zero_matrix:
        return sympy.zeros(V.rows, B.rows)
    columns = list(B.rref()[1])
    if len(columns) < B.rows:
        return None
    rows = list(range(B.rows))
    X = (V.extract(list(range(V.rows)), columns) * B.extract(rows, columns).inv()).applyfunc(
        sympy.cancel
    )
    return X if (V - X * B).applyfunc(sympy.cancel).is_zero_matrix else None


def convert_named(system: System, found: ca.SX) -> Any:
    """Expressions in SymPy, by the names of states and parameters."""
    x, theta, time, _ = system.inputs
    names = [*system.state_names, *system.structure.parameters.free_names, "time"]
    return convert(found, ca.vertcat(x, theta, time), names)


def refuse_not_linear(system: System, slopes: ca.SX) -> None:
    """Refuse slopes that are no constants.

    Raises
    ------
    OptionError
        If they depend on states, time, or what sticks.
    """
    x, _, time, settings = system.inputs
    if ca.depends_on(slopes, ca.vertcat(x, time, settings)):
        raise OptionError(
            f"{system.name}: the drive is not linear; its formulas depend on where it is. "
            "Use modes with an operating point."
        )


def state_matrix(system: System, parameters: Changes | None) -> Matrices:
    """The state matrix of a linear drive; what is zero stays zero.

    Parameters
    ----------
    parameters : mapping of name to float, optional
        Parameters that are given as numbers.

    Raises
    ------
    OptionError
        If the drive is not linear, or a parameter has the name of a variable.
    """
    sympy = load_sympy()
    x = system.inputs[0]
    A = ca.jacobian(system.rates, x)
    refuse_not_linear(system, A)
    theta = system.theta(parameters)
    names = system.structure.parameters.free_names
    numbers = dict(zip(names, theta.tolist(), strict=True))
    for name in ("s", "lambda", "omega"):
        if name in numbers:
            raise OptionError(f"{system.name}: rename the parameter {name}, a symbol of formulas.")
    fixed = {system.key(name) for name in parameters or {}}
    given = {
        sympy.Symbol(name): exact(value)
        for name, value in numbers.items()
        if value == 0 or name in fixed
    }
    kept = np.flatnonzero(~np.isin(system.structure.states, [*system.structure.cyclic])).tolist()
    matrix = convert_named(system, A[kept, kept]).subs(given).applyfunc(sympy.cancel)
    return Matrices(system, [system.state_names[i] for i in kept], matrix, given, numbers, kept)
