"""Extreme values of quantities over a run, found between its steps and located to rounding."""

from __future__ import annotations

from typing import NamedTuple

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.legs import Leg
from lumped.gradients.samples import Samples, sampled, values_at
from lumped.gradients.step_code import FRACTIONS
from lumped.gradients.steps import Steps
from lumped.numerics.bracketed_roots import bracketed_roots
from lumped.simulation.functionals import Peak
from lumped.support.made_once import made_once
from lumped.timeloop.many_points import ManyPoints
from lumped.timeloop.result import Trajectory

__all__ = ["HALVINGS", "Intervals", "Looks", "SampledExtreme", "extremes", "parts_of"]

HALVINGS = 40
"""Of an interval of samples until a quantity is resolved in it."""
_GENEROUS = 1e5
"""Tolerances below the highest sample so far, from which on a part of a step is looked at."""
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


class Intervals(NamedTuple):
    """Parts of steps with values and slopes at their ends, arrays of one shape."""

    leg: np.ndarray
    begin: np.ndarray
    end: np.ndarray
    y: np.ndarray
    y_end: np.ndarray
    slope: np.ndarray
    slope_end: np.ndarray
    error: np.ndarray

    def of(self, which: np.ndarray) -> Intervals:
        """Some of them."""
        return Intervals(*(v[which] for v in self))

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
    looks = Looks(run, legs, steps, name)
    samples, size = looks.samples(signs, rtol, peak.between)
    slack = 10 * rtol * size
    found: list[SampledExtreme] = []
    for sign in signs:
        best = max((e.value for e in found), default=-np.inf)
        found += _highest(looks, samples, sign, best, size, slack, peak.between)
    best = max(e.value for e in found)
    found = [e for e in found if e.value >= best - slack]
    found.sort(key=lambda e: (-e.value, e.time))
    return found[:_TIES]


def _highest(
    looks: Looks,
    samples: Intervals,
    sign: float,
    best: float,
    size: float,
    slack: float,
    between: tuple[float, float] | None,
) -> list[SampledExtreme]:
    """Ends and inner extremes that are highest, of a quantity times a sign."""
    turned = {k: sign * getattr(samples, k) for k in ("y", "y_end", "slope", "slope_end")}
    parts = samples._replace(**turned)
    best = max(best, float(np.max(parts.y)), float(np.max(parts.y_end)))
    resolved: list[Intervals] = []
    noise = 1e-13 * (abs(best) + size)
    for _ in range(HALVINGS):
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
    inner = Intervals(*(np.concatenate(columns) for columns in zip(*resolved, strict=True)))
    found = looks.ends(samples, sign, between)
    order = np.argsort(-inner.bounds.max(axis=0), kind="stable")[:_LOCATED]
    found += looks.located(inner.of(order), sign)
    return [e for e in found if e.value >= best - slack]


