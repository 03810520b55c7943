"""Start values given to instances and set by users, and those of declarations."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import Changes, System
from lumped.errors import StartError
from lumped.language.port import Flange, LinearFlange
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.support.units import plain

_POSITIONS = (Flange.potential.unit, LinearFlange.potential.unit)


def read_start_values(system: System, start: Changes) -> dict[int, float]:
    """Start values that are set, by unknowns.

    Raises
    ------
    StartError
        If one is no number in the unit of its quantity.
    """
    tree = system.structure.tree
    found: dict[int, float] = {}
    for name, value in start.items():
        unknown = tree.unknown(name)
        unit = tree.quantity(unknown).unit
        found[unknown] = plain(value, unit, f"{system.key(name)} =", StartError)
    return found


def _start_column(system: System) -> ca.SX:
    """Start values of declarations, then those given to instances."""
    flat = system.structure.flat
    return ca.vertcat(ca.SX(0, 1), *flat.starts.values(), *flat.given.values())


def evaluate_start_values(
    system: System, theta: np.ndarray
) -> tuple[dict[int, float], dict[int, float]]:
    """Start values given to instances, and those of declarations, by unknowns."""
    flat, numbers = system.structure.flat, _start_values(system)(theta)[0].tolist()
    count = len(flat.starts)
    given = dict(zip(flat.given, numbers[count:], strict=True))
    return given, dict(zip(flat.starts, numbers[:count], strict=True))


@made_once
def _start_values(system: System) -> ArrayFunction:
    theta = system.structure.parameters.theta
    return ArrayFunction(ca.Function("starts", [theta], [ca.densify(_start_column(system))]))


@made_once
def differentiate_start_values(system: System) -> ca.Function:
    """Derivatives of start values by the parameters: of those declared, then of those given."""
    theta = system.structure.parameters.theta
    return ca.Function("slopes", [theta], [ca.jacobian(_start_column(system), theta)])


@made_once
def relative_positions(system: System) -> tuple[int, ...]:
    """States that are positions of parts relative to each other, such as twists and gaps."""
    tree, reduced = system.structure.tree, system.structure.reduced
    absolute = {
        reduced.node(part.first_unknown + i)
        for part in tree.instances
        for i, quantity in enumerate(part.layout.quantities)
        if quantity.kind == "potential"
    }
    relative = (
        n for n in system.structure.states if n not in absolute and n not in system.structure.cyclic
    )
    return tuple(
        n
        for n in relative
        if n in system.structure.members
        and tree.quantity(system.structure.members[n]).unit in _POSITIONS
    )
