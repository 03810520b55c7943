"""How a functional hangs on the instants of a run: in one way, or in several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from lumped.gradients.adjoint import AdjointPoint

__all__ = ["Owed", "Way", "multiple", "sum_of"]


@dataclass(frozen=True)
class Way:
    """One way in which a functional can hang on a run.

    Attributes
    ----------
    value : float
        What it is.
    points : tuple of AdjointPoint
        What it owes to single instants.
    by_end : float
        Its derivative by the end of the run.
    """

    value: float
    points: tuple[AdjointPoint, ...] = ()
    by_end: float = 0.0


class Owed(NamedTuple):
    """A functional of a run.

    Attributes
    ----------
    ways : tuple of Way
        The only one, or several: extremes of one height, or a change at the very instant.
    pick : str
        Which of several ways it goes: of the greatest or least derivative; or the second one
        where the change comes later.
    guard : tuple of AdjointPoint
        The instant of the change, if ways differ by it.
    where : str
        In words, where the ways part.
    """

    ways: tuple[Way, ...]
    pick: Literal["", "greatest", "least", "later"] = ""
    guard: tuple[AdjointPoint, ...] = ()
    where: str = ""


def multiple(way: Way, factor: float) -> Way:
    """A multiple of what hangs on a run in a way."""
    points = tuple(
        replace(
            p,
            by_states=factor * p.by_states,
            by_parameters=factor * p.by_parameters,
            late=factor * p.late,
        )
        for p in way.points
    )
    return Way(factor * way.value, points, factor * way.by_end)


def sum_of(ways: Sequence[Way]) -> Way:
    """The sum of what hangs on a run in several ways."""
    points = tuple(point for way in ways for point in way.points)
    return Way(sum(w.value for w in ways), points, sum(w.by_end for w in ways))
