"""Alias elimination: quantities that are equal up to sign and time derivative become one.

``der(phi) == w`` makes w the first derivative of phi, ``flange_a.tau == -flange_b.tau`` makes one
torque of two. Rigidly joined inertias thereby share one motion before any index reduction.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lumped.flattening.flat_model import FlatModel
from lumped.support.sparse_graph import find_sets

Row = list[tuple[int, int, float]]
"""Terms of a sum that is zero: unknown, order of derivative, coefficient."""


@dataclass(frozen=True, eq=False)
class Aliases:
    """Classes of equal quantities.

    Attributes
    ----------
    classes : ndarray of int, shape (unknowns,)
        Class of each unknown, -1 if it is zero.
    shifts : ndarray of int, shape (unknowns,)
        The unknown is this derivative of its class,
    signs : ndarray, shape (unknowns,)
        times this sign.
    count : int
        Number of classes.
    kept_equations, kept_sums : ndarray of bool
        Component equations and flow sums that were not used up.
    used : list of tuple (str, int)
        Equations used up: kind (``"equation"``, ``"sum"``, ``"equal"`` or ``"ground"``) and number.
    """

    classes: np.ndarray
    shifts: np.ndarray
    signs: np.ndarray
    count: int
    kept_equations: np.ndarray
    kept_sums: np.ndarray
    used: list[tuple[str, int]]


class _Union:
    """Union-find whose links carry a sign and a number of time derivatives; 0 is zero.

    Parameters
    ----------
    count : int
        Number of unknowns.
    equal : ndarray of int, shape (k, 2)
        Pairs that are equal to begin with.
    """

    def __init__(self, count: int, equal: np.ndarray) -> None:
        label = find_sets(equal, count)
        least = np.full(count, count)
        np.minimum.at(least, label, np.arange(count))
        self.parent: list[int] = least[label].tolist()
        self.shift = [0] * count
        self.sign = [1] * count
        self.zero = [False] * count

    def find(self, u: int) -> tuple[int, int, int]:
        """Root of u, and (shift, sign) so that u == sign * root^(shift)."""
        parent, shift, sign = self.parent, self.shift, self.sign
        if parent[parent[u]] == parent[u]:
            return parent[u], shift[u], sign[u]
        path = []
        while parent[u] != u:
            path.append(u)
            u = parent[u]
        root, total, product = u, 0, 1
        for v in reversed(path):
            total, product = total + shift[v], product * sign[v]
            parent[v], shift[v], sign[v] = root, total, product
        return root, total, product

    def find_all(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Roots, shifts and signs of all unknowns."""
        parent, shift, sign = (np.array(own, int) for own in (self.parent, self.shift, self.sign))
        while (parent[parent] != parent).any():
            shift, sign = shift + shift[parent], sign * sign[parent]
            parent = parent[parent]
        return parent, shift, sign

    def reduce(self, row: Row) -> dict[tuple[int, int], float]:
        """The row in terms of roots, zeros and cancelled terms left out."""
        terms: dict[tuple[int, int], float] = {}
        zero, find = self.zero, self.find
        for u, order, coefficient in row:
            root, shift, sign = find(u)
            if zero[root]:
                continue
            key = (root, order + shift)
            total = terms.get(key, 0.0) + sign * coefficient
            if abs(total) > 1e-14:
                terms[key] = total
            else:
                terms.pop(key, None)
        return terms

    def absorb(self, row: Row) -> bool:
        """Use the row up as an alias if it is one."""
        if len(row) == 2:  # nearly all are, and most of them join two roots
            (u, i, c), (v, j, d) = row
            (a, shift_a, sign_a), (b, shift_b, sign_b) = self.find(u), self.find(v)
            if a != b and not (self.zero[a] or self.zero[b]):
                return self._join(a, i + shift_a, sign_a * c, b, j + shift_b, sign_b * d)
        terms = self.reduce(row)
        if len(terms) == 1:
            (root, order) = next(iter(terms))
            self.zero[root] = self.zero[root] or order == 0
            return order == 0
        if len(terms) != 2:
            return False
        ((a, i), c), ((b, j), d) = terms.items()
        return a != b and self._join(a, i, c, b, j, d)

    def _join(self, a: int, i: int, c: float, b: int, j: int, d: float) -> bool:
        """Use up ``c a^(i) + d b^(j) == 0`` of two roots if one is the other's derivative."""
        if abs(c) != abs(d) or (i > 0 and j > 0):
            return False
        if i > 0:
            a, i, b, j = b, j, a, i
        if i == j and b > a:
            a, b = b, a
        # here i == 0: root a equals -+ the j-th derivative of root b
        self.parent[a], self.shift[a] = b, j
        self.sign[a] = 1 if c * d < 0 else -1
        return True


