"""Masses and inertias of a system that vary with its position or with the frequency."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.energies import sum_stored
from lumped.compiler.system import System
from lumped.support.arrays import Complex, Integer, Real
from lumped.support.made_once import made_once


@dataclass(frozen=True, eq=False)
class Masses:
    """Where the mass matrix of a system is no constant; elsewhere it is left the unit matrix.

    Attributes
    ----------
    rows, columns : ndarray of int, shape (m,)
        Places of its numbers among the states.
    count : int
        Number of states.
    """

    rows: Integer
    columns: Integer
    count: int

    @property
    def own(self) -> Integer:
        """States whose rows these are."""
        return np.unique(self.rows)

    def times(self, matrix: ca.SX, rates: ca.SX) -> ca.SX:
        """Rates, those of the states in M multiplied by M."""
        if not len(self.rows):
            return rates
        found, own = ca.SX(rates), self.own.tolist()
        found[own] = ca.mtimes(matrix[own, own], rates[own])
        return found

    @property
    def place(self) -> Integer:
        """Place of each state among these, shape (n,); zero for others."""
        found = np.zeros(self.count, dtype=int)
        found[self.own] = np.arange(len(self.own))
        return found

    def whole(self, numbers: Real) -> Real:
        """M from its numbers, shapes (..., m) to (..., own, own)."""
        place = self.place
        found: Real = np.zeros((*numbers.shape[:-1], len(self.own), len(self.own)))
        found[..., place[self.rows], place[self.columns]] = numbers
        return found

    def in_states(self, numbers: Real) -> Real:
        """M among all states, shapes (..., m) to (..., n, n)."""
        found: Real = np.zeros((*numbers.shape[:-1], self.count, self.count))
        rest = np.setdiff1d(np.arange(self.count), self.own)
        found[..., rest, rest] = 1.0
        found[..., self.rows, self.columns] = numbers
        return found

    def divide(self, numbers: Real, right: Complex) -> Complex:
        """``M^-1`` times vectors, shape (..., n)."""
        if not len(self.rows):
            return right
        found = right.copy()
        own = right[..., self.own]
        found[..., self.own] = np.linalg.solve(self.whole(numbers), own[..., None])[..., 0]
        return found

    def divide_matrix(
        self, numbers: Real, pattern: tuple[Integer, Integer], A: Real
    ) -> tuple[tuple[Integer, Integer], Real]:
        """Places and numbers of ``M^-1 A``, shapes (..., m) and (..., a) to (..., b)."""
        if not len(self.rows):
            return pattern, A
        rows, columns = pattern
        own, place = self.own, self.place
        mine = np.isin(rows, own)
        dense: Real = np.zeros((*A.shape[:-1], len(own), self.count))
        dense[..., place[rows[mine]], columns[mine]] = A[..., mine]
        dense = np.asarray(np.linalg.solve(self.whole(numbers), dense), dtype=float)
        uses = scipy.sparse.coo_array(
            (np.ones(mine.sum()), (place[rows[mine]], columns[mine])), shape=dense.shape[-2:]
        )
        links = scipy.sparse.coo_array(
            (np.ones(len(self.rows)), (place[self.rows], place[self.columns])), (len(own),) * 2
        )
        label = scipy.sparse.csgraph.connected_components(links, directed=False)[1]
        together = scipy.sparse.csr_array((label[:, None] == label[None, :]).astype(float))
        i, j = (together @ uses).tocoo().coords
        return (
            (np.append(rows[~mine], own[i]), np.append(columns[~mine], j)),
            np.concatenate([A[..., ~mine], dense[..., i, j]], axis=-1),
        )


@made_once
def masses(system: System) -> tuple[Masses, ca.SX]:
    """The mass matrix of a system, shape (n, n), where it varies; its other rows are empty.

    It is the second derivative of what components store (their method `stored`) by the speeds that
    are states. A component with a mass that varies, and without this method, counts with the mean
    of one over its mass.
    """
    x, theta, _, _ = system.inputs
    n, speeds = x.numel(), mechanical_states(system)[1].tolist()
    none = Masses(np.zeros(0, dtype=int), np.zeros(0, dtype=int), n), ca.SX(n, n)
    if not speeds:
        return none
    energy = system.structure.in_states(sum_stored(system))
    found = ca.cse(ca.hessian(energy, x)[0])[speeds, speeds]
    by = ca.vertcat(x, theta[system.structure.parameters.vibrating])
    rows, columns = (np.array(part, dtype=int) for part in found.sparsity().get_triplet())
    numbers = ca.sparsity_cast(found, ca.Sparsity.dense(found.nnz(), 1))
    varies = np.array(ca.which_depends(numbers, by, 1, True), dtype=bool)
    if not varies.any():
        return none
    links = scipy.sparse.coo_array((np.ones(len(rows)), (rows, columns)), (len(speeds),) * 2)
    label = scipy.sparse.csgraph.connected_components(links, directed=False)[1]
    chosen = np.flatnonzero(np.isin(label[rows], label[rows[varies]]))
    M = ca.SX(n, n)
    for k in chosen.tolist():
        M[speeds[rows[k]], speeds[columns[k]]] = numbers[k]
    i, j = M.sparsity().get_triplet()
    return Masses(np.array(i, dtype=int), np.array(j, dtype=int), n), M


def mechanical_states(system: System) -> tuple[Integer, Integer]:
    """Places of the states that are positions or angles, and of those that are speeds."""
    tree, members = system.structure.tree, system.structure.members
    units = np.array(
        [tree.quantity(members[n]).unit if n in members else "" for n in system.structure.states],
        dtype=str,
    )
    positions, speeds = (np.isin(units, pair) for pair in (("rad", "m"), ("rad/s", "m/s")))
    return np.flatnonzero(positions), np.flatnonzero(speeds)
