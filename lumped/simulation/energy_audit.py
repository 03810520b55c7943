"""Where the energy of a run went.

A component that stores energy says how much by a method `stored`, one that dissipates by a method
`loss`, both as expressions of its own quantities and their derivatives. What flows into those that
store, through their mechanical ports, must be found again as stored or dissipated there. What
others dissipate, such as friction, counts as supplied and as dissipated. The powers come from
torques and speeds at the ports, the stored energies from the states, so the balance closes only as
well as the states were integrated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np
from numpy.polynomial.legendre import leggauss

from lumped.compiler.energies import dissipated_power, stored_energies
from lumped.compiler.formulas import derivative
from lumped.compiler.system import System
from lumped.flattening.tree import Instance
from lumped.reduction.pruning import uses
from lumped.support.display_units import display
from lumped.support.made_once import made_once
from lumped.support.text_table import number
from lumped.timeloop.results.trajectory import Piece, Trajectory

_WORK = {("rad", "N.m"), ("m", "N")}
"""Units of potential and flow of a port whose product is work."""
_GAUSS = leggauss(5)
_NODES, _WEIGHTS = 0.5 * (1 + _GAUSS[0]), 0.5 * _GAUSS[1]
"""Gauss points and weights of a step of length one."""


@dataclass(frozen=True)
class EnergyAudit:
    """Energies of a run, J: ``supplied == change + dissipated + impacts`` but for the error.

    Attributes
    ----------
    components : tuple of str
        Those that say what they store. All others count as supply, springs and bodies inside
        components without a method `stored` too.
    supplied : float
        Work that came in through their mechanical ports, impacts apart, and what others dissipated.
    change : float
        What is stored at the end less that at the begin.
    dissipated : float
        What they and all others with mechanical ports dissipate, by their method `loss`.
    impacts : float
        What they lost in jumps of the states.
    turnover : float
        Largest energy stored, or work done.
    error : float
        Largest gap of the balance in the course of the run, over the turnover.
    works : tuple of (str, float)
        What each of the others that does work gave at its mechanical ports, impacts apart, and
        dissipated: of a motor the power from its supply, of friction nothing; negative if it took.
        Parts stand for the composites they are in.
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
    storing, others = _find_storing(run.system), _find_others(run.system)
    if not storing:
        return None
    courses = _follow(again, run.theta)
    balance = _Balance(float(courses[0].stored[0]), np.zeros(len(others)))
    first = balance.stored
    for course in courses:
        balance.add(course, first)
    turnover = balance.turnover
    return EnergyAudit(
        components=tuple(node.path for node in storing),
        supplied=balance.supplied,
        change=balance.stored - first,
        dissipated=balance.dissipated,
        impacts=balance.impacts,
        turnover=turnover,
        error=balance.gap / turnover if turnover else 0.0,
        works=tuple(
            (node.path, float(work))
            for node, work in zip(others, balance.given, strict=True)
            if abs(work) > 1e-9 * turnover
        ),
    )


class _Course(NamedTuple):
    """Energies at the steps of a piece of a run, J; work is that since the begin of the piece.

    Attributes
    ----------
    stored : ndarray, shape (k,)
        In the components that say so.
    supplied, dissipated : ndarray, shape (k,)
        Work through their ports and what others dissipated, and what all dissipated.
    taken : ndarray, shape (k, m)
        Work into each of the others, less what it dissipated.
    """

    stored: np.ndarray
    supplied: np.ndarray
    dissipated: np.ndarray
    taken: np.ndarray


@dataclass
class _Balance:
    """Energies of a run up to an instant, by the names of `EnergyAudit`; largest gap, J."""

    stored: float
    given: np.ndarray
    supplied: float = 0.0
    dissipated: float = 0.0
    impacts: float = 0.0
    turnover: float = 0.0
    gap: float = 0.0

    def add(self, course: _Course, first: float) -> None:
        """Go on over a piece of the run; what was stored before and is no more, impacts took."""
        self.impacts += self.stored - float(course.stored[0])
        supplied = self.supplied + course.supplied
        dissipated = self.dissipated + course.dissipated
        gaps = course.stored - first + self.impacts + dissipated - supplied
        self.gap = max(self.gap, float(np.abs(gaps).max()))
        for energy in (course.stored, supplied, dissipated):
            self.turnover = max(self.turnover, float(np.abs(energy).max()))
        self.stored = float(course.stored[-1])
        self.supplied, self.dissipated = float(supplied[-1]), float(dissipated[-1])
        self.given = self.given - course.taken[-1]