def eliminate_aliases(flat: FlatModel) -> Aliases:
    """Join all quantities that simple equations make equal.

    Sums of two terms with coefficients of equal magnitude, and single terms equal to zero, are
    used up; everything else stays an equation. An equation that would join a quantity with
    itself stays too, so that the structural check finds it.
    """
    joints = flat.joints
    equal = np.array([(a, b) for a, b, _ in joints.equal], dtype=int).reshape(-1, 2)
    union = _Union(flat.tree.unknown_count, equal)
    used = [("equal", k) for k in range(len(equal))]
    waiting: list[tuple[str, int, Row]] = [
        ("ground", k, [(u, 0, 1.0)]) for k, (u, _) in enumerate(joints.grounded)
    ]
    waiting += [
        ("sum", k, [(u, 0, c) for u, c in zip(flows, signs, strict=True)])
        for k, (flows, signs, _) in enumerate(joints.sums)
    ]
    waiting += _candidates(flat)
    while True:
        left = []
        for kind, number, row in waiting:
            if union.absorb(row):
                used.append((kind, number))
            else:
                left.append((kind, number, row))
        if len(left) == len(waiting):
            break
        waiting = left
    kept = {
        "equation": np.ones(flat.equation_count, dtype=bool),
        "sum": np.ones(len(joints.sums), dtype=bool),
    }
    for kind, number in used:
        if kind in kept:
            kept[kind][number] = False
    roots, shifts, signs = union.find_all()
    alive = ~np.array(union.zero, dtype=bool)[roots]
    # numbered in the order of the first unknown of each
    _, firsts, places = np.unique(roots[alive], return_index=True, return_inverse=True)
    classes = np.full(len(roots), -1)
    classes[alive] = np.argsort(np.argsort(firsts))[places]
    kept_of = kept["equation"], kept["sum"]
    signs = signs * _orientations(flat, classes, shifts, signs)[classes]
    return Aliases(classes, shifts, signs.astype(float), len(firsts), *kept_of, used)


def _orientations(
    flat: FlatModel, classes: np.ndarray, shifts: np.ndarray, signs: np.ndarray
) -> np.ndarray:
    """Sign of the unknown after which each class is named: a variable before a port quantity."""
    other = np.array([q.kind != "variable" for q in flat.tree.quantities], dtype=bool)
    best = np.lexsort((shifts, other, classes))
    named, places = np.unique(classes[best], return_index=True)
    found = np.ones(len(named), dtype=int)
    found[: (named >= 0).sum()] = signs[best[places]][named >= 0]
    return found


def _candidates(flat: FlatModel) -> list[tuple[str, int, Row]]:
    found: list[tuple[str, int, Row]] = []
    for group in flat.groups:
        n = group.template.count
        for e in range(n):
            residual = group.template.residual(e)
            if not residual.homogeneous:
                continue
            orders, values = residual.orders.tolist(), residual.values.tolist()
            table = group.unknowns[:, residual.locals].tolist()
            for i, unknowns in enumerate(table):
                row = list(zip(unknowns, orders, values, strict=True))
                found.append(("equation", group.first_equation + i * n + e, row))
    return found
