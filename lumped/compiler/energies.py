"""Energies that components say they store or dissipate, by the symbols of all states."""

from __future__ import annotations

from typing import Any

import casadi as ca

from lumped.compiler.formulas import rate_of
from lumped.compiler.system import System
from lumped.errors import EquationError, told_by
from lumped.flattening.tree import Instance
from lumped.language.expression import Expr, Ref
from lumped.language.lowering import lower
from lumped.support.made_once import made_once


@made_once
def stored_energies(system: System) -> dict[Instance, ca.SX]:
    """What each component stores that says so, J.

    Raises
    ------
    EquationError
        If a method `stored` holds something else than the component's own quantities.
    """
    nodes = system.structure.tree.instances
    found = {node: _lower_told(system, node, node.component.stored) for node in nodes}
    return {node: energy for node, energy in found.items() if energy is not None}


def sum_stored(system: System) -> ca.SX:
    """What all components store that say so, J; errors as `stored_energies`."""
    found = ca.SX(0)
    for energy in stored_energies(system).values():
        found += energy
    return found


def dissipated_power(system: System, node: Instance) -> ca.SX:
    """What a component dissipates, W; zero if it does not say.

    Raises
    ------
    EquationError
        If its method `loss` holds something else than its own quantities.
    """
    power = _lower_told(system, node, node.component.loss)
    return ca.SX(0) if power is None else power


def _lower_told(system: System, node: Instance, tell: Any) -> ca.SX | None:
    """What a method of a component tells of its own quantities, in those of the system."""
    layout, structure = node.layout, system.structure
    if not callable(tell):  # a quantity of this name
        return None
    with told_by(node.label, f"{tell.__name__}()"):
        expression = tell()
    if expression is None:
        return None

    def leaf(found: Expr) -> ca.SX:
        name = ""
        if isinstance(found, Ref) and found.owner is node.component:
            name = found.name
        if name in layout.parameters:
            return structure.parameters.values[node.first_parameter + layout.parameters[name]]
        if name not in layout.unknowns:
            raise EquationError(
                f"{node.label}: '{expression!r}' is an energy or a loss and may hold only the "
                f"component's own quantities and parameters, not '{found!r}'."
            )
        return structure.raw([node.first_unknown + layout.unknowns[name]])

    values = structure.values
    return lower(
        expression, leaf, time=values.time, derivative=lambda found: rate_of(values, found)
    )
