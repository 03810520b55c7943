"""Steps of a run that are dealt with at once, over the changes between its smooth parts."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from lumped.gradients.adjoint import Leg
from lumped.gradients.step_code import Span
from lumped.timeloop.result import Trajectory

__all__ = ["Stretch", "stretches"]


@dataclass(frozen=True)
class Stretch:
    """Steps one after the other, and changes between them.

    Attributes
    ----------
    legs : list of (int, int, int)
        Number of each smooth part, and from which to which end of its steps.
    places : list of int
        Where each begins among all ends of steps.
    """

    legs: list[tuple[int, int, int]]
    places: list[int]

    def span(self, run: Trajectory, legs: Sequence[Leg]) -> Span:
        """The steps."""
        return Span.joined([legs[k].span(run, begin, end) for k, begin, end in self.legs])

    def place(self, legs: Sequence[Leg], leg: int, time: float) -> int | None:
        """Where a step of a smooth part ends at a time; None if that is not in here.

        Where a part is cut in two, this end belongs to the later one.
        """
        for (number, begin, end), first in zip(self.legs, self.places, strict=True):
            if number == leg:
                place = int(np.searchsorted(legs[number].t, time))
                is_last = end == len(legs[number].t) - 1
                if begin <= place < end + is_last:
                    return first + place - begin
        return None


def stretches(legs: Sequence[Leg], most: int, apart: Container[int] = ()) -> list[Stretch]:
    """All steps of a run, in the order of time.

    Parameters
    ----------
    most : int
        Steps at once.
    apart : container of int
        Smooth parts before which a new stretch begins.
    """
    found: list[Stretch] = []
    count = 0
    for number, leg in enumerate(legs):
        begin, last = 0, len(leg.t) - 1
        while True:
            if not found or count >= most or begin or number in apart:
                found.append(Stretch([], []))
                count = 0
            end = min(last, begin + most - count)
            found[-1].legs.append((number, begin, end))
            found[-1].places.append(count)
            count += end - begin + 1
            if end == last:
                break
            begin = end
    return found
