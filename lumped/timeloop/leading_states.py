"""Exchange of states: where a state hardly leads what depends on it, as at a dead centre."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.timeloop.guards import levers
from lumped.timeloop.plants.executable import evaluate_at


class Lead(NamedTuple):
    """A system with another choice of states, and the states of a run in it.

    Attributes
    ----------
    system : System
    x, settings : ndarray
        Its states, modes and implicit quantities.
    after, before : str
        Names of the quantities that lead now, and that led before.
    """

    system: System
    x: np.ndarray
    settings: np.ndarray
    after: str
    before: str


def exchange_lead(
    system: System, theta: np.ndarray, t: float, x: np.ndarray, settings: np.ndarray
) -> Lead:
    """Let the motion lead that is fastest over the state that leads it."""
    ratios = np.abs(evaluate_at(system, "leverage", x, theta, t, settings))
    follower, leader = levers(system)[0][int(np.argmax(ratios))]
    new, change = _change_lead(system, follower, leader)
    states, implicit = change(x, theta, t, settings)
    modes = settings[: len(settings) - len(system.structure.implicit)]
    now = np.concatenate([modes, implicit])
    return Lead(new, states, now, _name(system, follower), _name(system, leader))


@made_once
def _change_lead(system: System, follower: int, leader: int) -> tuple[System, ArrayFunction]:
    """The system led by another motion, and its states and implicit quantities."""
    new = system.exchange_state(follower, leader)
    wanted = (new.structure.states, new.structure.implicit)
    found = [ca.densify(system.structure.values.of(nodes)) for nodes in wanted]
    return new, ArrayFunction(ca.Function("change", system.inputs, found))


def _name(system: System, node: int) -> str:
    reduced = system.structure.reduced
    number, _ = reduced.class_and_order(node)
    return system.structure.node_name(int(reduced.first[number]))
