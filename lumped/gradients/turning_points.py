"""Where a quantity turns in a run, found between its steps and located to rounding."""

from __future__ import annotations

import numpy as np

from lumped.errors import SolverError
from lumped.gradients.extremes import HALVINGS, Intervals, Looks, SampledExtreme, parts_of
from lumped.gradients.legs import Leg
from lumped.gradients.samples import sampled
from lumped.gradients.steps import Steps
from lumped.timeloop.result import Trajectory

__all__ = ["turning_points"]

_COARSE = 1e-3
"""Part of the range of a quantity by which a step may miss the next recorded point."""


def turning_points(
    run: Trajectory, legs: list[Leg], steps: Steps, name: str, rtol: float
) -> list[SampledExtreme]:
    """All points at which a quantity turns, in order of time; the first and the last among them.

    A jump gives the values on both sides of it where these are turning points. Swings that are
    smaller than the accuracy of the run are left out.

    Raises
    ------
    SolverError
        If the points of the run are too far apart to follow the quantity between them.
    """
    looks = Looks(run, legs, steps, name)
    samples, size = _samples(looks)
    inner = looks.located(_turning(looks, samples, rtol * size), 1.0)
    found = sorted(_ends(samples, legs) + inner, key=lambda e: (e.leg, e.time))
    return _alternating(found)


def _samples(looks: Looks) -> tuple[Intervals, float]:
    """All parts of all steps, and the range of the quantity."""
    rows: list[np.ndarray] = []
    missed = 0.0
    for samples in sampled(looks.legs, looks.steps, looks.look):
        rows.append(np.array(parts_of(samples, None)))
        for number in np.unique(samples.leg).tolist():
            # a step ends at the point that was recorded there, if it was one of the run
            own = samples.leg == number
            leg = looks.legs[number]
            t, y = samples.t[own, -1], samples.values[own, -1, 0]
            x, m = leg.sides(np.searchsorted(leg.t, t))
            missed = max(
                missed, float(np.abs(looks.look(x, looks.run.theta, t, m)[:, 0] - y).max())
            )
    table = np.concatenate(rows, axis=1)
    looks.check(table)
    found = Intervals(table[0].astype(int), *table[1:])
    size = float(np.ptp(np.append(found.y, found.y_end)))
    if missed > _COARSE * size:
        raise SolverError(
            f"{looks.run.system.name}: {looks.name} is off by {missed:.3g} where it is followed "
            "from one point of the run to the next: they are too far apart. Record the run at its "
            "steps, simulate(..., grid=None), or on a finer grid.",
            looks.run,
        )
    return found, size


def _turning(looks: Looks, samples: Intervals, least: float) -> Intervals:
    """Parts of steps in which the quantity turns once."""
    found: list[Intervals] = []
    parts = samples
    for _ in range(HALVINGS):
        bounds = parts.bounds
        reach = np.ptp(bounds, axis=0) + parts.error
        turned = (parts.slope < 0) != (parts.slope_end < 0)  # once, where a slope is zero
        ways = np.diff(bounds, axis=0)
        monotone = (ways >= 0).all(axis=0) | (ways <= 0).all(axis=0)
        plain = parts.error <= 1e-3 * reach
        found.append(parts.of(plain & turned & (reach > least)))
        parts = parts.of((reach > least) & ~(plain & (turned | monotone)))
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
        edge = 0 if number == last else number + 1
        found.append(
            SampledExtreme(number, float(samples.begin[a]), float(samples.y[a]), 1.0, number)
        )
        found.append(
            SampledExtreme(number, float(samples.end[b]), float(samples.y_end[b]), 1.0, edge)
        )
    return found


def _alternating(points: list[SampledExtreme]) -> list[SampledExtreme]:
    """Those at which the values turn; of equal neighbours the first."""
    found: list[SampledExtreme] = []
    for point in points:
        if found and point.value == found[-1].value:
            continue
        if len(found) > 1 and (point.value > found[-1].value) == (
            found[-1].value > found[-2].value
        ):
            found.pop()
        found.append(point)
    return found
