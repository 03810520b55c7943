"""Connections: which ports and signals meet in one node of the model."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from lumped.errors import ConnectError, EquationError, told_by
from lumped.flattening.tree import Instance, Tree
from lumped.language.component import Component
from lumped.language.connection import label
from lumped.language.declared import values_of
from lumped.language.expression import Ref
from lumped.language.port import Connection, Port
from lumped.language.quantity import Input, Output
from lumped.support.sparse_graph import find_sets


@dataclass
class Joints:
    """Result of joining all connections of a model.

    Attributes
    ----------
    equal : list of (int, int, str)
        Unknowns that are equal by a connection, and the connection's text.
    sums : list of (list of int, list of float, str)
        Flows and their signs that sum to zero, and the node's text.
    grounded : list of (int, str)
        Potentials that are zero because their port is left open and grounds itself.
    inside : set of int
        Ports of composites that are connected inside (by port number).
    driven : set of int
        Outputs of composites that are driven from inside (by unknown number).
    """

    equal: list[tuple[int, int, str]] = field(default_factory=list)
    sums: list[tuple[list[int], list[float], str]] = field(default_factory=list)
    grounded: list[tuple[int, str]] = field(default_factory=list)
    inside: set[int] = field(default_factory=set)
    driven: set[int] = field(default_factory=set)


class _End(NamedTuple):
    """One side of a port in a connection."""

    node: Instance
    port: int
    sign: int


def join(tree: Tree) -> Joints:
    """Resolve the connections of all composites.

    Raises
    ------
    ConnectError
        If a port that must be connected is not, or a signal has no or several sources.
    """
    pairs: list[tuple[int, int]] = []
    ends: dict[int, _End] = {}
    signals: list[tuple[int, int]] = []
    sides: dict[int, set[str]] = {}
    for node in tree.instances:
        if type(node.component).connections is Component.connections:
            continue
        with told_by(node.label, "connections()"):
            found: object = node.component.connections()
            found = list(found) if isinstance(found, Iterator) else found
        if not isinstance(found, Iterable):
            raise EquationError(
                f"{node.label}: connections() gave {found!r} back. Yield each connection: "
                "yield lumped.connect(...), or 'yield from' lumped.chain(...)."
            )
        for connection in found:
            if not isinstance(connection, Connection):
                raise EquationError(
                    f"{node.label}: connections() yielded {connection!r}; "
                    "yield lumped.connect(...) or 'yield from' lumped.chain(...)."
                )
            numbers = [
                _terminal(tree, node, e, ends)
                if isinstance(e, Port)
                else _signal(tree, node, e, sides)
                for e in connection.ends
            ]
            # all ends are of one kind
            found_pairs = pairs if isinstance(connection.ends[0], Port) else signals
            found_pairs += itertools.pairwise(numbers)
    for node in tree.instances:
        for port in range(len(node.layout.ports)):
            ends.setdefault(2 * (node.first_port + port), _End(node, port, 1))
    joints = Joints(inside={t // 2 for t in ends if t % 2})
    for group in _groups(list(ends), pairs):
        _tie(tree, [ends[t] for t in group], joints)
    _tie_signals(tree, signals, sides, joints)
    return joints


def _node(tree: Tree, scope: Instance, end: Port | Ref) -> Instance:
    """Component of an end, which must be the scope itself or a direct part of it."""
    node = tree.find(end.owner, scope)
    if node is None or not (node is scope or tree.instances[node.parent] is scope):
        raise ConnectError(
            f"{scope.label}: a connection names {label(end)} of a component "
            f"{type(end.owner).__name__} that is not one of its parts. Connect ports and signals "
            "of the component itself and of its direct parts."
        )
    return node


def _terminal(tree: Tree, scope: Instance, end: Port, ends: dict[int, _End]) -> int:
    node = _node(tree, scope, end)
    port = node.layout.ports.index(end.name)
    inner = node is scope
    number = 2 * (node.first_port + port) + inner
    ends.setdefault(number, _End(node, port, -1 if inner else 1))
    return number


def _signal(tree: Tree, scope: Instance, end: Ref, sides: dict[int, set[str]]) -> int:
    node = _node(tree, scope, end)
    number = node.first_unknown + node.layout.unknowns[end.name]
    is_input = isinstance(end.quantity, Input)
    gives = is_input == (node is scope)
    sides.setdefault(number, set()).add("source" if gives else "sink")
    if not gives and not is_input:
        sides[number].add("driven inside")
    return number


def _groups(items: list[int], pairs: list[tuple[int, int]]) -> list[list[int]]:
    if not items:
        return []
    items.sort()
    place = {t: i for i, t in enumerate(items)}
    joined = np.array([(place[a], place[b]) for a, b in pairs], dtype=int).reshape(-1, 2)
    labels = find_sets(joined, len(items))
    groups: list[list[int]] = [[] for _ in range(labels.max() + 1)]
    for item, group in zip(items, labels.tolist(), strict=True):
        groups[group].append(item)
    return sorted(groups)


def _tie(tree: Tree, members: list[_End], joints: Joints) -> None:
    """Join the ports of one node."""
    potentials = [m.node.first_unknown + 2 * m.port for m in members]
    flows = [potential + 1 for potential in potentials]
    signs = [float(m.sign) for m in members]
    if len(members) > 1:
        where = " = ".join(tree.port_name(m.node, m.port) for m in members[:4])
        where += " = ..." if len(members) > 4 else ""
        joints.equal += [(a, b, where) for a, b in itertools.pairwise(potentials)]
        joints.sums.append((flows, signs, where))
        return
    node, number = members[0].node, members[0].port
    port = tree.port(node, number)
    name = tree.port_name(node, number)
    if port.grounded:
        joints.grounded.append((potentials[0], name))
        return
    if not (port.free or node.parent < 0) and members[0].sign > 0:
        raise ConnectError(
            f"{name} of {node.label} is not connected. Connect it, or leave the component out; "
            "only ports declared free or grounded may stay open."
        )
    joints.sums.append((flows, signs, name))


def _tie_signals(
    tree: Tree, pairs: list[tuple[int, int]], sides: dict[int, set[str]], joints: Joints
) -> None:
    """Join signals, each to the one that feeds it."""
    for node in tree.instances:
        for name, local in node.layout.inputs.items():
            quantity = node.layout.quantities[local]
            number = node.first_unknown + local
            connected, bound = "sink" in sides.get(number, ()), name in values_of(node.component)
            if connected and bound:
                raise ConnectError(
                    f"{node.name(name)} is both connected and given a value; do only one."
                )
            if not connected and not bound:
                raise ConnectError(
                    f"{node.name(name)}: the input ({quantity.text}, {quantity.unit}) has no "
                    f"source. Connect an output to it, or give it: {name}=..., a number or an "
                    "expression of lumped.time."
                )
    for group in _groups(list(sides), pairs):
        sources = [n for n in group if "source" in sides[n] and "sink" not in sides[n]]
        if len(sources) != 1:
            listed = ", ".join(tree.unknown_name(n) for n in group)
            what = "no source" if not sources else f"{len(sources)} sources"
            raise ConnectError(
                f"Signals {listed} are joined but have {what}; exactly one output must feed them."
            )
        where = " = ".join(tree.unknown_name(n) for n in group[:4])
        joints.equal += [(a, b, where) for a, b in itertools.pairwise(group)]
    for n, roles in sides.items():
        if "driven inside" in roles and isinstance(tree.quantity(n), Output):
            joints.driven.add(n)
