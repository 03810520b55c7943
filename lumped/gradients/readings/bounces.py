"""Impacts that follow each other ever faster, and the instant at which they accumulate."""

from __future__ import annotations

from collections.abc import Sequence

from lumped.gradients.jumps import Crossing

_FLIGHT = 1e-6
"""Part of a run that a flight must last for its length to be known well."""


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
