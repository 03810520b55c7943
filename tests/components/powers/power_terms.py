"""What energies and powers are written with: the motion of a part as plain numbers."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Motion:
    """What a part is given, and its motion, as plain numbers.

    Parameters; positions, velocities and accelerations by port, where the potential of a pin counts
    as a velocity; states inside the part and their derivatives; powers of what sticks or slides;
    torques, forces and other flows by port.
    """

    p: dict[str, float]
    q: dict[str, complex]
    v: dict[str, complex]
    a: dict[str, float]
    x: dict[str, complex]
    rates: dict[str, float]
    held: tuple[float, ...] = ()
    flow: dict[str, float] = field(default_factory=dict)

    def rel(self, by: dict[str, complex]) -> complex:
        return by["flange_b"] - by["flange_a"]


Energy = Callable[[Motion], complex]
Power = Callable[[Motion], float]


def turning(at: Motion) -> complex:
    return at.v["flange"] - at.v["support"]


def bounded(speed: float, limit: float) -> float:
    return np.clip(speed / limit, -1, 1)
