"""Steps of a run that are dealt with at once, over the changes between its smooth parts."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from lumped.gradients.legs import Leg
from lumped.gradients.spans import Span


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

    @property
    def ends(self) -> int:
        """Ends of steps, both sides of a change counted."""
        _, begin, end = self.legs[-1]
        return self.places[-1] + end - begin + 1

    def add(self, number: int, begin: int, end: int) -> None:
        """Add steps of a smooth part."""
        self.places.append(self.ends if self.legs else 0)
        self.legs.append((number, begin, end))

    def span(self, legs: Sequence[Leg]) -> Span:
        """The steps."""
        return Span.join([legs[k].span(begin, end) for k, begin, end in self.legs])

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


def stretches(legs: Sequence[Leg], apart: Container[int] = ()) -> list[Stretch]:
    """All steps of a run, in the order of time; states of each are kept at once.

    A change is part of the stretch before it, which then ends with no step of the next part.

    Parameters
    ----------
    apart : container of int
        Smooth parts before which a new stretch begins; this change is in none.
    """
    found: list[Stretch] = []
    for number, leg in enumerate(legs):
        for begin, end in leg.chunks() or [(0, 0)]:
            is_apart = not found or (number in apart and not begin)
            if is_apart or begin or (end and found[-1].ends + end > leg.rows):
                if not is_apart and not begin:
                    found[-1].add(number, 0, 0)
                found.append(Stretch([], []))
            found[-1].add(number, begin, end)
    return found
