"""What a run must not pass over in silence."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.kernel.run import MOST_JUMP, Run
from lumped.support.made_once import made_once

_MANY = 20
"""Leading states of each dependent node, on the average, up to which all of them are watched."""
_ELSEWHERE = 25
"""Points at which it is looked at for that."""


def finite_fault(system: System, t: float, x: np.ndarray, rates: np.ndarray) -> str | None:
    """Derivatives that are not finite numbers."""
    bad = np.flatnonzero(~np.isfinite(rates))
    if not len(bad):
        return None
    names = system.state_names
    listed = ", ".join(f"{n} = {v:.6g}" for n, v in list(zip(names, x, strict=True))[:8])
    return (
        f"the derivative of {names[bad[0]]} is not a finite number at t = {t:g} s, where {listed}. "
        "A division by zero or a function outside its range; check the parameters and start "
        "values that enter it."
    )


def jump_fault(
    system: System,
    theta: np.ndarray,
    t: float,
    x: np.ndarray,
    before: np.ndarray,
    after: np.ndarray,
) -> str | None:
    """A position or speed that bodies would have to follow at a jump of the modes."""
    names, function = followers(system)
    if not names:
        return None
    old, new = (np.asarray(function(x, theta, t, m)).ravel() for m in (before, after))
    jump = np.abs(new - old) > MOST_JUMP * np.maximum(1.0, np.abs(old))
    if not jump.any():
        return None
    i = int(np.argmax(jump))
    return (
        f"{names[i]} would have to jump from {old[i] + 0.0:.6g} to {new[i] + 0.0:.6g} at "
        f"t = {t:g} s, because a prescribed motion jumps or has a kink there that a body or damper "
        "must follow. Prescribe a smoother motion (no jump of the angle or position, for bodies "
        "none of the speed either, behind a spring none of acceleration and jerk), or put a spring "
        "without damper in between."
    )


def set_twice_fault(system: System, run: Run) -> str:
    """Words for two `when` that set one state at the present instant of a run."""
    state, jumps = int(run.instant.set_twice), system.switching.jumps
    first, second = (
        f"{jumps[int(k)].name} when {jumps[int(k)].condition}"
        for k in (run.instant.set_by[state] - 1, run.instant.setting_again)
    )
    return (
        f"at t = {run.t:.9g} s two settings of {system.state_names[state]} meet: {first}, and "
        f"{second}. One of them would be lost. Write both as one `when`, or conditions of which "
        "only one becomes true at an instant."
    )


def shrinking_fault(
    system: System,
    theta: np.ndarray,
    t: float,
    x: np.ndarray,
    rates: np.ndarray,
    settings: np.ndarray,
    scale: np.ndarray,
) -> str:
    """Why steps became too small: what the present point tells, and one just ahead.

    Parameters
    ----------
    scale : ndarray, shape (n,)
        Error that is tolerated in each state.
    """
    ahead = 1e-9 * max(1.0, abs(t))
    beyond = system.rhs(x + ahead * rates, theta, t + ahead, settings)
    for f in (rates, np.asarray(beyond).ravel()):
        fault = finite_fault(system, t, x, f)
        if fault:
            return fault
    worst = int(np.argmax(np.abs(rates) / scale))
    return (
        f"the step size shrank to nothing at t = {t:.9g} s; the fastest "
        f"state there is {system.state_names[worst]} = {x[worst]:.6g} with derivative "
        f"{rates[worst]:.6g}. A quantity runs to infinity or leaves the range of a function."
    )


def may_be_unfit(system: System) -> bool:
    """Whether what a state leads varies at all."""
    return bool(levers(system)[0])


def _dependent(system: System) -> list[int]:
    nodes = system.structure.reduced.dependent
    return [
        n for n, ok in zip(nodes, system.structure.available(nodes, cyclic=True), strict=True) if ok
    ]


@made_once
def followers(system: System) -> tuple[list[str], ca.Function]:
    """Dependent positions and speeds that depend on modes: names and values."""
    nodes = _dependent(system)
    found = system.structure.values.of(nodes)
    touched = sorted(
        set(ca.jacobian_sparsity(found, system.structure.values.modes).get_triplet()[0])
    )
    names = [system.structure.node_name(nodes[i]) for i in touched]
    return names, ca.Function("followers", system.inputs, [found[touched]])


@made_once
def levers(system: System) -> tuple[list[tuple[int, int]], ca.Function]:
    """Varying ratios of dependent positions to leading ones, and of speeds to speeds.

    Relative to their typical size if that is above one, so that units do not count: a torque that
    follows a twist by 1e4 N.m/rad everywhere is well led.
    """
    nodes, x = _dependent(system), system.inputs[0]
    ratios = _find_ratios(system, nodes)
    rows, columns = ratios.sparsity().get_triplet()
    entries = ca.SX(ratios.nz[:])
    order = [system.structure.reduced.class_and_order(n)[1] for n in nodes]
    leading = [system.structure.reduced.class_and_order(n)[1] for n in system.structure.states]
    varying = [
        i
        for i in sorted(set(ca.jacobian_sparsity(entries, x).get_triplet()[0]))
        if order[rows[i]] == leading[columns[i]]
    ]
    pairs = [(nodes[rows[i]], system.structure.states[columns[i]]) for i in varying]
    function = ca.Function("levers", system.inputs, [entries[varying]])
    if pairs and not system.structure.implicit:
        scaled = entries[varying] / ca.DM(_typical(system, function))
        function = ca.Function("levers", system.inputs, [scaled])
    return pairs, function


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
