"""Where the energy of a run went.

A component that stores energy says how much by a method `stored`, one that dissipates by a method
`loss`, both as expressions of its own quantities and their derivatives. What flows into those that
store, through their mechanical ports, must be found again as stored or dissipated there. The powers
come from torques and speeds at the ports, the stored energies from the states, so the balance
closes only as well as the states were integrated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from lumped.compiler.formulas import derivative
from lumped.compiler.system import System
from lumped.errors import EquationError, told_by
from lumped.flattening.tree import Instance
from lumped.language.expression import Expr, Ref
from lumped.language.lowering import lower
from lumped.reduction.pruning import uses
from lumped.support.display_units import display
from lumped.support.made_once import made_once
from lumped.support.text_table import number
from lumped.timeloop.results.trajectory import Piece, Trajectory

_WORK = {("rad", "N.m"), ("m", "N")}
"""Units of potential and flow of a port whose product is work."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(5)


@dataclass(frozen=True)
class EnergyAudit:
    """Energies of a run, J: ``supplied == change + dissipated + impacts`` but for the error.

    Attributes
    ----------
    components : tuple of str
        Those that say what they store. All others count as supply, springs and bodies inside
        components without a method `stored` too.
    supplied : float
        Work that came in through their mechanical ports, impacts apart.
    change : float
        What is stored at the end less that at the begin.
    dissipated : float
        What they dissipate themselves, by their method `loss`.
    impacts : float
        What they lost in jumps of the states.
    turnover : float
        Largest energy stored, or work done.
    error : float
        Largest gap of the balance in the course of the run, over the turnover.
    works : tuple of (str, float)
        What each of the others that does work gave at its mechanical ports, impacts apart;
        negative if it took. Parts stand for the composites they are in.
    """

    components: tuple[str, ...]
    supplied: float
    change: float
    dissipated: float
    impacts: float
    turnover: float
    error: float
    works: tuple[tuple[str, float], ...] = ()

    def __repr__(self) -> str:
        parts = (self.supplied, self.change, self.dissipated, self.impacts)
        to_show = display("energy", "J")
        texts = [number(to_show.value(value + 0.0)) for value in parts]
        return (
            "energy of {} components, {}: supplied {} = stored {} + dissipated {} + impacts {}, "
            "to {} of the turnover {}"
        ).format(
            *(len(self.components), to_show.unit, *texts, number(self.error, 2)),
            number(to_show.value(self.turnover), 4),
        )


def audit_energy(
    run: Trajectory, again: Callable[[Sequence[float] | np.ndarray | None], Trajectory]
) -> EnergyAudit | None:
    """Energy balance of a run; None if no component says what it stores.

    Parameters
    ----------
    run : Trajectory
        Whose energies are wanted.
    again : callable
        The same run at other output times: those given, or None for the steps of the solver.

    Raises
    ------
    EquationError
        If a method `stored` or `loss` holds something else than the component's own quantities.
    """
    nodes = _storing(run.system)
    if not nodes:
        return None
    steps = again(None)
    pieces = [piece for piece in steps.pieces if len(piece.t)]
    inner = [_inside(piece.t) for piece in pieces]
    fine = again(np.concatenate([t.ravel() for t in inner]))
    others = _others(run.system)
    powers = np.concatenate([_values(piece, run.theta)[:, 1:] for piece in fine.pieces])
    given = np.zeros(len(others))
    supplied = dissipated = impacts = largest = worst = 0.0
    first = before = float(_values(pieces[0], run.theta)[0, 0])
    place = 0
    for piece, t in zip(pieces, inner, strict=True):
        stored = _values(piece, run.theta)[:, 0]
        impacts += before - float(stored[0])
        own = powers[place : place + t.size].reshape(*t.shape, 2 + len(others))
        place += t.size
        width = 0.5 * np.diff(piece.t)
        work = np.cumsum(np.einsum("knp,n,k->kp", own, _WEIGHTS, width), axis=0)
        in_, out = supplied + work[:, 0], dissipated + work[:, 1]
        gaps = stored[1:] - first + impacts + out - in_
        worst = max(worst, float(np.abs(gaps).max(initial=0.0)))
        for each in (stored, in_, out):
            largest = max(largest, float(np.abs(each).max(initial=0.0)))
        if len(work):
            supplied, dissipated = float(in_[-1]), float(out[-1])
            given -= work[-1, 2:]
        before = float(stored[-1])
    error = worst / largest if largest else 0.0
    paths = tuple(node.path for node in nodes)
    works = tuple(
        (node.path, float(work))
        for node, work in zip(others, given, strict=True)
        if abs(work) > 1e-9 * largest
    )
    return EnergyAudit(paths, supplied, before - first, dissipated, impacts, largest, error, works)