@made_once
def _look(system: System, name: str) -> ManyPoints:
    """A quantity and its slope."""
    x, _, t, _ = system.inputs
    y = system.expressions([name])
    along = ca.jtimes(y, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
    both = ca.densify(ca.vertcat(y, along))
    return ManyPoints(ca.Function("look", system.inputs, [both]))


class Looks:
    """A quantity and its slope anywhere in a run."""

    def __init__(self, run: Trajectory, legs: list[Leg], steps: Steps, name: str) -> None:
        self.run, self.legs, self.steps, self.name = run, legs, steps, name
        self.look = _look(run.system, name)

    def samples(
        self, signs: tuple[float, ...], rtol: float, between: tuple[float, float] | None
    ) -> tuple[Intervals, float]:
        """Parts of steps that may hold the extreme, with an estimate of how far a cubic deviates.

        The largest size of all samples stands beside them.
        """
        rows: list[np.ndarray] = []
        best, size = -np.inf, 0.0
        for samples in sampled(self.legs, self.steps, self.look):
            found = parts_of(samples, between)
            if not len(found.leg):
                continue
            columns = np.array(found)
            self.check(columns)
            values = np.array(signs)[:, None] * np.append(found.y, found.y_end)
            best = max(best, float(values.max()))
            size = max(size, float(np.abs(values).max()))
            highest = np.max([(sign * found.bounds).max(axis=0) for sign in signs], axis=0)
            near = highest + found.error >= best - _GENEROUS * rtol * size
            is_new = np.diff(found.leg) > 0
            near[[0, -1]] = True  # smooth parts may begin or end there
            near[1:] |= is_new
            near[:-1] |= is_new
            rows.append(columns[:, near])
        if not rows:
            last = len(self.legs) - 1
            t = self.legs[-1].t[-1:]
            y, slope = self.at(np.array([last]), t)[:, :, None]
            rows = [np.array([[last], t, t, y[0], y[0], slope[0], slope[0], [0.0]])]
            size = abs(float(y[0, 0]))
            self.check(rows[0])
        table = np.concatenate(rows, axis=1)
        return Intervals(table[0].astype(int), *table[1:]), size

    def check(self, found: np.ndarray) -> None:
        """Refuse what is not finite."""
        if not np.isfinite(found).all():
            raise SolverError(
                f"{self.run.system.name}: {self.name} is not finite somewhere in the run.", self.run
            )

    def at(self, legs: np.ndarray, t: np.ndarray) -> np.ndarray:
        """Quantity and slope at times in smooth parts, shape (2, times)."""
        return values_at(self.run, self.legs, self.steps, self.look, legs, t).T

    def halved(self, parts: Intervals, sign: float) -> Intervals:
        """Each part in two, by shorter steps to its middle."""
        middle = 0.5 * (parts.begin + parts.end)
        y, slope = sign * self.at(parts.leg, middle)
        ends = np.array([parts.y, y, parts.y_end]).T
        slopes = np.array([parts.slope, slope, parts.slope_end]).T
        error = np.maximum(*_misses(ends, slopes, (parts.end - parts.begin)[:, None])).ravel()
        left = parts._replace(end=middle, y_end=y, slope_end=slope, error=error)
        right = parts._replace(begin=middle, y=y, slope=slope, error=error)
        return Intervals(*(np.concatenate(c) for c in zip(left, right, strict=True)))

    def ends(
        self, samples: Intervals, sign: float, between: tuple[float, float] | None
    ) -> list[SampledExtreme]:
        """Ends of the legs at which the quantity does not rise inwards."""
        found, last = [], len(self.legs) - 1
        for number in dict.fromkeys(samples.leg.tolist()):
            own = np.flatnonzero(samples.leg == number)
            a, b = own[0], own[-1]
            begin, end = float(samples.begin[a]), float(samples.end[b])
            if sign * samples.slope[a] <= 0:
                fixed = between is not None and begin <= between[0]
                found.append(
                    SampledExtreme(number, begin, sign * samples.y[a], sign, 0 if fixed else number)
                )
            if sign * samples.slope_end[b] >= 0:
                fixed = number == last or (between is not None and end >= between[1])
                value = sign * samples.y_end[b]
                found.append(SampledExtreme(number, end, value, sign, 0 if fixed else number + 1))
        return found

    def located(self, parts: Intervals, sign: float) -> list[SampledExtreme]:
        """The extremes inside parts whose slopes differ in sign."""
        if not len(parts.leg):
            return []
        t = bracketed_roots(
            lambda which, times: sign * self.at(parts.leg[which], times)[1],
            *(parts.begin, parts.end, parts.slope, parts.slope_end),
            1e-15 * np.maximum(1.0, parts.end),
        )
        values = sign * self.at(parts.leg, t)[0]
        found = zip(parts.leg.tolist(), t.tolist(), values.tolist(), strict=True)
        return [SampledExtreme(leg, time, value, sign, 0) for leg, time, value in found]


def parts_of(samples: Samples, between: tuple[float, float] | None) -> Intervals:
    """Parts of sampled steps, all or those within an interval."""
    leg, t, values = samples
    y, slope = values[:, :, 0], values[:, :, 1]
    error = np.maximum(*_misses(y, slope, (t[:, -1:] - t[:, :1]) * 2 / len(FRACTIONS)))
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
    return Intervals(*(c[inside].ravel() for c in columns))


def _misses(y: np.ndarray, slope: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far every second value, and slope, is from the cubic through its neighbours."""
    a, middle, b = y[:, :-2:2], y[:, 1:-1:2], y[:, 2::2]
    s_a, s_middle, s_b = slope[:, :-2:2], slope[:, 1:-1:2], slope[:, 2::2]
    value = 0.5 * (a + b) + h / 8 * (s_a - s_b)
    rise = 1.5 * (b - a) - h * (s_a + s_b) / 4
    return np.abs(middle - value), np.abs(h * s_middle - rise) / 4
