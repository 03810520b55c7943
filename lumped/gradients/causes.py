"""Why a run stops at an instant, and how that instant moves with states and parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.flattening import hold_modes
from lumped.gradients.instant_values import InstantLooks, InstantValues
from lumped.gradients.jumps import Side
from lumped.kernel.instants.impacts import LOWEST
from lumped.support.array_function import ArrayFunction
from lumped.support.made_once import Shared, made_once
from lumped.timeloop.holds import Holds
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.trajectory import Trajectory

TURNING = 10.0
"""Margins that turn back before they cross, or soon after, by less than so many tolerances of the
run, relative to their size before, are only touched."""

_TOUCHED = 10
"""Margins count as used up within so many of their tolerances."""

_RESTING, _LEAST_AGAIN = 1e-12, 0.1
"""Height, m or rad, from which what does not bounce closes by rounding alone; restitution from
which on what closes did bounce before."""


class Instant(NamedTuple):
    """An instant of a run at which something changes.

    Attributes
    ----------
    run : Trajectory
        The run.
    t : float
        When, s.
    old, new : tuple of ndarray
        States and settings on both sides.
    """

    run: Trajectory
    t: float
    old: Side
    new: Side


class Stop(NamedTuple):
    """An instant at which a run stops.

    Attributes
    ----------
    at : Instant
        When, and both sides.
    values : InstantValues
        What decides changes, before it.
    rates_after : ndarray, shape (n,)
        Derivatives of the states after it.
    accuracy : ndarray, shape (margins,)
        How well each margin is known.
    events : sequence of Event
        What the run tells of it.
    """

    at: Instant
    values: InstantValues
    rates_after: np.ndarray
    accuracy: np.ndarray
    events: Sequence[Event]

    @property
    def names(self) -> tuple[str, ...]:
        """Components with an event."""
        return tuple(dict.fromkeys(n for e in self.events for n in e.component.split(", ")))


class Cause(NamedTuple):
    """One reason why a run stops.

    Attributes
    ----------
    used : tuple of int
        Margins that are used up.
    row : ndarray, shape (n + p,)
        Derivatives of the instant.
    names : tuple of str
        Components.
    modes : tuple of int
        What changes with it.
    gap : ndarray or None, shape (n + p,)
        Derivatives of a gap that closes at the end of ever smaller bounces.
    plain : tuple or None
        Derivatives by states, parameters and time of a margin that only matters after another
        change.
    """

    used: tuple[int, ...]
    row: np.ndarray
    names: tuple[str, ...]
    modes: tuple[int, ...]
    gap: np.ndarray | None = None
    plain: tuple[np.ndarray, float] | None = None


class Causes(Shared):
    """Causes of the changes of one system."""

    def __init__(self, system: System, looks: InstantLooks) -> None:
        super().__init__()
        self.system, self.looks, s = system, looks, system.switching
        self._count = system.structure.mode_count
        self._timed_modes = [m for c in looks.clocks for m in c.condition.modes]
        self._gaps = [i for i, (kind, h) in enumerate(s.rows) if kind == "slide" and s.has_gap[h]]
        self._gap_modes = s.first_modes[[s.rows[i][1] for i in self._gaps]]
        self._jumping = {jump.mode for jump in s.jumps}

    def of(self, stop: Stop) -> list[Cause]:
        """Why a run stops: one cause for each instant that can move by itself.

        Raises
        ------
        SolverError
            If what changes is only touched.
        """
        old, new, values = stop.at.old, stop.at.new, stop.values
        changed = old[1][: self._count] != new[1][: self._count]
        causes = self._find_timed(stop, changed)
        near = values.margins <= _TOUCHED * values.tolerances
        resting = near & self._resting(stop)
        used = np.flatnonzero((near & (values.margin_rates < 0)) | resting).tolist()
        for i in self._acting(used, old, changed):
            if resting[i]:
                causes.append(self._find_rest(stop, i))
                continue
            row = self.row(values, i)
            if self._grazes(stop, i) and not _is_smooth(stop):
                raise SolverError(
                    f"{self.system.name}: at t = {stop.at.t:.9g} s {', '.join(self.names(i))} only "
                    "touches what changes it, within the accuracy of the run; there is no "
                    "derivative there. Tighten rtol if it does cross, or change a parameter.",
                    stop.at.run,
                )
            causes.append(Cause((i,), row, self.names(i), self._modes(i)))
        if not causes and changed.any() and not _is_smooth(stop):
            raise SolverError(
                f"{self.system.name}: at t = {stop.at.t:.9g} s modes change "
                f"({', '.join(stop.names)}), but what changes them is touched without "
                "being crossed; the run has no derivative there.",
                stop.at.run,
            )
        if len(causes) < 2:
            return causes
        sizes = np.concatenate([1.0 + np.abs(old[0]), np.abs(stop.at.run.theta)])
        return _merge_causes(causes, sizes, self._find_shared_limits(old))

    def row(self, values: InstantValues, margin: int) -> np.ndarray:
        """Derivatives of the instant at which a margin is used up."""
        found: np.ndarray = self.looks.margin_slopes(values, margin) / -values.margin_rates[margin]
        return found

    @made_once
    def names(self, margin: int) -> tuple[str, ...]:
        """The component of a margin."""
        s = self.system.switching
        kind, k = s.rows[margin]
        return (s.relation_text(k, True)[0] if kind == "relation" else s.names[k],)

    def _find_shared_limits(self, old: Side) -> set[int]:
        """Margins of limits whose reaction redundant constraints share."""
        s = self.system.switching
        return {
            i
            for i, (kind, h) in enumerate(s.rows)
            if kind in ("upper", "lower") and old[1][s.first_modes[h] + hold_modes.COMPLIANCE] > 0
        }

    def _find_timed(self, stop: Stop, changed: np.ndarray) -> list[Cause]:
        """Functions of time that change their piece."""
        if not changed[self._timed_modes].any():
            return []
        causes, touching = [], []
        for k, clock in enumerate(self.looks.clocks):
            modes = tuple(clock.condition.modes)
            if not changed[list(modes)].any():
                continue
            here, fast = float(stop.values.places[k]), float(stop.values.fast[k])
            number = clock.number(np.array([here]))
            borders = clock.border(np.concatenate([number, number + 1]))
            off = np.abs(borders - here).min()
            if off > 1e-9 * (1.0 + abs(here) + abs(fast)):
                continue  # it jumped there, because something else changed
            if fast == 0.0:  # it rests on its border until something else changes
                touching.append(clock.condition.name)
                continue
            row = self.looks.clock_slopes(stop.values, k) / -fast
            causes.append(Cause((), row, (clock.condition.name,), modes))
        if touching and not causes:
            raise SolverError(
                f"{self.system.name}: at t = {stop.at.t:.9g} s a function of time in "
                f"{', '.join(touching)} touches the border at which it changes; the run has no "
                "derivative there.",
                stop.at.run,
            )
        return causes

    def _resting(self, stop: Stop) -> np.ndarray:
        """Margins of gaps that close after ever smaller bounces, to rest."""
        values = stop.values
        found = np.zeros(len(values.margins), dtype=bool)
        if not self._gaps:
            return found
        found[self._gaps] = stop.at.new[1][self._gap_modes] > 0.5
        if found.any():
            (x, settings), s = stop.at.old, self.system.switching
            count = self.system.structure.mode_count
            look = Holds(self.system, stop.at.run.theta).look(
                stop.at.t, x, settings[:count], settings[count:]
            )
            again = look.restitution[[s.rows[i][1] for i in self._gaps]]
            height = np.full(len(found), _RESTING)
            height[self._gaps] = LOWEST / np.maximum(again, _LEAST_AGAIN) ** 2
            height[self._gaps] = np.where(again > _LEAST_AGAIN, height[self._gaps], _RESTING)
            found &= values.bends < 0
            found &= values.margin_rates**2 <= -2 * values.bends * height
        return found

    @property
    @made_once
    def _speeds(self) -> tuple[ArrayFunction, np.ndarray, np.ndarray]:
        """Derivatives of the speeds of holds by states and parameters; their rows and columns."""
        x, p, _, _ = self.system.inputs
        speeds = self.system.structure.in_states(self.system.switching.speed)
        slopes = ca.jacobian(speeds, ca.vertcat(x, p))
        rows, columns = (np.array(v, dtype=int) for v in slopes.sparsity().get_triplet())
        return ArrayFunction(ca.Function("speeds", self.system.inputs, [slopes])), rows, columns

    def _find_rest(self, stop: Stop, margin: int) -> Cause:
        """A gap that closes to rest: the instant is that of its standstill.

        Its speed is rounding then, so that the gap does not tell the instant any more.
        """
        bend = float(stop.values.bends[margin])
        gap = self.looks.margin_slopes(stop.values, margin)
        call, rows, columns = self._speeds
        slopes = call(stop.at.old[0], stop.at.run.theta, stop.at.t, stop.at.old[1])[0]
        own = rows == self.system.switching.rows[margin][1]
        speed = np.zeros(len(gap))
        speed[columns[own]] = slopes[own]
        return Cause((margin,), -speed / bend, self.names(margin), self._modes(margin), gap)

    def _acting(self, used: list[int], old: Side, changed: np.ndarray) -> list[int]:
        """Margins that are used up and whose modes or states change."""
        s, found = self.system.switching, []
        for i in used:
            kind, k = s.rows[i]
            if kind == "relation":
                mode = int(s.relation_modes[k])
                own = changed[list(s.conditions[k].modes)].any()
                acts = own or (mode in self._jumping and not old[1][mode])
            else:
                first = int(s.first_modes[k])
                acts = changed[first : first + hold_modes.COUNT].any() or (
                    kind == "slide" and s.has_gap[k]
                )
            if acts:
                found.append(i)
        return found

    @made_once
    def _modes(self, margin: int) -> tuple[int, ...]:
        """Modes that belong to a margin."""
        s = self.system.switching
        kind, k = s.rows[margin]
        if kind != "relation":
            first = int(s.first_modes[k])
            return tuple(range(first, first + hold_modes.COUNT))
        mode = int(s.relation_modes[k])
        engaged = [int(s.first_modes[h]) for h in np.flatnonzero(s.engaged == mode)]
        return (
            *s.conditions[k].modes,
            *(first + i for first in engaged for i in range(hold_modes.COUNT)),
        )

    def _grazes(self, stop: Stop, margin: int) -> bool:
        """Whether a margin would turn back within the accuracy of the run."""
        bend = float(stop.values.bends[margin])
        if bend <= 0:
            return False
        rate = float(stop.values.margin_rates[margin])
        return bool(rate**2 / (2 * bend) <= TURNING * stop.accuracy[margin])


def _is_smooth(stop: Stop) -> bool:
    """Whether states and rates are the same on both sides, so that no change matters."""
    rates = stop.values.rates
    size = np.abs(rates).max(initial=0.0)
    same = bool((stop.at.old[0] == stop.at.new[0]).all())
    apart = np.abs(rates - stop.rates_after).max(initial=0.0)
    return same and bool(apart <= 1e-9 * (1 + size))


def _merge_causes(causes: list[Cause], sizes: np.ndarray, shared: set[int]) -> list[Cause]:
    """Causes whose instants move alike are one, and so are limits of one shared reaction."""
    found: list[Cause] = []
    for cause in causes:
        for i, other in enumerate(found):
            both = np.abs(np.array([cause.row, other.row]) * sizes)
            apart = np.abs((cause.row - other.row) * sizes).max(initial=0.0)
            alike = apart <= 1e-6 * (1e-6 + both.max(initial=0.0))
            share = {*cause.used, *other.used} <= shared and cause.used and other.used
            if alike or share:
                names = tuple(dict.fromkeys((*other.names, *cause.names)))
                modes = tuple(dict.fromkeys((*other.modes, *cause.modes)))
                found[i] = Cause((*other.used, *cause.used), other.row, names, modes)
                break
        else:
            found.append(cause)
    return found