def _others(system: System) -> list[Instance]:
    """Components without parts that do not say what they store and have mechanical ports."""
    storing = {node.path for node in _storing(system)}
    return [
        node
        for node in system.structure.tree.instances
        if not node.children and node.path not in storing and _ports(node)
    ]


def _ports(node: Instance) -> list[int]:
    """Places of the potentials of mechanical ports."""
    quantities = node.layout.quantities
    pairs = ((i, quantities[i], quantities[i + 1]) for i in range(0, 2 * len(node.layout.ports), 2))
    return [i for i, potential, flow in pairs if (potential.unit, flow.unit) in _WORK]


def _inside(t: np.ndarray) -> np.ndarray:
    """Gauss points between times, shape (k - 1, 5)."""
    return t[:-1, None] + 0.5 * np.diff(t)[:, None] * (1 + _NODES)


def _values(piece: Piece, theta: np.ndarray) -> np.ndarray:
    """Energy stored, power through ports, power dissipated, and power into others, (k, 3 + m)."""
    found = _audit(piece.system)(piece.x.T, theta, piece.t[None, :], piece.settings.T)
    return np.asarray(found).T


@made_once
def _energies(system: System) -> list[tuple[Instance, ca.SX]]:
    """Components that say what they store, and that energy, by the symbols of all states."""
    return [
        (node, _lower_method(system, node, "stored"))
        for node in system.structure.tree.instances
        if hasattr(node.component, "stored")
    ]


@made_once
def _storing(system: System) -> list[Instance]:
    """Components whose stored energy needs no state that was left out, such as a height."""
    structure, energies = system.structure, _energies(system)
    found = uses(ca.vertcat(*(energy for _, energy in energies)), structure.values).tocoo()
    lost = set(found.row[~np.isin(found.col, structure.in_use)].tolist()) if energies else set()
    return [node for i, (node, _) in enumerate(energies) if i not in lost]


def sum_stored(system: System) -> ca.SX:
    """What all components store that say so, J, by the symbols of all states.

    Raises
    ------
    EquationError
        If a method `stored` holds something else than the component's own quantities.
    """
    found = ca.SX(0)
    for _, energy in _energies(system):
        found += energy
    return found


@made_once
def _audit(system: System) -> ca.Function:
    stored = power = loss = ca.SX(0)
    energies = dict(_energies(system))
    for node in _storing(system):
        component: Any = node.component
        stored += energies[node]
        if hasattr(component, "loss"):
            loss += _lower_method(system, node, "loss")
        power += _power(system, node)
    rest = [_power(system, node) for node in _others(system)]
    found = ca.densify(system.structure.in_states(ca.vertcat(stored, power, loss, *rest)))
    return ca.Function("audit", system.inputs, [found])


def _power(system: System, node: Instance) -> ca.SX:
    """Power that flows into a component through its mechanical ports."""
    power = ca.SX(0)
    for i in _ports(node):
        q = node.first_unknown + i
        power += system.structure.raw([q + 1]) * derivative(system.structure.values, q, 1)
    return power


def _lower_method(system: System, node: Instance, method: str) -> ca.SX:
    """What a method of a component tells of its own quantities, in those of the system."""
    layout, values = node.layout, system.structure.values
    with told_by(node.label, f"{method}()"):
        expression: Expr = getattr(node.component, method)()

    def leaf(found: Expr) -> ca.SX:
        name = ""
        if isinstance(found, Ref) and found.owner is node.component:
            name = found.name
        if name in layout.parameters:
            return system.structure.parameters.values[
                node.first_parameter + layout.parameters[name]
            ]
        if name not in layout.unknowns:
            raise EquationError(
                f"{node.label}: '{expression!r}' is an energy or a loss and may hold only the "
                f"component's own quantities and parameters, not '{found!r}'."
            )
        return system.structure.raw([node.first_unknown + layout.unknowns[name]])

    def rate(found: ca.SX) -> ca.SX:
        moving = ca.vertcat(values.states, values.time)
        rates = ca.vertcat(values.of([state + 1 for state in values.reduced.states]), 1)
        return ca.jtimes(found, moving, rates)

    return lower(expression, leaf, time=values.time, derivative=rate)
