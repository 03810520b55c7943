"""Torsional models of rotors that were entered for ROSS.

Source: ROSS 2.3.0, the torsional parts of the matrices of its elements (petrobras/ross).
"""

from __future__ import annotations

from typing import Any

from lumped import Component
from lumped.components.imported.numbered_nodes import NumberedNodes
from lumped.errors import DeclarationError, shown
from lumped.ops import pi

__all__ = ["from_ross"]


def from_ross(rotor: Any) -> Component:
    """The torsional model of a rotor of ROSS.

    ``node["3"]`` is all inertia at node 3, ``shaft[0]`` the stiffness and damping of the first
    shaft element, ``coupling[0]`` those of the first coupling. The polar moment of area of a shaft
    element is the mean of those at both ends, as in ROSS; its inertia is there a consistent mass
    matrix ``m [[2, 1], [1, 2]]``, here ``m`` at each end and ``middle[0]``, ``4 m`` that turns with
    the mean of both ends by ``mean[0]``. Discs and gears are inertias. Bearings, seals and point
    masses do not act on rotation about the axis and are left out.

    Parameters
    ----------
    rotor : ross.Rotor
        Shaft elements, couplings, discs and gears.

    Returns
    -------
    Component

    Raises
    ------
    DeclarationError
        If it is no rotor, or several that mesh; a coupling has no torsional stiffness; or a shaft
        element has damping in proportion to its mass, which would brake it against the ground.
    """
    if not hasattr(rotor, "shaft_elements"):
        raise DeclarationError(
            f"from_ross: {shown(rotor)} has no shaft_elements; give a Rotor of ROSS."
        )
    if hasattr(rotor, "rotors"):
        raise DeclarationError(
            "from_ross: this MultiRotor joins rotors by its gear mesh. Convert each of its rotors "
            "and connect the nodes of their gears by an IdealGear or a GearMesh."
        )
    drive = NumberedNodes()
    for element in rotor.shaft_elements:
        if hasattr(element, "kr_z"):
            _add_coupling(drive, element)
        else:
            _add_shaft(drive, element)
    for disc in rotor.disk_elements:
        drive.add_inertia(int(disc.n), disc.Ip)
    return drive.model()


def _add_shaft(drive: NumberedNodes, element: Any) -> None:
    if element.alpha:
        raise DeclarationError(
            f"from_ross: the shaft element from node {element.n_l} to {element.n_r} has damping, "
            f"alpha = {element.alpha:g} 1/s in proportion to its mass, which brakes it against the "
            "ground. Set alpha to 0, and connect a Damper to a Fixed flange where that is meant."
        )
    ends = (element.odl, element.idl), (element.odr, element.idr)
    area = sum(pi / 32 * (outer**4 - inner**4) for outer, inner in ends) / 2
    c = float(element.material.G_s * area / element.L)
    m = float(element.material.rho * area * element.L / 6)
    drive.add_shaft((int(element.n_l), int(element.n_r)), c, float(element.beta) * c, m)


def _add_coupling(drive: NumberedNodes, element: Any) -> None:
    ends = int(element.n_l), int(element.n_r)
    if not element.kr_z:
        raise DeclarationError(
            f"from_ross: the coupling from node {ends[0]} to {ends[1]} has no torsional stiffness; "
            "give kr_z, N.m/rad."
        )
    drive.add_shaft(ends, float(element.kr_z), float(element.cr_z), 0.0, "coupling")
    for node, inertia in zip(ends, (element.Ip_l, element.Ip_r), strict=True):
        drive.add_inertia(node, inertia)
