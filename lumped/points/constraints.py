"""What ties positions and speeds together: constraints as one function of all that they tie."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.flattening.residual import VARYING
from lumped.reduction.diagnosis import equation_text
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import made_once


class Constraints:
    """Constraints of positions and speeds, and the nodes that they tie.

    Attributes
    ----------
    nodes : list of int
        Nodes that are tied, ascending.
    rows : list of (int, int)
        Equation of each constraint, and how often it is differentiated.
    level : ndarray of int, shape (rows,)
        Highest order of derivative in each.
    last : ndarray of int
        Constraints that are not differentiated any further.
    varying : bool
        Whether any coefficient varies.
    """

    def __init__(self, system: System) -> None:
        self._system, structure = system, system.structure
        reduced, flat = structure.reduced, structure.flat
        incidence, self.nodes = reduced.incidence, sorted(reduced.tied)
        z, every = ca.SX.sym("z", len(self.nodes)), ca.SX.zeros(int(reduced.first[-1]) + 1)
        every[self.nodes] = z
        numbers = reduced.differentiations
        self.rows = [(e, k) for e in np.flatnonzero(numbers).tolist() for k in range(numbers[e])]
        self.last = np.array([i for i, (e, k) in enumerate(self.rows) if k + 1 == numbers[e]])
        self.varying, left = False, ca.SX.zeros(len(self.rows))
        equations, orders = np.array(self.rows, dtype=int).reshape(-1, 2).T
        for places, seen in incidence.alike(equations, orders):
            nodes, residual, group = reduced.nodes_of(seen), seen.residual, seen.group
            m, n = nodes.shape
            count = len(group.template.modes)
            modes = group.first_mode + seen.instances[:, None] * count + np.arange(count)
            parameters = group.parameters[seen.instances].ravel().tolist()
            symbols = every[nodes.ravel().tolist()] * ca.DM(seen.signs.ravel().astype(float))
            arguments = [
                ca.reshape(symbols, n, m),
                ca.reshape(flat.parameters.values[parameters], -1, m),
                structure.values.time,
                ca.reshape(structure.values.modes[modes.ravel().tolist()], -1, m),
            ]
            left[places.tolist()] = ca.vec(residual.value.map(m)(*arguments))
            self.varying |= bool((residual.kinds == VARYING).any())
        sums = np.flatnonzero(equations >= incidence.first_sum)
        places, classes, shifts, signs = incidence.sum_terms(equations[sums])
        for place, number, shift, sign in zip(places, classes, shifts, signs, strict=True):
            row = int(sums[place])
            left[row] += float(sign) * every[int(reduced.first[number] + shift + orders[row])]
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


@made_once
def constraints_of(system: System) -> Constraints:
    """Constraints of a system."""
    return Constraints(system)
