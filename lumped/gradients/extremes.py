"""Extreme values of quantities over a run, found between its steps and located to rounding."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.adjoint import Leg, Steps
from lumped.gradients.samples import sampled, values_at
from lumped.gradients.step_code import FRACTIONS
from lumped.numerics.bracketed_roots import bracketed_roots
from lumped.simulation.functionals import Peak
from lumped.support.made_once import made_once
from lumped.timeloop.point_function import PointFunction
from lumped.timeloop.result import Trajectory

__all__ = ["SampledExtreme", "extremes"]

_HALVINGS = 40
"""Of an interval of samples until a quantity is resolved in it."""
_LOCATED, _TIES = 64, 6
"""Most extremes of nearly the same height that are located, and that are kept."""


class SampledExtreme(NamedTuple):
    """Where a quantity is greatest.

    Attributes
    ----------
    leg : int
        Number of the smooth part of the run.
    time, value : float
        Instant, s, and the value there times its sign.
    sign : float
        -1 if it is the opposite of the quantity that is greatest there.
    edge : int
        Number of the leg with whose begin the instant moves; 0 if it does not move.
    """

    leg: int
    time: float
    value: float
    sign: float
    edge: int


class _Intervals(NamedTuple):
    """Parts of steps with values and slopes at their ends, arrays of one shape."""

    leg: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    y: np.ndarray
    y_end: np.ndarray
    slope: np.ndarray
    slope_end: np.ndarray
    error: np.ndarray

    def of(self, which: np.ndarray) -> _Intervals:
        return _Intervals(*(v[which] for v in self))

    @property
    def bounds(self) -> np.ndarray:
        """Control points of the cubic through the ends, shape (4, k): it stays among them."""
        h = self.end - self.begin
        inner = self.y + h * self.slope / 3, self.y_end - h * self.slope_end / 3
        return np.array([self.y, *inner, self.y_end])


def extremes(
    run: Trajectory, legs: list[Leg], steps: Steps, peak: Peak, rtol: float
) -> list[SampledExtreme]:
    """The extremes of a run that are highest within its accuracy, the highest first.

    Values and slopes at samples bound what a cubic can reach between them; where the next sample
    deviates from it, and the highest may hide, the interval is halved.
    """
    name = run.system.key(peak.name)
    signs = {"peak": (1.0, -1.0), "highest": (1.0,), "lowest": (-1.0,)}[peak.kind]
    looks = _Looks(run, legs, steps, name)
    sampled = looks.samples(peak.between)
    size = max(np.abs(sampled.y).max(initial=0.0), np.abs(sampled.y_end).max(initial=0.0))
    slack = 10 * rtol * float(size)
    found: list[SampledExtreme] = []
    for sign in signs:
        best = max((e.value for e in found), default=-np.inf)
        found += _highest(looks, sampled, sign, best, slack, peak.between)
    best = max(e.value for e in found)
    found = [e for e in found if e.value >= best - slack]
    found.sort(key=lambda e: (-e.value, e.time))
    return found[:_TIES]


def _highest(
    looks: _Looks,
    sampled: _Intervals,
    sign: float,
    best: float,
    slack: float,
    between: tuple[float, float] | None,
) -> list[SampledExtreme]:
    """Ends and inner extremes that are highest, of a quantity times a sign."""
    turned = {k: sign * getattr(sampled, k) for k in ("y", "y_end", "slope", "slope_end")}
    parts = sampled._replace(**turned)
    best = max(best, float(np.max(parts.y)), float(np.max(parts.y_end)))
    resolved: list[_Intervals] = []
    noise = 1e-13 * (abs(best) + float(np.abs(parts.y).max()))
    for _ in range(_HALVINGS):
        bounds = parts.bounds
        high = bounds.max(axis=0)
        parts = parts.of(active := high + parts.error >= best - slack)
        bounds, high = bounds[:, active], high[active]
        ends = np.maximum(parts.y, parts.y_end)
        peaked = (parts.slope > 0) & (parts.slope_end <= 0)
        plain = parts.error <= 1e-3 * np.ptp(bounds, axis=0) + noise
        done = plain & (peaked | (high <= ends + noise))
        resolved.append(parts.of(done & peaked))
        parts = parts.of(~done)
        if not len(parts.leg):
            break
        parts = looks.halved(parts, sign)
        best = max(best, float(parts.y.max()), float(parts.y_end.max()))
    inner = _Intervals(*(np.concatenate(columns) for columns in zip(*resolved, strict=True)))
    found = looks.ends(sampled, sign, between)
    order = np.argsort(-inner.bounds.max(axis=0), kind="stable")[:_LOCATED]
    found += looks.located(inner.of(order), sign)
    return [e for e in found if e.value >= best - slack]


@made_once
def _look(system: System, name: str) -> PointFunction:
    """A quantity and its slope."""
    x, _, t, _ = system.inputs
    y = system.expressions([name])
    along = ca.jtimes(y, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
    both = ca.densify(ca.vertcat(y, along))
    return PointFunction(ca.Function("look", system.inputs, [both]))


class _Looks:
    """A quantity and its slope anywhere in a run."""

    def __init__(self, run: Trajectory, legs: list[Leg], steps: Steps, name: str) -> None:
        self.run, self.legs, self.steps, self.name = run, legs, steps, name
        self.look = _look(run.system, name)

    def samples(self, between: tuple[float, float] | None) -> _Intervals:
        """Parts of all steps, with an estimate of how far a cubic deviates in each."""
        rows: list[np.ndarray] = []
        for leg, t, values in sampled(self.run, self.legs, self.steps, self.look):
            y, slope = values[:, :, 0], values[:, :, 1]
            double = (t[:, -1:] - t[:, :1]) * 2 / len(FRACTIONS)
            error = np.maximum(*_misses(y, slope, double))
            columns = (
                np.repeat(leg[:, None], len(FRACTIONS), axis=1),
                t[:, :-1],
                t[:, 1:],
                y[:, :-1],
                y[:, 1:],
                slope[:, :-1],
                slope[:, 1:],
                np.repeat(error, 2, axis=1),
            )
            inside = np.ones(len(leg), dtype=bool)
            if between is not None:
                inside = (t[:, 0] >= between[0]) & (t[:, -1] <= between[1])
            rows.append(np.array([c[inside].ravel() for c in columns]))
        if not any(own.size for own in rows):
            last = len(self.legs) - 1
            t = self.legs[-1].t[-1:]
            y, slope = self.at([last], t)[:, :, None]
            rows = [np.array([[last], t, t, y, y, slope, slope, [0.0]])]
        table = np.concatenate(rows, axis=1)
        if not np.isfinite(table).all():
            raise SolverError(
                f"{self.run.system.name}: {self.name} is not finite somewhere in the run.", self.run
            )
        return _Intervals(table[0].astype(int), *table[1:])

    def at(self, legs: Sequence[int], t: np.ndarray) -> np.ndarray:
        """Quantity and slope at times in smooth parts, shape (2, times)."""
        return values_at(self.run, self.legs, self.steps, self.look, legs, t).T

    def halved(self, parts: _Intervals, sign: float) -> _Intervals:
        """Each part in two, by shorter steps to its middle."""
        middle = 0.5 * (parts.begin + parts.end)
        y, slope = sign * self.at(parts.leg.tolist(), middle)
        ends = np.array([parts.y, y, parts.y_end]).T
        slopes = np.array([parts.slope, slope, parts.slope_end]).T
        error = np.maximum(*_misses(ends, slopes, (parts.end - parts.begin)[:, None])).ravel()
        left = parts._replace(end=middle, y_end=y, slope_end=slope, error=error)
        right = parts._replace(begin=middle, y=y, slope=slope, error=error)
        return _Intervals(*(np.concatenate(c) for c in zip(left, right, strict=True)))

    def ends(
        self, sampled: _Intervals, sign: float, between: tuple[float, float] | None
    ) -> list[SampledExtreme]:
        """Ends of the legs at which the quantity does not rise inwards."""
        found, last = [], len(self.legs) - 1
        for number in dict.fromkeys(sampled.leg.tolist()):
            own = np.flatnonzero(sampled.leg == number)
            a, b = own[0], own[-1]
            begin, end = float(sampled.begin[a]), float(sampled.end[b])
            if sign * sampled.slope[a] <= 0:
                fixed = between is not None and begin <= between[0]
                found.append(
                    SampledExtreme(number, begin, sign * sampled.y[a], sign, 0 if fixed else number)
                )
            if sign * sampled.slope_end[b] >= 0:
                fixed = number == last or (between is not None and end >= between[1])
                value = sign * sampled.y_end[b]
                found.append(SampledExtreme(number, end, value, sign, 0 if fixed else number + 1))
        return found

    def located(self, parts: _Intervals, sign: float) -> list[SampledExtreme]:
        """The extremes inside parts whose slopes differ in sign."""
        if not len(parts.leg):
            return []
        t = bracketed_roots(
            lambda which, times: sign * self.at(parts.leg[which].tolist(), times)[1],
            *(parts.begin, parts.end, parts.slope, parts.slope_end),
            1e-15 * np.maximum(1.0, parts.end),
        )
        legs = parts.leg.tolist()
        values = sign * self.at(legs, t)[0]
        found = zip(legs, t.tolist(), values.tolist(), strict=True)
        return [SampledExtreme(leg, time, value, sign, 0) for leg, time, value in found]


def _misses(y: np.ndarray, slope: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far every second value, and slope, is from the cubic through its neighbours."""
    a, middle, b = y[:, :-2:2], y[:, 1:-1:2], y[:, 2::2]
    s_a, s_middle, s_b = slope[:, :-2:2], slope[:, 1:-1:2], slope[:, 2::2]
    value = 0.5 * (a + b) + h / 8 * (s_a - s_b)
    rise = 1.5 * (b - a) - h * (s_a + s_b) / 4
    return np.abs(middle - value), np.abs(h * s_middle - rise) / 4
