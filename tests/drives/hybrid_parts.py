"""Contacts and loads of drives in closed form."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np


class LostError(Exception):
    """The reference finds no way on."""


@dataclass(frozen=True)
class Line:
    """Straight lines of time through points, constant outside; two points at one time jump."""

    ts: Sequence[float]
    ys: Sequence[float]

    def on(self, begin: float, end: float) -> tuple[float, float]:
        """Value at the begin and slope of the line between two times without a kink between."""
        i = int(np.searchsorted(self.ts, (begin + end) / 2))
        if i in (0, len(self.ts)):
            return float(self.ys[min(i, len(self.ys) - 1)]), 0.0
        slope = (self.ys[i] - self.ys[i - 1]) / (self.ts[i] - self.ts[i - 1])
        return float(self.ys[i - 1] + slope * (begin - self.ts[i - 1])), float(slope)


def steady(value: float) -> Line:
    return Line((0.0,), (value,))


@dataclass(frozen=True)
class Contact:
    """What acts on the relative speed ``row @ v`` without being smooth.

    A "friction" slides at ``level + rise |speed|`` and bears `peak` times its level at rest; a
    "freewheel" besides lets no negative speed pass; a "gap" is ``gap + row @ q >= 0`` with
    restitution e; a "dog" is closed while its level is above 0.5.
    """

    name: str
    kind: str
    row: np.ndarray
    level: Line = field(default_factory=lambda: steady(0.0))
    rise: float = 0.0
    peak: float = 1.0
    gap: float = 0.0
    e: float = 0.0


@dataclass(frozen=True)
class Load:
    """Torque ``line(t) + size sin(rate t + phase)`` along ``row @ q``."""

    row: np.ndarray
    line: Line
    size: float = 0.0
    rate: float = 0.0
    phase: float = 0.0
