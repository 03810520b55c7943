"""A model as a graph of networkx: parts and joints, as connected and as reduced."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from lumped.compiler.structure import Structure
from lumped.flattening.nets import SIGNAL, End, Net, Opened
from lumped.flattening.tree import Instance
from lumped.language.declared import ports_of, quantities_of

if TYPE_CHECKING:
    import networkx as nx

PART, JOINT = 0, 1
"""What a node is, as networkx marks the two sides of a bipartite graph."""


def connection_graph(
    structure: Structure, depth: int | None = None, *, reduced: bool = False
) -> nx.Graph:
    """Parts and joints of a model (see `System.graph`)."""
    return _Builder(structure, depth, reduced=reduced).build()


class _Builder:
    def __init__(self, structure: Structure, depth: int | None, *, reduced: bool) -> None:
        import networkx as nx

        flat = structure.flat
        self.structure, self.tree, self.reduced = structure, flat.tree, reduced
        self.opened = Opened(flat.tree, flat.joints, depth)
        self.states: dict[int, list[str]] = defaultdict(list)
        self.lost: dict[int, dict[str, str]] = defaultdict(dict)
        self.led: dict[int, list[str]] = defaultdict(list)
        self.graph = nx.Graph(name=flat.name, left_out=tuple(structure.left_out))
        self.still = self._find_still()
        self._place_states()

    def _find_still(self) -> set[int]:
        """Nodes of positions that never change, such as that of a housing."""
        values, reduced = self.structure.values, self.structure.reduced
        quantities = self.tree.quantities
        places = [q.kind == "potential" and q.unit in ("rad", "m") for q in quantities]
        nodes = np.unique(reduced.nodes[np.array(places, dtype=bool) & (reduced.nodes >= 0)])
        if not len(nodes):
            return set()
        moving = ca.vertcat(values.states, values.time, values.modes, values.guesses)
        moves = ca.which_depends(values.of(nodes.tolist()), moving, 1, True)
        return set(nodes[~np.array(moves, dtype=bool)].tolist())

    def _place_states(self) -> None:
        """States, and those that are left out and why, by the parts that declare them."""
        structure, used = self.structure, set(self.structure.states)
        why = {item.what: item.why for item in structure.left_out}
        for state in structure.reduced.states:
            number, order = structure.reduced.class_and_order(state)
            base = structure.members[state if state in structure.members else state - order]
            part, name = self.tree.number_of_unknown(base), structure.node_name(state)
            while part not in self.opened.parts and part not in self.opened.composites:
                part = self.tree.instances[part].parent
            if state in used:
                self.states[part].append(name)
                self.led[number].append(name)
            else:
                self.lost[part][name] = why.get(name, "")

    def build(self) -> nx.Graph:
        nets = self.opened.find_nets()
        met = {(end.part, end.name) for net in nets for end in net.ends}
        acting = {end.part for net in nets for end in net.ends if not end.exposed}
        parts = self.opened.parts
        for part in sorted(acting | parts.keys() | self.states.keys() | self.lost.keys()):
            self._add_part(part)
        for net in nets:
            self._add_joint(net)
        for part in parts:
            for name, port in ports_of(self.tree.instances[part].component).items():
                if (part, name) not in met:
                    role = "support" if port.grounded else "line"
                    self._add_joint(Net(port.kind, [End(part, name, role)]))
        return self.graph

    def _add_part(self, part: int) -> None:
        node = self.tree.instances[part]
        numbers, given = self.structure.parameters.numbers, self.tree.input_parameters
        places = {name: node.first_parameter + i for name, i in node.layout.parameters.items()}
        places |= {n: given[node.name(n)] for n in node.layout.names if node.name(n) in given}
        declared = quantities_of(node.component)
        self.graph.add_node(
            node.path,
            bipartite=PART,
            kind=type(node.component).__name__,
            parameters={n: (float(numbers[i]), declared[n].unit) for n, i in places.items()},
            quantities={n: q.unit for n, q in declared.items() if n not in places},
            states=tuple(self.states.get(part, ())),
            left_out=self.lost.get(part, {}),
        )

    def _add_joint(self, net: Net) -> None:
        """Add a joint with the edges to its parts, or to what moves as it does."""
        graph, reduced = self.graph, self.structure.reduced
        end = next((end for end in net.ends if not end.exposed), net.ends[0])
        first, name = self.tree.instances[end.part], self.opened.name(end)
        unknown = self._unknown(first, end.name)
        remains = reduced.node(unknown)
        equal = None if remains is None else self.structure.node_name(remains)
        still = net.kind != SIGNAL and (remains is None or remains in self.still)
        if self.reduced and net.kind != SIGNAL:
            name = f"ground ({net.kind})" if still or equal is None else equal
        if name not in graph:
            quantities = self.tree.quantities[unknown : unknown + 1 + (net.kind != SIGNAL)]
            names = first.layout.names[unknown - first.first_unknown :]
            number = -1 if remains is None else reduced.class_and_order(remains)[0]
            graph.add_node(
                name,
                bipartite=JOINT,
                kind=net.kind,
                quantities={
                    n.rpartition(".")[2]: q.unit for n, q in zip(names, quantities, strict=False)
                },
                ports=[],
                equal=equal,
                still=still,
                states=tuple(self.led.get(number, ())),
            )
        graph.nodes[name]["ports"] += map(self.opened.name, net.ends)
        for end in net.ends:
            if not end.exposed:
                path = self.tree.instances[end.part].path
                edge: dict[str, Any] = graph.get_edge_data(path, name, {"ports": {}})
                graph.add_edge(path, name, ports=edge["ports"] | {end.name: end.role})

    def _unknown(self, node: Instance, name: str) -> int:
        """Number of a signal, or of the potential of a port."""
        layout = node.layout
        local = layout.unknowns.get(name)
        if local is None:
            local = 2 * layout.ports.index(name)
        return node.first_unknown + local
