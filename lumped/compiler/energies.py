"""What components say they store or dissipate, and powers of ports, by symbols of all states."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Literal, NamedTuple

import casadi as ca

from lumped.compiler.formulas import derivative, rate_of
from lumped.compiler.system import System
from lumped.errors import EquationError, shown, told_by
from lumped.flattening.tree import Instance
from lumped.language.expression import Expr, Ref, as_expr
from lumped.language.lowering import lower
from lumped.support.known_units import measure
from lumped.support.made_once import made_once

Told = Literal["stored", "loss"]
ENERGIES: dict[Told, str] = {"stored": "J", "loss": "W"}
"""Methods by which components tell energies and powers, and the units of these."""


@made_once
def stored_energies(system: System) -> dict[Instance, ca.SX]:
    """What each component stores that says so, J.

    Raises
    ------
    EquationError
        If a method `stored` holds something else than the component's own quantities.
    """
    nodes = system.structure.tree.instances
    found = {node: _lower_told(system, node, "stored") for node in nodes}
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
    power = _lower_told(system, node, "loss")
    return ca.SX(0) if power is None else power


class PortPower(NamedTuple):
    """Power that flows in through a port of a component.

    Attributes
    ----------
    name : str
        Dotted name of the port.
    power : SX or None
        Potential times flow where that has the unit of a power, the rate of a position times its
        force or torque, or the flow itself if that is a power already, W; else None.
    is_heat : bool
        Whether the flow itself is a power.
    """

    name: str
    power: ca.SX | None
    is_heat: bool = False


def port_powers(system: System, node: Instance) -> list[PortPower]:
    """Power through each port of a component, in the order of the ports."""
    units, structure = [quantity.unit for quantity in node.layout.quantities], system.structure
    found = []
    for k, port in enumerate(node.layout.ports):
        name, q = node.name(port), node.first_unknown + 2 * k
        kind, factor = _find_power(*units[2 * k : 2 * k + 2])
        if kind is None:
            found.append(PortPower(name, None))
            continue
        power = factor * structure.raw([q + 1])
        if kind == "product":
            power *= structure.raw([q])
        elif kind == "rate":
            power *= derivative(structure.values, q, 1)
        found.append(PortPower(name, power, kind == "flow"))
    return found


@cache
def _find_power(
    potential: str, flow: str
) -> tuple[Literal["flow", "product", "rate"] | None, float]:
    """How the power of a port follows from its potential and flow, and the factor to W."""
    across, through = measure(potential), measure(flow)
    if through is not None and _without_angles(through.powers) == _POWER:
        return "flow", through.factor
    if across is None or through is None or across.zero:
        return None, 0.0
    names = across.powers.keys() | through.powers.keys()
    powers = {n: across.powers.get(n, 0) + through.powers.get(n, 0) for n in names}
    factor = across.factor * through.factor
    if _without_angles(powers) == _POWER:
        return "product", factor
    if across.powers in ({"rad": 1}, {"m": 1}) and _without_angles(powers) == _WORK:
        return "rate", factor
    return None, 0.0


def _without_angles(powers: Mapping[str, int]) -> dict[str, int]:
    return {base: power for base, power in powers.items() if power and base != "rad"}


_WORK = {"kg": 1, "m": 2, "s": -2}
_POWER = {"kg": 1, "m": 2, "s": -3}


def told(node: Instance, name: Told) -> Expr | None:
    """What a component says by its method `stored` or `loss`; None if it does not say.

    Raises
    ------
    EquationError
        If that is no method, or gives neither an expression nor None.
    """
    tell = found = getattr(node.component, name)
    if callable(tell):
        with told_by(node.label, f"{name}()"):
            found = tell()
            if isinstance(found, Expr | int | float):
                return as_expr(found)
    if found is None or (not callable(tell) and not isinstance(tell, str | int | float)):
        return None  # a quantity or a part may have the name
    raise EquationError(
        f"{node.label}: {name} gives {shown(found)}. Write a method, def {name}(self), that "
        f"returns an expression of the component's own quantities, in {ENERGIES[name]}, or None."
    )


def _lower_told(system: System, node: Instance, name: Told) -> ca.SX | None:
    """What a component tells of its own quantities, in those of the system."""
    layout, structure = node.layout, system.structure
    expression = told(node, name)
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
