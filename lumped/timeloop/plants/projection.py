"""Projection of redundant coordinates to their constraints, after each step of a run.

Redundant coordinates meet their constraints as long as the rates are exact; steps leave them by
their errors. The least change in nominal sizes brings them back, of positions first, then of speeds
(Eich, SIAM Journal on Numerical Analysis 30 (1993) 1467; Hairer and Wanner, Solving Ordinary
Differential Equations II, VII.2). Errors inside the constraints remain, and they alone.
"""

from __future__ import annotations

import itertools

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.numerics.least_change import least_change
from lumped.timeloop.nominal_sizes import nominals


def companions(system: System) -> tuple[np.ndarray, np.ndarray]:
    """States of the same order and unit that share an invariant with each state.

    Returns
    -------
    first, companion : ndarray of int
        Those of state i are ``companion[first[i] : first[i + 1]]``.
    """
    structure = system.structure
    left = structure.in_states(structure.invariants)
    touch = ca.jacobian_sparsity(left, system.inputs[0])
    # of a symmetric pattern, rows and columns may change places
    b, a = (np.array(i, dtype=int) for i in ca.mtimes(touch.T, touch).get_triplet())
    order = [structure.reduced.class_and_order(n)[1] for n in structure.states]
    unit = [system.quantity(n).unit if "(" not in n else n for n in system.state_names]
    kinds = list(zip(order, unit, strict=True))
    alike = np.array([kinds[i] == kinds[j] for i, j in zip(a, b, strict=True)], dtype=bool)
    first = np.searchsorted(a[alike], np.arange(len(structure.states) + 1))
    return first, b[alike]


def _find_sizes(system: System) -> np.ndarray:
    """Nominal sizes, the same for all companions: a twist of a spring is an angle like others.

    If it hardly moved, constraints would seem to depend on each other where they do not.
    """
    sizes, (first, companion) = nominals(system), companions(system)
    shared = [sizes[companion[a:b]].max(initial=0.0) for a, b in itertools.pairwise(first)]
    found: np.ndarray = np.maximum(sizes, shared)
    return found


def projection(system: System) -> ca.Function:
    """Change of the states that meets constraints to first order, and how independent these are.

    Returns
    -------
    Function
        (x, p, t, m) -> (n + 1,); last the least share of a constraint, squared, that is at right
        angles to those eliminated before it.
    """
    structure, x = system.structure, system.inputs[0]
    left = structure.in_states(structure.invariants)
    orders = np.array([structure.reduced.class_and_order(n)[1] for n in structure.states])
    rows, columns = ca.jacobian_sparsity(left, x).get_triplet()
    level = np.zeros(left.numel(), dtype=int)
    np.maximum.at(level, np.array(rows, dtype=int), orders[list(columns)])
    change, sizes, least = ca.SX.zeros(x.numel()), _find_sizes(system), ca.SX(1)
    angles = x[[i for i, node in enumerate(structure.states) if structure.is_angle(node)]]
    for order in np.unique(level):
        own, free = np.flatnonzero(level == order), np.flatnonzero(orders == order).tolist()
        part = left[own.tolist()]
        slopes, rest = ca.jacobian(part, x[free]), part + ca.jtimes(part, x, change)
        change[free], now = least_change(slopes, rest, sizes[free], angles)
        least = ca.fmin(least, now)
    found = ca.vertcat(ca.densify(change), least)
    return ca.Function("projection", system.inputs, [ca.cse(found)])
