"""What ties positions and speeds together: constraints as one function of all that they tie."""

from __future__ import annotations

from collections import defaultdict

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening.residual import VARYING
from lumped.reduction.diagnosis import equation_text
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once
from lumped.support.sparse_graph import find_sets


class Constraints:
    """Constraints of positions and speeds that hang together, and the nodes that they tie.

    Parameters
    ----------
    system : System
        From `assemble`.
    rows : list of (int, int)
        Equation of each constraint, and how often it is differentiated.
    nodes : list of int
        Nodes that occur in them, ascending.
    varying : bool
        Whether any coefficient varies.

    Attributes
    ----------
    rows, nodes, varying
        As given.
    level : ndarray of int, shape (rows,)
        Highest order of derivative in each.
    last : ndarray of int
        Constraints that are not differentiated any further.
    """

    def __init__(
        self, system: System, rows: list[tuple[int, int]], nodes: list[int], *, varying: bool
    ) -> None:
        self._system, structure = system, system.structure
        self.rows, self.nodes, self.varying = rows, nodes, varying
        reduced, flat = structure.reduced, structure.flat
        incidence = reduced.incidence
        place = np.full(int(reduced.first[-1]) + 1, len(nodes))  # the last one stands for zero
        place[nodes] = np.arange(len(nodes))
        z = ca.SX.sym("z", len(nodes))
        every, left = ca.vertcat(z, 0), ca.SX.zeros(len(rows))
        numbers = reduced.differentiations
        self.last = np.array([i for i, (e, k) in enumerate(rows) if k + 1 == numbers[e]])
        equations, orders = np.array(rows, dtype=int).T
        for places, seen in incidence.alike(equations, orders):
            group = seen.group
            own = place[reduced.nodes_of(seen)]
            m, n = own.shape
            count = len(group.template.modes)
            modes = group.first_mode + seen.instances[:, None] * count + np.arange(count)
            parameters = group.parameters[seen.instances].ravel().tolist()
            symbols = every[own.ravel().tolist()] * ca.DM(seen.signs.ravel().astype(float))
            arguments = [
                ca.reshape(symbols, n, m),
                ca.reshape(flat.parameters.values[parameters], -1, m),
                structure.values.time,
                ca.reshape(structure.values.modes[modes.ravel().tolist()], -1, m),
            ]
            left[places.tolist()] = ca.vec(seen.residual.value.map(m)(*arguments))
        sums = np.flatnonzero(equations >= incidence.first_sum)
        for row, node, sign in zip(*_sum_terms(system, equations[sums], orders[sums]), strict=True):
            left[int(sums[row])] += float(sign) * every[int(place[node])]
        inputs = [z, structure.parameters.theta, structure.values.time, structure.values.modes]
        slopes = ca.jacobian(left, z)
        self._entries = tuple(np.array(v, dtype=int) for v in slopes.sparsity().get_triplet())
        self._call = ArrayFunction(ca.Function("constraints", inputs, [ca.densify(left), slopes]))
        order = np.array([reduced.class_and_order(node)[1] for node in self.nodes], dtype=int)
        self.level = np.zeros(len(self.rows), dtype=int)
        np.maximum.at(self.level, self._entries[0], order[self._entries[1]])

    def __call__(
        self, z: np.ndarray, theta: np.ndarray, time: float, modes: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What each constraint misses, and the derivatives by what is tied."""
        value, nonzeros = self._call(z, theta, time, modes)
        matrix = np.zeros((len(self.rows), len(self.nodes)))
        matrix[self._entries] = nonzeros
        return value, matrix

    def touched(self, rows: np.ndarray) -> list[int]:
        """Places of the nodes in some constraints."""
        return sorted(set(self._entries[1][np.isin(self._entries[0], rows)].tolist()))

    def text(self, row: int) -> str:
        """A constraint as the user wrote it, and where."""
        equation, order = self.rows[row]
        incidence = self._system.structure.reduced.incidence
        what = equation_text(incidence, *incidence.origin(equation))
        times = ("", "once", "twice")[min(order, 2)]
        return what + (f", differentiated {times}" if order else "")


def _sum_terms(
    system: System, sums: np.ndarray, orders: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Terms of flow sums: place of the sum, node, sign."""
    reduced = system.structure.reduced
    places, classes, shifts, signs = reduced.incidence.sum_terms(sums)
    return places, reduced.first[classes] + shifts + orders[places], signs


def declared_followers(system: System) -> set[int]:
    """Tied nodes that are no states and have declared values, which may not hold."""
    reduced = system.structure.reduced
    declared = (reduced.node(unknown) for unknown in system.structure.flat.starts)
    tied = reduced.tied - set(reduced.states)
    return {node for node in declared if node is not None and node in tied}


@made_once
def constraints_of(system: System) -> list[Constraints]:
    """Constraints that vary, or tie what has a declared start and is no state.

    Each entry holds those that hang together.
    """
    reduced = system.structure.reduced
    incidence, numbers = reduced.incidence, reduced.differentiations
    rows = [(e, k) for e in np.flatnonzero(numbers).tolist() for k in range(numbers[e])]
    if not rows:
        return []
    equations, orders = np.array(rows, dtype=int).T
    varies = np.zeros(len(rows), dtype=bool)
    pairs = []
    for places, seen in incidence.alike(equations, orders):
        nodes = reduced.nodes_of(seen)
        varies[places] = (seen.residual.kinds == VARYING).any()
        pairs.append((np.repeat(places, nodes.shape[1]), nodes.ravel()))
    sums = np.flatnonzero(equations >= incidence.first_sum)
    places, nodes, _ = _sum_terms(system, equations[sums], orders[sums])
    pairs.append((sums[places], nodes))
    row, node = (np.concatenate(part) for part in zip(*pairs, strict=True))
    row, node = row[node < reduced.first[-1]], node[node < reduced.first[-1]]
    count = len(rows) + int(reduced.first[-1])
    owner = find_sets(np.column_stack([row, len(rows) + node]), count)
    wanted = set(owner[: len(rows)][varies].tolist())
    wanted |= {int(owner[len(rows) + node]) for node in declared_followers(system)}
    own, tied = defaultdict[int, list[int]](list), defaultdict[int, set[int]](set)
    for i, number in enumerate(owner[: len(rows)].tolist()):
        own[number].append(i)
    for number, n in zip(owner[row].tolist(), node.tolist(), strict=True):
        tied[number].add(n)
    return [
        Constraints(
            system,
            [rows[i] for i in own[number]],
            sorted(tied[number]),
            varying=bool(varies[own[number]].any()),
        )
        for number in sorted(wanted)
    ]
