"""How derivatives of states jump where a run stops: the rules for all who differentiate runs."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.flattening import hold_modes
from lumped.gradients.causes import Cause, Causes, Instant, Stop
from lumped.gradients.instant_values import looks_of, margin_sizes, rates_along
from lumped.gradients.jumps import Crossing, EventDerivatives, Side
from lumped.gradients.legs import SmoothParts
from lumped.gradients.state_changes import Changes
from lumped.support.made_once import made_once
from lumped.timeloop.results.event import Event
from lumped.timeloop.results.trajectory import Trajectory

_SHARING = (hold_modes.COMPLIANCE, hold_modes.SHARE)
_MOST = 4
"""Different causes at one instant whose orders are all followed."""
_AT_ONCE = 1e-10
"""Part of a run within which changes are at the same instant."""


class Saltation:
    """Jumps of the derivatives of one system."""

    def __init__(self, system: System) -> None:
        self.system, self.changes, self._looks = system, Changes(system), looks_of(system)
        self._causes, self._rates = Causes(system, self._looks), rates_along(system)
        s = system.switching
        self._count = system.structure.mode_count
        self._sharing = np.concatenate([s.first_modes + i for i in _SHARING])
        self._jumping = {jump.name for jump in s.jumps}

    def between(self, course: SmoothParts, accuracy: np.ndarray) -> list[Crossing]:
        """Derivatives where each of the smooth parts but the first begins.

        Parameters
        ----------
        accuracy : ndarray, shape (legs, margins)
            How well each margin is known in each of them.

        Raises
        ------
        SolverError
            If there are none.
        """
        run, legs = course.run, course.legs
        t = np.array([leg.t[0] for leg in legs[1:]])
        old, new = [leg.side(-1) for leg in legs[:-1]], [leg.side(0) for leg in legs[1:]]
        (x_old, m_old), (x_new, m_new) = (
            tuple(map(np.array, zip(*sides, strict=True))) for sides in (old, new)
        )
        values = self._looks.along(x_old, run.theta, t, m_old)
        after = self._rates(x_new, run.theta, t, m_new)
        events: dict[float, list[Event]] = {}
        for event in run.events:
            events.setdefault(event.time, []).append(event)
        found = []
        for k, time in enumerate(t.tolist()):
            at, own = Instant(run, time, old[k], new[k]), events.get(time, ())
            found.append(self._at(Stop(at, values[k], after[k], accuracy[k], own)))
        return found

    def _at(self, stop: Stop) -> Crossing:
        """Derivatives at an instant."""
        at, t, old, new = stop.at, stop.at.t, stop.at.old, stop.at.new
        if self._shares_anew(old, new):
            return Crossing(t, ())
        causes = self._causes.of(stop)
        if len(causes) <= 1:
            if (old[0] == new[0]).all():
                self._refuse_return(stop)
            if not causes:  # an instant that does not move
                causes = [Cause((), np.zeros(len(old[0]) + len(at.run.theta)), stop.names, ())]
            return Crossing(t, ((self._jump(at, causes[0], stop.rates_after),),))
        names = list(dict.fromkeys(n for cause in causes for n in cause.names))
        owned = {mode for cause in causes for mode in cause.modes}
        changed = np.flatnonzero(old[1][: self._count] != new[1][: self._count])
        if len(causes) > _MOST or not set(changed.tolist()) <= owned:
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s changes of {', '.join(names)} coincide, and "
                "which comes first depends on the parameters; this is followed only where each "
                "change is that of its own component alone. Change a parameter a little, so that "
                "one comes first.",
                at.run,
            )
        return Crossing(t, self._orders(at, causes))

    def _shares_anew(self, old: Side, new: Side) -> bool:
        """Whether nothing changes but how redundant constraints share what they carry."""
        before, after = (side[1][: self._count] for side in (old, new))
        if (before[self._sharing] == after[self._sharing]).all():
            return False
        positions = self.system.switching.positions
        same = (positions(before) == positions(after)).all()
        # yielding comes to rest
        return bool(same and np.allclose(old[0], new[0], rtol=1e-9, atol=1e-6))

    def join(
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
        left = self._looks.at(old[0], run.theta, one.t, old[1]).margins
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
            Cause(j.used, j.instant, j.names, j.modes, None, self._plain(run, one.t, j, waits))
            for j in jumps
        ]
        return Crossing(other.t, self._orders(Instant(run, one.t, old, new), causes))

    def _plain(
        self, run: Trajectory, t: float, jump: EventDerivatives, waits: list[int]
    ) -> tuple[np.ndarray, float] | None:
        """Derivatives of the margin of a jump as it is where it matters, if it has waited."""
        if not set(jump.used) & set(waits):
            return None
        (x, settings), margin = jump.before, jump.used[0]
        values = self._looks.at(x, run.theta, t, settings)
        by_both = self._looks.margin_slopes(values, margin)
        rate = float(values.margin_rates[margin])
        return by_both, rate - float(by_both[: len(x)] @ values.rates)

    def _row(self, at: Instant, cause: Cause) -> np.ndarray:
        """Derivatives of the instant of a cause, with the rates before it.

        Raises
        ------
        SolverError
            If it would not come.
        """
        if cause.gap is not None or not cause.used:
            return cause.row
        values = self._looks.at(at.old[0], at.run.theta, at.t, at.old[1])
        if cause.plain is None:
            slopes = self._looks.margin_slopes(values, cause.used[0])
            rate = float(values.margin_rates[cause.used[0]])
        else:
            slopes, by_time = cause.plain
            rate = float(slopes[: len(values.rates)] @ values.rates) + by_time
        if not rate < 0:
            raise SolverError(
                f"{self.system.name}: at t = {at.t:.9g} s changes coincide, and "
                f"{', '.join(cause.names)} would not change if another came first; the run has no "
                "derivative there.",
                at.run,
            )
        return -slopes / rate

    def _refuse_return(self, stop: Stop) -> None:
        """Refuse an instant at which a condition changes and changes back."""
        now = [e for e in stop.events if e.kind == "condition"]
        now = [e for e in now if e.component not in self._jumping]  # it may undo its own condition
        changes = {(e.component, e.before, e.after) for e in now}
        back = [e.component for e in now if (e.component, e.after, e.before) in changes]
        if back:
            names = ", ".join(dict.fromkeys(back))
            raise SolverError(
                f"{self.system.name}: at t = {stop.at.t:.9g} s ({names}) different changes "
                "coincide: a condition changes and changes back at once. "
                "Which comes first depends on the parameters, so the run has no derivative there.",
                stop.at.run,
            )

    def _orders(
        self, at: Instant, causes: Sequence[Cause]
    ) -> tuple[tuple[EventDerivatives, ...], ...]:
        """Jumps of several causes in every order."""
        return tuple(self._order_jumps(at, order) for order in itertools.permutations(causes))

    def _order_jumps(self, at: Instant, causes: tuple[Cause, ...]) -> tuple[EventDerivatives, ...]:
        """Jumps of several causes in this order."""
        jumps: list[EventDerivatives] = []
        run, t, side, new = at
        for number, cause in enumerate(causes):
            cause = cause._replace(row=self._row(at._replace(old=side), cause))
            settings = side[1].copy()
            settings[list(cause.modes)] = new[1][list(cause.modes)]
            after = new
            if number < len(causes) - 1:
                after = self._strike(run, t, side, settings, cause), settings
            rates = self._rates(after[0][None, :], run.theta, np.array([t]), after[1][None, :])[0]
            jumps.append(self._jump(Instant(run, t, side, after), cause, rates))
            side = after
        return tuple(jumps)

    def _strike(
        self, run: Trajectory, t: float, side: Side, settings: np.ndarray, cause: Cause
    ) -> np.ndarray:
        """States after one of several causes: the first that is possible."""
        for act in self.changes.acts(cause.used, side[1], settings):
            return self.changes.states(*act, settings).at(side[0], run.theta, t, side[1])[0]
        return side[0]

    def _jump(self, at: Instant, cause: Cause, rates_after: np.ndarray) -> EventDerivatives:
        """Derivatives across what one cause changes."""
        run, t, old, new = at
        for act in self.changes.acts(cause.used, old[1], new[1]):
            change = self.changes.states(*act, new[1])
            x, by_x, by_p, along = change.at(old[0], run.theta, t, old[1])
            gap = np.abs(x - new[0]) / (1.0 + np.abs(new[0]))
            if gap.max(initial=0.0) < 1e-7:
                break
        else:
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s several changes follow each other at once "
                f"({', '.join(cause.names)}); derivatives are not followed across that.",
                run,
            )
        drift = along - rates_after
        s = self.system.switching
        lets_go = {h for kind, h in (s.rows[i] for i in cause.used) if kind in ("upper", "lower")}
        shared = any(old[1][s.first_modes[h] + hold_modes.COMPLIANCE] > 0 for h in lets_go)
        settles = cause.gap is not None
        if cause.gap is not None:  # the states stay where the gap is zero
            by_gap, gap_by_p = np.split(cause.gap, [len(drift)])
            across = -by_gap / (by_gap @ by_gap)
            shifts = [v.multiply_transposed(by_gap[:, None]).ravel() for v in (by_x, by_p)]
            by_x, by_p = by_x.with_outer(across, shifts[0]), by_p.with_outer(across, shifts[1])
            by_p = by_p.with_outer(across, gap_by_p)
            drift = drift + across * (by_gap @ drift)
        sides, margins = (old, new), (cause.used, cause.modes)
        return EventDerivatives(
            by_x, by_p, drift, cause.row, cause.names, shared, *sides, act, settles, *margins
        )


@made_once
def saltation_of(system: System) -> Saltation:
    """Jumps of the derivatives of a system."""
    return Saltation(system)


def crossings_of(course: SmoothParts) -> list[Crossing]:
    """How derivatives jump where each smooth part of a run but the first begins.

    Raises
    ------
    SolverError
        Where the run has no derivatives.
    """
    if len(course.legs) < 2:
        return []
    run, sizes, saltation = course.run, margin_sizes(course), saltation_of(course.run.system)
    found = saltation.between(course, course.rtol * sizes)
    soon = _AT_ONCE * course.until
    for k in range(len(found) - 1):
        if found[k + 1].t - found[k].t <= soon and found[k].orders:
            accuracy = max(course.rtol, _AT_ONCE) * sizes[k]
            both = saltation.join(run, found[k], found[k + 1], accuracy)
            if both is not None:
                found[k], found[k + 1] = Crossing(found[k].t, ()), both
    return found
