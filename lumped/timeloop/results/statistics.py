"""What makes the steps of a run, and what the run cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

_WORDS = {
    "none": "nothing was computed",
    "exact": "closed form, as the model is linear between jumps",
    "explicit": "DOP853",
    "implicit": "Rodas5P",
    "taylor": "Taylor's series",
    "explicit then implicit": "DOP853 until its steps were limited by stability, then Rodas5P",
    "taylor then implicit": "series until their steps were limited by stability, then Rodas5P",
    "explicit then taylor": "DOP853, then Taylor's series, which are worth compiling in a long run",
    "explicit then taylor then implicit": "DOP853, then Taylor's series, as the run was long, "
    "until their steps were limited by stability, then Rodas5P",
    "explicit and implicit": "DOP853, and Rodas5P where its steps were limited by stability",
    "taylor and implicit": "series, and Rodas5P where their steps were limited by stability",
    "explicit and implicit and taylor": "DOP853, in the end Taylor's series, as the run was long, "
    "and Rodas5P where their steps were limited by stability",
    "explicit and taylor and implicit": "DOP853, later Taylor's series, as the run was long, "
    "and Rodas5P where their steps were limited by stability",
}


class Used(NamedTuple):
    """What makes the steps of a run from some time on.

    Attributes
    ----------
    begin : float
        The time, s.
    method : str
        "exact", "explicit", "taylor" or "implicit".
    """

    begin: float
    method: str


@dataclass(frozen=True)
class Statistics:
    """What a run cost.

    Attributes
    ----------
    methods : tuple of Used
        Methods used, one after the other.
    steps, rejected, evaluations, segments : int
        Accepted and rejected steps, evaluations of the right-hand side, restarts + 1.
    seconds : float
        Wall time of the stepping.
    small : tuple of str
        States that moved, but stayed so small that the absolute tolerance governs them.
    """

    methods: tuple[Used, ...]
    steps: int
    rejected: int
    evaluations: int
    segments: int
    seconds: float
    small: tuple[str, ...]

    @property
    def method(self) -> str:
        """Methods used, in the order of their first steps.

        "then" joins them if each was used once, "and" if one came back.
        """
        names = [used.method for used in self.methods]
        different = dict.fromkeys(names)
        return (" then " if len(different) == len(names) else " and ").join(different) or "none"

    @property
    def why(self) -> str:
        """The method in words."""
        return _WORDS[self.method]

    def is_implicit(self, t: np.ndarray) -> np.ndarray:
        """Whether implicit steps begin at these times, if any do."""
        begins, names = zip(*self.methods, strict=True)
        implicit = np.array([name == "implicit" for name in names])
        if len(begins) == 1:
            return implicit.repeat(len(t))
        return implicit[np.maximum(np.searchsorted(begins, t, "right") - 1, 0)]
