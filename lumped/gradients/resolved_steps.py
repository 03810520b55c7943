"""Steps that are short enough for integrals over a run, and for derivatives by its states.

The steps of a run are chosen for its states. An integrand may be faster, and derivatives may move
while the states rest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lumped.errors import SolverError
from lumped.gradients.legs import Leg, SmoothParts
from lumped.gradients.readings.instant_terms import AdjointPoint
from lumped.gradients.spans import Carried
from lumped.gradients.sweep import Seeds, StepResults, sweep
from lumped.gradients.varied import TIGHTER

_ROUNDS = 40
_MOST = 1_000_000
"""Steps of a run at most."""
_FINEST = 1000
"""Parts into which a step is divided at once."""
_ROUNDING = 1e-11
"""Accuracy of derivatives that rounding allows."""


class Resolved(NamedTuple):
    """Derivatives of results by a sweep over steps that are short enough.

    Attributes
    ----------
    found : list of Carried
        For all orders of changes that coincide.
    errors : ndarray, shape (k,)
        Estimated errors, relative to the terms of which a derivative consists.
    sums, sizes : ndarray, shape (q,)
        Integrals, and those of the sizes.
    """

    found: list[Carried]
    errors: np.ndarray
    sums: np.ndarray
    sizes: np.ndarray


def refine_sweep(course: SmoothParts, seeds: Seeds, points: list[AdjointPoint]) -> Resolved:
    """Sweep back, and divide steps until integrals and derivatives are accurate.

    Raises
    ------
    SolverError
        If that needs too many steps.
    """
    for _ in range(_ROUNDS):
        found, by_step = sweep(course, seeds, points)
        sums, sizes = _totals(course.legs, by_step, seeds)
        each = [course.steps.relative(swept.largest, swept.lost) for swept in found]
        errors: np.ndarray = np.max(each, axis=0)
        if not _divide_steps(course, by_step, sizes, errors):
            return Resolved(found, errors, sums, sizes)
    raise _too_many(course)


def _divide_steps(
    course: SmoothParts, by_step: StepResults, sizes: np.ndarray, errors: np.ndarray
) -> bool:
    """Whether steps were divided, as integrals or derivatives are not accurate.

    Parameters
    ----------
    sizes : ndarray, shape (q,)
        Integrals of the sizes.
    errors : ndarray, shape (k,)
        Errors of the derivatives of the results by all steps.
    """
    legs, rtol = course.legs, max(course.rtol / TIGHTER, _ROUNDING)
    allowed = rtol * sizes
    rough = ~(np.sum([e.sum(axis=0) for e in by_step.part_errors], axis=0) <= allowed)
    over = ~(errors <= rtol)  # also where an adjoint has grown beyond all numbers
    count = sum(len(leg.t) for leg in legs)
    span = course.until - float(legs[0].t[0])
    finer = False
    for leg, each, of_integrals in zip(legs, by_step.errors, by_step.part_errors, strict=True):
        length = np.diff(leg.t)
        implicit = course.run.statistics.is_implicit(leg.t[:-1])
        share = allowed * length[:, None] / span
        parts = np.maximum(
            _parts(of_integrals[:, rough], share[:, rough], implicit),
            _parts(each[:, over], np.full(1, rtol / count), implicit),
        )
        parts[length <= 1e-12 * (1.0 + np.abs(leg.t[1:]))] = 1
        if (parts > 1).any():
            finer = True
            if count + parts.sum() > _MOST:
                raise _too_many(course)
            leg.divide(parts)
    return finer


def _too_many(course: SmoothParts) -> SolverError:
    return SolverError(
        f"{course.run.system.name}: an integral or a derivative needs more than {_MOST} steps at "
        f"rtol = {course.rtol:g}. Loosen rtol, end the run earlier, or take method='implicit' for "
        "a stiff drive that rests.",
        course.run,
    )


def _parts(errors: np.ndarray, allowed: np.ndarray, implicit: np.ndarray) -> np.ndarray:
    """Into how many parts each step is divided, so that its errors are allowed, shape (steps,)."""
    if not errors.size:
        return np.ones(len(errors), dtype=int)
    with np.errstate(divide="ignore", invalid="ignore"):
        over = np.where(errors == 0, 0.0, errors / allowed)
    over = np.nan_to_num(over, nan=1e300, posinf=1e300).max(axis=1)
    # an error of order p in one step is one of order p - 1 in all its parts together
    many: np.ndarray = np.ceil(1.2 * over ** np.where(implicit, 1 / 4, 1 / 6))
    return np.where(over > 1.0, np.clip(many, 2, _FINEST), 1).astype(int)


def _totals(legs: list[Leg], by_step: StepResults, seeds: Seeds) -> tuple[np.ndarray, np.ndarray]:
    """Each integral over its span, and that of its size; spans end where steps do."""
    found, sizes = np.zeros(len(seeds.spans)), np.zeros(len(seeds.spans))
    for leg, parts in zip(legs, by_step.parts, strict=True):
        middle = 0.5 * (leg.t[1:] + leg.t[:-1])[:, None]
        inside = (seeds.spans[:, 0] < middle) & (middle < seeds.spans[:, 1])
        found += (parts * inside).sum(axis=0)
        sizes += np.abs(parts * inside).sum(axis=0)
    return found, sizes
