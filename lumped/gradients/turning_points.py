"""Where a quantity turns in a run, found between its steps and located to rounding."""

from __future__ import annotations

import casadi as ca
import numpy as np

from lumped.compiler.system import System
from lumped.errors import SolverError
from lumped.gradients.extremes import HALVINGS, Intervals, Looks, SampledExtreme, parts_of
from lumped.gradients.legs import Leg
from lumped.gradients.samples import sampled
from lumped.gradients.steps import Steps
from lumped.support.made_once import made_once
from lumped.timeloop.many_points import ManyPoints
from lumped.timeloop.result import Trajectory

__all__ = ["turning_points"]

_COARSE = 1e-3
"""Part of the range of a quantity by which a step may miss the next point of the run at most."""
_DIVISIONS = 8
"""How often steps are divided in two, at most; beyond `_COARSE` only while that helps."""

_ROUNDING = 1e-12
"""Of the terms of a quantity: swings below are rounding."""


def turning_points(
    run: Trajectory, legs: list[Leg], steps: Steps, name: str, rtol: float
) -> list[SampledExtreme]:
    """All points at which a quantity turns, in order of time; the first and the last among them.

    Of a jump, both sides are among them where the quantity turns there. Swings smaller than `rtol`
    of its range are left out, the last one too. Where points of the run are farther apart than
    steps, the steps between them are divided.

    Raises
    ------
    SolverError
        If the points of the run are too far apart to follow the quantity between them.
    """
    looks = Looks(run, legs, steps, name)
    samples, size = _samples(looks, rtol)
    is_still = float(np.ptp(np.append(samples.y, samples.y_end))) <= rtol * size
    inner = [] if is_still else looks.located(_turning(looks, samples, rtol * size), 1.0)
    found = sorted(_ends(samples, legs) + inner, key=lambda e: (e.leg, e.time))
    return _swinging(found, rtol * size)


def _samples(looks: Looks, rtol: float) -> tuple[Intervals, float]:
    """All parts of all steps, and the range of the quantity."""
    known = [looks.at(np.full(len(leg.t), k), leg.t)[0] for k, leg in enumerate(looks.legs)]
    looks.check(np.concatenate(known))
    floor = max(_ROUNDING * _terms(looks), 1e-300)
    size = max(float(np.ptp(np.concatenate(known))), floor)
    origins = [np.arange(len(y) - 1) for y in known]  # to which step of the run each part belongs
    before = [np.full(len(y) - 1, np.inf) for y in known]
    for _ in range(_DIVISIONS):
        found, missed = _followed(looks, origins)
        wanted = [
            (m > rtol * size) & ((m < 0.5 * b) | (m > _COARSE * size))
            for m, b in zip(missed, before, strict=True)
        ]
        if not any(steps.any() for steps in wanted):
            break
        for k, leg in enumerate(looks.legs):
            parts = np.where(wanted[k][origins[k]], 2, 1)
            leg.divide(parts)
            origins[k] = np.repeat(origins[k], parts)
        before = [np.where(w, m, 0.0) for w, m in zip(wanted, missed, strict=True)]
    worst = max(float(m.max(initial=0.0)) for m in missed)
    if not worst <= _COARSE * size:
        raise SolverError(
            f"{looks.run.system.name}: {looks.name} is off by {worst:.3g} where it is followed "
            "from one point of the run to the next. Record the run at its steps, simulate(..., "
            "grid=None), or make it with a smaller rtol.",
            looks.run,
        )
    return found, max(float(np.ptp(np.append(found.y, found.y_end))), floor / rtol)


@made_once
def _by_states(system: System, name: str) -> ManyPoints:
    """Derivatives of a quantity by the states."""
    slopes = ca.jacobian(system.expressions([name]), system.inputs[0])
    return ManyPoints(ca.Function("by_states", system.inputs, [ca.densify(slopes.T)]))


