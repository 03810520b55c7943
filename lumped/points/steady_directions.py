"""Steady motion: what may go on changing at an equilibrium."""

from __future__ import annotations

import itertools

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.support.made_once import made_once
from lumped.timeloop.results.operating_point import OperatingPoint

_RADII = (2.0, 0.3, 1e-2, 1e-4)
_ROUNDING = 1e-12


def unsteady_part(point: OperatingPoint) -> scipy.sparse.csc_array:
    """What of the derivatives is no steady motion, as a projection of them.

    Steady is what positions do in directions in which neither a derivative nor a condition or gap
    that decides on derivatives depends on them: a play that opens is no steady motion. Positions
    are states with the unit of a port's potential, such as angles and twists; the derivatives are
    looked at in random points, wide apart and close to each other.

    Returns
    -------
    csc_array, shape (states, states)
    """
    system, count = point.system, len(point.x)
    layouts = {id(node.layout): node.layout for node in system.structure.tree.instances}
    units = {q.unit for t in layouts.values() for q in t.quantities if q.kind == "potential"}
    places = np.flatnonzero([_unit(system, node) in units for node in system.structure.states])
    directions = np.eye(len(places))
    deciding = _deciding(system)
    rng = np.random.default_rng(7)
    for radius, centre in itertools.product(_RADII, (np.zeros(count), point.x)):
        if not directions.shape[1]:
            return scipy.sparse.csc_array(scipy.sparse.eye_array(count))
        x = centre + rng.uniform(-radius, radius, count)
        matrix = system.jacobian(x, point.theta, point.time, point.settings)[0].full()
        slopes = deciding(x, point.theta, point.time, point.settings).full()
        matrix = np.vstack([matrix, slopes])
        matrix = matrix[np.isfinite(matrix).all(axis=1)]
        scale = np.maximum(np.abs(matrix).max(axis=1, initial=0.0), 1e-9)
        effects = (matrix[:, places] / scale[:, None]) @ directions
        effects = effects[(np.abs(effects) > _ROUNDING).any(axis=1)]
        if len(effects):
            directions = directions @ _null_space(effects)
            if directions.shape[1]:
                directions = scipy.linalg.qr(directions, mode="economic")[0]
    steady = directions @ directions.T
    alone = np.diag(steady) > 1 - 1e-9  # exactly, so that nothing of its rate is left
    steady[alone], steady[:, alone] = 0.0, 0.0
    steady[alone, alone] = 1.0
    change = np.eye(count)
    change[np.ix_(places, places)] -= np.where(np.abs(steady) > _ROUNDING, steady, 0.0)
    return scipy.sparse.csc_array(change)


@made_once
def _deciding(system: System) -> ca.Function:
    """Derivatives by the states of what decides on modes of the rates: conditions and gaps."""
    s, modes = system.switching, system.structure.values.modes
    used = set(ca.jacobian_sparsity(system.rates, modes).get_triplet()[1])
    numbers = [k for k, mode in enumerate(s.relation_modes.tolist()) if mode in used]
    gaps = np.flatnonzero(s.has_gap).tolist()
    found = ca.vertcat(s.greater[numbers] - s.less[numbers], s.gap[gaps])
    slopes = ca.jacobian(system.structure.in_states(found), system.inputs[0])
    return ca.Function("deciding", system.inputs, [slopes])


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """What a matrix maps to zero, as columns; by pivoted QR, much faster than singular values."""
    triangle, order = scipy.linalg.qr(matrix, mode="r", pivoting=True)
    rank = int((np.abs(np.diag(triangle)) > _ROUNDING).sum())
    found = np.zeros((matrix.shape[1], matrix.shape[1] - rank))
    found[order[:rank]] = -scipy.linalg.solve_triangular(
        triangle[:rank, :rank], triangle[:rank, rank:]
    )
    found[order[rank:]] = np.eye(found.shape[1])
    return found


def _unit(system: System, node: int) -> str | None:
    unknown = system.structure.members.get(node)
    return None if unknown is None else system.structure.tree.quantity(unknown).unit
