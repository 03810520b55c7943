"""The search for states at the start, in the positions of conditions and holds that hold there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from lumped.compiler.system import Changes, System
from lumped.errors import SolverError, StartError
from lumped.flattening.hold_modes import BACKWARD, FORWARD, STUCK
from lumped.language.quantity import beyond
from lumped.points.constraint_rank import refuse_redundant
from lumped.points.position_search import borders, search_positions
from lumped.points.start_values import (
    differentiate_start_values,
    evaluate_start_values,
    read_start_values,
    relative_positions,
)
from lumped.points.targets import Targets
from lumped.support.units import amount
from lumped.timeloop.clocks import modes_at
from lumped.timeloop.holds import Holds
from lumped.timeloop.settings import calm_positions, close_settings, just_after, open_modes

ROUNDING = 1e-3
"""Of the speed that counts as standstill: what a search leaves of a speed that is zero."""
_MOST = 60
"""Times that positions are found anew."""


class _Trial(NamedTuple):
    """All states, parameters, and modes of all conditions and holds."""

    x: np.ndarray
    theta: np.ndarray
    modes: np.ndarray


class StartSearch:
    """What is demanded of a start, and the states and parameters that meet it.

    Parameters
    ----------
    system : System
        From `assemble`.
    theta : ndarray
        Parameters.
    start : mapping of name to float
        Start values to set.
    free : list of int
        Places of the parameters to be found.
    time : float
        Instant, s.
    together : bool
        Parts move together: relative positions, such as twists, rest.
    pressed : tuple of int
        Nodes of further speeds that are zero.

    Attributes
    ----------
    x, theta, settings : ndarray
        All states, parameters, modes and implicit quantities.
    given : dict of int to float
        Start value of each unknown that has one.
    changed : set of int
        Those of them that were set.
    fixed, targets, guessed : dict of int to (int, float)
        Unknown and value of each node that is a state, that is none, and that a linkage determines.
    followed : dict of int to (int, float)
        The same of values that hold besides, at a point that was found before.
    search : Targets or None
        What was searched for.
    residual : float or None
        How far the worst of it is missed; None where nothing was searched for.
    """

    def __init__(
        self,
        system: System,
        theta: np.ndarray,
        start: Changes,
        free: list[int],
        time: float,
        together: bool = False,
        pressed: tuple[int, ...] = (),
    ) -> None:
        self.system, self.theta, self.free, self.time = system, theta, free, time
        self._resting, self._pressed = relative_positions(system) if together else (), pressed
        self.reduced = system.structure.reduced
        self.position = {n: i for i, n in enumerate(self.reduced.states)}
        given, self.starts = evaluate_start_values(system, theta)
        changed = read_start_values(system, start)
        self.given, self.changed = given | changed, set(changed)
        for unknown, number in self.given.items():
            why = beyond(number)
            if why is not None:
                raise StartError(f"{self._text(unknown)}: a start value {why}.")
        self.followed: dict[int, tuple[int, float]] = {}
        self.guesses = self._first_guesses()
        self.x = np.zeros(len(self.reduced.states))
        for unknown, value in self.starts.items():
            node = self.reduced.node(unknown)
            if node in self.position:
                self.x[self.position[node]] = self.signed(unknown, value)

    def signed(self, unknown: int, value: float) -> float:
        """Value of the node of an unknown."""
        return value * float(self.reduced.aliases.signs[unknown])

    def solve(self) -> np.ndarray:
        """All states, before any impact.

        Raises
        ------
        StartError
            If what is demanded cannot hold.
        """
        self.sort()
        self.search: Targets | None = None
        self.residual: float | None = None
        for node, (_, value) in self.fixed.items():
            self.x[self.position[node]] = value
        modes, self.guesses = open_modes(self.system, self.x, self.theta, self.time, self.guesses)
        trial = _Trial(self.x, self.theta, modes)
        if len(self.guesses):
            refuse_redundant(self.system, *trial, self.guesses, self.time)
        if self.targets or self.free or self.system.structure.flat.initial:
            held = {self.position[n]: u for n, (u, _) in self.fixed.items()}
            self.search = Targets(
                self.system, self.targets, held, self.free, self.guesses, self.time, self._text
            )
            trial = self._meet(trial)
            self.residual = self.search.residual(trial.x, trial.theta)[0]
            if self.free:
                self.system.check_parameters(trial.theta)
        self.x, self.theta, _ = trial
        self.settings = self._close(trial)
        return self.x

    def check(self, settings: np.ndarray) -> None:
        """Refuse a start at which what is demanded does not hold in the modes of these settings.

        Raises
        ------
        StartError
            With the worst of it.
        """
        if self.search is None or not self.search.have_positions:
            return
        modes = settings[: len(self.search.modes)]
        if (modes == self.search.modes).all():
            return
        self.search.modes = modes
        self.residual, missed = self.search.residual(self.x, self.theta)
        if missed:
            raise self._disagreement(missed)

    def sort(self) -> None:
        """Which given values are those of states, which must be searched for, which are guesses.

        Raises
        ------
        StartError
            If two of them contradict each other.
        """
        self.fixed: dict[int, tuple[int, float]] = {}
        self.targets: dict[int, tuple[int, float]] = {}
        self.guessed: dict[int, tuple[int, float]] = {}
        for unknown, raw in self.given.items():
            node, value = self.reduced.node(unknown), self.signed(unknown, raw)
            if node is None:
                if raw != 0.0:
                    raise StartError(
                        f"{self._text(unknown)} cannot hold: this quantity is always zero here. "
                        "Remove the start value."
                    )
                continue
            usual = self.fixed if node in self.position else self.targets
            store = self.guessed if self._is_assembly(node) else usual
            if node in store and not np.isclose(store[node][1], value, rtol=1e-12, atol=0):
                raise StartError(
                    f"Start values contradict each other: {self._text(store[node][0])} and "
                    f"{self._text(unknown)}, but both are the same motion. Give only one of them."
                )
            store[node] = (unknown, value)
        for node, held in self.followed.items():
            store = self.fixed if node in self.position else self.targets
            store.setdefault(node, held)
        for node in self._resting:
            rate = node + 1
            if not {rate} & (self.fixed.keys() | self.targets.keys() | self.position.keys()):
                self.targets[rate] = (~self.system.structure.members[node], 0.0)
        for node in self._pressed:
            if not {node} & (self.fixed.keys() | self.targets.keys()):
                store = self.fixed if node in self.position else self.targets
                store[node] = (~self.system.structure.members.get(node, 0), 0.0)

    def _is_assembly(self, node: int) -> bool:
        """Whether a node is a motion that a closed linkage determines; its value is a guess."""
        kind, _ = self.reduced.class_and_order(node)
        moves = self.reduced.first[kind + 1] - self.reduced.first[kind] > 1
        return bool(moves) and node in self.system.structure.implicit

    def _close(self, trial: _Trial) -> np.ndarray:
        used = trial.x[self.system.structure.in_use]
        return close_settings(self.system, used, trial.theta, self.time, trial.modes, self.guesses)

    def _meet(self, first: _Trial) -> _Trial:
        """Where everything that is demanded holds, in the positions that hold there."""
        assert self.search is not None
        if not (self.system.switching and self.search.have_positions):
            return self._still(self._solve_in(first, first))
        fault: StartError | None = None
        begins = ((begin, on) for begin in self._begins(first) for on in (False, True))
        for begin, follows in begins:
            try:
                found = search_positions(
                    begin,
                    partial(self._solve_in, first),
                    self._reposition,
                    _between,
                    lambda trial: self.system.switching.positions(trial.modes),
                    _MOST,
                    follows,
                )
            except StartError as error:
                fault = fault or error
                continue
            if found is not None:
                return self._still(found, stuck=True)
        raise fault or self._disagreement(self.search.residual(first.x, first.theta)[1])

    def _begins(self, first: _Trial) -> Iterator[_Trial]:
        """Where to begin, with positions."""
        try:
            begin = self._reposition(first)
        except StartError:
            begin = first
        yield begin
        if begin is not first:
            yield first
        yield from self._across(begin)

    def _across(self, begin: _Trial) -> Iterator[_Trial]:
        """Points beyond borders, where something else changes what is demanded.

        Within a play, nothing changes the torque that a spring behind it shall have: borders are
        crossed until something does.
        """
        assert self.search is not None
        touching, border = borders(self.system, self.search.value)
        if not touching.size:
            return
        movable = np.ones(len(self.x), dtype=bool)
        movable[list(self.search.fixed)] = False
        trial, (missed, hopeless, *measure) = begin, self._find_idle(begin)
        first = True
        while hopeless or first:
            found = []
            settings = self._close(trial)
            ways, slopes = border(trial.x, trial.theta, self.time, settings)
            slopes = slopes.reshape(len(ways), -1) * movable
            for k in np.flatnonzero(touching[missed].any(axis=0)).tolist():
                way, slope = ways[k], slopes[k]
                if not (np.isfinite(slope).all() and slope.any() and np.isfinite(way)):
                    continue
                moved = trial.x + way * slope / (slope @ slope)
                try:
                    beyond = self._reposition(_Trial(moved, trial.theta, trial.modes))
                    found.append((self._find_idle(beyond), beyond))
                except StartError:
                    continue
            found.sort(key=lambda pair: pair[0][2:])
            yield from (point for idle, point in found if not idle[1])
            first = False
            if not found or list(found[0][0][2:]) >= measure:
                return
            (missed, hopeless, *measure), trial = found[0]

    def _find_idle(self, trial: _Trial) -> tuple[np.ndarray, bool, int, float]:
        assert self.search is not None
        self.search.modes = trial.modes
        return self.search.find_idle(trial.x, trial.theta)

    def _solve_in(self, first: _Trial, trial: _Trial) -> _Trial:
        """Where everything that is demanded holds in the positions of a trial."""
        assert self.search is not None
        self.search.modes = trial.modes
        try:
            x, theta = self.search.meet(trial.x, trial.theta)
        except StartError:
            if trial.x is first.x:
                raise
            x, theta = self.search.meet(first.x, first.theta)
        return _Trial(x, theta, trial.modes)

    def _still(self, trial: _Trial, *, stuck: bool = False) -> _Trial:
        """The trial with speeds of holds that are rounding made zero, or all such that stick."""
        if not self.system.switching:
            return trial
        x, used = trial.x.copy(), trial.x[self.system.structure.in_use]
        holds = Holds(self.system, trial.theta)
        guesses = self._close(trial)[len(trial.modes) :]
        speed = np.abs(holds.look(self.time, used, trial.modes, guesses).speed)
        still = speed <= holds.rounding(used) * (1.0 if stuck else ROUNDING)
        if stuck:
            still &= holds.parts(trial.modes)[STUCK]
        self._stop(holds, used, still)
        x[self.system.structure.in_use] = used
        return trial._replace(x=x)

    def _reposition(self, trial: _Trial) -> _Trial:
        """The trial with the positions that hold there; itself if these are its own.

        What would slide backwards is tried at standstill.
        """
        x, used = trial.x.copy(), trial.x[self.system.structure.in_use]
        modes, guesses = np.split(self._close(trial), [len(trial.modes)])
        holds = Holds(self.system, trial.theta)
        speed = holds.look(self.time, used, modes, guesses).speed
        parts = holds.parts(modes)
        turned = (parts[FORWARD] & (speed < 0)) | (parts[BACKWARD] & (speed > 0))
        self._stop(holds, used, turned & ~self.system.switching.has_gap)
        self._stop(holds, used, np.abs(speed) <= holds.rounding(used) * ROUNDING)
        x[self.system.structure.in_use] = used
        begin = np.append(modes_at(self.system, trial.theta, just_after(self.time)), guesses)
        try:
            settings = calm_positions(self.system, trial.theta, self.time, used, begin)
        except SolverError as error:
            raise StartError(str(error)) from None
        found = settings[: len(modes)]
        positions = self.system.switching.positions
        if (positions(found) == positions(trial.modes)).all():
            return trial
        return _Trial(x, trial.theta, found)

    def _stop(self, holds: Holds, used: np.ndarray, which: np.ndarray) -> None:
        """Make speeds zero, but not those that are given."""
        before = used.copy()
        holds.stop(used, which)
        given = [i for i, n in enumerate(self.system.structure.states) if n in self.fixed]
        used[given] = before[given]

    def _disagreement(self, missed: str) -> StartError:
        return StartError(
            f"{self.system.name}: {missed or 'what is demanded'} cannot hold at the start: the "
            "positions of conditions, friction and contacts in which it is met are not those that "
            "follow from it. Give start values nearer to the ones that are meant, or demand less."
        )

    def slopes(
        self, x: np.ndarray, seed: np.ndarray, varied: Mapping[int, np.ndarray]
    ) -> np.ndarray:
        """Derivatives of the states found (see `start_slopes`)."""
        flat, signs = self.system.structure.flat, self.reduced.aliases.signs
        found = differentiate_start_values(self.system)(self.theta).sparse() @ seed
        none = np.zeros(seed.shape[1])
        values = zip((*flat.starts, *flat.given), found, strict=True)
        rows = {**dict(values), **dict.fromkeys(self.changed, none)}
        for unknown, slope in varied.items():
            # a start value that is an expression of parameters moves with these too
            rows[unknown] = rows.get(unknown, none) + slope
        S = np.zeros((len(x), seed.shape[1]))
        for unknown in (*flat.starts, *varied):
            node = self.reduced.node(unknown)
            if node in self.position:
                S[self.position[node]] = signs[unknown] * rows[unknown]
        for node, (unknown, _) in self.fixed.items():
            S[self.position[node]] = signs[unknown] * rows[unknown]
        if self.search is None:
            return S
        wanted = [signs[unknown] * rows[unknown] for unknown, _ in self.targets.values()]
        return self.search.slopes(x, S, seed, np.array(wanted).reshape(-1, seed.shape[1]))

    def _first_guesses(self) -> np.ndarray:
        """Where the search for implicit quantities begins: start values given or declared."""
        implicit = {node: i for i, node in enumerate(self.system.structure.implicit)}
        guesses = np.zeros(len(implicit))
        for values in (self.starts, self.given) if implicit else ():
            for unknown, value in values.items():
                node = self.reduced.node(unknown)
                if node in implicit:
                    guesses[implicit[node]] = self.signed(unknown, value)
        return guesses

    def _text(self, unknown: int) -> str:
        tree = self.system.structure.tree
        if unknown < 0:
            return f"{tree.unknown_name(~unknown)} at rest (together=True)"
        unit = tree.quantity(unknown).unit
        return f"{tree.unknown_name(unknown)} = {amount((self.starts | self.given)[unknown], unit)}"


def _between(begin: _Trial, end: _Trial, share: float) -> _Trial:
    x, theta = (a + share * (b - a) for a, b in zip(begin[:2], end[:2], strict=True))
    return _Trial(x, theta, begin.modes)
