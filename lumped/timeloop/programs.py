"""Programs that runs ask at instants: their order at one instant, and their answers."""

from __future__ import annotations

from types import TracebackType
from typing import Self

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.kernel.run import Run
from lumped.language.program import Session
from lumped.support.made_once import made_once
from lumped.timeloop.guards import set_twice_fault

ProgramInputs = dict[int, np.ndarray]
"""Instants, s, and what a program was given at each, by the number of the jump."""


def programs_of(system: System) -> dict[str, str]:
    """Components that ask programs, and what these are."""
    jumps = system.switching.jumps
    return {jump.name: jump.program.text for jump in jumps if jump.program is not None}


def refuse_programs(system: System, what: str) -> None:
    """Refuse what needs equations of everything.

    Raises
    ------
    OptionError
        If the system asks programs.
    """
    for name, text in programs_of(system).items():
        raise OptionError(
            f"{system.name}: {what} needs equations of all parts, but {name} asks {text}, which "
            "only answers. Put a component with equations in its place."
        )


@made_once
def rank_programs(system: System) -> list[int]:
    """Order in which programs are asked at one instant, from 1; 0 for jumps without any.

    One that needs what another answers comes later. In a ring the first that was declared is asked
    first, so it has the answer of the sample before.
    """
    jumps, structure = system.switching.jumps, system.structure
    asked = [k for k, jump in enumerate(jumps) if jump.program is not None]
    ranks = [0] * len(jumps)
    if not asked:
        return ranks
    import networkx as nx

    values, x = structure.in_states(system.switching.values), system.inputs[0]
    rows, columns = (np.array(v) for v in ca.jacobian_sparsity(values, x).get_triplet())
    place = {node: i for i, node in enumerate(structure.states)}
    needs = nx.DiGraph()
    needs.add_nodes_from(asked)
    for k in asked:
        asked_with = jumps[k].question
        used = set(columns[(rows >= asked_with.start) & (rows < asked_with.stop)].tolist())
        needs.add_edges_from(
            (other, k)
            for other in asked
            if other != k and any(place.get(node) in used for node in jumps[other].answers)
        )
    rings = nx.condensation(needs)
    order = nx.lexicographical_topological_sort(
        rings, lambda ring: min(rings.nodes[ring]["members"])
    )
    members = [k for ring in order for k in sorted(rings.nodes[ring]["members"])]
    for rank, k in enumerate(members, 1):
        ranks[k] = rank
    return ranks


@made_once
def _find_taken(system: System, number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which answers of a program states take, which states, and their signs."""
    place = {node: i for i, node in enumerate(system.structure.states)}
    jump = system.switching.jumps[number]
    which = [i for i, node in enumerate(jump.answers) if node in place]
    states = np.array([place[jump.answers[i]] for i in which], dtype=int)
    signs = np.array([jump.answer_signs[i] for i in which])
    return np.array(which, dtype=int), states, signs


def _claim(system: System, run: Run, number: int, states: np.ndarray) -> None:
    """Note that a jump sets states at this instant, as the loop does where no program is asked.

    Raises
    ------
    SolverError
        If another set one of them.
    """
    for state in states.tolist():
        if run.instant.set_by[state] > 0:
            run.instant.set_twice, run.instant.setting_again = state, number
            raise SolverError(set_twice_fault(system, run))
        run.instant.set_by[state] = number + 1


class Answers:
    """What programs answer in a run, or in runs of one thread one after the other.

    Parameters
    ----------
    before : dict, optional
        What they were given before; they are given it again before the first question.
    """

    def __init__(self, before: ProgramInputs | None = None) -> None:
        self._before = before or {}
        self._sessions: dict[int, Session] = {}
        self._since: dict[int, list[np.ndarray]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, fault: object, trace: TracebackType | None
    ) -> None:
        for session in self._sessions.values():
            session.end()
        self._sessions.clear()

    def ask(self, system: System, run: Run) -> np.ndarray:
        """Ask the program whose turn it is, and let states take its answers.

        Parameters
        ----------
        system : System
            What runs.
        run : Run
            Waits for the answers.

        Returns
        -------
        ndarray
            The instant, and what the program was given.

        Raises
        ------
        SolverError
            If it does not answer, or another `when` sets one of the states at this instant.
        """
        number = int(run.instant.asking)
        values = run.instant.seen.jumped[system.switching.jumps[number].question].copy()
        answers = self._find_answers(system, run.t, number, values)
        which, states, signs = _find_taken(system, number)
        _claim(system, run, number, states)
        run.instant.x[states] = signs * answers[which]
        return np.array([run.t, *values])

    def try_to_ask(self, system: System, run: Run) -> bool:
        """As `ask`; whether it succeeds."""
        try:
            self.ask(system, run)
        except SolverError:
            return False
        return True

    def ask_and_keep(self, system: System, run: Run) -> None:
        """As `ask`; what the program is given is kept."""
        number = int(run.instant.asking)
        self._since.setdefault(number, []).append(self.ask(system, run))

    def _find_answers(
        self, system: System, t: float, number: int, values: np.ndarray
    ) -> np.ndarray:
        """What the program of a jump answers; it begins when it is asked first."""
        jump = system.switching.jumps[number]
        assert jump.program is not None
        try:
            if number not in self._sessions:
                self._sessions[number] = jump.program.begin()
                for row in self._before.get(number, ()):
                    self._sessions[number].answer(row[1:])
            return self._sessions[number].answer(values)
        except SolverError as error:
            raise SolverError(
                f"at t = {t:.9g} s {jump.name} asks {jump.program.text}: {error}"
            ) from None

    @property
    def program_inputs(self) -> ProgramInputs:
        """Instants and what programs were given, in this run and before."""
        found = dict(self._before)
        for number, rows in self._since.items():
            before = [self._before[number]] if number in self._before else []
            found[number] = np.concatenate([*before, np.array(rows)])
        return found
