"""Extreme values of quantities over a run, located to rounding."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import casadi as ca
import numpy as np
import scipy

from lumped.analysis.adjoint import Leg, Steps
from lumped.analysis.dense import Method
from lumped.analysis.functionals import Peak
from lumped.analysis.result import Trajectory
from lumped.analysis.reverse import FRACTIONS, looked
from lumped.errors import SolverError
from lumped.system import System

__all__ = ["Extreme", "extremes"]


class Extreme(NamedTuple):
    """Where a quantity is greatest.

    Attributes
    ----------
    leg : int
        Number of the smooth part of the run.
    time : float
        Instant, s.
    sign : float
        -1 if it is the opposite of the quantity that is greatest there.
    edge : int
        Number of the leg with whose begin the instant moves; 0 if it does not move.
    x, settings : ndarray
        States and settings there.
    """

    leg: int
    time: float
    sign: float
    edge: int
    x: np.ndarray
    settings: np.ndarray


def extremes(
    run: Trajectory, legs: list[Leg], steps: Steps, wanted: Sequence[Peak]
) -> list[Extreme]:
    """Extremes of a run; those inside steps become ends of steps."""
    if not wanted:
        return []
    names = [run.system.key(peak.name) for peak in wanted]
    sampled = _samples(run, legs, names)
    found = []
    for row, (peak, name) in enumerate(zip(wanted, names, strict=True)):
        values = [samples[row] for samples in sampled]
        found.append(_located(run, legs, steps, peak, name, values))
    for extreme in found:
        leg = legs[extreme.leg]
        if extreme.time not in leg.t:
            step = int(np.searchsorted(leg.t, extreme.time)) - 1
            leg.insert(step, extreme.time, extreme.x)
    return found


def _samples(run: Trajectory, legs: list[Leg], names: list[str]) -> list[np.ndarray]:
    """Quantities at the begin of each leg and inside its steps, shapes (names, 1 + 8 steps)."""
    system, theta = run.system, run.theta
    first = system.function(names).map(len(legs))(
        np.stack([leg.x[0] for leg in legs], axis=1),
        np.repeat(theta[:, None], len(legs), axis=1),
        np.array([[leg.t[0] for leg in legs]]),
        np.stack([leg.settings[0] for leg in legs], axis=1),
    )
    t = np.concatenate([leg.t[:-1] for leg in legs])
    h = np.concatenate([np.diff(leg.t) for leg in legs])
    x = np.concatenate([leg.x[:-1] for leg in legs])
    m = np.concatenate([leg.settings[:-1] for leg in legs])
    inside = np.zeros((len(names), len(t), len(FRACTIONS)))
    implicit = t >= run.statistics.implicit_from
    methods: tuple[tuple[Method, np.ndarray], ...] = (
        ("explicit", np.flatnonzero(~implicit)),
        ("implicit", np.flatnonzero(implicit)),
    )
    for method, rows in methods:
        if not len(rows):
            continue
        key = ("looked", method, tuple(names))
        if key not in system.made:
            system.made[key] = looked(system, method, names)
        values = system.made[key].map(len(rows))(
            x[rows].T,
            np.repeat(theta[:, None], len(rows), axis=1),
            t[None, rows],
            h[None, rows],
            m[rows].T,
        )
        inside[:, rows] = np.asarray(values).reshape(len(names), len(rows), len(FRACTIONS))
    ends = np.cumsum([len(leg.t) - 1 for leg in legs])[:-1]
    parts = [part.reshape(len(names), -1) for part in np.split(inside, ends, axis=1)]
    begins = np.asarray(first).T[:, :, None]
    return [np.hstack([b, part]) for b, part in zip(begins, parts, strict=True)]


def _located(
    run: Trajectory,
    legs: list[Leg],
    steps: Steps,
    peak: Peak,
    name: str,
    samples: list[np.ndarray],
) -> Extreme:
    """The extreme next to the best sample."""
    signs = {"peak": (1.0, -1.0), "highest": (1.0,), "lowest": (-1.0,)}[peak.kind]
    if not all(np.isfinite(values).all() for values in samples):
        raise SolverError(f"{run.system.name}: {name} is not finite somewhere in the run.", run)
    best = max((float((s * v).max()), -k, s) for k, v in enumerate(samples) for s in signs)
    number, sign = -best[1], best[2]
    leg = legs[number]
    place = int(np.argmax(sign * samples[number]))
    parts = np.array([0.0, *FRACTIONS[:-1]])
    times = (leg.t[:-1, None] + np.diff(leg.t)[:, None] * parts).ravel()
    times = np.append(times, leg.t[-1])
    slope = _Slope(run, leg, steps, name, sign)
    t = float(times[place])
    rise = slope(t)
    other = place + 1 if rise > 0 else place - 1
    if 0 <= other < len(times):
        to = float(times[other])
        if rise and slope(to) * rise < 0:
            low, high = sorted((t, to))
            t = float(
                scipy.optimize.brentq(slope, low, high, xtol=1e-15 * max(1.0, high), rtol=1e-15)
            )
    edge = 0
    if place and t == leg.t[-1]:
        edge = number + 1 if number + 1 < len(legs) else 0
    elif t == leg.t[0]:
        edge = number
    return Extreme(number, t, sign, edge, *slope.state(t))


class _Slope:
    """Time derivative of a quantity inside a leg."""

    def __init__(self, run: Trajectory, leg: Leg, steps: Steps, name: str, sign: float) -> None:
        self._run, self._steps, self._sign = run, steps, sign
        self._t, self._x, self._m = leg.t, leg.x, leg.settings
        self._function = slope_function(run.system, name)

    def state(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """States and settings at a time: those of a shorter step."""
        i = int(np.searchsorted(self._t, t, "right")) - 1
        if self._t[i] == t:
            return self._x[i], self._m[i]
        implicit = self._t[i] >= self._run.statistics.implicit_from
        step = self._steps.step("implicit" if implicit else "explicit")
        x, _ = step(self._x[i], self._run.theta, self._t[i], t - self._t[i], self._m[i])
        return np.asarray(x).ravel(), self._m[i]

    def __call__(self, t: float) -> float:
        x, m = self.state(t)
        return self._sign * float(self._function(x, self._run.theta, t, m))


def slope_function(system: System, name: str) -> ca.Function:
    """Time derivative of a quantity: (x, p, t, m)."""
    key = ("slope", name)
    if key not in system.made:
        x, _, t, _ = system._inputs
        y = system.expressions([name])
        along = ca.jtimes(y, ca.vertcat(x, t), ca.vertcat(system.rates, 1))
        system.made[key] = ca.Function("slope", system._inputs, [ca.densify(along)])
    found: ca.Function = system.made[key]
    return found
