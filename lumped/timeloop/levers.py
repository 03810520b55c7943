"""What the states of a run lead, and by how much more than they move themselves."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.numerics.least_change import least_change
from lumped.reduction.open_loops import OpenLoops
from lumped.support.made_once import made_once
from lumped.timeloop.guards import list_dependent

FAIR_LEVERAGE = 5.0
"""Ratio above which runs go on in redundant coordinates: errors of what follows are larger by it
than those of the states that lead."""
MOST_LEVERAGE = 1e3
"""Ratio above which a state does not lead."""
_MANY = 20
"""Leading states of each dependent node, on the average, up to which all of them are watched."""
_ELSEWHERE = 25
"""Points at which it is looked at for that."""


def may_be_unfit(system: System) -> bool:
    """Whether what a state leads varies at all."""
    return bool(levers(system, FAIR_LEVERAGE)[0])


@made_once
def levers(system: System, leverage: float) -> tuple[list[tuple[int, int]], ca.SX]:
    """Ratios of dependent positions to leading ones, and of speeds to speeds, over the greatest.

    Those of explicit formulas are relative to their typical size if that is above one, so that
    units do not count: a torque that follows a twist by 1e4 N.m/rad everywhere is well led.

    Parameters
    ----------
    leverage : float
        The greatest ratio for what follows by iteration.

    Returns
    -------
    pairs : list of (int, int)
        Nodes that follow and lead.
    ratios : SX, shape (pairs, 1)
        Above one where a state does not lead.
    """
    structure, nodes = system.structure, list_dependent(system)
    explicit = set(structure.reduced.dependent[: structure.reduced.explicit])
    ratios = _find_ratios(system, nodes)
    rows, columns = ratios.sparsity().get_triplet()
    entries = ca.vec(ca.SX(ratios.nz[:]))
    order = [structure.reduced.class_and_order(n)[1] for n in nodes]
    leading = [structure.reduced.class_and_order(n)[1] for n in structure.states]
    varying = [
        i
        for i in sorted(set(ca.jacobian_sparsity(entries, system.inputs[0]).get_triplet()[0]))
        if order[rows[i]] == leading[columns[i]]
    ]
    pairs = [(nodes[rows[i]], structure.states[columns[i]]) for i in varying]
    if not pairs:
        return [], ca.SX(0, 1)
    found, is_explicit = entries[varying], np.array([node in explicit for node, _ in pairs])
    if not structure.reduced.is_kinematic:
        leverage = MOST_LEVERAGE
    most = np.where(is_explicit, MOST_LEVERAGE, leverage)
    if not structure.implicit:
        typical = _typical(system, ca.Function("levers", system.inputs, [found]))
        most *= np.where(is_explicit, typical, 1.0)
    angles = _find_angles(system) if structure.reduced.is_kinematic else []
    pairs += [pair for pair, _ in angles]
    parts = found / ca.DM(most), *(angle / leverage for _, angle in angles)
    return pairs, ca.cse(ca.vertcat(*parts))


def _find_angles(system: System) -> list[tuple[tuple[int, int], ca.SX]]:
    """How near linkages are to positions in which their constraints depend on each other.

    For each linkage an implicit node, a state that leads it, and one over the sine of the least
    angle between one of its constraints and those before it.
    """
    structure, values, found = system.structure, system.structure.values, []
    closed = OpenLoops(structure.reduced)
    _, blocks = closed.list_constraints()
    own, symbols = (ca.vertcat(v.guesses, v.states, v.time, v.modes) for v in (closed, values))
    count = values.guesses.numel()
    nodes = [*structure.implicit, *structure.reduced.states]
    angles = symbols[[i for i, node in enumerate(nodes) if structure.is_angle(node)]]
    for left in blocks:
        slopes = ca.jacobian(left, own[: count + len(structure.reduced.states)])
        used = np.flatnonzero(np.diff(slopes.sparsity().colind()))
        states = used[used >= count] - count
        if left.numel() > 1 and len(states) and set(states.tolist()) <= set(structure.in_use):
            slopes = ca.substitute(slopes[:, used.tolist()], own, symbols)
            sine = ca.sqrt(least_change(slopes, left, np.ones(len(used)), angles)[1])
            pair = structure.implicit[used[0]], structure.reduced.states[states[0]]
            found.append((pair, structure.in_states(1 / sine)))
    return found


def _find_ratios(system: System, nodes: list[int]) -> ca.SX:
    """Derivatives of dependent nodes by the states; where these are many, by their own states.

    In a chain each body follows all states before it, through other dependent bodies. Where a
    block of equations is singular it is so in all directions, so those of the states that it has
    itself tell; one that has none follows those of the bodies that it follows.
    """
    structure, x = system.structure, system.inputs[0]
    found = structure.values.of(nodes)
    sparsity = ca.jacobian_sparsity(found, x)
    if sparsity.nnz() <= _MANY * len(nodes):
        return ca.jacobian(found, x)
    counts = np.diff(sparsity.T.colind())  # grow along a chain
    orders = np.array([structure.reduced.class_and_order(n)[1] for n in nodes])
    leading = np.array([structure.reduced.class_and_order(n)[1] for n in structure.states])
    ratios = ca.SX(len(nodes), len(leading))
    orders[np.isin(np.array(nodes) - 1, nodes) & (orders == 1)] = -1  # as their positions
    for order in np.unique(orders[orders >= 0]):
        rows, columns = np.flatnonzero(orders == order), np.flatnonzero(leading == order)
        rows = rows[np.lexsort((structure.reduced.block_of[np.array(nodes)[rows]], counts[rows]))]
        follows = found[rows.tolist()]
        own, cut = _cut_chains(ca.Function("follows", system.inputs, [follows]), system.inputs)
        by_state = ca.jacobian(own, x[columns.tolist()])
        has_none = np.diff(by_state.T.sparsity().colind()) == 0
        for i in np.flatnonzero(has_none).tolist():
            by_state[i, :] = ca.jacobian(own[i], cut) @ by_state
        ratios[rows.tolist(), columns.tolist()] = ca.substitute(by_state, cut, follows)
    return ca.cse(ratios)


def _cut_chains(function: ca.Function, inputs: list[ca.SX]) -> tuple[ca.SX, ca.SX]:
    """Results of a function by its inputs and by symbols of the results before them."""
    work: dict[int, ca.SX] = {}
    found: list[ca.SX] = []
    symbols = ca.SX.sym("f", function.numel_out(0))
    for k in range(function.n_instructions()):
        op, out = function.instruction_id(k), function.instruction_output(k)
        if op == ca.OP_CONST:
            work[out[0]] = ca.SX(function.instruction_constant(k))
            continue
        given = function.instruction_input(k)
        if op == ca.OP_INPUT:
            work[out[0]] = inputs[given[0]].nz[given[1]]
        elif op == ca.OP_OUTPUT:
            found.append(work[given[0]])
            work[given[0]] = symbols[out[1]]
        elif len(given) == 2:
            work[out[0]] = ca.SX.binary(op, work[given[0]], work[given[1]])
        else:
            work[out[0]] = ca.SX.unary(op, work[given[0]])
    return ca.vertcat(*found), symbols


def _typical(system: System, function: ca.Function) -> np.ndarray:
    """Middle size of ratios over random points, at least one."""
    n, settings = len(system.state_names), system.inputs[3].numel()
    rng = np.random.default_rng(6)
    points = rng.uniform(-1.0, 1.0, (n, _ELSEWHERE))
    theta = system.structure.parameters.defaults
    sizes = np.abs(np.asarray(function(points, theta, 0.0, np.zeros(settings))))
    found = [np.median(row[np.isfinite(row)]) if np.isfinite(row).any() else 1.0 for row in sizes]
    return np.maximum(1.0, found)
