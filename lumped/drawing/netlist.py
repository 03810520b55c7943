"""Contents of a schematic: components down to a depth, their frames, and the nets between them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from lumped.compiler.system import System
from lumped.flattening.connection_sets import Joints, join
from lumped.flattening.tree import Tree
from lumped.language.component import Component
from lumped.language.declared import ports_of
from lumped.language.quantity import Input, Output

SIGNAL = "signal"
PORT = "port"


@dataclass(eq=False)
class Item:
    """A component drawn as a symbol, or a port through which a frame is joined to the outside.

    Attributes
    ----------
    path : str
        Dotted path; of a port, that of the port.
    label : str
        Text beside the symbol.
    symbol, kind : str
        Name of the symbol, and of the component's class.
    place : int
        Number in declaration order.
    ports : tuple of str
        Its ports in the order of their declaration.
    grounded : dict of str to str
        Open ports that are grounded, and their kinds.
    """

    path: str
    label: str
    symbol: str
    kind: str
    place: int
    ports: tuple[str, ...] = ()
    grounded: dict[str, str] = field(default_factory=dict)


@dataclass(eq=False)
class Net:
    """Ports or signals that are joined.

    Attributes
    ----------
    kind : str
        Kind of the ports, or "signal".
    ends : list of (Item, str, str)
        Item, its port, and the port's role: "line", "support", "in" or "out".
    """

    kind: str
    ends: list[tuple[Item, str, str]]


@dataclass(eq=False)
class Frame:
    """A composite: its path, its items, and the frames inside it."""

    path: str
    label: str
    items: list[Item] = field(default_factory=list)
    frames: list[Frame] = field(default_factory=list)

    def chains(self) -> Iterator[list[Frame]]:
        """For this frame and each inside it, the frames from this one to it."""
        yield [self]
        for inner in self.frames:
            for chain in inner.chains():
                yield [self, *chain]

    def all_items(self) -> Iterator[Item]:
        """Items at every depth."""
        return (item for chain in self.chains() for item in chain[-1].items)


@dataclass(eq=False)
class Netlist:
    """Frames with their items, and the nets that join these."""

    name: str
    top: Frame
    nets: list[Net]


_Terminal = tuple[int, str, bool]  # node, name of the port or signal, seen from inside


def netlist(model: Component | System, depth: int | None = None) -> Netlist:
    """Items and nets of a model, composites opened down to a depth.

    Parameters
    ----------
    model : Component or System
        Model to show.
    depth : int, optional
        Composites at this depth are drawn as one symbol each; default is to open all.

    Raises
    ------
    ConnectError
        If the connections of a component are faulty.
    """
    if isinstance(model, System):
        tree, joints = model.structure.tree, model.structure.flat.joints
    else:
        tree = Tree(model)
        joints = join(tree)
    return _Builder(tree, joints, depth).build()


class _Builder:
    def __init__(self, tree: Tree, joints: Joints, depth: int | None) -> None:
        self.tree, self.joints = tree, joints
        self.number = {id(node): i for i, node in enumerate(tree.instances)}
        self.items: dict[int, Item] = {}
        self.frames: dict[int, Frame] = {}
        self.ports: dict[tuple[int, str], Item] = {}
        depths: list[int] = []
        for i, node in enumerate(tree.instances):
            up = node.parent
            depths.append(0 if up < 0 else depths[up] + 1)
            if up >= 0 and up not in self.frames:
                continue
            label = node.path.removeprefix(tree.instances[up].path).lstrip(".") if i else ""
            if (node.children or up < 0) and (depth is None or depths[i] < max(depth, 1)):
                frame = self.frames[i] = Frame(node.path, label)
                if up >= 0:
                    self.frames[up].frames.append(frame)
            if i not in self.frames or not node.children:
                cls = type(node.component)
                name, ports = cls.__name__, tuple(ports_of(node.component))
                item = Item(node.path, label or name, cls.symbol, name, i, ports)
                self.items[i] = item
                self.frames.setdefault(i if up < 0 else up, Frame("", "")).items.append(item)

    def build(self) -> Netlist:
        nets = [*self._port_nets(), *self._signal_nets()]
        for unknown, name in self.joints.grounded:
            node = self.tree.node_of_unknown(unknown)
            number = self.number[id(node)]
            port = name.rpartition(".")[2]
            item = self.items.get(number) or self.ports.get((number, port))
            if item is not None:
                item.grounded[port] = ports_of(node.component)[port].kind
        top = self.frames[0]
        return Netlist(type(self.tree.model).__name__, top, [n for n in nets if len(n.ends) > 1])

    def _edge(self, number: int, name: str) -> Item:
        """A port of an opened composite, drawn because it is open on one side."""
        if (number, name) not in self.ports:
            path = self.tree.instances[number].name(name)
            item = self.ports[number, name] = Item(path, name, PORT, PORT, number)
            self.frames[number].items.append(item)
        return self.ports[number, name]

    def _port_nets(self) -> Iterable[Net]:
        from networkx.utils import UnionFind

        tree = self.tree
        joined: dict[_Terminal, int] = {}
        for g, (flows, signs, _) in enumerate(self.joints.sums):
            for flow, sign in zip(flows, signs, strict=True):
                node = tree.node_of_unknown(flow)
                name = node.layout.ports[(flow - node.first_unknown) // 2]
                if len(flows) > 1:
                    joined[self.number[id(node)], name, sign < 0] = g
        trunks = UnionFind()
        for number, name, inner in joined:
            through = number in self.frames and number not in self.items
            if inner and through and (number, name, False) in joined:
                trunks.union(joined[number, name, True], joined[number, name, False])
        nets: dict[int, Net] = {}
        for (number, name, inner), g in joined.items():
            node = tree.instances[number]
            port = ports_of(node.component)[name]
            if number in self.items:
                if inner:
                    continue
                end = (self.items[number], name, "support" if port.grounded else "line")
            elif number in self.frames and (number, name, not inner) not in joined:
                end = (self._edge(number, name), name, "line")
            else:
                continue
            nets.setdefault(trunks[g], Net(port.kind, [])).ends.append(end)
        return nets.values()

    def _signal_nets(self) -> Iterable[Net]:
        from networkx.utils import UnionFind

        tree = self.tree
        joined = UnionFind()
        for a, b, _ in self.joints.equal:
            if isinstance(tree.quantity(a), Input | Output):
                joined.union(a, b)
        members: dict[int, list[int]] = {}
        for unknown in joined:
            members.setdefault(joined[unknown], []).append(unknown)
        nets = []
        for group in members.values():
            net = Net(SIGNAL, [])
            nodes = [tree.node_of_unknown(u) for u in group]
            inside = {node.parent for node in nodes}
            numbers = {self.number[id(node)] for node in nodes}
            for unknown, node in zip(group, nodes, strict=True):
                number = self.number[id(node)]
                name = node.layout.names[unknown - node.first_unknown]
                gives = isinstance(node.layout.quantities[unknown - node.first_unknown], Output)
                if number in self.items:
                    net.ends.append((self.items[number], name, "out" if gives else "in"))
                elif number in self.frames:
                    beside = sum(n.parent == node.parent for n in nodes) > 1
                    within, around = number in inside, beside or node.parent in numbers
                    if within != around:
                        role = "out" if gives != within else "in"
                        net.ends.append((self._edge(number, name), name, role))
            nets.append(net)
        return nets