def _follow(
    again: Callable[[Sequence[float] | np.ndarray | None], Trajectory], theta: np.ndarray
) -> list[_Course]:
    """Energies at the steps of each piece; powers are taken at Gauss points within the steps."""
    pieces = [piece for piece in again(None).pieces if len(piece.t)]
    inner = [piece.t[:-1, None] + np.diff(piece.t)[:, None] * _NODES for piece in pieces]
    wanted = np.concatenate([t.ravel() for t in inner])
    finer = [piece for piece in again(wanted).pieces if len(piece.t)]
    powers = np.zeros((0, _powers(pieces[0].system).size1_out(0)))
    powers = np.concatenate([powers, *(_evaluate(_powers, piece, theta) for piece in finer)])
    reached = np.concatenate([[], *(piece.t for piece in finer)])
    assert np.array_equal(reached, wanted), "the finer run has other instants than the steps"
    ends = np.cumsum([t.size for t in inner])
    courses = []
    for piece, own in zip(pieces, np.split(powers, ends[:-1]), strict=True):
        by_step = own.reshape(len(piece.t) - 1, len(_NODES), own.shape[1])
        works = np.einsum("knp,n,k->kp", by_step, _WEIGHTS, np.diff(piece.t))
        work = np.concatenate([np.zeros((1, own.shape[1])), np.cumsum(works, axis=0)])
        stored = _evaluate(_stored, piece, theta)[:, 0]
        courses.append(_Course(stored, work[:, 0], work[:, 1], work[:, 2:]))
    return courses


def _evaluate(
    expression: Callable[[System], ca.Function], piece: Piece, theta: np.ndarray
) -> np.ndarray:
    """Energies or powers at all instants of a piece, shape (k, numbers)."""
    function = expression(piece.system)
    return np.asarray(function(piece.x.T, theta, piece.t[None, :], piece.settings.T)).T


@made_once
def _stored(system: System) -> ca.Function:
    """Energy in the components that say so."""
    energy = ca.SX(0)
    for node in _find_storing(system):
        energy += stored_energies(system)[node]
    return _function(system, energy)


@made_once
def _powers(system: System) -> ca.Function:
    """Power supplied, power dissipated, and power into each other less what it dissipates."""
    storing, others = _find_storing(system), _find_others(system)
    losses = [dissipated_power(system, node) for node in others]
    known = _mark_known(system, losses)
    losses = [loss if fits else ca.SX(0) for loss, fits in zip(losses, known, strict=True)]
    lost = sum(losses, ca.SX(0))
    supplied = sum((_power(system, node) for node in storing), lost)
    dissipated = sum((dissipated_power(system, node) for node in storing), lost)
    taken = [_power(system, node) - loss for node, loss in zip(others, losses, strict=True)]
    return _function(system, ca.vertcat(supplied, dissipated, *taken))


def _function(system: System, found: ca.SX) -> ca.Function:
    found = ca.densify(system.structure.in_states(found))
    return ca.Function("energies", system.inputs, [found])


@made_once
def _find_storing(system: System) -> list[Instance]:
    """Components whose stored energy needs no state that was left out, such as a height."""
    energies = stored_energies(system)
    known = _mark_known(system, list(energies.values()))
    return [node for node, fits in zip(energies, known, strict=True) if fits]


def _mark_known(system: System, expressions: list[ca.SX]) -> np.ndarray:
    """Which expressions need no state that was left out."""
    known = np.ones(len(expressions), dtype=bool)
    if expressions:
        found = uses(ca.vertcat(*expressions), system.structure.values).tocoo()
        known[found.row[~np.isin(found.col, system.structure.in_use)]] = False
    return known


def _find_others(system: System) -> list[Instance]:
    """Components without parts that do not say what they store and have mechanical ports."""
    storing = set(_find_storing(system))
    return [
        node
        for node in system.structure.tree.instances
        if not node.children and node not in storing and _find_ports(node)
    ]


def _find_ports(node: Instance) -> list[int]:
    """Places of the potentials of mechanical ports."""
    quantities = node.layout.quantities
    pairs = ((i, quantities[i], quantities[i + 1]) for i in range(0, 2 * len(node.layout.ports), 2))
    return [i for i, potential, flow in pairs if (potential.unit, flow.unit) in _WORK]


def _power(system: System, node: Instance) -> ca.SX:
    """Power that flows into a component through its mechanical ports."""
    power = ca.SX(0)
    for i in _find_ports(node):
        q = node.first_unknown + i
        power += system.structure.raw([q + 1]) * derivative(system.structure.values, q, 1)
    return power
