"""How derivatives of states jump where a run stops: the rules for all who differentiate runs."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import NamedTuple

import casadi as ca
import numpy as np
import scipy

from lumped.analysis.changes import Blow, Changes
from lumped.analysis.result import Trajectory
from lumped.errors import SolverError
from lumped.system import System

__all__ = ["TURNING", "Crossing", "Jump", "Saltation", "Side"]

Side = tuple[np.ndarray, np.ndarray]
"""States and settings on one side of an instant."""

TURNING = 10.0
"""Margins that turn back before they cross, or soon after, by less than so many tolerances of the
run, relative to what cancels in them, are only touched."""

_TOUCHED = 10
"""Margins count as used up within so many of their tolerances."""

_RESTING = 1e-12
"""Height, m or rad, of bounces that are rounding."""

_MOST = 4
"""Different causes at one instant whose orders are all followed."""


class Jump(NamedTuple):
    """Derivatives at an instant ``t(x, p)`` at which something changes; its own are `instant`.

    Sensitivities S become ``states S + parameters + drift t_p``. Leine and Nijmeijer, Dynamics and
    Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7.

    Attributes
    ----------
    states, parameters : scipy.sparse.csc_array, shapes (n, n) and (n, p)
        Of the states after it by those before it and by the parameters.
    drift : ndarray, shape (n,)
        What a later instant adds to the states: ``g_x f_before + g_t - f_after``.
    instant : ndarray, shape (n + p,)
        Derivatives of the instant by states and parameters; zero if it is fixed.
    names : tuple of str
        Components that change.
    shared : bool
        Statically indeterminate constraints let go; the derivatives hold their shares fixed.
    before, after : tuple of ndarray
        States and settings on both sides.
    act : tuple or None
        The `when` statements, and what closes at a speed.
    """

    states: scipy.sparse.csc_array
    parameters: scipy.sparse.csc_array
    drift: np.ndarray
    instant: np.ndarray
    names: tuple[str, ...]
    shared: bool
    before: Side
    after: Side
    act: tuple[tuple[int, ...], Blow | None]

    def forward(self, S: np.ndarray, seed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Sensitivities after it, shape (n, k), and of the instant, (k,).

        Parameters
        ----------
        S, seed : ndarray, shapes (n, k) and (p, k)
            Derivatives of states and parameters by what is varied.
        """
        t_p = self.instant @ np.vstack([S, seed])
        return self.states @ S + self.parameters @ seed + np.outer(self.drift, t_p), t_p

    def backward(self, adjoint: np.ndarray, late: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The transposed: adjoints before it and what it adds by parameters.

        Parameters
        ----------
        adjoint : ndarray, shape (n, k)
            Derivatives of k results by the states after it.
        late : ndarray, shape (k,)
            Derivatives of the results by the instant itself.
        """
        n = len(self.drift)
        weight = self.drift @ adjoint + late
        before = self.states.T @ adjoint + np.outer(self.instant[:n], weight)
        return before, self.parameters.T @ adjoint + np.outer(self.instant[n:], weight)


Part = tuple[Jump, np.ndarray, np.ndarray]
"""A jump, the derivatives of its instant, and those by which integrals gain."""


class Passed(NamedTuple):
    """Sensitivities after an instant, and those of the instants of its parts, shape (k,) each.

    Attributes
    ----------
    S : ndarray, shape (n, k)
        Sensitivities.
    parts : list
        Jumps and derivatives of their instants.
    gains : list
        The same in every order, with those of the order that each column takes.
    """

    S: np.ndarray
    parts: list[Part]
    every: list[Part] | None = None

    @property
    def gains(self) -> list[Part]:
        return self.parts if self.every is None else self.every


class Crossing(NamedTuple):
    """What happens at one instant, in every order in which its parts can come.

    Attributes
    ----------
    t : float
        Instant, s.
    orders : tuple of tuple of Jump
        Jumps one after the other; several orders if different causes coincide.
    """

    t: float
    orders: tuple[tuple[Jump, ...], ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Components that change."""
        return tuple(dict.fromkeys(n for jump in self.orders[0] for n in jump.names))

    def forward(self, S: np.ndarray, seed: np.ndarray, side: int) -> Passed:
        """Sensitivities after it.

        Parameters
        ----------
        side : {1, -1}
            Whether what is varied grows or shrinks, which decides what comes first.
        """
        S_new, parts = self._followed(self.orders[0], S, seed)
        if len(self.orders) == 1:
            return Passed(S_new, parts)
        chosen = np.zeros(S.shape[1], dtype=bool)
        every = []
        for order in self.orders:
            after, own = self._followed(order, S, seed)
            times = side * np.array([slopes for _, slopes, _ in own])
            rounding = 1e-9 * np.abs(times).max(axis=0)
            fits = (np.diff(times, axis=0) >= -rounding).all(axis=0) & ~chosen
            chosen |= fits
            S_new[:, fits] = after[:, fits]
            # integrals gain by this order for its own columns only
            every += [(jump, slopes, np.where(fits, slopes, 0.0)) for jump, slopes, _ in own]
            for i, (jump, slopes, gained) in enumerate(parts):
                same = next(s for j, s, _ in own if j.names == jump.names)
                parts[i] = jump, np.where(fits, same, slopes), gained
        return Passed(S_new, parts, every)

    @staticmethod
    def _followed(
        order: tuple[Jump, ...], S: np.ndarray, seed: np.ndarray
    ) -> tuple[np.ndarray, list[Part]]:
        parts = []
        for jump in order:
            S, t_p = jump.forward(S, seed)
            parts.append((jump, t_p, t_p))
        return S, parts


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
    """

    used: tuple[int, ...]
    row: np.ndarray
    names: tuple[str, ...]
    modes: tuple[int, ...]
    gap: np.ndarray | None = None


class Saltation:
    """Jumps of the derivatives of one system."""

    def __init__(self, system: System) -> None:
        self.system, self.changes = system, Changes(system)
        self.inputs = system._inputs
        x, p, t, _ = self.inputs
        thresholds, _ = system._flat.thresholds
        at = thresholds(p)
        self.thresholds = ca.Function("at", [p], [at, ca.jacobian(at, p)])
        margins = system._in_states(system.switching.margins[0])
        by_both = ca.jacobian(margins, ca.vertcat(x, p))
        self.margins = ca.Function("margins", self.inputs, [by_both])
        along = ca.vertcat(system.rates, 1)
        rates = ca.jtimes(margins, ca.vertcat(x, t), along)
        speeds = system._in_states(system.switching.speed)
        by_both = ca.densify(ca.jacobian(speeds, ca.vertcat(x, p)))
        self.speeds = ca.Function("speeds", self.inputs, [by_both])
        self.bends = ca.Function(
            "bends", self.inputs, [ca.densify(ca.jtimes(rates, ca.vertcat(x, t), along))]
        )

    @classmethod
    def of(cls, system: System) -> Saltation:
        """That of a system, made once."""
        if "saltation" not in system.made:
            system.made["saltation"] = cls(system)
        made: Saltation = system.made["saltation"]
        return made

    def at(self, run: Trajectory, t: float, old: Side, new: Side, rtol: float) -> Crossing:
        """Derivatives at an instant between two sides.

        Parameters
        ----------
        rtol : float
            Relative accuracy of the run.

        Raises
        ------
        SolverError
            If there are none.
        """
        causes = self._causes(run, t, old, new, rtol)
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

    @property
    def _count(self) -> int:
        return self.system._flat.mode_count

    def _ordered(
        self, run: Trajectory, t: float, old: Side, new: Side, causes: tuple[_Cause, ...]
    ) -> tuple[Jump, ...]:
        """Jumps of several causes in this order."""
        jumps: list[Jump] = []
        side = old
        for number, cause in enumerate(causes):
            if cause.used and number:
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

    def _jump(self, run: Trajectory, t: float, old: Side, new: Side, cause: _Cause) -> Jump:
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
        shared = any(old[1][s.first_modes[h] + 3] > 0 for h in lets_go)
        derivatives = [_sparse(by_states), _sparse(by_parameters)]
        if cause.gap is not None:
            by_gap, by_p = np.split(cause.gap, [len(drift)])
            along_gap = by_gap / (by_gap @ by_gap)
            kept = scipy.sparse.csc_array(np.eye(len(drift)) - np.outer(along_gap, by_gap))
            moved = scipy.sparse.csc_array(np.outer(along_gap, by_p))
            drift, derivatives = (
                kept @ drift,
                [kept @ derivatives[0], kept @ derivatives[1] - moved],
            )
        return Jump(*derivatives, drift, cause.row, cause.names, shared, old, new, act)

    def _fixed(self, run: Trajectory, t: float, new: Side) -> _Cause:
        """An instant that does not move."""
        return _Cause((), np.zeros(len(new[0]) + len(run.theta)), _happening(run, t), ())

    def _causes(self, run: Trajectory, t: float, old: Side, new: Side, rtol: float) -> list[_Cause]:
        """Why the run stops here: one cause for each instant that can move by itself."""
        point = (old[0], run.theta, t, old[1])
        at, by_parameters = self.thresholds(run.theta)
        at, n = np.asarray(at).ravel(), len(old[0])
        changed = old[1][: self._count] != new[1][: self._count]
        causes: list[_Cause] = []
        owners = _happening(run, t, timed=True)
        near = np.abs(at - t) <= 1e-12 * (1.0 + t)
        for i in np.flatnonzero(changed[: len(at)] & near).tolist():
            row = np.append(np.zeros(n), _sparse(by_parameters)[[i]].toarray().ravel())
            causes.append(_Cause((), row, owners, (i,)))
        left, tolerance = (np.asarray(v).ravel() for v in self.system.margins(*point))
        rates = np.asarray(self.system.margin_rates(*point)).ravel()
        used = np.flatnonzero((left <= _TOUCHED * tolerance) & (rates < 0)).tolist()
        for i in self._acting(used, old, new, changed):
            row = self._row(run, t, old, [i], self._names([i]))
            if self._grazes(point, i, row, rates[i], rtol):
                raise SolverError(
                    f"{self.system.name}: at t = {t:.9g} s {', '.join(self._names([i]))} only "
                    "touches what changes it, within the accuracy of the run; there is no "
                    "derivative there. Tighten rtol if it does cross, or change a parameter.",
                    run,
                )
            cause = _Cause((i,), row, self._names([i]), self._modes(i))
            causes.append(self._settled(run, t, old, new, rates[i], cause))
        if not causes and changed.any() and not near.any():
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s modes change "
                f"({', '.join(_happening(run, t))}), but what changes them is touched without "
                "being crossed; the run has no derivative there.",
                run,
            )
        sizes = np.concatenate([1.0 + np.abs(old[0]), np.abs(run.theta)])
        return _merged(causes, sizes)

    def _settled(
        self, run: Trajectory, t: float, old: Side, new: Side, rate: float, cause: _Cause
    ) -> _Cause:
        """A gap that closes after ever smaller bounces: the instant is that of its standstill.

        Its speed is rounding then, so that the gap does not tell the instant any more.
        """
        s, point = self.system.switching, (old[0], run.theta, t, old[1])
        (margin,) = cause.used
        kind, h = s.rows[margin]
        if kind != "slide" or not s.has_gap[h] or not new[1][s.first_modes[h]] > 0.5:
            return cause
        bend = float(np.asarray(self.bends(*point)).ravel()[margin])
        if not (bend < 0 and rate**2 <= -2 * bend * _RESTING):
            return cause
        gap = _sparse(self.margins(*point))[[margin]].toarray().ravel()
        speed = np.asarray(self.speeds(*point))[h]
        return cause._replace(row=-speed / bend, gap=gap)

    def _acting(self, used: list[int], old: Side, new: Side, changed: np.ndarray) -> list[int]:
        """Margins that are used up and whose modes or states change."""
        s, found = self.system.switching, []
        jumping = {jump.mode for jump in s.jumps}
        for i in used:
            kind, k = s.rows[i]
            if kind == "relation":
                mode = int(s.relation_modes[k])
                acts = changed[mode] or (mode in jumping and not old[1][mode])
            else:
                first = int(s.first_modes[k])
                acts = changed[first : first + 5].any() or (kind == "slide" and s.has_gap[k])
            if acts:
                found.append(i)
        return found

    def _modes(self, margin: int) -> tuple[int, ...]:
        """Modes that belong to a margin."""
        s = self.system.switching
        kind, k = s.rows[margin]
        if kind != "relation":
            first = int(s.first_modes[k])
            return tuple(range(first, first + 5))
        mode = int(s.relation_modes[k])
        engaged = [int(s.first_modes[h]) for h in np.flatnonzero(s.engaged == mode)]
        return (mode, *(first + i for first in engaged for i in range(5)))

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
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s changes coincide, and {', '.join(names)} "
                "would not change if another came first; the run has no derivative there.",
                run,
            )
        row = _sparse(self.margins(*point))[[used[0]]].toarray().ravel()
        found: np.ndarray = -row / rate
        return found

    def _grazes(
        self,
        point: tuple[np.ndarray, np.ndarray, float, np.ndarray],
        margin: int,
        row: np.ndarray,
        rate: float,
        rtol: float,
    ) -> bool:
        """Whether a margin would turn back within the accuracy of the run."""
        bend = float(np.asarray(self.bends(*point)).ravel()[margin])
        if bend <= 0:
            return False
        size = float(np.abs(row * rate) @ np.abs(np.concatenate([point[0], point[1]])))
        return bool(rate**2 / (2 * bend) <= TURNING * rtol * size)

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


def _merged(causes: list[_Cause], sizes: np.ndarray) -> list[_Cause]:
    """Causes whose instants move alike are one."""
    found: list[_Cause] = []
    for cause in causes:
        for i, other in enumerate(found):
            both = np.abs(np.array([cause.row, other.row]) * sizes)
            apart = np.abs((cause.row - other.row) * sizes).max(initial=0.0)
            if apart <= 1e-6 * (1e-6 + both.max(initial=0.0)):
                names = tuple(dict.fromkeys((*other.names, *cause.names)))
                modes = tuple(dict.fromkeys((*other.modes, *cause.modes)))
                found[i] = _Cause((*other.used, *cause.used), other.row, names, modes)
                break
        else:
            found.append(cause)
    return found


def _happening(run: Trajectory, t: float, timed: bool = False) -> tuple[str, ...]:
    """Components with an event at an instant; those of functions of time alone if `timed`."""
    names = []
    for event in run.events:
        if event.time == t and not (timed and (event.before or event.after)):
            names += event.component.split(", ")
    return tuple(dict.fromkeys(names))


def _sparse(matrix: ca.DM) -> scipy.sparse.csc_array:
    return scipy.sparse.csc_array(ca.DM(matrix).sparse())
