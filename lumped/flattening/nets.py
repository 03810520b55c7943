"""Parts of a model that is opened down to a depth, and the nets in which their ends meet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from lumped.flattening.connection_sets import Joints
from lumped.flattening.tree import Tree
from lumped.language.declared import ports_of
from lumped.language.quantity import Input, Output

SIGNAL = "signal"


class End(NamedTuple):
    """A port or signal in a net.

    Attributes
    ----------
    part : int
        Number of the component in the tree.
    name : str
        Of the port or signal.
    role : str
        "line", "support", "in" or "out".
    exposed : bool
        The component is open and joins the net from inside alone: what is outside is unknown.
    """

    part: int
    name: str
    role: str
    exposed: bool = False


class Net(NamedTuple):
    """Ports or signals that are joined.

    Attributes
    ----------
    kind : str
        Kind of the ports, or "signal".
    ends : list of End
        In the order of their declaration.
    """

    kind: str
    ends: list[End]


class Opened:
    """A model whose composites are opened down to a depth.

    Parameters
    ----------
    tree : Tree
        Components of the model.
    joints : Joints
        Their connections.
    depth : int, optional
        Composites at this depth stay closed; default is to open all.

    Attributes
    ----------
    parts : dict of int to None
        Numbers of the components that are seen as one: those without parts, and closed ones.
    composites : dict of int to None
        Numbers of the open ones; the model is one of them.
    """

    def __init__(self, tree: Tree, joints: Joints, depth: int | None = None) -> None:
        self.tree, self.joints = tree, joints
        self.parts: dict[int, None] = {}
        self.composites: dict[int, None] = {}
        depths: list[int] = []
        for i, node in enumerate(tree.instances):
            up = node.parent
            depths.append(0 if up < 0 else depths[up] + 1)
            if up >= 0 and up not in self.composites:
                continue
            if (node.children or up < 0) and (depth is None or depths[i] < max(depth, 1)):
                self.composites[i] = None
            if i not in self.composites or not node.children:
                self.parts[i] = None

    def name(self, end: End) -> str:
        """Dotted name of a port or signal."""
        return self.tree.instances[end.part].name(end.name)

    def find_nets(self) -> list[Net]:
        """All nets with an end; ports that are left open are in none."""
        return [net for net in (*self._port_nets(), *self._signal_nets()) if net.ends]

    def _port_nets(self) -> Iterable[Net]:
        from networkx.utils import UnionFind

        tree = self.tree
        joined: dict[tuple[int, str, bool], int] = {}  # the last: seen from inside
        for g, (flows, signs, _) in enumerate(self.joints.sums):
            for flow, sign in zip(flows, signs, strict=True):
                if len(flows) > 1:
                    number = tree.number_of_unknown(flow)
                    node = tree.instances[number]
                    name = node.layout.ports[(flow - node.first_unknown) // 2]
                    joined[number, name, sign < 0] = g
        trunks = UnionFind()
        for number, name, inner in joined:
            through = number in self.composites and number not in self.parts
            if inner and through and (number, name, False) in joined:
                trunks.union(joined[number, name, True], joined[number, name, False])
        nets: dict[int, Net] = {}
        for (number, name, inner), g in joined.items():
            port = ports_of(tree.instances[number].component)[name]
            if number in self.parts:
                if inner:
                    continue
                end = End(number, name, "support" if port.grounded else "line")
            elif number in self.composites and (number, name, not inner) not in joined:
                end = End(number, name, "line", inner)
            else:
                continue
            nets.setdefault(trunks[g], Net(port.kind, [])).ends.append(end)
        return nets.values()

    def _signal_nets(self) -> Iterator[Net]:
        from networkx.utils import UnionFind

        tree = self.tree
        joined = UnionFind()
        for a, b, _ in self.joints.equal:
            if isinstance(tree.quantity(a), Input | Output):
                joined.union(a, b)
        members: dict[int, list[int]] = {}
        for unknown in joined:
            members.setdefault(joined[unknown], []).append(unknown)
        for group in members.values():
            net = Net(SIGNAL, [])
            numbers = [tree.number_of_unknown(u) for u in group]
            parents = [tree.instances[number].parent for number in numbers]
            for unknown, number, parent in zip(group, numbers, parents, strict=True):
                node = tree.instances[number]
                local = unknown - node.first_unknown
                name = node.layout.names[local]
                gives = isinstance(node.layout.quantities[local], Output)
                if number in self.parts:
                    net.ends.append(End(number, name, "out" if gives else "in"))
                elif number in self.composites:
                    within = number in parents
                    around = parents.count(parent) > 1 or parent in numbers
                    if within != around:
                        role = "out" if gives != within else "in"
                        net.ends.append(End(number, name, role, within))
            yield net
