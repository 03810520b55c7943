"""How derivatives of states jump where a run stops: the rules for all who differentiate runs."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import casadi as ca
import numpy as np
import scipy

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.flattening import hold_modes
from lumped.gradients.jumps import Crossing, EventDerivatives, Side
from lumped.gradients.state_changes import Blow, Changes
from lumped.support.made_once import made_once
from lumped.timeloop.instants import clocks
from lumped.timeloop.result import Trajectory

__all__ = ["TURNING", "saltation_of"]

_Place = tuple[np.ndarray, np.ndarray, float, np.ndarray]
"""States, parameters, time, settings."""

TURNING = 10.0
"""Margins that turn back before they cross, or soon after, by less than so many tolerances of the
run, relative to their size before, are only touched."""

_TOUCHED = 10
"""Margins count as used up within so many of their tolerances."""

_RESTING = 1e-12
"""Height, m or rad, of bounces that are rounding."""

_SHARING = (hold_modes.COMPLIANCE, hold_modes.SHARE)
_MOST = 4
"""Different causes at one instant whose orders are all followed."""


class _Cause(NamedTuple):
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


class Saltation:
    """Jumps of the derivatives of one system."""

    def __init__(self, system: System) -> None:
        self.system, self.changes = system, Changes(system)
        self.inputs = system.inputs
        x, p, t, _ = self.inputs
        self.clocks = [clock for clock in clocks(system) if clock.moves]
        arguments = ca.vertcat(ca.SX(0, 1), *(c.condition.argument for c in self.clocks))
        slopes = [ca.densify(ca.jacobian(arguments, by)) for by in (t, p)]
        self.clocked = ca.Function("clocked", self.inputs, [ca.densify(arguments), *slopes])
        margins = system.structure.in_states(system.switching.margins[0])
        by_both = ca.jacobian(margins, ca.vertcat(x, p))
        self.margins = ca.Function("margins", self.inputs, [by_both])
        along = ca.vertcat(system.rates, 1)
        rates = ca.jtimes(margins, ca.vertcat(x, t), along)
        speeds = system.structure.in_states(system.switching.speed)
        by_both = ca.densify(ca.jacobian(speeds, ca.vertcat(x, p)))
        self.speeds = ca.Function("speeds", self.inputs, [by_both])
        self.bends = ca.Function(
            "bends", self.inputs, [ca.densify(ca.jtimes(rates, ca.vertcat(x, t), along))]
        )

    def at(
        self, run: Trajectory, t: float, old: Side, new: Side, rtol: float, sizes: np.ndarray
    ) -> Crossing:
        """Derivatives at an instant between two sides.

        Parameters
        ----------
        rtol : float
            Relative accuracy of the run.
        sizes : ndarray
            How large each margin was before.

        Raises
        ------
        SolverError
            If there are none.
        """
        if self._shares_anew(old, new):
            return Crossing(t, ())
        causes = self._causes(run, t, old, new, rtol * sizes)
        if len(causes) <= 1 and (old[0] == new[0]).all():
            self._refuse_return(run, t)
        if len(causes) <= 1:
            cause = causes[0] if causes else self._fixed(run, t, new)
            return Crossing(t, ((self._jump(run, t, old, new, cause),),))
        names = list(dict.fromkeys(n for cause in causes for n in cause.names))
        owned = {mode for cause in causes for mode in cause.modes}
        changed = np.flatnonzero(old[1][: self._count] != new[1][: self._count])
        if len(causes) > _MOST or not set(changed.tolist()) <= owned:
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s changes of {', '.join(names)} coincide, and "
                "which comes first depends on the parameters; this is followed only where each "
                "change is that of its own component alone. Change a parameter a little, so that "
                "one comes first.",
                run,
            )
        orders = [self._ordered(run, t, old, new, o) for o in itertools.permutations(causes)]
        return Crossing(t, tuple(orders))

    def _shares_anew(self, old: Side, new: Side) -> bool:
        """Whether nothing changes but how redundant constraints share what they carry."""
        switching = self.system.switching
        before, after = (side[1][: self._count] for side in (old, new))
        yields = np.concatenate([switching.first_modes + i for i in _SHARING])
        same = (switching.positions(before) == switching.positions(after)).all()
        same = same and np.allclose(old[0], new[0], rtol=1e-9, atol=1e-6)  # yielding comes to rest
        return bool(same and (before[yields] != after[yields]).any())

    def joined(
        self, run: Trajectory, one: Crossing, other: Crossing, accuracy: np.ndarray
    ) -> Crossing | None:
        """Two crossings at the same instant, in both orders; None if they are one after the other.

        Parameters
        ----------
        accuracy : ndarray
            How well each margin is known.

        Raises
        ------
        SolverError
            If they coincide, but not all orders can be followed.
        """
        jumps = (*one.orders[0], *other.orders[0])
        owned = [mode for jump in jumps for mode in jump.modes]
        if not all(jump.modes for jump in jumps) or len(set(owned)) < len(owned):
            return None
        old, new = jumps[0].before, jumps[-1].after
        left = np.asarray(self.system.margins(old[0], run.theta, one.t, old[1])[0]).ravel()
        changed = np.flatnonzero(old[1][: self._count] != new[1][: self._count])
        waits = [i for jump in jumps for i in jump.used if left[i] > 1e3 * accuracy[i]]
        if waits and self.system.switching.rows[waits[0]][0] != "relation":
            return None
        if len(jumps) > _MOST or not set(changed.tolist()) <= set(owned):
            names = ", ".join(dict.fromkeys(name for jump in jumps for name in jump.names))
            raise SolverError(
                f"{self.system.name}: at t = {one.t:.9g} s different changes coincide ({names}), "
                "and which comes first depends on the parameters; this is followed only where each "
                "change is that of its own component alone. Change a parameter a little.",
                run,
            )
        causes = [
            _Cause(j.used, j.instant, j.names, j.modes, None, self._plain(run, one.t, j, waits))
            for j in jumps
        ]
        orders = [self._ordered(run, one.t, old, new, o) for o in itertools.permutations(causes)]
        return Crossing(other.t, tuple(orders))

    def _plain(
        self, run: Trajectory, t: float, jump: EventDerivatives, waits: list[int]
    ) -> tuple[np.ndarray, float] | None:
        """Derivatives of the margin of a jump as it is where it matters, if it has waited."""
        if not set(jump.used) & set(waits):
            return None
        x, settings = jump.before
        point, margin = (x, run.theta, t, settings), jump.used[0]
        by_both = _sparse(self.margins(*point))[[margin]].toarray().ravel()
        rates = np.asarray(self.system.rhs(*point)).ravel()
        rate = float(np.asarray(self.system.margin_rates(*point)).ravel()[margin])
        return by_both, rate - float(by_both[: len(x)] @ rates)

    def _plain_row(self, run: Trajectory, t: float, side: Side, cause: _Cause) -> np.ndarray:
        """Derivatives of the instant of such a margin, with the rates of a side."""
        assert cause.plain is not None
        by_both, by_time = cause.plain
        rates = np.asarray(self.system.rhs(side[0], run.theta, t, side[1])).ravel()
        rate = float(by_both[: len(rates)] @ rates) + by_time
        if not rate < 0:
            raise self._dependent(run, t, cause.names)
        found: np.ndarray = -by_both / rate
        return found

    def _dependent(self, run: Trajectory, t: float, names: tuple[str, ...]) -> SolverError:
        return SolverError(
            f"{self.system.name}: at t = {t:.9g} s changes coincide, and {', '.join(names)} "
            "would not change if another came first; the run has no derivative there.",
            run,
        )

    def _refuse_return(self, run: Trajectory, t: float) -> None:
        """Refuse an instant at which a condition changes and changes back."""
        words = {"<", "<=", ">", ">="}
        now = [e for e in run.events if e.time == t and words & set(e.before.split(" "))]
        jumping = {jump.name for jump in self.system.switching.jumps}
        now = [e for e in now if e.component not in jumping]  # a jump may undo its own condition
        told = {(e.component, e.before, e.after) for e in now}
        back = [e.component for e in now if (e.component, e.after, e.before) in told]
        if back:
            names = ", ".join(dict.fromkeys(back))
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s ({names}) different changes coincide: a "
                "condition changes and changes back at once. "
                "Which comes first depends on the parameters, so the run has no derivative there.",
                run,
            )

    @property
    def _count(self) -> int:
        return self.system.structure.mode_count

    def _ordered(
        self, run: Trajectory, t: float, old: Side, new: Side, causes: tuple[_Cause, ...]
    ) -> tuple[EventDerivatives, ...]:
        """Jumps of several causes in this order."""
        jumps: list[EventDerivatives] = []
        side = old
        for number, cause in enumerate(causes):
            if cause.plain is not None:
                cause = cause._replace(row=self._plain_row(run, t, side, cause))
            elif cause.used and cause.gap is None:
                cause = cause._replace(row=self._row(run, t, side, list(cause.used), cause.names))
            settings = side[1].copy()
            settings[list(cause.modes)] = new[1][list(cause.modes)]
            if number == len(causes) - 1:
                after = new
            else:
                after = self._struck(run, t, side, settings, cause), settings
            jumps.append(self._jump(run, t, side, after, cause))
            side = after
        return tuple(jumps)

    def _struck(
        self, run: Trajectory, t: float, side: Side, settings: np.ndarray, cause: _Cause
    ) -> np.ndarray:
        """States after one of several causes: the first that is possible."""
        for act in self._acts(cause.used, side[1], settings):
            function = self.changes.states(*act, settings)
            return np.asarray(function(side[0], run.theta, t, side[1])[0]).ravel()
        return side[0]

    def _jump(
        self, run: Trajectory, t: float, old: Side, new: Side, cause: _Cause
    ) -> EventDerivatives:
        """Derivatives across what one cause changes."""
        theta, point = run.theta, (old[0], run.theta, t, old[1])
        for act in self._acts(cause.used, old[1], new[1]):
            x, by_states, by_parameters, along = self.changes.states(*act, new[1])(*point)
            gap = np.abs(np.asarray(x).ravel() - new[0]) / (1.0 + np.abs(new[0]))
            if gap.max(initial=0.0) < 1e-7:
                break
        else:
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s several changes follow each other at once "
                f"({', '.join(cause.names)}); derivatives are not followed across that.",
                run,
            )
        after = np.asarray(self.system.rhs(new[0], theta, t, new[1])).ravel()
        drift = np.asarray(along).ravel() - after
        s = self.system.switching
        lets_go = {h for kind, h in (s.rows[i] for i in cause.used) if kind in ("upper", "lower")}
        shared = any(old[1][s.first_modes[h] + hold_modes.COMPLIANCE] > 0 for h in lets_go)
        by_x, by_p = _sparse(by_states), _sparse(by_parameters)
        settles = cause.gap is not None
        if cause.gap is not None:
            by_gap, gap_by_p = np.split(cause.gap, [len(drift)])
            along_gap = by_gap / (by_gap @ by_gap)
            kept = scipy.sparse.csc_array(np.eye(len(drift)) - np.outer(along_gap, by_gap))
            by_x, drift = kept @ by_x, kept @ drift
            by_p = kept @ by_p - scipy.sparse.csc_array(np.outer(along_gap, gap_by_p))
        return EventDerivatives(
            by_x,
            by_p,
            drift,
            cause.row,
            cause.names,
            shared,
            old,
            new,
            act,
            settles,
            cause.used,
            cause.modes,
        )

    def _fixed(self, run: Trajectory, t: float, new: Side) -> _Cause:
        """An instant that does not move."""
        return _Cause((), np.zeros(len(new[0]) + len(run.theta)), _happening(run, t), ())

    def _causes(
        self, run: Trajectory, t: float, old: Side, new: Side, accuracy: np.ndarray
    ) -> list[_Cause]:
        """Why the run stops here: one cause for each instant that can move by itself."""
        point = (old[0], run.theta, t, old[1])
        changed = old[1][: self._count] != new[1][: self._count]
        causes = self._timed(run, point, changed)
        left, tolerance = (np.asarray(v).ravel() for v in self.system.margins(*point))
        rates = np.asarray(self.system.margin_rates(*point)).ravel()
        smooth = self._smooth(point, new)
        near = left <= _TOUCHED * tolerance
        resting = near & self._resting(point, new, rates)
        used = np.flatnonzero((near & (rates < 0)) | resting).tolist()
        for i in self._acting(used, old, new, changed):
            if resting[i]:
                causes.append(self._settled(point, i))
                continue
            row = self._row(run, t, old, [i], self._names([i]))
            if not smooth and self._grazes(point, i, row, rates[i], accuracy[i]):
                raise SolverError(
                    f"{self.system.name}: at t = {t:.9g} s {', '.join(self._names([i]))} only "
                    "touches what changes it, within the accuracy of the run; there is no "
                    "derivative there. Tighten rtol if it does cross, or change a parameter.",
                    run,
                )
            causes.append(_Cause((i,), row, self._names([i]), self._modes(i)))
        if not causes and changed.any() and not smooth:
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s modes change "
                f"({', '.join(_happening(run, t))}), but what changes them is touched without "
                "being crossed; the run has no derivative there.",
                run,
            )
        sizes = np.concatenate([1.0 + np.abs(old[0]), np.abs(run.theta)])
        return _merged(causes, sizes, self._shared_limits(old))

    def _shared_limits(self, old: Side) -> set[int]:
        """Margins of limits whose reaction redundant constraints share."""
        s = self.system.switching
        return {
            i
            for i, (kind, h) in enumerate(s.rows)
            if kind in ("upper", "lower") and old[1][s.first_modes[h] + hold_modes.COMPLIANCE] > 0
        }

    def _timed(self, run: Trajectory, point: _Place, changed: np.ndarray) -> list[_Cause]:
        """Functions of time that change their piece."""
        place, slope, by_parameters = (np.asarray(v) for v in self.clocked(*point))
        causes, touching = [], []
        for k, clock in enumerate(self.clocks):
            modes = tuple(clock.condition.modes)
            if not changed[list(modes)].any():
                continue
            here, fast = float(place[k, 0]), float(slope[k, 0])
            number = clock.number(np.array([here]))
            borders = clock.border(np.concatenate([number, number + 1]))
            off = np.abs(borders - here).min()
            if off > 1e-9 * (1.0 + abs(here) + abs(fast)):
                continue  # it jumped there, because something else changed
            if fast == 0.0:  # it rests on its border until something else changes
                touching.append(clock.condition.name)
                continue
            row = np.append(np.zeros(len(point[0])), -by_parameters[k] / fast)
            causes.append(_Cause((), row, (clock.condition.name,), modes))
        if touching and not causes:
            raise SolverError(
                f"{self.system.name}: at t = {point[2]:.9g} s a function of time in "
                f"{', '.join(touching)} touches the border at which it changes; the run has no "
                "derivative there.",
                run,
            )
        return causes

    def _smooth(self, point: _Place, new: Side) -> bool:
        """Whether states and rates are the same on both sides, so that no change matters."""
        rates = [
            np.asarray(self.system.rhs(x, *point[1:3], m)).ravel()
            for x, m in ((point[0], point[3]), new)
        ]
        size = np.abs(rates[0]).max(initial=0.0)
        same = bool((point[0] == new[0]).all())
        return same and bool(np.abs(rates[0] - rates[1]).max(initial=0.0) <= 1e-9 * (1 + size))

    def _resting(self, point: _Place, new: Side, rates: np.ndarray) -> np.ndarray:
        """Margins of gaps that close after ever smaller bounces, to rest."""
        s, found = self.system.switching, np.zeros(len(rates), dtype=bool)
        for i, (kind, h) in enumerate(s.rows):
            found[i] = kind == "slide" and s.has_gap[h] and new[1][s.first_modes[h]] > 0.5
        if found.any():
            bends = np.asarray(self.bends(*point)).ravel()
            found &= (bends < 0) & (rates**2 <= -2 * bends * _RESTING)
        return found

    def _settled(self, point: _Place, margin: int) -> _Cause:
        """A gap that closes to rest: the instant is that of its standstill.

        Its speed is rounding then, so that the gap does not tell the instant any more.
        """
        bend = float(np.asarray(self.bends(*point)).ravel()[margin])
        gap = _sparse(self.margins(*point))[[margin]].toarray().ravel()
        speed = np.asarray(self.speeds(*point))[self.system.switching.rows[margin][1]]
        return _Cause((margin,), -speed / bend, self._names([margin]), self._modes(margin), gap)

    def _acting(self, used: list[int], old: Side, new: Side, changed: np.ndarray) -> list[int]:
        """Margins that are used up and whose modes or states change."""
        s, found = self.system.switching, []
        jumping = {jump.mode for jump in s.jumps}
        for i in used:
            kind, k = s.rows[i]
            if kind == "relation":
                mode = int(s.relation_modes[k])
                own = changed[list(s.conditions[k].modes)].any()
                acts = own or (mode in jumping and not old[1][mode])
            else:
                first = int(s.first_modes[k])
                acts = changed[first : first + hold_modes.COUNT].any() or (
                    kind == "slide" and s.has_gap[k]
                )
            if acts:
                found.append(i)
        return found

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

    def _names(self, margins: list[int]) -> tuple[str, ...]:
        s, names = self.system.switching, []
        for kind, k in (s.rows[i] for i in margins):
            names.append(s.relation_text(k, True)[0] if kind == "relation" else s.names[k])
        return tuple(dict.fromkeys(names))

    def _row(
        self, run: Trajectory, t: float, side: Side, used: list[int], names: tuple[str, ...]
    ) -> np.ndarray:
        """Derivatives of the instant at which a margin is used up."""
        point = (side[0], run.theta, t, side[1])
        rate = float(np.asarray(self.system.margin_rates(*point)).ravel()[used[0]])
        if not rate < 0:
            raise self._dependent(run, t, names)
        row = _sparse(self.margins(*point))[[used[0]]].toarray().ravel()
        found: np.ndarray = -row / rate
        return found

    def _grazes(
        self,
        point: _Place,
        margin: int,
        row: np.ndarray,
        rate: float,
        accuracy: float,
    ) -> bool:
        """Whether a margin would turn back within the accuracy of the run."""
        bend = float(np.asarray(self.bends(*point)).ravel()[margin])
        if bend <= 0:
            return False
        return bool(rate**2 / (2 * bend) <= TURNING * accuracy)

    def _acts(
        self, used: tuple[int, ...], old: np.ndarray, new: np.ndarray
    ) -> Iterator[tuple[tuple[int, ...], Blow | None]]:
        """What may become of the states: `when` statements, and bodies that hit each other."""
        s = self.system.switching
        rows = [s.rows[i] for i in used]
        risen = {int(s.relation_modes[k]) for kind, k in rows if kind == "relation"}
        risen |= set(np.flatnonzero(new > old).tolist())
        jumps = tuple(j for j, w in enumerate(s.jumps) if w.mode in risen and not old[w.mode])
        impulsive = ~(s.has_upper & s.has_lower)
        was, now = (side[s.first_modes] > 0.5 for side in (old, new))
        bodies = {h for kind, h in rows if kind == "slide" and s.has_gap[h]}
        hits = sorted(bodies | set(np.flatnonzero(now & ~was & impulsive).tolist()))
        for stay in (was & impulsive, was & now & impulsive) if hits else ():
            members = tuple(sorted({*hits, *np.flatnonzero(stay).tolist()}))
            # what sticks afterwards did not bounce
            for bounces in (tuple(not now[h] for h in hits), (True,) * len(hits)):
                yield jumps, Blow(tuple(zip(hits, map(bool, bounces), strict=True)), members)
        if not bodies:
            yield jumps, None


@made_once
def saltation_of(system: System) -> Saltation:
    """Jumps of the derivatives of a system."""
    return Saltation(system)


def _merged(causes: list[_Cause], sizes: np.ndarray, shared: set[int]) -> list[_Cause]:
    """Causes whose instants move alike are one, and so are limits of one shared reaction."""
    found: list[_Cause] = []
    for cause in causes:
        for i, other in enumerate(found):
            both = np.abs(np.array([cause.row, other.row]) * sizes)
            apart = np.abs((cause.row - other.row) * sizes).max(initial=0.0)
            alike = apart <= 1e-6 * (1e-6 + both.max(initial=0.0))
            share = {*cause.used, *other.used} <= shared and cause.used and other.used
            if alike or share:
                names = tuple(dict.fromkeys((*other.names, *cause.names)))
                modes = tuple(dict.fromkeys((*other.modes, *cause.modes)))
                found[i] = _Cause((*other.used, *cause.used), other.row, names, modes)
                break
        else:
            found.append(cause)
    return found


def _happening(run: Trajectory, t: float) -> tuple[str, ...]:
    """Components with an event at an instant."""
    names = [n for e in run.events if e.time == t for n in e.component.split(", ")]
    return tuple(dict.fromkeys(names))


def _sparse(matrix: ca.DM) -> scipy.sparse.csc_array:
    return scipy.sparse.csc_array(ca.DM(matrix).sparse())
