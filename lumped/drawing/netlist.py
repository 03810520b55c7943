"""Contents of a schematic: components down to a depth, their frames, and the nets between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from lumped.compiler.system import System
from lumped.flattening.connection_sets import Joints, join
from lumped.flattening.nets import SIGNAL as SIGNAL
from lumped.flattening.nets import End, Opened
from lumped.flattening.tree import Tree
from lumped.language.component import Component
from lumped.language.declared import ports_of

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
        self.opened = Opened(tree, joints, depth)
        self.items: dict[int, Item] = {}
        self.frames: dict[int, Frame] = {}
        self.ports: dict[tuple[int, str], Item] = {}
        for i in sorted(self.opened.parts | self.opened.composites):
            node, up = tree.instances[i], tree.instances[i].parent
            label = node.path.removeprefix(tree.instances[up].path).lstrip(".") if i else ""
            if i in self.opened.composites:
                frame = self.frames[i] = Frame(node.path, label)
                if up >= 0:
                    self.frames[up].frames.append(frame)
            if i in self.opened.parts:
                cls = type(node.component)
                name, ports = cls.__name__, tuple(ports_of(node.component))
                item = Item(node.path, label or name, cls.symbol, name, i, ports)
                self.items[i] = item
                self.frames.setdefault(i if up < 0 else up, Frame("", "")).items.append(item)

    def build(self) -> Netlist:
        nets = [
            Net(net.kind, [(self._item(end), end.name, end.role) for end in net.ends])
            for net in self.opened.find_nets()
        ]
        for unknown, name in self.joints.grounded:
            number = self.tree.number_of_unknown(unknown)
            port = name.rpartition(".")[2]
            item = self.items.get(number) or self.ports.get((number, port))
            if item is not None:
                item.grounded[port] = ports_of(self.tree.instances[number].component)[port].kind
        top = self.frames[0]
        return Netlist(type(self.tree.model).__name__, top, [n for n in nets if len(n.ends) > 1])

    def _item(self, end: End) -> Item:
        """The part of an end, or the port of an open composite, drawn as it is open on one side."""
        if end.part in self.items:
            return self.items[end.part]
        key = end.part, end.name
        if key not in self.ports:
            self.ports[key] = Item(self.opened.name(end), end.name, PORT, PORT, end.part)
            self.frames[end.part].items.append(self.ports[key])
        return self.ports[key]
