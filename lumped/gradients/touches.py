"""Where a run touches a border without crossing it, so that it has no derivative."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.causes import TURNING
from lumped.gradients.instant_values import margin_sizes
from lumped.gradients.legs import Leg, SmoothParts
from lumped.gradients.readings.product_curve import sample_steps, values_at
from lumped.numerics.bracketed_roots import find_bracketed_roots
from lumped.support.made_once import made_once
from lumped.timeloop.holds import turn_condition
from lumped.timeloop.plants.many_points import ManyPoints


def refuse_touches(course: SmoothParts, ends: bool) -> None:
    """Refuse a run in which a margin falls to zero and turns back, or is zero at the very end.

    Only where it matters: where a crossing would change the rates, an integrand or the states.

    Parameters
    ----------
    ends : bool
        Whether it matters what is at the very end.

    Raises
    ------
    SolverError
        With the instant and the components.
    """
    if not course.run.system.margins.size1_out(0):
        return
    touches, legs = _Touches(course), course.legs
    for number, row, t in touches.lowest():
        touches.check(legs[number], row, t, "only touches what would change it")
    if not ends:
        return
    leg, t = legs[-1], float(legs[-1].t[-1])
    left, rates = np.split(touches.at(np.array([len(legs) - 1]), leg.t[-1:])[0], 2)
    near = left <= TURNING * course.rtol * margin_sizes(replace(course, legs=[leg], whole={}))[0]
    for row in np.flatnonzero(near & (rates < 0)).tolist():
        touches.check(leg, row, t, "is just about to change, and the run ends")


@made_once
def _look(system: System) -> ManyPoints:
    """Margins and their rates."""
    parts = system.margins(*system.inputs)[0], system.margin_rates(*system.inputs)
    both = ca.densify(ca.vertcat(*parts))
    return ManyPoints(ca.Function("look", system.inputs, [both]))


class _Touches:
    """Margins of a run and their lowest points."""

    def __init__(self, course: SmoothParts) -> None:
        self.course, self.run, self.system = course, course.run, course.run.system
        self.look = _look(self.system)
        self.count = self.system.margins.size1_out(0)

    def lowest(self) -> Iterator[tuple[int, int, float]]:
        """Margins that turn near zero: number of the smooth part, of the margin, and when."""
        highest = np.zeros((len(self.course.legs), self.count))
        found = [np.zeros((6, 0))]
        for leg, t, both in sample_steps(self.course, self.look):
            values, slopes = both[:, :, : self.count], both[:, :, self.count :]
            h = np.diff(t)[:, :, None]
            a, b, s_a, s_b = values[:, :-1], values[:, 1:], slopes[:, :-1], slopes[:, 1:]
            # the cubic through the ends stays among its control points
            least = np.minimum(np.minimum(a + h * s_a / 3, b - h * s_b / 3), np.minimum(a, b))
            near = (s_a < 0) & (s_b > 0) & (least <= 0.1 * np.maximum(a, b))
            step, k, row = np.nonzero(near)
            brackets = t[step, k], t[step, k + 1], s_a[step, k, row], s_b[step, k, row]
            found.append(np.array([leg[step], row, *brackets]))
            np.maximum.at(highest, leg, np.abs(values).max(axis=1))
        candidates = np.concatenate(found, axis=1)
        if not candidates.size:
            return
        legs, rows = candidates[:2].astype(int)
        begin, end, at_begin, at_end = candidates[2:]

        def slopes_at(which: np.ndarray, t: np.ndarray) -> np.ndarray:
            both = self.at(legs[which], t)
            own: np.ndarray = both[np.arange(len(t)), self.count + rows[which]]
            return own

        accuracy = 1e-14 * (1 + end)
        lowest = find_bracketed_roots(slopes_at, begin, end, at_begin, at_end, accuracy)
        values = self.at(legs, lowest)[np.arange(len(legs)), rows]
        for i in np.flatnonzero(
            values <= TURNING * self.course.rtol * highest[legs, rows]
        ).tolist():
            yield int(legs[i]), int(rows[i]), float(lowest[i])

    def at(self, legs: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Margins, then their rates, at times in smooth parts."""
        return values_at(self.course, self.look, legs, t)

    def check(self, leg: Leg, row: int, t: float, what: str) -> None:
        """Refuse a touch if a crossing there would change anything at once."""
        x, m = leg.state(t)
        if not self._matters(row, x, t, m):
            return
        s = self.system.switching
        kind, k = s.rows[row]
        if kind == "relation":
            name, words = s.relation_text(k, m[s.relation_modes[k]])
        else:
            name = s.names[k]
            words = "standstill or contact" if kind == "slide" else "its limit"
        raise SolverError(
            f"{self.system.name}: at t = {t:.9g} s {name} {what} ({words}), to the accuracy of "
            "the run: there is no derivative. Change a parameter a little, or tighten rtol if it "
            "does stay clear.",
            self.run,
        )

    def _matters(self, row: int, x: np.ndarray, t: float, m: np.ndarray) -> bool:
        s = self.system.switching
        kind, k = s.rows[row]
        other = m.copy()
        if kind == "relation":
            mode = int(s.relation_modes[k])
            if mode in {jump.mode for jump in s.jumps} or (s.engaged == mode).any():
                return True
            other = turn_condition(self.system, x, self.run.theta, t, m, k)
            return self._apart(x, t, m, other)
        first = int(s.first_modes[k])
        if kind == "slide":
            if s.has_gap[k]:
                return True
            # it would stay at rest where its limits are not used up there
            other[first : first + 3] = 1.0, 0.0, 0.0
            left, tolerance = (
                np.asarray(v).ravel() for v in self.system.margins(x, self.run.theta, t, other)
            )
            own = [i for i, (how, h) in enumerate(s.rows) if h == k and how in ("upper", "lower")]
            return bool(all(left[i] > 1e4 * tolerance[i] for i in own))
        other[first : first + 3] = 0.0, float(kind == "upper"), float(kind == "lower")
        return self._apart(x, t, m, other)

    def _apart(self, x: np.ndarray, t: float, one: np.ndarray, other: np.ndarray) -> bool:
        """Whether rates or integrands differ in two modes."""
        for function in (self.system.rhs, self.course.steps.integrated):
            a, b = (np.asarray(function(x, self.run.theta, t, m)).ravel() for m in (one, other))
            if np.abs(a - b).max(initial=0.0) > 1e-6 * (1e-6 + np.abs(a).max(initial=0.0)):
                return True
        return False
