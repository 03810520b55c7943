"""How a functional depends on the instants of a run: one derivative, or alternatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from lumped.gradients.jumps import Crossing, EventDerivatives

_FLIGHT = 1e-6
"""Part of a run that a flight must last for its length to be known well."""


@dataclass(frozen=True)
class AdjointPoint:
    """Derivatives of a result through one instant of a run.

    Attributes
    ----------
    leg : int
        Number of the smooth part.
    time : float
        Where in it, s.
    column : int
        Number of the result.
    by_states, by_parameters : ndarray, shapes (n,) and (p,)
        Derivatives of the result at that instant.
    edge : int
        Number of the leg with whose begin the instant moves; 0 if it does not move.
    late : float
        Derivative of the result by that begin.
    name : str
        Component whose change this is about, if others may change at the same instant.
    """

    leg: int
    time: float
    column: int
    by_states: np.ndarray
    by_parameters: np.ndarray
    edge: int = 0
    late: float = 0.0
    name: str = ""

    def find_jump(self, order: Sequence[EventDerivatives]) -> int:
        """Which of the jumps at the begin of the leg of the edge the instant moves with."""
        if self.name:
            return next((i for i, jump in enumerate(order) if self.name in jump.names), 0)
        return len(order) - 1 if self.leg == self.edge else 0


@dataclass(frozen=True)
class InstantTerms:
    """A value, and the terms of its derivative at single instants of a run.

    Attributes
    ----------
    value : float
        What it is.
    points : tuple of AdjointPoint
        Its derivatives through single instants.
    by_end : float
        Its derivative by the end of the run.
    """

    value: float
    points: tuple[AdjointPoint, ...] = ()
    by_end: float = 0.0


class ReadingTerms(NamedTuple):
    """A functional of a run.

    Attributes
    ----------
    alternatives : tuple of InstantTerms
        The only one, or several: extremes of one height, or a change at the very instant.
    pick : str
        Which of several holds: that of the greatest or least derivative; or the second one
        where the change comes later.
    guard : tuple of AdjointPoint
        The instant of the change, if alternatives differ by it.
    where : str
        In words, where the alternatives differ.
    """

    alternatives: tuple[InstantTerms, ...]
    pick: Literal["", "greatest", "least", "later"] = ""
    guard: tuple[AdjointPoint, ...] = ()
    where: str = ""


def scale_terms(terms: InstantTerms, factor: float) -> InstantTerms:
    """A multiple of a value and its terms."""
    points = tuple(
        replace(
            p,
            by_states=factor * p.by_states,
            by_parameters=factor * p.by_parameters,
            late=factor * p.late,
        )
        for p in terms.points
    )
    return InstantTerms(factor * terms.value, points, factor * terms.by_end)


def add_terms(parts: Sequence[InstantTerms]) -> InstantTerms:
    """The sum of several values and their terms."""
    points = tuple(point for terms in parts for point in terms.points)
    return InstantTerms(sum(p.value for p in parts), points, sum(p.by_end for p in parts))


def find_last_bounces(crossings: Sequence[Crossing], component: str, until: float) -> list[int]:
    """Legs that begin at the last three impacts whose flights are resolved in a run.

    Parameters
    ----------
    crossings : sequence of Crossing
        All before the component rests.
    component : str
        What bounces.
    until : float
        End of the run, s.
    """
    found, times = [], []
    for k, crossing in enumerate(crossings, 1):
        for jump in (j for order in crossing.orders[:1] for j in order):
            blow = jump.act[1]
            if component in jump.names and blow is not None and any(b for _, b in blow.hits):
                found.append(k)
                times.append(crossing.t)
    while len(found) > 3 and times[-1] - times[-2] < _FLIGHT * until:
        found.pop()
        times.pop()
    return found[-3:]


def find_limit_of_flights(times: Sequence[float]) -> tuple[float, list[float]]:
    """Limit of a geometric series of flights between three impacts, and its derivatives.

    A run leaves out the bounces that are too small for it.
    """
    weights = [
        _limit(*(t + 1e-30j * (i == k) for i, t in enumerate(times))).imag / 1e-30 for k in range(3)
    ]
    return float(_limit(*times).real), weights


def _limit(a: complex, b: complex, c: complex) -> complex:
    """Limit of a geometric series from three of its sums (Aitken)."""
    return c + (c - b) ** 2 / ((b - a) - (c - b))
