"""Where the energy of a run went.

A component that stores energy says how much by a method `stored`, one that dissipates by a method
`loss`, both as expressions of its own quantities and their derivatives. What flows into those that
store, through their ports, must be found again as stored or dissipated there. What others
dissipate, such as friction, counts as supplied and as dissipated; what goes on through a thermal
port is not lost and counts as neither. The powers come from potentials and flows of the ports, the
stored energies from the states, so the balance closes only as well as the states were integrated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.energies import PortPower, dissipated_power, port_powers, stored_energies
from lumped.compiler.report import shorten
from lumped.compiler.system import System
from lumped.flattening.tree import Instance
from lumped.reduction.pruning import independent_of, uses
from lumped.simulation.works import integrate_powers
from lumped.support.display_units import display
from lumped.support.made_once import made_once
from lumped.support.text_table import number
from lumped.timeloop.results.trajectory import Piece, Trajectory


@dataclass(frozen=True)
class EnergyAudit:
    """Energies of a run, J: ``supplied == change + dissipated + impacts`` but for the error.

    Attributes
    ----------
    components : tuple of str
        Those that say what they store. All others count as supply, springs and bodies inside
        components without a method `stored` too.
    supplied : float
        Work that came in through their ports, impacts apart, and what others dissipated.
    change : float
        What is stored at the end less that at the begin.
    dissipated : float
        What they and all others dissipate, by their method `loss`, less the heat that goes on
        through their thermal ports.
    impacts : float
        What they lost in jumps of the states.
    turnover : float
        Largest energy stored, or work done.
    error : float
        Largest gap of the balance in the course of the run, and what is not known of the works,
        over the turnover.
    works : tuple of (str, float)
        What each of the others that does work gave at its ports, impacts apart, and dissipated: of
        a source the power that it feeds, of friction nothing; negative if it took. Parts stand for
        the composites they are in.
    uncounted : tuple of str
        Ports whose power is not counted: potential times flow is none by their units, or needs a
        state that was left out.
    """

    components: tuple[str, ...]
    supplied: float
    change: float
    dissipated: float
    impacts: float
    turnover: float
    error: float
    works: tuple[tuple[str, float], ...] = ()
    uncounted: tuple[str, ...] = ()

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
        ) + (f"; {self.missing}" if self.uncounted else "")

    @property
    def missing(self) -> str:
        """Which ports are not counted, and why, in words; empty if all are."""
        why = "of no known power, or one that needs a state left out"
        return f"not counted are ports {why}: {shorten(self.uncounted)}" if self.uncounted else ""


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
    courses, unsettled = _follow(again, run.theta)
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
        error=(balance.gap + unsettled) / turnover if turnover else 0.0,
        works=tuple(
            (node.path, float(work))
            for node, work in zip(others, balance.given, strict=True)
            if abs(work) > 1e-9 * turnover
        ),
        uncounted=tuple(
            port.name
            for node, ports in _find_powers(run.system).items()
            for port in ports
            if port.power is None and (node in storing or not node.children)
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
) -> tuple[list[_Course], float]:
    """Energies at the steps of each piece, and the work that is not known, J."""
    pieces = [piece for piece in again(None).pieces if len(piece.t)]
    begin = np.concatenate([piece.t[:-1] for piece in pieces])
    width = np.concatenate([np.diff(piece.t) for piece in pieces])
    energies = [_evaluate(_stored, piece, theta)[:, 0] for piece in pieces]
    most = float(np.abs(np.concatenate(energies)).max())
    steps, unsettled = integrate_powers(
        again, lambda piece: _evaluate(_powers, piece, theta), begin, width, most
    )
    ends = np.cumsum([len(piece.t) - 1 for piece in pieces])
    courses = []
    for stored, works in zip(energies, np.split(steps, ends[:-1]), strict=True):
        work = np.concatenate([np.zeros((1, works.shape[1])), np.cumsum(works, axis=0)])
        courses.append(_Course(stored, work[:, 0], work[:, 1], work[:, 2:]))
    return courses, unsettled


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
    losses = {node: _find_loss(system, node) for node in (*storing, *others)}
    lost = sum((losses[node] for node in others), ca.SX(0))
    supplied = sum((_power(system, node) for node in storing), lost)
    dissipated = sum(losses.values(), ca.SX(0))
    taken = [_power(system, node) - losses[node] for node in others]
    return _function(system, ca.vertcat(supplied, dissipated, *taken))


def _find_loss(system: System, node: Instance) -> ca.SX:
    """Power that is lost in a component: what it dissipates less the heat that goes on."""
    loss = dissipated_power(system, node)
    if loss.is_zero() or not _mark_known(system, [loss])[0]:
        return ca.SX(0)
    heats = (port.power for port in _find_powers(system)[node] if port.is_heat)
    return sum((heat for heat in heats if heat is not None), loss)


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
        values = system.structure.values
        rows, columns = uses(ca.vertcat(*expressions), values)
        lost = np.setdiff1d(columns, system.structure.in_use).tolist()
        for row in np.unique(rows[np.isin(columns, lost)]).tolist():
            known[row] = independent_of(expressions[row], lost, values).all()
    return known


def _find_others(system: System) -> list[Instance]:
    """Components without parts that do not say what they store and have ports."""
    storing = set(_find_storing(system))
    powers = _find_powers(system)
    return [node for node in powers if node not in storing and not node.children and powers[node]]


@made_once
def _find_powers(system: System) -> dict[Instance, list[PortPower]]:
    """Powers through the ports of all components; None where one needs a state left out."""
    every = {node: port_powers(system, node) for node in system.structure.tree.instances}
    found = [port for ports in every.values() for port in ports if port.power is not None]
    known = _mark_known(system, [port.power for port in found if port.power is not None])
    fits = {port.name for port, is_known in zip(found, known, strict=True) if is_known}
    return {
        node: [port if port.name in fits else port._replace(power=None) for port in ports]
        for node, ports in every.items()
    }


def _power(system: System, node: Instance) -> ca.SX:
    """Power that flows into a component through its ports."""
    powers = (port.power for port in _find_powers(system)[node])
    return sum((power for power in powers if power is not None), ca.SX(0))
