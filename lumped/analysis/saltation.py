"""How derivatives of states jump where a run stops."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import casadi as ca
import numpy as np
import scipy

from lumped.analysis.instants import clocks
from lumped.analysis.result import Trajectory
from lumped.errors import SolverError
from lumped.system import System

__all__ = ["Jump", "Saltation", "coincide"]

Side = tuple[np.ndarray, np.ndarray]
"""States and settings on one side of an instant."""

_TOUCHED = 10
"""Margins count as used up within so many of their tolerances."""


class Jump(NamedTuple):
    """Derivatives at an instant ``t(x, p)`` at which the run stops; its own are ``t_x``, ``t_p``.

    Sensitivities S become ``states S + parameters + drift (t_x S + t_p)``. Leine and Nijmeijer,
    Dynamics and Bifurcations of Non-Smooth Mechanical Systems, 2004, ch. 7.

    Attributes
    ----------
    states, parameters : scipy.sparse.csc_array, shapes (n, n) and (n, p)
        Of the states after it by those before it and by the parameters.
    drift : ndarray, shape (n,)
        What a later instant adds to the states: ``g_x f_before + g_t - f_after``.
    instants : ndarray, shape (r, n + p)
        Derivatives of the instant by states and parameters, one row for each that stops the run
        there; no row if it is fixed.
    shared : bool
        Statically indeterminate constraints let go; the derivatives hold their shares fixed.
    """

    states: scipy.sparse.csc_array
    parameters: scipy.sparse.csc_array
    drift: np.ndarray
    instants: np.ndarray
    shared: bool

    def forward(self, S: np.ndarray, seed: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """Sensitivities after it, shape (n, k), and of the instant, (k,); None if ambiguous.

        Parameters
        ----------
        S, seed : ndarray, shapes (n, k) and (p, k)
            Derivatives of states and parameters by what is varied.
        """
        found = self.instants @ np.vstack([S, seed])
        if _differ(found):
            return None
        t_p = found[0] if len(found) else np.zeros(S.shape[1])
        return self.states @ S + self.parameters @ seed + np.outer(self.drift, t_p), t_p

    def backward(
        self, adjoint: np.ndarray, late: np.ndarray, size: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """The transposed: adjoints before it and what it adds by parameters; None if ambiguous.

        Parameters
        ----------
        adjoint : ndarray, shape (n, k)
            Derivatives of k results by the states after it.
        late : ndarray, shape (k,)
            Derivatives of the results by the instant itself.
        size : ndarray, shape (n + p,)
            Sizes of states and parameters.
        """
        if _differ(self.instants * size):
            return None
        n = len(self.drift)
        before, by_parameters = self.states.T @ adjoint, self.parameters.T @ adjoint
        if len(self.instants):
            weight = self.drift @ adjoint + late
            before = before + np.outer(self.instants[0, :n], weight)
            by_parameters = by_parameters + np.outer(self.instants[0, n:], weight)
        return before, by_parameters


def _differ(rows: np.ndarray) -> bool:
    """Whether derivatives of one instant contradict each other."""
    if len(rows) < 2:
        return False
    return bool(np.ptp(rows, axis=0).max() > 1e-6 * (1e-6 + np.abs(rows).max()))


def coincide(run: Trajectory, t: float) -> SolverError:
    """What is raised where derivatives of an instant contradict each other."""
    return SolverError(
        f"{run.system.name}: at t = {t:.9g} s different changes coincide (see run.events); "
        "which comes first depends on the parameters, so the run has no derivative there.",
        run,
    )


class _Impact(NamedTuple):
    """Constraints that close, those that take impulses, whether any bounces, modes after it."""

    hits: tuple[int, ...]
    members: tuple[int, ...]
    bounce: bool
    modes: np.ndarray


class Saltation:
    """Jumps of the derivatives of one system."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.inputs = system._inputs
        x, p, _, _ = self.inputs
        self.clocks = [clock for clock in clocks(system) if clock.moves]
        arguments = ca.vertcat(ca.SX(0, 1), *(c.condition.argument for c in self.clocks))
        slopes = [ca.densify(ca.jacobian(arguments, by)) for by in (self.inputs[2], p)]
        self.clocked = ca.Function("clocked", self.inputs, [ca.densify(arguments), *slopes])
        margins = system._in_states(system.switching.margins[0])
        by_both = ca.jacobian(margins, ca.vertcat(x, p))
        self.margins = ca.Function("margins", self.inputs, [by_both])
        self._made: dict[object, ca.Function] = {}

    @classmethod
    def of(cls, system: System) -> Saltation:
        """That of a system, made once."""
        if "saltation" not in system.made:
            system.made["saltation"] = cls(system)
        made: Saltation = system.made["saltation"]
        return made

    def at(self, run: Trajectory, t: float, old: Side, new: Side) -> Jump:
        """Derivatives at an instant between two sides.

        Raises
        ------
        SolverError
            If there are none.
        """
        theta, point = run.theta, (old[0], run.theta, t, old[1])
        instants, used = self._instant(run, t, old, new)
        for function in self._changes(used, old, new):
            x, by_states, by_parameters, drift = function(*point)
            gap = np.abs(np.asarray(x).ravel() - new[0]) / (1.0 + np.abs(new[0]))
            if gap.max(initial=0.0) < 1e-7:
                break
        else:
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s several changes follow each other at once "
                "(see run.events); derivatives are not followed across that.",
                run,
            )
        after = np.asarray(self.system.rhs(new[0], theta, t, new[1])).ravel()
        late = np.asarray(drift).ravel() - after
        s = self.system.switching
        lets_go = {h for kind, h in (s.rows[i] for i in used) if kind in ("upper", "lower")}
        shared = any(old[1][s.first_modes[h] + 3] > 0 for h in lets_go)
        return Jump(_sparse(by_states), _sparse(by_parameters), late, instants, shared)

    def _instant(
        self, run: Trajectory, t: float, old: Side, new: Side
    ) -> tuple[np.ndarray, list[int]]:
        """Derivatives of an instant, and which margins are used up there."""
        system, point = self.system, (old[0], run.theta, t, old[1])
        count, n = system._flat.mode_count, len(old[0])
        changed = old[1][:count] != new[1][:count]
        left, tolerance = (np.asarray(v).ravel() for v in system.margins(*point))
        rates = np.asarray(system.margin_rates(*point)).ravel()
        used = np.flatnonzero((left <= _TOUCHED * tolerance) & (rates < 0)).tolist()
        rows = self._timed(run, point, changed)
        if len(rows):
            return np.hstack([np.zeros((len(rows), n)), rows]), used
        if used:
            rows = _sparse(self.margins(*point))[used].toarray()
            return -rows / rates[used, None], used
        if changed.any():
            raise SolverError(
                f"{system.name}: at t = {t:.9g} s modes change, but what changes them is "
                "touched without being crossed; the run has no derivative there.",
                run,
            )
        return np.zeros((0, n + len(run.theta))), used

    def _timed(self, run: Trajectory, point: tuple[object, ...], changed: np.ndarray) -> np.ndarray:
        """Derivatives by the parameters of an instant at which functions of time change."""
        place, slope, by_parameters = (np.asarray(v) for v in self.clocked(*point))
        rows = []
        for k, clock in enumerate(self.clocks):
            if not changed[clock.condition.mode]:
                continue
            here, fast = float(place[k, 0]), float(slope[k, 0])
            number = clock.number(np.array([here]))
            borders = clock.border(np.concatenate([number, number + 1]))
            off = np.abs(borders - here).min()
            if off > 1e-9 * (1.0 + abs(here) + abs(fast)):
                continue  # it jumped there, because something else changed
            if fast == 0.0:
                raise SolverError(
                    f"{self.system.name}: at t = {point[2]:.9g} s a function of time in "
                    f"{clock.condition.name} touches the border at which it changes; the run has "
                    "no derivative there.",
                    run,
                )
            rows.append(-by_parameters[k] / fast)
        return np.array(rows).reshape(len(rows), len(run.theta))

    def _changes(self, used: list[int], old: Side, new: Side) -> Iterator[ca.Function]:
        """What may become of the states: (x, p, t, m) -> states, derivatives by x and p, drift."""
        s = self.system.switching
        rows = [s.rows[i] for i in used]
        risen = {int(s.relation_modes[k]) for kind, k in rows if kind == "relation"}
        risen |= set(np.flatnonzero(new[1] > old[1]).tolist())
        jumps = tuple(j for j, w in enumerate(s.jumps) if w.mode in risen and not old[1][w.mode])
        impulsive = ~(s.has_upper & s.has_lower)
        was, now = (side[1][s.first_modes] > 0.5 for side in (old, new))
        bodies = {h for kind, h in rows if kind == "slide" and s.has_gap[h]}
        hits = bodies | set(np.flatnonzero(now & ~was & impulsive).tolist())
        for stay in (was & impulsive, was & now & impulsive) if hits else ():
            for bounce in (True, False):
                members = np.flatnonzero(stay).tolist()
                impact = _Impact(
                    tuple(sorted(hits)), tuple(sorted({*hits, *members})), bounce, new[1]
                )
                yield self._change(jumps, impact)
        if not bodies:
            yield self._change(jumps, None)

    def _change(self, jumps: tuple[int, ...], impact: _Impact | None) -> ca.Function:
        """One possible change: of `when` statements, and of bodies that hit each other."""
        count = self.system._flat.mode_count
        key = jumps, impact and (*impact[:3], impact.modes[:count].tobytes())
        if key not in self._made:
            x, p, t, _ = self.inputs
            rates = self.system.rates
            x_new = ca.SX(x)
            place = {node: i for i, node in enumerate(self.system.states)}
            values = self.system._in_states(self.system.switching.values)
            for j in jumps:
                jump = self.system.switching.jumps[j]
                for i, (node, sign) in enumerate(zip(jump.nodes, jump.signs, strict=True)):
                    if node in place:
                        x_new[place[node]] = sign * values[jump.first + i]
            if impact is not None:
                x_new = x_new + self._impulse(x_new, impact)
            drift = ca.jtimes(x_new, ca.vertcat(x, t), ca.vertcat(rates, 1))
            outputs = [x_new, ca.jacobian(x_new, x), ca.jacobian(x_new, p), ca.densify(drift)]
            self._made[key] = ca.Function("change", self.inputs, outputs)
        return self._made[key]

    def _impulse(self, x: ca.SX, impact: _Impact) -> ca.SX:
        """Jump of the states where constraints close (see `Impacts` for the law)."""
        s, count = self.system.switching, self.system._flat.mode_count
        _, p, t, m = self.inputs
        rest = ca.vertcat(ca.SX(ca.DM(impact.modes[:count])), m[count:])
        both = self.system._in_states(ca.horzcat(s.speed, s.restitution))
        closing = ca.Function("closing", self.inputs, [both])(x, p, t, m)
        for h, first in enumerate(s.first_modes.tolist()):
            rest[first : first + 5] = ca.DM([h in impact.members, 0, 0, 0, 0])
        push = ca.SX(rest)
        for h in impact.hits:
            again = 1 + closing[h, 1] if impact.bounce else 1
            push[int(s.first_modes[h]) + 4] = -again * closing[h, 0]
        jump: ca.SX = self.system.rhs(x, p, t, push) - self.system.rhs(x, p, t, rest)
        return jump


def _sparse(matrix: ca.DM) -> scipy.sparse.csc_array:
    return scipy.sparse.csc_array(ca.DM(matrix).sparse())
