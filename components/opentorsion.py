"""Drives that were entered for openTorsion.

Source: openTorsion 0.3.2, the matrices of its elements (aalto-arotor/openTorsion).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lumped import Component, Connection, compose, connect
from lumped.components.compliance import Damper, SpringDamper
from lumped.components.gears import IdealGear, Planetary
from lumped.components.inertia import Inertia
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
        drive.add_shaft(shaft)
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


class _Drive:
    """Parts of a model, and what is joined: names of ports at each node and apart from nodes."""

    def __init__(self) -> None:
        self._inertias: dict[int, float] = {}
        self._parts: dict[str, list[Component]] = {}
        self._at: dict[int, list[tuple[str, int, str]]] = {}
        self._joined: list[list[tuple[str, int, str]]] = []

    def _add(self, name: str, part: Component) -> int:
        self._parts.setdefault(name, []).append(part)
        return len(self._parts[name]) - 1

    def _attach(self, node: int, name: str, place: int, port: str) -> None:
        self._at.setdefault(node, []).append((name, place, port))

    def add_inertia(self, node: int, inertia: float) -> None:
        self._inertias[node] = self._inertias.get(node, 0.0) + float(inertia)

    def add_shaft(self, shaft: Any) -> None:
        place = self._add("shaft", SpringDamper(c=float(shaft.k), d=float(shaft.c)))
        ends = (shaft.nl, shaft.nr)
        for node, port in zip(ends, ("flange_a", "flange_b"), strict=True):
            self._attach(node, "shaft", place, port)
        if m := float(shaft.mass):
            mean = self._add("mean", Planetary(ratio=1.0))
            middle = self._add("middle", Inertia(J=4 * m))
            self._joined.append([("mean", mean, "carrier"), ("middle", middle, "flange_a")])
            for node, port in zip(ends, ("sun", "ring"), strict=True):
                self.add_inertia(node, m)
                self._attach(node, "mean", mean, port)

    def add_disc(self, disc: Any) -> None:
        if disc.k:
            raise DeclarationError(
                f"from_opentorsion: the disc at node {disc.node} has the stiffness k = {disc.k:g} "
                "N.m/rad, which openTorsion leaves out of its matrices. Set it to 0, and add a "
                "shaft to a fixed flange here if it is meant."
            )
        self.add_inertia(disc.node, disc.I)
        if disc.c:
            damper = self._add("damper", Damper(d=float(disc.c)))
            housing = self._add("housing", Fixed())
            self._attach(disc.node, "damper", damper, "flange_a")
            self._joined.append([("damper", damper, "flange_b"), ("housing", housing, "flange")])

    def add_gear(self, gear: Any) -> None:
        self._attach(gear.parent.node, "gear", self._wheels(gear), "flange_a")

    def _wheels(self, gear: Any) -> int:
        place = self._add("gear", IdealGear(ratio=-float(gear.R) / float(gear.parent.R)))
        self._attach(gear.node, "gear", place, "flange_b")
        return place

    def add_mesh(self, gear: Any) -> None:
        if not gear.k:
            raise DeclarationError(
                f"from_opentorsion: the elastic gear at node {gear.node} has no stiffness; give k, "
                "N.m/rad, or take a Gear."
            )
        place = self._wheels(gear)
        mesh = self._add("mesh", SpringDamper(c=float(gear.k), d=float(gear.c or 0.0)))
        self._attach(gear.parent.node, "mesh", mesh, "flange_a")
        self._joined.append([("mesh", mesh, "flange_b"), ("gear", place, "flange_a")])

    def model(self) -> Component:
        nodes = {str(n): Inertia(J=J) for n, J in sorted(self._inertias.items()) if J}

        def connections(model: Any) -> Iterator[Connection]:
            def port(name: str, place: int, end: str) -> Any:
                return getattr(getattr(model, name)[place], end)

            for ends in self._joined:
                yield connect(*(port(*end) for end in ends))
            for number, ends in self._at.items():
                ports = [port(*end) for end in ends]
                if str(number) in nodes:
                    ports.append(model.node[str(number)].flange_a)
                if len(ports) > 1:
                    yield connect(*ports)

        members: dict[str, Any] = {"node": nodes, **self._parts}
        return compose(**members, connections=connections)
