"""Where a run touches a border without crossing it, so that it has no derivative."""

from __future__ import annotations

from collections.abc import Iterator

import casadi as ca
import numpy as np
import scipy

from lumped.code.operations import operations_of
from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.adjoint import Leg, Steps
from lumped.gradients.causes import TURNING
from lumped.gradients.instant_values import margin_sizes
from lumped.gradients.step_code import FRACTIONS
from lumped.support.made_once import made_once
from lumped.timeloop.counted_function import CountedFunction
from lumped.timeloop.holds import turned
from lumped.timeloop.result import Trajectory

__all__ = ["refuse_touches"]

_CHUNK = 1024
"""Steps that are looked at in one call."""


def refuse_touches(run: Trajectory, legs: list[Leg], steps: Steps, rtol: float, ends: bool) -> None:
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
    if not run.system.margins.size1_out(0):
        return
    touches = _Touches(run, steps, rtol)
    for leg in legs:
        for row, t in touches.lowest(leg):
            touches.check(leg, row, t, "only touches what would change it")
    if not ends:
        return
    leg, t = legs[-1], float(legs[-1].t[-1])
    left, rates = touches.margins(leg, t)
    (sizes,) = margin_sizes(run.system, run.theta, [leg.course])
    near = left <= TURNING * rtol * sizes
    for row in np.flatnonzero(near & (rates < 0)).tolist():
        touches.check(leg, row, t, "is just about to change, and the run ends")


@made_once
def _look(system: System) -> ca.Function:
    """Margins and their rates: (x, p, t, m)."""
    parts = system.margins(*system.inputs)[0], system.margin_rates(*system.inputs)
    return ca.Function("look", system.inputs, [ca.densify(ca.vertcat(*parts))])


@made_once
def _counted(system: System) -> CountedFunction:
    return CountedFunction(operations_of(_look(system)))


class _Touches:
    """Margins of a run and their lowest points."""

    def __init__(self, run: Trajectory, steps: Steps, rtol: float) -> None:
        self.run, self.steps, self.rtol = run, steps, rtol
        self.system = run.system
        self.look = _look(run.system)

    def lowest(self, leg: Leg) -> Iterator[tuple[int, float]]:
        """Margins that turn near zero, and when."""
        highest = np.zeros(self.system.margins.size1_out(0))
        found: list[tuple[int, float, float]] = []
        for t, values, slopes in self._sampled(leg):
            h = np.diff(t)
            a, b, s_a, s_b = values[:, :-1], values[:, 1:], slopes[:, :-1], slopes[:, 1:]
            # the cubic through the ends stays among its control points
            least = np.minimum(np.minimum(a + h * s_a / 3, b - h * s_b / 3), np.minimum(a, b))
            near = (s_a < 0) & (s_b > 0) & (least <= 0.1 * np.maximum(a, b))
            found += [(row, t[k], t[k + 1]) for row, k in np.argwhere(near).tolist()]
            highest = np.maximum(highest, np.abs(values).max(axis=1))
        for row, begin, end in found:

            def slope(t: float, row: int = row) -> float:
                return float(self.margins(leg, t)[1][row])

            if slope(begin) * slope(end) >= 0:
                continue
            lowest = float(scipy.optimize.brentq(slope, begin, end, xtol=1e-14 * (1 + end)))
            if self.margins(leg, lowest)[0][row] <= TURNING * self.rtol * highest[row]:
                yield row, lowest

    def margins(self, leg: Leg, t: float) -> tuple[np.ndarray, np.ndarray]:
        """Margins and their rates."""
        x, m = leg.state(self.run, self.steps, t)
        values = np.asarray(self.look(x, self.run.theta, t, m)).ravel()
        left, rates = np.split(values, 2)
        return left, rates

    def check(self, leg: Leg, row: int, t: float, what: str) -> None:
        """Refuse a touch if a crossing there would change anything at once."""
        x, m = leg.state(self.run, self.steps, t)
        if not self._matters(row, x, t, m):
            return
        s = self.system.switching
        kind, k = s.rows[row]
        name = s.relation_text(k, True)[0] if kind == "relation" else s.names[k]
        words = (
            s.relation_text(k, m[s.relation_modes[k]])[1]
            if kind == "relation"
            else {"upper": "its limit", "lower": "its limit", "slide": "standstill or contact"}[
                kind
            ]
        )
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
            other = turned(self.system, x, self.run.theta, t, m, k)
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
        for function in (self.system.rhs, self.steps.integrated):
            a, b = (np.asarray(function(x, self.run.theta, t, m)).ravel() for m in (one, other))
            if np.abs(a - b).max(initial=0.0) > 1e-6 * (1e-6 + np.abs(a).max(initial=0.0)):
                return True
        return False

    def _sampled(self, leg: Leg) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Times, margins and rates at the ends of steps and between, some steps at once."""
        look, width = _counted(self.system), 2 * self.system.margins.size1_out(0)
        for begin in range(0, len(leg.t) - 1, _CHUNK):
            end = min(begin + _CHUNK, len(leg.t) - 1)
            span = leg.span(self.run, begin, end)
            inside = self.steps.looked(span, look, width).reshape(-1, width)
            first = np.asarray(self.look(span.x[0], span.theta, span.t[0], span.m[0]))
            t = span.t[:-1, None] + np.diff(span.t)[:, None] * np.array(FRACTIONS)
            values, slopes = np.split(np.vstack([first.reshape(1, -1), inside]).T, 2)
            yield np.append(span.t[0], t.ravel()), values, slopes
