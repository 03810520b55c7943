"""Steady rotation about which a drive vibrates: its states over the angle of a shaft."""

from __future__ import annotations

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from lumped.compiler.structure import Name
from lumped.compiler.system import System
from lumped.errors import OptionError, SolverError
from lumped.flattening.hold_modes import STUCK
from lumped.support.arrays import Boolean, Integer, Real
from lumped.support.made_once import made_once
from lumped.timeloop.plants.many_points import ManyPoints
from lumped.timeloop.results.operating_point import OperatingPoint

_ROUNDING = 1e-12
"""Relative difference of states and parameters that is rounding."""


@dataclass(frozen=True, eq=False)
class Rotation:
    """States of a drive that turns steadily at each of many speeds.

    Attributes
    ----------
    system : System
        What turns.
    shaft : str or None
        Angle of the shaft whose speed is given; None if none is.
    speeds : ndarray, shape (k,)
        Speeds of that shaft, rad/s.
    x : ndarray, shape (k, n)
        States where its angle is that of the operating point.
    theta : ndarray, shape (k, p)
        Parameters.
    settings : ndarray, shape (k, m)
        Modes.
    turning : ndarray, shape (n,)
        By what each state grows with that angle; zero if nothing depends on it.
    turns : int
        Turns after which everything repeats.
    points : tuple of OperatingPoint
        Operating points that were given or found: one, or one for each speed.
    is_given : bool
        The user gave them.
    balancing : str or None
        Parameter that lets mean torques balance.
    """

    system: System
    shaft: str | None
    speeds: Real
    x: Real
    theta: Real
    settings: Real
    turning: Real
    turns: int
    points: tuple[OperatingPoint, ...]
    is_given: bool
    balancing: str | None = None

    @property
    def time(self) -> float:
        """Instant at which functions of time are taken, s."""
        return self.points[0].time

    def at(self, k: int) -> Rotation:
        """The rotation at one of the speeds."""
        return self.part(np.array([k]))

    def part(self, own: Integer) -> Rotation:
        """The rotation at some of the speeds, by their numbers."""
        points = self.points
        if len(points) > 1:
            points = tuple(points[k] for k in own.tolist())
        return replace(
            self,
            speeds=self.speeds[own],
            x=self.x[own],
            theta=self.theta[own],
            settings=self.settings[own],
            points=points,
        )

    def on_lines(self, speeds: Real) -> Rotation:
        """The rotation at other speeds: states and parameters on lines between its own."""
        own = np.clip(np.searchsorted(self.speeds, speeds, "right") - 1, 0, len(self.speeds) - 1)
        x, theta = (
            np.array([np.interp(speeds, self.speeds, column) for column in part.T])
            .reshape(part.shape[1], len(speeds))
            .T
            for part in (self.x, self.theta)
        )
        return replace(self.part(own), speeds=speeds, x=x, theta=theta)

    @property
    def turns_matter(self) -> bool:
        """Whether anything depends on the angle."""
        return bool(self.turning.any())

    @property
    def idle(self) -> Boolean:
        """States on which no rate depends, such as angles that were asked for, shape (n,)."""
        structure = self.system.structure
        return np.isin(structure.states, list(structure.cyclic))

    @property
    def standing(self) -> tuple[str, ...]:
        """Speeds that holds keep at zero, which rates, all zero, alone would not tell."""
        switching, structure = self.system.switching, self.system.structure
        sticks = self.settings[0, switching.first_modes + STUCK] > 0.5
        held = zip(switching.speeds, sticks, strict=True)
        nodes = {node for node, is_held in held if is_held and node >= 0}
        return tuple(structure.node_name(node) for node in sorted(nodes))

    @property
    def plane(self) -> Real | None:
        """Two numbers of each speed on which states and parameters depend linearly, shape (k, 2).

        None if there are no such numbers, or the settings differ.
        """
        if (self.settings != self.settings[0]).any():
            return None
        every = np.hstack([self.x, self.theta])
        size = np.abs(every).max(axis=0)
        every = every[:, np.ptp(every, axis=0) > _ROUNDING * (size + 1)]
        if every.shape[1] < 2:
            return np.hstack([every, np.zeros((len(every), 2 - every.shape[1]))])
        apart = (every - every.mean(axis=0)) / np.abs(every).max(axis=0)
        found, sizes, _ = np.linalg.svd(apart, full_matrices=False)
        return None if (sizes[2:] > _ROUNDING * sizes[0]).any() else found[:, :2] * sizes[:2]

    def along(self, k: int, angles: Real) -> tuple[Real, Real]:
        """States and settings at one speed and at angles, shapes (samples, n) and (samples, m)."""
        x = self.x[k] + angles[:, None] * self.turning
        return x, find_settings(self.system, x, self.theta[k], self.settings[k], self.time)


def find_settings(system: System, x: Real, theta: Real, settings: Real, time: float) -> Real:
    """Settings at states, shape (points, m): conditions as their sides say, holds as given.

    Raises
    ------
    SolverError
        If conditions contradict each other.
    """
    found = np.broadcast_to(settings, (len(x), len(settings))).copy()
    switching = system.switching
    count = len(switching.relation_modes)
    if not count:
        return found
    sides, t = _sides(system), np.full(len(x), time)
    for _ in range(count + 2):
        both, before = sides(x, theta, t, found), found.copy()
        switching.begin(found, both[:, :count], both[:, count:])
        if np.array_equal(found, before):
            return found
    raise SolverError(
        f"{system.name}: conditions contradict each other where the drive turns steadily, so that "
        "no linearisation exists there. Compute a periodic motion (lumped.periodic) instead."
    )


@made_once
def _sides(system: System) -> ManyPoints:
    s = system.switching
    found = system.structure.in_states(ca.vertcat(s.greater, s.less))
    return ManyPoints(ca.Function("sides", system.inputs, [ca.densify(found)]))


def speed_of(system: System, shaft: Name) -> str:
    """Name of the speed that belongs to an angle.

    Raises
    ------
    OptionError
        If no quantity is its rate.
    """
    structure = system.structure
    node = structure.reduced.node(structure.tree.unknown(shaft))
    if node is not None and node + 1 in structure.members:
        aliases, unknown = structure.reduced.aliases, structure.members[node + 1]
        if aliases.signs[unknown] == aliases.signs[structure.tree.unknown(shaft)]:
            return structure.tree.unknown_name(unknown)
    raise OptionError(
        f"{system.name}: shaft={system.key(shaft)!r} is no angle whose speed is a quantity of the "
        "model. Name the angle of an inertia, such as 'crank.phi'."
    )
