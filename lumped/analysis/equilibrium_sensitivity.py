"""How an equilibrium changes with parameters."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np
import scipy
from numpy.typing import NDArray

from lumped.analysis.linearise import sparse_state_matrix
from lumped.analysis.moving import moving
from lumped.analysis.ranking import ranked
from lumped.analysis.result import OperatingPoint
from lumped.analysis.steady import unsteady_part
from lumped.arguments import checked
from lumped.errors import OptionError, SolverError, UnknownNameError, nearest
from lumped.system import Name, System
from lumped.table import number, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["EquilibriumSensitivity", "equilibrium_sensitivity", "moved_states"]

Real = NDArray[np.float64]

_STILL = 1e-9
"""Derivatives of states, relative to the terms in them, below which a point is an equilibrium."""


@dataclass(frozen=True, eq=False)
class EquilibriumSensitivity:
    """Derivatives of quantities at an equilibrium; ``found["shaft.phi_rel", "load.tau"]`` is one.

    Attributes
    ----------
    point : OperatingPoint
        The equilibrium.
    of, to : tuple of str
        Quantities and parameters.
    values : ndarray, shape (len(of),)
        Quantities.
    derivatives : ndarray, shape (len(of), len(to))
        Their derivatives.
    """

    point: OperatingPoint
    of: tuple[str, ...]
    to: tuple[str, ...]
    values: Real
    derivatives: Real

    @checked
    def __getitem__(self, pair: tuple[Name, Name]) -> float:
        row, column = self._row(pair[0]), _place(self.point.system, pair[1], self.to)
        return float(self.derivatives[row, column])

    @checked
    def ranked(self, of: Name) -> list[tuple[str, float]]:
        """Parameters and relative sensitivities of a quantity, the largest first.

        Raises
        ------
        OptionError
            If the quantity is zero, to which nothing is relative.
        """
        row, known = self._row(of), self.point.parameters
        varied = np.array([known[name] for name in self.to])
        with np.errstate(divide="ignore", invalid="ignore"):
            relative = self.derivatives[row] * varied / self.values[row]
        return ranked(self.of[row], self.values[row], self.to, relative)

    @checked
    def plot(self, of: Name | None = None) -> Figure:
        """Tornado of the parameters that matter most (see `lumped.plot.tornado`)."""
        from lumped.plot import tornado

        row = 0 if of is None else self._row(of)
        name = self.of[row]
        title = f"{self.point.system.name}: {name} = {self.values[row]:.4g} at the equilibrium"
        return tornado(self.ranked(name), title, name)

    def _row(self, of: Name) -> int:
        return _place(self.point.system, of, self.of)

    def __repr__(self) -> str:
        rows = []
        for name, value in zip(self.of[:12], self.values, strict=False):
            most = self.ranked(name)[:4] if value else []
            text = "; ".join(f"{n} {v:+.4f}" for n, v in most if v)
            unit = self.point.system.quantity(name).unit
            rows.append((name, number(float(value)), unit, text))
        head = f"{self.point.system.name}: equilibrium by {len(self.to)} parameters, relative"
        if self.point.search is not None:
            head += f"; the point was {self.point.search}"
        return f"{head}\n" + table(("quantity", "value", "unit", "largest"), rows)


@checked
def equilibrium_sensitivity(
    point: OperatingPoint, *, of: Iterable[Name], to: Iterable[Name] | None = None
) -> EquilibriumSensitivity:
    """Derivatives of quantities at an equilibrium by parameters.

    By the implicit function theorem on vanishing derivatives, ``f_x dx + f_p dp == 0``. Where an
    equilibrium is one of many, such as the speed of a free drive, states change as little as they
    can. What sticks goes on to stick.

    Parameters
    ----------
    point : OperatingPoint
        From `equilibrium`.
    of : iterable of names
        Quantities.
    to : iterable of names, optional
        Parameters; default is all that can be changed.

    Raises
    ------
    OptionError
        If `of` or `to` is empty, or the point is no equilibrium.
    UnknownNameError
        If a name does not exist.
    SolverError
        If there is no equilibrium for other parameters.
    """
    system = point.system
    p = system._flat.parameters
    names = [p.names[i] for i in p.free] if to is None else [system.key(name) for name in to]
    wanted = [system.key(name) for name in of]
    if not wanted or not names:
        raise OptionError("equilibrium_sensitivity: name at least one quantity and one parameter.")
    places = system.places(names)
    moved = moved_states(point, places)
    if moved is None:
        raise OptionError(
            f"{system.name}: derivatives of states do not vanish at this point, so it is no "
            "equilibrium. Take one from lumped.equilibrium."
        )
    x, theta, _, _ = system._inputs
    y = system.expressions(wanted)
    results = [ca.densify(v) for v in (y, ca.jacobian(y, x), ca.jacobian(y, theta[places]))]
    function = ca.Function("outputs", system._inputs, results)
    inputs = (point.x, point.theta, point.time, point.modes)
    values, by_states, by_parameters = (v.full() for v in function(*inputs))
    found = by_states @ moved + by_parameters
    return EquilibriumSensitivity(point, tuple(wanted), tuple(names), values.ravel(), found)


def moved_states(point: OperatingPoint, places: list[int]) -> Real | None:
    """How states follow parameters, shape (n, p), so that the point stays an equilibrium.

    None if it is no equilibrium. Of several possible the nearest.

    Parameters
    ----------
    places : list of int
        Places of the parameters.

    Raises
    ------
    SolverError
        If no equilibrium is near for other parameters.
    """
    change = unsteady_part(point)
    if not _is_equilibrium(point, change):
        return None
    system = point.system
    by_parameters = ca.jacobian(system.rates, system._inputs[1][places])
    function = ca.Function("f", system._inputs, [by_parameters])
    inputs = (point.x, point.theta, point.time, point.modes)
    right = (change @ scipy.sparse.csc_array(function(*inputs).sparse())).toarray()
    own = moving(system, point)  # a speed that sticks stays zero
    matrix = (change @ sparse_state_matrix(system, point)).toarray()[:, own]
    scale = np.abs(matrix).max(axis=1, initial=1e-12)[:, None]
    step = np.zeros((len(own), len(places)))
    step[own] = scipy.linalg.lstsq(matrix / scale, -right / scale, cond=1e-13)[0]
    left_over = np.abs(matrix @ step[own] + right).max(axis=0, initial=0.0)
    size = np.abs(right).max(axis=0, initial=0.0)
    lost = np.flatnonzero(left_over > 1e-6 * size)
    if len(lost):
        names = system._flat.parameters
        name = names.names[names.free[places[lost[0]]]]
        raise SolverError(
            f"{system.name}: there is no equilibrium near the operating point when {name} "
            "changes. Leave it out of `to`, or let a load depend on the speed."
        )
    return step


def _is_equilibrium(point: OperatingPoint, change: scipy.sparse.csc_array) -> bool:
    """Whether the derivatives vanish at the point, steady motion apart."""
    system = point.system
    inputs = (point.x, point.theta, point.time, point.modes)
    rates = np.abs(change @ np.asarray(system.rhs(*inputs)).ravel())
    terms = abs(change @ sparse_state_matrix(system, point)) @ (np.abs(point.x) + 1e-3)
    return bool((rates <= _STILL * (terms + 1e-9)).all())


def _place(system: System, name: Name, known: tuple[str, ...]) -> int:
    key = system.key(name)
    if key not in known:
        raise UnknownNameError(f"'{key}' was not asked for. {nearest(key, known)}")
    return known.index(key)