def _terms(looks: Looks) -> float:
    """Size of the terms of which a quantity consists, at the ends of the smooth parts."""
    sizes = [0.0]
    for leg in looks.legs:
        (x, m), t = leg.sides(np.array([0, len(leg.t) - 1])), leg.t[[0, -1]]
        slopes = _by_states(looks.run.system, looks.name)(x, looks.run.theta, t, m)
        sizes.append(float(np.nan_to_num(np.abs(slopes * x)).sum(axis=1).max()))
    return max(sizes)


def _followed(looks: Looks, origins: list[np.ndarray]) -> tuple[Intervals, list[np.ndarray]]:
    """All parts of all steps; by how much each step of the run, in parts, misses its end."""
    rows = [np.zeros((8, 0))]
    missed = [np.zeros(origin[-1] + 1 if len(origin) else 0) for origin in origins]
    for samples in sampled(looks.legs, looks.steps, looks.look):
        rows.append(np.array(parts_of(samples, None)))
        for number in np.unique(samples.leg).tolist():
            own, leg = samples.leg == number, looks.legs[number]
            t = samples.t[own]
            ends = np.searchsorted(leg.t, t[:, -1])
            off = np.abs(samples.values[own, -1] - looks.at(np.full(len(t), number), t[:, -1]).T)
            off[:, 1] *= t[:, -1] - t[:, 0]  # a slope that is off moves the turning points
            np.maximum.at(missed[number], origins[number][ends - 1], off.max(axis=1))
    table = np.concatenate(rows, axis=1)
    return Intervals(table[0].astype(int), *table[1:]), missed


def _turning(looks: Looks, samples: Intervals, least: float) -> Intervals:
    """Parts of steps in which the quantity turns once."""
    found: list[Intervals] = []
    parts = samples
    for _ in range(HALVINGS):
        bounds = parts.bounds
        reach = np.ptp(bounds, axis=0)
        turned = (parts.slope < 0) != (parts.slope_end < 0)  # once, where a slope is zero
        ways = np.diff(bounds, axis=0)
        monotone = (ways >= 0).all(axis=0) | (ways <= 0).all(axis=0)
        plain = parts.error <= 1e-3 * reach + 0.1 * least
        small = reach + parts.error <= least
        found.append(parts.of(turned & (plain | small)))
        parts = parts.of(~small & ~(plain & (turned | monotone)))
        if not len(parts.leg):
            break
        parts = looks.halved(parts, 1.0)
    return Intervals(*(np.concatenate(columns) for columns in zip(*found, strict=True)))


def _ends(samples: Intervals, legs: list[Leg]) -> list[SampledExtreme]:
    """Begins and ends of all smooth parts, with the change that they move with."""
    found, last = [], len(legs) - 1
    for number in np.unique(samples.leg).tolist():
        own = np.flatnonzero(samples.leg == number)
        a, b = own[0], own[-1]
        begin, end = float(samples.begin[a]), float(samples.end[b])
        edge = 0 if number == last else number + 1
        found.append(SampledExtreme(number, begin, float(samples.y[a]), 1.0, number))
        found.append(SampledExtreme(number, end, float(samples.y_end[b]), 1.0, edge))
    return found


def _swinging(points: list[SampledExtreme], least: float) -> list[SampledExtreme]:
    """Those between which the quantity swings by more than the least, and the first."""
    found, furthest, sign = [points[0]], points[0], 0.0
    lowest = highest = points[0]
    for point in points[1:]:
        if sign == 0:
            lowest = min(lowest, point, key=lambda e: e.value)
            highest = max(highest, point, key=lambda e: e.value)
            if highest.value - lowest.value > least:
                sign, furthest = (1.0, highest) if point is highest else (-1.0, lowest)
                other = lowest if point is highest else highest
                if other is not points[0]:
                    found.append(other)
        elif sign * (point.value - furthest.value) > 0:
            furthest = point
        elif sign * (furthest.value - point.value) > least:
            found.append(furthest)
            furthest, sign = point, -sign
    return [*found, furthest if sign else points[-1]]
