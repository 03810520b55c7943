"""Drives of other programs, whose elements stand between numbered nodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lumped import Component, Connection, compose, connect
from lumped.components.compliance import SpringDamper
from lumped.components.gearing.gears import Planetary
from lumped.components.inertia import Inertia

__all__ = ["NumberedNodes"]

Port = tuple[str, int, str]


class NumberedNodes:
    """Parts of a model, and what is joined: names of ports at each node and apart from nodes."""

    def __init__(self) -> None:
        self._inertias: dict[int, float] = {}
        self._parts: dict[str, list[Component]] = {}
        self._at: dict[int, list[Port]] = {}
        self._joined: list[list[Port]] = []

    def add(self, name: str, part: Component) -> int:
        """Number of a part among those of its name."""
        self._parts.setdefault(name, []).append(part)
        return len(self._parts[name]) - 1

    def attach(self, node: int, name: str, place: int, port: str) -> None:
        """Join a port of a part with a node."""
        self._at.setdefault(node, []).append((name, place, port))

    def join(self, *ends: Port) -> None:
        """Join ports apart from nodes."""
        self._joined.append([*ends])

    def add_inertia(self, node: int, inertia: float) -> None:
        """Inertia at a node, kg.m2, beside what it has."""
        self._inertias[node] = self._inertias.get(node, 0.0) + float(inertia)

    def add_shaft(
        self, ends: tuple[int, int], c: float, d: float, m: float, name: str = "shaft"
    ) -> None:
        """A spring with a damper, and the consistent inertia ``m [[2, 1], [1, 2]]`` of a shaft.

        Of this, ``m`` is at each end, and ``4 m`` turns with the mean of both ends.
        """
        place = self.add(name, SpringDamper(c=c, d=d))
        for node, port in zip(ends, ("flange_a", "flange_b"), strict=True):
            self.attach(node, name, place, port)
        if m:
            mean = self.add("mean", Planetary(ratio=1.0))
            middle = self.add("middle", Inertia(J=4 * m))
            self.join(("mean", mean, "carrier"), ("middle", middle, "flange_a"))
            for node, port in zip(ends, ("sun", "ring"), strict=True):
                self.add_inertia(node, m)
                self.attach(node, "mean", mean, port)

    def model(self) -> Component:
        """The model; ``node["3"]`` is all inertia at node 3."""
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
