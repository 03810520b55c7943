"""Drives that were entered for openTorsion.

Source: openTorsion 0.3.2, the matrices of its elements (aalto-arotor/openTorsion).
"""

from __future__ import annotations

from typing import Any

from lumped import Component
from lumped.components.compliance import Damper, SpringDamper
from lumped.components.gearing.gears import IdealGear
from lumped.components.imported.numbered_nodes import NumberedNodes
from lumped.components.sources import Fixed
from lumped.errors import DeclarationError, shown

__all__ = ["from_opentorsion"]

_LISTS = ("shaft_elements", "disk_elements", "gear_elements", "elastic_gear_elements")


def from_opentorsion(assembly: Any) -> Component:
    """The model of an assembly of openTorsion.

    ``node["3"]`` is all inertia at node 3, ``shaft[0]`` the stiffness and damping of the first
    shaft, ``gear[0]`` the first pair of wheels and ``mesh[0]`` the stiffness of the first elastic
    one, ``damper[0]`` the first damper to the housing. The inertia of a shaft is there a consistent
    mass matrix ``m [[2, 1], [1, 2]]``; here it is ``m`` at each end and ``middle[0]``, ``4 m``
    that turns with the mean of both ends by ``mean[0]``.

    Parameters
    ----------
    assembly : opentorsion.Assembly
        Shafts, discs, gears and elastic gears.

    Returns
    -------
    Component

    Raises
    ------
    DeclarationError
        If it is no assembly, a disc has a stiffness, which openTorsion leaves out of its matrices,
        or an elastic gear has none.
    """
    if not hasattr(assembly, _LISTS[0]):
        raise DeclarationError(
            f"from_opentorsion: {shown(assembly)} has no shaft_elements; give an Assembly of "
            "openTorsion."
        )
    drive = _Drive()
    shafts, discs, gears, elastic = (getattr(assembly, name, None) or () for name in _LISTS)
    for shaft in shafts:
        ends = shaft.nl, shaft.nr
        drive.add_shaft(ends, float(shaft.k), float(shaft.c), float(shaft.mass))
    for disc in discs:
        drive.add_disc(disc)
    for gear in (*gears, *elastic):
        drive.add_inertia(gear.node, gear.I)
    for gear in gears:
        if gear.parent is not None:
            drive.add_gear(gear)
    for gear in elastic:
        if gear.parent is not None:
            drive.add_mesh(gear)
    return drive.model()


class _Drive(NumberedNodes):
    """Elements of openTorsion between its nodes."""

    def add_disc(self, disc: Any) -> None:
        if disc.k:
            raise DeclarationError(
                f"from_opentorsion: the disc at node {disc.node} has the stiffness k = {disc.k:g} "
                "N.m/rad, which openTorsion leaves out of its matrices. Set it to 0, and add a "
                "shaft to a fixed flange here if it is meant."
            )
        self.add_inertia(disc.node, disc.I)
        if disc.c:
            damper = self.add("damper", Damper(d=float(disc.c)))
            housing = self.add("housing", Fixed())
            self.attach(disc.node, "damper", damper, "flange_a")
            self.join(("damper", damper, "flange_b"), ("housing", housing, "flange"))

    def add_gear(self, gear: Any) -> None:
        self.attach(gear.parent.node, "gear", self._wheels(gear), "flange_a")

    def _wheels(self, gear: Any) -> int:
        place = self.add("gear", IdealGear(ratio=-float(gear.R) / float(gear.parent.R)))
        self.attach(gear.node, "gear", place, "flange_b")
        return place

    def add_mesh(self, gear: Any) -> None:
        if not gear.k:
            raise DeclarationError(
                f"from_opentorsion: the elastic gear at node {gear.node} has no stiffness; give k, "
                "N.m/rad, or take a Gear."
            )
        place = self._wheels(gear)
        mesh = self.add("mesh", SpringDamper(c=float(gear.k), d=float(gear.c or 0.0)))
        self.attach(gear.parent.node, "mesh", mesh, "flange_a")
        self.join(("mesh", mesh, "flange_b"), ("gear", place, "flange_a"))
