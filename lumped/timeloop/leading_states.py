"""Redundant coordinates: where a state hardly leads what depends on it, as at a dead centre.

There all coordinates that varying constraints tie become states, each by its own rate, and steps
bring them back to the constraints. None leads, so that none loses its lead; errors are measured in
all of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.constraints import constraints_of
from lumped.compiler.leads import exchange_states, free_coordinates
from lumped.compiler.system import System
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.fit_states import FitStates
from lumped.timeloop.levers import FAIR_LEVERAGE, levers
from lumped.timeloop.plants.executable import evaluate_at


class Lead(NamedTuple):
    """A system with more states, and the states of a run in it.

    Attributes
    ----------
    system : System
    x, settings : ndarray
        Its states, modes and implicit quantities.
    follower, leader : str
        Names of the quantity that is fastest over the state that led it, and of that state.
    """

    system: System
    x: np.ndarray
    settings: np.ndarray
    follower: str
    leader: str


def free_states(
    system: System, theta: np.ndarray, t: float, x: np.ndarray, settings: np.ndarray
) -> Lead:
    """Let all coordinates that constraints tie be states, or another one that follows.

    Where equations of motion are constraints, as in inverse dynamics of elastic drives, forces are
    tied to positions; errors of both have no common measure.
    """
    ratios = np.abs(evaluate_at(system, "leverage", x, theta, t, settings))
    follower, leader = levers(system, FAIR_LEVERAGE)[0][int(np.argmax(ratios))]
    reduced = system.structure.reduced
    is_explicit = follower in reduced.dependent[: reduced.explicit]
    if reduced.is_kinematic:
        new = free_coordinates(system, follower if is_explicit else -1)
    else:
        new = exchange_states(system, [(follower, leader)])
    states, implicit = states_of(system, new)(x, theta, t, settings)
    modes = settings[: len(settings) - len(system.structure.implicit)]
    now = np.concatenate([modes, implicit])
    return Lead(new, states, now, _name(system, follower), _name(system, leader))


def bind_states(
    system: System,
    redundant: System,
    theta: np.ndarray,
    t: float,
    x: np.ndarray,
    settings: np.ndarray,
) -> tuple[System, np.ndarray, np.ndarray]:
    """A point of redundant coordinates led by states again: the system, its states and settings.

    Parameters
    ----------
    system : System
        Whose states are taken if they lead there.
    redundant : System
        The same in redundant coordinates; what follows is a point in it.

    Raises
    ------
    SingularPositionError
        If no states lead there.
    """
    modes = settings[: len(settings) - len(redundant.structure.implicit)]
    values = tied_values(system, redundant, [x, theta, t, settings])
    fit = FitStates(system, theta, t, modes)
    pairs = fit.find(values) if fit.is_unfit(values) else []
    led = exchange_states(system, pairs) if pairs else system
    states, implicit = states_of(redundant, led)(x, theta, t, settings)
    return led, states, np.concatenate([modes, implicit])


def tied_values(
    system: System, led: System, point_inputs: Sequence[np.ndarray | float]
) -> dict[int, float]:
    """Values of what constraints of a system tie, at a point of the same led by other states."""
    nodes, function = _tied_nodes(led, system)
    return dict(zip(nodes, function(*point_inputs)[0].tolist(), strict=True))


@made_once
def _tied_nodes(led: System, system: System) -> tuple[list[int], ArrayFunction]:
    """Nodes that constraints tie and states in use determine, and their values."""
    tied = [node for part in constraints_of(system) for node in part.nodes]
    usable = led.structure.available(tied, cyclic=True)
    nodes = [n for n, ok in zip(tied, usable, strict=True) if ok]
    values = ca.densify(led.structure.in_states(led.structure.values.of(nodes)))
    return nodes, ArrayFunction(ca.Function("tied", led.inputs, [values]))


@made_once
def states_of(system: System, other: System) -> ArrayFunction:
    """States and implicit quantities of another system."""
    sets, structure = (other.structure.states, other.structure.implicit), system.structure
    found = [ca.densify(structure.in_states(structure.values.of(nodes))) for nodes in sets]
    return ArrayFunction(ca.Function("change", system.inputs, found))


def _name(system: System, node: int) -> str:
    reduced = system.structure.reduced
    number, _ = reduced.class_and_order(node)
    return system.structure.node_name(int(reduced.first[number]))
