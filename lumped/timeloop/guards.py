"""What a run must not pass over in silence."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.kernel.run import MOST_JUMP, Run
from lumped.support.made_once import made_once


def finite_fault(system: System, t: float, x: np.ndarray, rates: np.ndarray) -> str | None:
    """Derivatives that are not finite numbers."""
    bad = np.flatnonzero(~np.isfinite(rates))
    if not len(bad):
        return None
    return (
        f"the derivative of {system.state_names[bad[0]]} is not a finite number at t = {t:g} s, "
        f"where {_list_states(system, x)}. "
        "A division by zero or a function outside its range; check the parameters and start "
        "values that enter it."
    )


def _list_states(system: System, x: np.ndarray) -> str:
    """Names and values of some states."""
    named = list(zip(system.state_names, x, strict=True))[:8]
    return ", ".join(f"{name} = {value:.6g}" for name, value in named)


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
        f"the step size shrank to nothing at t = {t:.9g} s, where {_list_states(system, x)}; the "
        f"fastest is {system.state_names[worst]} with derivative {rates[worst]:.6g}. A quantity "
        "runs to infinity or leaves the range of a function."
    )


def list_dependent(system: System) -> list[int]:
    """Nodes that constraints determine, of those that are computed."""
    nodes = system.structure.reduced.dependent
    return [
        n for n, ok in zip(nodes, system.structure.available(nodes, cyclic=True), strict=True) if ok
    ]


@made_once
def followers(system: System) -> tuple[list[str], ca.Function]:
    """Dependent positions and speeds that depend on modes: names and values."""
    relieved = _find_relieved(system)
    nodes = [n for n in list_dependent(system) if n not in relieved]
    found = system.structure.values.of(nodes)
    touched = sorted(
        set(ca.jacobian_sparsity(found, system.structure.values.modes).get_triplet()[0])
    )
    names = [system.structure.node_name(nodes[i]) for i in touched]
    return names, ca.Function("followers", system.inputs, [found[touched]])


def _find_relieved(system: System) -> set[int]:
    """Dependent nodes that may jump, as only limits of friction beside springs follow them."""
    structure, reduced = system.structure, system.structure.reduced
    limits = {
        reduced.node(node.first_unknown + node.layout.unknowns[room])
        for node in structure.tree.instances
        for room in (() if node.massless is None else node.massless.rooms)
    }
    if not limits:
        return set()
    dependent = {int(reduced.block_of[n]) for n in reduced.dependent}
    own = {int(reduced.block_of[n]) for n in limits if n is not None}
    leads, harms = set(own), set[int]()  # blocks that limits need, and that other followers need
    for number in range(len(reduced.blocks) - 1, -1, -1):
        follows = number in dependent and (number not in leads or number in harms)
        for needed in reduced.blocks[number].needs:
            if follows or (number in harms and number not in dependent):
                harms.add(needed)
            if number in leads:
                leads.add(needed)
    return {n for n in reduced.dependent if int(reduced.block_of[n]) in leads - harms}
