"""Redundant constraints of linkages: dependent on each other wherever the linkage moves.

That is seen at positions that meet the constraints only, as a third crank of a parallelogram is one
more constraint anywhere else. Nothing tells how such constraints share a load, so they are refused.
A singular position, from which a motion leads to regular ones, is none.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SingularModelError
from lumped.reduction.diagnosis import list_each_once, list_equations
from lumped.reduction.open_loops import OpenLoops
from lumped.support.made_once import made_once

_DEPENDENT = 1e-8
"""Smallest singular value of independent constraints, relative to the largest."""
_MET = 1e-12
_MOST = 50
_MOVE = 0.05
"""Length of a motion to a neighbouring position, in m and rad."""


class _Constraints(NamedTuple):
    """What linkages demand.

    Attributes
    ----------
    rows : list of int
        The equations.
    columns : list of int
        Places, in guesses and states, of what occurs in them.
    function : Function
        What is left of the equations, and its derivatives by what occurs.
    """

    rows: list[int]
    columns: list[int]
    function: ca.Function


@made_once
def _constraints(system: System) -> _Constraints:
    loops = OpenLoops(system.structure.reduced)
    rows, parts = loops.list_constraints()
    left = ca.vertcat(ca.SX(0, 1), *parts)
    candidates = ca.vertcat(loops.guesses, loops.states)
    matrix = ca.jacobian(left, candidates)
    columns = sorted(set(matrix.sparsity().get_triplet()[1]))
    inputs = [candidates, system.structure.flat.parameters.theta, loops.time, loops.modes]
    function = ca.Function("constraints", inputs, [left, matrix[:, columns]])
    return _Constraints(rows, columns, function)


@made_once
def _independent(system: System) -> list[bytes]:
    """The last parameters for which constraints were independent."""
    return []


def refuse_redundant(
    system: System,
    x: np.ndarray,
    theta: np.ndarray,
    modes: np.ndarray,
    guesses: np.ndarray,
    time: float,
) -> None:
    """Refuse constraints that are redundant near a position.

    Parameters
    ----------
    system : System
        From `assemble`.
    x, theta : ndarray
        All states, and parameters.
    modes, guesses : ndarray
        Modes, and values of implicit quantities.
    time : float
        Instant, s.

    Raises
    ------
    SingularModelError
        With the constraints of which multiples add up to nothing.
    """
    constraints, known = _constraints(system), _independent(system)
    if not constraints.rows or known == [theta.tobytes()]:
        return
    begin = np.concatenate([guesses, x])

    def look(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        full = begin.copy()
        full[constraints.columns] = z
        left, matrix = (part.full() for part in constraints.function(full, theta, time, modes))
        size = np.linalg.norm(matrix, axis=1)
        size[size == 0] = 1.0
        return left.ravel() / size, matrix / size[:, None]

    rng = np.random.default_rng(2)
    z = begin[constraints.columns]
    seen = []
    for _ in range(3):
        met = _meet(look, z)
        if met is None:
            return
        U, sizes, V = np.linalg.svd(look(met)[1], full_matrices=False)
        rank = int((sizes > _DEPENDENT * sizes[0]).sum())
        seen.append((U[:, rank:], sizes, rank))
        if rank == len(sizes):
            known[:] = [theta.tobytes()]
            return
        motion = rng.normal(size=len(z))
        motion -= V[:rank].T @ (V[:rank] @ motion)
        z = met + _MOVE * motion / np.linalg.norm(motion)
    shares, sizes, rank = seen[0]
    share = np.linalg.norm(shares, axis=1)
    incidence = system.structure.reduced.incidence
    rows = sorted(np.array(constraints.rows)[share > 1e-6].tolist())
    owners = [incidence.flat.origin(incidence.origin(row)[1])[0] for row in rows]
    parts = list_each_once(owner.path or owner.label for owner in owners)
    raise SingularModelError(
        f"{system.name}: of {len(sizes)} constraints of linkages only {rank} are independent, at "
        f"the start and where it moves from there: {len(z) - rank} motions are left, not "
        f"{len(z) - len(sizes)}. Singular values of their derivatives are {sizes[rank]:.1g} and "
        f"below, then {sizes[rank - 1]:.3g} to {sizes[0]:.3g}. Of these constraints, multiples add "
        f"up to nothing:\n{list_equations(incidence, rows)}\n"
        f"Nothing tells how {parts} share the load. Remove one of them, or make one elastic."
    )


def _meet(
    look: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], z: np.ndarray
) -> np.ndarray | None:
    """The position near another that meets constraints, redundant or not; None if none is found.

    Steps of Levenberg and Marquardt damped by what is left converge quadratically where the
    distance to the solutions is of its order (Fan and Yuan, Computing 74 (2005) 23).
    """
    for _ in range(_MOST):
        left, matrix = look(z)
        size = float(np.linalg.norm(left))
        if not np.isfinite(size):
            return None
        if size <= _MET * (1 + np.abs(z).max()):
            return z
        U, sizes, V = np.linalg.svd(matrix, full_matrices=False)
        z = z - V.T @ (sizes / (sizes**2 + size) * (U.T @ left))
    return None
