"""How derivatives of states jump where a run stops."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.analysis.result import Trajectory
from lumped.errors import SolverError
from lumped.system import System

__all__ = ["Saltation"]

Side = tuple[np.ndarray, np.ndarray]
"""States and settings on one side of an instant."""

_TOUCHED = 10
"""Margins count as used up within so many of their tolerances."""


class Saltation:
    """Jumps of the sensitivities of one system.

    Parameters
    ----------
    system : System
        From `assemble`.
    S : SX, shape (n, k)
        Symbols of the sensitivities.
    seed : ndarray, shape (parameters, k)
        Derivatives of the parameters by what is varied.
    """

    def __init__(self, system: System, S: ca.SX, seed: np.ndarray) -> None:
        self.system, self.S, self.seed = system, S, seed
        self.inputs = system._inputs
        x, p, t, m = self.inputs
        thresholds, _ = system._flat.thresholds
        at = thresholds(p)
        self.thresholds = ca.Function("at", [p], [at, ca.densify(ca.jtimes(at, p, ca.DM(seed)))])
        margins = system._in_states(system.switching.margins[0])
        self.margins = ca.Function("along", [x, S, p, t, m], [self._along(margins)])
        self._made: dict[object, ca.Function] = {}

    def _along(self, expression: ca.SX) -> ca.SX:
        x, p, _, _ = self.inputs
        both = ca.vertcat(self.S, ca.SX(ca.DM(self.seed)))
        return ca.densify(ca.jtimes(expression, ca.vertcat(x, p), both))

    def across(
        self, run: Trajectory, t: float, old: Side, new: Side, S: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Sensitivities after an instant, shape (n, k), and derivatives of the instant, (k,)."""
        theta = run.theta
        t_p, used = self._instant(run, t, old, new, S)
        for function in self._changes(used, old, new):
            x, moved, drift = (np.asarray(v) for v in function(old[0], S, theta, t, old[1]))
            gap = np.abs(x.ravel() - new[0]) / (1.0 + np.abs(new[0]))
            if gap.max(initial=0.0) < 1e-7:
                break
        else:
            raise SolverError(
                f"{self.system.name}: at t = {t:.9g} s several changes follow each other at once "
                "(see run.events); derivatives are not followed across that.",
                run,
            )
        after = np.asarray(self.system.rhs(new[0], theta, t, new[1])).ravel()
        return moved + np.outer(drift.ravel() - after, t_p), t_p

    def _instant(
        self, run: Trajectory, t: float, old: Side, new: Side, S: np.ndarray
    ) -> tuple[np.ndarray, list[int]]:
        """Derivatives of an instant, and which margins are used up there."""
        system, point = self.system, (old[0], run.theta, t, old[1])
        at, along = (np.asarray(v) for v in self.thresholds(run.theta))
        changed = old[1][: len(at)] != new[1][: len(at)]
        found = along[changed & (np.abs(at.ravel() - t) <= 1e-12 * (1.0 + t))]
        left, tolerance = (np.asarray(v).ravel() for v in system.margins(*point))
        rates = np.asarray(system.margin_rates(*point)).ravel()
        used = np.flatnonzero((left <= _TOUCHED * tolerance) & (rates < 0)).tolist()
        if not len(found) and used:
            by = np.asarray(self.margins(old[0], S, run.theta, t, old[1]))
            found = -by[used] / rates[used, None]
        if not len(found):
            if changed.any():
                raise SolverError(
                    f"{system.name}: at t = {t:.9g} s modes change, but what changes them is "
                    "touched without being crossed; the run has no derivative there.",
                    run,
                )
            return np.zeros(S.shape[1]), used
        if np.ptp(found, axis=0).max() > 1e-6 * (1e-6 + np.abs(found).max()):
            raise SolverError(
                f"{system.name}: at t = {t:.9g} s different changes coincide (see run.events); "
                "which comes first depends on the parameters, so the run has no derivative there.",
                run,
            )
        return found[0], used

    def _changes(self, used: list[int], old: Side, new: Side) -> list[ca.Function]:
        """What may become of the states: (x, S, p, t, m) -> states, their S, their drift."""
        switching = self.system.switching
        rows = [switching.rows[i] for i in used]
        risen = {int(switching.relation_modes[k]) for kind, k in rows if kind == "relation"}
        risen |= set(np.flatnonzero(new[1] > old[1]).tolist())
        jumps = [j for j, w in enumerate(switching.jumps) if w.mode in risen and not old[1][w.mode]]
        hits = [h for kind, h in rows if kind == "slide" and switching.has_gap[h]]
        before, after = (side[1][switching.first_modes] > 0.5 for side in (old, new))
        limited = switching.has_upper & switching.has_lower
        closing = np.flatnonzero(after & ~before & ~switching.has_gap & ~limited).tolist()
        if not hits:
            return [self._change(tuple(jumps), (), tuple(closing), new)]
        return [
            self._change(tuple(jumps), tuple(b), tuple(c), new)
            for b, c in ((hits, closing), ([], hits + closing))
        ]

    def _change(
        self, jumps: tuple[int, ...], bouncing: tuple[int, ...], closing: tuple[int, ...], new: Side
    ) -> ca.Function:
        """One possible change: of `when` statements, of bodies that bounce and that stay."""
        modes = new[1][: self.system._flat.mode_count]
        hit = bool(bouncing or closing)
        key = (jumps, bouncing, closing, modes.tobytes() if hit else b"")
        if key not in self._made:
            x, p, t, m = self.inputs
            rates = self.system.rates
            x_new = ca.SX(x)
            place = {node: i for i, node in enumerate(self.system.states)}
            values = self.system._in_states(self.system.switching.values)
            for j in jumps:
                jump = self.system.switching.jumps[j]
                for i, (node, sign) in enumerate(zip(jump.nodes, jump.signs, strict=True)):
                    if node in place:
                        x_new[place[node]] = sign * values[jump.first + i]
            if hit:
                x_new = x_new + self._impulse(bouncing, closing, modes)
            drift = ca.jtimes(x_new, ca.vertcat(x, t), ca.vertcat(rates, 1))
            outputs = [ca.densify(v) for v in (x_new, self._along(x_new), drift)]
            self._made[key] = ca.Function("change", [x, self.S, p, t, m], outputs)
        return self._made[key]

    def _impulse(
        self, bouncing: tuple[int, ...], closing: tuple[int, ...], modes: np.ndarray
    ) -> ca.SX:
        """Jump of the states where constraints close (see `Settler` for the law)."""
        switching = self.system.switching
        speed = self.system._in_states(switching.speed)
        restitution = self.system._in_states(switching.restitution)
        x, p, t, m = self.inputs
        rest = ca.SX(m)
        rest[: len(modes)] = ca.DM(modes)
        for h, first in enumerate(switching.first_modes.tolist()):
            limited = switching.has_upper[h] and switching.has_lower[h]
            holds = h in bouncing or h in closing or (modes[first] > 0.5 and not limited)
            rest[first : first + 3] = ca.DM([holds, 0, 0])
        push = ca.SX(rest)
        for h in (*bouncing, *closing):
            again = 1 + restitution[h] if h in bouncing else 1
            push[int(switching.first_modes[h]) + 4] = -again * speed[h]
        rhs = self.system.rhs
        jump: ca.SX = rhs(x, p, t, push) - rhs(x, p, t, rest)
        return jump
