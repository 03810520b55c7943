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
        inputs = range(jumps[k].first + len(jumps[k].nodes), jumps[k].first + jumps[k].width)
        used = set(columns[np.isin(rows, inputs)].tolist())
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

    def give(self, system: System, run: Run) -> np.ndarray:
        """Ask the program whose turn it is, and set the states that take its answers.

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
            If it does not answer.
        """
        number = int(run.instant.asking)
        jump = system.switching.jumps[number]
        first = jump.first + len(jump.nodes)
        values = run.instant.seen.jumped[first : jump.first + jump.width].copy()
        assert jump.program is not None
        try:
            if number not in self._sessions:
                self._sessions[number] = jump.program.begin()
                for row in self._before.get(number, ()):
                    self._sessions[number].answer(row[1:])
            answers = self._sessions[number].answer(values)
        except SolverError as error:
            raise SolverError(
                f"at t = {run.t:.9g} s {jump.name} asks {jump.program.text}: {error}"
            ) from None
        which, states, signs = _find_taken(system, number)
        for state in states.tolist():
            if run.instant.set_by[state] > 0:
                run.instant.set_twice, run.instant.setting_again = state, number
                raise SolverError(set_twice_fault(system, run))
            run.instant.set_by[state] = number + 1
        run.instant.x[states] = signs * answers[which]
        return np.array([run.t, *values])

    def does_answer(self, system: System, run: Run) -> bool:
        """Whether the program answers, as `give`."""
        try:
            self.give(system, run)
        except SolverError:
            return False
        return True

    def note(self, system: System, run: Run) -> None:
        """As `give`; what the program was given is kept."""
        number = int(run.instant.asking)
        self._since.setdefault(number, []).append(self.give(system, run))

    @property
    def program_inputs(self) -> ProgramInputs:
        """Instants and what programs were given, in this run and before."""
        found = dict(self._before)
        for number, rows in self._since.items():
            before = [self._before[number]] if number in self._before else []
            found[number] = np.concatenate([*before, np.array(rows)])
        return found
