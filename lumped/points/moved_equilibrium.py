"""How an operating point follows parameters, so that it stays an equilibrium."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.points.steady_directions import unsteady_part
from lumped.points.target_values import initial_residuals
from lumped.support.arrays import Boolean, Real
from lumped.support.text_table import list_names
from lumped.timeloop.results.operating_point import Kept, OperatingPoint

_STILL = 1e-9
"""Derivatives of states, relative to the terms in them, below which a point is an equilibrium."""
_RANK, _ROUNDING, _MISSED = 1e-13, 1e-9, 1e-6


@dataclass(frozen=True, eq=False)
class MovedPoint:
    """Derivatives of an operating point by k parameters.

    Attributes
    ----------
    states : ndarray, shape (n, k)
        Of the states.
    parameters : ndarray, shape (p, k)
        Of all parameters: one for itself, and those that the equilibrium determines.
    """

    states: Real
    parameters: Real

    def sizes(self) -> MovedPoint:
        """Their magnitudes."""
        return MovedPoint(np.abs(self.states), np.abs(self.parameters))

    def through(self, slopes: Any) -> Any:
        """Derivatives of what has these slopes by states and parameters, shape (m, n + p)."""
        steps = np.vstack([self.states, self.parameters])
        used = np.flatnonzero(steps.any(axis=1))  # a slope that is not used may be no number
        return slopes[:, used] @ steps[used]


def places_to(point: OperatingPoint, by: Iterable[Name] | None) -> tuple[list[str], list[int]]:
    """Names and places of the parameters to derive by; None for all that can be given.

    Raises
    ------
    OptionError
        If the equilibrium determines one of them.
    """
    system = point.system
    free = set() if point.kept is None else set(point.kept.free)
    if by is None:
        every = enumerate(system.structure.parameters.free_names)
        names = [name for place, name in every if place not in free]
    else:
        names = [system.key(name) for name in by]
    places = system.places(names)
    for name, place in zip(names, places, strict=True):
        if place in free:
            raise OptionError(
                f"{system.name}: {name} is free at this equilibrium, which determines it; nothing "
                "has a derivative by it. Leave it out of `by`, or ask for the derivative of what "
                "was given by another parameter."
            )
    return names, places


def point_matters(point: OperatingPoint, slopes: Any, least: float = 0.0) -> bool:
    """Whether slopes by states, or by parameters that the equilibrium determines, are there.

    Parameters
    ----------
    slopes : ndarray, shape (m, n + p)
        By states, then by all parameters.
    """
    free = [] if point.kept is None else [len(point.x) + place for place in point.kept.free]
    felt = np.abs(slopes[:, [*range(len(point.x)), *free]]) > least
    return bool(felt.any())


def still_point(point: OperatingPoint, places: list[int]) -> MovedPoint:
    """Derivatives of a point whose states are held."""
    parameters = np.zeros((len(point.theta), len(places)))
    parameters[places, np.arange(len(places))] = 1.0
    return MovedPoint(np.zeros((len(point.x), len(places))), parameters)


def find_moved_point(point: OperatingPoint, places: list[int]) -> MovedPoint | None:
    """How states and free parameters follow others, so that the point stays an equilibrium.

    What is held stays held: what sticks or is locked stays where it is, what is closed or on its
    stop stays in contact. Where parameters are free, what was given stays as it was given. Of
    several possible equilibria that which keeps best what was given, then the nearest. None if the
    point is no equilibrium.

    Parameters
    ----------
    places : list of int
        Places of the parameters.

    Raises
    ------
    SolverError
        If no such equilibrium is near for other parameters.
    """
    system, kept = point.system, point.kept or Kept()
    every = scipy.sparse.eye_array(len(point.x), format="csc")
    change = every if kept.rest else unsteady_part(point)
    if not _is_equilibrium(point, change):
        return None
    free, count = list(kept.free), len(system.structure.reduced.states)
    end, chosen = count + len(free), [*free, *places]
    rates = _slopes(point, system.rates, chosen)
    # what cancels in it is exactly zero there, and nothing depends on states that are left out
    rates[:, :count] = 0.0
    rates[:, system.structure.in_use] = system.state_matrix(point.inputs).toarray()
    given = _slopes(point, _collect_given(system, kept), chosen)
    held = _slopes(point, _collect_held(system, point), chosen)
    hard = np.vstack([change @ rates, held, *([given] if free else [])])
    step, missed = _least(
        hard[:, :end], hard[:, end:], given[:, :end], given[:, end:], system.structure.in_use
    )
    lost = np.flatnonzero(missed > _MISSED)
    if len(lost):
        raise SolverError(_none_near(point, places[lost[0]]))
    parameters = still_point(point, places).parameters
    parameters[free] = step[count:]
    return MovedPoint(step[system.structure.in_use], parameters)


def select_still(point: OperatingPoint, vectors: Real) -> Real:
    """Those combinations of columns of states in which nothing moves that is held."""
    system = point.system
    if not _find_stuck_holds(point).any() or not vectors.shape[1]:
        return vectors
    slopes = _slopes(point, _collect_held(system, point), [])
    lost = np.setdiff1d(np.arange(slopes.shape[1]), system.structure.in_use)
    # a state that is left out may take any value
    slopes = _solve_least_squares(slopes[:, lost].T, np.zeros((len(lost), 1)))[1].T @ slopes
    moves = slopes[:, system.structure.in_use] @ vectors
    size = np.abs(slopes[:, system.structure.in_use]) @ np.abs(vectors)
    moves[np.abs(moves) <= _MISSED * size] = 0.0
    return vectors @ _solve_least_squares(moves, np.zeros((len(moves), 1)))[1]


def _collect_held(system: System, point: OperatingPoint) -> ca.SX:
    """What does not change while something is held: speeds, and gaps or positions.

    Expressions of all states; what is always zero is left out.
    """
    switching, values, reduced = system.switching, system.structure.values, system.structure.reduced
    found = [ca.SX(0, 1)]
    for hold in np.flatnonzero(_find_stuck_holds(point)).tolist():
        node = switching.speeds[hold]
        if node < 0:
            continue
        found.append(switching.speed[hold])
        if switching.has_gap[hold]:
            found.append(switching.gap[hold])
        elif reduced.class_and_order(node)[1] > 0:
            found.append(values.of([node - 1]))
        else:
            found.append(_way(point, hold))
    return ca.vertcat(*found)


def _way(point: OperatingPoint, hold: int) -> ca.SX:
    """A position whose rate is the speed of a hold, which is the derivative of no quantity.

    It is made of the angles and positions of its component, by the factors of their rates in the
    speed at the point.
    """
    system, name = point.system, point.system.switching.names[hold]
    reduced, values, layouts = (
        system.structure.reduced,
        system.structure.values,
        system.structure.tree.instances,
    )
    node = next((n for n in layouts if n.path == name), layouts[0])
    units = {q.unit for q in node.layout.quantities if q.kind == "potential"}
    own = {
        reduced.node(node.first_unknown + i)
        for i, q in enumerate(node.layout.quantities)
        if q.unit in units
    }
    order = reduced.class_and_order
    places = sorted(n for n in own if n is not None and order(n + 1)[0] == order(n)[0])
    speed = ca.vertcat(system.switching.speed[hold], values.of([n + 1 for n in places]))
    rows = _slopes(point, speed, [])
    factors = scipy.linalg.lstsq(rows[1:].T, rows[0])[0]
    if np.abs(factors @ rows[1:] - rows[0]).max() > _MISSED * np.abs(rows[0]).max():
        raise SolverError(
            f"{system.name}: {name} holds a speed that is not made of its own angles and "
            "positions, so what else moves while it holds is not known. Declare the angle or "
            "position whose derivative the speed is."
        )
    return ca.mtimes(ca.DM(factors).T, values.of(places))


def _collect_given(system: System, kept: Kept) -> ca.SX:
    """What the search for the equilibrium kept, as expressions of all states."""
    reduced = system.structure.reduced
    nodes = set(kept.nodes)
    if kept.rest:
        nodes |= {n for n in reduced.states if reduced.class_and_order(n)[1] > 0}
    initial = initial_residuals(system)[0] if kept.initial else ca.SX(0, 1)
    return ca.vertcat(system.structure.values.of(sorted(nodes)), initial)


def _slopes(point: OperatingPoint, expression: ca.SX, places: list[int]) -> Real:
    """Derivatives by all states, then by parameters, at the point."""
    structure = point.system.structure
    inputs = [structure.values.states, *point.system.inputs[1:]]
    by = ca.vertcat(inputs[0], inputs[1][places])
    function = ca.Function("slopes", inputs, [ca.jacobian(expression, by)])
    every = np.zeros(len(structure.reduced.states))
    every[structure.in_use] = point.x
    found: Real = function(every, point.theta, point.time, point.settings).full()
    return found


def _least(
    own: Real, right: Real, soft: Real, soft_right: Real, near: list[int]
) -> tuple[Real, Real]:
    """Solutions of ``own z + right == 0``, and what each misses, relative.

    Of several those that come nearest to ``soft z + soft_right == 0``, then those in which the
    unknowns `near` are least.
    """
    rows = np.abs(own).max(axis=1, initial=0.0)
    rows = np.where(rows > 0, rows, np.maximum(np.abs(right).max(axis=1, initial=0.0), 1e-300))
    columns = np.abs(own / rows[:, None]).max(axis=0, initial=0.0)
    columns = np.where(columns > 0, 1 / np.where(columns > 0, columns, 1.0), 1.0)
    matrix, wanted = own / rows[:, None] * columns, -right / rows[:, None]
    z, free = _solve_least_squares(matrix, wanted)
    missed = np.abs(matrix @ z - wanted).max(axis=0, initial=0.0)
    sizes = np.abs(wanted).max(axis=0, initial=0.0)
    if free.shape[1]:
        wishes = soft * columns
        size = float(np.abs(wishes).max(initial=0.0))
        more, left = _solve_least_squares(wishes @ free, -(wishes @ z + soft_right), size)
        z, free = z + free @ more, free @ left
    if free.shape[1]:
        lengths = columns[near, None]
        size = float(np.abs(lengths).max(initial=0.0))
        z = z + free @ _solve_least_squares(lengths * free[near], -lengths * z[near], size)[0]
    return z * columns[:, None], missed / np.where(sizes > 0, sizes, 1.0)


def _solve_least_squares(matrix: Real, right: Real, size: float = 0.0) -> tuple[Real, Real]:
    """Least squares of least norm, and what the matrix maps to zero, as columns.

    What is as small as the rounding of numbers of a `size` counts as zero.
    """
    left, sizes, rows = scipy.linalg.svd(matrix)
    rank = int((sizes > max(_RANK * sizes.max(initial=0.0), _ROUNDING * size)).sum())
    found = rows[:rank].T @ ((left[:, :rank].T @ right) / sizes[:rank, None])
    return found, rows[rank:].T


def _is_equilibrium(point: OperatingPoint, change: scipy.sparse.csc_array) -> bool:
    """Whether the derivatives vanish at the point, steady motion apart."""
    system = point.system
    rates = np.abs(change @ np.asarray(system.rhs(*point.inputs)).ravel())
    terms = abs(change @ system.state_matrix(point.inputs)) @ (np.abs(point.x) + 1e-3)
    return bool((rates <= _STILL * (terms + 1e-9)).all())


def _none_near(point: OperatingPoint, place: int) -> str:
    system = point.system
    name = system.structure.parameters.free_names[place]
    held = list(dict.fromkeys(np.array(system.switching.names)[_find_stuck_holds(point)].tolist()))
    staying = (
        f" while {list_names(held)} {'stays' if len(held) == 1 else 'stay'} held" if held else ""
    )
    given = " and the given start values hold" if point.kept is not None and point.kept.free else ""
    return (
        f"{system.name}: there is no equilibrium near the operating point when "
        f"{name} changes{staying}{given}. Leave it out of `by`, or let a load "
        "depend on the speed."
    )


def _find_stuck_holds(point: OperatingPoint) -> Boolean:
    """Which holds hold at the operating point, shape (h,)."""
    found: Boolean = point.settings[point.system.switching.first_modes] > 0.5
    return found
