"""Conditions that depend on the time alone, and their modes at any time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from lumped.compiler.condition import Condition
from lumped.compiler.system import System
from lumped.language.lowering import has_steps, is_even
from lumped.numerics.interval_bounds import interval_bounds
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import Recent, made_once


@dataclass(frozen=True, eq=False)
class Clock:
    """A condition that depends on the time and on parameters only.

    Attributes
    ----------
    condition : Condition
        The condition.
    needs : list of int
        Numbers of the clocks that it needs.
    inputs : list of SX
        Symbols of the time, of the modes that it needs, and of the parameters.
    slope : SX
        Derivative of the argument by the time.
    """

    condition: Condition
    needs: list[int]
    inputs: list[ca.SX]
    slope: ca.SX

    @cached_property
    def value(self) -> ca.Function:
        """(time, modes that it needs, parameters) -> argument and its slope."""
        outputs = [ca.densify(self.condition.argument), ca.densify(self.slope)]
        return ca.Function("clock", self.inputs, outputs)

    @cached_property
    def bounds(self) -> ca.Function:
        """(begin, end, modes that it needs, parameters) -> bounds of the argument, of its slope."""
        return interval_bounds(self.value)

    @cached_property
    def even(self) -> bool:
        """The argument is linear in the time, so one slope tells all of its changes."""
        return is_even(self.condition.argument, self.inputs[0])

    @cached_property
    def steps(self) -> bool:
        """The argument holds functions of steps, which have no slope where they jump."""
        return has_steps(self.condition.argument, self.inputs[0])

    @cached_property
    def moves(self) -> bool:
        """The time occurs in the argument."""
        return bool(ca.depends_on(self.condition.argument, self.inputs[0]))

    def number(self, place: np.ndarray) -> np.ndarray:
        """Which piece an argument is in; 1 or 0 for a relation that holds or not."""
        pieces = self.condition.pieces
        if pieces is not None:
            return pieces.number(place)
        holds = place > 0 if self.condition.relation.strict else place >= 0
        return holds.astype(int)

    def border(self, number: np.ndarray) -> np.ndarray:
        """Where the piece begins."""
        pieces = self.condition.pieces
        return np.zeros(len(number)) if pieces is None else pieces.begin(number)

    def settings(self, number: np.ndarray) -> np.ndarray:
        """Modes in a piece, shape (..., width)."""
        pieces = self.condition.pieces
        return number[..., None].astype(float) if pieces is None else pieces.settings(number)


@made_once
def clocks(system: System) -> list[Clock]:
    """All of a system, each after those that it needs."""
    s, v = system.switching, system.structure.values
    found: list[Clock] = []
    for condition, needs in zip(s.timed, s.needs, strict=True):
        modes = [mode for i in needs for mode in s.timed[i].modes]
        inputs = [v.time, v.modes[modes] if modes else ca.SX(0, 1), system.inputs[1]]
        slope = ca.jacobian(condition.argument, v.time)
        found.append(Clock(condition, needs, inputs, slope))
    return found


@made_once
def clock_parameters(system: System) -> np.ndarray:
    """Places of the parameters on which clocks depend."""
    arguments = ca.vertcat(ca.SX(0, 1), *(clock.condition.argument for clock in clocks(system)))
    _, columns = ca.jacobian_sparsity(arguments, system.inputs[1]).get_triplet()
    return np.unique(np.array(columns, dtype=int))


@made_once
def _latest(system: System) -> Recent[np.ndarray]:
    """Modes found last."""
    return Recent(1)


def modes_at(system: System, theta: np.ndarray, time: float) -> np.ndarray:
    """Modes at a time, or just after it where it is an instant of change.

    Modes that depend on more than the time are zero.
    """
    key = theta[clock_parameters(system)].tobytes(), time
    return _latest(system).of(key, lambda: _modes_at(system, theta, time)).copy()


def _modes_at(system: System, theta: np.ndarray, time: float) -> np.ndarray:
    modes = np.zeros(system.structure.mode_count)
    for found, function in _levels(system):
        both = function(time, modes, theta)[0].reshape(2, -1).T
        near = both[:, 0] + both[:, 1] * max(1e-300, 1e-15 * abs(time))
        for clock, place, slope, later in zip(found, *both.T.tolist(), near, strict=True):
            number = clock.number(np.array([later]))
            if later == place == 0.0 and slope and clock.condition.pieces is None:
                number = np.array([int(slope > 0)])
            modes[clock.condition.modes] = clock.settings(number)[0]
    return modes


@made_once
def _levels(system: System) -> list[tuple[list[Clock], ArrayFunction]]:
    """Clocks of a system that need only those before them, with their arguments and slopes."""
    all_clocks, v, levels = clocks(system), system.structure.values, list[list[Clock]]()
    depth: list[int] = []
    for clock in all_clocks:
        depth.append(1 + max((depth[i] for i in clock.needs), default=-1))
        if depth[-1] == len(levels):
            levels.append([])
        levels[depth[-1]].append(clock)
    inputs = [v.time, v.modes, system.inputs[1]]
    made = []
    for level in levels:
        rows = [ca.horzcat(clock.condition.argument, clock.slope) for clock in level]
        function = ca.Function("clocks", inputs, [ca.densify(ca.vertcat(*rows))])
        made.append((level, ArrayFunction(function)))
    return made


@made_once
def plain_clocks(system: System) -> tuple[list[int], ArrayFunction]:
    """Numbers of relations that are linear in the time and need no others; (time, parameters)."""
    both = {
        k: (clock.condition.argument, clock.slope)
        for k, clock in enumerate(clocks(system))
        if clock.condition.pieces is None and not clock.needs and clock.even
    }
    columns = zip(*both.values(), strict=True)
    outputs = [ca.densify(ca.vertcat(ca.SX(0, 1), *column)) for column in columns]
    inputs = [system.structure.values.time, system.inputs[1]]
    return list(both), ArrayFunction(ca.Function("plain", inputs, outputs))


@dataclass(frozen=True, eq=False)
class MovedClocks:
    """Clocks that move with some parameters.

    Attributes
    ----------
    are_plain : bool
        Whether all that move are linear in the time and no other needs them; if not, `numbers` is
        empty.
    numbers : list of int
        Numbers of these clocks.
    relations : list of (int, bool)
        Mode of each, and whether it is false where its sides are equal.
    function : Function
        Their arguments, then the slopes of these by time: (x, p, t, m) -> (2 k,).
    """

    are_plain: bool
    numbers: list[int]
    relations: list[tuple[int, bool]]
    function: ca.Function


def find_moved_clocks(system: System, varied: ca.SX) -> MovedClocks:
    """Clocks that move with parameters, given as symbols."""
    everything = clocks(system)
    moved = [
        k
        for k, clock in enumerate(everything)
        if varied.numel() and ca.depends_on(clock.condition.argument, varied)
    ]
    needed = {i for clock in everything for i in clock.needs}
    are_plain = all(
        everything[k].condition.pieces is None and everything[k].even and not everything[k].needs
        for k in moved
    ) and needed.isdisjoint(moved)
    chosen = moved if are_plain else []
    own = [everything[k] for k in chosen]
    columns = [ca.SX(0, 1), *(c.condition.argument for c in own), *(c.slope for c in own)]
    function = ca.Function("at", system.inputs, [ca.densify(ca.vertcat(*columns))])
    relations = [(c.condition.mode, bool(c.condition.relation.strict)) for c in own]
    return MovedClocks(are_plain, chosen, relations, function)
